//! Errors of a calibration.

use std::path::PathBuf;

use crate::error::StudyError;

/// Why parameters are not calibrated.
#[derive(Debug, thiserror::Error)]
pub enum CalibrateError {
    /// The file, the scenario or the march.
    #[error(transparent)]
    Study(#[from] StudyError),
    /// A table of measured numbers that cannot be read.
    #[error("{}: {source}", .path.display())]
    Unreadable {
        /// The table.
        path: PathBuf,
        /// The cause.
        source: std::io::Error,
    },
    /// A line of a table that cannot be used.
    #[error("{}:{line}: {found}; expected {expected}", .path.display())]
    Line {
        /// The table.
        path: PathBuf,
        /// The line, counted from 1.
        line: usize,
        /// What is there.
        found: String,
        /// What should be.
        expected: String,
    },
    /// A table that does not go with the other arguments.
    #[error("{}: {reason}", .path.display())]
    Table {
        /// The table.
        path: PathBuf,
        /// What does not go together, and what to do.
        reason: String,
    },
    /// A file without live parameters of regions.
    #[error(
        "the file has no live parameters to calibrate; build it with `representation = \"parametric\"` and a \
         `[[parameter]]` for each unknown"
    )]
    NotParametric,
    /// A parameter that cannot be calibrated, or no parameter at all.
    #[error("{reason}")]
    Parameters {
        /// What is asked for, and what can be.
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
