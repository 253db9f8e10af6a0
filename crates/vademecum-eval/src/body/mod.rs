//! Whole bodies: one, many of one file, and one that owns its memory.

pub(crate) mod any;
pub(crate) mod batch;
pub(crate) mod body;
pub(crate) mod identity;
pub(crate) mod quantity;
pub(crate) mod saved;
#[cfg(feature = "alloc")]
pub(crate) mod simulation;
pub(crate) mod tree;
