//! Why bytes are not a vademecum file: one variant per numbered refusal of `formats/vademecum-1.md`.

use crate::scheme::TableError;
use core::fmt;
use thiserror::Error;

/// A refusal; numbers only, the sentence is made by `Display`.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum FormatError {
    /// 1: fewer bytes than the header or the directory needs.
    #[error("{found} bytes where at least {needed} are needed; the file is cut: copy or build it again")]
    TooShort {
        /// Bytes given.
        found: u64,
        /// Bytes needed to go on.
        needed: u64,
    },
    /// 2: the first eight bytes are not the magic.
    #[error("not a vademecum file: the first eight bytes are not 89 56 44 4D 0D 0A 1A 0A")]
    Magic,
    /// 3: a major version this reader does not know.
    #[error("file version {found}, this reader knows version 1; use a newer program or build the file again")]
    MajorVersion {
        /// The file's.
        found: u16,
    },
    /// 4: the header does not match its checksum.
    #[error(
        "the header has checksum {found:#010x}, written is {expected:#010x}: damaged, copy or build the file again"
    )]
    HeaderChecksum {
        /// Computed from the bytes.
        found: u32,
        /// Written in the file.
        expected: u32,
    },
    /// 5: bytes that must be zero are not (header, directory entry or padding).
    #[error("byte {offset} is padding and must be zero; the file is damaged")]
    NotZero {
        /// Place in the file, in bytes from its start.
        offset: u64,
    },
    /// 6: the file is longer or shorter than it says.
    #[error("{found} bytes, the file says {expected}; copy or build it again")]
    FileLength {
        /// Bytes given.
        found: u64,
        /// Length by the header or the last section.
        expected: u64,
    },
    /// 7: more sections than the limit.
    #[error("{found} sections, the limit is {limit}")]
    SectionCount {
        /// The file's.
        found: u32,
        /// The most there may be.
        limit: u32,
    },
    /// 8: the metadata do not follow the directory.
    #[error("metadata at byte {found}, they must follow the directory at byte {expected}")]
    MetadataOffset {
        /// The file's.
        found: u64,
        /// Their required place.
        expected: u64,
    },
    /// 9: metadata longer than the limit or than the file.
    #[error("metadata of {found} bytes, the limit is {limit}")]
    MetadataLength {
        /// The file's.
        found: u64,
        /// The most there may be.
        limit: u64,
    },
    /// 10: the directory does not match its checksum.
    #[error(
        "the directory has checksum {found:#010x}, written is {expected:#010x}: damaged, copy or build the file again"
    )]
    DirectoryChecksum {
        /// Computed from the bytes.
        found: u32,
        /// Written in the file.
        expected: u32,
    },
    /// 11: the metadata do not match their checksum.
    #[error(
        "the metadata has checksum {found:#010x}, written is {expected:#010x}: damaged, copy or build the file again"
    )]
    MetadataChecksum {
        /// Computed from the bytes.
        found: u32,
        /// Written in the file.
        expected: u32,
    },
    /// 12: the metadata are not the encoding of a [`crate::Metadata`] of exactly this length.
    #[error(
        "of {length} bytes of metadata {understood} could be understood; the writer is not ours or newer"
    )]
    MetadataEncoding {
        /// Bytes understood; 0 when decoding failed.
        understood: u64,
        /// Bytes there are.
        length: u64,
    },
    /// 13: a count is out of its range.
    #[error("the number of {what} is {found}, expected {lower} to {upper}")]
    Count {
        /// Which.
        what: Quantity,
        /// The file's.
        found: u32,
        /// Smallest allowed.
        lower: u32,
        /// Largest allowed.
        upper: u32,
    },
    /// 14: a metadata number is not finite or out of its range.
    #[error("{what} is {found:e}: not finite or out of its range")]
    Number {
        /// Which.
        what: Quantity,
        /// Its value.
        found: f64,
    },
    /// 15: the time scheme is not consistent.
    #[error("the file's time scheme is refused: {0}")]
    Scheme(TableError),
    /// 16: an axis is malformed (range, number of points, or data in an unused place).
    #[error("axis {axis} is malformed: check its range and number of points")]
    Axis {
        /// Its place.
        axis: u32,
    },
    /// 17: no structure of the step is present.
    #[error(
        "neither the diagonal, nor the block, nor the canonical, nor the strain structure is present: \
         nothing to step with"
    )]
    NoStructure,
    /// 18: a required section of a kind this reader does not know.
    #[error("a required section of kind {kind} is unknown to this reader; use a newer program")]
    UnknownKind {
        /// The kind.
        kind: u32,
    },
    /// 19: a known section with an unknown element type, or one its kind may not have.
    #[error("section {kind} has element type {found}, which its kind may not have")]
    Element {
        /// The section's kind.
        kind: u32,
        /// The element code.
        found: u8,
    },
    /// 20: a known section with an unknown codec.
    #[error("section {kind} has codec {found}, unknown to this reader")]
    Codec {
        /// The section's kind.
        kind: u32,
        /// The codec.
        found: u8,
    },
    /// 21: flags this version does not define.
    #[error("section {kind} has flags {found:#06x}; only bit 0 is defined")]
    Flags {
        /// The section's kind.
        kind: u32,
        /// The flags.
        found: u16,
    },
    /// 22: two sections of the same kind.
    #[error("two sections of kind {kind}; one is allowed")]
    Duplicate {
        /// The kind.
        kind: u32,
    },
    /// 23: a section does not begin at the first multiple of 64 after the previous one.
    #[error("section {kind} at byte {found}, expected at byte {expected}")]
    Offset {
        /// The section's kind.
        kind: u32,
        /// The file's.
        found: u64,
        /// Its required start.
        expected: u64,
    },
    /// 24: a section's length disagrees with its shape, its codec or the file.
    #[error("section {kind} has {found} bytes, expected {expected} by its shape and the file's length")]
    Length {
        /// The section's kind.
        kind: u32,
        /// The file's.
        found: u64,
        /// Length by shape and element type.
        expected: u64,
    },
    /// 25: a section's shape disagrees with the metadata.
    #[error("shape of section {kind}, place {axis}: {found}, the metadata ask for {expected}")]
    Shape {
        /// The section's kind.
        kind: u32,
        /// Which of the three numbers.
        axis: u8,
        /// The file's.
        found: u64,
        /// Number by the metadata.
        expected: u64,
    },
    /// 26: a section is missing that an announced structure or parameter needs.
    #[error("section {kind} is missing, an announced structure or parameter needs it")]
    Missing {
        /// The kind of the section.
        kind: u32,
    },
    /// 27: a section does not match its checksum.
    #[error("section {kind} has checksum {found:#010x}, written is {expected:#010x}: damaged, copy it again")]
    SectionChecksum {
        /// The section's kind.
        kind: u32,
        /// Computed from the bytes.
        found: u32,
        /// Written in the file.
        expected: u32,
    },
    /// 28: a compressed section is asked for its numbers.
    #[error("section {kind} is compressed (codec {codec}); unpack it before reading its numbers")]
    Compressed {
        /// The section's kind.
        kind: u32,
        /// Its codec.
        codec: u8,
    },
    /// 29: a section of text is not UTF-8.
    #[error("section {kind} is not UTF-8 text")]
    Text {
        /// The section's kind.
        kind: u32,
    },
    /// 30: the memory lent to the writer is too short.
    #[error("{found} bytes were lent to the writer, {needed} are needed")]
    LentMemory {
        /// Bytes lent.
        found: u64,
        /// Bytes needed.
        needed: u64,
    },
    /// 31: a parameter is malformed (range, region, a name or role used twice, or data in an unused place).
    #[error(
        "parameter {parameter} is malformed: check its range, its region, and that its name and role are \
         its own"
    )]
    Parameter {
        /// Its place.
        parameter: u32,
    },
    /// 32: a part of the canonical structure is malformed, or a stage lacks one (state and load, together or
    /// apart).
    #[error("part {part} of the canonical structure is malformed or missing")]
    CanonicalPart {
        /// Its place; the number of parts where one is missing.
        part: u32,
    },
    /// 33: an axis of the canonical structure is malformed, out of order, or of no part.
    #[error("axis {axis} of the canonical structure is malformed: role, order, range, points or factor")]
    CanonicalAxis {
        /// Its place.
        axis: u32,
    },
    /// 34: a section of the canonical structure has not the numbers its parts ask for.
    #[error("section {kind} has {found} numbers, the parts of the canonical structure ask for {expected}")]
    CanonicalLength {
        /// The section's kind.
        kind: u32,
        /// Numbers found.
        found: u64,
        /// Numbers the parts ask for.
        expected: u64,
    },
    /// 35: a load position is no loadable node, or the load's direction is missing, not finite or one too
    /// many.
    #[error("load position {place} is no loadable node, or the load's direction is wrong")]
    CanonicalLoad {
        /// Its place; the number of positions for the direction.
        place: u32,
    },
    /// 36: the table of a section coded by block is cut, not increasing, or does not end where the section
    /// does.
    #[error("section {kind}: the table of its blocks is wrong at block {block}; the file is damaged")]
    BlockTable {
        /// The section's kind.
        kind: u32,
        /// The block.
        block: u64,
    },
    /// 37: what should be one zstd frame of the decoded length is not.
    #[error("section {kind}, block {block}: not one zstd frame of the declared length; the file is damaged")]
    Frame {
        /// The section's kind.
        kind: u32,
        /// The block; 0 for a section that is one frame.
        block: u64,
    },
    /// 38: an index is not below what it counts.
    #[error("section {kind}, number {place}: index {found} of {count}; the file is damaged")]
    Index {
        /// The section's kind.
        kind: u32,
        /// Its place, counted from 0.
        place: u64,
        /// Its value.
        found: u32,
        /// What it counts.
        count: u64,
    },
}

/// Subject of a [`FormatError::Count`] or [`FormatError::Number`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Quantity {
    /// `n_nodes`.
    Nodes,
    /// `n_surface_nodes`.
    SurfaceNodes,
    /// `n_load_nodes`.
    LoadNodes,
    /// `n_triangles`.
    Triangles,
    /// `n_load_triangles`.
    LoadTriangles,
    /// `n_modes`.
    Modes,
    /// `n_patterns`.
    Patterns,
    /// `n_probes`.
    Probes,
    /// `n_axes`.
    Axes,
    /// `n_terms`.
    Terms,
    /// `n_regions`.
    Regions,
    /// `n_parameters`.
    Parameters,
    /// `time_step`.
    TimeStep,
    /// `alpha`.
    Alpha,
    /// `beta`.
    Beta,
    /// A number of the certificate.
    Certificate,
    /// Coordinates of the strain structure that interact.
    Interacting,
    /// Coordinates of the strain structure that couple with these.
    Coupled,
    /// Rows of the strain structure.
    StrainRows,
    /// Sub-steps of a step of the strain structure.
    Substeps,
}

impl fmt::Display for Quantity {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.pad(match self {
            Self::Nodes => "nodes",
            Self::SurfaceNodes => "surface nodes",
            Self::LoadNodes => "loadable nodes",
            Self::Triangles => "triangles",
            Self::LoadTriangles => "loadable triangles",
            Self::Modes => "modes",
            Self::Patterns => "load patterns",
            Self::Probes => "probes",
            Self::Axes => "axes",
            Self::Terms => "terms",
            Self::Regions => "regions",
            Self::Parameters => "parameters",
            Self::TimeStep => "the time step",
            Self::Alpha => "alpha",
            Self::Beta => "beta",
            Self::Certificate => "a certificate number",
            Self::Interacting => "coordinates that interact",
            Self::Coupled => "coordinates that couple with those that interact",
            Self::StrainRows => "strain rows",
            Self::Substeps => "sub-steps of a step",
        })
    }
}

impl From<TableError> for FormatError {
    fn from(error: TableError) -> Self {
        Self::Scheme(error)
    }
}
