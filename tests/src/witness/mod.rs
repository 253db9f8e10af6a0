//! Bodies whose answers others have published, and the same bodies in another finite element program.
//!
//! A witness is a problem file of `tests/witnesses`, a mesh that is made here, and reference values. The mesh
//! is written as an Abaqus deck, which this program and CalculiX both read, so the two compute with the same
//! nodes and elements.

mod bodies;
pub mod calculix;
mod deck;
mod large;
mod mass;
mod record;
mod thermal;

pub use bodies::{Mode, StressAt, Witness, whole_cylinder, witness, witnesses};
pub use deck::write as write_deck;
pub use large::{Bent, bend};
pub use record::{Apart, Found, compare, markdown, measure};
pub use thermal::Thermal;
