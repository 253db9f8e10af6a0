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
pub use learn::{CondensedBasis, LargeModel, LargeOptions, LearnError, StrainLearner};
pub use map::{Pairs, ReducedStrain, StrainGram};
pub use prediction::Prediction;
pub use prior::{Prior, columns};
pub use regression::StrainColumns;
pub use shapes::relaxed;
pub use states::{TrainingStates, draw};
pub use trial::{PARTS, ProjectedRun, Push, PushFamily, ReferenceModel, ReferenceRun, asked_displacement};

#[cfg(test)]
mod tests;
