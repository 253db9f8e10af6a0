//! Vectors over the dofs, and products of one with a sparse matrix.

use faer::{MatMut, MatRef};

use crate::fem::SymmetricMatrix;

pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// `y ← y + w x`.
pub(super) fn add(y: &mut [f64], w: f64, x: &[f64]) {
    y.iter_mut().zip(x).for_each(|(y, x)| *y += w * x);
}

/// `a + w b`.
pub(super) fn sum(a: &[f64], w: f64, b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a + w * b).collect()
}

/// `A x`.
pub(super) fn times(matrix: &SymmetricMatrix, x: &[f64]) -> Vec<f64> {
    let mut y = vec![0.0; x.len()];
    let n = x.len();
    matrix.mul_into(
        MatRef::from_column_major_slice(x, n, 1),
        MatMut::from_column_major_slice_mut(&mut y, n, 1),
    );
    y
}
