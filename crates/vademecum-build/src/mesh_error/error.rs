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
        "a disc of radius {radius:e} m: expected at most half of the body's size, {most:.3e} m, and enough for points of \
         integration on a facet that can move, such as a mean edge of the mesh, {edge:.3e} m"
    )]
    Disc {
        /// Its radius.
        radius: f64,
        /// The largest.
        most: f64,
        /// The mean edge of the mesh.
        edge: f64,
    },
    /// The user wants to stop.
    #[error("the search in the raised space")]
    Cancelled(#[from] Cancelled),
}
