//! Rows of dashpots that couple modes.

use vademecum_format::{File, SectionKind};

use super::super::error::{Fault, RewriteError};
use super::super::numbers::{reals_of, unsound};

/// Section 79, if the file has it.
pub(super) fn check(file: &File<'_>) -> Result<(), RewriteError> {
    let (kind, metadata) = (SectionKind::DampingRows, file.metadata());
    let Some(numbers) = reals_of(file, kind)? else { return Ok(()) };
    if !metadata.diagonal || !metadata.scheme.is_exact() {
        let reason = "dashpots couple modes that are moved exactly, which the file does not have";
        return Err(unsound(kind, Fault::Disagrees, reason.into()));
    }
    let r = metadata.n_modes as usize;
    let rows = numbers.len() / r.max(1);
    if rows > r {
        let reason = format!("{rows} rows over {r} modes; no damping matrix needs more than {r}");
        return Err(unsound(kind, Fault::Disagrees, reason));
    }
    Ok(())
}
