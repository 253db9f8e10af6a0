//! Universal files: modes and frequency responses for programs of modal testing, and modes from them.
//!
//! A universal file is a text of datasets, each between two lines `-1`, with its number in the line behind
//! the first: 164 units, 15 nodes, 82 lines between nodes, 55 data at nodes (here modes), 58 a function at a
//! dof (here a frequency response). Numbers stand in columns of fixed width.

mod error;
mod export;
mod match_modes;
mod read;
mod write;

pub use error::UffError;
pub use export::{UffExport, UffRequest};
pub use match_modes::{Matched, is_universal};
pub use read::{UniversalFile, UniversalMode};
