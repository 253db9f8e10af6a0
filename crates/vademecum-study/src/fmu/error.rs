//! Errors of the export of an FMU.

use vademecum_eval::BindError;
use vademecum_fmu::points::{LONGEST_NAME, MOST};
use vademecum_format::FormatError;
use vademecum_rewrite::RewriteError;

use crate::error::FileError;

/// Errors of the export of an FMU.
#[derive(Debug, thiserror::Error)]
pub enum FmuError {
    /// The file cannot be used.
    #[error(transparent)]
    File(#[from] FileError),
    /// A point is nowhere near the body.
    #[error(
        "the point `{name}` is {distance:.3e} away from the loadable surface of a body that is {size:.3e} \
         large; expected a point on it: is it in the unit of the file?"
    )]
    FarPoint {
        /// Its name.
        name: String,
        /// Distance to the loadable surface.
        distance: f64,
        /// Diagonal of the box around the body.
        size: f64,
    },
    /// A stress of a file that knows none.
    #[error(
        "the file knows no stress, so there is none for `{name}`; build it with `[output] stress = …` \
         (docs/how-to/stress.md)"
    )]
    NoStress {
        /// Its name.
        name: String,
    },
    /// A place of a stress is nowhere near one that is known.
    #[error(
        "the place `{name}` is {distance:.3e} away from the nearest node whose stress the file knows, of a \
         body that is {size:.3e} large; is it in the unit of the file, and in the selection of \
         `[output] stress`?"
    )]
    FarStress {
        /// Its name.
        name: String,
        /// Distance to the nearest node with a stress.
        distance: f64,
        /// Diagonal of the box around the body.
        size: f64,
    },
    /// A name that a point cannot have.
    #[error("`{name}` is no name of a point: expected 1 to {most} bytes without control characters", most = LONGEST_NAME)]
    BadName {
        /// The name.
        name: String,
    },
    /// Two variables of one name.
    #[error("there are two variables `{name}`; give one of them another name")]
    NameTwice {
        /// The name.
        name: String,
    },
    /// More points than an FMU holds.
    #[error("{found} points; an FMU holds at most {most}", most = MOST)]
    TooManyPoints {
        /// Requested number.
        found: usize,
    },
    /// Arrays in FMI 2.
    #[error("arrays need FMI 3; export with `--fmi 3 --surface`, or name points with `--point` for FMI 2")]
    ArraysOfThree,
    /// A number of surface nodes that the file does not have.
    #[error("{found} surface nodes; the loadable surface of the file has {known}, expected 1 to {known}")]
    SurfaceNodes {
        /// Requested number.
        found: usize,
        /// Nodes of the loadable surface.
        known: usize,
    },
    /// More surface nodes than an FMU holds.
    #[error("{found} surface nodes; an FMU holds at most {most}: ask for fewer, such as `--surface {most}`", most = MOST)]
    TooManySurfaceNodes {
        /// Requested number.
        found: usize,
    },
    /// There is nothing to put into the archive for some platform.
    #[error("an FMU needs a library for at least one platform")]
    NoPlatform,
    /// The archive could not be written.
    #[error("the archive")]
    Archive(#[from] zip::result::ZipError),
}

impl From<FormatError> for FmuError {
    fn from(error: FormatError) -> Self {
        Self::File(error.into())
    }
}

impl From<BindError> for FmuError {
    fn from(error: BindError) -> Self {
        Self::File(error.into())
    }
}

impl From<RewriteError> for FmuError {
    fn from(error: RewriteError) -> Self {
        Self::File(error.into())
    }
}
