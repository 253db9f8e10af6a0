//! Contacts near each other give no energy away: the matrix of the flexibility between them is positive
//! semidefinite.

use faer::{Mat, Side};
use serde::Serialize;
use vademecum_format::{File, SectionKind as S, taper};
use vademecum_rewrite::{Fault, RewriteError, numbers};

use crate::error::StudyError;

/// Nodes that are tried together at most.
const GROUP: usize = 1000;
/// Share of the largest eigenvalue below zero that an eigenvalue may be: rounding to binary32 takes less.
const NEGATIVE: f64 = 1e-6;
/// Rounding of the static answer, from which the residual is what the modes leave.
const ROUNDING: f64 = 1.0 / (1u64 << 40) as f64;
/// Steps of a power iteration for the size of a matrix, which it finds from below.
const STEPS: usize = 30;

/// Loadable nodes of a file as contacts, all with each other.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct PatchSoundness {
    /// Distance at which contacts have nothing but further modes between them \[m\].
    pub distance: f64,
    /// Loadable nodes, each a contact.
    pub contacts: usize,
    /// Groups of nodes that were tried, each by itself.
    pub groups: usize,
}

/// Sections that are read.
pub(super) fn is_needed(kind: S) -> bool {
    let own = [S::ContactModes, S::PatchPairs, S::PatchResidual, S::ContactPatch];
    own.contains(&kind) || matches!(kind, S::NodeCoordinates | S::SurfaceBasis | S::Eigenvalues)
}

/// Tries all loadable nodes as contacts, in overlapping groups where they are many; `None` of a file without
/// sections 107 to 110, and of one without the places of nodes.
///
/// # Errors
/// An eigenvalue below zero by more than a millionth of the largest.
pub(super) fn check(file: &File<'_>) -> Result<Option<PatchSoundness>, StudyError> {
    let places = reals(file, S::NodeCoordinates)?;
    let Some(patch) = file.contact_patch()?.filter(|_| !places.is_empty()) else { return Ok(None) };
    let n = file.metadata().n_load_nodes as usize;
    let (places, m) = (places.as_chunks::<3>().0, patch.n_modes);
    let modes = reals(file, S::ContactModes)?;
    let modal = modal_diagonal(file)?;
    let pairs: Vec<[usize; 2]> =
        patch.pairs.iter().map(|pair| pair.map(|node| u32::from_le_bytes(node) as usize)).collect();
    let blocks = reals(file, S::PatchResidual)?;
    let mut groups = 0;
    loop {
        let start = groups * GROUP / 2;
        let end = (start + GROUP).min(n);
        let count = 3 * (end - start);
        let row = |i: usize| &modes[(3 * start + i) * m..(3 * start + i + 1) * m];
        let dot = |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
        let mut matrix = Mat::from_fn(count, count, |i, j| if i >= j { dot(row(i), row(j)) } else { 0.0 });
        let first = pairs.partition_point(|pair| pair[0] < start);
        let rest = pairs[first..].iter().zip(blocks.as_chunks::<9>().0[first..].iter());
        for (&[a, b], block) in rest.take_while(|(pair, _)| pair[0] < end).filter(|(pair, _)| pair[1] < end) {
            let apart = (0..3).map(|c| (places[a][c] - places[b][c]).powi(2)).sum::<f64>().sqrt();
            let share = taper(apart / patch.distance);
            for (at, value) in block.iter().enumerate() {
                let [i, j] = [3 * (a - start) + at / 3, 3 * (b - start) + at % 3];
                // The lower half alone; a block of one node has both.
                if a < b || j <= i {
                    matrix[(i.max(j), i.min(j))] += share * value;
                }
            }
        }
        let own: f64 = modal.get(start..end).unwrap_or_default().iter().sum();
        let shift = NEGATIVE * largest(&matrix) + ROUNDING * own;
        (0..count).for_each(|i| matrix[(i, i)] += shift);
        if shift > 0.0 && matrix.llt(Side::Lower).is_err() {
            let reason = format!(
                "contacts at the nodes {start} to {} take a negative value together, below {:e}; expected a \
                 positive semidefinite matrix",
                end - 1,
                -shift
            );
            return Err(
                RewriteError::Unsound { kind: S::PatchResidual, fault: Fault::Negative, reason }.into()
            );
        }
        groups += 1;
        if end == n {
            return Ok(Some(PatchSoundness { distance: patch.distance, contacts: n, groups }));
        }
    }
}

/// The sum over the three components of what the modes of the file answer at each loadable node.
fn modal_diagonal(file: &File<'_>) -> Result<Vec<f64>, StudyError> {
    let (basis, eigenvalues) = (reals(file, S::SurfaceBasis)?, reals(file, S::Eigenvalues)?);
    let answer = |rows: &[f64]| -> f64 {
        rows.iter().enumerate().map(|(at, x)| x * x / eigenvalues[at % eigenvalues.len()]).sum()
    };
    let rows = basis.chunks_exact(3 * eigenvalues.len().max(1));
    Ok(rows.map(answer).map(|sum| if sum.is_finite() { sum.max(0.0) } else { 0.0 }).collect())
}

/// The largest eigenvalue of a symmetric matrix given by its lower half, from below.
fn largest(lower: &Mat<f64>) -> f64 {
    let n = lower.nrows();
    let whole = Mat::from_fn(n, n, |i, j| lower[(i.max(j), i.min(j))]);
    // All components, and none alike.
    let mut vector = Mat::from_fn(n, 1, |i, _| 1.0 + (i % 7) as f64 / 8.0 - f64::from(u8::from(i % 3 == 1)));
    let mut size = 0.0;
    for _ in 0..STEPS {
        let length = vector.norm_l2();
        if length == 0.0 {
            break;
        }
        vector *= faer::Scale(1.0 / length);
        let image = &whole * &vector;
        size = (vector.transpose() * &image)[(0, 0)];
        vector = image;
    }
    f64::max(size, 0.0)
}

/// The decoded numbers of a raw section; none if the file does not have it.
fn reals(file: &File<'_>, kind: S) -> Result<Vec<f64>, StudyError> {
    let Some(section) = file.section(kind) else { return Ok(vec![]) };
    Ok(numbers(&section, section.raw()?)?)
}
