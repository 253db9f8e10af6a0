//! Columns of a method and their matrices.

use faer::Mat;

use crate::linalg::{symmetric_part, transposed_product};

/// Columns over `v = (q, x)`, and what is known of their matrices.
pub(super) struct Reduced {
    pub(super) columns: Mat<f64>,
    pub(super) frequencies_hz: Vec<f64>,
    pub(super) mass: Mat<f64>,
    pub(super) stiffness: Mat<f64>,
    /// Eigenvalues of the coordinates behind those of the interfaces, zero of rigid motions, where these are
    /// natural modes of the body as it is.
    pub(super) natural: Option<Vec<f64>>,
}

/// `½ (VᵀAV + its transpose)` for an image `AV`.
pub(super) fn gram(columns: &Mat<f64>, image: &Mat<f64>) -> Mat<f64> {
    symmetric_part(transposed_product(columns.as_ref(), image.as_ref()).as_ref())
}

/// `√λ / 2π`.
pub(super) fn hertz(eigenvalues: &[f64]) -> Vec<f64> {
    eigenvalues.iter().map(|value| value.sqrt() / std::f64::consts::TAU).collect()
}
