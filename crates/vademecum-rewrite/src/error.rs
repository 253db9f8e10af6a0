//! Why a file was not rewritten.

use thiserror::Error;
use vademecum_format::{FormatError, SectionKind};

use super::keep::Keep;

/// Why a file was not rewritten or did not pass its check.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum RewriteError {
    /// The file is refused, or a section does not match its checksum.
    #[error(transparent)]
    Format(#[from] FormatError),
    /// The file holds optional sections of a later version, which rewriting would lose.
    #[error("{count} section(s) are of a kind this program does not know, and rewriting would lose them")]
    Unknown {
        /// Their number.
        count: usize,
    },
    /// The file does not have the sections to keep.
    #[error("to keep {keep}, the file needs section {kind}, which it does not have{}", Self::cure(*kind))]
    Absent {
        /// The section.
        kind: SectionKind,
        /// The choice of sections to keep.
        keep: Keep,
    },
    /// The file holds no more than what is to be kept.
    #[error("the file holds nothing beside {keep}: there is nothing to strip")]
    NothingToStrip {
        /// The choice of sections to keep.
        keep: Keep,
    },
    /// The file has no term that could be dropped.
    #[error("none of the {terms} terms can be dropped within the tolerance")]
    NoTerms {
        /// Terms of the block structure; 0 without one.
        terms: usize,
    },
    /// A compression level zstd does not have.
    #[error("compression level {level} is not in 1 to 22")]
    Level {
        /// The level.
        level: i32,
    },
    /// A tolerance no rounding is made for.
    #[error("tolerance {tolerance} is not in 1e-12 to 0.1")]
    Tolerance {
        /// The tolerance.
        tolerance: f64,
    },
    /// Sections would decode to more than the limit.
    #[error(
        "what is needed of the file decodes to {declared} bytes, most of them section {kind}; the limit is \
         {limit}"
    )]
    TooLarge {
        /// The largest section.
        kind: SectionKind,
        /// Bytes the directory declares.
        declared: u64,
        /// The limit.
        limit: u64,
    },
    /// A section's stored bytes are not one zstd frame of the declared length.
    #[error("section {kind} is not one zstd frame of {declared} bytes: {reason}")]
    Frame {
        /// The section.
        kind: SectionKind,
        /// Its decoded length.
        declared: u64,
        /// The fault, in words.
        reason: String,
    },
    /// The compressor failed.
    #[error("zstd cannot compress a section: {reason}")]
    Compress {
        /// Its message.
        reason: &'static str,
    },
    /// The machine has too little memory.
    #[error("the machine has no memory for {bytes} bytes more")]
    Memory {
        /// Bytes asked for.
        bytes: u64,
    },
    /// A number is infinite or not a number.
    #[error("section {kind}: number {place} is {value}")]
    NotFinite {
        /// The section.
        kind: SectionKind,
        /// Its place, counted from 0.
        place: usize,
        /// Its value.
        value: f64,
    },
    /// Names are too few, too many, empty or the same.
    #[error("section {kind}: {reason}")]
    Names {
        /// The section.
        kind: SectionKind,
        /// The fault, in words.
        reason: String,
    },
    /// A section says what cannot be, or what another section contradicts.
    #[error("section {kind}: {reason}")]
    Unsound {
        /// The section.
        kind: SectionKind,
        /// Kind of the fault.
        fault: Fault,
        /// Place of the fault, found and expected values.
        reason: String,
    },
    /// A certificate in the metadata says what cannot be.
    #[error("the certificate of the {structure} structure: {reason}")]
    Certificate {
        /// The structure.
        structure: &'static str,
        /// Found and expected values.
        reason: String,
    },
    /// The points of an axis do not increase, or leave its range.
    #[error("section AxisPoints: axis {axis} is not increasing within its range")]
    Points {
        /// The axis, counted from 0.
        axis: usize,
    },
}

impl RewriteError {
    /// The way to a file that has a section.
    const fn cure(kind: SectionKind) -> &'static str {
        match kind {
            SectionKind::ProbeRows => ": build it with an `[[output.probe]]`",
            _ => "",
        }
    }
}

/// Faults of sections whose every number is finite.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Fault {
    /// A number is so large that its square overflows.
    Magnitude,
    /// Things that must differ are the same: ids, corners, triangles, columns, or all nodes.
    Twice,
    /// A column of the basis is zero or follows from the others.
    Dependent,
    /// A matrix that must be symmetric is not.
    NotSymmetric,
    /// A number that must not be negative is.
    Negative,
    /// It contradicts another section.
    Disagrees,
    /// A quantised number is none that a writer makes.
    Quantised,
}
