//! Large displacements: a strain map over a basis, learnt from shapes of least energy.

mod map;
mod prior;
mod relax;
mod states;
mod step;

pub use map::{Columns, Pairs, StrainMap};
pub use prior::{Prior, columns};
pub use relax::relax;
pub use states::{States, draw, relaxed};
pub use step::{Motion, ROW_VISCOSITY};
