//! What crosses crates is tested here.

pub mod annotate;
pub mod stage;
pub mod synthetic;
pub mod textbook;
