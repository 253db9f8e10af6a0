//! A file as it is shipped: each section in its smallest coding, without loss or within a tolerance.

use vademecum_format::{Codec, Element, File, Section, SectionInput, SectionKind};

use super::codec::{check_total, decode, default_limit, smallest};
use super::contact::NodeLimits;
use super::error::RewriteError;
use super::numbers::decoded_of;
use super::round::{Loss, Measure, may_be_rounded, quantise, single, trimmed};
use super::whole::{whole, write};

/// A section as it will be written.
struct Packed<'a> {
    section: Section<'a>,
    element: Element,
    codec: Codec,
    decoded_length: u64,
    stored: Vec<u8>,
}

/// The file with each section in the codec that makes it smallest, raw where none does. `level` is zstd's, 1
/// to 22.
///
/// The same input, level and version of zstd give the same bytes.
///
/// # Errors
/// [`RewriteError::Level`], [`RewriteError::Format`], [`RewriteError::Unknown`], [`RewriteError::Frame`],
/// [`RewriteError::TooLarge`].
pub fn pack(bytes: &[u8], level: i32) -> Result<Vec<u8>, RewriteError> {
    pack_limited(bytes, level, None, default_limit(bytes.len()))
}

/// [`pack`], and sections of numbers over nodes rounded to 16 bits with scales, or to binary32, as far as
/// every field stays within `tolerance` (relative, root of the mean square over nodes), and what a force at
/// any loadable node does, and stress beside the largest of its field. What it cost is measured and kept in
/// section Losses; a section that was rounded before stays. Probes, patterns and the step stay as they are.
///
/// # Errors
/// Those of [`pack`], and [`RewriteError::Tolerance`].
pub fn pack_within(bytes: &[u8], level: i32, tolerance: f64) -> Result<Vec<u8>, RewriteError> {
    pack_limited(bytes, level, Some(tolerance), default_limit(bytes.len()))
}

/// [`pack`], or with a tolerance [`pack_within`], of a file whose sections decode to `limit` bytes at most.
///
/// # Errors
/// Those of [`pack_within`].
pub fn pack_limited(
    bytes: &[u8],
    level: i32,
    tolerance: Option<f64>,
    limit: u64,
) -> Result<Vec<u8>, RewriteError> {
    if let Some(tolerance) = tolerance.filter(|tolerance| !(1e-12..=0.1).contains(tolerance)) {
        return Err(RewriteError::Tolerance { tolerance });
    }
    if !(1..=22).contains(&level) {
        return Err(RewriteError::Level { level });
    }
    let file = whole(bytes)?;
    check_total(&file, |_| true, limit)?;
    let (mut packed, mut new) = (vec![], vec![]);
    let rounded_before = read_losses(&file)?;
    for section in file.sections() {
        let is_exact = rounded_before.iter().all(|(kind, _)| *kind != section.kind());
        let (best, loss) = pack_section(&file, &section, level, tolerance.filter(|_| is_exact))?;
        new.extend(loss.map(|loss| (section.kind(), loss)));
        packed.push(best);
    }
    // Nothing rounded: the section of losses is one like any other.
    let table = if new.is_empty() { vec![] } else { losses_bytes(&merged(rounded_before, new)) };
    let losses = losses_shape(&table);
    let (codec, stored) = smallest(&table, Element::F64, losses, level)?;
    packed.retain(|p| table.is_empty() || p.section.kind() != SectionKind::Losses);
    let mut inputs: Vec<SectionInput<'_>> = packed
        .iter()
        .map(|p| SectionInput {
            element: p.element,
            codec: p.codec,
            decoded_length: p.decoded_length,
            stored: &p.stored,
            ..p.section.into()
        })
        .collect();
    if !table.is_empty() {
        inputs.push(SectionInput {
            kind: SectionKind::Losses,
            element: Element::F64,
            codec,
            required: false,
            shape: losses,
            decoded_length: table.len() as u64,
            stored: &stored,
        });
    }
    write(&file, &inputs)
}

/// Known losses, but for those of sections rounded anew.
fn merged(mut known: Vec<(SectionKind, Loss)>, new: Vec<(SectionKind, Loss)>) -> Vec<(SectionKind, Loss)> {
    known.retain(|(kind, _)| new.iter().all(|(other, _)| other != kind));
    known.extend(new);
    known
}

/// The smallest way to store a section, and its loss if that rounds it.
fn pack_section<'a>(
    file: &File<'a>,
    section: &Section<'a>,
    level: i32,
    tolerance: Option<f64>,
) -> Result<(Packed<'a>, Option<Loss>), RewriteError> {
    let raw = decode(section, u64::MAX)?; // all of them were held to the limit
    let coded = |element: Element, raw: &[u8]| -> Result<Packed<'a>, RewriteError> {
        let (codec, stored) = smallest(raw, element, section.shape(), level)?;
        Ok(Packed { section: *section, element, codec, decoded_length: raw.len() as u64, stored })
    };
    let mut best = (coded(section.element(), &raw)?, None);
    let Some(tolerance) = tolerance.filter(|_| may_be_rounded(section.kind())) else { return Ok(best) };
    for (element, bytes, loss) in rounded(file, section, &raw, tolerance)? {
        let candidate = coded(element, &bytes)?;
        if candidate.stored.len() < best.0.stored.len() {
            best = (candidate, Some(loss));
        }
    }
    Ok(best)
}

/// The ways to round a section of binary32 or binary64 numbers that keep the tolerance.
fn rounded(
    file: &File<'_>,
    section: &Section<'_>,
    raw: &[u8],
    tolerance: f64,
) -> Result<Vec<(Element, Vec<u8>, Loss)>, RewriteError> {
    let values = match section.element() {
        Element::F32 | Element::F64 => super::numbers::reals(section.element(), raw)?,
        _ => return Ok(vec![]),
    };
    if values.is_empty() {
        return Ok(vec![]);
    }
    if section.kind() == SectionKind::NodeCoordinates {
        let (bytes, rounded) = single(&values);
        let loss = Loss { displacement: moved(&values, &rounded), ..Loss::default() };
        let sound = section.element() == Element::F64 && loss.within(tolerance);
        return Ok(if sound { vec![(Element::F32, bytes, loss)] } else { vec![] });
    }
    let Some(measure) = measure(file, section, &values)? else { return Ok(vec![]) };
    let mut ways = vec![];
    if let Some((bytes, loss)) = quantise(&values, &measure, tolerance) {
        ways.push((Element::I16, bytes, loss));
    }
    if let Some((bytes, loss)) = trimmed(&values, &measure, tolerance) {
        ways.push((Element::F32, bytes, loss));
    }
    if section.element() == Element::F64 {
        let (bytes, rounded) = single(&values);
        let loss = measure.loss(&values, &rounded);
        if loss.within(tolerance) {
            ways.push((Element::F32, bytes, loss));
        }
    }
    Ok(ways)
}

/// Largest change of a coordinate over the longest side of the body.
fn moved(exact: &[f64], rounded: &[f64]) -> f64 {
    let off = exact.iter().zip(rounded).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    let side = |axis: usize| {
        let along = exact.iter().skip(axis).step_by(3);
        let (low, high) =
            along.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &x| (low.min(x), high.max(x)));
        high - low
    };
    if off == 0.0 { 0.0 } else { off / (0..3).map(side).fold(0.0, f64::max) }
}

/// Reference magnitude for the errors of a section; `None` if the file cannot say (no basis to the loads, no
/// numbers).
fn measure(file: &File<'_>, section: &Section<'_>, values: &[f64]) -> Result<Option<Measure>, RewriteError> {
    let r = file.metadata().n_modes as usize;
    let squares = |rows: &[f64]| {
        let mut squares = vec![0.0; r];
        rows.iter().enumerate().for_each(|(i, x)| squares[i % r] += x * x);
        squares
    };
    let (squares, terms) = if section.kind() == SectionKind::BlockLoad {
        let Some(basis) = decoded_of(file, SectionKind::SurfaceBasis)? else { return Ok(None) };
        let load_rows = 3 * file.metadata().n_load_nodes as usize * r;
        (squares(&basis[..load_rows.min(basis.len())]), term_strengths(file)?)
    } else {
        let rows_of_three = if section.kind() == SectionKind::StressBasis { 2 } else { 1 };
        (squares(values), vec![1.0; rows_of_three])
    };
    let sound = squares.iter().chain(&terms).all(|x| x.is_normal());
    let nodes = match section.kind() {
        SectionKind::SurfaceBasis => NodeLimits::of(file, values, eigenvalues(file)?.as_deref())?,
        SectionKind::BlockLoad => {
            let basis = decoded_of(file, SectionKind::SurfaceBasis)?.unwrap_or_default();
            NodeLimits::of(file, &basis, eigenvalues(file)?.as_deref())?
        }
        _ => None,
    };
    let pointwise = section.kind() == SectionKind::StressBasis;
    Ok(sound.then_some(Measure { shares: shares(file)?, squares, terms, nodes, pointwise }))
}

/// Rayleigh quotients of the modes, where all of them are positive numbers.
fn eigenvalues(file: &File<'_>) -> Result<Option<Vec<f64>>, RewriteError> {
    let table = decoded_of(file, SectionKind::ModeTable)?.unwrap_or_default();
    let values: Vec<f64> = table.as_chunks::<6>().0.iter().map(|row| row[1]).collect();
    let usable = values.len() == file.metadata().n_modes as usize
        && values.iter().all(|value| *value > 0.0 && value.is_finite());
    Ok(usable.then_some(values))
}

/// `s_k` and `s_k λ_k` from the table of modes; all the same without one.
fn shares(file: &File<'_>) -> Result<[Vec<f64>; 2], RewriteError> {
    let r = file.metadata().n_modes as usize;
    let table = decoded_of(file, SectionKind::ModeTable)?.unwrap_or_default();
    let row = |k: usize| table.get(6 * k..6 * k + 6).map_or((1.0, 1.0), |row| (row[2], row[1]));
    let usable =
        (0..r).all(|k| row(k).0 >= 0.0 && row(k).0.is_finite() && row(k).1 > 0.0 && row(k).1.is_finite());
    let row = |k: usize| if usable { row(k) } else { (1.0, 1.0) };
    // A share of zero would ask for no bits at all: the bound on single modes rules there.
    let share = |k: usize| row(k).0.max(1e-30);
    Ok([(0..r).map(share).collect(), (0..r).map(|k| share(k) * row(k).1).collect()])
}

/// The largest product of factors of each term over the points of the axes.
pub(super) fn term_strengths(file: &File<'_>) -> Result<Vec<f64>, RewriteError> {
    let metadata = file.metadata();
    let factors = decoded_of(file, SectionKind::Factors)?.unwrap_or_default();
    let terms = metadata.n_terms as usize;
    let mut strengths = vec![1.0; terms];
    let mut rest = &factors[..];
    for axis in metadata.active_axes() {
        let points = axis.n_points as usize;
        let (own, others) = rest.split_at(rest.len().min(terms * points));
        rest = others;
        for (strength, row) in strengths.iter_mut().zip(own.chunks_exact(points.max(1))) {
            *strength *= row.iter().fold(0.0, |m: f64, g| m.max(g.abs()));
        }
    }
    Ok(strengths)
}

/// Errors of earlier rewriting, by section.
///
/// # Errors
/// [`RewriteError::Frame`], [`RewriteError::TooLarge`].
pub fn read_losses(file: &File<'_>) -> Result<Vec<(SectionKind, Loss)>, RewriteError> {
    check_total(file, |kind| kind == SectionKind::Losses, default_limit(file.bytes().len()))?;
    let table = decoded_of(file, SectionKind::Losses)?.unwrap_or_default();
    let row = |row: &[f64; 4]| {
        let kind = SectionKind::from_number(row[0] as u32)?;
        Some((kind, Loss { displacement: row[1], velocity: row[2], worst_mode: row[3] }))
    };
    Ok(table.as_chunks().0.iter().filter_map(row).collect())
}

fn losses_bytes(losses: &[(SectionKind, Loss)]) -> Vec<u8> {
    let row = |(kind, loss): &(SectionKind, Loss)| {
        [f64::from(kind.number()), loss.displacement, loss.velocity, loss.worst_mode]
    };
    losses.iter().flat_map(row).flat_map(f64::to_le_bytes).collect()
}

fn losses_shape(table: &[u8]) -> [u64; 3] {
    [table.len() as u64 / 32, 4, 1]
}
