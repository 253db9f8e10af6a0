//! Errors of the chapter's structure beside those of any structure.

use core::fmt;

use crate::base::error::{BindError, LoadError, StepError};
use crate::base::lend::Short;
use vademecum_format::{ChapterRole, FormatError};

/// Why a scene of the chapter's structure could not be bound.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum ChapterBindError {
    /// As for any scene.
    Bind(BindError),
    /// The file does not have the chapter's structure.
    NoChapter,
    /// The structure was built for the file's time step, damping and scales and for all its terms, and the
    /// options ask for others.
    Fixed,
}

/// Why a load was not added; the accumulated loads are unchanged.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum ChapterLoadError {
    /// As for any scene.
    Load(LoadError),
    /// The file was built for loads in one direction, and this is another.
    OtherDirection,
    /// The load can stand at listed nodes, and this is none of them.
    NotAPosition {
        /// The node, in file order.
        node: u32,
    },
    /// State and load are in the same terms, so there can be one load, whole at one node.
    OneContact,
    /// Magnitude or component is not on its axis.
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
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum ChapterStepError {
    /// As for any scene.
    Step(StepError),
    /// A coordinate has left the range its axis was built for.
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

impl fmt::Display for ChapterBindError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Bind(error) => error.fmt(out),
            Self::NoChapter => {
                write!(out, "the file does not have the chapter's structure: bind an ordinary scene")
            }
            Self::Fixed => write!(
                out,
                "the canonical structure holds one time step, damping and scale and all its terms: leave \
                 the options at the file's"
            ),
        }
    }
}

impl fmt::Display for ChapterLoadError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Load(error) => error.fmt(out),
            Self::OtherDirection => write!(
                out,
                "the canonical structure was built for loads in one direction, and this is another"
            ),
            Self::NotAPosition { node } => write!(
                out,
                "node {node} is no load position of the canonical structure; its section 27 lists them"
            ),
            Self::OneContact => write!(
                out,
                "the canonical structure has state and load in the same terms: one load, whole at one node"
            ),
            Self::OutsideAxis { role, value, lower, upper } => outside(out, role, value, lower, upper),
        }
    }
}

impl fmt::Display for ChapterStepError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Step(error) => error.fmt(out),
            Self::OutsideAxis { stage, role, value, lower, upper } => {
                write!(out, "stage {}: ", stage + 1)?;
                outside(out, role, value, lower, upper)
            }
        }
    }
}

fn outside(
    out: &mut fmt::Formatter<'_>,
    role: ChapterRole,
    value: f64,
    lower: f64,
    upper: f64,
) -> fmt::Result {
    write!(out, "{role} is {value:e}, outside its axis from {lower:e} to {upper:e}; it is not extrapolated")
}

impl core::error::Error for ChapterBindError {}
impl core::error::Error for ChapterLoadError {}
impl core::error::Error for ChapterStepError {}

impl From<BindError> for ChapterBindError {
    fn from(error: BindError) -> Self {
        Self::Bind(error)
    }
}

impl From<FormatError> for ChapterBindError {
    fn from(error: FormatError) -> Self {
        Self::Bind(error.into())
    }
}

impl From<Short> for ChapterBindError {
    fn from(short: Short) -> Self {
        Self::Bind(short.into())
    }
}

impl From<LoadError> for ChapterLoadError {
    fn from(error: LoadError) -> Self {
        Self::Load(error)
    }
}

impl From<Short> for ChapterLoadError {
    fn from(short: Short) -> Self {
        Self::Load(short.into())
    }
}

impl From<StepError> for ChapterStepError {
    fn from(error: StepError) -> Self {
        Self::Step(error)
    }
}

impl From<Short> for ChapterStepError {
    fn from(short: Short) -> Self {
        Self::Step(short.into())
    }
}
