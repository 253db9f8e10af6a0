//! Errors of the chapter's structure beside those of any structure.

use thiserror::Error;
use vademecum_eval::{BindError, LoadError, StepError};
use vademecum_format::{ChapterRole, FormatError};

/// Why a scene of the chapter's structure could not be bound.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum ChapterBindError {
    /// As for any scene.
    #[error(transparent)]
    Bind(#[from] BindError),
    /// The file does not have the chapter's structure.
    #[error("the file does not have the chapter's structure: bind an ordinary scene")]
    NoChapter,
    /// The structure was built for the file's time step, damping and scales and for all its terms, and the
    /// options ask for others.
    #[error(
        "the chapter's structure holds one time step, damping and scale and all its terms: leave the options \
         at the file's"
    )]
    Fixed,
}

/// Why a load was not added; the accumulated loads are unchanged.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum ChapterLoadError {
    /// As for any scene.
    #[error(transparent)]
    Load(#[from] LoadError),
    /// The file was built for loads in one direction, and this is another.
    #[error("the chapter's structure was built for loads in one direction, and this is another")]
    OtherDirection,
    /// The load can stand at listed nodes, and this is none of them.
    #[error("node {node} is no load position of the chapter's structure; its section 27 lists them")]
    NotAPosition {
        /// The node, in file order.
        node: u32,
    },
    /// State and load are in the same terms, so there can be one load, whole at one node.
    #[error("the chapter's structure has state and load in the same terms: one load, whole at one node")]
    OneContact,
    /// Magnitude or component is not on its axis.
    #[error("{role} is {value:e}, outside its axis from {lower:e} to {upper:e}; it is not extrapolated")]
    OutsideAxis {
        /// Which.
        role: ChapterRole,
        /// The value.
        value: f64,
        /// Smallest value on the axis.
        lower: f64,
        /// Largest value on the axis.
        upper: f64,
    },
}

/// Why a step was not taken; the state is unchanged.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum ChapterStepError {
    /// As for any scene.
    #[error(transparent)]
    Step(#[from] StepError),
    /// A coordinate has left the range its axis was built for.
    #[error(
        "stage {}: {role} is {value:e}, outside its axis from {lower:e} to {upper:e}; it is not extrapolated",
        stage + 1
    )]
    OutsideAxis {
        /// The stage, counted from 0.
        stage: usize,
        /// The coordinate: family and mode of the state, or the load's.
        role: ChapterRole,
        /// Its value, in the unit of the axis.
        value: f64,
        /// Smallest value on the axis.
        lower: f64,
        /// Largest value on the axis.
        upper: f64,
    },
}

impl From<FormatError> for ChapterBindError {
    fn from(error: FormatError) -> Self {
        Self::Bind(error.into())
    }
}
