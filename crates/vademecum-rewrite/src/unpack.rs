//! A file with every section raw.

use vademecum_format::{Codec, SectionInput};

use super::codec::{check_total, decode};
use super::error::RewriteError;
use super::whole::{whole, write};

/// The file with every section raw, as it is mapped. `limit` bounds the bytes of all sections together.
///
/// `unpack(pack(f)) = f` for a file `f` whose sections are all raw.
///
/// # Errors
/// [`RewriteError::Format`], [`RewriteError::Unknown`], [`RewriteError::Frame`], [`RewriteError::TooLarge`].
pub fn unpack(bytes: &[u8], limit: u64) -> Result<Vec<u8>, RewriteError> {
    let file = whole(bytes)?;
    check_total(&file, limit)?;
    let mut raw = vec![];
    for section in file.sections() {
        raw.push((section, decode(&section, limit)?));
    }
    let inputs: Vec<SectionInput<'_>> = raw
        .iter()
        .map(|(section, raw)| SectionInput { codec: Codec::Raw, stored: raw, ..SectionInput::from(*section) })
        .collect();
    write(&file, &inputs)
}
