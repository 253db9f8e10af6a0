//! Real numbers of sections, and what to say of wrong ones.

use vademecum_format::{Element, File, FormatError, Numbers, Section, SectionKind};

use super::codec::{decode, room};
use super::error::{Fault, RewriteError};

/// The real numbers of a decoded section; none for the other elements.
///
/// # Errors
/// [`RewriteError::Memory`]; [`RewriteError::Format`] if there are not as many as the shape says.
pub fn numbers(section: &Section<'_>, raw: &[u8]) -> Result<Vec<f64>, RewriteError> {
    match section.element() {
        Element::I16 => {
            let (found, expected) = (raw.len() as u64, section.decoded_length());
            let wrong = FormatError::Length { kind: section.kind().number(), found, expected };
            collected(Numbers::quantised(raw, section.shape()).ok_or(wrong)?)
        }
        element => reals(element, raw),
    }
}

/// Decoded numbers of a section; `None` if it is absent. The caller has held the file to a limit.
pub(super) fn decoded_of(file: &File<'_>, kind: SectionKind) -> Result<Option<Vec<f64>>, RewriteError> {
    let Some(section) = file.section(kind) else { return Ok(None) };
    let raw = decode(&section, u64::MAX)?;
    Ok(Some(numbers(&section, &raw)?))
}

fn collected(numbers: Numbers<'_>) -> Result<Vec<f64>, RewriteError> {
    let mut values = room(numbers.len())?;
    values.extend(numbers.iter());
    Ok(values)
}

pub(crate) fn reals(element: Element, raw: &[u8]) -> Result<Vec<f64>, RewriteError> {
    match element {
        Element::F32 => collected(Numbers::F32(raw.as_chunks().0)),
        Element::F64 => collected(Numbers::F64(raw.as_chunks().0)),
        _ => Ok(vec![]),
    }
}

/// The real numbers of a raw section; none if the file does not have it.
pub(crate) fn reals_of(file: &File<'_>, kind: SectionKind) -> Result<Option<Vec<f64>>, RewriteError> {
    file.section(kind).map(|section| collected(section.numbers()?)).transpose()
}

/// A fault in a section.
pub(crate) fn unsound(kind: SectionKind, fault: Fault, reason: String) -> RewriteError {
    RewriteError::Unsound { kind, fault, reason }
}
