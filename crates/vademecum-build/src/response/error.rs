//! Why a stage has no response.

use vademecum_format::scheme::TableError;

use crate::fem::FactorError;

/// Why a stage has no response.
#[derive(Debug, thiserror::Error)]
pub enum ResponseError {
    /// The scheme refuses a parameter.
    #[error("`time.scheme`")]
    Table(#[from] TableError),
    /// `M + θK` does not factorise.
    #[error("a matrix of the model does not factorise")]
    Factor(#[from] FactorError),
}
