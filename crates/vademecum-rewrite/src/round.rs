//! Space sections rounded: to 16-bit numbers with scales, or to binary32, as coarsely as a tolerance allows,
//! and what that costs.
//!
//! A field is `Σ_k ζ_k B_k`. With coordinates as the snapshots had them (uncorrelated, mean square `s_k`, the
//! energy share in the table of modes), rounding errors `δ_k` of the columns change it by
//!
//! ```text
//! error² = Σ_k s_k |δ_k|² / Σ_k s_k |B_k|²        (root of the mean square over the nodes of the section)
//! ```
//!
//! and for velocities `s_k λ_k` stands for `s_k`. For one error the fewest bits are spent if every mode adds
//! the same to the sum: the step of mode `k` goes with `1/√s_k`. A rare mode would then be lost in a contact
//! that excites it, so no column is off by more than [`WORST_MODE`] tolerances of itself.

use vademecum_format::{BLOCK_NODES, SectionKind};

/// Most a single mode may be off, in tolerances.
pub const WORST_MODE: f64 = 32.0;

/// Largest quantised number.
const LARGEST: f64 = i16::MAX as f64;

/// Relative errors of rounding a section.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct Loss {
    /// Of displacement fields.
    pub displacement: f64,
    /// Of velocity fields.
    pub velocity: f64,
    /// Of the worst single mode.
    pub worst_mode: f64,
}

impl Loss {
    /// True if it is within a tolerance on fields.
    pub(super) fn within(&self, tolerance: f64) -> bool {
        self.displacement <= tolerance && self.worst_mode <= WORST_MODE * tolerance
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
        Loss {
            displacement: field(&self.shares[0]),
            velocity: field(&self.shares[1]),
            worst_mode: worst.fold(0.0, f64::max),
        }
    }

    /// Step of each column for a field error of `aim`, no mode past [`WORST_MODE`] tolerances; `peaks` are
    /// those of each block and column.
    fn steps(&self, peaks: &[f64], nodes: usize, aim: f64, tolerance: f64) -> Vec<f64> {
        let columns = 3 * self.n_modes() * self.terms.len();
        let weight = |c: usize| {
            let (mode, term) = self.mode_and_term(c);
            self.shares[0][mode] * self.terms[term].powi(2)
        };
        let most = |c: usize| {
            let (mode, term) = self.mode_and_term(c);
            let rounded = 3.0 * nodes as f64 * self.terms.len() as f64 * self.terms[term].powi(2) / 12.0;
            WORST_MODE * tolerance * (self.squares[mode] / rounded).sqrt()
        };
        let limits: Vec<(f64, f64)> = (0..columns).map(|c| (weight(c), most(c))).collect();
        let step = |fair: f64, c: usize| (fair / limits[c].0.sqrt()).min(limits[c].1);
        // Uniform rounding errors have a mean square of step²/12; a block whose peak asks for more than 16
        // bits has a larger step.
        let per_block = nodes.min(BLOCK_NODES) as f64 / 12.0;
        let square = |fair: f64| -> f64 {
            let own = |(i, peak): (usize, &f64)| {
                let c = i % columns;
                limits[c].0 * step(fair, c).max(peak / LARGEST).powi(2)
            };
            per_block * peaks.iter().enumerate().map(own).sum::<f64>()
        };
        let allowed = aim * aim * self.shares[0].iter().zip(&self.squares).map(|(s, q)| s * q).sum::<f64>();
        let (mut low, mut high) = (-150.0, 150.0);
        for _ in 0..40 {
            let middle: f64 = 0.5 * (low + high);
            *(if square(middle.exp2()) <= allowed { &mut low } else { &mut high }) = middle;
        }
        (0..columns).map(|c| step(f64::exp2(low), c)).collect()
    }
}

fn ratio(square: f64, of: f64) -> f64 {
    if square == 0.0 { 0.0 } else { (square / of).sqrt() }
}

/// The decoded bytes of the quantised section and its loss; `None` if 16 bits cannot keep the tolerance.
pub(super) fn quantise(values: &[f64], measure: &Measure, tolerance: f64) -> Option<(Vec<u8>, Loss)> {
    let columns = 3 * measure.n_modes() * measure.terms.len();
    let nodes = values.len() / columns;
    let peaks = peaks(values, columns);
    let mut aim = tolerance;
    // The formula is a mean: the sum of a few hundred rounding errors may lie some per cent beside it.
    for _ in 0..8 {
        let steps = measure.steps(&peaks, nodes, aim, 0.9 * tolerance);
        let (bytes, rounded) = round(values, columns, &steps, &peaks)?;
        let loss = measure.loss(values, &rounded);
        if loss.within(tolerance) {
            return Some((bytes, loss));
        }
        aim *= 0.98 * (tolerance / loss.displacement).min(1.0);
    }
    None
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

/// Rounds to multiples of each column's step, or of a larger one where a block of nodes asks for more than 16
/// bits. `None` if a scale is no normal number.
fn round(values: &[f64], columns: usize, steps: &[f64], peaks: &[f64]) -> Option<(Vec<u8>, Vec<f64>)> {
    let (mut scales, mut numbers) = (vec![], vec![]);
    let mut rounded = Vec::with_capacity(values.len());
    for (block, peaks) in values.chunks(columns * BLOCK_NODES).zip(peaks.chunks(columns)) {
        let own: Vec<f32> =
            steps.iter().zip(peaks).map(|(step, peak)| step.max(peak / LARGEST) as f32).collect();
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
