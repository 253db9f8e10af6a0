//! Names, one a line: as many as are counted, none empty, none twice.

use std::collections::HashSet;

use vademecum_format::{BASE_PATTERNS, File, SectionKind};

use super::super::error::RewriteError;

/// One name a line, as many as are counted, none empty, none twice.
pub(super) fn check_names(kind: SectionKind, raw: &[u8], count: u32) -> Result<(), RewriteError> {
    let refused = |reason| Err(RewriteError::Names { kind, reason });
    let names = lines(kind, raw)?;
    if names.len() != count as usize {
        return refused(format!("it has {} names, the metadata count {count}", names.len()));
    }
    let mut seen = HashSet::new();
    match names.into_iter().find(|&name| name.is_empty() || !seen.insert(name)) {
        Some("") => refused("a name is empty".to_string()),
        Some(name) => refused(format!("the name `{name}` occurs twice")),
        None => Ok(()),
    }
}

/// The lines of a decoded text, such as one name a line; an empty text has none.
///
/// # Errors
/// [`RewriteError::Names`]: bytes that are not UTF-8.
pub fn lines(kind: SectionKind, raw: &[u8]) -> Result<Vec<&str>, RewriteError> {
    let refused = |_| RewriteError::Names { kind, reason: "it is not UTF-8".to_string() };
    let text = std::str::from_utf8(raw).map_err(refused)?;
    Ok(if text.is_empty() { vec![] } else { text.split('\n').collect() })
}

/// The last patterns of a file whose base moves are its motions.
pub(super) fn check_base(file: &File<'_>) -> Result<(), RewriteError> {
    let names: Vec<&str> = file.pattern_names().collect();
    if file.section(SectionKind::BaseFrame).is_none() || names.ends_with(&BASE_PATTERNS) {
        return Ok(());
    }
    let reason = "the last twelve are not the motions of the base, `base.ax` to `base.wzwx`".to_string();
    Err(RewriteError::Names { kind: SectionKind::PatternNames, reason })
}
