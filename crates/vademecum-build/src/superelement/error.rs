//! Why a body cannot be reduced to its interfaces.

use crate::dynamics::ModesError;
use crate::fem::{FactorError, PencilError};
use crate::limits::TooMuchMemory;
use crate::linalg::NoConvergence;
use crate::progress::Cancelled;

/// Why a body cannot be reduced to its interfaces.
#[derive(Debug, thiserror::Error)]
pub enum SuperelementError {
    /// Two interfaces have a dof in common.
    #[error(
        "--interface {first} and {second} have node {node} in common: a node has its coordinates once; join them in one \
         interface, on = {{ any = [ … ] }}, or select other nodes"
    )]
    Shared {
        /// The earlier interface.
        first: String,
        /// The later one.
        second: String,
        /// Number of the node in the mesh file; 0 of a reference point.
        node: u64,
    },
    /// A coordinate depends on others of its interface.
    #[error(
        "--interface {name}: one of its {count} coordinates follows from the others, by an attachment or by too few nodes; \
         select more nodes, or those that nothing couples"
    )]
    Dependent {
        /// The interface.
        name: String,
        /// Number of its coordinates.
        count: usize,
    },
    /// Rigid motions that the interfaces do not see.
    #[error(
        "the interfaces leave {left} of the 6 rigid motions of the free body to its inside, where a mode with fixed \
         interfaces has to be elastic; expected interfaces that fix the body: a frame, or three nodes that are not on a \
         line; or take --method rubin"
    )]
    Loose {
        /// Rigid motions with the interfaces at rest.
        left: usize,
    },
    /// Nothing is left inside.
    #[error("the interfaces have all {free} free dofs of the body: there is nothing left to reduce")]
    NothingInside {
        /// Free dofs.
        free: usize,
    },
    /// Residual flexibility that does not reach all coordinates.
    #[error(
        "the flexibility that the {modes} modes leave out is singular over the {coordinates} coordinates of the interfaces: \
         take fewer modes, or frames instead of patches"
    )]
    NoResidual {
        /// Elastic modes.
        modes: usize,
        /// Coordinates of the interfaces.
        coordinates: usize,
    },
    /// A method with free interfaces has no modes.
    #[error("--modes 0 with --method {method}: a basis of free-interface modes needs at least one")]
    NoModes {
        /// The method.
        method: &'static str,
    },
    /// No modes.
    #[error("normal modes of the superelement")]
    Modes(#[from] ModesError),
    /// The stiffness inside does not factorise.
    #[error(
        "the stiffness with fixed interfaces does not factorise: a part of the body moves freely between the interfaces"
    )]
    Factor(#[from] FactorError),
    /// The matrices over the coordinates are no pencil.
    #[error("the matrices over the coordinates of the interfaces")]
    Pencil(#[from] PencilError),
    /// More memory than there is.
    #[error(transparent)]
    Memory(#[from] TooMuchMemory),
    /// Numbers beyond double precision.
    #[error("the modes of the superelement")]
    NoConvergence(#[from] NoConvergence),
    /// The user wants to stop.
    #[error("the reduction to the interfaces")]
    Cancelled(#[from] Cancelled),
}
