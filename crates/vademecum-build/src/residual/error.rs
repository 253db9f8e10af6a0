//! Why there is no residual.

use crate::dynamics::ModesError;
use crate::fem::FactorError;
use crate::linalg::NoConvergence;
use crate::progress::Cancelled;

/// Why there is no residual.
#[derive(Debug, thiserror::Error)]
pub enum ResidualError {
    /// The stiffness does not factorise.
    #[error("the stiffness does not factorise")]
    Factor(#[from] FactorError),
    /// No natural modes.
    #[error("natural modes")]
    Modes(#[from] ModesError),
    /// A reduced matrix is not definite.
    #[error("the residual flexibility over the box")]
    Reduced(#[from] NoConvergence),
    /// On request.
    #[error("the residual of the loadable nodes")]
    Cancelled(#[from] Cancelled),
}
