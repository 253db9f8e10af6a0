//! Why bytes are not a vademecum file: one variant per numbered refusal of `formats/vademecum-1.md`.

use crate::scheme::TableError;
use core::fmt;

/// A refusal; numbers only, the sentence is made by `Display`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum FormatError {
    /// 1: fewer bytes than the header or the directory needs.
    TooShort {
        /// Bytes given.
        found: u64,
        /// Bytes needed to go on.
        needed: u64,
    },
    /// 2: the first eight bytes are not the magic.
    Magic,
    /// 3: a major version this reader does not know.
    MajorVersion {
        /// The file's.
        found: u16,
    },
    /// 4: the header does not match its checksum.
    HeaderChecksum {
        /// Computed from the bytes.
        found: u32,
        /// Written in the file.
        expected: u32,
    },
    /// 5: bytes that must be zero are not (header, directory entry or padding).
    NotZero {
        /// Where in the file, in bytes from its start.
        offset: u64,
    },
    /// 6: the file is longer or shorter than it says.
    FileLength {
        /// Bytes given.
        found: u64,
        /// What the header or the last section says.
        expected: u64,
    },
    /// 7: more sections than the limit.
    SectionCount {
        /// The file's.
        found: u32,
        /// The most there may be.
        limit: u32,
    },
    /// 8: the metadata do not follow the directory.
    MetadataOffset {
        /// The file's.
        found: u64,
        /// Where they must be.
        expected: u64,
    },
    /// 9: metadata longer than the limit or than the file.
    MetadataLength {
        /// The file's.
        found: u64,
        /// The most there may be.
        limit: u64,
    },
    /// 10: the directory does not match its checksum.
    DirectoryChecksum {
        /// Computed from the bytes.
        found: u32,
        /// Written in the file.
        expected: u32,
    },
    /// 11: the metadata do not match their checksum.
    MetadataChecksum {
        /// Computed from the bytes.
        found: u32,
        /// Written in the file.
        expected: u32,
    },
    /// 12: the metadata are not the encoding of a [`crate::Metadata`] of exactly this length.
    MetadataEncoding {
        /// Bytes understood; 0 when decoding failed.
        understood: u64,
        /// Bytes there are.
        length: u64,
    },
    /// 13: a count is out of its range.
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
    Number {
        /// Which.
        what: Quantity,
        /// Its value.
        found: f64,
    },
    /// 15: the time scheme is not consistent.
    Scheme(TableError),
    /// 16: an axis is malformed (range, number of points, or data in an unused place).
    Axis {
        /// Its place.
        axis: u32,
    },
    /// 17: no structure of the step is present.
    NoStructure,
    /// 18: a required section of a kind this reader does not know.
    UnknownKind {
        /// The kind.
        kind: u32,
    },
    /// 19: a known section with an unknown element type, or one its kind may not have.
    Element {
        /// The section's kind.
        kind: u32,
        /// The element code.
        found: u8,
    },
    /// 20: a known section with an unknown codec.
    Codec {
        /// The section's kind.
        kind: u32,
        /// The codec.
        found: u8,
    },
    /// 21: flags this version does not define.
    Flags {
        /// The section's kind.
        kind: u32,
        /// The flags.
        found: u16,
    },
    /// 22: two sections of the same kind.
    Duplicate {
        /// The kind.
        kind: u32,
    },
    /// 23: a section does not begin at the first multiple of 64 after the previous one.
    Offset {
        /// The section's kind.
        kind: u32,
        /// The file's.
        found: u64,
        /// Where it must begin.
        expected: u64,
    },
    /// 24: a section's length disagrees with its shape, its codec or the file.
    Length {
        /// The section's kind.
        kind: u32,
        /// The file's.
        found: u64,
        /// What follows from shape and element type.
        expected: u64,
    },
    /// 25: a section's shape disagrees with the metadata.
    Shape {
        /// The section's kind.
        kind: u32,
        /// Which of the three numbers.
        axis: u8,
        /// The file's.
        found: u64,
        /// What the metadata ask for.
        expected: u64,
    },
    /// 26: a section is missing that an announced structure or parameter needs.
    Missing {
        /// The kind of the section.
        kind: u32,
    },
    /// 27: a section does not match its checksum.
    SectionChecksum {
        /// The section's kind.
        kind: u32,
        /// Computed from the bytes.
        found: u32,
        /// Written in the file.
        expected: u32,
    },
    /// 28: a compressed section is asked for its numbers.
    Compressed {
        /// The section's kind.
        kind: u32,
        /// Its codec.
        codec: u8,
    },
    /// 29: a section of text is not UTF-8.
    Text {
        /// The section's kind.
        kind: u32,
    },
    /// 30: the memory lent to the writer is too short.
    LentMemory {
        /// Bytes lent.
        found: u64,
        /// Bytes needed.
        needed: u64,
    },
    /// 31: a parameter is malformed (range, region, a name or role used twice, or data in an unused place).
    Parameter {
        /// Its place.
        parameter: u32,
    },
    /// 32: a part of the canonical structure is malformed, or a stage lacks one (state and load, together or
    /// apart).
    CanonicalPart {
        /// Its place; the number of parts where one is missing.
        part: u32,
    },
    /// 33: an axis of the canonical structure is malformed, out of order, or of no part.
    CanonicalAxis {
        /// Its place.
        axis: u32,
    },
    /// 34: a section of the canonical structure has not the numbers its parts ask for.
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
    CanonicalLoad {
        /// Its place; the number of positions for the direction.
        place: u32,
    },
    /// 36: the table of a section coded by block is cut, not increasing, or does not end where the section
    /// does.
    BlockTable {
        /// The section's kind.
        kind: u32,
        /// The block.
        block: u64,
    },
    /// 37: what should be one zstd frame of the decoded length is not.
    Frame {
        /// The section's kind.
        kind: u32,
        /// The block; 0 for a section that is one frame.
        block: u64,
    },
}

/// What a [`FormatError::Count`] or [`FormatError::Number`] speaks of.
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

impl fmt::Display for FormatError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        use FormatError as E;
        match *self {
            E::TooShort { found, needed } => {
                write!(
                    out,
                    "{found} bytes where at least {needed} are needed; the file is cut: copy or build it \
                     again"
                )
            }
            E::Magic => {
                write!(out, "not a vademecum file: the first eight bytes are not 89 56 44 4D 0D 0A 1A 0A")
            }
            E::MajorVersion { found } => {
                write!(
                    out,
                    "file version {found}, this reader knows version 1; use a newer program or build the \
                     file again"
                )
            }
            E::HeaderChecksum { found, expected } => checksum(out, "the header", found, expected),
            E::NotZero { offset } => {
                write!(out, "byte {offset} is padding and must be zero; the file is damaged")
            }
            E::FileLength { found, expected } => {
                write!(out, "{found} bytes, the file says {expected}; copy or build it again")
            }
            E::SectionCount { found, limit } => {
                write!(out, "{found} sections, the limit is {limit}")
            }
            E::MetadataOffset { found, expected } => {
                write!(out, "metadata at byte {found}, they must follow the directory at byte {expected}")
            }
            E::MetadataLength { found, limit } => {
                write!(out, "metadata of {found} bytes, the limit is {limit}")
            }
            E::DirectoryChecksum { found, expected } => checksum(out, "the directory", found, expected),
            E::MetadataChecksum { found, expected } => checksum(out, "the metadata", found, expected),
            E::MetadataEncoding { understood, length } => {
                write!(
                    out,
                    "of {length} bytes of metadata {understood} could be understood; the writer is not \
                     ours or newer"
                )
            }
            E::Count { what, found, lower, upper } => {
                write!(out, "the number of {} is {found}, expected {lower} to {upper}", what.name())
            }
            E::Number { what, found } => {
                write!(out, "{} is {found:e}: not finite or out of its range", what.name())
            }
            E::Scheme(error) => write!(out, "the file's time scheme is refused: {error}"),
            E::Axis { axis } => write!(out, "axis {axis} is malformed: check its range and number of points"),
            E::NoStructure => {
                write!(
                    out,
                    "neither the diagonal, nor the block, nor the canonical, nor the strain structure is \
                     present: nothing to step with"
                )
            }
            E::UnknownKind { kind } => {
                write!(
                    out,
                    "a required section of kind {kind} is unknown to this reader; use a newer program"
                )
            }
            E::Element { kind, found } => {
                write!(out, "section {kind} has element type {found}, which its kind may not have")
            }
            E::Codec { kind, found } => {
                write!(out, "section {kind} has codec {found}, unknown to this reader")
            }
            E::Flags { kind, found } => {
                write!(out, "section {kind} has flags {found:#06x}; only bit 0 is defined")
            }
            E::Duplicate { kind } => write!(out, "two sections of kind {kind}; one is allowed"),
            E::Offset { kind, found, expected } => {
                write!(out, "section {kind} at byte {found}, expected at byte {expected}")
            }
            E::Length { kind, found, expected } => {
                write!(
                    out,
                    "section {kind} has {found} bytes, expected {expected} by its shape and the file's length"
                )
            }
            E::Shape { kind, axis, found, expected } => {
                write!(out, "shape of section {kind}, place {axis}: {found}, the metadata ask for {expected}")
            }
            E::Missing { kind } => {
                write!(out, "section {kind} is missing, an announced structure or parameter needs it")
            }
            E::SectionChecksum { kind, found, expected } => {
                write!(
                    out,
                    "section {kind} has checksum {found:#010x}, written is {expected:#010x}: damaged, \
                     copy it again"
                )
            }
            E::Compressed { kind, codec } => {
                write!(
                    out,
                    "section {kind} is compressed (codec {codec}); unpack it before reading its numbers"
                )
            }
            E::Text { kind } => write!(out, "section {kind} is not UTF-8 text"),
            E::LentMemory { found, needed } => {
                write!(out, "{found} bytes were lent to the writer, {needed} are needed")
            }
            E::BlockTable { kind, block } => {
                write!(
                    out,
                    "section {kind}: the table of its blocks is wrong at block {block}; the file is damaged"
                )
            }
            E::Frame { kind, block } => {
                write!(
                    out,
                    "section {kind}, block {block}: not one zstd frame of the declared length; the file \
                     is damaged"
                )
            }
            E::Parameter { parameter } => write!(
                out,
                "parameter {parameter} is malformed: check its range, its region, and that its name and \
                 role are its own"
            ),
            E::CanonicalPart { part } => {
                write!(out, "part {part} of the canonical structure is malformed or missing")
            }
            E::CanonicalAxis { axis } => {
                write!(
                    out,
                    "axis {axis} of the canonical structure is malformed: role, order, range, points or \
                     factor"
                )
            }
            E::CanonicalLength { kind, found, expected } => {
                write!(
                    out,
                    "section {kind} has {found} numbers, the parts of the canonical structure ask for \
                     {expected}"
                )
            }
            E::CanonicalLoad { place } => {
                write!(out, "load position {place} is no loadable node, or the load's direction is wrong")
            }
        }
    }
}

fn checksum(out: &mut fmt::Formatter<'_>, what: &str, found: u32, expected: u32) -> fmt::Result {
    write!(
        out,
        "{what} has checksum {found:#010x}, written is {expected:#010x}: damaged, copy or build the file \
         again"
    )
}

impl core::error::Error for FormatError {}

impl Quantity {
    fn name(self) -> &'static str {
        match self {
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
        }
    }
}

impl From<TableError> for FormatError {
    fn from(error: TableError) -> Self {
        Self::Scheme(error)
    }
}
