//! Outputs: displacement, velocity, energy, stress, reactions, static fields.

pub(crate) mod output;
pub(crate) mod reaction;
pub(crate) mod static_field;
pub(crate) mod stress;
