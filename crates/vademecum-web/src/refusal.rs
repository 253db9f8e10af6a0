//! Refusals of the module, in one type.

use thiserror::Error;
#[cfg(feature = "world")]
use vademecum_eval::WorldError;
use vademecum_eval::{BindError, LoadError, LocateError, OutputError, SavedError, StepError};

/// Reason of a refused call.
#[derive(Clone, Copy, Debug, Error)]
#[non_exhaustive]
pub enum Refusal {
    /// Options, parameters or lent memory do not fit the file.
    #[error(transparent)]
    Bind(#[from] BindError),
    /// A load cannot be applied.
    #[error(transparent)]
    Load(#[from] LoadError),
    /// There is no place nearest to a point, or it is too far away.
    #[error(transparent)]
    Locate(#[from] LocateError),
    /// A step or a state cannot be taken.
    #[error(transparent)]
    Step(#[from] StepError),
    /// An output cannot be read.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// A saved state cannot be restored.
    #[error(transparent)]
    Saved(#[from] SavedError),
    /// A tool was laid down where the body does not move exactly.
    #[error(
        "a tool to press with needs exact steps, and this body moves by the stages of another time scheme: \
         build the file with scheme = {{ name = \"exact\" }}, or push with a force"
    )]
    NoTool,
    /// A tool's radius, force, friction or speed is not a number it can have.
    #[error(
        "a sphere has a radius and a force above zero, a friction and a speed that are not below zero, and a \
         place"
    )]
    BadTool,
    /// A world cannot be made or stepped.
    #[cfg(feature = "world")]
    #[error(transparent)]
    World(#[from] WorldError),
    /// A step or a reading before the world was bound.
    #[cfg(feature = "world")]
    #[error("the world is not bound yet")]
    NoWorld,
    /// A part, joint or motion that this world has not, or that it cannot have any more.
    #[cfg(feature = "world")]
    #[error("this world has no such part or joint, the part does not move so, or the world is bound already")]
    BadPart,
    /// A hand that cannot pull.
    #[cfg(feature = "world")]
    #[error(
        "a hand has a member and a place on it, a stiffness above zero and a damping that is not below zero"
    )]
    BadPull,
    /// A saved state of another world.
    #[cfg(feature = "world")]
    #[error("the saved state is that of another world")]
    BadState,
}
