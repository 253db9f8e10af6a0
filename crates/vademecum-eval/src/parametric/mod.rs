//! Parametric reduced-order models: bodies with live stiffness and density of regions, set to values in lent
//! memory, each time as the bytes of an ordinary file.

pub(crate) mod error;
pub(crate) mod memory;
pub(crate) mod model;
pub(crate) mod ports;
pub(crate) mod reactions;
pub(crate) mod residual;
pub(crate) mod rows;
pub(crate) mod solve;
pub(crate) mod tuned;
pub(crate) mod write;
