//! Why a world of an assembly file cannot be marched.

use vademecum_build::input::toml_file::TomlError;
use vademecum_build::mesh::MeshError;
use vademecum_build::progress::Cancelled;
use vademecum_eval::{BindError, OutputError, WorldError};

use crate::error::AssemblyError;
use crate::file::AssemblyFile;

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

/// The part, pair or joint of a world that an error is about.
pub(crate) fn subject(file: &AssemblyFile, error: &WorldError) -> String {
    match *error {
        WorldError::Member { member, .. } => {
            file.parts.get(member).map_or("the ground".into(), |part| format!("part `{}`", part.name))
        }
        WorldError::Pair { pair } => file.contacts.get(pair).map_or("a pair".into(), |contact| {
            format!("contact of `{}` and `{}`", contact.between[0], contact.between[1])
        }),
        WorldError::Joint { joint } | WorldError::Redundant { joint } => {
            file.joints.get(joint).map_or("a joint".into(), |entry| format!("joint `{}`", entry.name(joint)))
        }
        _ => "the world".into(),
    }
}
