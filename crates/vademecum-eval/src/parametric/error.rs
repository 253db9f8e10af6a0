//! Errors of setting live parameters.

use crate::base::error::{BindError, ParameterError};
use thiserror::Error;
use vademecum_format::{FormatError, LiveError, SectionKind};

/// Why live parameters are not set. Nothing is changed then.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum ParametricError {
    /// The file has no live parameters of regions.
    #[error("the file has no parametric reduced-order model; build it with live regions")]
    NotParametric,
    /// Sections of the parameters that do not fit.
    #[error(transparent)]
    Live(#[from] LiveError),
    /// A parameter that there is not, one that is set twice, or a value out of its range.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// More or fewer values than the file has parameters.
    #[error("{found} values of parameters; expected {needed}")]
    Values {
        /// Values given.
        found: usize,
        /// Parameters of the file.
        needed: usize,
    },
    /// No body of this number in a batch.
    #[error("body {body} of a batch of {bodies}")]
    NoBody {
        /// The number asked for.
        body: usize,
        /// Bodies of the batch.
        bodies: usize,
    },
    /// A batch of another file.
    #[error("the batch was made for a file of other parameters or vectors")]
    OtherModel,
    /// Numbers along the basis that are too few, too many or not finite.
    #[error("{found} numbers along the basis; expected {needed} that are finite")]
    Forces {
        /// As many as were given.
        found: usize,
        /// Vectors of the basis.
        needed: usize,
    },
    /// A number of stepped modes that there is not.
    #[error("{found} stepped modes; expected 1 to {most}")]
    Modes {
        /// As many as were asked for.
        found: usize,
        /// As many as the file has.
        most: usize,
    },
    /// Fewer stepped modes than the basis has, where all are needed.
    #[error("{found} stepped modes; a derivative of a shape needs all {all} of the basis")]
    NotAllModes {
        /// As many as are stepped.
        found: usize,
        /// As many as the basis has.
        all: usize,
    },
    /// No probe, load pattern or node of this number.
    #[error("row {index} of section {section}, which has {count}")]
    Row {
        /// The section.
        section: SectionKind,
        /// The number asked for.
        index: usize,
        /// Number of rows.
        count: usize,
    },
    /// Two modes of one eigenvalue, whose shapes have no derivative of their own.
    #[error("modes {first} and {second} have the same frequency: their shapes have no derivative")]
    EqualModes {
        /// The lower mode, counted from 0.
        first: usize,
        /// The other.
        second: usize,
    },
    /// Derivatives of motion where regions have loss factors.
    #[error(
        "regions of the file have loss factors, whose damping ratios follow the modes: their motion has no \
             derivatives here"
    )]
    LossFactors,
    /// Derivatives of motion where dashpots couple the modes.
    #[error("dashpots couple the modes of the file: their motion has no derivatives here")]
    Dashpots,
    /// The eigenproblem does not converge, or a matrix is not definite.
    #[error("the eigenproblem at these values has no solution: matrices of the file are not definite")]
    NoConvergence,
    /// Memory that is too short.
    #[error("{found} {what} were lent, {needed} are needed")]
    LentMemory {
        /// Bytes of the file, numbers of memory or of work.
        what: &'static str,
        /// As many as were lent.
        found: usize,
        /// As many as are needed.
        needed: usize,
    },
    /// The body at these values cannot be bound.
    #[error(transparent)]
    Bind(BindError),
    /// The file at these values cannot be written.
    #[error("the file at these values: {0}")]
    Format(#[from] FormatError),
}

impl From<ParametricError> for BindError {
    fn from(error: ParametricError) -> Self {
        match error {
            ParametricError::Parameter(error) => error.into(),
            ParametricError::Bind(error) => error,
            ParametricError::Format(error) | ParametricError::Live(LiveError::Format(error)) => error.into(),
            ParametricError::Modes { found, most } => Self::TooLarge { what: "modes", asked: found, most },
            ParametricError::LentMemory { found, needed, .. } => Self::LentMemory { found, needed },
            _ => Self::LiveParameters,
        }
    }
}
