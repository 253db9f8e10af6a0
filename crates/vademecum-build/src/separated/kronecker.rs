//! A sum of Kronecker operators: `Σ_t (⊗_a A_ta) ⊗ S_t u = Σ_s (⊗_a f_sa) ⊗ B_s`.
//!
//! `A_ta` acts on axis `a` and couples at most neighbouring points; `S_t` acts on space.

use super::axis::Axis;
use super::error::{SeparatedError, check_len};
use super::operator::AxisOperator;
use super::solution::Separated;
use super::space::Space;
use faer::Mat;

/// One separable right-hand side, `(⊗_a f_a) ⊗ B`.
#[derive(Clone, Debug)]
pub struct Source {
    /// Load vector on each axis, tested against the axis' basis (for a function `f`: Gram matrix times its
    /// values).
    pub vectors: Vec<Vec<f64>>,
    /// Load in space: `(n_rows, n_columns)`.
    pub block: Mat<f64>,
}

/// A separated problem. `operators[t][a]` goes with space operator `t`.
pub struct KroneckerProblem<S> {
    pub(super) axes: Vec<Axis>,
    pub(super) operators: Vec<Vec<AxisOperator>>,
    pub(super) space: S,
    pub(super) sources: Vec<Source>,
    pub(super) n_columns: usize,
}

impl<S: Space> KroneckerProblem<S> {
    /// Checks that everything fits together.
    ///
    /// # Errors
    /// [`SeparatedError::Shape`].
    pub fn new(
        axes: Vec<Axis>,
        operators: Vec<Vec<AxisOperator>>,
        space: S,
        sources: Vec<Source>,
    ) -> Result<KroneckerProblem<S>, SeparatedError> {
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
        Ok(KroneckerProblem { axes, operators, space, sources, n_columns })
    }

    /// `S_t F_i` of all terms, `(n_rows · n_columns, n_terms)`.
    pub(super) fn apply_to_blocks(&self, t: usize, u: &Separated) -> Mat<f64> {
        let (n, c) = (u.n_rows(), u.n_columns());
        let wide = Mat::from_fn(n, c * u.n_terms(), |i, j| u.blocks()[(i + (j % c) * n, j / c)]);
        let applied = self.space.apply(t, wide.as_ref());
        Mat::from_fn(n * c, u.n_terms(), |j, i| applied[(j % n, i * c + j / n)])
    }
}
