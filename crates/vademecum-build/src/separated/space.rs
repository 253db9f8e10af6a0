//! Operators in space: what a [`KroneckerProblem`](super::KroneckerProblem) and a sampled problem ask of a
//! body.
//!
//! Space is reached through [`Space`] only, so the same code runs on small dense matrices and on a sparse
//! factorisation of the whole mesh.

use super::error::{SeparatedError, check_len};
use super::linalg::{Cholesky, axpy, product};
use faer::{Mat, MatRef};

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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::separated::surrogate::Pencil;

    #[test]
    fn a_weighted_sum_is_solved_or_refused() {
        let pencil = Pencil::lattice(3, 3, 4, 2, 3);
        let matrices = std::iter::once(pencil.mass).chain(pencil.stiffness).collect();
        let space = DenseSpace::new(matrices).unwrap();
        for weights in [[1.0, 2.0, 3.0], [1.0, 0.1, 5.0]] {
            let x = space.solve(&weights, pencil.modes.as_ref()).unwrap();
            let mut residual = pencil.modes.clone();
            for (t, w) in weights.into_iter().enumerate() {
                axpy(residual.as_mut(), -w, space.apply(t, x.as_ref()).as_ref());
            }
            assert!(residual.norm_max() < 1e-13 * pencil.modes.norm_max(), "condition below 100");
        }
        let indefinite = space.solve(&[1.0, -90.0, -90.0], pencil.modes.as_ref());
        assert!(matches!(indefinite, Err(SeparatedError::NotPositiveDefinite { .. })));
        let sizes = vec![Mat::identity(3, 3), Mat::identity(4, 4)];
        assert!(matches!(DenseSpace::new(sizes), Err(SeparatedError::Shape { expected: 3, found: 4, .. })));
    }
}
