//! Opening a file: every structural statement in it is checked once, here.

use crate::chapter::Chapter;
use crate::checksum::checksum;
use crate::element::{Codec, Element};
use crate::error::FormatError;
use crate::kind::{SectionKind, quadrangle_width};
use crate::layout::{BLOCK, Entry, Header, align, refuse_nonzero};
use crate::metadata::{MAX_METADATA, Metadata, configuration};
use crate::section::Section;
use crate::strain::StrainSizes;

/// An opened file: borrowed bytes whose structure has been checked.
///
/// Opening reads header, directory, metadata and padding; the sections themselves are read when they are
/// used.
#[derive(Clone, Copy, Debug)]
pub struct File<'a> {
    bytes: &'a [u8],
    directory: &'a [[u8; BLOCK]],
    metadata: Metadata<'a>,
    minor: u16,
}

impl<'a> File<'a> {
    /// Opens the bytes of a file.
    ///
    /// # Errors
    /// A refusal of `formats/vademecum-1.md`, 1 to 26 and 31 to 35.
    pub fn parse(bytes: &'a [u8]) -> Result<Self, FormatError> {
        let length = bytes.len() as u64;
        let too_short = |needed| FormatError::TooShort { found: length, needed };
        let (first, rest) = bytes.split_first_chunk::<BLOCK>().ok_or(too_short(BLOCK as u64))?;
        let header = Header::decode(first)?;
        if header.file_length != length {
            return Err(FormatError::FileLength { found: length, expected: header.file_length });
        }
        let directory_end = BLOCK as u64 * (1 + u64::from(header.n_sections));
        let directory =
            rest.as_chunks().0.get(..header.n_sections as usize).ok_or(too_short(directory_end))?;
        let found = checksum(directory.as_flattened());
        if found != header.directory_crc32 {
            return Err(FormatError::DirectoryChecksum { found, expected: header.directory_crc32 });
        }
        let parts = SectionKind::CanonicalParts.number();
        let strain = SectionKind::StrainSizes.number();
        let [canonical, strain] =
            [parts, strain].map(|kind| directory.iter().any(|block| Entry::decode(block).kind == kind));
        let metadata = read_metadata(bytes, &header, directory_end, [canonical, strain])?;
        let file = Self { bytes, directory, metadata, minor: header.minor };
        file.check_sections(directory_end + header.metadata_length)?;
        file.check_structures()?;
        if cfg!(feature = "full") {
            file.check_strain()?;
            file.check_chapter()?;
        }
        Ok(file)
    }

    /// The file's metadata.
    #[must_use]
    pub const fn metadata(&self) -> &Metadata<'a> {
        &self.metadata
    }

    /// Minor version it was written in.
    #[must_use]
    pub const fn minor(&self) -> u16 {
        self.minor
    }

    /// Sections in its directory, of known kinds or not: what the header's bytes 12 to 15 say.
    #[must_use]
    pub const fn n_sections(&self) -> usize {
        self.directory.len()
    }

    /// All bytes of the file.
    #[must_use]
    pub const fn bytes(&self) -> &'a [u8] {
        self.bytes
    }

    /// The section of this kind, if the file has it.
    #[must_use]
    pub fn section(&self, kind: SectionKind) -> Option<Section<'a>> {
        self.sections().find(|section| section.kind == kind)
    }

    /// All sections of known kinds, in file order.
    pub fn sections(&self) -> impl Iterator<Item = Section<'a>> + use<'a> {
        let Self { bytes, directory, .. } = *self;
        directory.iter().filter_map(move |block| open_section(bytes, &Entry::decode(block)).ok().flatten())
    }

    /// Names of the probes, in their order; none where the file has no probes or keeps the names compressed.
    pub fn probe_names(&self) -> impl Iterator<Item = &'a str> + use<'a> {
        self.lines(SectionKind::ProbeNames)
    }

    /// Names of the load patterns, in their order; none where the file has no patterns or keeps the names
    /// compressed.
    pub fn pattern_names(&self) -> impl Iterator<Item = &'a str> + use<'a> {
        self.lines(SectionKind::PatternNames)
    }

    /// Names of the supports whose reactions the file gives, in their order; none where it gives none or
    /// keeps the names compressed.
    pub fn support_names(&self) -> impl Iterator<Item = &'a str> + use<'a> {
        self.lines(SectionKind::SupportNames)
    }

    fn lines(&self, kind: SectionKind) -> core::str::Lines<'a> {
        self.section(kind).and_then(|section| section.text().ok()).unwrap_or("").lines()
    }

    /// Compares every section of a known kind with its checksum, and the indices of raw ones with what they
    /// count. Reads the whole file.
    ///
    /// # Errors
    /// Refusals 27 and 38.
    pub fn verify_all(&self) -> Result<(), FormatError> {
        self.sections().try_for_each(|section| section.verify())?;
        self.verify_indices()
    }

    /// Refusals 5 and 18 to 25, and 6 for bytes after the last section.
    fn check_sections(&self, metadata_end: u64) -> Result<(), FormatError> {
        let mut end = metadata_end;
        for (place, block) in self.directory.iter().enumerate() {
            let entry = Entry::decode(block);
            let start = check_place(&entry, end, self.bytes)?;
            if entry.reserved != 0 {
                return Err(FormatError::NotZero { offset: (BLOCK * (1 + place) + 60) as u64 });
            }
            end = start + entry.stored_length;
            let same_kind = |other: &&[u8; BLOCK]| Entry::decode(other).kind == entry.kind;
            if self.directory.iter().take(place).find(same_kind).is_some() {
                return Err(FormatError::Duplicate { kind: entry.kind });
            }
            if let Some(section) = open_section(self.bytes, &entry)? {
                check_shape(&section, &self.metadata)?;
            }
        }
        let length = self.bytes.len() as u64;
        if end != length {
            return Err(FormatError::FileLength { found: length, expected: end });
        }
        Ok(())
    }

    /// Refusal 26.
    fn check_structures(&self) -> Result<(), FormatError> {
        use crate::parameter::ParameterRole as R;
        use SectionKind as S;
        let diagonal: &[SectionKind] = if self.metadata.diagonal { &[S::Eigenvalues] } else { &[] };
        let block: &[SectionKind] = if self.metadata.block {
            &[S::ReducedStiffness, S::BlockState, S::AxisPoints, S::Factors]
        } else {
            &[]
        };
        let canonical: &[SectionKind] = if self.section(S::CanonicalParts).is_some() {
            &[
                S::ReducedStiffness,
                S::CanonicalAxes,
                S::CanonicalFactors,
                S::CanonicalTerms,
                S::CanonicalPositions,
                S::CanonicalCertificate,
            ]
        } else {
            &[]
        };
        let moved = |role: fn(&R) -> bool| self.metadata.active_parameters().iter().any(|p| role(&p.role));
        let stiffness: &[SectionKind] =
            if moved(|role| matches!(role, R::RegionStiffness { .. })) { &[S::RegionStiffness] } else { &[] };
        let mass: &[SectionKind] =
            if moved(|role| matches!(role, R::RegionDensity { .. })) { &[S::RegionMass] } else { &[] };
        match diagonal
            .iter()
            .chain(block)
            .chain(canonical)
            .chain(stiffness)
            .chain(mass)
            .find(|&&kind| self.section(kind).is_none())
        {
            None => Ok(()),
            Some(kind) => Err(FormatError::Missing { kind: kind.number() }),
        }
    }

    /// The sizes of the strain structure that the file announces; `None` for a file without it.
    ///
    /// # Errors
    /// Refusals 13 and 28.
    pub fn strain_sizes(&self) -> Result<Option<StrainSizes>, FormatError> {
        let Some(section) = self.section(SectionKind::StrainSizes) else { return Ok(None) };
        let mut numbers = [0; 4];
        numbers.iter_mut().zip(section.u32s()?).for_each(|(out, &bytes)| *out = u32::from_le_bytes(bytes));
        StrainSizes::new(numbers, &self.metadata).map(Some)
    }

    /// Refusals 13, 25 and 26 of the strain structure; left for later where the sizes are compressed.
    fn check_strain(&self) -> Result<(), FormatError> {
        let sizes = match self.strain_sizes() {
            Ok(Some(sizes)) => sizes,
            Ok(None) | Err(FormatError::Compressed { .. }) => return Ok(()),
            Err(error) => return Err(error),
        };
        for (kind, expected, needed) in sizes.shapes() {
            let Some(section) = self.section(kind) else {
                if needed {
                    return Err(FormatError::Missing { kind: kind.number() });
                }
                continue;
            };
            for (axis, (&found, expected)) in section.shape.iter().zip(expected).enumerate() {
                if found != expected {
                    let (kind, axis) = (kind.number(), axis as u8);
                    return Err(FormatError::Shape { kind, axis, found, expected });
                }
            }
        }
        Ok(())
    }

    /// Refusals 32 to 35; left for later where a section is compressed.
    fn check_chapter(&self) -> Result<(), FormatError> {
        match Chapter::read(self) {
            Ok(_) | Err(FormatError::Compressed { .. }) => Ok(()),
            Err(error) => Err(error),
        }
    }
}

fn read_metadata<'a>(
    bytes: &'a [u8],
    header: &Header,
    expected: u64,
    others: [bool; 2],
) -> Result<Metadata<'a>, FormatError> {
    if header.metadata_offset != expected {
        return Err(FormatError::MetadataOffset { found: header.metadata_offset, expected });
    }
    let limit = (MAX_METADATA as u64).min((bytes.len() as u64).saturating_sub(expected));
    let too_long = FormatError::MetadataLength { found: header.metadata_length, limit };
    if header.metadata_length > limit {
        return Err(too_long);
    }
    let (start, length) = (expected as usize, header.metadata_length as usize);
    let encoded = bytes.get(start..start + length).ok_or(too_long)?;
    let found = checksum(encoded);
    if found != header.metadata_crc32 {
        return Err(FormatError::MetadataChecksum { found, expected: header.metadata_crc32 });
    }
    let refused = |understood| FormatError::MetadataEncoding { understood, length: header.metadata_length };
    let (metadata, understood): (Metadata<'a>, usize) =
        bincode::borrow_decode_from_slice(encoded, configuration()).map_err(|_| refused(0))?;
    if understood != length {
        return Err(refused(understood as u64));
    }
    metadata.check(others)?;
    Ok(metadata)
}

/// Start of the section: refusals 23, 24 and 5. Holds for sections of any kind.
fn check_place(entry: &Entry, end: u64, bytes: &[u8]) -> Result<u64, FormatError> {
    let kind = entry.kind;
    let length = bytes.len() as u64;
    let start = align(end).unwrap_or(u64::MAX);
    if entry.offset != start {
        return Err(FormatError::Offset { kind, found: entry.offset, expected: start });
    }
    let room = length.saturating_sub(start);
    if start > length || entry.stored_length > room {
        return Err(FormatError::Length { kind, found: entry.stored_length, expected: room });
    }
    let cut = FormatError::Length { kind, found: entry.stored_length, expected: room };
    let padding = bytes.get(end as usize..start as usize).ok_or(cut)?;
    refuse_nonzero(padding, end)?;
    Ok(start)
}

/// The section of an entry whose place has been checked; `None` for an optional kind this reader does not
/// know.
fn open_section<'a>(bytes: &'a [u8], entry: &Entry) -> Result<Option<Section<'a>>, FormatError> {
    let number = entry.kind;
    let required = entry.flags & 1 == 1;
    let Some(kind) = SectionKind::from_number(number) else {
        return if required { Err(FormatError::UnknownKind { kind: number }) } else { Ok(None) };
    };
    if entry.flags > 1 {
        return Err(FormatError::Flags { kind: number, found: entry.flags });
    }
    let element = Element::from_code(entry.element).filter(|&element| kind.allows(element));
    let element = element.ok_or(FormatError::Element { kind: number, found: entry.element })?;
    let codec = Codec::from_code(entry.codec).filter(|codec| codec.codes(element));
    let codec = codec.ok_or(FormatError::Codec { kind: number, found: entry.codec })?;
    let end = entry.offset.saturating_add(entry.stored_length);
    let expected = (bytes.len() as u64).saturating_sub(entry.offset);
    let cut = FormatError::Length { kind: number, found: entry.stored_length, expected };
    let stored = bytes.get(entry.offset as usize..end as usize).ok_or(cut)?;
    Ok(Some(Section {
        kind,
        element,
        codec,
        required,
        shape: entry.shape,
        decoded_length: entry.decoded_length,
        crc32: entry.crc32,
        stored,
    }))
}

/// Refusals 24 and 25.
fn check_shape(section: &Section<'_>, metadata: &Metadata<'_>) -> Result<(), FormatError> {
    let kind = section.kind.number();
    for (axis, (&found, expected)) in section.shape.iter().zip(section.kind.shape(metadata)).enumerate() {
        if let Some(expected) = expected.filter(|&expected| expected != found) {
            return Err(FormatError::Shape { kind, axis: axis as u8, found, expected });
        }
    }
    let [_, found, _] = section.shape;
    let expected = quadrangle_width(found);
    if section.kind == SectionKind::Quadrangles && found != expected {
        return Err(FormatError::Shape { kind, axis: 1, found, expected });
    }
    let expected = section.element.decoded_length(section.shape).unwrap_or(u64::MAX);
    if section.decoded_length != expected {
        return Err(FormatError::Length { kind, found: section.decoded_length, expected });
    }
    let found = section.stored.len() as u64;
    if section.codec == Codec::Raw && found != expected {
        return Err(FormatError::Length { kind, found, expected });
    }
    Ok(())
}
