//! Motion at full order: time schemes as tables, the march, natural modes, damping.

mod damping;
mod dashpots;
mod full_order;
mod harmonic;
mod history;
mod initial;
mod interval;
pub(crate) mod krylov;
pub mod large;
mod march;
mod mode_table;
mod modes;
mod natural;
mod orthonormal;
mod reference;
pub mod schemes;
mod window;
mod work;

pub use damping::{Damping, DampingError, ModalRatios, NumericalDamping, Rayleigh, numerical_damping};
pub use dashpots::{COUPLED, coupling_error, damping_rows};
pub(crate) use dashpots::{fewest_rows, uncouple};
pub use full_order::{FullOrder, FullOrderError, StageLoads, State, Workspace};
pub use harmonic::{HarmonicError, harmonic};
pub use history::{Course, History, LoadTable, Wave};
pub use interval::Interval;
pub(crate) use krylov::search_vectors;
pub use march::march_stages;
pub use march::{
    ErrorMeter, INSTANTS, MarchError, TimedLoad, TrajectoryError, factors, march_full_order, stage_amplitudes,
};
pub use mode_table::{ModeRow, mode_table, table_matrix};
pub(crate) use modes::lowest_modes_kept;
pub use modes::{FirstMode, lowest_modes, search_on};
pub use natural::{Modes, ModesError};
pub use reference::{
    Complement, Decay, MarchMeter, MotionPart, ReferenceDistance, ReferenceError, ReferenceOptions,
    ReferenceSolution, ReferenceTrajectory,
};
pub use schemes::{SchemeError, SchemeKind};
pub use window::{Span, Window};
pub use work::{TooMuchWork, Work, announce, seconds_per_step, time_in_words};

#[cfg(test)]
mod oracle_tests;
