//! The structure of chapter 5 as the chapter prints it, with a scene of its own (feature `chapter`).
//!
//! A file built with `representation = "canonical"` holds, for each stage of the time scheme, a sum of terms.
//! Each term is a product of one-dimensional functions of the state's coordinates and of the load, times r
//! numbers (equations 5.8 and 5.9, key `chapter5` of `docs/reference/bibliography.md`). It is kept as a
//! baseline to compare with, and nobody who only wants to step a body needs it: [`Scene`](crate::Scene)
//! refuses such a file by name ([`BindError::OnlyChapter`](crate::BindError::OnlyChapter)).
//!
//! [`ChapterScene`], [`ChapterState`] and [`ChapterLoads`] are used as [`Scene`](crate::Scene),
//! [`State`](crate::State) and [`Loads`](crate::Loads) are. They know less: one time step and damping (those
//! of the file), no live parameters, no load patterns, and contacts only at listed nodes.
//!
//! Evaluating a stage is one interpolation per axis for all terms at once, then one weighted sum of r numbers
//! per term. Where state and load are apart, what the loads contribute does not depend on the state: it is
//! summed when they are added, contact by contact.
//!
//! The odd thing: the functions end where their ranges do. A coordinate that leaves its range is refused by
//! name with the state unchanged; nothing is clamped or extrapolated. There is no map to fuse, so the stages
//! run one after the other.

mod error;
mod loads;
mod output;
mod scene;
mod state;
mod step;
mod terms;

pub use error::{ChapterBindError, ChapterLoadError, ChapterStepError};
pub use loads::ChapterLoads;
pub use scene::ChapterScene;
pub use state::ChapterState;
