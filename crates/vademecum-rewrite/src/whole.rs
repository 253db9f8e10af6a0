//! Whole files: what is read before anything is rewritten, and what is written in the end.

use vademecum_format::{File, Metadata, SectionInput, encode_into, encoded_len};

use super::codec::zeros;
use super::error::RewriteError;

/// The file, undamaged, if every section of it is known.
pub(crate) fn whole(bytes: &[u8]) -> Result<File<'_>, RewriteError> {
    let file = File::parse(bytes)?;
    file.verify_all()?;
    match unknown_sections(&file) {
        0 => Ok(file),
        count => Err(RewriteError::Unknown { count }),
    }
}

/// Sections of kinds this program does not know.
pub(crate) fn unknown_sections(file: &File<'_>) -> usize {
    file.n_sections().saturating_sub(file.sections().count())
}

/// The bytes of a file with the metadata of another.
pub(crate) fn write(file: &File<'_>, sections: &[SectionInput<'_>]) -> Result<Vec<u8>, RewriteError> {
    write_with(file.metadata(), sections)
}

/// The bytes of a file.
pub(crate) fn write_with(
    metadata: &Metadata<'_>,
    sections: &[SectionInput<'_>],
) -> Result<Vec<u8>, RewriteError> {
    let mut bytes = zeros(encoded_len(metadata, sections)?)?;
    encode_into(metadata, sections, &mut bytes)?;
    Ok(bytes)
}
