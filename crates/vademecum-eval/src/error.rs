//! What can go wrong, apart by who can act: binding (options or memory), loading, stepping, reading.

use core::fmt;
use vademecum_format::scheme::SchemeError;
use vademecum_format::{FormatError, SectionKind};

/// Why a scene could not be bound.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum BindError {
    /// The file is refused, or a section it needs is compressed.
    Format(FormatError),
    /// Scheme or step parameters are refused.
    Scheme(SchemeError),
    /// The structure asked for is not in the file.
    NoStructure,
    /// The block structure was built for other parameters: no axis carries what the options change.
    Fixed {
        /// The stage.
        stage: usize,
        /// `θ` \[s²\] the options ask for.
        requested: f64,
        /// `θ` the file was built for.
        built: f64,
    },
    /// A parameter lies outside its axis (or between the points of an index axis).
    OutsideAxis {
        /// The axis.
        axis: usize,
        /// The value.
        value: f64,
    },
    /// An axis has a role or kind this evaluator does not know.
    UnknownAxis {
        /// The axis.
        axis: usize,
    },
    /// Memory lent to the scene, the state or the loads is too short.
    LentMemory {
        /// Numbers lent.
        found: usize,
        /// Numbers needed.
        needed: usize,
    },
    /// The rest threshold or the tolerance is negative or not a number.
    BadOption {
        /// Its value.
        value: f64,
    },
    /// A coefficient of the fused step is not finite in the chosen precision.
    NotFinite,
}

/// Why a load was not added; the accumulated loads are unchanged.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum LoadError {
    /// A force, weight or amplitude is not finite.
    NotFinite,
    /// The node is not loadable.
    NotLoadable {
        /// The node, in file order.
        node: u32,
        /// Loadable nodes.
        limit: u32,
    },
    /// There is no such pattern.
    NoPattern {
        /// The pattern.
        index: usize,
        /// Patterns in the file.
        count: usize,
    },
    /// A section this needs is not in the file, or is compressed.
    Missing {
        /// Its kind.
        kind: SectionKind,
    },
    /// The loads were made for a scene of another shape.
    Mismatch,
}

/// Why a step was not taken; the state is unchanged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum StepError {
    /// The new state is not finite: a load too large, or a state set too large, for the precision.
    NotFinite,
    /// State or loads were made for a scene of another shape, or given numbers have the wrong length.
    Mismatch,
}

/// Why an output could not be given.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum OutputError {
    /// A section this needs is not in the file, or is compressed.
    Missing {
        /// Its kind.
        kind: SectionKind,
    },
    /// There is no such probe or node.
    OutOfRange {
        /// The index.
        index: usize,
        /// How many there are.
        count: usize,
    },
    /// The output slice has the wrong length.
    Length {
        /// Its length.
        found: usize,
        /// The length needed.
        needed: usize,
    },
    /// The state was made for a scene of another shape.
    Mismatch,
}

impl fmt::Display for BindError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Format(error) => error.fmt(out),
            Self::Scheme(error) => error.fmt(out),
            Self::NoStructure => write!(
                out,
                "the file does not hold the structure asked for; choose the other or build it"
            ),
            Self::Fixed {
                stage,
                requested,
                built,
            } => write!(
                out,
                "stage {stage} needs theta = {requested:e} s², the block structure was built for {built:e}: \
                 keep the file's time step, damping and scales, or use the diagonal structure"
            ),
            Self::OutsideAxis { axis, value } => write!(
                out,
                "{value:e} is not on axis {axis}; the file's ranges are in its metadata"
            ),
            Self::UnknownAxis { axis } => write!(
                out,
                "axis {axis} is of a role or kind unknown to this evaluator"
            ),
            Self::LentMemory { found, needed } => {
                write!(out, "{found} numbers were lent, {needed} are needed")
            }
            Self::BadOption { value } => write!(
                out,
                "tolerance or rest threshold {value:e}: expected 0 or more"
            ),
            Self::NotFinite => write!(
                out,
                "the fused step is not finite in this precision; use f64"
            ),
        }
    }
}

impl fmt::Display for LoadError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::NotFinite => write!(out, "a force, weight or amplitude is not finite"),
            Self::NotLoadable { node, limit } => write!(
                out,
                "node {node} is not loadable; the first {limit} nodes are"
            ),
            Self::NoPattern { index, count } => write!(
                out,
                "there is no load pattern {index}; the file has {count}"
            ),
            Self::Missing { kind } => missing(out, kind),
            Self::Mismatch => write!(out, "these loads belong to a scene of another shape"),
        }
    }
}

impl fmt::Display for StepError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::NotFinite => write!(
                out,
                "the new state is not finite; the old one was kept: reduce the load"
            ),
            Self::Mismatch => write!(
                out,
                "state, loads or numbers belong to a scene of another shape"
            ),
        }
    }
}

impl fmt::Display for OutputError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Missing { kind } => missing(out, kind),
            Self::OutOfRange { index, count } => write!(out, "index {index} of {count}"),
            Self::Length { found, needed } => write!(
                out,
                "an output of {found} numbers was lent, {needed} are written"
            ),
            Self::Mismatch => write!(out, "this state belongs to a scene of another shape"),
        }
    }
}

fn missing(out: &mut fmt::Formatter<'_>, kind: SectionKind) -> fmt::Result {
    write!(
        out,
        "section {} ({kind:?}) is not in the file or is compressed",
        kind.number()
    )
}

impl core::error::Error for BindError {}
impl core::error::Error for LoadError {}
impl core::error::Error for StepError {}
impl core::error::Error for OutputError {}

impl From<FormatError> for BindError {
    fn from(error: FormatError) -> Self {
        Self::Format(error)
    }
}

impl From<SchemeError> for BindError {
    fn from(error: SchemeError) -> Self {
        Self::Scheme(error)
    }
}
