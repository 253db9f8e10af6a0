//! The step of a strain map, written out: what the evaluator does with vectors and tiles, for choices that
//! are made while a file is built.
//!
//! With `k` the sub-step, `p = qⁿ − qⁿ⁻¹` and `ẑ` the strain polarised between two states, the scheme
//!
//! ```text
//! (I + k²/4 Gᵀ W G) d = p + ½ k² (f − Gᵀ ẑ(qⁿ, qⁿ⁻¹))        d = ½ (qⁿ⁺¹ − qⁿ⁻¹)
//! ```
//!
//! keeps a discrete energy exactly (docs/theory/large-displacements-reduced.md).

use faer::linalg::solvers::Solve;
use faer::{Mat, Side};

use super::map::StrainMap;
use crate::dynamics::Rayleigh;

/// Numerical damping of the leading rows that is Bathe's at small amplitude.
pub const ROW_VISCOSITY: f64 = 1.0 / 18.0;

/// A strain map that moves.
pub struct Motion<'a> {
    map: &'a StrainMap,
    /// Sub-step \[s\].
    k: f64,
    damping: Rayleigh,
    viscosity: f64,
    /// Coordinates.
    pub q: Vec<f64>,
    /// What they gained in the last sub-step.
    p: Vec<f64>,
}

impl<'a> Motion<'a> {
    /// At rest.
    pub fn new(map: &'a StrainMap, k: f64, damping: Rayleigh, viscosity: f64) -> Self {
        let r = map.frequencies.len();
        Self { map, k, damping, viscosity, q: vec![0.0; r], p: vec![0.0; r] }
    }

    /// One sub-step under the reduced force `f`, the mean over the two sub-steps around now.
    pub fn step(&mut self, f: &[f64]) {
        let Self { map, k, damping, viscosity, .. } = *self;
        let r = map.frequencies.len();
        let (alpha, beta) = (damping.alpha, damping.beta);
        let s = 0.5 * k;
        let mut matrix = Mat::<f64>::identity(r, r);
        for j in 0..r {
            matrix[(j, j)] += 0.5 * k * alpha;
        }
        let mut right: Vec<f64> = self.p.iter().zip(f).map(|(p, f)| p + 0.5 * k * k * f).collect();
        let middle: Vec<f64> = self.q.iter().zip(&self.p).map(|(q, p)| q - 0.5 * p).collect();
        let before: Vec<f64> = self.q.iter().zip(&self.p).map(|(q, p)| q - p).collect();
        let mut g = vec![0.0; r];
        for row in 0..map.quadratic.nrows() {
            g.fill(0.0);
            let mut z = 0.0;
            for (j, (a, b)) in map.pairs.iter().enumerate() {
                let c = s * map.quadratic[(row, j)];
                g[a] += c * self.q[b];
                g[b] += c * self.q[a];
                z += c * 0.5 * (self.q[a] * before[b] + self.q[b] * before[a]);
            }
            let own = map.frequencies.get(row).map_or(0.0, |w| s * w);
            if row < r {
                g[row] += own;
                z += own * middle[row];
            }
            let weight = 1.0 + viscosity * own * own + 2.0 * beta / k;
            for i in 0..r {
                right[i] -= 2.0 * z * g[i];
                if g[i] != 0.0 {
                    for j in 0..=i {
                        matrix[(i, j)] += weight * g[i] * g[j];
                    }
                }
            }
        }
        let right = Mat::from_fn(r, 1, |i, _| right[i]);
        let d = matrix.llt(Side::Lower).expect("I plus squares").solve(right);
        for j in 0..r {
            self.p[j] = 2.0 * d[(j, 0)] - self.p[j];
            self.q[j] += self.p[j];
        }
    }

    /// The energy that the scheme keeps: that of the last sub-step's velocity, and of the strain polarised
    /// between its ends \[J\].
    pub fn energy(&self) -> f64 {
        let before: Vec<f64> = self.q.iter().zip(&self.p).map(|(q, p)| q - p).collect();
        let kinetic: f64 = self.p.iter().map(|p| (p / self.k).powi(2)).sum();
        let middle: Vec<f64> = self.q.iter().zip(&before).map(|(a, b)| 0.5 * (a + b)).collect();
        let elastic = |row: usize| {
            let of = |(j, (a, b)): (usize, (usize, usize))| {
                0.5 * self.map.quadratic[(row, j)] * (self.q[a] * before[b] + self.q[b] * before[a])
            };
            let linear = self.map.frequencies.get(row).map_or(0.0, |w| w * middle[row]);
            (linear + self.map.pairs.iter().enumerate().map(of).sum::<f64>()).powi(2)
        };
        0.5 * (kinetic + (0..self.map.quadratic.nrows()).map(elastic).sum::<f64>())
    }
}
