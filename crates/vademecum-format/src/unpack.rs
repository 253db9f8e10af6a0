//! From a packed file to a raw one in lent memory, with no more of it than is wanted (feature `zstd`; needs
//! `std`).
//!
//! Each section is decoded straight into its place, block by block. Beside the lent memory there is one block
//! and the decoder's own state, whatever the file declares.

extern crate std;

use crate::blocks::Blocks;
use crate::element::Codec;
use crate::error::FormatError;
use crate::kind::SectionKind;
use crate::read::File;
use crate::section::Section;
use crate::write::{MAX_INPUTS, SectionInput, planned_len, write_planned};
use std::vec;
use std::vec::Vec;
use zstd::bulk::Decompressor;
use zstd::zstd_safe::find_frame_compressed_size;

/// Bytes [`unpack_into`] writes if it keeps the sections for which `wanted` holds.
///
/// # Errors
/// Refusal 30 if that is more than memory can be.
pub fn unpacked_len(file: &File<'_>, wanted: impl Fn(SectionKind) -> bool) -> Result<usize, FormatError> {
    let mut inputs = [SectionInput::NONE; MAX_INPUTS];
    planned_len(file.metadata(), planned(file, wanted, &mut inputs)?, |input| input.decoded_length)
}

/// Writes the file with the wanted sections, every one raw, at the front of `memory`, and opens it there.
///
/// The checksum of each wanted section is verified first, so this reads all of what it keeps and nothing of
/// the others.
///
/// ```
/// use vademecum_format::{File, SectionKind, unpack_into, unpacked_len};
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// # let shipped = include_bytes!(concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/golden/quantised.vdm"));
/// let file = File::parse(shipped)?;
/// let wanted = |kind| kind != SectionKind::InteriorBasis; // the surface will do
/// let mut memory = vec![0; unpacked_len(&file, wanted)?];
/// let raw = unpack_into(&file, wanted, &mut memory)?;
/// assert!(raw.section(SectionKind::InteriorBasis).is_none());
/// assert!(raw.section(SectionKind::SurfaceBasis).is_some());
/// assert_eq!(raw.metadata().n_modes, file.metadata().n_modes);
/// # Ok(())
/// # }
/// ```
///
/// # Errors
/// Refusals 27 (damaged), 30 (`memory` too short, see [`unpacked_len`]), 36 and 37 (not what the codec says);
/// 26 if what is wanted leaves out what an announced structure needs.
pub fn unpack_into<'m>(
    file: &File<'_>,
    wanted: impl Fn(SectionKind) -> bool,
    memory: &'m mut [u8],
) -> Result<File<'m>, FormatError> {
    let mut inputs = [SectionInput::NONE; MAX_INPUTS];
    let inputs = planned(file, wanted, &mut inputs)?;
    let mut decoder = Decoder::new()?;
    let fill = |input: &SectionInput<'_>, out: &mut [u8]| {
        let missing = FormatError::Missing { kind: input.kind.number() };
        let section = file.section(input.kind).ok_or(missing)?;
        section.verify()?;
        decoder.decode_into(&section, out)
    };
    let length = write_planned(file.metadata(), inputs, |input| input.decoded_length, fill, memory)?;
    let short = FormatError::LentMemory { found: memory.len() as u64, needed: length as u64 };
    File::parse(memory.get(..length).ok_or(short)?)
}

/// The sections as they will be written: raw, nothing stored yet; in `inputs`, which has room for all.
fn planned<'a, 'i>(
    file: &File<'a>,
    wanted: impl Fn(SectionKind) -> bool,
    inputs: &'i mut [SectionInput<'a>],
) -> Result<&'i [SectionInput<'a>], FormatError> {
    let (mut count, room) = (0, inputs.len());
    for section in file.sections().filter(|section| wanted(section.kind())) {
        let too_many = FormatError::SectionCount { found: count as u32 + 1, limit: room as u32 };
        let place = inputs.get_mut(count).ok_or(too_many)?;
        *place = SectionInput { codec: Codec::Raw, stored: &[], ..section.into() };
        count += 1;
    }
    inputs.get(..count).ok_or(FormatError::SectionCount { found: count as u32, limit: room as u32 })
}

/// Decodes sections and blocks of sections. Holds zstd's state and one filtered block.
pub struct Decoder {
    zstd: Decompressor<'static>,
    filtered: Vec<u8>,
}

impl Decoder {
    /// A decoder.
    ///
    /// # Errors
    /// Refusal 30 if zstd gets no memory.
    pub fn new() -> Result<Self, FormatError> {
        let no_memory = FormatError::LentMemory { found: 0, needed: 0 };
        Ok(Self { zstd: Decompressor::new().map_err(|_| no_memory)?, filtered: vec![] })
    }

    /// Decodes a whole section into `out`, as long as its decoded length.
    ///
    /// # Errors
    /// Refusals 30, 36 and 37.
    pub fn decode_into(&mut self, section: &Section<'_>, out: &mut [u8]) -> Result<(), FormatError> {
        let (found, needed) = (out.len() as u64, section.decoded_length());
        if found != needed {
            return Err(FormatError::LentMemory { found, needed });
        }
        match section.codec() {
            Codec::Raw => {
                out.iter_mut().zip(section.stored()).for_each(|(out, &byte)| *out = byte);
                Ok(())
            }
            Codec::Zstd => {
                let refused = FormatError::Frame { kind: section.kind().number(), block: 0 };
                self.thaw(section.stored(), out).ok_or(refused)
            }
            Codec::Shuffled | Codec::Delta => {
                let blocks = Blocks::new(section)?;
                let mut rest = out;
                for index in 0..blocks.len() {
                    let range = blocks.decoded(index);
                    let length = (range.end - range.start) as usize;
                    let cut = core::mem::take(&mut rest).split_at_mut_checked(length);
                    let (block, after) = cut.ok_or(FormatError::LentMemory { found, needed: range.end })?;
                    rest = after;
                    self.block_into(section, &blocks, index, block)?;
                }
                Ok(())
            }
        }
    }

    /// Decodes block `index` of a section coded by block into `out`, as long as [`Blocks::decoded`] says.
    ///
    /// # Errors
    /// Refusals 30, 36 and 37.
    pub fn block_into(
        &mut self,
        section: &Section<'_>,
        blocks: &Blocks<'_>,
        index: usize,
        out: &mut [u8],
    ) -> Result<(), FormatError> {
        let range = blocks.decoded(index);
        let (found, needed) = (out.len() as u64, range.end - range.start);
        if found != needed {
            return Err(FormatError::LentMemory { found, needed });
        }
        let frame = blocks.frame(index)?;
        let mut filtered = core::mem::take(&mut self.filtered);
        filtered.resize(out.len(), 0);
        let thawed = self.thaw(frame, &mut filtered);
        if thawed.is_some() {
            blocks.filter().undo(&filtered, out);
        }
        self.filtered = filtered;
        thawed.ok_or(FormatError::Frame { kind: section.kind().number(), block: index as u64 })
    }

    /// One frame of exactly `out.len()` bytes and nothing after it. zstd writes to `out` and never past it.
    fn thaw(&mut self, frame: &[u8], out: &mut [u8]) -> Option<()> {
        if find_frame_compressed_size(frame) != Ok(frame.len()) {
            return None;
        }
        let length = self.zstd.decompress_to_buffer(frame, out).ok()?;
        (length == out.len()).then_some(())
    }
}
