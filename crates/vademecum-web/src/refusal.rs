//! What a session refuses, in one type.

use core::fmt;

use vademecum_eval::{BindError, LoadError, OutputError, StepError};

/// Why the session refused.
#[derive(Clone, Copy, Debug)]
pub enum Refusal {
    /// Options or lent memory do not fit the file.
    Bind(BindError),
    /// A load cannot be applied.
    Load(LoadError),
    /// A step or a state cannot be taken.
    Step(StepError),
    /// An output cannot be read.
    Output(OutputError),
    /// A tool was laid down where the body does not move exactly.
    NoTool,
    /// A tool's radius, force, friction or speed is not a number it can have.
    BadTool,
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Bind(error) => error.fmt(f),
            Self::Load(error) => error.fmt(f),
            Self::Step(error) => error.fmt(f),
            Self::Output(error) => error.fmt(f),
            Self::NoTool => f.write_str(
                "a tool to press with needs exact steps, and this body moves by the stages of another time \
                 scheme: build the file with scheme = { name = \"exact\" }, or push with a force",
            ),
            Self::BadTool => f.write_str(
                "a sphere has a radius and a force above zero, a friction and a speed that are not below zero, \
                 and a place",
            ),
        }
    }
}

impl core::error::Error for Refusal {}

macro_rules! from_error {
    ($($kind:ident <- $error:ty),*) => {
        $(impl From<$error> for Refusal {
            fn from(error: $error) -> Self {
                Self::$kind(error)
            }
        })*
    };
}
from_error!(Bind <- BindError, Load <- LoadError, Step <- StepError, Output <- OutputError);
