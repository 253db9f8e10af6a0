//! Why there is no basis.

use super::snapshots::SnapshotError;
use crate::dynamics::{FullOrderError, ModesError};
use crate::fem::FactorError;
use crate::linalg::NoConvergence;

/// Why there is no basis.
#[derive(Debug, thiserror::Error)]
pub enum BasisError {
    /// No snapshots.
    #[error(transparent)]
    Snapshots(#[from] SnapshotError),
    /// The full-order march of a parameter sample cannot start.
    #[error("the full-order march cannot start")]
    FullOrder(#[from] FullOrderError),
    /// No natural modes.
    #[error("natural modes")]
    Modes(#[from] ModesError),
    /// A matrix does not factorise.
    #[error("a matrix of the model does not factorise")]
    Factor(#[from] FactorError),
    /// A decomposition met numbers that double precision does not hold.
    #[error("the basis")]
    NoConvergence(#[from] NoConvergence),
    /// More modes asked for than the snapshots span.
    #[error(
        "{path}: `basis.modes` is {asked}; the snapshots span {found} dimensions: add positions, directions or time to `[snapshots]`"
    )]
    TooManyModes {
        /// The problem file and line.
        path: String,
        /// Modes asked for.
        asked: usize,
        /// Dimension of the snapshots.
        found: usize,
    },
}
