//! The fixed bytes at the front: header and directory entries, and where things lie.

use crate::checksum::checksum;
use crate::error::FormatError;

/// First bytes of every file: a byte with the high bit, a name, line ends and an end-of-file mark, so that a
/// text-mode copy shows.
pub const MAGIC: [u8; 8] = [0x89, 0x56, 0x44, 0x4D, 0x0D, 0x0A, 0x1A, 0x0A];
/// Major version written and read.
pub const MAJOR: u16 = 1;
/// Highest minor version this crate knows; any is read. A file is written in the lowest that knows all it
/// holds.
pub const MINOR: u16 = 14;
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

/// `N` bytes of a block from byte `AT`.
fn take<const AT: usize, const N: usize>(block: &[u8; BLOCK]) -> [u8; N] {
    const { assert!(AT + N <= BLOCK, "within the block") };
    core::array::from_fn(|place| block[AT + place])
}

#[cfg(feature = "full")]
fn put(block: &mut [u8; BLOCK], at: usize, bytes: &[u8]) {
    for (place, &byte) in block.iter_mut().skip(at).zip(bytes) {
        *place = byte;
    }
}

impl Header {
    #[cfg(feature = "full")]
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
        let checksum = checksum(block.split_at(60).0);
        put(&mut block, 60, &checksum.to_le_bytes());
        block
    }

    /// Refusals 2 to 5 and 7.
    pub fn decode(block: &[u8; BLOCK]) -> Result<Self, FormatError> {
        if take::<0, 8>(block) != MAGIC {
            return Err(FormatError::Magic);
        }
        let major = u16::from_le_bytes(take::<8, 2>(block));
        if major != MAJOR {
            return Err(FormatError::MajorVersion { found: major });
        }
        let (found, expected) = (checksum(block.split_at(60).0), u32::from_le_bytes(take::<60, 4>(block)));
        if found != expected {
            return Err(FormatError::HeaderChecksum { found, expected });
        }
        refuse_nonzero(&take::<48, 12>(block), 48)?;
        let n_sections = u32::from_le_bytes(take::<12, 4>(block));
        if n_sections > MAX_SECTIONS {
            return Err(FormatError::SectionCount { found: n_sections, limit: MAX_SECTIONS });
        }
        Ok(Self {
            minor: u16::from_le_bytes(take::<10, 2>(block)),
            n_sections,
            file_length: u64::from_le_bytes(take::<16, 8>(block)),
            metadata_offset: u64::from_le_bytes(take::<24, 8>(block)),
            metadata_length: u64::from_le_bytes(take::<32, 8>(block)),
            metadata_crc32: u32::from_le_bytes(take::<40, 4>(block)),
            directory_crc32: u32::from_le_bytes(take::<44, 4>(block)),
        })
    }
}

impl Entry {
    #[cfg(feature = "full")]
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
        let [element, codec] = take::<4, 2>(block);
        Self {
            kind: u32::from_le_bytes(take::<0, 4>(block)),
            element,
            codec,
            flags: u16::from_le_bytes(take::<6, 2>(block)),
            shape: [take::<8, 8>(block), take::<16, 8>(block), take::<24, 8>(block)].map(u64::from_le_bytes),
            offset: u64::from_le_bytes(take::<32, 8>(block)),
            stored_length: u64::from_le_bytes(take::<40, 8>(block)),
            decoded_length: u64::from_le_bytes(take::<48, 8>(block)),
            crc32: u32::from_le_bytes(take::<56, 4>(block)),
            reserved: u32::from_le_bytes(take::<60, 4>(block)),
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
