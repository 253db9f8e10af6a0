//! Bodies that touch: contact with friction between deformable surfaces, found and solved in each step.

pub(crate) mod bind;
pub(crate) mod bounds;
pub(crate) mod close;
pub(crate) mod contacts;
pub(crate) mod error;
pub(crate) mod find;
pub(crate) mod frame;
pub(crate) mod joint;
pub(crate) mod joints;
pub(crate) mod lead;
pub(crate) mod member;
pub(crate) mod motion;
pub(crate) mod options;
pub(crate) mod patch;
pub(crate) mod room;
pub(crate) mod rows;
pub(crate) mod saved;
pub(crate) mod slot;
pub(crate) mod solve;
pub(crate) mod touch;
// The type that the room is named after.
#[allow(clippy::module_inception)]
pub(crate) mod world;
