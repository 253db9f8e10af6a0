//! Errors of a state-space model.

use crate::error::{FileError, StudyError};

/// Reasons why there is no state-space model of a file.
#[derive(Debug, thiserror::Error)]
pub enum StateSpaceError {
    /// A study failed.
    #[error(transparent)]
    Study(#[from] StudyError),
    /// Large displacements.
    #[error(
        "the file has large displacements, whose step is not linear in its state: build the problem without \
         `model = \"large-displacement\"` for its linear motion"
    )]
    LargeDisplacements,
    /// The chapter's representation.
    #[error(
        "the file has the chapter's representation, whose step is a separated function of the load's place and \
         of the state, not matrices: build the problem without `representation`"
    )]
    Chapter,
    /// A step that is not exact in time.
    #[error(
        "the step of the {structure} structure is that of a time scheme, and there is no exact discrete map: \
         {remedy}"
    )]
    NotExact {
        /// Structure.
        structure: &'static str,
        /// Remedy.
        remedy: &'static str,
    },
    /// Nothing acts.
    #[error(
        "there is no input: the file has no load pattern; name a point and a direction such as 1,0.04,0.1,-z"
    )]
    NoInputs,
    /// Nothing is read.
    #[error(
        "there is no output: the file has neither probes nor reactions; name a point and a direction such as \
         1,0.04,0.1,-z"
    )]
    NoOutputs,
    /// A signal is given twice.
    #[error("the {side} `{name}` is given twice; expected each once")]
    Twice {
        /// `input` or `output`.
        side: &'static str,
        /// Its name.
        name: String,
    },
    /// No stress.
    #[error(
        "the file has no stress; add `[output] stress = \"surface\"` to the problem file and build it again"
    )]
    NoStress,
    /// Stress at a node of two regions.
    #[error(
        "the node at ({x:.6}, {y:.6}, {z:.6}) lies between two regions and has a stress in each; expected a \
         place inside of a region"
    )]
    BetweenRegions {
        /// Coordinate.
        x: f64,
        /// Coordinate.
        y: f64,
        /// Coordinate.
        z: f64,
    },
    /// The file has no reaction of a support.
    #[error(
        "the file has no reaction of support `{name}`; known: {known}. `[output] reactions = true` in the problem \
         file gives a file its reactions"
    )]
    NoSupport {
        /// Name.
        name: String,
        /// Known names, or `none`.
        known: String,
    },
}

impl From<FileError> for StateSpaceError {
    fn from(error: FileError) -> Self {
        Self::Study(error.into())
    }
}
