//! Whole bodies: one, many of one file, and one that owns its memory.

pub(crate) mod batch;
#[cfg(feature = "alloc")]
pub(crate) mod simulation;
pub(crate) mod tree;
