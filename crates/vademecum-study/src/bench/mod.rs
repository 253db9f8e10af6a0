//! Run time against error: what `vademecum bench` compares, made from the same pieces as a build.
//!
//! One model, one set of snapshots and one POD serve every basis, and one motion that is exact in time serves
//! every total error, so that two rows differ by the basis and the structure of the step and by nothing else.
//! Each piece is timed where it is made; a method's offline time is the sum of the pieces it needs, as if it
//! had been built alone.
//!
//! [`compare_methods`] is the whole comparison; [`Study`] makes the pieces, and other records are made of
//! them too. [`compare_large_methods`] is that of bodies of large displacements.

mod candidates;
mod chapter;
mod comparison;
mod equal_time;
mod errors;
mod front;
mod galerkin;
mod inputs;
mod large;
mod measure;
mod method;
mod modal;
mod staged;
mod study;
mod table;
#[cfg(test)]
mod tests;
mod trajectory;
mod two_stage;

pub use chapter::LoadSites;
pub use comparison::{BenchOptions, compare_methods};
pub use equal_time::{EqualTime, Side};
pub use errors::Errors;
pub use front::front;
pub use galerkin::DenseGalerkin;
pub(crate) use inputs::Bound;
pub use large::{
    LARGE_COLUMNS, LargeBenchOptions, LargeBenchTable, LargeErrors, LargeMethod, LargeRow,
    compare_large_methods,
};
pub use method::{Identity, Precision, Way};
pub use modal::ExactModes;
pub use study::{Study, Timed};
pub use table::{BenchTable, COLUMNS, Column, Row, SchemeDistance};
pub use two_stage::TwoStage;
