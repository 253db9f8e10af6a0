//! Why a separation over the parameters ends without a solution.

use vademecum_format::scheme::TableError;

use crate::progress::Cancelled;
use crate::separated::SeparatedError;

/// Why there are no separated responses.
#[derive(Debug, thiserror::Error)]
pub enum ParametricError {
    /// The separation itself.
    #[error("the separated solution")]
    Separated(#[from] SeparatedError),
    /// The scheme refuses a parameter.
    #[error("`parameter`")]
    Scheme(#[from] TableError),
    /// No response at any point of the box is a number.
    #[error("no response over the box of the live parameters is a number: check ranges, units and materials")]
    NoExpansion,
    /// On request.
    #[error("the separation over the parameters")]
    Cancelled(#[from] Cancelled),
}
