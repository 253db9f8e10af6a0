//! Rigid motion of bodies that nothing holds.

pub(crate) mod free;
pub(crate) mod rigid;
