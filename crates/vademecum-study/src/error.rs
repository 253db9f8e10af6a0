//! Why a study ended without its figures.

use vademecum_build::basis::{BasisError, SnapshotError};
use vademecum_build::chapter::ChapterError;
use vademecum_build::dynamics::{FullOrderError, MarchError, ModesError, SchemeError};
use vademecum_build::fem::FactorError;
use vademecum_build::parametric::ParametricError;
use vademecum_build::pipeline::BuildError;
use vademecum_build::prepared::{BodyError, PrepareError};
use vademecum_build::response::ResponseError;
use vademecum_format::FormatError;
use vademecum_format::scheme::TableError;

/// Why a study ended without its figures.
#[derive(Debug, thiserror::Error)]
pub enum StudyError {
    /// A build behind it failed.
    #[error(transparent)]
    Build(#[from] BuildError),
    /// The full-order march failed.
    #[error("the full-order march")]
    March(#[from] MarchError),
    /// The scheme refuses a parameter.
    #[error("`time.scheme`")]
    Table(#[from] TableError),
    /// The scheme's parameters are unusable.
    #[error("`time.scheme`")]
    Scheme(#[from] SchemeError),
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
    PrepareError,
    BasisError,
    ModesError,
    FullOrderError,
    ResponseError,
    ParametricError,
    ChapterError,
    FormatError
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
