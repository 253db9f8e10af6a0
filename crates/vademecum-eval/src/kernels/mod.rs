//! Loops over numbers: rows of a map, vectors of a step, the solve of large displacements.

pub(crate) mod coordinates;
pub(crate) mod kernel;
pub(crate) mod strain;
