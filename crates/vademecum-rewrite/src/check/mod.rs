//! Everything that can be said of a file without the problem it came from: it parses, every checksum holds,
//! every number is finite, names and indices fit the counts, and sections do not contradict one another or
//! what a body is. Reads (and decodes) the whole file. `formats/vademecum-1.md` lists the checks.

mod basis;
mod claims;
mod dashpots;
mod embedded;
mod factor;
mod geometry;
mod live;
mod matrices;
mod names;
mod patch;
mod ports;
mod quadrangles;
mod reactions;
mod residual;
mod rigid;
mod step;
mod strain;
mod stress;
mod symmetric;

use vademecum_format::{AxisKind, Codec, Element, File, Metadata, Section, SectionKind};

use super::codec::default_limit;
use super::error::{Fault, RewriteError};
use super::numbers::{reals, unsound};
use super::unpack::unpack_wanted;
use super::whole::unknown_sections;

use names::check_names;

pub use geometry::check_coordinates;
pub use names::lines;

/// Result of a check.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
pub struct CheckReport {
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

/// Largest size of a real number in a file: its square is finite.
const LARGEST: f64 = f64::from_bits((1023 + 511) << 52); // 2⁵¹¹

/// Checks the bytes of a file, whose sections decode to [`default_limit`] bytes at most.
///
/// # Errors
/// [`RewriteError`]: the first thing found wrong.
pub fn check(bytes: &[u8]) -> Result<CheckReport, RewriteError> {
    check_limited(bytes, default_limit(bytes.len()))
}

/// Checks the bytes of a file, whose sections decode to `limit` bytes at most.
///
/// The time is that of reading the file, beside `n r²` products for `n` nodes (at most 2³³) and `r³` for
/// each reduced matrix.
///
/// # Errors
/// [`RewriteError`]: the first thing found wrong.
pub fn check_limited(bytes: &[u8], limit: u64) -> Result<CheckReport, RewriteError> {
    let file = File::parse(bytes)?;
    file.verify_all()?;
    let memory;
    // Tables of a packed file are checked when they are raw: by opening what is unpacked.
    let raw = if file.sections().all(|section| section.codec() == Codec::Raw) {
        file
    } else {
        memory = unpack_wanted(&file, |_| true, limit)?;
        let raw = File::parse(&memory)?;
        raw.verify_indices()?;
        raw
    };
    let mut checked = CheckReport {
        bytes: bytes.len() as u64,
        sections: 0,
        unknown_sections: unknown_sections(&file),
        decoded_bytes: 0,
        numbers: 0,
    };
    for section in raw.sections() {
        checked.sections += 1;
        checked.decoded_bytes += section.decoded_length();
        checked.numbers += check_numbers(&section)?;
        check_meaning(&section, raw.metadata())?;
    }
    geometry::check(&raw)?;
    quadrangles::check(&raw)?;
    embedded::check(&raw)?;
    matrices::check(&raw)?;
    basis::check(&raw)?;
    step::check(&raw)?;
    residual::check(&raw)?;
    factor::check(&raw)?;
    rigid::check(&raw)?;
    dashpots::check(&raw)?;
    ports::check(&raw)?;
    patch::check(&raw)?;
    live::check(&raw)?;
    strain::check(&raw)?;
    stress::check(&raw)?;
    reactions::check(&raw)?;
    names::check_base(&raw)?;
    claims::check(&raw)?;
    Ok(checked)
}

/// The numbers of a section of reals, how many; 0 for the other elements.
fn check_numbers(section: &Section<'_>) -> Result<u64, RewriteError> {
    let kind = section.kind();
    if !matches!(section.element(), Element::F32 | Element::F64 | Element::I16) {
        return Ok(0);
    }
    let mut count = 0;
    for (place, value) in section.numbers()?.iter().enumerate() {
        if value.is_finite() {
            count += 1;
        } else if !(value.is_nan() && may_be_unmeasured(kind, place)) {
            return Err(RewriteError::NotFinite { kind, place, value });
        }
        if value.abs() > LARGEST && value.is_finite() {
            let reason = format!("number {place} is {value:e}, whose square is not finite");
            return Err(unsound(kind, Fault::Magnitude, reason));
        }
    }
    Ok(count)
}

/// True for a number that may be NaN for "not measured", as in the metadata: those of a certificate,
/// and of a mode its energy share (natural modes have no snapshots), damping ratios and elongation.
fn may_be_unmeasured(kind: SectionKind, place: usize) -> bool {
    match kind {
        SectionKind::CanonicalCertificate | SectionKind::StructureFigures => true,
        SectionKind::ModeTable => place % 6 >= 2,
        _ => false,
    }
}

fn check_meaning(section: &Section<'_>, metadata: &Metadata<'_>) -> Result<(), RewriteError> {
    let raw = section.raw()?;
    match section.kind() {
        kind @ SectionKind::PatternNames => check_names(kind, raw, metadata.n_patterns),
        kind @ SectionKind::ProbeNames => check_names(kind, raw, metadata.n_probes),
        kind @ SectionKind::Repairs => lines(kind, raw).map(|_| ()),
        SectionKind::AxisPoints => check_points(&reals(section.element(), raw)?, metadata),
        _ => Ok(()),
    }
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
