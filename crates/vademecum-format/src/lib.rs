//! Reader and writer of vademecum files, and the meaning of their numbers.
//!
//! The builder writes through this crate, the evaluator reads through it, and they share nothing else. The
//! normative text is `formats/vademecum-1.md`.
//!
//! # Should I use this crate?
//!
//! Yes, if you want to know what is in a file, take its basis or its modes into a program of your own, or
//! write files from another builder. It needs `core` only, has no heap, and does not panic on any input.
//!
//! No, if you want to step a body: the crate `vademecum-eval` does, and re-exports this one. Nor if you want
//! a file made from a mesh: that is the program `vademecum build`.
//!
//! # The flow
//!
//! ```text
//! header ─ directory ─ metadata ─ section ─ section ─ …        bytes, sections at multiples of 64
//!    │         │           │          │
//!    └── File::parse ──────┘          │                        every structural statement is checked once
//!             │                       │
//!             ├── File::metadata      │                        counts, scheme, parameters, certificate
//!             └── File::section ──────┘
//!                      │
//!                      ├── Section::verify                     against its checksum
//!                      └── numbers, f64s, u32s, u64s, text     where they lie, not copied
//! ```
//!
//! ```
//! use vademecum_format::{File, SectionKind};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let bytes = include_bytes!(concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/golden/fixed-f64.vdm"));
//! let file = File::parse(bytes)?;
//! let metadata = file.metadata();
//! assert_eq!((metadata.n_nodes, metadata.n_modes, metadata.time_step), (11, 3, 1e-3));
//!
//! // The Ritz values, and from them the natural frequencies in Hz.
//! let section = file.section(SectionKind::Eigenvalues).ok_or("no diagonal structure")?;
//! section.verify()?;
//! let frequencies = section.numbers()?.iter().map(|lambda: f64| lambda.sqrt() / std::f64::consts::TAU);
//! assert_eq!(frequencies.map(|f| f.round()).collect::<Vec<_>>(), [5.0, 32.0, 252.0]);
//! # Ok(())
//! # }
//! ```
//!
//! # Common tasks
//!
//! - **Reading.** [`File::parse`], [`File::metadata`], [`File::section`], [`Section::verify`],
//!   [`Section::numbers`], and [`Numbers::iter`], [`Numbers::row`] or [`Numbers::get`]. [`File::verify_all`]
//!   checks every section at once.
//! - **Writing.** A [`Metadata`] and a list of [`SectionInput`], [`encoded_len`], [`encode_into`] into memory
//!   you lend. What it writes it opens once itself, so a file that could not be read is never written.
//! - **Opening what was shipped small** (feature `zstd`). [`unpacked_len`] and [`unpack_into`] write the file
//!   anew, with the sections you want and every one of them raw; a [`Decoder`] decodes one section, or one
//!   block of it.
//! - **From a time scheme to a step.** [`scheme::SchemeTable::check`], [`scheme::theta`],
//!   [`scheme::StageCoefficients::new`] and [`scheme::fuse_into`]: the arithmetic that builder and evaluator
//!   have in common.
//!
//! What counts as accurate and stable enough is in [`policy`].
#![no_std]
// The pages link to what the feature adds; without it those links lead nowhere.
#![cfg_attr(not(feature = "zstd"), allow(rustdoc::broken_intra_doc_links))]

mod base;
mod blocks;
mod chapter;
mod checksum;
pub mod coupled;
mod element;
mod error;
pub mod exact;
mod fuse;
mod indices;
mod kind;
mod layout;
mod live;
mod metadata;
mod names;
mod parameter;
mod patch;
pub mod policy;
mod ports;
mod quadrangles;
mod quantised;
mod read;
pub mod scheme;
mod section;
mod strain;
#[cfg(feature = "zstd")]
mod unpack;
#[cfg(feature = "full")]
mod write;

pub use base::{BASE_PATTERNS, BaseMotion, base_field};
pub use blocks::{Blocks, Filter, MAX_BLOCK_LENGTH};
pub use chapter::{Chapter, ChapterAxis, ChapterPart, ChapterRole};
pub use checksum::checksum;
pub use element::{Codec, Element};
pub use error::{FormatError, Quantity};
pub use kind::{CHAPTER_AXIS, CHAPTER_CERTIFICATE, SectionKind};
pub use layout::{BLOCK, MAGIC, MAJOR, MAX_SECTIONS, MINOR};
pub use live::{LIVE_COLUMNS, LiveError, LiveParameters, MAX_LIVE, MAX_LIVE_REGIONS};
pub use metadata::{
    Axis, AxisKind, AxisRole, Certificate, MAX_AXES, MAX_METADATA, MAX_MODES, MAX_NODES, MAX_PARAMETERS,
    MAX_REGIONS, MAX_TERMS, Metadata, StructureCertificate,
};
pub use parameter::{Parameter, ParameterRole};
pub use patch::{ContactPatch, taper};
pub use ports::{PORT_COLUMNS, PORT_FACET_NODES, PortKind, PortRange};
pub use quadrangles::{Quadrangle, Quadrangles};
pub use quantised::{BLOCK_NODES, Quantised};
pub use read::File;
pub use section::{Numbers, Section};
pub use strain::{MAX_STRAIN_ROWS, MAX_SUBSTEPS, StrainSizes};
#[cfg(feature = "zstd")]
pub use unpack::{Decoder, unpack_into, unpacked_len};
#[cfg(feature = "full")]
pub use write::{SectionInput, encode_filled, encode_into, encoded_len, filled_len};
