//! A file with every section raw, or with those that are wanted.

use vademecum_format::{File, SectionKind, unpack_into, unpacked_len};

use super::codec::{check_total, prove, zeros};
use super::error::RewriteError;
use super::whole::whole;

/// The file with every section raw, as it is mapped. `limit` bounds the bytes of all sections together.
///
/// `unpack(pack(f)) = f` for a file `f` whose sections are all raw.
///
/// # Errors
/// [`RewriteError::Unknown`], and those of [`unpack_wanted`].
pub fn unpack(bytes: &[u8], limit: u64) -> Result<Vec<u8>, RewriteError> {
    unpack_wanted(&whole(bytes)?, |_| true, limit)
}

/// A raw file with the sections for which `wanted` holds, and nothing of the others. `limit` bounds the bytes
/// of the wanted sections together. Sections of kinds this program does not know are left out.
///
/// # Errors
/// [`RewriteError::TooLarge`], [`RewriteError::Frame`], [`RewriteError::Format`] (a section that does not
/// match its checksum; a structure that is left without a section it needs), [`RewriteError::Memory`].
pub fn unpack_wanted(
    file: &File<'_>,
    wanted: impl Fn(SectionKind) -> bool,
    limit: u64,
) -> Result<Vec<u8>, RewriteError> {
    check_total(file, &wanted, limit)?;
    for section in file.sections().filter(|section| wanted(section.kind())) {
        section.verify()?;
        prove(&section)?;
    }
    let mut memory = zeros(unpacked_len(file, &wanted)?)?;
    unpack_into(file, &wanted, &mut memory)?;
    Ok(memory)
}
