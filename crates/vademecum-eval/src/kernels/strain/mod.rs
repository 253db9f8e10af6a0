//! The step of large displacements: its quadratic forms, their memory, and the solve of a sub-step.

pub(crate) mod kernel;
pub(crate) mod map;
pub(crate) mod memory;
pub(crate) mod numbers;
pub(crate) mod solve;
pub(crate) mod tail;
pub(crate) mod wide;
