//! Loops over numbers: rows of a map, vectors of a step, the solve of large displacements,
//! small dense matrices.

pub(crate) mod coordinates;
#[cfg(feature = "assembly")]
pub(crate) mod dense;
#[cfg(feature = "assembly")]
pub(crate) mod eigen;
pub(crate) mod kernel;
pub(crate) mod strain;
