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
    /// A disc that no traction can be spread over.
    #[error(
        "a disc of radius {radius:e} m: expected one from a tenth of a mean edge of the mesh to half of the body's \
         size, {least:.3e} to {most:.3e} m"
    )]
    Disc {
        /// Its radius.
        radius: f64,
        /// The smallest.
        least: f64,
        /// The largest.
        most: f64,
    },
    /// The user wants to stop.
    #[error("the search in the raised space")]
    Cancelled(#[from] Cancelled),
}
