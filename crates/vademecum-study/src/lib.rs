//! What is asked of a finished file: a scenario played through it, a full-order march beside it, other programs beside both.
//!
//! A study reads a vademecum and the problem it was built from, steps and measures, and returns figures. It prints nothing:
//! the program `vademecum` and any other caller show what they get.

pub mod bench;
pub mod compare;
pub mod contents;
mod error;
pub mod export;
pub mod free_run;
pub mod modes;
pub mod player;
pub mod run;
pub mod scenario;
pub mod separation;
mod statistics;
pub mod target;
pub mod timings;
pub mod verify;

pub use error::{FileError, StudyError};
