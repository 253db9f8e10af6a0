//! What one time step does to a basis: the response of each stage to every mode, and the terms a file keeps
//! of it.

mod error;
mod stage;
mod terms;

pub use error::ResponseError;
pub use stage::{StageResponse, stage_responses};
pub use terms::{AxisTable, BlockTerms};
