//! Sections to zstd frames and back.
//!
//! A hostile file may declare any decoded length and hold a frame of any ratio. Decoding therefore grows its memory with what the
//! frame really gives and stops one byte past the declaration, and the declarations are added up and held to a limit first.

use std::io::Read;

use vademecum_format::{Codec, File, Section};
use zstd::stream::read::Decoder;

use super::RewriteError;

/// Bytes all sections of a file may decode to unless the caller says otherwise: 4 GiB.
pub const DECODED_LIMIT: u64 = 1 << 32;

/// Largest window a frame may ask for, as a power of two: that of zstd's level 22. Memory for it is taken before the first byte.
const WINDOW_LOG: u32 = 27;

/// The section's bytes, decoded. `limit` bounds its declared length.
///
/// # Errors
/// [`RewriteError::TooLarge`], [`RewriteError::Frame`].
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

/// The declared lengths of all sections, added up, against the limit.
pub(super) fn check_total(file: &File<'_>, limit: u64) -> Result<(), RewriteError> {
    let declared = file.sections().fold(0, |sum: u64, section| sum.saturating_add(section.decoded_length()));
    if declared > limit { Err(RewriteError::TooLarge { declared, limit }) } else { Ok(()) }
}

/// One frame of these bytes.
pub(super) fn frame(raw: &[u8], level: i32) -> Result<Vec<u8>, RewriteError> {
    zstd::bulk::compress(raw, level).map_err(RewriteError::Compress)
}
