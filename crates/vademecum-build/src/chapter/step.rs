//! The reduced step of the canonical maps in double precision, as the evaluator will take it: for certificates.

use vademecum_format::scheme::MAX_STAGES;
use vademecum_format::{ChapterAxis, ChapterRole};

use super::{ChapterMap, MapPart};

/// A load at one of the positions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChapterLoad {
    /// Place in the list of positions.
    pub position: usize,
    /// Magnitude in each stage \[N\].
    pub magnitudes: [f64; MAX_STAGES],
    /// Components of the direction, where they are axes.
    pub components: [f64; 3],
}

/// A coordinate that is not on its axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outside {
    /// The stage, counted from 0.
    pub stage: usize,
    /// The axis.
    pub axis: ChapterAxis,
    /// The value.
    pub value: f64,
}

impl std::fmt::Display for Outside {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { stage, axis: ChapterAxis { role, lower, upper, .. }, value } = self;
        write!(f, "stage {}: {role} is {value:.3e}, outside [{lower:.3e}, {upper:.3e}]", stage + 1)
    }
}

impl ChapterMap {
    /// One step of `y = (ζ, Δt ζ̇, Δt² ζ̈)`, length 3r, under one load or none.
    ///
    /// # Errors
    /// [`Outside`]; the state is then unchanged.
    pub fn step(&self, y: &mut [f64], load: Option<&ChapterLoad>) -> Result<(), Outside> {
        let r = self.n_modes;
        let mut history = y.to_vec();
        history.resize((3 + self.stages.len()) * r, 0.0);
        for (index, stage) in self.stages.iter().enumerate() {
            let mut new = vec![0.0; r];
            for part in &stage.parts {
                if load.is_some() || part.axes.iter().any(ChapterAxis::is_state) {
                    let outside = |(axis, value)| Outside { stage: index, axis, value };
                    part.add_into(&history, r, index, load, &mut new).map_err(outside)?;
                }
            }
            history[(3 + index) * r..(4 + index) * r].copy_from_slice(&new);
        }
        for (row, out) in self.table.finish.iter().zip(y.chunks_exact_mut(r)) {
            out.fill(0.0);
            for (part, weight) in history.chunks_exact(r).zip(row) {
                out.iter_mut().zip(part).for_each(|(out, x)| *out += weight * x);
            }
        }
        Ok(())
    }

    /// Largest modulus of the eigenvalues of the unloaded step linearised at rest, by differences over half of each range
    /// (less where a stage would leave its own); NaN if some coordinate cannot be moved.
    pub fn spectral_radius(&self) -> f64 {
        let n = 3 * self.n_modes;
        let mut map = vec![0.0; n * n];
        for (j, column) in map.chunks_exact_mut(n).enumerate() {
            let Some(slope) = self.slope(j) else { return f64::NAN };
            column.copy_from_slice(&slope);
        }
        crate::response::reduced::spectral_radius(n, &map)
    }

    /// Column `j` of the linearised step.
    fn slope(&self, j: usize) -> Option<Vec<f64>> {
        let (family, mode) = (j / self.n_modes, j % self.n_modes);
        let axes = self.stages.iter().flat_map(|s| &s.parts).flat_map(|part| &part.axes);
        let own = axes.filter(|axis| axis.role == ChapterRole::State { family, mode });
        let reach = own.map(|axis| axis.upper.min(-axis.lower) / axis.factor).fold(f64::INFINITY, f64::min);
        let mut length = if reach.is_finite() { 0.5 * reach } else { 1.0 };
        for _ in 0..60 {
            let moved = |by: f64| {
                let mut y = vec![0.0; 3 * self.n_modes];
                y[j] = by;
                self.step(&mut y, None).ok().map(|()| y)
            };
            if let (Some(up), Some(down)) = (moved(length), moved(-length)) {
                return Some(up.iter().zip(down).map(|(u, d)| (u - d) / (2.0 * length)).collect());
            }
            length *= 0.5;
        }
        None
    }
}

impl MapPart {
    /// Adds `Σ_t (Π_a g_ta) f_t` to `out`, length r.
    fn add_into(
        &self,
        history: &[f64],
        r: usize,
        stage: usize,
        load: Option<&ChapterLoad>,
        out: &mut [f64],
    ) -> Result<(), (ChapterAxis, f64)> {
        let mut weights = vec![1.0; self.terms.ncols()];
        for (axis, factors) in self.axes.iter().zip(&self.factors) {
            let value = match axis.role {
                ChapterRole::State { family, mode } => axis.factor * history[family * r + mode],
                ChapterRole::Magnitude => load.map_or(0.0, |load| load.magnitudes[stage]),
                ChapterRole::Component { component } => load.map_or(0.0, |load| load.components[component]),
                ChapterRole::Position => load.map_or(0.0, |load| load.position as f64),
            };
            if !(axis.lower <= value && value <= axis.upper) {
                return Err((*axis, value));
            }
            let (left, share) = place(axis, value);
            for (t, weight) in weights.iter_mut().enumerate() {
                let right = if share > 0.0 { factors[(left + 1, t)] } else { 0.0 };
                *weight *= (1.0 - share) * factors[(left, t)] + share * right;
            }
        }
        for (t, weight) in weights.iter().enumerate() {
            out.iter_mut().zip(self.terms.col(t).iter()).for_each(|(out, f)| *out += weight * f);
        }
        Ok(())
    }
}

/// The point at or before `value`, and how far it is to the next.
fn place(axis: &ChapterAxis, value: f64) -> (usize, f64) {
    if axis.role == ChapterRole::Position {
        return (value as usize, 0.0);
    }
    let x = (value - axis.lower) / (axis.upper - axis.lower) * (axis.points - 1) as f64;
    let left = (x as usize).min(axis.points - 2);
    (left, x - left as f64)
}
