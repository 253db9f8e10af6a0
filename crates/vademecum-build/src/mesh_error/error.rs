//! Why an estimate of the discretisation error failed.

use crate::dynamics::ModesError;
use crate::fem::FactorError;
use crate::linalg::NoConvergence;
use crate::progress::Cancelled;

/// Why an estimate failed.
#[derive(Debug, thiserror::Error)]
pub enum MeshErrorFailure {
    /// The stiffness does not factorise.
    #[error("the stiffness does not factorise")]
    Factor(#[from] FactorError),
    /// The modes of the mesh.
    #[error("natural modes")]
    Modes(#[from] ModesError),
    /// A small decomposition failed.
    #[error(transparent)]
    NoConvergence(#[from] NoConvergence),
    /// The user wants to stop.
    #[error("the search in the raised space")]
    Cancelled(#[from] Cancelled),
}
