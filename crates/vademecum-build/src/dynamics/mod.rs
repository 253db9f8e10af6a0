//! Motion at full order: time schemes as tables, the march, natural modes, damping.

mod damping;
mod full_order;
mod initial;
pub(crate) mod krylov;
mod modes;
pub mod schemes;

pub use damping::{Damping, DampingError, NumericalDamping, Rayleigh, numerical_damping, step_matrix};
pub use full_order::{FullOrder, FullOrderError, StageLoads, State, Workspace};
pub use modes::{Modes, ModesError, lowest_modes};
pub use schemes::{SchemeError, SchemeKind};

#[cfg(test)]
mod oracle_tests;
