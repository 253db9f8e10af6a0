//! Sections coded and decoded.
//!
//! A hostile file may declare any decoded length and hold a frame of any ratio. Decoding therefore grows its
//! memory with what the frames really give and stops one byte past the declaration, and the declarations are
//! added up and held to a limit first.

use std::io::Read;

use vademecum_format::{
    Blocks, Codec, Decoder as BlockDecoder, Element, File, Filter, MAX_BLOCK_LENGTH, Section,
};
use zstd::stream::read::Decoder;

use super::error::RewriteError;

/// Bytes all sections of a file may decode to unless the caller says otherwise: 4 GiB.
pub const DECODED_LIMIT: u64 = 1 << 32;

/// Largest window a frame may ask for, as a power of two: that of zstd's level 22. Memory for it is taken
/// before the first byte.
const WINDOW_LOG: u32 = 27;

/// Decoded bytes a block is given: what zstd itself takes as one block, so that cutting there costs next to
/// nothing.
const BLOCK_LENGTH: u64 = 128 * 1024;

/// The section's bytes, decoded. `limit` bounds its declared length.
///
/// # Errors
/// [`RewriteError::TooLarge`], [`RewriteError::Frame`], [`RewriteError::Format`].
pub fn decode(section: &Section<'_>, limit: u64) -> Result<Vec<u8>, RewriteError> {
    let declared = section.decoded_length();
    if declared > limit {
        return Err(RewriteError::TooLarge { declared, limit });
    }
    match section.codec() {
        Codec::Raw => Ok(section.stored().to_vec()),
        Codec::Zstd => {
            let frame = |reason| RewriteError::Frame { kind: section.kind(), declared, reason };
            thaw(section.stored(), declared).map_err(frame)
        }
        Codec::Shuffled | Codec::Delta => join(section),
        other => {
            let reason = format!("codec {other:?} is not known");
            Err(RewriteError::Frame { kind: section.kind(), declared, reason })
        }
    }
}

/// One frame of exactly `declared` bytes and nothing after it.
fn thaw(stored: &[u8], declared: u64) -> Result<Vec<u8>, String> {
    let failed = |error: std::io::Error| error.to_string();
    let mut decoder = Decoder::with_buffer(stored).map_err(failed)?.single_frame();
    decoder.window_log_max(WINDOW_LOG).map_err(failed)?;
    let mut raw = vec![];
    decoder.by_ref().take(declared.saturating_add(1)).read_to_end(&mut raw).map_err(failed)?;
    if raw.len() as u64 != declared {
        let more = if raw.len() as u64 > declared { "more than " } else { "" };
        return Err(format!("it holds {more}{} bytes", declared.min(raw.len() as u64)));
    }
    match decoder.finish().len() {
        0 => Ok(raw),
        left => Err(format!("{left} bytes follow the frame")),
    }
}

/// Block after block; a block that fails ends it before more memory is taken.
fn join(section: &Section<'_>) -> Result<Vec<u8>, RewriteError> {
    let blocks = Blocks::new(section)?;
    let mut decoder = BlockDecoder::new()?;
    let mut raw = vec![];
    for index in 0..blocks.len() {
        let range = blocks.decoded(index);
        raw.resize(range.end as usize, 0);
        decoder.block_into(section, &blocks, index, &mut raw[range.start as usize..])?;
    }
    Ok(raw)
}

/// The declared lengths of all sections, added up, against the limit.
pub(super) fn check_total(file: &File<'_>, limit: u64) -> Result<(), RewriteError> {
    let declared = file.sections().fold(0, |sum: u64, section| sum.saturating_add(section.decoded_length()));
    if declared > limit { Err(RewriteError::TooLarge { declared, limit }) } else { Ok(()) }
}

/// The smallest coding of these bytes; of equal ones the simplest.
pub(super) fn smallest(
    raw: &[u8],
    element: Element,
    shape: [u64; 3],
    level: i32,
) -> Result<(Codec, Vec<u8>), RewriteError> {
    let mut best = (Codec::Raw, raw.to_vec());
    for codec in [Codec::Zstd, Codec::Shuffled, Codec::Delta] {
        if !codec.codes(element) || (codec != Codec::Zstd && element.size() == 1) {
            continue;
        }
        let stored = match Filter::new(codec, element.size(), shape) {
            None => frame(raw, level)?,
            Some(filter) => cut(raw, filter, block_length(element, shape), level)?,
        };
        if stored.len() < best.1.len() {
            best = (codec, stored);
        }
    }
    Ok(best)
}

/// Whole nodes where they fit; a multiple of 8 in any case.
fn block_length(element: Element, shape: [u64; 3]) -> u64 {
    let node = element.size().saturating_mul(shape[1]).saturating_mul(shape[2]).max(1);
    let group = node.saturating_mul(8);
    if group > MAX_BLOCK_LENGTH { BLOCK_LENGTH } else { group * (BLOCK_LENGTH / group).max(1) }
}

/// The table and a frame for each block.
fn cut(raw: &[u8], filter: Filter, block_length: u64, level: i32) -> Result<Vec<u8>, RewriteError> {
    let mut table = block_length.to_le_bytes().to_vec();
    let mut frames = vec![];
    let mut filtered = vec![];
    for block in raw.chunks(block_length as usize) {
        filtered.resize(block.len(), 0);
        filter.apply(block, &mut filtered);
        frames.extend(frame(&filtered, level)?);
        table.extend((frames.len() as u64).to_le_bytes());
    }
    table.extend(frames);
    Ok(table)
}

/// One frame of these bytes.
fn frame(raw: &[u8], level: i32) -> Result<Vec<u8>, RewriteError> {
    zstd::bulk::compress(raw, level).map_err(RewriteError::Compress)
}
