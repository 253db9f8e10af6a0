//! Covariance of a tracked state: modal coordinates, their rates, and parameters.

use crate::base::lend::Lender;
use crate::kernels::dense::{add_scaled, at, dot, row, row_mut, set, symmetrise, transpose};
use crate::parametric::slope_step::SlopeStep;

/// A tracked parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tracked {
    /// Its number.
    pub parameter: usize,
    /// Standard deviation at the start: relative, if the range of the parameter lies above 0, and else in its
    /// unit.
    pub deviation: f64,
    /// Standard deviation that it gains in a second, as that of a random walk \[1/√s\].
    pub drift: f64,
}

/// A covariance of `n` rows, `(q, q̇, parameters)`.
#[derive(Debug)]
pub(crate) struct Covariance<'m> {
    n: usize,
    p: &'m mut [f64],
    /// Two rows of work, and a square.
    gain: &'m mut [f64],
    other: &'m mut [f64],
}

impl<'m> Covariance<'m> {
    /// Numbers of memory.
    pub const fn len(n: usize) -> usize {
        n * n + 2 * n
    }

    /// A state known exactly.
    pub fn new(n: usize, lender: &mut Lender<&'m mut [f64]>) -> Option<Self> {
        let mut take = |n| lender.take(n).ok();
        let (p, gain, other) = (take(n * n)?, take(n)?, take(n)?);
        p.fill(0.0);
        Some(Self { n, p, gain, other })
    }

    /// Variance of a number of the state.
    pub fn own(&self, i: usize) -> f64 {
        at(self.p, i * self.n + i)
    }

    pub fn set_own(&mut self, i: usize, variance: f64) {
        set(self.p, i * self.n + i, variance);
    }

    pub fn add_own(&mut self, i: usize, variance: f64) {
        let own = self.own(i);
        self.set_own(i, own + variance);
    }

    /// Adds the variance of a load along mode `k`, whose answer after a step this is.
    pub fn add_load(&mut self, m: usize, k: usize, answer: [f64; 2]) {
        let places = [k, m + k];
        for (i, a) in places.into_iter().zip(answer) {
            for (j, b) in places.into_iter().zip(answer) {
                let place = i * self.n + j;
                set(self.p, place, at(self.p, place) + a * b);
            }
        }
    }

    /// `P ← F P Fᵀ` with the free step of the modes and the slopes of the parameters.
    pub fn predict(&mut self, m: usize, step: &SlopeStep<'_>, changes: &[f64], tracked: &[Tracked]) {
        // `F P` row by row, then the same of its transpose, since `F P Fᵀ = (F (F P)ᵀ)ᵀ`.
        for _ in 0..2 {
            for k in 0..m {
                let e = step.free(k);
                let (gain, other) = (&mut *self.gain, &mut *self.other);
                gain.copy_from_slice(row(self.p, k, self.n));
                other.copy_from_slice(row(self.p, m + k, self.n));
                for (i, [of_q, of_v]) in [k, m + k].into_iter().zip(e) {
                    let out = row_mut(self.p, i, self.n);
                    out.iter_mut()
                        .zip(gain.iter().zip(&*other))
                        .for_each(|(out, (q, v))| *out = of_q * q + of_v * v);
                }
            }
            let Some((motion, parameters)) = self.p.split_at_mut_checked(2 * m * self.n) else { return };
            for (i, out) in motion.chunks_exact_mut(self.n.max(1)).enumerate() {
                for (own, of_parameter) in tracked.iter().zip(parameters.chunks_exact(self.n.max(1))) {
                    add_scaled(out, at(changes, own.parameter * 2 * m + i), of_parameter);
                }
            }
            transpose(self.p, self.n);
        }
        symmetrise(self.p, self.n);
    }

    /// Takes a measured number: that of `measured` along part of the state from `first`, with this variance,
    /// and its difference from what was expected. Gives the variance of that difference.
    pub fn update(
        &mut self,
        first: usize,
        measured: &[f64],
        variance: f64,
        surprise: f64,
        state: &mut [f64],
    ) -> f64 {
        let n = self.n;
        for (gain, of_state) in self.gain.iter_mut().zip(self.p.chunks_exact(n.max(1))) {
            *gain = dot(of_state.get(first..).unwrap_or_default(), measured);
        }
        let total = variance + dot(self.gain.get(first..).unwrap_or_default(), measured);
        if total <= 0.0 || !total.is_finite() {
            return f64::INFINITY;
        }
        add_scaled(state, surprise / total, self.gain);
        for (&gain, out) in self.gain.iter().zip(self.p.chunks_exact_mut(n.max(1))) {
            add_scaled(out, -gain / total, self.gain);
        }
        total
    }

    /// Carries state and covariance to other modes, of which `turn` has a row for each mode before.
    pub fn turn(&mut self, m: usize, turn: &[f64], state: &mut [f64]) {
        let n = self.n;
        // Both parts of the state, and of each row; rows are columns after the transpose.
        let mut of_row = |numbers: &mut [f64]| {
            for part in numbers.chunks_exact_mut(m.max(1)).take(2) {
                let out = self.gain.get_mut(..m).unwrap_or_default();
                out.fill(0.0);
                for (k, value) in part.iter().enumerate() {
                    add_scaled(out, *value, row(turn, k, m));
                }
                part.copy_from_slice(out);
            }
        };
        of_row(state);
        for _ in 0..2 {
            self.p.chunks_exact_mut(n.max(1)).for_each(&mut of_row);
            transpose(self.p, n);
        }
    }
}
