//! Loops over numbers: rows of a map, vectors of a step, the solve of large displacements,
//! small dense matrices.

pub(crate) mod coordinates;
#[cfg(any(feature = "assembly", feature = "parametric"))]
pub(crate) mod dense;
#[cfg(any(feature = "assembly", feature = "parametric"))]
pub(crate) mod eigen;
pub(crate) mod kernel;
#[cfg(feature = "parametric")]
pub(crate) mod lowest;
pub(crate) mod strain;
