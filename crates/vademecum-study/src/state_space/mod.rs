//! State-space model of a file: the matrices of `ẋ = A x + B u`, `y = C x + D u`, and the exact map of a
//! step.
//!
//! The state holds the reduced coordinates `ζ`, their velocities, and, under stiffness-proportional damping,
//! a filtered amplitude of each input whose residual flexibility follows it with the time constant `β`. The
//! equation of motion gives `A` and `B`. Everything else is read of a body: `C` is what it shows in each unit
//! state, `D` what it shows at rest under each unit load, and the maps of a step are its own. So a march of
//! the matrices is a run of the file, to rounding.
//!
//! A step takes a load as linear in time from its start to its end:
//!
//! ```text
//! x(t + Δt) = Ad x(t) + Bd_start u(t) + Bd_end u(t + Δt)       y = C x + D u
//! ```

mod error;
mod extract;
mod files;
mod model;
mod place;
mod signal;

pub use error::StateSpaceError;
pub use files::ModelDescription;
pub use model::{Signal, StateSpace, StateSpaceRequest};
pub use signal::{OutputSignal, SignalError};
