//! Space sections rounded: to 16-bit numbers with scales, or to binary32 with as many digits as a tolerance
//! asks for, and what that costs.
//!
//! A field is `Σ_k ζ_k B_k`. Rounding errors `δ_k` of the columns that are small beside every single column,
//!
//! ```text
//! |δ_k| ≤ t |B_k|        (root of the mean square over the nodes of the section)
//! ```
//!
//! are small beside every field. The rows of loadable nodes also turn a force into modal forces, and near a
//! support they are small beside the rest of the column. Their errors are held to their own row,
//!
//! ```text
//! 4 Σ_k δ_ikᵀ C_i⁻¹ δ_ik / λ_k ≤ t²,        C_i = Σ_k B_ik B_ikᵀ / λ_k + R_i
//! ```
//!
//! with the compliance of the node, so that it holds in every direction, and the same with `1/λ_k²` for the
//! field of a force there: the displacement under a contact, its field and its reactions keep the tolerance.
//! A stress is held to the largest of each mode: `4 |δ_k| ≤ t max |S_k|` at every point.

use vademecum_format::{BLOCK_NODES, SectionKind};

use super::contact::NodeLimits;

/// Largest quantised number.
const LARGEST: f64 = i16::MAX as f64;

/// Relative errors of rounding a section.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct Loss {
    /// Of displacement fields, of what a force at a loadable node does, and of a stress beside its largest.
    pub displacement: f64,
    /// Of velocity fields.
    pub velocity: f64,
    /// Of the worst single mode.
    pub worst_mode: f64,
}

impl Loss {
    /// True if it is within a tolerance on fields.
    pub(super) fn within(&self, tolerance: f64) -> bool {
        self.displacement <= tolerance && self.worst_mode <= tolerance
    }
}

/// Reference magnitudes for errors: mean squares of the coordinates, `|B_k|²` over the nodes, for loads how
/// strongly each term counts.
pub(super) struct Measure {
    /// `s_k`, and `s_k λ_k`.
    pub shares: [Vec<f64>; 2],
    /// `|B_k|²`.
    pub squares: Vec<f64>,
    /// Largest product of factors of each term; `[1.0]` for a basis, and twice that for the six rows of a
    /// stress.
    pub terms: Vec<f64>,
    /// Limits of the rows of loadable nodes.
    pub nodes: Option<NodeLimits>,
    /// True of a stress, which is held at every point.
    pub pointwise: bool,
}

impl Measure {
    fn n_modes(&self) -> usize {
        self.squares.len()
    }

    /// Mode and term of column `c`: columns are (term, component, mode).
    fn mode_and_term(&self, c: usize) -> (usize, usize) {
        (c % self.n_modes(), c / (3 * self.n_modes()))
    }

    /// Errors of the change from `exact` to `rounded`.
    pub fn loss(&self, exact: &[f64], rounded: &[f64]) -> Loss {
        let columns = 3 * self.n_modes() * self.terms.len();
        let mut off = vec![0.0; self.n_modes()];
        for (i, (a, b)) in exact.iter().zip(rounded).enumerate() {
            let (mode, term) = self.mode_and_term(i % columns);
            off[mode] += (self.terms[term] * (a - b)).powi(2);
        }
        let field = |shares: &[f64]| {
            let sum = |squares: &[f64]| shares.iter().zip(squares).map(|(s, q)| s * q).sum::<f64>();
            ratio(sum(&off), sum(&self.squares))
        };
        let worst = off.iter().zip(&self.squares).map(|(&off, &square)| ratio(off, square));
        let row = 3 * self.n_modes() * self.terms.len();
        let loss = |nodes: &NodeLimits| nodes.loss(exact, rounded, row, &self.terms);
        let contact = self.nodes.as_ref().map_or(0.0, loss);
        let points = if self.pointwise { self.largest_error(exact, rounded) } else { 0.0 };
        Loss {
            displacement: field(&self.shares[0]).max(contact).max(points),
            velocity: field(&self.shares[1]),
            worst_mode: worst.fold(0.0, f64::max),
        }
    }

    /// Four times the largest error of a mode beside its largest number.
    fn largest_error(&self, exact: &[f64], rounded: &[f64]) -> f64 {
        let (mut off, mut peaks) = (vec![0.0f64; self.n_modes()], self.largest(exact));
        for (i, (a, b)) in exact.iter().zip(rounded).enumerate() {
            let mode = i % self.n_modes();
            off[mode] = off[mode].max((a - b).abs());
        }
        peaks.iter_mut().for_each(|peak| *peak = peak.max(f64::MIN_POSITIVE));
        off.iter().zip(&peaks).map(|(off, peak)| 4.0 * off / peak).fold(0.0, f64::max)
    }

    /// The largest number of each mode.
    fn largest(&self, values: &[f64]) -> Vec<f64> {
        let mut peaks = vec![0.0f64; self.n_modes()];
        for (i, value) in values.iter().enumerate() {
            let mode = i % self.n_modes();
            peaks[mode] = peaks[mode].max(value.abs());
        }
        peaks
    }

    /// Step of each column that keeps the tolerance in the mean, and at points where they count.
    fn steps(&self, values: &[f64], tolerance: f64) -> Vec<f64> {
        let columns = 3 * self.n_modes() * self.terms.len();
        let nodes = values.len() / columns;
        let peaks = if self.pointwise { self.largest(values) } else { vec![] };
        let step = |c: usize| {
            let (mode, term) = self.mode_and_term(c);
            // Uniform rounding errors have a mean square of step²/12.
            let numbers = 3.0 * nodes as f64 * self.terms.len() as f64 * self.terms[term].powi(2) / 12.0;
            let mean = tolerance * (self.squares[mode] / numbers).sqrt();
            peaks.get(mode).map_or(mean, |peak| mean.min(0.5 * tolerance * peak))
        };
        (0..columns).map(step).collect()
    }

    /// The step of a number of a node, where its row is held to itself.
    fn step_at(&self, steps: &[f64], node: usize, c: usize, tolerance: f64) -> f64 {
        let (mode, term) = self.mode_and_term(c);
        let component = c / self.n_modes() % 3;
        let own = self.nodes.as_ref().and_then(|nodes| nodes.step(node, component, mode, tolerance));
        let share = self.terms[term] * (self.terms.len() as f64).sqrt();
        own.map_or(steps[c], |own| steps[c].min(own / share))
    }
}

fn ratio(square: f64, of: f64) -> f64 {
    if square == 0.0 { 0.0 } else { (square / of).sqrt() }
}

/// The decoded bytes of a rounded section and its loss; `None` if the tolerance cannot be kept so.
fn within(
    values: &[f64],
    measure: &Measure,
    tolerance: f64,
    way: impl Fn(&[f64], f64) -> Option<(Vec<u8>, Vec<f64>)>,
) -> Option<(Vec<u8>, Loss)> {
    let mut aim = 0.95 * tolerance;
    // The formulas are means: the sum of a few hundred rounding errors may lie some per cent beside them.
    for _ in 0..8 {
        let (bytes, rounded) = way(&measure.steps(values, aim), aim)?;
        let loss = measure.loss(values, &rounded);
        if loss.within(tolerance) {
            return Some((bytes, loss));
        }
        aim *= 0.98 * (tolerance / loss.displacement.max(loss.worst_mode)).min(1.0);
    }
    None
}

/// Quantised to 16 bits.
pub(super) fn quantise(values: &[f64], measure: &Measure, tolerance: f64) -> Option<(Vec<u8>, Loss)> {
    let columns = 3 * measure.n_modes() * measure.terms.len();
    let nodes = values.len() / columns;
    let peaks = peaks(values, columns);
    within(values, measure, tolerance, |steps, aim| {
        let step = |block: usize, c: usize| {
            let nodes = block * BLOCK_NODES..nodes.min((block + 1) * BLOCK_NODES);
            nodes.map(|node| measure.step_at(steps, node, c, aim)).fold(f64::INFINITY, f64::min)
        };
        round(values, columns, step, &peaks)
    })
}

/// To binary32, each number with as many digits as its node needs: the rest is zeros, which compress.
pub(super) fn trimmed(values: &[f64], measure: &Measure, tolerance: f64) -> Option<(Vec<u8>, Loss)> {
    let columns = 3 * measure.n_modes() * measure.terms.len();
    within(values, measure, tolerance, |steps, aim| {
        let number = |(i, &value): (usize, &f64)| {
            let step = measure.step_at(steps, i / columns, i % columns, aim).log2().floor().exp2();
            if step.is_normal() { ((value / step).round() * step) as f32 } else { value as f32 }
        };
        let rounded: Vec<f32> = values.iter().enumerate().map(number).collect();
        Some((
            rounded.iter().flat_map(|x| x.to_le_bytes()).collect(),
            rounded.iter().map(|&x| f64::from(x)).collect(),
        ))
    })
}

/// Largest magnitude of each block of nodes and column.
fn peaks(values: &[f64], columns: usize) -> Vec<f64> {
    let block = |block: &[f64]| {
        let mut peaks = vec![0.0f64; columns];
        block.iter().enumerate().for_each(|(i, v)| peaks[i % columns] = peaks[i % columns].max(v.abs()));
        peaks
    };
    values.chunks(columns * BLOCK_NODES).flat_map(block).collect()
}

/// Rounds to multiples of each block's and column's step, or of a larger one where 16 bits ask for it. `None`
/// if a scale is no normal number.
fn round(
    values: &[f64],
    columns: usize,
    step: impl Fn(usize, usize) -> f64,
    peaks: &[f64],
) -> Option<(Vec<u8>, Vec<f64>)> {
    let (mut scales, mut numbers) = (vec![], vec![]);
    let mut rounded = Vec::with_capacity(values.len());
    for (at, (block, peaks)) in values.chunks(columns * BLOCK_NODES).zip(peaks.chunks(columns)).enumerate() {
        let own: Vec<f32> =
            (0..columns).zip(peaks).map(|(c, peak)| step(at, c).max(peak / LARGEST) as f32).collect();
        if own.iter().any(|scale| !scale.is_normal()) {
            return None;
        }
        for (i, &value) in block.iter().enumerate() {
            let scale = f64::from(own[i % columns]);
            let number = (value / scale).round().clamp(-LARGEST, LARGEST);
            numbers.extend((number as i16).to_le_bytes());
            rounded.push(scale * number);
        }
        scales.extend(own.iter().flat_map(|scale| scale.to_le_bytes()));
    }
    scales.extend(numbers);
    Some((scales, rounded))
}

/// To binary32, and what that makes of the values.
pub(super) fn single(values: &[f64]) -> (Vec<u8>, Vec<f64>) {
    let single = values.iter().map(|&value| value as f32);
    (single.clone().flat_map(f32::to_le_bytes).collect(), single.map(f64::from).collect())
}

/// The sections a tolerance is for.
pub(super) fn may_be_rounded(kind: SectionKind) -> bool {
    use SectionKind as S;
    matches!(kind, S::NodeCoordinates | S::SurfaceBasis | S::InteriorBasis | S::BlockLoad | S::StressBasis)
}
