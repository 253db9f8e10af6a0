//! Why a world of an assembly file cannot be marched.

use vademecum_build::input::toml_file::TomlError;
use vademecum_build::mesh::MeshError;
use vademecum_build::progress::Cancelled;
use vademecum_eval::{BindError, OutputError, WorldError};

use crate::error::AssemblyError;

/// Why a world of an assembly file cannot be marched.
#[derive(Debug, thiserror::Error)]
pub enum WorldRunError {
    /// The assembly file, or a file of a part.
    #[error(transparent)]
    Assembly(#[from] AssemblyError),
    /// The surface of a rigid body.
    #[error("part `{part}`")]
    Surface {
        /// The part.
        part: String,
        /// The reason.
        source: MeshError,
    },
    /// A file that cannot be bound.
    #[error("part `{part}`: the file cannot be bound")]
    Bind {
        /// The part.
        part: String,
        /// The reason.
        source: BindError,
    },
    /// A world of these parts that cannot be made.
    #[error("{subject}")]
    World {
        /// The part, joint or pair that it is about.
        subject: String,
        /// The reason.
        source: WorldError,
    },
    /// A step that was refused.
    #[error("after {time} s: {subject}")]
    Step {
        /// Time before the step \[s\].
        time: f64,
        /// The part that it is about, or the world.
        subject: String,
        /// The reason.
        source: WorldError,
    },
    /// A position that cannot be read.
    #[error("part `{part}`: its position")]
    Output {
        /// The part.
        part: String,
        /// The reason.
        source: OutputError,
    },
    /// A request to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl From<TomlError> for WorldRunError {
    fn from(error: TomlError) -> Self {
        Self::Assembly(error.into())
    }
}
