//! Live parameters: which of them are free, what they do to the model, and the separated responses over their
//! box.
//!
//! Parameters that only move θ (docs/explanation/5-vademecum.md: uniform stiffness and density, Δt, α, β,
//! both stages) collapse into one axis; scales of single regions take an axis each. The user's parameters and
//! the axes of the solution are therefore two things, and
//! [`ParameterSpace`](crate::prepared::ParameterSpace) is the map between them.

mod axis_map;
mod error;
mod record;
mod responses;
mod separate;

pub use error::ParametricError;
pub use record::{RadiusSample, SeparationRecord};
pub use separate::{Parametric, SeparationOptions, separate_responses};
