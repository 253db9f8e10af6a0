//! The online half: a file of the chapter's structure, bound and stepped.
//!
//! A file built with `representation = "chapter"` holds, for each stage of the time scheme, a sum of terms.
//! Each term is a product of one-dimensional functions of the state's coordinates and of the load, times r
//! numbers (equations 5.8 and 5.9, key `chapter5` of `docs/reference/bibliography.md`). The evaluator refuses
//! such a file by name ([`BindError::OnlyChapter`](vademecum_eval::BindError::OnlyChapter)).
//!
//! [`ChapterScene`], [`ChapterState`] and [`ChapterLoads`] are used as the evaluator's scene, state and loads
//! are. They own their memory, step in `f64` and know less: one time step and damping (those of the file), no
//! live parameters, no load patterns, and contacts only at listed nodes.
//!
//! Evaluating a stage is one interpolation per axis for all terms at once, then one weighted sum of r numbers
//! per term. Where state and load are apart, what the loads contribute does not depend on the state: it is
//! summed when they are added, contact by contact.
//!
//! Note: the functions end where their ranges do. A coordinate that leaves its range is refused by
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
