//! Why bodies cannot be joined.

use std::path::PathBuf;

use vademecum_build::input::toml_file::TomlError;
use vademecum_eval::{ParametricError, PartFault};
use vademecum_format::{FormatError, SectionKind};
use vademecum_rewrite::RewriteError;

/// Why bodies cannot be joined.
#[derive(Debug, thiserror::Error)]
pub enum AssemblyError {
    /// The assembly file.
    #[error(transparent)]
    File(#[from] TomlError),
    /// A file of a part cannot be read.
    #[error("part `{part}`: cannot read {}", path.display())]
    Unreadable {
        /// The part.
        part: String,
        /// Its file.
        path: PathBuf,
        /// The reason.
        source: std::io::Error,
    },
    /// A file of a part is none, or damaged.
    #[error("part `{part}`: {}", path.display())]
    Part {
        /// The part.
        part: String,
        /// Its file.
        path: PathBuf,
        /// The reason.
        source: RewriteError,
    },
    /// A parametric model that cannot be set.
    #[error("part `{part}`: its live parameters")]
    Parameters {
        /// The part.
        part: String,
        /// The reason.
        #[source]
        fault: ParametricError,
    },
    /// A file of a part is not one that is joined.
    #[error("part `{part}`: the file {found}; expected {expected}")]
    Kind {
        /// The part.
        part: String,
        /// Its property.
        found: String,
        /// The file that is needed.
        expected: &'static str,
    },
    /// A section that joining needs.
    #[error("part `{part}`: the file has no section {kind}; build it with `[[port]]`, and do not strip it")]
    Missing {
        /// The part.
        part: String,
        /// The section.
        kind: SectionKind,
    },
    /// Sections of a part that do not fit one another.
    #[error("part `{part}`: {fault}")]
    Fault {
        /// The part.
        part: String,
        /// Its fault.
        fault: PartFault,
    },
    /// Rows of joints that follow from others.
    #[error(
        "joint `{joint}`: its rows follow from those of joints before it, or both sides are held; expected joints \
         that do not hold a motion twice"
    )]
    Redundant {
        /// The joint.
        joint: String,
    },
    /// A body that is not held.
    #[error(
        "the joined body moves freely in {motions} ways: part {parts} has no path of joints to a support; hold one \
         of the parts, or join it to `ground`"
    )]
    Free {
        /// Number of motions without stiffness.
        motions: usize,
        /// Parts that move.
        parts: String,
    },
    /// Numbers that double precision does not hold.
    #[error("the eigenproblem of the joined body does not converge")]
    NoConvergence,
    /// The joined file cannot be written.
    #[error("the joined file")]
    Format(#[from] FormatError),
}
