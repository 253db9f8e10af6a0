//! Why a build ended without a file.

use vademecum_format::FormatError;

use crate::basis::BasisError;
use crate::certificate::CertificateError;
use crate::chapter::ChapterError;
use crate::dynamics::{FullOrderError, ModesError, TooMuchWork};
use crate::fem::FactorError;
use crate::limits::TooMuchMemory;
use crate::parametric::ParametricError;
use crate::prepared::{PrepareError, TimeStepError};
use crate::residual::ResidualError;
use crate::response::ResponseError;

/// Why a build ended without a file, by stage.
#[derive(Debug, thiserror::Error)]
pub enum BuildError {
    /// The problem cannot be computed with.
    #[error(transparent)]
    Prepare(#[from] PrepareError),
    /// More memory than there is.
    #[error(transparent)]
    Memory(#[from] TooMuchMemory),
    /// More full-order work than was asked for by name.
    #[error(transparent)]
    Work(#[from] TooMuchWork),
    /// A time step that does not fit the body.
    #[error(transparent)]
    TimeStep(#[from] TimeStepError),
    /// No first natural mode.
    #[error("natural modes")]
    Modes(#[from] ModesError),
    /// The full-order march cannot start.
    #[error("the full-order march cannot start")]
    FullOrder(#[from] FullOrderError),
    /// No basis.
    #[error(transparent)]
    Basis(#[from] BasisError),
    /// No static residual.
    #[error("the static residual")]
    Residual(#[from] ResidualError),
    /// No factor of the stiffness for whole fields.
    #[error("the factor of the stiffness, for whole fields")]
    Factor(#[from] FactorError),
    /// A stage has no response.
    #[error(transparent)]
    Response(#[from] ResponseError),
    /// The separated solution over the parameters failed.
    #[error("the separated solution over the parameters")]
    Parametric(#[from] ParametricError),
    /// The chapter's representation failed.
    #[error("the chapter's representation")]
    Chapter(#[from] ChapterError),
    /// The certificate could not be taken.
    #[error(transparent)]
    Certificate(#[from] CertificateError),
    /// The file cannot hold what was built.
    #[error("the file cannot hold what was built")]
    Format(#[from] FormatError),
}
