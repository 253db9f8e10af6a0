//! Why there is no basis.

use super::snapshots::SnapshotError;
use crate::dynamics::{FullOrderError, ModesError};
use crate::fem::FactorError;
use crate::linalg::NoConvergence;
use crate::residual::ResidualError;

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
    /// No bound of the natural modes.
    #[error("the bound of natural modes")]
    Residual(#[from] ResidualError),
    /// No number of natural modes keeps the bound asked for.
    #[error(
        "{path}: `basis.error` is {asked:e}; {modes} natural modes, the most that are tried on this body, reach \
         {reached:.2e} at the worst loadable node: ask for no less than that, or for `modes`, or choose a smaller \
         `load.surface`"
    )]
    BoundMissed {
        /// The problem file and line.
        path: String,
        /// The bound asked for.
        asked: f64,
        /// Modes tried.
        modes: usize,
        /// The bound they reach.
        reached: f64,
    },
    /// More vectors asked for than the modes over the box of live regions span.
    #[error(
        "{path}: `basis.modes` is {asked}; the modes over the box of live regions span {found} dimensions: \
         ask for at most {found}"
    )]
    TooManyPooled {
        /// The problem file and line.
        path: String,
        /// As many as were asked for.
        asked: usize,
        /// As many as there are.
        found: usize,
    },
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
