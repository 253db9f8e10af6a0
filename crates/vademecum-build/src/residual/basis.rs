//! A body and the basis beside which its residual flexibility is.

use faer::MatRef;

use crate::fem::{Pencil, Symbolic};
use crate::prepared::Body;

/// A body and the basis whose residual flexibility is computed.
#[derive(Clone, Copy)]
pub(crate) struct ResidualBasis<'a> {
    /// The body.
    pub(crate) body: &'a Body,
    /// Its mass and stiffness, or those at other values of its parameters.
    pub(crate) pencil: &'a Pencil,
    /// Symbolic factorisation of its pattern.
    pub(crate) symbolic: &'a Symbolic,
    /// `B`, shape (n, r), `BᵀMB = I`.
    pub(crate) vectors: MatRef<'a, f64>,
    /// `Λ`, the diagonal of `BᵀKB`.
    pub(crate) eigenvalues: &'a [f64],
    /// True if `B` are natural modes and the step is exact in time: whether the bound is rigorous.
    pub(crate) rigorous: bool,
}
