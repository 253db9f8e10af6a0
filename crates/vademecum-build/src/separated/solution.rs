//! The sum of terms `u(μ) = Σ_i (Π_a g_ia(μ_a)) F_i`, whatever made it.

use super::axis::Axis;
use super::error::{SeparatedError, check_len};
use super::linalg::{column, dot, norm, product};
use faer::{Mat, MatRef};

/// A separated solution over parameter axes, with blocks of `n_columns` columns over space.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub struct Separated {
    axes: Vec<Axis>,
    #[serde(with = "crate::linalg::stored::list")]
    factors: Vec<Mat<f64>>,
    #[serde(with = "crate::linalg::stored")]
    blocks: Mat<f64>,
    n_rows: usize,
}

impl Separated {
    /// The solution without terms: zero everywhere.
    pub fn zero(axes: &[Axis], n_rows: usize, n_columns: usize) -> Separated {
        let factors = axes.iter().map(|a| Mat::zeros(a.len(), 0)).collect();
        Separated { axes: axes.to_vec(), factors, blocks: Mat::zeros(n_rows * n_columns, 0), n_rows }
    }

    /// From its parts: `factors[a]` is `(axes[a].len(), n_terms)`; `blocks` is
    /// `(n_rows · n_columns, n_terms)`, each column one block in column-major order.
    ///
    /// # Errors
    /// [`SeparatedError::Shape`].
    pub fn new(
        axes: Vec<Axis>,
        factors: Vec<Mat<f64>>,
        blocks: Mat<f64>,
        n_rows: usize,
    ) -> Result<Separated, SeparatedError> {
        check_len("factors, one matrix per axis", axes.len(), factors.len())?;
        for (axis, g) in axes.iter().zip(&factors) {
            check_len("rows of a factor matrix", axis.len(), g.nrows())?;
            check_len("terms of a factor matrix", blocks.ncols(), g.ncols())?;
        }
        check_len("rows of the blocks, modulo rows of space", 0, blocks.nrows() % n_rows.max(1))?;
        Ok(Separated { axes, factors, blocks, n_rows })
    }

    /// The parameter axes, in the order of a point's coordinates.
    pub fn axes(&self) -> &[Axis] {
        &self.axes
    }

    /// Factors on axis `a`: `(axes[a].len(), n_terms)`.
    pub fn factors(&self, a: usize) -> MatRef<'_, f64> {
        self.factors[a].as_ref()
    }

    /// All blocks: `(n_rows · n_columns, n_terms)`, each column one block in column-major order.
    pub fn blocks(&self) -> MatRef<'_, f64> {
        self.blocks.as_ref()
    }

    /// Block of term `i`: `(n_rows, n_columns)`.
    pub fn block(&self, i: usize) -> MatRef<'_, f64> {
        MatRef::from_column_major_slice(column(&self.blocks, i), self.n_rows, self.n_columns())
    }

    /// Number of terms, the rank of the sum.
    pub fn n_terms(&self) -> usize {
        self.blocks.ncols()
    }

    /// Rows of a block.
    pub fn n_rows(&self) -> usize {
        self.n_rows
    }

    /// Columns of a block.
    pub(crate) fn n_columns(&self) -> usize {
        self.blocks.nrows() / self.n_rows.max(1)
    }

    /// `Π_a g_ia(μ_a)` of every term at `point`, one coordinate per axis.
    ///
    /// # Errors
    /// [`SeparatedError::OutsideAxis`], [`SeparatedError::NotAPosition`], [`SeparatedError::Shape`].
    pub fn weights(&self, point: &[f64]) -> Result<Vec<f64>, SeparatedError> {
        check_len("coordinates of a point", self.axes.len(), point.len())?;
        let mut weights = vec![1.0; self.n_terms()];
        for ((axis, g), &x) in self.axes.iter().zip(&self.factors).zip(point) {
            let mut basis = vec![0.0; axis.len()];
            axis.basis_into(x, &mut basis)?;
            weights.iter_mut().enumerate().for_each(|(i, w)| *w *= dot(column(g, i), &basis));
        }
        Ok(weights)
    }

    /// The field at `point`: `(n_rows, n_columns)`. Costs one pass over the blocks; no system is solved.
    ///
    /// # Errors
    /// As [`Separated::weights`].
    pub fn evaluate(&self, point: &[f64]) -> Result<Mat<f64>, SeparatedError> {
        let weights = self.weights(point)?;
        let w = MatRef::from_column_major_slice(&weights, weights.len(), 1);
        let sum = product(self.blocks.as_ref(), w);
        Ok(Mat::from_fn(self.n_rows, self.n_columns(), |i, j| sum[(i + j * self.n_rows, 0)]))
    }

    /// The first `terms` terms, all when there are fewer.
    pub fn truncated(&self, terms: usize) -> Separated {
        let first = |m: &Mat<f64>| m.as_ref().subcols(0, terms.min(m.ncols())).to_owned();
        let factors = self.factors.iter().map(first).collect();
        Separated { axes: self.axes.clone(), factors, blocks: first(&self.blocks), n_rows: self.n_rows }
    }

    /// All terms of `self`, then all of `other`, over the same axes.
    ///
    /// # Errors
    /// [`SeparatedError::Shape`].
    pub fn concatenate(&self, other: &Separated) -> Result<Separated, SeparatedError> {
        check_len("rows of the blocks", self.blocks.nrows(), other.blocks.nrows())?;
        check_len("axes", self.axes.len(), other.axes.len())?;
        let join = |a: &Mat<f64>, b: &Mat<f64>| {
            Mat::from_fn(a.nrows(), a.ncols() + b.ncols(), |i, j| {
                if j < a.ncols() { a[(i, j)] } else { b[(i, j - a.ncols())] }
            })
        };
        let factors = self.factors.iter().zip(&other.factors).map(|(a, b)| join(a, b)).collect();
        Separated::new(self.axes.clone(), factors, join(&self.blocks, &other.blocks), self.n_rows)
    }

    /// The same sum in one form of the many it has: factors of unit Gram norm whose largest entry is
    /// positive, the size of a term in its block, terms by descending size (ties keep their order). Terms of
    /// size zero are dropped.
    pub fn normalised(&self) -> Separated {
        let (mut factors, mut blocks) = (self.factors.clone(), self.blocks.clone());
        for (axis, g) in self.axes.iter().zip(&mut factors) {
            let mass = axis.gram();
            for i in 0..g.ncols() {
                let scale = signed_norm(&mass.apply(column(g, i)), column(g, i));
                let inverse = if scale == 0.0 { 0.0 } else { scale.recip() };
                (0..g.nrows()).for_each(|j| g[(j, i)] *= inverse);
                (0..blocks.nrows()).for_each(|j| blocks[(j, i)] *= scale);
            }
        }
        let size: Vec<f64> = (0..blocks.ncols()).map(|i| norm(blocks.as_ref().subcols(i, 1))).collect();
        let mut order: Vec<usize> = (0..size.len()).filter(|&i| size[i] > 0.0).collect();
        order.sort_by(|&i, &j| size[j].total_cmp(&size[i]));
        let pick = |m: &Mat<f64>| Mat::from_fn(m.nrows(), order.len(), |i, j| m[(i, order[j])]);
        let factors = factors.iter().map(pick).collect();
        Separated { axes: self.axes.clone(), factors, blocks: pick(&blocks), n_rows: self.n_rows }
    }
}

/// Gram norm of a factor, with the sign of its largest entry.
fn signed_norm(mass_times: &[f64], factor: &[f64]) -> f64 {
    let largest = factor.iter().fold(0.0f64, |m, &v| if v.abs() > m.abs() { v } else { m });
    dot(mass_times, factor).max(0.0).sqrt().copysign(largest)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::separated::AxisKind;

    /// sin(x + y) = sin x cos y + cos x sin y on Chebyshev points fine enough to be exact to rounding.
    fn sine_of_sum() -> Separated {
        let kind = AxisKind::Chebyshev { points: 20 };
        let axes: Vec<Axis> =
            ["x", "y"].iter().map(|n| Axis::new(n, "1", 0.0, 2.0, kind, false).unwrap()).collect();
        let pair = |f: fn(f64) -> f64, g: fn(f64) -> f64, axis: &Axis| {
            Mat::from_fn(20, 2, |j, i| if i == 0 { f(axis.nodes()[j]) } else { g(axis.nodes()[j]) })
        };
        let factors = vec![pair(f64::sin, f64::cos, &axes[0]), pair(f64::cos, f64::sin, &axes[1])];
        Separated::new(axes, factors, Mat::from_fn(1, 2, |_, _| 1.0), 1).unwrap()
    }

    #[test]
    fn evaluates_the_sine_of_a_sum() {
        let u = sine_of_sum();
        for k in 0..20 {
            let (x, y) = (0.1 * k as f64, 2.0 - 0.07 * k as f64);
            // 20 points on a length of 2 interpolate sine to rounding (next coefficient 1/20!)
            assert!((u.evaluate(&[x, y]).unwrap()[(0, 0)] - (x + y).sin()).abs() < 1e-13);
        }
        assert!(matches!(u.evaluate(&[1.0, 2.1]), Err(SeparatedError::OutsideAxis { .. })));
        assert!(matches!(u.evaluate(&[1.0]), Err(SeparatedError::Shape { .. })));
    }

    #[test]
    fn the_normalised_sum_is_the_same_function() {
        let u = sine_of_sum();
        let v = u.normalised();
        let at = |w: &Separated| w.evaluate(&[0.3, 1.1]).unwrap()[(0, 0)];
        let gap = at(&u) - at(&v);
        assert!(gap.abs() < 1e-14, "four products of numbers below 1, rounded: {gap}");
        for a in 0..2 {
            for i in 0..2 {
                let g = column(&v.factors[a], i);
                assert!((dot(&v.axes[a].gram().apply(g), g) - 1.0).abs() < 1e-14);
            }
        }
        assert!(norm(v.blocks().subcols(0, 1)) >= norm(v.blocks().subcols(1, 1)));
    }
}
