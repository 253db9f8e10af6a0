//! The basis: columns that are there and differ, quantised numbers as writers make them, and probes that do
//! not move further than any node.

use std::collections::HashMap;
use std::hash::{DefaultHasher, Hasher as _};

use vademecum_format::{Element, File, Numbers, Section, SectionKind};

use super::super::error::{Fault, RewriteError};
use super::super::numbers::{reals_of, unsound};

/// Products the rank of a basis may cost; of a larger one only zero and equal columns are looked for.
const MAX_PRODUCTS: u64 = 1 << 33;

/// Sections 6, 7, 9 and 14, as far as the file has them.
pub(super) fn check(file: &File<'_>) -> Result<(), RewriteError> {
    use SectionKind as S;
    for kind in [S::SurfaceBasis, S::InteriorBasis, S::BlockLoad] {
        if let Some(section) = file.section(kind) {
            quantised(&section)?;
        }
    }
    let Some(surface) = file.section(S::SurfaceBasis) else { return Ok(()) };
    let interior = file.section(S::InteriorBasis);
    let metadata = file.metadata();
    let complete = interior.is_some() || metadata.n_surface_nodes == metadata.n_nodes;
    let rows = Rows { r: metadata.n_modes as usize, sections: [Some(surface), interior] };
    if rows.sections.iter().flatten().any(|section| section.element() == Element::I16) {
        // A coarse rounding may leave nothing of a mode, or make two of them alike.
        return Ok(());
    }
    equal_columns(&rows)?;
    if !complete {
        // What is not here may tell columns apart, and may lie under a probe.
        return Ok(());
    }
    zero_columns(&rows)?;
    rank(&rows)?;
    let units = file.section(S::ProbeUnits).map(|section| section.text()).transpose()?.unwrap_or("");
    reals_of(file, S::ProbeRows)?.map_or(Ok(()), |probes| reach(&rows, &probes, units))
}

/// The rows of the basis that the file has: those of the surface, then those inside.
struct Rows<'a> {
    r: usize,
    sections: [Option<Section<'a>>; 2],
}

impl Rows<'_> {
    /// Hands out every row, `r` numbers each.
    fn each(&self, mut visit: impl FnMut(&[f64])) -> Result<(), RewriteError> {
        let mut row = Vec::with_capacity(self.r);
        for section in self.sections.iter().flatten() {
            for value in section.numbers()?.iter() {
                row.push(value);
                if row.len() == self.r {
                    visit(&row);
                    row.clear();
                }
            }
        }
        Ok(())
    }

    fn count(&self) -> u64 {
        self.sections.iter().flatten().map(|section| 3 * section.shape()[0]).sum()
    }
}

/// Scales are positive normal numbers, integers at least −32 767.
fn quantised(section: &Section<'_>) -> Result<(), RewriteError> {
    let Numbers::I16(numbers) = section.numbers()? else { return Ok(()) };
    for (block, (scales, integers)) in numbers.blocks().enumerate() {
        let sound = |scale: &[u8; 4]| {
            let scale = f32::from_le_bytes(*scale);
            scale.is_normal() && scale > 0.0
        };
        if let Some(column) = scales.iter().position(|scale| !sound(scale)) {
            let scale = f32::from_le_bytes(scales[column]);
            let reason = format!(
                "the scale of column {column}, block {block} is {scale:e}; scales are positive normal numbers"
            );
            return Err(unsound(section.kind(), Fault::Quantised, reason));
        }
        if let Some(place) = integers.iter().position(|&x| i16::from_le_bytes(x) == i16::MIN) {
            let reason = format!("integer {place} of block {block} is −32768; the least is −32767");
            return Err(unsound(section.kind(), Fault::Quantised, reason));
        }
    }
    Ok(())
}

/// No two columns are equal, number for number, but for columns of zeros (held or not in this part).
fn equal_columns(rows: &Rows<'_>) -> Result<(), RewriteError> {
    let mut marks: Vec<(DefaultHasher, bool)> = vec![(DefaultHasher::new(), false); rows.r];
    rows.each(|row| {
        for ((hash, moves), value) in marks.iter_mut().zip(row) {
            hash.write_u64(value.to_bits());
            *moves |= *value != 0.0;
        }
    })?;
    let mut seen = HashMap::new();
    for (k, (hash, _)) in marks.iter().enumerate().filter(|(_, mark)| mark.1) {
        if let Some(other) = seen.insert(hash.finish(), k) {
            let reason = format!("columns {other} and {k} are the same");
            return Err(unsound(SectionKind::SurfaceBasis, Fault::Twice, reason));
        }
    }
    Ok(())
}

fn zero_columns(rows: &Rows<'_>) -> Result<(), RewriteError> {
    let mut moves = vec![false; rows.r];
    rows.each(|row| moves.iter_mut().zip(row).for_each(|(moves, x)| *moves |= *x != 0.0))?;
    match moves.iter().position(|moves| !moves) {
        None => Ok(()),
        Some(k) => {
            let reason = format!("column {k} is zero at every node");
            Err(unsound(SectionKind::SurfaceBasis, Fault::Dependent, reason))
        }
    }
}

/// The columns are independent: their Gram matrix, scaled to a diagonal of ones, keeps positive pivots. A sum
/// of `n` squares is known to about `√n 2⁻⁵²`, and elimination adds up `r` such errors; of a pivot below 16
/// times that nothing is left.
fn rank(rows: &Rows<'_>) -> Result<(), RewriteError> {
    let (r, n) = (rows.r, rows.count());
    if n.saturating_mul(r as u64 * r as u64) > MAX_PRODUCTS {
        return Ok(());
    }
    // Unit size first: the numbers have a unit, and a small body has large ones.
    let mut largest = vec![0.0f64; r];
    rows.each(|row| largest.iter_mut().zip(row).for_each(|(m, x)| *m = m.max(x.abs())))?;
    let mut gram = vec![0.0; r * r];
    let mut scaled = vec![0.0; r];
    rows.each(|row| {
        scaled.iter_mut().zip(row.iter().zip(&largest)).for_each(|(s, (x, m))| *s = x / m);
        for (own, x) in gram.chunks_exact_mut(r).zip(&scaled).filter(|(_, x)| **x != 0.0) {
            own.iter_mut().zip(&scaled).for_each(|(g, y)| *g += x * y);
        }
    })?;
    let norms: Vec<f64> = (0..r).map(|k| gram[k * r + k].sqrt()).collect();
    gram.iter_mut().enumerate().for_each(|(i, g)| *g /= norms[i / r] * norms[i % r]);
    let least = 16.0 * r as f64 * (n as f64).sqrt() * f64::EPSILON;
    for k in 0..r {
        let (above, below) = gram.split_at_mut((k + 1) * r);
        let row = &above[k * r..];
        if row[k] <= least {
            let reason = format!("column {k} is a combination of those before it");
            return Err(unsound(SectionKind::SurfaceBasis, Fault::Dependent, reason));
        }
        for own in below.chunks_exact_mut(r) {
            let share = own[k] / row[k];
            own[k..].iter_mut().zip(&row[k..]).for_each(|(x, y)| *x -= share * y);
        }
    }
    Ok(())
}

/// A probe may lie outside the nodes, at a reference point that moves further than all of them.
const OUTSIDE: f64 = 1e3;

/// A displacement is that of a node along a direction of length 1, or of a reference point: in no mode it is
/// [`OUTSIDE`] times that of the node that moves furthest. Strains have no such bound. Rows in binary32 are
/// off by 2⁻²⁴ of themselves, quantised ones by half a step in each component.
fn reach(rows: &Rows<'_>, probes: &[f64], units: &str) -> Result<(), RewriteError> {
    let r = rows.r;
    let (mut furthest, mut squares, mut place) = (vec![0.0f64; r], vec![0.0f64; r], 0);
    rows.each(|row| {
        squares.iter_mut().zip(row).for_each(|(s, x)| *s += x * x);
        place += 1;
        if place % 3 == 0 {
            furthest.iter_mut().zip(&squares).for_each(|(f, s)| *f = f.max(s.sqrt()));
            squares.fill(0.0);
        }
    })?;
    let steps = steps(rows)?;
    let allowed = |k: usize| OUTSIDE * (furthest[k] + 3.0 * steps[k]);
    let units: Vec<&str> = units.lines().collect();
    let length = |i: usize| units.get(i / r).is_none_or(|unit| *unit == "m");
    match probes.iter().enumerate().find(|&(i, x)| length(i) && x.abs() > allowed(i % r)) {
        None => Ok(()),
        Some((i, value)) => {
            let (probe, mode) = (i / r, i % r);
            let reason = format!(
                "probe {probe} moves by {value:e} in mode {mode}, more than a thousand times any node, {:e}",
                furthest[mode]
            );
            Err(unsound(SectionKind::ProbeRows, Fault::Disagrees, reason))
        }
    }
}

/// The largest step of quantised numbers in each column; 0 where they are not quantised.
fn steps(rows: &Rows<'_>) -> Result<Vec<f64>, RewriteError> {
    let mut steps = vec![0.0f64; rows.r];
    for section in rows.sections.iter().flatten() {
        let Numbers::I16(numbers) = section.numbers()? else { continue };
        for (column, scale) in numbers.blocks().flat_map(|(scales, _)| scales.iter().enumerate()) {
            let step = &mut steps[column % rows.r];
            *step = step.max(f64::from(f32::from_le_bytes(*scale)));
        }
    }
    Ok(steps)
}
