//! What a vademecum file is, byte for byte, and what its numbers mean.
//!
//! The builder writes through this crate, the evaluator reads through it, and they share nothing else.
//! The normative text is `formats/vademecum-1.md`. Core only: no heap, no panic on any input.
#![no_std]

mod blocks;
mod chapter;
mod error;
mod fuse;
mod layout;
mod metadata;
mod names;
mod parameter;
pub mod policy;
mod quantised;
mod read;
pub mod scheme;
mod section;
#[cfg(feature = "zstd")]
mod unpack;
mod write;

pub use blocks::{Blocks, Filter, MAX_BLOCK_LENGTH};
pub use chapter::{CHAPTER_AXIS, CHAPTER_CERTIFICATE, Chapter, ChapterAxis, ChapterPart, ChapterRole};
pub use error::{FormatError, Quantity};
pub use layout::{BLOCK, MAGIC, MAJOR, MAX_SECTIONS, MINOR};
pub use metadata::{
    Axis, AxisKind, AxisRole, Certificate, MAX_AXES, MAX_METADATA, MAX_MODES, MAX_NODES, MAX_PARAMETERS,
    MAX_REGIONS, MAX_TERMS, Metadata, StructureCertificate,
};
pub use parameter::{Parameter, ParameterRole};
pub use quantised::{BLOCK_NODES, Quantised};
pub use read::File;
pub use section::{Codec, Element, Numbers, Section, SectionKind};
#[cfg(feature = "zstd")]
pub use unpack::{Decoder, unpack_into, unpacked_len};
pub use write::{SectionInput, encode_into, encoded_len};
