//! Why there is no map in the chapter's representation.

use vademecum_format::scheme::TableError;

use vademecum_eval::{OutputError, StepError};
use vademecum_format::FormatError;

use crate::online::{ChapterBindError, ChapterLoadError, ChapterStepError};
use vademecum_build::basis::SnapshotError;
use vademecum_build::dynamics::MarchError;
use vademecum_build::fem::FactorError;
use vademecum_build::separated::SeparatedError;

/// Why there is no map in the chapter's representation.
#[derive(Debug, thiserror::Error)]
pub enum ChapterError {
    /// The runs that give the ranges of the axes failed.
    #[error(transparent)]
    Ranges(#[from] SnapshotError),
    /// The scheme refuses a parameter.
    #[error("`time.scheme`")]
    Table(#[from] TableError),
    /// A stage does not factorise.
    #[error("a matrix of the model does not factorise")]
    Factor(#[from] FactorError),
    /// The separation of a stage failed.
    #[error("the chapter's representation of a stage")]
    Separated(#[from] SeparatedError),
    /// The march of the certificate failed.
    #[error("certificate")]
    March(#[from] MarchError),
    /// The file that was built does not open.
    #[error("the file that was built does not open")]
    Format(#[from] FormatError),
    /// The file that was built does not bind.
    #[error("the file that was built does not bind")]
    Bind(#[from] ChapterBindError),
    /// A load of the certificate is refused.
    #[error("a load of the certificate is refused")]
    Load(#[from] ChapterLoadError),
    /// A step failed.
    #[error("a step failed")]
    Step(#[from] ChapterStepError),
    /// The energy of a state is refused.
    #[error("the energy of a state is refused")]
    Output(#[from] OutputError),
    /// The vectors of the basis depend on each other in the Euclidean product.
    #[error(
        "`canonical.projection` is \"euclidean\", in which the vectors of the basis depend on each other"
    )]
    DependentBasis,
    /// The eigenvalues of the linearised step did not converge.
    #[error("the eigenvalues of the linearised step did not converge")]
    Eigenvalues,
}

impl From<StepError> for ChapterError {
    fn from(error: StepError) -> Self {
        Self::Step(error.into())
    }
}
