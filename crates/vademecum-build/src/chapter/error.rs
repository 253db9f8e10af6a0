//! Why there is no map in the chapter's representation.

use vademecum_format::scheme::SchemeError as TableError;

use crate::basis::SnapshotError;
use crate::dynamics::MarchError;
use crate::fem::FactorError;
use crate::separated::SeparatedError;

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
}
