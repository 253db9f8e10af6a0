//! Failures of a factorisation.

use super::single::TOLERANCE;
use super::spread::EngineError;

/// Why a factorisation failed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FactorError {
    /// Conjugate gradients with a factor in single precision do not reach the tolerance.
    #[error(
        "systems cannot be solved to {TOLERANCE:e} with a factor in single precision (error {error:.0e} of the \
         energy norm): the stiffness is too ill-conditioned for it"
    )]
    NotConverged {
        /// The error that was reached, relative in the energy norm.
        error: f64,
    },
    /// The matrix is not positive definite: a body that can move freely, or a bad combination of weights.
    #[error(
        "the matrix is not positive definite (pivot {pivot} of {n}): is the body held, are all weights positive?"
    )]
    NotPositiveDefinite {
        /// The pivot, in elimination order, at which it showed.
        pivot: usize,
        /// Size of the matrix.
        n: usize,
    },
    /// The memory for the factor was refused.
    #[error("not enough memory for the factor")]
    OutOfMemory,
    /// Ranks that factorise together had to stop.
    #[error(transparent)]
    Engine(#[from] EngineError),
}
