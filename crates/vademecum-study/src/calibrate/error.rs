//! Errors of a calibration.

use crate::error::StudyError;
use crate::table::TableFileError;

/// Why parameters are not calibrated.
#[derive(Debug, thiserror::Error)]
pub enum CalibrateError {
    /// The file, the scenario or the march.
    #[error(transparent)]
    Study(#[from] StudyError),
    /// A table of measured numbers.
    #[error(transparent)]
    Table(#[from] TableFileError),
    /// A file without live parameters of regions.
    #[error(
        "the file has no live parameters to calibrate; build it with `representation = \"parametric\"` and a \
         `[[parameter]]` for each unknown"
    )]
    NotParametric,
    /// A parameter that cannot be calibrated, or no parameter at all.
    #[error("{reason}")]
    Parameters {
        /// The names asked for, and those that there are.
        reason: String,
    },
    /// Fewer measured numbers than parameters.
    #[error(
        "{numbers} measured numbers for {parameters} parameters; expected more numbers than parameters: name fewer \
         with `--fit`, or give more data"
    )]
    TooFew {
        /// Measured numbers.
        numbers: usize,
        /// Parameters to fit.
        parameters: usize,
    },
    /// A prediction that is not finite, or derivatives without a decomposition.
    #[error("the derivatives of the predictions are not finite at {at}")]
    NotFinite {
        /// Names and values of the parameters.
        at: String,
    },
}
