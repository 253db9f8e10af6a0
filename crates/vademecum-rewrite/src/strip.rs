//! A file without what a target does not need.

use vademecum_format::SectionInput;

use super::error::RewriteError;
use super::keep::Keep;
use super::whole::{whole, write};

/// The file without the sections `keep` does not name. Codecs stay as they are.
///
/// # Errors
/// [`RewriteError::Format`], [`RewriteError::Unknown`]; [`RewriteError::Absent`] if what is to be kept is not
/// there; [`RewriteError::NothingToStrip`] if all of the file is to be kept.
pub fn strip(bytes: &[u8], keep: Keep) -> Result<Vec<u8>, RewriteError> {
    let file = whole(bytes)?;
    if let Some(&kind) = keep.needs().iter().find(|&&kind| file.section(kind).is_none()) {
        return Err(RewriteError::Absent { kind, keep });
    }
    let kept: Vec<SectionInput<'_>> =
        file.sections().filter(|section| keep.keeps(section.kind())).map(SectionInput::from).collect();
    if keep != Keep::All && kept.len() == file.sections().count() {
        return Err(RewriteError::NothingToStrip { keep });
    }
    write(&file, &kept)
}
