//! Errors of setting live parameters.

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
    /// No parameter of this number.
    #[error("parameter {index} of {count}")]
    Index {
        /// The number asked for.
        index: usize,
        /// Number of parameters.
        count: usize,
    },
    /// A parameter set twice at once.
    #[error("parameter {index} is set twice at once")]
    Twice {
        /// Its number.
        index: usize,
    },
    /// A value outside of the range that the file was built for.
    #[error("parameter {index} = {found}; the file was built for {lower} to {upper}")]
    Range {
        /// Its number.
        index: usize,
        /// The value asked for.
        found: f64,
        /// Smallest value.
        lower: f64,
        /// Largest value.
        upper: f64,
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
    /// The file at these values cannot be written.
    #[error("the file at these values: {0}")]
    Format(#[from] FormatError),
}
