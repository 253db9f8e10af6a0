//! Why a certificate could not be taken.

use vademecum_eval::{BindError, LoadError, OutputError, ParameterError, StepError};
use vademecum_format::FormatError;

use crate::dynamics::{FullOrderError, MarchError, ModesError, ReferenceError};
use crate::fem::{FactorError, PencilError};
use crate::parametric::ParametricError;
use crate::progress::Cancelled;
use crate::residual::ResidualError;

/// Why a certificate could not be taken.
#[derive(Debug, thiserror::Error)]
pub enum CertificateError {
    /// The full-order march failed.
    #[error("the certificate's full-order march")]
    March(#[from] MarchError),
    /// The full-order march at a corner of the box cannot start.
    #[error("the certificate's full-order march cannot start")]
    FullOrder(#[from] FullOrderError),
    /// The model in the space of the reference cannot be marched.
    #[error("the model in the space of the certificate's reference")]
    Space(#[from] PencilError),
    /// Its matrices do not factorise.
    #[error("the model in the space of the certificate's reference")]
    Factor(#[from] FactorError),
    /// The residual flexibility at a point of the box.
    #[error("the residual flexibility at a point of the box")]
    Residual(#[from] ResidualError),
    /// There is no motion exact in time to compare with.
    #[error("the certificate's reference")]
    Reference(#[from] ReferenceError),
    /// No first natural mode at a corner of the box.
    #[error("natural modes at a corner of the box")]
    Modes(#[from] ModesError),
    /// The file that was built does not open.
    #[error("the file that was built does not open")]
    Format(#[from] FormatError),
    /// The evaluator does not bind the file that was built.
    #[error("the evaluator does not bind the file that was built")]
    Bind(#[from] BindError),
    /// A corner lies outside the separated solution.
    #[error("a corner of the box lies outside the separated solution")]
    Parametric(#[from] ParametricError),
    /// The parametric model that was built cannot be set to a point of the box.
    #[error("a point of the box")]
    Model(#[from] vademecum_eval::ParametricError),
    /// The evaluator refuses a corner of the box.
    #[error("the evaluator refuses a value of a live parameter")]
    Parameter(#[from] ParameterError),
    /// The evaluator refuses a load.
    #[error("the evaluator refuses an unseen load")]
    Load(#[from] LoadError),
    /// The evaluator's step failed.
    #[error("the evaluator's step failed")]
    Step(#[from] StepError),
    /// The evaluator cannot tell the energy.
    #[error("the evaluator cannot tell the energy")]
    Output(#[from] OutputError),
    /// The eigenvalues of the step did not converge.
    #[error("the eigenvalues of the step did not converge")]
    Eigenvalues,
    /// On request.
    #[error("the certificate")]
    Cancelled(#[from] Cancelled),
}
