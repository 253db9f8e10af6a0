//! Small dense kernels, sequential on purpose: their rounding must not depend on the number of threads.

use super::error::SeparatedError;
pub use crate::linalg::sequential_product as product;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt;
use faer::linalg::{matmul::matmul, svd};
use faer::{Accum, Mat, MatMut, MatRef, Par};

/// `Aᵀ B`.
pub fn transposed_product(a: MatRef<'_, f64>, b: MatRef<'_, f64>) -> Mat<f64> {
    product(a.transpose(), b)
}

/// `C ← C + α A B`.
pub(crate) fn add_product(c: MatMut<'_, f64>, alpha: f64, a: MatRef<'_, f64>, b: MatRef<'_, f64>) {
    matmul(c, Accum::Add, a, b, alpha, Par::Seq);
}

/// `Y ← Y + α X`.
pub(crate) fn axpy(mut y: MatMut<'_, f64>, alpha: f64, x: MatRef<'_, f64>) {
    for j in 0..x.ncols() {
        for i in 0..x.nrows() {
            y[(i, j)] += alpha * x[(i, j)];
        }
    }
}

/// `Σ_ij A_ij B_ij`.
pub(crate) fn inner(a: MatRef<'_, f64>, b: MatRef<'_, f64>) -> f64 {
    let mut sum = 0.0;
    for j in 0..a.ncols() {
        let mut column = 0.0;
        for i in 0..a.nrows() {
            column += a[(i, j)] * b[(i, j)];
        }
        sum += column;
    }
    sum
}

/// Frobenius norm.
pub(crate) fn norm(a: MatRef<'_, f64>) -> f64 {
    inner(a, a).sqrt()
}

/// `Σ a_i b_i`.
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

/// A column as a slice; matrices here are column-major with unit row stride.
pub(crate) fn column(a: &Mat<f64>, j: usize) -> &[f64] {
    a.col_as_slice(j)
}

/// Cholesky factor of a symmetric positive definite matrix, lower triangle.
pub(crate) struct Cholesky(Mat<f64>);

impl Cholesky {
    /// Factorises; `None` when a pivot is not positive.
    pub(crate) fn new(mut a: Mat<f64>) -> Option<Cholesky> {
        let n = a.nrows();
        let scratch = llt::factor::cholesky_in_place_scratch::<f64>(n, Par::Seq, Default::default());
        let mut buffer = MemBuffer::new(scratch);
        let stack = MemStack::new(&mut buffer);
        llt::factor::cholesky_in_place(a.as_mut(), Default::default(), Par::Seq, stack, Default::default())
            .ok()?;
        (0..n).all(|i| a[(i, i)].is_finite()).then_some(Cholesky(a))
    }

    /// Overwrites `rhs` with `A⁻¹ rhs`.
    pub(crate) fn solve_in_place(&self, rhs: MatMut<'_, f64>) {
        let mut buffer =
            MemBuffer::new(llt::solve::solve_in_place_scratch::<f64>(self.0.nrows(), rhs.ncols(), Par::Seq));
        llt::solve::solve_in_place(self.0.as_ref(), rhs, Par::Seq, MemStack::new(&mut buffer));
    }
}

/// Solves `W X = R` for a symmetric positive *semi*definite `W`, as Gram matrices of nearly parallel terms
/// are: symmetric scaling to a unit diagonal, then the smallest ridge that factorises, from 1e-14 (the size
/// of the rounding in W) upwards. Directions below the ridge are left where they are, so `R` should be a
/// residual, not a total.
pub(crate) fn solve_semidefinite(w: MatRef<'_, f64>, mut rhs: Mat<f64>) -> Mat<f64> {
    let n = w.nrows();
    let scale: Vec<f64> =
        (0..n).map(|i| if w[(i, i)] > 0.0 { w[(i, i)].sqrt().recip() } else { 0.0 }).collect();
    let scaled = Mat::from_fn(n, n, |i, j| w[(i, j)] * scale[i] * scale[j]);
    let mut ridge = 1e-14 * n as f64;
    let factor = loop {
        let mut a = scaled.clone();
        (0..n).for_each(|i| a[(i, i)] = 1.0 + ridge);
        match Cholesky::new(a) {
            Some(factor) => break factor,
            None if ridge > 1.0 => return Mat::zeros(n, rhs.ncols()),
            None => ridge *= 10.0,
        }
    };
    let rescale = |m: &mut Mat<f64>| {
        for j in 0..m.ncols() {
            for i in 0..n {
                m[(i, j)] *= scale[i];
            }
        }
    };
    rescale(&mut rhs);
    factor.solve_in_place(rhs.as_mut());
    rescale(&mut rhs);
    rhs
}

/// `(U, s, V)`.
pub(crate) type ThinSvd = (Mat<f64>, Vec<f64>, Mat<f64>);

/// Thin singular value decomposition `A = U diag(s) Vᵀ`, `s` descending.
///
/// The matrix is brought to unit largest entry first: the library loses accuracy on matrices of tiny norm.
pub(crate) fn thin_svd(a: MatRef<'_, f64>) -> Result<ThinSvd, SeparatedError> {
    let (m, n) = (a.nrows(), a.ncols());
    let size = m.min(n);
    let largest = a.norm_max();
    if !largest.is_finite() {
        return Err(SeparatedError::NoConvergence { what: "singular value decomposition" });
    }
    let scale = if largest > 0.0 { largest } else { 1.0 };
    let scaled = Mat::from_fn(m, n, |i, j| a[(i, j)] / scale);
    let (mut u, mut v) = (Mat::zeros(m, size), Mat::zeros(n, size));
    let mut s = faer::diag::Diag::<f64>::zeros(size);
    let thin = svd::ComputeSvdVectors::Thin;
    let mut buffer = MemBuffer::new(svd::svd_scratch::<f64>(m, n, thin, thin, Par::Seq, Default::default()));
    let stack = MemStack::new(&mut buffer);
    svd::svd(
        scaled.as_ref(),
        s.as_mut(),
        Some(u.as_mut()),
        Some(v.as_mut()),
        Par::Seq,
        stack,
        Default::default(),
    )
    .map_err(|_| SeparatedError::NoConvergence { what: "singular value decomposition" })?;
    let values = (0..size).map(|i| s.column_vector()[i] * scale).collect();
    Ok((u, values, v))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::Random;

    #[test]
    fn svd_keeps_its_accuracy_at_tiny_scales() {
        let mut random = Random::new(1);
        let a = Mat::from_fn(180, 150, |_, _| 1e-18 * (random.uniform() - 0.5));
        let (u, s, v) = thin_svd(a.as_ref()).unwrap();
        let us = Mat::from_fn(180, 150, |i, j| u[(i, j)] * s[j]);
        let back = product(us.as_ref(), v.transpose());
        // backward stable: a modest multiple of ε √(mn)
        assert!(norm((&a - &back).as_ref()) < 1e-13 * norm(a.as_ref()));
    }

    #[test]
    fn semidefinite_solve_leaves_the_null_space_alone() {
        let w = Mat::from_fn(3, 3, |i, j| {
            if i < 2 && j < 2 {
                4.0
            } else if i == j {
                1.0
            } else {
                0.0
            }
        });
        let x = solve_semidefinite(w.as_ref(), Mat::from_fn(3, 1, |i, _| if i < 2 { 8.0 } else { 3.0 }));
        // the ridge of 3e-14 moves the solution by that much, amplified by nothing in the range of W
        assert!((4.0 * (x[(0, 0)] + x[(1, 0)]) - 8.0).abs() < 1e-11 && (x[(2, 0)] - 3.0).abs() < 1e-11);
        assert!((x[(0, 0)] - x[(1, 0)]).abs() < 1e-1, "the null direction (1,−1,0) is not excited");
    }
}
