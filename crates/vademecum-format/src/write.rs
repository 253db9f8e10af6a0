//! Writing a file into lent memory. The same input gives the same bytes, and what is written opens: the
//! writer ends by parsing its own bytes, so reader and writer cannot disagree about what is allowed.

use crate::checksum::checksum;
use crate::element::{Codec, Element};
use crate::error::FormatError;
use crate::kind::SectionKind;
use crate::layout::{BLOCK, Entry, Header, MAX_SECTIONS, align};
use crate::metadata::{MAX_METADATA, Metadata, configuration};
use crate::read::File;
use crate::section::Section;
use bincode::Encode;
use bincode::enc::EncoderImpl;
use bincode::enc::write::SizeWriter;

/// Room for every kind there is: a file has each at most once.
#[cfg(feature = "zstd")]
pub(crate) const MAX_INPUTS: usize = SectionKind::ALL.len();

/// A section to be written.
#[derive(Clone, Copy, Debug)]
pub struct SectionInput<'a> {
    /// Its kind.
    pub kind: SectionKind,
    /// Its element type.
    pub element: Element,
    /// Codec of `stored`.
    pub codec: Codec,
    /// True if a reader that does not know the kind must refuse the file.
    pub required: bool,
    /// Its shape; places past its rank are 1.
    pub shape: [u64; 3],
    /// Bytes once decoded: element size times the shape.
    pub decoded_length: u64,
    /// The coded bytes.
    pub stored: &'a [u8],
}

impl<'a> From<Section<'a>> for SectionInput<'a> {
    /// The section as it stands in its file.
    fn from(section: Section<'a>) -> Self {
        Self {
            kind: section.kind,
            element: section.element,
            codec: section.codec,
            required: section.required,
            shape: section.shape,
            decoded_length: section.decoded_length,
            stored: section.stored,
        }
    }
}

#[cfg(feature = "zstd")]
impl SectionInput<'_> {
    /// Nothing, where a list has room left.
    pub(crate) const NONE: Self = Self {
        kind: SectionKind::NodeIds,
        element: Element::U8,
        codec: Codec::Raw,
        required: false,
        shape: [0; 3],
        decoded_length: 0,
        stored: &[],
    };
}

/// Bytes [`encode_into`] will write.
///
/// # Errors
/// Refusals 7, 9 (too many sections, metadata too long), 12 and 30 (longer than memory can be).
pub fn encoded_len(metadata: &Metadata<'_>, sections: &[SectionInput<'_>]) -> Result<usize, FormatError> {
    planned_len(metadata, sections, |section| section.stored.len() as u64)
}

/// Writes a file at the front of `out` and returns its length, [`encoded_len`]. Sections keep their order.
///
/// # Errors
/// Any refusal the written bytes would meet on opening, and 30 if `out` is too short.
pub fn encode_into(
    metadata: &Metadata<'_>,
    sections: &[SectionInput<'_>],
    out: &mut [u8],
) -> Result<usize, FormatError> {
    let length = |section: &SectionInput<'_>| section.stored.len() as u64;
    let copy = |section: &SectionInput<'_>, place: &mut [u8]| {
        place.copy_from_slice(section.stored);
        Ok(())
    };
    write_planned(metadata, sections, length, copy, out)
}

/// Bytes [`encode_filled`] will write.
///
/// # Errors
/// As [`encoded_len`].
pub fn filled_len(metadata: &Metadata<'_>, sections: &[SectionInput<'_>]) -> Result<usize, FormatError> {
    planned_len(metadata, sections, |section| section.decoded_length)
}

/// [`encode_into`] without a copy: `fill` writes the bytes of each section where they belong, zeros before.
/// Sections are raw and have `decoded_length` bytes; `stored` is not looked at.
///
/// # Errors
/// As [`encode_into`], and the errors of `fill`.
pub fn encode_filled(
    metadata: &Metadata<'_>,
    sections: &[SectionInput<'_>],
    mut fill: impl FnMut(SectionKind, &mut [u8]) -> Result<(), FormatError>,
    out: &mut [u8],
) -> Result<usize, FormatError> {
    let length = |section: &SectionInput<'_>| section.decoded_length;
    write_planned(metadata, sections, length, |section, place| fill(section.kind, place), out)
}

/// [`encoded_len`] for sections whose stored bytes are not there yet but have known lengths.
pub(crate) fn planned_len(
    metadata: &Metadata<'_>,
    sections: &[SectionInput<'_>],
    length: impl Fn(&SectionInput<'_>) -> u64,
) -> Result<usize, FormatError> {
    let mut end = (BLOCK * (1 + count(sections)? as usize) + metadata_len(metadata)?) as u64;
    for section in sections {
        end = align(end).and_then(|start| start.checked_add(length(section))).unwrap_or(u64::MAX);
    }
    let too_long = FormatError::LentMemory { found: usize::MAX as u64, needed: end };
    usize::try_from(end).map_err(|_| too_long)
}

/// [`encode_into`] for sections whose stored bytes `fill` puts where they belong.
pub(crate) fn write_planned(
    metadata: &Metadata<'_>,
    sections: &[SectionInput<'_>],
    length: impl Fn(&SectionInput<'_>) -> u64,
    fill: impl FnMut(&SectionInput<'_>, &mut [u8]) -> Result<(), FormatError>,
    out: &mut [u8],
) -> Result<usize, FormatError> {
    let needed = planned_len(metadata, sections, &length)?;
    let found = out.len() as u64;
    let short = FormatError::LentMemory { found, needed: needed as u64 };
    let out = out.get_mut(..needed).ok_or(short)?;
    out.fill(0);
    let n_sections = count(sections)?;
    let directory_end = BLOCK * (1 + sections.len());
    let metadata_length = metadata_len(metadata)?;
    let (front, body) = out.split_at_mut_checked(directory_end).ok_or(short)?;
    let encoded = body.get_mut(..metadata_length).ok_or(short)?;
    encode_metadata(metadata, encoded)?;
    let metadata_crc32 = checksum(encoded);
    let (header, directory) = front.split_first_chunk_mut::<BLOCK>().ok_or(short)?;
    write_sections(sections, length, fill, directory, body, [directory_end, metadata_length])?;
    let block = Header {
        minor: minor(metadata, sections),
        n_sections,
        file_length: needed as u64,
        metadata_offset: directory_end as u64,
        metadata_length: metadata_length as u64,
        metadata_crc32,
        directory_crc32: checksum(directory),
    };
    *header = block.encode();
    File::parse(out)?;
    Ok(needed)
}

/// Fills the directory and the sections; `body` begins at byte `base` of the file with the metadata.
fn write_sections(
    sections: &[SectionInput<'_>],
    length: impl Fn(&SectionInput<'_>) -> u64,
    mut fill: impl FnMut(&SectionInput<'_>, &mut [u8]) -> Result<(), FormatError>,
    directory: &mut [u8],
    body: &mut [u8],
    [base, metadata_length]: [usize; 2],
) -> Result<(), FormatError> {
    let mut end = (base + metadata_length) as u64;
    let found = body.len() as u64;
    for (section, block) in sections.iter().zip(directory.as_chunks_mut::<BLOCK>().0) {
        let offset = align(end).unwrap_or(u64::MAX);
        let start = (offset as usize).saturating_sub(base);
        let length = length(section) as usize;
        let short = FormatError::LentMemory { found, needed: offset };
        let place = body.get_mut(start..start.saturating_add(length)).ok_or(short)?;
        fill(section, place)?;
        *block = entry(section, offset, place).encode();
        end = offset.saturating_add(length as u64);
    }
    Ok(())
}

fn entry(section: &SectionInput<'_>, offset: u64, stored: &[u8]) -> Entry {
    Entry {
        kind: section.kind.number(),
        element: section.element as u8,
        codec: section.codec as u8,
        flags: u16::from(section.required),
        shape: section.shape,
        offset,
        stored_length: stored.len() as u64,
        decoded_length: section.decoded_length,
        crc32: checksum(stored),
        reserved: 0,
    }
}

/// The lowest minor version that knows the scheme and every kind, element and codec of the sections.
fn minor(metadata: &Metadata<'_>, sections: &[SectionInput<'_>]) -> u16 {
    let since = |section: &SectionInput<'_>| {
        let later =
            section.element == Element::I16 || matches!(section.codec, Codec::Shuffled | Codec::Delta);
        section.kind.since().max(u16::from(later))
    };
    let scheme = if metadata.scheme.is_exact() { 3 } else { 0 };
    sections.iter().map(since).fold(scheme, u16::max)
}

fn count(sections: &[SectionInput<'_>]) -> Result<u32, FormatError> {
    let found = u32::try_from(sections.len()).unwrap_or(u32::MAX);
    if found > MAX_SECTIONS {
        return Err(FormatError::SectionCount { found, limit: MAX_SECTIONS });
    }
    Ok(found)
}

fn metadata_len(metadata: &Metadata<'_>) -> Result<usize, FormatError> {
    let mut encoder = EncoderImpl::new(SizeWriter::default(), configuration());
    let refused = FormatError::MetadataEncoding { understood: 0, length: 0 };
    metadata.encode(&mut encoder).map_err(|_| refused)?;
    let length = encoder.into_writer().bytes_written;
    if length > MAX_METADATA {
        return Err(FormatError::MetadataLength { found: length as u64, limit: MAX_METADATA as u64 });
    }
    Ok(length)
}

fn encode_metadata(metadata: &Metadata<'_>, place: &mut [u8]) -> Result<(), FormatError> {
    let length = place.len() as u64;
    let refused = |understood| FormatError::MetadataEncoding { understood, length };
    let written = bincode::encode_into_slice(metadata, place, configuration()).map_err(|_| refused(0))?;
    if written as u64 == length { Ok(()) } else { Err(refused(written as u64)) }
}
