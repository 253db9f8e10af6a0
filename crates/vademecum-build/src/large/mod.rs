//! Large displacements: the reduced Green–Lagrange strain over a basis, fitted to statically condensed
//! shapes.

mod basis;
mod learn;
mod map;
mod prediction;
mod prior;
mod regression;
mod shapes;
mod states;
mod trial;

pub(crate) use learn::CANDIDATES;
pub use learn::LearnError;
pub(crate) use learn::{LargeModel, LargeOptions, StrainLearner};
pub use map::Pairs;
pub use prior::{Prior, columns};
pub use regression::StrainColumns;
pub use states::draw;
pub use trial::asked_displacement;
pub(crate) use trial::{PARTS, ProjectedRun, Push, PushFamily, ReferenceModel, ReferenceRun};

#[cfg(test)]
mod tests;
