//! Modes that dashpots couple, moved exactly in time under loads that are linear in it.
//!
//! A whole step is one of all modes together, by the responses `S`, `φ` and `ψ` to a unit impulse, step and
//! ramp. They are power series at a short time, and are doubled from there. Short pieces of time are power
//! series of the motion itself: their cost is that of a few products with the damping matrix, which is a
//! diagonal and a few rows.
//!
//! The evaluator has the same step in its own code (`vademecum-format`, `coupled.rs`), which a certificate
//! checks with this one: nothing is shared.

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatMut, MatRef, Par};

/// Largest frequency and damping times the length of a power series.
const SHORT: f64 = 0.5;

/// Terms of a power series: what follows is below 1e-22 of the first.
const TERMS: usize = 20;

/// Modes of stiffness `λ` and decay `σ`, and the rows of dashpots along them.
#[derive(Clone, Copy)]
pub(super) struct CoupledModes<'a> {
    /// `λ` \[rad²/s²\] and `σ` \[1/s\].
    pub modes: &'a [[f64; 2]],
    /// Shape (any, modes) \[s^-½\].
    pub rows: MatRef<'a, f64>,
}

/// Displacements `q` and velocities \[1/s\] of modes.
#[derive(Clone)]
pub(super) struct ModalState {
    pub displacement: Vec<f64>,
    pub velocity: Vec<f64>,
}

/// A step of coupled modes of one length.
pub(super) struct CoupledStep {
    length: f64,
    impulse: Mat<f64>,
    step: Mat<f64>,
    ramp: Mat<f64>,
}

impl CoupledModes<'_> {
    /// `G x` of some columns, `G` the damping matrix \[1/s\].
    fn damping(&self, x: MatRef<'_, f64>) -> Mat<f64> {
        let along = self.rows * x;
        let mut out = Mat::from_fn(x.nrows(), x.ncols(), |i, j| 2.0 * self.modes[i][1] * x[(i, j)]);
        matmul(out.as_mut(), Accum::Add, self.rows.transpose(), along.as_ref(), 1.0, Par::Seq);
        out
    }

    /// `diag(λ) x`.
    fn stiffened(&self, x: MatRef<'_, f64>) -> Mat<f64> {
        Mat::from_fn(x.nrows(), x.ncols(), |i, j| self.modes[i][0] * x[(i, j)])
    }

    /// Halvings of a length of time that make it short.
    fn halvings(&self, length: f64) -> i32 {
        let fastest = self
            .modes
            .iter()
            .fold(0.0, |most: f64, &[lambda, sigma]| most.max(lambda.max(0.0).sqrt()).max(2.0 * sigma));
        let fastest = fastest.max(self.rows.squared_norm_l2());
        (fastest * length / SHORT).log2().ceil().clamp(0.0, 1000.0) as i32
    }

    /// Products that [`CoupledModes::moved`] takes for a piece of this length.
    fn work(&self, length: f64) -> f64 {
        let (rows, m) = (2 * self.rows.nrows() + 4, self.modes.len());
        2f64.powi(self.halvings(length)) * (TERMS * rows * m) as f64
    }

    /// True if pieces of this length are best moved by a step that is made for them: where there are `pieces`
    /// of them.
    pub(super) fn wants_step(&self, length: f64, pieces: usize) -> bool {
        let m = self.modes.len() as f64;
        let made = 4.0 * m * m * m * f64::from(self.halvings(length) + 4);
        pieces as f64 * self.work(length) > made + pieces as f64 * 5.0 * m * m
    }

    /// Moves all modes over `length` \[s\] under a force that goes from `before` to `after`, by power series.
    pub(super) fn moved(&self, state: &mut ModalState, [before, after]: [&[f64]; 2], length: f64) {
        let m = self.modes.len();
        let pieces = 2f64.powi(self.halvings(length));
        let time = length / pieces;
        let mut piece = 0.0;
        while piece < pieces {
            let at = |i: usize, share: f64| before[i] + (after[i] - before[i]) * share;
            let from: Vec<f64> = (0..m).map(|i| at(i, piece / pieces)).collect();
            let rise: Vec<f64> = (0..m).map(|i| (after[i] - before[i]) / pieces).collect();
            // Terms of the series of q, those of its rate are n/t times them.
            let mut old: Vec<f64> = state.displacement.clone();
            let mut now: Vec<f64> = state.velocity.iter().map(|v| time * v).collect();
            let (mut q, mut v) = (state.displacement.clone(), now.clone());
            q.iter_mut().zip(&now).for_each(|(q, term)| *q += term);
            for n in 1..=TERMS {
                let number = n as f64;
                let damped = self.damping(MatRef::from_column_major_slice(&now, m, 1));
                let force = |i: usize| match n {
                    1 => from[i],
                    2 => rise[i],
                    _ => 0.0,
                };
                let term = |i: usize| {
                    let pushed = time * time * (force(i) - self.modes[i][0] * old[i]);
                    (pushed - time * number * damped[(i, 0)]) / (number * (number + 1.0))
                };
                let next: Vec<f64> = (0..m).map(term).collect();
                for i in 0..m {
                    q[i] += next[i];
                    v[i] += (number + 1.0) * next[i];
                }
                (old, now) = (now, next);
            }
            v.iter_mut().for_each(|v| *v /= time);
            (state.displacement, state.velocity) = (q, v);
            piece += 1.0;
        }
    }

    /// The step of one length.
    pub(super) fn step(&self, length: f64) -> CoupledStep {
        let (m, halvings) = (self.modes.len(), self.halvings(length));
        let time = length / 2f64.powi(halvings);
        let identity = Mat::<f64>::identity(m, m);
        let mut impulse = time * &identity;
        let mut step = (0.5 * time * time) * &identity;
        let mut ramp = (time * time * time / 6.0) * &identity;
        let (mut old, mut now) = (Mat::zeros(m, m), impulse.clone());
        for n in 1..TERMS {
            let n = n as f64;
            let (of_old, of_now) = (self.stiffened(old.as_ref()), self.damping(now.as_ref()));
            let next = Mat::from_fn(m, m, |i, j| {
                -time * of_now[(i, j)] / (n + 1.0) - time * time * of_old[(i, j)] / (n * (n + 1.0))
            });
            impulse += &next;
            step += (time / (n + 2.0)) * &next;
            ramp += (time * time / ((n + 2.0) * (n + 3.0))) * &next;
            (old, now) = (now, next);
        }
        for _ in 0..halvings {
            let half_damped = |x: &Mat<f64>| 0.5 * self.damping(x.as_ref());
            let doubled = |m: &Mat<f64>, by: f64, x: Mat<f64>| 2.0 * m + by * (&x + x.transpose());
            let stiff = self.stiffened(step.as_ref());
            let longer_ramp = doubled(&ramp, 1.0, product(&step, &(&impulse + half_damped(&step))));
            let longer_step = 2.0 * &step - product(&step, &stiff) + product(&impulse, &impulse);
            let longer_impulse = doubled(&impulse, -1.0, product(&impulse, &(stiff + half_damped(&impulse))));
            ramp = longer_ramp;
            step = 0.5 * (&longer_step + longer_step.transpose());
            impulse = longer_impulse;
        }
        CoupledStep { length, impulse, step, ramp }
    }
}

fn product(a: &Mat<f64>, b: &Mat<f64>) -> Mat<f64> {
    let mut out = Mat::zeros(a.nrows(), b.ncols());
    matmul(out.as_mut(), Accum::Replace, a.as_ref(), b.as_ref(), 1.0, Par::Seq);
    out
}

impl CoupledStep {
    /// Its length \[s\].
    pub(super) fn length(&self) -> f64 {
        self.length
    }

    /// Moves all modes under a force that goes from `before` to `after`:
    /// `q ← q + S v + φ a + ψ ḟ` and `v ← v + S (a − G v) + φ (ḟ − Λ v)` with `a = f − Λ q`.
    pub(super) fn take(
        &self,
        modes: &CoupledModes<'_>,
        state: &mut ModalState,
        [before, after]: [&[f64]; 2],
    ) {
        let ModalState { displacement: q, velocity: v } = state;
        let m = q.len();
        let damped = modes.damping(MatRef::from_column_major_slice(v, m, 1));
        let pull = |i: usize| before[i] - modes.modes[i][0] * q[i];
        let rise = |i: usize| (after[i] - before[i]) / self.length;
        let by_impulse = Mat::from_fn(m, 2, |i, j| if j == 0 { v[i] } else { pull(i) - damped[(i, 0)] });
        let by_step =
            Mat::from_fn(m, 2, |i, j| if j == 0 { pull(i) } else { rise(i) - modes.modes[i][0] * v[i] });
        let by_ramp = Mat::from_fn(m, 1, |i, _| rise(i));
        let mut moved = Mat::zeros(m, 2);
        let add = |out: MatMut<'_, f64>, matrix: &Mat<f64>, x: &Mat<f64>| {
            matmul(out, Accum::Add, matrix.as_ref(), x.as_ref(), 1.0, Par::Seq);
        };
        add(moved.as_mut(), &self.impulse, &by_impulse);
        add(moved.as_mut(), &self.step, &by_step);
        add(moved.as_mut().subcols_mut(0, 1), &self.ramp, &by_ramp);
        q.iter_mut().zip(moved.col_as_slice(0)).for_each(|(q, moved)| *q += moved);
        v.iter_mut().zip(moved.col_as_slice(1)).for_each(|(v, moved)| *v += moved);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::Random;

    /// Eigenvalues and damping of modes, rows of dashpots, a state, and forces at both ends of a step.
    type Example = (Vec<[f64; 2]>, Mat<f64>, ModalState, [Vec<f64>; 2]);

    /// Five modes and two dashpots, and a state of them.
    fn example() -> Example {
        let mut random = Random::new(7);
        let modes = (0..5).map(|k| [10f64.powi(2 * k), 0.1 * f64::from(k)]).collect();
        let rows = Mat::from_fn(2, 5, |_, _| 8.0 * (random.uniform() - 0.5));
        let mut numbers = || (0..5).map(|_| random.uniform() - 0.5).collect::<Vec<f64>>();
        let state = ModalState { displacement: numbers(), velocity: numbers() };
        (modes, rows, state, [numbers(), numbers()])
    }

    #[test]
    fn doubling_and_power_series_of_the_motion_agree() {
        let (modes, rows, start, force) = example();
        let modes = CoupledModes { modes: &modes, rows: rows.as_ref() };
        let force = [&force[0][..], &force[1][..]];
        let energies = modes.modes.iter().zip(start.displacement.iter().zip(&start.velocity));
        let size = energies.map(|([lambda, _], (q, v))| lambda * q * q + v * v).sum::<f64>().sqrt();
        for length in [1e-6, 1e-3, 0.1, 3.0] {
            let (mut by_step, mut by_series) = (start.clone(), start.clone());
            modes.step(length).take(&modes, &mut by_step, force);
            modes.moved(&mut by_series, force, length);
            for (k, [lambda, _]) in modes.modes.iter().enumerate() {
                let displaced = lambda.sqrt() * (by_step.displacement[k] - by_series.displacement[k]);
                let faster = by_step.velocity[k] - by_series.velocity[k];
                // Some roundings of the energy at the start in each piece of the series.
                let allowed = 64.0 * f64::EPSILON * 2f64.powi(modes.halvings(length)) * size;
                assert!(displaced.hypot(faster) < allowed, "{length}, {k}: {displaced:e} {faster:e}");
            }
        }
    }

    #[test]
    fn short_pieces_take_the_series_and_many_long_ones_the_step() {
        let (modes, rows, ..) = example();
        let modes = CoupledModes { modes: &modes, rows: rows.as_ref() };
        assert!(!modes.wants_step(1e-6, 1));
        assert!(modes.wants_step(10.0, 100));
    }
}
