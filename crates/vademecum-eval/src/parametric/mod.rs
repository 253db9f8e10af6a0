//! Parametric reduced-order models: bodies with live stiffness and density of regions, set to values in lent
//! memory, each time as the bytes of an ordinary file.

pub(crate) mod batch;
pub(crate) mod coupling;
pub(crate) mod damped;
pub(crate) mod dissipation;
pub(crate) mod error;
pub(crate) mod memory;
pub(crate) mod model;
pub(crate) mod ports;
pub(crate) mod reactions;
pub(crate) mod residual;
pub(crate) mod rows;
pub(crate) mod slope_step;
pub(crate) mod slopes;
pub(crate) mod solve;
pub(crate) mod tangents;
pub(crate) mod tracked;
pub(crate) mod tracker;
pub(crate) mod tuned;
pub(crate) mod write;
