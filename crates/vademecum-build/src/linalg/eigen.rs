//! Eigenvalues of dense matrices and dense systems, compiled once for all crates of the offline side.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::evd::{ComputeEigenvectors, self_adjoint_evd, self_adjoint_evd_scratch};
use faer::linalg::solvers::Solve;
use faer::{Mat, MatRef, Par, Spec, c64};

use super::NoConvergence;

/// The decomposition named in errors.
const EIGENVALUES: &str = "the eigenvalues of a symmetric matrix";

/// Eigenvalues, ascending, and orthonormal eigenvectors of a symmetric matrix; one thread.
///
/// The matrix is scaled to unit size first: faer's routine returns wrong results for small norms from n ≈ 130
/// on.
///
/// # Errors
/// [`NoConvergence`]: an entry that is not a finite number.
pub fn symmetric_eigen(matrix: MatRef<'_, f64>) -> Result<(Vec<f64>, Mat<f64>), NoConvergence> {
    let n = matrix.nrows();
    if n == 0 {
        return Ok((Vec::new(), Mat::new()));
    }
    let size = matrix.norm_max();
    // The largest of numbers and NaNs may be a number.
    let finite = (0..n).all(|j| (0..n).all(|i| matrix[(i, j)].is_finite()));
    if !finite {
        return Err(NoConvergence { what: EIGENVALUES });
    }
    let scale = if size > 0.0 { size } else { 1.0 };
    let scaled = Mat::from_fn(n, n, |i, j| matrix[(i, j)] / scale);
    let mut values = faer::Col::<f64>::zeros(n);
    let mut vectors = Mat::zeros(n, n);
    let request = self_adjoint_evd_scratch::<f64>(n, ComputeEigenvectors::Yes, Par::Seq, Spec::default());
    let mut memory = MemBuffer::new(request);
    self_adjoint_evd(
        scaled.as_ref(),
        values.as_mut().as_diagonal_mut(),
        Some(vectors.as_mut()),
        Par::Seq,
        MemStack::new(&mut memory),
        Spec::default(),
    )
    .map_err(|_| NoConvergence { what: EIGENVALUES })?;
    Ok(((0..n).map(|i| scale * values[i]).collect(), vectors))
}

/// Eigenvalues of a square matrix, in no order.
///
/// # Errors
/// [`NoConvergence`]: an entry that is not a finite number.
pub fn eigenvalues(matrix: MatRef<'_, f64>) -> Result<Vec<c64>, NoConvergence> {
    matrix.eigenvalues().map_err(|_| NoConvergence { what: "the eigenvalues of a matrix" })
}

/// Solution of a square dense system, by elimination with row pivots; not finite of a singular matrix.
pub fn solve_dense(matrix: MatRef<'_, f64>, right: MatRef<'_, f64>) -> Mat<f64> {
    matrix.partial_piv_lu().solve(right)
}
