//! The fixed bytes at the front: header and directory entries, and where things lie.

use crate::error::FormatError;

/// First bytes of every file: a byte with the high bit, a name, line ends and an end-of-file mark, so that a text-mode copy
/// shows.
pub const MAGIC: [u8; 8] = [0x89, 0x56, 0x44, 0x4D, 0x0D, 0x0A, 0x1A, 0x0A];
/// Major version written and read.
pub const MAJOR: u16 = 1;
/// Newest minor version written: a file is given the lowest one that has all its sections. Any is read.
pub const MINOR: u16 = 1;
/// Bytes of the header, of a directory entry, and the alignment of sections.
pub const BLOCK: usize = 64;
/// Most sections of a file.
pub const MAX_SECTIONS: u32 = 256;

/// The header's variable fields.
pub(crate) struct Header {
    pub minor: u16,
    pub n_sections: u32,
    pub file_length: u64,
    pub metadata_offset: u64,
    pub metadata_length: u64,
    pub metadata_crc32: u32,
    pub directory_crc32: u32,
}

/// One directory entry as it is in the file.
#[derive(Clone, Copy)]
pub(crate) struct Entry {
    pub kind: u32,
    pub element: u8,
    pub codec: u8,
    pub flags: u16,
    pub shape: [u64; 3],
    pub offset: u64,
    pub stored_length: u64,
    pub decoded_length: u64,
    pub crc32: u32,
    pub reserved: u32,
}

/// `N` bytes of a block from `at`; every call site is within the block, so the zeros are never seen.
fn take<const N: usize>(block: &[u8; BLOCK], at: usize) -> [u8; N] {
    block.get(at..).and_then(|rest| rest.first_chunk()).copied().unwrap_or([0; N])
}

fn put(block: &mut [u8; BLOCK], at: usize, bytes: &[u8]) {
    for (place, &byte) in block.iter_mut().skip(at).zip(bytes) {
        *place = byte;
    }
}

impl Header {
    pub fn encode(&self) -> [u8; BLOCK] {
        let mut block = [0; BLOCK];
        put(&mut block, 0, &MAGIC);
        put(&mut block, 8, &MAJOR.to_le_bytes());
        put(&mut block, 10, &self.minor.to_le_bytes());
        put(&mut block, 12, &self.n_sections.to_le_bytes());
        put(&mut block, 16, &self.file_length.to_le_bytes());
        put(&mut block, 24, &self.metadata_offset.to_le_bytes());
        put(&mut block, 32, &self.metadata_length.to_le_bytes());
        put(&mut block, 40, &self.metadata_crc32.to_le_bytes());
        put(&mut block, 44, &self.directory_crc32.to_le_bytes());
        let checksum = crc32fast::hash(block.split_at(60).0);
        put(&mut block, 60, &checksum.to_le_bytes());
        block
    }

    /// Refusals 2 to 5 and 7.
    pub fn decode(block: &[u8; BLOCK]) -> Result<Self, FormatError> {
        if take(block, 0) != MAGIC {
            return Err(FormatError::Magic);
        }
        let major = u16::from_le_bytes(take(block, 8));
        if major != MAJOR {
            return Err(FormatError::MajorVersion { found: major });
        }
        let (found, expected) = (crc32fast::hash(block.split_at(60).0), u32::from_le_bytes(take(block, 60)));
        if found != expected {
            return Err(FormatError::HeaderChecksum { found, expected });
        }
        refuse_nonzero(&take::<12>(block, 48), 48)?;
        let n_sections = u32::from_le_bytes(take(block, 12));
        if n_sections > MAX_SECTIONS {
            return Err(FormatError::SectionCount { found: n_sections, limit: MAX_SECTIONS });
        }
        Ok(Self {
            minor: u16::from_le_bytes(take(block, 10)),
            n_sections,
            file_length: u64::from_le_bytes(take(block, 16)),
            metadata_offset: u64::from_le_bytes(take(block, 24)),
            metadata_length: u64::from_le_bytes(take(block, 32)),
            metadata_crc32: u32::from_le_bytes(take(block, 40)),
            directory_crc32: u32::from_le_bytes(take(block, 44)),
        })
    }
}

impl Entry {
    pub fn encode(&self) -> [u8; BLOCK] {
        let mut block = [0; BLOCK];
        put(&mut block, 0, &self.kind.to_le_bytes());
        put(&mut block, 4, &[self.element, self.codec]);
        put(&mut block, 6, &self.flags.to_le_bytes());
        for (place, number) in self.shape.iter().enumerate() {
            put(&mut block, 8 + 8 * place, &number.to_le_bytes());
        }
        put(&mut block, 32, &self.offset.to_le_bytes());
        put(&mut block, 40, &self.stored_length.to_le_bytes());
        put(&mut block, 48, &self.decoded_length.to_le_bytes());
        put(&mut block, 56, &self.crc32.to_le_bytes());
        put(&mut block, 60, &self.reserved.to_le_bytes());
        block
    }

    pub fn decode(block: &[u8; BLOCK]) -> Self {
        let [element, codec] = take(block, 4);
        Self {
            kind: u32::from_le_bytes(take(block, 0)),
            element,
            codec,
            flags: u16::from_le_bytes(take(block, 6)),
            shape: [8, 16, 24].map(|at| u64::from_le_bytes(take(block, at))),
            offset: u64::from_le_bytes(take(block, 32)),
            stored_length: u64::from_le_bytes(take(block, 40)),
            decoded_length: u64::from_le_bytes(take(block, 48)),
            crc32: u32::from_le_bytes(take(block, 56)),
            reserved: u32::from_le_bytes(take(block, 60)),
        }
    }
}

/// The first multiple of 64 at or after `offset`.
pub(crate) fn align(offset: u64) -> Option<u64> {
    offset.checked_next_multiple_of(BLOCK as u64)
}

/// Refusal 5 for bytes that lie at `offset` in the file.
pub(crate) fn refuse_nonzero(bytes: &[u8], offset: u64) -> Result<(), FormatError> {
    match bytes.iter().position(|&byte| byte != 0) {
        None => Ok(()),
        Some(place) => Err(FormatError::NotZero { offset: offset + place as u64 }),
    }
}
