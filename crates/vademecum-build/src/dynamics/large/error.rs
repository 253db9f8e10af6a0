//! Why large displacements were not found.

use super::scheme::LargeDamping;
use crate::dynamics::FullOrderError;
use crate::fem::FactorError;
use crate::progress::Cancelled;

/// Why a body at large displacements found no rest, no next step or no relaxed shape.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum LargeError {
    /// The step is not a positive number.
    #[error("the time step must be positive and finite; found {0} s")]
    TimeStep(f64),
    /// A damping coefficient is negative or not finite.
    #[error(
        "damping must not be negative: found mass {} 1/s, stiffness {} s, strain rate {} s", .0.mass, .0.stiffness,
        .0.strain_rate
    )]
    Damping(LargeDamping),
    /// The scheme mixes forces of several instants, or is no scheme.
    #[error(
        "a scheme for large displacements must balance the forces at the instants of its stages; the exact scheme \
         and schemes that mix the elastic forces of two instants (hht-alpha, generalized-alpha) do not: use bathe, \
         rho-bathe, newmark or the energy-momentum scheme"
    )]
    Scheme,
    /// A body without supports has no rest under a load.
    #[error("a body without supports has no rest and no relaxed shape: hold it, or march it in time")]
    FreeBody,
    /// Vectors of another length than the number of free dofs.
    #[error("{what} has {found} numbers for {expected} expected")]
    Length {
        /// Which vector.
        what: &'static str,
        /// Numbers found.
        found: usize,
        /// Numbers expected.
        expected: usize,
    },
    /// A load is infinite or no number.
    #[error("the load at {at} has a value that is not a finite number")]
    Load {
        /// The time \[s\], or the part of the load path.
        at: f64,
    },
    /// A matrix does not factorise.
    #[error("the tangent stiffness")]
    Factor(#[from] FactorError),
    /// There is no initial acceleration.
    #[error("the start of the march")]
    Start(#[from] FullOrderError),
    /// A load step failed however short it was.
    #[error(
        "no rest was found beyond {reached} of the load path: Newton's method stopped at a relative residual of \
         {residual:.1e} after {iterations} iterations with load steps of {step:.1e}; the body may buckle or \
         collapse there: apply less load, or march it in time with damping"
    )]
    NoRest {
        /// Part of the load path that was reached.
        reached: f64,
        /// Length of the load step that failed.
        step: f64,
        /// Energy of the last correction as a part of the energy, its root.
        residual: f64,
        /// Iterations of the step that failed.
        iterations: usize,
    },
    /// Only shapes with elements turned inside out balance the load.
    #[error(
        "beyond {reached} of the load path the load is balanced only with elements turned inside out, which the law \
         of St. Venant-Kirchhoff allows under strong compression: apply less load, or spread it over more elements"
    )]
    InsideOut {
        /// Part of the load path that was reached.
        reached: f64,
    },
    /// A time step failed, and so did its halves.
    #[error(
        "no balance was found in time step {step}, from {time:.6e} s on: Newton's method stopped at a relative \
         residual of {residual:.1e} after {iterations} iterations, with the step halved {halvings} times; take a \
         shorter time step or a smaller load, or add damping"
    )]
    NoStep {
        /// The step, counted from 0.
        step: usize,
        /// Start of the part that failed \[s\].
        time: f64,
        /// Energy of the last correction as a part of the energy, its root.
        residual: f64,
        /// Iterations of the last attempt.
        iterations: usize,
        /// Number of halvings of the step.
        halvings: usize,
    },
    /// A relaxation failed.
    #[error(
        "no relaxed shape was found at the prescribed coordinates: Newton's method stopped at a relative \
         residual of {residual:.1e} after {iterations} iterations; prescribe coordinates nearer to those of the \
         last shape"
    )]
    NoShape {
        /// Energy of the last correction as a part of the energy, its root.
        residual: f64,
        /// Iterations of the attempt that failed.
        iterations: usize,
    },
    /// On request.
    #[error("the march was stopped")]
    Cancelled(#[from] Cancelled),
}

/// Refuses a vector of another length.
pub(super) fn check_length(what: &'static str, found: usize, expected: usize) -> Result<(), LargeError> {
    if found == expected { Ok(()) } else { Err(LargeError::Length { what, found, expected }) }
}
