//! Sections coded and decoded.
//!
//! A hostile file may declare any decoded length and hold a frame of any ratio. So the declarations of all
//! sections that are wanted are added up and held to a limit first, a frame is decoded into nothing before
//! memory for it is taken, and memory is asked for in a way that can be refused.

use std::io::Read;

use vademecum_format::{
    Blocks, Codec, Decoder as BlockDecoder, Element, File, Filter, MAX_BLOCK_LENGTH, Section, SectionKind,
};
use zstd::stream::read::Decoder;
use zstd::zstd_safe::{CCtx, CParameter, compress_bound, get_error_name};

use super::error::RewriteError;

/// Bytes all sections of a file may decode to where the file is trusted: 4 GiB.
pub const DECODED_LIMIT: u64 = 1 << 32;

/// Bytes the sections that are wanted may decode to unless the caller says otherwise: 64 MiB and 64 times
/// the length of the file.
///
/// Numbers of a body pack to a third of their length, coarsely rounded ones to a twentieth; a file that asks
/// for more than 64 times its length is a rare one or made to hurt. The constant lets a small file hold long
/// runs of zeros.
#[must_use]
pub const fn default_limit(file_length: usize) -> u64 {
    (file_length as u64).saturating_mul(64).saturating_add(64 << 20)
}

/// Largest window a frame may ask for, as a power of two: that of zstd's level 22. Memory for it is taken
/// before the first byte.
const WINDOW_LOG: u32 = 27;

/// Decoded bytes a block is given: what zstd itself takes as one block, so that cutting there costs next to
/// nothing.
const BLOCK_LENGTH: u64 = 128 * 1024;

/// Memory of zeros, or an error where the machine has none.
pub(super) fn zeros(length: usize) -> Result<Vec<u8>, RewriteError> {
    let mut memory = room(length)?;
    memory.resize(length, 0);
    Ok(memory)
}

/// An empty vector with room for `length` items, or an error where the machine has none.
pub(super) fn room<T>(length: usize) -> Result<Vec<T>, RewriteError> {
    let mut memory = vec![];
    let bytes = (length as u64).saturating_mul(size_of::<T>() as u64);
    memory.try_reserve_exact(length).map_err(|_| RewriteError::Memory { bytes })?;
    Ok(memory)
}

/// A copy, or an error where the machine has no memory for it.
fn copied(bytes: &[u8]) -> Result<Vec<u8>, RewriteError> {
    let mut copy = room(bytes.len())?;
    copy.extend_from_slice(bytes);
    Ok(copy)
}

/// The section's bytes, decoded. `limit` bounds its declared length.
///
/// # Errors
/// [`RewriteError::TooLarge`], [`RewriteError::Frame`], [`RewriteError::Format`], [`RewriteError::Memory`].
pub fn decode(section: &Section<'_>, limit: u64) -> Result<Vec<u8>, RewriteError> {
    let declared = section.decoded_length();
    if declared > limit {
        return Err(RewriteError::TooLarge { kind: section.kind(), declared, limit });
    }
    if section.codec() == Codec::Raw {
        return copied(section.stored());
    }
    prove(section)?;
    let mut raw = zeros(declared as usize)?;
    BlockDecoder::new()?.decode_into(section, &mut raw)?;
    Ok(raw)
}

/// Checks that the section's frames have the declared length, without memory for it: they are decoded
/// piece by piece and the pieces are counted.
///
/// # Errors
/// [`RewriteError::Frame`], [`RewriteError::Format`].
pub(super) fn prove(section: &Section<'_>) -> Result<(), RewriteError> {
    let (kind, declared) = (section.kind(), section.decoded_length());
    match section.codec() {
        Codec::Raw => Ok(()),
        Codec::Zstd => {
            count(section.stored(), declared).map_err(|reason| RewriteError::Frame { kind, declared, reason })
        }
        Codec::Shuffled | Codec::Delta => {
            let blocks = Blocks::new(section)?;
            let mut decoder = BlockDecoder::new()?;
            let mut piece = vec![];
            for index in 0..blocks.len() {
                let range = blocks.decoded(index);
                piece.resize((range.end - range.start) as usize, 0);
                decoder.block_into(section, &blocks, index, &mut piece)?;
            }
            Ok(())
        }
        other => {
            let reason = format!("codec {other} is not known");
            Err(RewriteError::Frame { kind, declared, reason })
        }
    }
}

/// One frame of exactly `declared` bytes and nothing after it.
fn count(stored: &[u8], declared: u64) -> Result<(), String> {
    let failed = |error: std::io::Error| error.to_string();
    let mut decoder = Decoder::with_buffer(stored).map_err(failed)?.single_frame();
    decoder.window_log_max(WINDOW_LOG).map_err(failed)?;
    let (mut piece, mut found) = (vec![0; BLOCK_LENGTH as usize], 0);
    while found <= declared {
        match decoder.read(&mut piece).map_err(failed)? {
            0 => break,
            n => found += n as u64,
        }
    }
    if found != declared {
        let more = if found > declared { "more than " } else { "" };
        return Err(format!("it holds {more}{} bytes", declared.min(found)));
    }
    match decoder.finish().len() {
        0 => Ok(()),
        left => Err(format!("{left} bytes follow the frame")),
    }
}

/// The declared lengths of the wanted sections, added up, against the limit.
pub(super) fn check_total(
    file: &File<'_>,
    wanted: impl Fn(SectionKind) -> bool,
    limit: u64,
) -> Result<(), RewriteError> {
    let sections = || file.sections().filter(|section| wanted(section.kind()));
    let declared = sections().fold(0, |sum: u64, section| sum.saturating_add(section.decoded_length()));
    match sections().max_by_key(|section| section.decoded_length()) {
        Some(largest) if declared > limit => {
            Err(RewriteError::TooLarge { kind: largest.kind(), declared, limit })
        }
        _ => Ok(()),
    }
}

/// The smallest coding of these bytes; of equal ones the simplest.
pub(super) fn smallest(
    raw: &[u8],
    element: Element,
    shape: [u64; 3],
    level: i32,
) -> Result<(Codec, Vec<u8>), RewriteError> {
    let mut best: Option<(Codec, Vec<u8>)> = None;
    for codec in [Codec::Zstd, Codec::Shuffled, Codec::Delta] {
        if !codec.codes(element) || (codec != Codec::Zstd && element.size() == 1) {
            continue;
        }
        let stored = match Filter::new(codec, element.size(), shape) {
            None => frame(raw, level)?,
            Some(filter) => cut(raw, filter, block_length(element, shape), level)?,
        };
        if stored.len() < best.as_ref().map_or(raw.len(), |best| best.1.len()) {
            best = Some((codec, stored));
        }
    }
    best.map_or_else(|| Ok((Codec::Raw, copied(raw)?)), Ok)
}

/// Whole nodes where they fit; a multiple of 8 in any case.
fn block_length(element: Element, shape: [u64; 3]) -> u64 {
    let node = element.size().saturating_mul(shape[1]).saturating_mul(shape[2]).max(1);
    let group = node.saturating_mul(8);
    if group > MAX_BLOCK_LENGTH { BLOCK_LENGTH } else { group * (BLOCK_LENGTH / group).max(1) }
}

/// The table and a frame for each block.
fn cut(raw: &[u8], filter: Filter, block_length: u64, level: i32) -> Result<Vec<u8>, RewriteError> {
    let blocks = raw.chunks(block_length as usize);
    let mut table = room(8 + 8 * blocks.len())?;
    table.extend(block_length.to_le_bytes());
    let mut frames: Vec<u8> = vec![];
    let mut filtered = vec![];
    for block in blocks {
        filtered.resize(block.len(), 0);
        filter.apply(block, &mut filtered);
        append(&mut frames, &frame(&filtered, level)?)?;
        table.extend((frames.len() as u64).to_le_bytes());
    }
    append(&mut table, &frames)?;
    Ok(table)
}

fn append(to: &mut Vec<u8>, bytes: &[u8]) -> Result<(), RewriteError> {
    let asked = (to.len() + bytes.len()) as u64;
    to.try_reserve(bytes.len()).map_err(|_| RewriteError::Memory { bytes: asked })?;
    to.extend_from_slice(bytes);
    Ok(())
}

/// One frame of these bytes.
fn frame(raw: &[u8], level: i32) -> Result<Vec<u8>, RewriteError> {
    let failed = |code| RewriteError::Compress { reason: get_error_name(code) };
    let bytes = compress_bound(raw.len());
    let mut out: Vec<u8> = room(bytes)?;
    let mut context = CCtx::try_create().ok_or(RewriteError::Memory { bytes: bytes as u64 })?;
    context.set_parameter(CParameter::CompressionLevel(level)).map_err(failed)?;
    context.compress2(&mut out, raw).map_err(failed)?;
    out.shrink_to_fit();
    Ok(out)
}
