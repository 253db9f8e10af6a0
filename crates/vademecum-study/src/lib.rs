//! Studies of a finished file: a scenario played through it, a full-order march and other methods
//! beside it.
//!
//! A study reads a vademecum and the problem it was built from, steps and measures, and returns figures. It
//! prints nothing and writes nothing: the program `vademecum` and any other caller show what they get.
//!
//! Start at [`player`], which binds a [`scenario`] to a file and steps it. [`run`] and [`verify`]
//! are made of it; [`contents`] and [`separation`] read what a file says without stepping it.

pub mod calibrate;
pub mod compare;
pub mod contents;
mod error;
pub mod export;
pub mod fmu;
pub mod free_run;
pub mod frf;
mod large_motion;
pub mod live;
pub mod live_errors;
pub mod log_scale;
mod modal;
pub mod modes;
mod near;
mod notes;
mod npz;
mod pace;
pub mod parameters;
pub mod player;
mod probes;
pub mod run;
pub mod scenario;
mod scenario_loads;
pub mod sensors;
pub mod separation;
pub mod sets;
pub mod shapes;
pub mod soundness;
pub mod starter;
pub mod state_space;
mod statistics;
pub mod stress;
mod stress_error;
mod study;
pub mod superelement;
pub mod sweep;
pub mod table;
pub mod target;
pub mod timings;
mod truth;
pub mod uff;
mod under_contacts;
pub mod verify;

pub use error::{FileError, StudyError};
pub use truth::{TruthErrors, contact_errors, largest_error};

/// Parts of verifications for programs that compare methods: reference solutions, played files, statistics.
pub mod parts {
    pub use crate::compare::orthonormal;
    pub use crate::large_motion::{Extent, LargeMotion, MarchDistance, Reference, SparseLoad};
    pub use crate::player::chapter::left_ranges;
    pub use crate::player::stop_if_asked;
    pub use crate::scenario_loads::ScenarioLoads;
    pub use crate::statistics::{median, percentiles};
    pub use crate::study::{Form, Study, Timed};
    pub use crate::truth::find_truth;
    pub use crate::verify::{BoundScenario, file_nodes};
}
