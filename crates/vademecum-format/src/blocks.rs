//! Sections coded by block: any block can be decoded without the others.
//!
//! The decoded bytes are cut every `block_length` bytes; each piece is filtered by itself (so that like bytes
//! lie together) and is one zstd frame. In front stands a table of little-endian u64: `block_length`, then
//! for each block where its frame ends, counted from the end of the table.

use crate::element::Codec;
use crate::error::FormatError;
use crate::section::Section;
use core::ops::Range;

/// Most decoded bytes of a block: what a reader must hold beside the memory it decodes into.
pub const MAX_BLOCK_LENGTH: u64 = 1 << 20;

/// The blocks of a section of codec [`Codec::Shuffled`] or [`Codec::Delta`].
#[derive(Clone, Copy, Debug)]
pub struct Blocks<'a> {
    kind: u32,
    filter: Filter,
    decoded_length: u64,
    block_length: u64,
    ends: &'a [[u8; 8]],
    frames: &'a [u8],
}

impl<'a> Blocks<'a> {
    /// Reads the table of a section. `O(1)`: each end is looked at when its block is.
    ///
    /// # Errors
    /// Refusal 36, and 20 if the section is not coded by block.
    pub fn new(section: &Section<'a>) -> Result<Self, FormatError> {
        let kind = section.kind().number();
        let filter = Filter::of(section).ok_or(FormatError::Codec { kind, found: section.codec() as u8 })?;
        let refused = FormatError::BlockTable { kind, block: 0 };
        let decoded_length = section.decoded_length();
        let (head, rest) = section.stored().split_first_chunk().ok_or(refused)?;
        let block_length = u64::from_le_bytes(*head);
        let sound = (1..=MAX_BLOCK_LENGTH).contains(&block_length) && block_length % 8 == 0;
        let count = decoded_length.div_ceil(block_length.max(1));
        let table =
            usize::try_from(count).ok().filter(|_| sound).and_then(|n| n.checked_mul(8)).ok_or(refused)?;
        let (ends, frames) = rest.split_at_checked(table).ok_or(refused)?;
        let ends = ends.as_chunks().0;
        let last = ends.last().map_or(0, |&end| u64::from_le_bytes(end));
        if last != frames.len() as u64 {
            return Err(FormatError::BlockTable { kind, block: count.saturating_sub(1) });
        }
        Ok(Self { kind, filter, decoded_length, block_length, ends, frames })
    }

    /// Number of blocks.
    #[must_use]
    pub const fn len(&self) -> usize {
        self.ends.len()
    }

    /// True without any block.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.ends.is_empty()
    }

    /// Decoded bytes of every block but the last, which may be shorter.
    #[must_use]
    pub const fn block_length(&self) -> u64 {
        self.block_length
    }

    /// Bytes of the decoded section that block `index` gives.
    #[must_use]
    pub fn decoded(&self, index: usize) -> Range<u64> {
        let at = |place: u64| place.saturating_mul(self.block_length).min(self.decoded_length);
        at(index as u64)..at((index as u64).saturating_add(1))
    }

    /// The zstd frame of block `index`.
    ///
    /// # Errors
    /// Refusal 36.
    pub fn frame(&self, index: usize) -> Result<&'a [u8], FormatError> {
        let end = |place: usize| self.ends.get(place).map(|&end| u64::from_le_bytes(end));
        let start = if index == 0 { Some(0) } else { end(index - 1) };
        let bounds = start
            .zip(end(index))
            .and_then(|(start, end)| Some(usize::try_from(start).ok()?..usize::try_from(end).ok()?));
        let refused = FormatError::BlockTable { kind: self.kind, block: index as u64 };
        bounds.and_then(|bounds| self.frames.get(bounds)).ok_or(refused)
    }

    /// The filter of each block's bytes.
    #[must_use]
    pub const fn filter(&self) -> Filter {
        self.filter
    }
}

/// A reversible order of a block's bytes that makes them easier to compress.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Filter {
    /// Bytes of a number.
    size: usize,
    /// Take differences over so many 16-bit numbers first; 0: none.
    lag: usize,
}

impl Filter {
    /// The filter of a section; `None` if it is not coded by block.
    #[must_use]
    pub fn of(section: &Section<'_>) -> Option<Self> {
        Self::new(section.codec(), section.element().size(), section.shape())
    }

    /// The filter of a codec for numbers of `size` bytes in a section of this shape.
    #[must_use]
    pub fn new(codec: Codec, size: u64, shape: [u64; 3]) -> Option<Self> {
        let [_, a, b] = shape;
        let lag = match codec {
            Codec::Shuffled => 0,
            Codec::Delta => usize::try_from(a.saturating_mul(b)).unwrap_or(usize::MAX).max(1),
            _ => return None,
        };
        Some(Self { size: size as usize, lag })
    }

    /// Filters a block; `out` is as long.
    pub fn apply(&self, raw: &[u8], out: &mut [u8]) {
        let count = raw.len() / self.size.max(1);
        for (index, number) in raw.chunks_exact(self.size.max(1)).enumerate() {
            let before = index.checked_sub(self.lag).and_then(|i| raw.get(2 * i..));
            let difference =
                (self.lag > 0).then(|| zigzag(read(number), before.map_or(0, read)).to_le_bytes());
            let bytes = difference.as_ref().map_or(number, |bytes| &bytes[..]);
            for (place, &byte) in bytes.iter().enumerate() {
                put(out, place * count + index, byte);
            }
        }
    }

    /// Undoes [`Filter::apply`]; `out` is as long.
    pub fn undo(&self, filtered: &[u8], out: &mut [u8]) {
        let count = filtered.len() / self.size.max(1);
        for (place, bytes) in filtered.chunks_exact(count.max(1)).enumerate().take(self.size) {
            for (number, &byte) in out.chunks_exact_mut(self.size.max(1)).zip(bytes) {
                put(number, place, byte);
            }
        }
        if self.lag > 0 {
            for index in 0..count {
                let before = index.checked_sub(self.lag).and_then(|i| out.get(2 * i..)).map_or(0, read);
                if let Some(number) = out.get_mut(2 * index..).and_then(<[u8]>::first_chunk_mut) {
                    *number = unzigzag(u16::from_le_bytes(*number), before).to_le_bytes();
                }
            }
        }
    }
}

fn put(out: &mut [u8], place: usize, byte: u8) {
    if let Some(out) = out.get_mut(place) {
        *out = byte;
    }
}

/// The 16-bit number at the front.
fn read(bytes: &[u8]) -> u16 {
    bytes.first_chunk().map_or(0, |&bytes| u16::from_le_bytes(bytes))
}

/// The difference modulo 2¹⁶, small magnitudes to small numbers: 0, −1, 1, −2, … to 0, 1, 2, 3, …
fn zigzag(number: u16, before: u16) -> u16 {
    let difference = number.wrapping_sub(before).cast_signed();
    ((difference << 1) ^ (difference >> 15)).cast_unsigned()
}

fn unzigzag(code: u16, before: u16) -> u16 {
    before.wrapping_add((code >> 1) ^ (code & 1).wrapping_neg())
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::array;

    #[test]
    fn what_was_filtered_comes_back() {
        let raw: [u8; 48] = array::from_fn(|i| (i * i * 37 + i) as u8);
        for (codec, size) in
            [(Codec::Shuffled, 8), (Codec::Shuffled, 4), (Codec::Shuffled, 1), (Codec::Delta, 2)]
        {
            for length in [0, 8, 40, 48] {
                let filter = Filter::new(codec, size, [4, 1, 3]).expect("a filter");
                let (mut filtered, mut back) = ([0; 48], [0; 48]);
                filter.apply(&raw[..length], &mut filtered[..length]);
                filter.undo(&filtered[..length], &mut back[..length]);
                assert_eq!(raw[..length], back[..length], "{codec:?} {size} {length}");
            }
        }
    }

    #[test]
    fn differences_and_bytes_are_where_the_page_says() {
        // Two nodes of two columns: 1, 300 and then 0, 301.
        let raw = [1, 0, 44, 1, 0, 0, 45, 1];
        let mut filtered = [0; 8];
        Filter::new(Codec::Delta, 2, [2, 1, 2]).expect("a filter").apply(&raw, &mut filtered);
        // 1 → 2, 300 → 600 = 88 + 2·256, −1 → 1, 1 → 2; low bytes, then high bytes.
        assert_eq!(filtered, [2, 88, 1, 2, 0, 2, 0, 0]);
        assert_eq!(Filter::new(Codec::Zstd, 2, [2, 1, 2]), None);
    }
}
