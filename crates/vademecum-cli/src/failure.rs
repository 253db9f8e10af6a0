//! Every way a command can fail: one exit code per cause, the chain of causes, and what to do.

use std::error::Error;
use std::fmt;
use std::path::Path;
use std::process::ExitCode;

use vademecum_build::basis::BasisError;
use vademecum_build::dynamics::ModesError;
use vademecum_build::input::ProblemError;
use vademecum_build::mesh::MeshError;
use vademecum_build::pipeline::BuildError;
use vademecum_build::prepared::{BodyError, PrepareError};
use vademecum_build::progress::is_cancelled;
use vademecum_build::report::ToleranceMissed;
use vademecum_study::StudyError;
use vademecum_study::scenario::ScenarioError;

/// What to do about a mesh that cannot be used.
const MESH: &str = "`vademecum mesh FILE` shows what the file holds and every problem found";

/// A failed command.
#[derive(Debug)]
pub struct Failure {
    cause: Cause,
    error: Box<dyn Error>,
    remedy: Option<String>,
}

/// Who can act.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cause {
    /// The machine: disk, memory, permissions.
    Machine = 1,
    /// The problem or scenario file.
    Input = 3,
    /// The mesh.
    Mesh = 4,
    /// The model: a matrix that does not factorise, modes that do not converge.
    Numerics = 5,
    /// A tolerance is missed.
    Tolerance = 6,
    /// The vademecum file.
    File = 7,
    /// Ctrl-C.
    Stopped = 130,
}

impl Failure {
    /// A failure with its cause.
    pub fn new(cause: Cause, error: impl Into<Box<dyn Error>>) -> Self {
        Self { cause, error: error.into(), remedy: None }
    }

    /// Adds what to do.
    pub fn remedy(mut self, text: impl Into<String>) -> Self {
        self.remedy = Some(text.into());
        self
    }

    /// A file that cannot be read or written.
    pub fn io(path: &Path, error: std::io::Error) -> Self {
        Self::new(Cause::Machine, format!("{}: {error}", path.display()))
            .remedy("check that the folder exists, that you may write there, and that the disk has room")
    }

    /// A vademecum file that cannot be used.
    pub fn file(path: &Path, error: impl fmt::Display) -> Self {
        Self::new(Cause::File, format!("{}: {error}", path.display()))
    }

    /// The process's exit code.
    pub fn exit_code(&self) -> ExitCode {
        ExitCode::from(self.cause as u8)
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "error: {}", self.error)?;
        let mut source = self.error.source();
        let mut said = self.error.to_string();
        while let Some(error) = source {
            let text = error.to_string();
            if !said.contains(&text) {
                write!(f, "\n  because: {text}")?;
            }
            said = text;
            source = error.source();
        }
        match &self.remedy {
            Some(remedy) => write!(f, "\n  try: {remedy}"),
            None => Ok(()),
        }
    }
}

impl From<ProblemError> for Failure {
    fn from(error: ProblemError) -> Self {
        Self::new(Cause::Input, error).remedy("see formats/problem-1.md for every key and its range")
    }
}

impl From<ScenarioError> for Failure {
    fn from(error: ScenarioError) -> Self {
        Self::new(Cause::Input, error).remedy("see formats/scenario-1.md for every key and its range")
    }
}

impl From<MeshError> for Failure {
    fn from(error: MeshError) -> Self {
        Self::new(Cause::Mesh, error).remedy(MESH)
    }
}

impl From<BuildError> for Failure {
    fn from(error: BuildError) -> Self {
        const KEYS: &str = "see formats/problem-1.md for every key and its range";
        if is_cancelled(&error) {
            return Self::new(Cause::Stopped, "stopped on request; nothing was written");
        }
        let (cause, remedy) = match &error {
            BuildError::Prepare(PrepareError::Body(BodyError::Mesh(_))) => (Cause::Mesh, MESH),
            BuildError::Prepare(PrepareError::Body(BodyError::Model(_))) => (
                Cause::Numerics,
                "check `[[support]]` (all six rigid motions must be held) and `[[material]]`",
            ),
            BuildError::Modes(ModesError::LostInRounding { .. })
            | BuildError::Basis(BasisError::Modes(ModesError::LostInRounding { .. })) => (
                Cause::Numerics,
                "hold every part of the body; thicken or refine what is a thousand times as long as thick",
            ),
            BuildError::Prepare(PrepareError::NotDefinite { .. }) => {
                (Cause::Numerics, "leave held dofs and dofs without mass out of the matrices")
            }
            BuildError::Prepare(PrepareError::Factor(_)) => (Cause::Numerics, ""),
            BuildError::Prepare(_) => (Cause::Input, KEYS),
            BuildError::Basis(BasisError::Snapshots(_) | BasisError::TooManyModes { .. }) => {
                (Cause::Input, "")
            }
            BuildError::Format(_) => (Cause::File, ""),
            _ => (Cause::Numerics, ""),
        };
        let failure = Self::new(cause, error);
        if remedy.is_empty() { failure } else { failure.remedy(remedy) }
    }
}

impl From<PrepareError> for Failure {
    fn from(error: PrepareError) -> Self {
        BuildError::from(error).into()
    }
}

impl From<StudyError> for Failure {
    fn from(error: StudyError) -> Self {
        match error {
            StudyError::Build(error) => error.into(),
            error if is_cancelled(&error) => {
                Self::new(Cause::Stopped, "stopped on request; nothing was written")
            }
            error => Self::new(Cause::Numerics, error),
        }
    }
}

impl From<ToleranceMissed> for Failure {
    fn from(error: ToleranceMissed) -> Self {
        Self::new(Cause::Tolerance, error).remedy(
            "more `basis.modes` or `basis.oversampling`, more `snapshots.positions`, or `--keep-missed` to write it all the same",
        )
    }
}
