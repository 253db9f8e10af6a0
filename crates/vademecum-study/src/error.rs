//! Why a study ended without its figures.
//!
//! No error here names the vademecum file it is about: a study is handed bytes and does not know where they
//! came from. The caller, who knows, puts the name in front of a [`FileError`].

use vademecum_build::basis::{BasisError, SnapshotError};
use vademecum_build::certificate::CertificateError;
use vademecum_build::chapter::ChapterError;
use vademecum_build::dynamics::{FullOrderError, MarchError, ModesError, SchemeError, TooMuchWork};
use vademecum_build::fem::FactorError;
use vademecum_build::parametric::ParametricError;
use vademecum_build::pipeline::BuildError;
use vademecum_build::prepared::{BodyError, PrepareError, TimeStepError};
use vademecum_build::progress::Cancelled;
use vademecum_build::response::ResponseError;
use vademecum_eval::chapter::{ChapterBindError, ChapterLoadError, ChapterStepError};
use vademecum_eval::{BindError, LoadError, OpenError, OutputError, StepError};
use vademecum_format::scheme::TableError;
use vademecum_format::{FormatError, SectionKind};
use vademecum_rewrite::RewriteError;

/// Why a study ended without its figures.
#[derive(Debug, thiserror::Error)]
pub enum StudyError {
    /// A build behind it failed.
    #[error(transparent)]
    Build(#[from] BuildError),
    /// The full-order march failed.
    #[error(transparent)]
    March(#[from] MarchError),
    /// The scheme refuses a parameter.
    #[error("`time.scheme`")]
    Table(#[from] TableError),
    /// The scheme's parameters are unusable.
    #[error("`time.scheme`")]
    Scheme(#[from] SchemeError),
    /// A vademecum file cannot be used for what is asked.
    #[error(transparent)]
    File(#[from] FileError),
    /// The scenario has a load pattern that the file does not have.
    #[error("the file has no load pattern `{name}`; it has {known}")]
    NoPattern {
        /// The pattern's name.
        name: String,
        /// Names of the patterns there are, or `none`.
        known: String,
    },
    /// The file has a load pattern that the problem does not have.
    #[error("the problem has no load pattern `{name}`, the file has")]
    ForeignPattern {
        /// The pattern's name.
        name: String,
    },
    /// A push was asked for, and there is nothing to push.
    #[error("the body has no surface that a push could act on")]
    NothingToPush,
    /// Every number of modes asked for is more than the snapshots span.
    #[error("no number of modes is left to compare: the snapshots span {span} dimensions")]
    NoModes {
        /// What the snapshots span.
        span: usize,
    },
    /// The spectral radius of the step was not found.
    #[error("the spectral radius of the step")]
    Radius(#[from] CertificateError),
    /// On request.
    #[error("stopped on request")]
    Cancelled(#[from] Cancelled),
}

/// Why a vademecum file cannot be used for what is asked.
#[derive(Debug, thiserror::Error)]
pub enum FileError {
    /// It cannot be opened.
    #[error(transparent)]
    Open(#[from] OpenError),
    /// It is refused, or a section of it is.
    #[error(transparent)]
    Format(#[from] FormatError),
    /// Its sections cannot be decoded or rewritten.
    #[error(transparent)]
    Rewrite(#[from] RewriteError),
    /// The evaluator does not bind it.
    #[error(transparent)]
    Bind(#[from] BindError),
    /// The evaluator refuses a load.
    #[error(transparent)]
    Load(#[from] LoadError),
    /// The evaluator's step failed.
    #[error(transparent)]
    Step(#[from] StepError),
    /// The evaluator has no such output.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// The evaluator does not bind its chapter's structure.
    #[error(transparent)]
    BindChapter(#[from] ChapterBindError),
    /// The evaluator refuses a load on the chapter's structure.
    #[error(transparent)]
    LoadChapter(#[from] ChapterLoadError),
    /// The evaluator's step of the chapter's structure failed.
    #[error(transparent)]
    StepChapter(#[from] ChapterStepError),
    /// The chapter's structure takes no load patterns.
    #[error("the chapter's structure is built for loads at nodes and takes no load patterns")]
    NoPatterns,
    /// It does not have a section.
    #[error("the file has no section {kind}")]
    Missing {
        /// The section.
        kind: SectionKind,
    },
    /// It has no surface that takes contacts.
    #[error("the file has no loadable surface, so contacts cannot act")]
    NoSurface,
    /// It was built on another mesh than the problem has.
    #[error("the file belongs to another mesh than {problem}")]
    ForeignMesh {
        /// The problem's file.
        problem: String,
    },
    /// It has a node that the mesh does not have.
    #[error("node {id} is not in the mesh")]
    ForeignNode {
        /// The node's id in the mesh file.
        id: u64,
    },
    /// `BᵀMB` is not positive definite.
    #[error("the columns of the basis are not independent")]
    DependentColumns,
    /// A scenario needs what the file does not have.
    #[error("the scenario has {what}, which needs section {kind}, and the new file does not have it")]
    Needed {
        /// The section.
        kind: SectionKind,
        /// What of the scenario.
        what: String,
    },
}

/// Stages of a build that a study runs by itself fail as the build does.
macro_rules! as_build {
    ($($error:ty),*) => {
        $(impl From<$error> for StudyError {
            fn from(error: $error) -> Self {
                Self::Build(error.into())
            }
        })*
    };
}

as_build!(
    TooMuchWork,
    TimeStepError,
    PrepareError,
    BasisError,
    ModesError,
    FullOrderError,
    ResponseError,
    ParametricError,
    ChapterError
);

/// What the evaluator and the rewriting say of a file is about the file.
macro_rules! as_file {
    ($($error:ty),*) => {
        $(impl From<$error> for StudyError {
            fn from(error: $error) -> Self {
                Self::File(error.into())
            }
        })*
    };
}

as_file!(
    FormatError,
    RewriteError,
    BindError,
    LoadError,
    StepError,
    OutputError,
    ChapterBindError,
    ChapterLoadError,
    ChapterStepError
);

impl From<BodyError> for StudyError {
    fn from(error: BodyError) -> Self {
        PrepareError::from(error).into()
    }
}

impl From<SnapshotError> for StudyError {
    fn from(error: SnapshotError) -> Self {
        BasisError::from(error).into()
    }
}

impl From<FactorError> for StudyError {
    fn from(error: FactorError) -> Self {
        BasisError::from(error).into()
    }
}
