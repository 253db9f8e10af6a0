//! Everything that can be said of a file without the problem it came from: it parses, every checksum holds,
//! every number is finite, names and indices fit the counts. Reads (and decodes) the whole file.

use std::collections::HashSet;

use vademecum_format::{AxisKind, Element, File, Metadata, Numbers, Section, SectionKind};

use super::codec::{self, DECODED_LIMIT, decode};
use super::error::RewriteError;
use super::whole::unknown_sections;

/// What a check has seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Checked {
    /// Bytes of the file.
    pub bytes: u64,
    /// Sections of known kinds, all checked.
    pub sections: usize,
    /// Sections of kinds this program does not know, which were skipped.
    pub unknown_sections: usize,
    /// Bytes of the known sections, decoded.
    pub decoded_bytes: u64,
    /// Real numbers found finite.
    pub numbers: u64,
}

/// Checks the bytes of a file.
///
/// # Errors
/// [`RewriteError`]: the first thing found wrong.
pub fn check(bytes: &[u8]) -> Result<Checked, RewriteError> {
    let file = File::parse(bytes)?;
    file.verify_all()?;
    codec::check_total(&file, DECODED_LIMIT)?;
    let mut checked = Checked {
        bytes: bytes.len() as u64,
        sections: 0,
        unknown_sections: unknown_sections(&file),
        decoded_bytes: 0,
        numbers: 0,
    };
    for section in file.sections() {
        let raw = decode(&section, DECODED_LIMIT)?;
        checked.sections += 1;
        checked.decoded_bytes += raw.len() as u64;
        checked.numbers += check_numbers(&section, &raw)?;
        check_meaning(&section, &raw, file.metadata())?;
    }
    Ok(checked)
}

/// The numbers of a section of reals, how many; 0 for the other elements.
fn check_numbers(section: &Section<'_>, raw: &[u8]) -> Result<u64, RewriteError> {
    let numbers = numbers(section, raw);
    let unknown = section.kind() == SectionKind::ModeTable && !numbers.iter().any(|x| x.is_infinite());
    let figures = matches!(section.kind(), SectionKind::CanonicalCertificate | SectionKind::StructureFigures);
    if figures || unknown {
        // What was not measured is NaN, as in the metadata: natural modes have no share of snapshots, and a
        // scheme may damp a mode so much that it has no period.
        return Ok(numbers.iter().filter(|x| x.is_finite()).count() as u64);
    }
    let bad = numbers.iter().position(|x| !x.is_finite());
    match bad {
        Some(place) => Err(RewriteError::NotFinite { kind: section.kind(), place, value: numbers[place] }),
        None => Ok(numbers.len() as u64),
    }
}

/// The real numbers of a decoded section; none for the other elements.
#[must_use]
pub fn numbers(section: &Section<'_>, raw: &[u8]) -> Vec<f64> {
    match section.element() {
        Element::I16 => {
            let numbers =
                Numbers::quantised(raw, section.shape()).expect("decoded to the length of its shape");
            numbers.iter().collect()
        }
        element => reals(element, raw),
    }
}

pub(super) fn reals(element: Element, raw: &[u8]) -> Vec<f64> {
    match element {
        Element::F32 => raw.as_chunks().0.iter().map(|&bytes| f64::from(f32::from_le_bytes(bytes))).collect(),
        Element::F64 => raw.as_chunks().0.iter().map(|&bytes| f64::from_le_bytes(bytes)).collect(),
        _ => vec![],
    }
}

fn check_meaning(section: &Section<'_>, raw: &[u8], metadata: &Metadata<'_>) -> Result<(), RewriteError> {
    match section.kind() {
        SectionKind::Triangles => check_triangles(raw, metadata),
        kind @ SectionKind::PatternNames => check_names(kind, raw, metadata.n_patterns),
        kind @ SectionKind::ProbeNames => check_names(kind, raw, metadata.n_probes),
        kind @ SectionKind::Repairs => lines(kind, raw).map(|_| ()),
        SectionKind::AxisPoints => check_points(&reals(section.element(), raw), metadata),
        _ => Ok(()),
    }
}

/// Triangles are made of surface nodes, those before `n_load_triangles` of loadable ones.
fn check_triangles(raw: &[u8], metadata: &Metadata<'_>) -> Result<(), RewriteError> {
    for (place, &bytes) in raw.as_chunks().0.iter().enumerate() {
        let index = u32::from_le_bytes(bytes);
        let loadable = place / 3 < metadata.n_load_triangles as usize;
        let count = if loadable { metadata.n_load_nodes } else { metadata.n_surface_nodes };
        if index >= count {
            return Err(RewriteError::Index { kind: SectionKind::Triangles, place, index, count });
        }
    }
    Ok(())
}

/// One name a line, as many as are counted, none empty, none twice.
fn check_names(kind: SectionKind, raw: &[u8], count: u32) -> Result<(), RewriteError> {
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

/// Points of an axis increase and lie within its range; those of an index axis are 0, 1, ….
fn check_points(points: &[f64], metadata: &Metadata<'_>) -> Result<(), RewriteError> {
    let mut rest = points;
    for (place, axis) in metadata.active_axes().iter().enumerate() {
        let (own, others) = rest.split_at(rest.len().min(axis.n_points as usize));
        rest = others;
        let sound = match axis.kind {
            AxisKind::Index => own.iter().enumerate().all(|(i, &x)| x == i as f64),
            _ => own.is_sorted_by(|a, b| a < b) && own.iter().all(|&x| axis.lower <= x && x <= axis.upper),
        };
        if !sound {
            return Err(RewriteError::Points { axis: place });
        }
    }
    Ok(())
}
