//! A refusal: its status and its words.

use core::fmt::{self, Display, Formatter};

use vademecum_eval::format::FormatError;
use vademecum_eval::{BindError, LoadError, LocateError, OutputError, SavedError, StepError};

#[cfg(feature = "world")]
use vademecum_eval::WorldError;

use crate::types::VdmStatus;

/// Answer of a call to its caller.
pub type Answer = Result<VdmStatus, Refusal>;

/// Reason of a refused call.
pub enum Refusal {
    /// A pointer of this name is null or not aligned.
    Null(&'static str),
    /// Refusals of this interface, which the evaluator does not know.
    Words(VdmStatus, &'static str),
    /// Fewer bytes of memory than are needed.
    Memory { found: usize, needed: usize },
    /// The bytes are no file.
    File(FormatError),
    /// The file does not allow the options or a value.
    Bind(BindError),
    /// A load.
    Load(LoadError),
    /// A step.
    Step(StepError),
    /// A point of the surface.
    Locate(LocateError),
    /// Something that is read.
    Output(OutputError),
    /// A saved state.
    Saved(SavedError),
    /// A world, or its step.
    #[cfg(feature = "world")]
    World(WorldError),
}

impl Refusal {
    pub const fn status(&self) -> VdmStatus {
        match self {
            Self::Null(_) => VdmStatus::VDM_ARGUMENT,
            Self::Words(status, _) => *status,
            Self::Memory { .. } => VdmStatus::VDM_MEMORY,
            Self::File(_) => VdmStatus::VDM_FILE,
            Self::Bind(_) => VdmStatus::VDM_BIND,
            Self::Load(LoadError::NoRoom) => VdmStatus::VDM_MEMORY,
            Self::Load(_) => VdmStatus::VDM_LOAD,
            Self::Step(_) => VdmStatus::VDM_STEP,
            Self::Locate(LocateError::NoSurface) | Self::Output(_) => VdmStatus::VDM_OUTPUT,
            Self::Locate(_) => VdmStatus::VDM_LOAD,
            Self::Saved(_) => VdmStatus::VDM_STATE,
            #[cfg(feature = "world")]
            Self::World(error) => match error {
                WorldError::LentMemory { .. } => VdmStatus::VDM_MEMORY,
                WorldError::Step(_) => VdmStatus::VDM_STEP,
                WorldError::Load(_) => VdmStatus::VDM_LOAD,
                _ => VdmStatus::VDM_WORLD,
            },
        }
    }
}

impl Display for Refusal {
    fn fmt(&self, out: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Self::Null(name) => write!(out, "`{name}` is a null pointer, or not aligned"),
            Self::Words(_, words) => out.write_str(words),
            Self::Memory { found, needed } => write!(
                out,
                "{found} bytes of memory were lent, {needed} are needed; ask again with the same options"
            ),
            Self::File(error) => error.fmt(out),
            Self::Bind(error) => error.fmt(out),
            Self::Load(LoadError::NoRoom) => {
                out.write_str("there is no room for kept loads; bind with VdmOptions.keep_loads = 1")
            }
            Self::Load(error) => error.fmt(out),
            Self::Step(error) => error.fmt(out),
            Self::Locate(error) => error.fmt(out),
            Self::Output(error) => error.fmt(out),
            Self::Saved(error) => error.fmt(out),
            #[cfg(feature = "world")]
            Self::World(error) => error.fmt(out),
        }
    }
}

/// Makes an error of the evaluator a refusal.
macro_rules! refused {
    ($($error:ty => $refusal:ident),*) => {
        $(impl From<$error> for Refusal {
            fn from(error: $error) -> Self {
                Self::$refusal(error)
            }
        })*
    };
}

refused!(
    FormatError => File, BindError => Bind, LoadError => Load, LocateError => Locate, StepError => Step,
    OutputError => Output, SavedError => Saved
);

#[cfg(feature = "world")]
refused!(WorldError => World);

/// The value behind a pointer, or a refusal that names it.
pub fn needed<T>(found: Option<T>, name: &'static str) -> Result<T, Refusal> {
    found.ok_or(Refusal::Null(name))
}
