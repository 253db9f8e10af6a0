//! Why there is no map in the chapter's representation.

use vademecum_format::scheme::TableError;

use vademecum_eval::chapter::{ChapterBindError, ChapterLoadError, ChapterStepError};
use vademecum_eval::{OutputError, StepError};
use vademecum_format::FormatError;

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
    /// The evaluator does not bind the file that was built.
    #[error("the evaluator does not bind the file that was built")]
    Bind(#[from] ChapterBindError),
    /// The evaluator refuses a load of the certificate.
    #[error("the evaluator refuses a load of the certificate")]
    Load(#[from] ChapterLoadError),
    /// The evaluator's step failed.
    #[error("the evaluator's step failed")]
    Step(#[from] ChapterStepError),
    /// The evaluator cannot tell the energy.
    #[error("the evaluator cannot tell the energy")]
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
