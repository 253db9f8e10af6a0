//! What crosses crates is tested here.

pub mod annotate;
pub mod bases;
pub mod golden;
pub mod largest;
pub mod long_march;
pub mod matrices;
pub mod program;
pub mod regions;
pub mod shared;
pub mod stage;
pub mod synthetic;
pub mod textbook;
