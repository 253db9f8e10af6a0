//! Numbers, lent memory, options and errors: what every other room uses.

pub(crate) mod error;
pub(crate) mod lend;
pub(crate) mod options;
#[cfg(any(feature = "assembly", feature = "world"))]
pub(crate) mod pose;
pub(crate) mod principal;
pub(crate) mod scalar;
pub(crate) mod vec3;
pub(crate) mod vectors;
