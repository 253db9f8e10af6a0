//! Modal truncation with the exact motion of each mode: no error in time but that of the load between its
//! instants.
//!
//! In natural modes every coordinate is an oscillator, `q̈ + 2γ q̇ + λ q = f`, `2γ = α + βλ`. Under a load
//! linear over the step, `f = f₀ + (f₁ − f₀) t/h`, the particular motion is `p = A + Bt` with
//! `λB = (f₁ − f₀)/h` and `λA + 2γB = f₀`, and with `ω² = λ − γ²`, `s = e^{−γh} sin(ωh)/ω`,
//! `c = e^{−γh} cos ωh`
//!
//! ```text
//! q(h) = p(h) + (c + γs)(q₀ − A) + s (q̇₀ − B),   q̇(h) = B − λs (q₀ − A) + (c − γs)(q̇₀ − B)
//! ```
//!
//! (hyperbolic functions where `λ < γ²`). Note: the load at the end of the step is its limit from
//! inside, `f₁ = 2 f(h/2) − f₀`, so that loads which jump or bend on the edges of steps are met exactly.

use super::staged::{Frame, ReducedSolver};
use vademecum_build::basis::Basis;
use vademecum_build::dynamics::INSTANTS;
use vademecum_build::dynamics::Rayleigh;
use vademecum_build::linalg::project;
use vademecum_study::parts::{Study, Timed};

/// Natural modes, each moved exactly.
pub struct ExactModes {
    frame: Frame,
    modes: Vec<Propagator>,
}

/// One step of one mode.
#[derive(Clone, Copy, Debug)]
struct Propagator {
    /// `(q, q̇) → (q, q̇)`, row by row.
    state: [[f64; 2]; 2],
    /// Contribution of the load at start and end of the step to `(q, q̇)`.
    load: [[f64; 2]; 2],
}

impl Propagator {
    /// For `λ > 0`, a step `h` and `γ ≥ 0`.
    fn new(eigenvalue: f64, gamma: f64, h: f64) -> Self {
        let (s, c) = oscillation(eigenvalue - gamma * gamma, gamma, h);
        let state = [[c + gamma * s, s], [-eigenvalue * s, c - gamma * s]];
        let load = [[1.0, 0.0], [0.0, 1.0]].map(|[f0, f1]| {
            let b = (f1 - f0) / (h * eigenvalue);
            let a = (f0 - 2.0 * gamma * b) / eigenvalue;
            let free = state.map(|row| -row[0] * a - row[1] * b);
            [a + b * h + free[0], b + free[1]]
        });
        Self { state, load }
    }
}

/// `(s, c)` of the module's equations for `ω²` of either sign.
fn oscillation(omega_squared: f64, gamma: f64, h: f64) -> (f64, f64) {
    let omega = omega_squared.abs().sqrt();
    let decay = (-gamma * h).exp();
    if omega * h < 1e-9 {
        (h * decay, decay)
    } else if omega_squared > 0.0 {
        (decay * (omega * h).sin() / omega, decay * (omega * h).cos())
    } else {
        // e^{−γh} inside: cosh alone overflows.
        let (slow, fast) = (((omega - gamma) * h).exp(), (-(omega + gamma) * h).exp());
        (0.5 * (slow - fast) / omega, 0.5 * (slow + fast))
    }
}

impl ExactModes {
    /// The natural modes of a study, with its step and damping.
    ///
    /// # Panics
    /// As [`ExactModes::new`].
    pub fn of_study(study: &Study, basis: &Basis) -> Timed<Self> {
        Timed::new(|| Self::new(basis, study.time_step(), study.prepared().rayleigh()))
    }

    /// The propagators of all modes.
    ///
    /// # Panics
    /// If the basis is not one of natural modes or Ritz vectors with their eigenvalues.
    pub fn new(basis: &Basis, dt: f64, damping: Rayleigh) -> Self {
        let values = basis.eigenvalues.as_ref().expect("modes have eigenvalues");
        let gamma = |value: f64| 0.5 * (damping.alpha + damping.beta * value);
        let modes = values.iter().map(|&value| Propagator::new(value, gamma(value), dt)).collect();
        let instants = std::array::from_fn(|j| if j == 1 { 0.5 } else { 0.0 });
        let frame = Frame { basis: basis.vectors.clone(), time_step: dt, instants, stages: 0 };
        Self { frame, modes }
    }
}

impl ReducedSolver for ExactModes {
    fn frame(&self) -> &Frame {
        &self.frame
    }

    /// Contribution of the loads to `q`, then to `q̇`.
    fn load_len(&self) -> usize {
        2 * self.modes.len()
    }

    fn responses(&self, force: &[f64]) -> [Vec<f64>; INSTANTS] {
        let reduced = project(self.frame.basis.as_ref(), force);
        // f₁ = 2 f½ − f₀.
        let at = |weights: [f64; 2]| -> Vec<f64> {
            let row = |component: usize| {
                let entry = move |(mode, f): (&Propagator, &f64)| {
                    f * (weights[0] * mode.load[0][component] + weights[1] * mode.load[1][component])
                };
                self.modes.iter().zip(&reduced).map(entry).collect::<Vec<_>>()
            };
            [row(0), row(1)].concat()
        };
        let mut out: [Vec<f64>; INSTANTS] = std::array::from_fn(|_| vec![]);
        (out[0], out[1]) = (at([1.0, -1.0]), at([0.0, 2.0]));
        out
    }

    /// `(q, q̇)`: there is no acceleration to keep.
    fn rest(&self, force: &[f64]) -> Vec<f64> {
        vec![0.0; 2 * force.len()]
    }

    fn work_len(&self) -> usize {
        0
    }

    fn step(&self, state: &mut [f64], load: &[f64], _: &mut [f64]) {
        let r = self.modes.len();
        let ((q, v), (f, g)) = (state.split_at_mut(r), load.split_at(r));
        for (k, mode) in self.modes.iter().enumerate() {
            let old = [q[k], v[k]];
            q[k] = mode.state[0][0] * old[0] + mode.state[0][1] * old[1] + f[k];
            v[k] = mode.state[1][0] * old[0] + mode.state[1][1] * old[1] + g[k];
        }
    }
}
