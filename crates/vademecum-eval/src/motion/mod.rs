//! Steps, changes of parameters, moving bases, and the compliance of contacts.

pub(crate) mod base;
pub(crate) mod compliance;
pub(crate) mod rebind;
pub(crate) mod set;
pub(crate) mod step;
pub(crate) mod strain;
