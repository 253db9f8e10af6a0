//! The laboratory: run time against error, method by method, made from the same pieces as a build. The
//! program of this crate runs it: `cargo run --release -p vademecum-lab -- bench`.
//!
//! One model, one set of snapshots and one POD serve every basis, and one motion that is exact in time serves
//! every total error, so that two rows differ by the basis and the structure of the step and by nothing else.
//! Each piece is timed where it is made; a method's offline time is the sum of the pieces it needs, as if it
//! had been built alone.
//!
//! [`compare_methods`] is the whole comparison; a [`Study`] makes the pieces. [`compare_large_methods`]
//! is that of bodies of large displacements.

mod candidates;
mod chapter;
mod comparison;
mod equal_time;
mod errors;
mod front;
mod galerkin;
mod large;
mod march;
mod measure;
mod method;
mod modal;
mod row;
mod staged;
mod table;
#[cfg(test)]
mod tests;
mod trajectory;
mod two_stage;

pub use chapter::{LoadSites, chapter_bytes};
pub use comparison::{BenchOptions, compare_methods};
pub use equal_time::{EqualTime, Side};
pub use errors::Errors;
pub use front::front;
pub use galerkin::DenseGalerkin;
pub use large::{
    LARGE_COLUMNS, LargeBenchOptions, LargeBenchTable, LargeErrors, LargeMethod, LargeRow,
    compare_large_methods,
};
pub use method::{Identity, Precision, Way};
pub use modal::ExactModes;
pub use row::Row;
pub use table::{BenchTable, COLUMNS, Column, SchemeDistance};
pub use two_stage::TwoStage;
pub use vademecum_study::parts::{Study, Timed};
