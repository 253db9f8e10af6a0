//! A separated problem: `Σ_t (⊗_a A_ta) ⊗ S_t u = Σ_s (⊗_a f_sa) ⊗ B_s`.
//!
//! `A_ta` acts on axis `a` and couples at most neighbouring points; `S_t` acts on space. Space is reached through
//! [`Space`] only, so the same engine runs on small dense matrices and on a sparse factorisation of the whole mesh.

use super::axis::Axis;
use super::error::{SeparatedError, check_len};
use super::linalg::{Cholesky, axpy, dot, product};
use faer::linalg::solvers::Solve;
use faer::sparse::SparseColMat;
use faer::sparse::linalg::solvers::{Llt, SymbolicLlt};
use faer::{Mat, MatRef, Side};
use std::sync::Mutex;

/// A symmetric operator on one axis: diagonal, or tridiagonal as hat functions make them.
#[derive(Clone, Debug, PartialEq)]
pub struct AxisOperator {
    lower: Vec<f64>,
    diagonal: Vec<f64>,
    upper: Vec<f64>,
}

impl AxisOperator {
    /// `diag(d)`.
    pub fn diagonal(diagonal: Vec<f64>) -> AxisOperator {
        AxisOperator { lower: Vec::new(), diagonal, upper: Vec::new() }
    }

    /// With `lower[j]` at `(j+1, j)` and `upper[j]` at `(j, j+1)`, each one shorter than the diagonal.
    pub fn tridiagonal(lower: Vec<f64>, diagonal: Vec<f64>, upper: Vec<f64>) -> AxisOperator {
        assert!(
            lower.len() + 1 == diagonal.len() && upper.len() + 1 == diagonal.len(),
            "lengths of the diagonals"
        );
        AxisOperator { lower, diagonal, upper }
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.diagonal.len()
    }

    /// Whether it acts on no points.
    pub fn is_empty(&self) -> bool {
        self.diagonal.is_empty()
    }

    /// `(lower, diagonal, upper)`; the outer two are empty for a diagonal operator.
    pub(crate) fn parts(&self) -> (&[f64], &[f64], &[f64]) {
        (&self.lower, &self.diagonal, &self.upper)
    }

    /// `A g`.
    pub fn apply(&self, g: &[f64]) -> Vec<f64> {
        let mut out: Vec<f64> = self.diagonal.iter().zip(g).map(|(d, x)| d * x).collect();
        for (j, (l, u)) in self.lower.iter().zip(&self.upper).enumerate() {
            out[j + 1] += l * g[j];
            out[j] += u * g[j + 1];
        }
        out
    }

    /// `A G`, column by column.
    pub fn apply_all(&self, g: MatRef<'_, f64>) -> Mat<f64> {
        let mut out = Mat::zeros(g.nrows(), g.ncols());
        for i in 0..g.ncols() {
            let column: Vec<f64> = (0..g.nrows()).map(|j| g[(j, i)]).collect();
            self.apply(&column).into_iter().enumerate().for_each(|(j, v)| out[(j, i)] = v);
        }
        out
    }

    /// `gᵀ A h`.
    pub fn bilinear(&self, g: &[f64], h: &[f64]) -> f64 {
        dot(g, &self.apply(h))
    }

    /// `A ← A + w B`.
    pub(crate) fn add(&mut self, w: f64, other: &AxisOperator) {
        if self.lower.is_empty() && !other.lower.is_empty() {
            self.lower = vec![0.0; other.lower.len()];
            self.upper = self.lower.clone();
        }
        let add = |to: &mut [f64], from: &[f64]| to.iter_mut().zip(from).for_each(|(t, f)| *t += w * f);
        add(&mut self.diagonal, &other.diagonal);
        add(&mut self.lower, &other.lower);
        add(&mut self.upper, &other.upper);
    }

    /// `A⁻¹ r` by elimination without pivoting, which positive definite operators do not need.
    pub(crate) fn solve(&self, mut r: Vec<f64>) -> Vec<f64> {
        let n = r.len();
        let mut pivot = self.diagonal.clone();
        if !self.lower.is_empty() {
            for j in 1..n {
                let l = self.lower[j - 1] / pivot[j - 1];
                pivot[j] -= l * self.upper[j - 1];
                r[j] -= l * r[j - 1];
            }
            r[n - 1] /= pivot[n - 1];
            for j in (0..n - 1).rev() {
                r[j] = (r[j] - self.upper[j] * r[j + 1]) / pivot[j];
            }
            return r;
        }
        r.iter_mut().zip(&pivot).for_each(|(r, p)| *r /= p);
        r
    }
}

/// The space operators `S_t` of a problem, symmetric, their weighted sums positive definite.
pub trait Space: Sync {
    /// Rows of a block.
    fn n_rows(&self) -> usize;
    /// Number of operators.
    fn n_operators(&self) -> usize;
    /// `S_t X` for a block `X` of shape `(n_rows, n_columns)`.
    fn apply(&self, t: usize, block: MatRef<'_, f64>) -> Mat<f64>;
    /// `(Σ_t weights_t S_t)⁻¹ rhs`, `rhs` of shape `(n_rows, n_columns)`.
    ///
    /// # Errors
    /// [`SeparatedError::NotPositiveDefinite`].
    fn solve(&self, weights: &[f64], rhs: MatRef<'_, f64>) -> Result<Mat<f64>, SeparatedError>;
}

/// Small dense space operators, `(n_rows, n_rows)` each.
#[derive(Clone, Debug)]
pub struct DenseSpace {
    matrices: Vec<Mat<f64>>,
}

impl DenseSpace {
    /// From symmetric matrices of one size.
    ///
    /// # Errors
    /// [`SeparatedError::Shape`].
    pub fn new(matrices: Vec<Mat<f64>>) -> Result<DenseSpace, SeparatedError> {
        let n = matrices.first().map_or(0, |m| m.nrows());
        for m in &matrices {
            check_len("rows of a space matrix", n, m.nrows())?;
            check_len("columns of a space matrix", n, m.ncols())?;
        }
        Ok(DenseSpace { matrices })
    }
}

impl Space for DenseSpace {
    fn n_rows(&self) -> usize {
        self.matrices.first().map_or(0, |m| m.nrows())
    }

    fn n_operators(&self) -> usize {
        self.matrices.len()
    }

    fn apply(&self, t: usize, block: MatRef<'_, f64>) -> Mat<f64> {
        product(self.matrices[t].as_ref(), block)
    }

    fn solve(&self, weights: &[f64], rhs: MatRef<'_, f64>) -> Result<Mat<f64>, SeparatedError> {
        let mut sum = Mat::zeros(self.n_rows(), self.n_rows());
        for (w, m) in weights.iter().zip(&self.matrices) {
            axpy(sum.as_mut(), *w, m.as_ref());
        }
        let factor = Cholesky::new(sum)
            .ok_or(SeparatedError::NotPositiveDefinite { what: "weighted space operator" })?;
        let mut x = rhs.to_owned();
        factor.solve_in_place(x.as_mut());
        Ok(x)
    }
}

/// Ratio of the weights, and the factor it gave.
type Factorised = (Vec<f64>, Llt<usize, f64>);

/// Sparse space operators of one pattern: analysed once, factorised when the *ratio* of the weights changes: once,
/// with one operator. Bits do not depend on which solve came before, so only exactly equal ratios share a factor.
pub struct SparseSpace {
    matrices: Vec<SparseColMat<usize, f64>>,
    symbolic: SymbolicLlt<usize>,
    latest: Mutex<Option<Factorised>>,
}

impl SparseSpace {
    /// From symmetric matrices stored in full with identical sparsity patterns; analyses the pattern.
    ///
    /// # Errors
    /// [`SeparatedError::Shape`] when the sizes or patterns differ or there is no matrix.
    pub fn new(matrices: Vec<SparseColMat<usize, f64>>) -> Result<SparseSpace, SeparatedError> {
        let Some(first) = matrices.first() else {
            return Err(SeparatedError::Shape { what: "space matrices", expected: 1, found: 0 });
        };
        for m in &matrices {
            check_len("rows of a space matrix", first.nrows(), m.nrows())?;
            let (own, other) = (m.symbolic(), first.symbolic());
            let same = own.row_idx() == other.row_idx() && own.col_ptr() == other.col_ptr();
            check_len(
                "entries of a space matrix (or their pattern)",
                first.compute_nnz(),
                if same { m.compute_nnz() } else { 0 },
            )?;
        }
        let symbolic = SymbolicLlt::try_new(first.symbolic(), Side::Lower)
            .map_err(|_| SeparatedError::NoConvergence { what: "symbolic factorisation" })?;
        Ok(SparseSpace { matrices, symbolic, latest: Mutex::new(None) })
    }

    fn factorize(&self, weights: &[f64]) -> Result<Llt<usize, f64>, SeparatedError> {
        let mut sum = self.matrices[0].clone();
        sum.val_mut().fill(0.0);
        for (w, m) in weights.iter().zip(&self.matrices) {
            sum.val_mut().iter_mut().zip(m.val()).for_each(|(s, v)| *s += w * v);
        }
        Llt::try_new_with_symbolic(self.symbolic.clone(), sum.as_ref(), Side::Lower)
            .map_err(|_| SeparatedError::NotPositiveDefinite { what: "weighted space operator" })
    }
}

impl Space for SparseSpace {
    fn n_rows(&self) -> usize {
        self.matrices[0].nrows()
    }

    fn n_operators(&self) -> usize {
        self.matrices.len()
    }

    fn apply(&self, t: usize, block: MatRef<'_, f64>) -> Mat<f64> {
        let m = &self.matrices[t];
        let mut out = Mat::zeros(m.nrows(), block.ncols());
        for c in 0..block.ncols() {
            for j in 0..m.ncols() {
                let x = block[(j, c)];
                for (i, v) in m.row_idx_of_col(j).zip(m.val_of_col(j)) {
                    out[(i, c)] += v * x;
                }
            }
        }
        out
    }

    fn solve(&self, weights: &[f64], rhs: MatRef<'_, f64>) -> Result<Mat<f64>, SeparatedError> {
        let scale = weights.iter().fold(0.0f64, |m, w| m.max(w.abs()));
        let ratio: Vec<f64> = weights.iter().map(|w| w / scale).collect();
        let mut latest = self.latest.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        if latest.as_ref().is_none_or(|(r, _)| *r != ratio) {
            *latest = Some((ratio.clone(), self.factorize(&ratio)?));
        }
        let (_, factor) =
            latest.as_ref().ok_or(SeparatedError::NotPositiveDefinite { what: "space operator" })?;
        let x = factor.solve(rhs);
        Ok(Mat::from_fn(x.nrows(), x.ncols(), |i, j| x[(i, j)] / scale))
    }
}

/// One separable right-hand side, `(⊗_a f_a) ⊗ B`.
#[derive(Clone, Debug)]
pub struct Source {
    /// Load vector on each axis, tested against the axis' basis (for a function `f`: Gram matrix times its values).
    pub vectors: Vec<Vec<f64>>,
    /// Load in space: `(n_rows, n_columns)`.
    pub block: Mat<f64>,
}

/// A separated problem. `operators[t][a]` goes with space operator `t`.
pub struct Problem<S> {
    pub(crate) axes: Vec<Axis>,
    pub(crate) operators: Vec<Vec<AxisOperator>>,
    pub(crate) space: S,
    pub(crate) sources: Vec<Source>,
    pub(crate) n_columns: usize,
}

impl<S: Space> Problem<S> {
    /// Checks that everything fits together.
    ///
    /// # Errors
    /// [`SeparatedError::Shape`].
    pub fn new(
        axes: Vec<Axis>,
        operators: Vec<Vec<AxisOperator>>,
        space: S,
        sources: Vec<Source>,
    ) -> Result<Problem<S>, SeparatedError> {
        check_len("operators, one list per space operator", space.n_operators(), operators.len())?;
        for list in &operators {
            check_len("operators, one per axis", axes.len(), list.len())?;
            axes.iter()
                .zip(list)
                .try_for_each(|(a, o)| check_len("points of an axis operator", a.len(), o.len()))?;
        }
        let n_columns = sources.first().map_or(1, |s| s.block.ncols());
        for source in &sources {
            check_len("vectors of a source, one per axis", axes.len(), source.vectors.len())?;
            axes.iter()
                .zip(&source.vectors)
                .try_for_each(|(a, v)| check_len("source on an axis", a.len(), v.len()))?;
            check_len("rows of a source block", space.n_rows(), source.block.nrows())?;
            check_len("columns of a source block", n_columns, source.block.ncols())?;
        }
        Ok(Problem { axes, operators, space, sources, n_columns })
    }

    /// The parameter axes.
    pub fn axes(&self) -> &[Axis] {
        &self.axes
    }
}
