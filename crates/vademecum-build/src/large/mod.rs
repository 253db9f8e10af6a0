//! Large displacements: a strain map over a basis, learnt from shapes of least energy.

mod basis;
mod learn;
mod map;
mod prediction;
mod prior;
mod regression;
mod shapes;
mod states;
mod trial;

pub use basis::with_followers;
pub use learn::{CANDIDATES, FollowedBasis, LargeOptions, LearnError, Learner, Learnt};
pub use map::{Pairs, StrainGram, StrainMap};
pub use prediction::Prediction;
pub use prior::{Prior, columns};
pub use regression::Columns;
pub use shapes::relaxed;
pub use states::{States, draw};
pub use trial::{FullOrder, PARTS, Push, Pushes, Reference, Seen, asked_displacement};

#[cfg(test)]
mod tests;
