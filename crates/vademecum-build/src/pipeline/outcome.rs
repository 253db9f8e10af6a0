//! A finished build, within its tolerance or not.

use crate::report::{BuildReport, ToleranceMissed};

/// A finished build.
pub struct Built {
    /// The file.
    pub bytes: Vec<u8>,
    /// The report of what was done and measured.
    pub report: BuildReport,
}

/// The end of a build.
pub enum Outcome {
    /// A structure of the file keeps the tolerance.
    Kept(Built),
    /// No structure does. The file is whole, and its certificate says by how much it misses.
    Missed(Built),
}

impl Outcome {
    /// The file, if it keeps its tolerance.
    ///
    /// # Errors
    /// [`ToleranceMissed`], with the report of what was built.
    pub fn kept(self) -> Result<Built, ToleranceMissed> {
        match self {
            Self::Kept(built) => Ok(built),
            Self::Missed(built) => Err(ToleranceMissed(Box::new(built.report))),
        }
    }

    /// The file, whether it keeps its tolerance or not.
    pub fn either(self) -> Built {
        match self {
            Self::Kept(built) | Self::Missed(built) => built,
        }
    }
}
