//! The plain reduced solver: Galerkin on a basis, the scheme's stages solved one after the other with dense factors.
//!
//! What a reduced model usually is, written as well as it can be without fusing the stages: `BᵀMB = I` and `A = BᵀKB` are
//! formed once, each stage's matrix `(m + αΔt d) I + (k Δt² + βΔt d) A` is factorised once, and a step is one right-hand
//! side and one pair of triangular solves per stage. It is the baseline the fused step is measured against.

use faer::Mat;
use vademecum_format::scheme::{HISTORY, MAX_STAGES, SchemeTable};

use crate::dynamics::Rayleigh;
use crate::export::reduced_load;
use crate::march::{INSTANTS, TimedLoad, factors};
use crate::pod::Basis;

/// One stage: its factor and what its right-hand side is made of.
struct Stage {
    /// Cholesky factor `L`, shape (r, r).
    lower: Mat<f64>,
    /// Weights of `I` on `(u, Δt u̇, Δt² ü, u_1, …)`.
    mass: [f64; HISTORY],
    /// Weights of `A` on the same \[s²\].
    stiffness: [f64; HISTORY],
    /// Weights of the force at each instant \[s²\].
    load: [f64; INSTANTS],
}

/// A reduced model that solves its stages densely.
pub struct DenseGalerkin {
    table: SchemeTable,
    dt: f64,
    /// Shape (n, r).
    basis: Mat<f64>,
    /// `A = BᵀKB`, shape (r, r).
    stiffness: Mat<f64>,
    stages: Vec<Stage>,
}

/// State and scratch of a [`DenseGalerkin`].
pub struct GalerkinState {
    /// `u, Δt u̇, Δt² ü, u_1, …`, each of length r.
    history: [Vec<f64>; HISTORY],
    right: Vec<f64>,
    weighted: Vec<f64>,
    next: [Vec<f64>; 3],
}

impl GalerkinState {
    /// Reduced coordinates, length r.
    pub fn coordinates(&self) -> &[f64] {
        &self.history[0]
    }
}

/// Forces of one step at each of its instants, length r each: `BᵀF`.
pub type ReducedForces = [Vec<f64>; INSTANTS];

impl DenseGalerkin {
    /// Factorises the stages.
    ///
    /// # Panics
    /// If the stiffness of the basis is not positive semidefinite.
    pub fn new(basis: &Basis, table: &SchemeTable, dt: f64, damping: Rayleigh) -> Self {
        let (alpha_dt, beta_dt) = (damping.alpha * dt, damping.beta * dt);
        let stiffness = &basis.stiffness;
        let stage = |stage: &vademecum_format::scheme::Stage| {
            let m = stage.mass + alpha_dt * stage.damping;
            let k = dt * dt * stage.stiffness + beta_dt * stage.damping;
            let r = stiffness.nrows();
            let matrix = Mat::from_fn(r, r, |i, j| f64::from(u8::from(i == j)) * m + k * stiffness[(i, j)]);
            let factor = matrix.llt(faer::Side::Lower).expect("a stage's matrix is positive definite");
            Stage {
                lower: factor.L().to_owned(),
                mass: std::array::from_fn(|p| stage.mass_history[p] + alpha_dt * stage.damping_history[p]),
                stiffness: std::array::from_fn(|p| {
                    dt * dt * stage.stiffness_history[p] + beta_dt * stage.damping_history[p]
                }),
                load: stage.load.map(|weight| dt * dt * weight),
            }
        };
        let stages = table.active().iter().map(stage).collect();
        Self { table: *table, dt, basis: basis.vectors.clone(), stiffness: stiffness.clone(), stages }
    }

    /// Number of modes r.
    pub fn n_modes(&self) -> usize {
        self.basis.ncols()
    }

    /// Number of free dofs n.
    pub fn n_dof(&self) -> usize {
        self.basis.nrows()
    }

    /// At rest under the forces at the start of `forces`: `ζ̈ = BᵀF`.
    pub fn rest(&self, forces: &ReducedForces) -> GalerkinState {
        let zero = || vec![0.0; self.n_modes()];
        let mut history: [Vec<f64>; HISTORY] = std::array::from_fn(|_| zero());
        history[2] = forces[0].iter().map(|f| self.dt * self.dt * f).collect();
        GalerkinState { history, right: zero(), weighted: zero(), next: std::array::from_fn(|_| zero()) }
    }

    /// Forces of step number `step`.
    pub fn forces(&self, loads: &[Load], step: usize) -> ReducedForces {
        let mut forces: ReducedForces = std::array::from_fn(|_| vec![0.0; self.n_modes()]);
        for load in loads {
            let at = factors(&self.table, self.dt, step, &load.when);
            for (force, factor) in forces.iter_mut().zip(at).filter(|(_, factor)| *factor != 0.0) {
                force.iter_mut().zip(&load.reduced).for_each(|(sum, f)| *sum += factor * f);
            }
        }
        forces
    }

    /// All loads at full height, at every instant.
    pub fn held(&self, loads: &[Load]) -> ReducedForces {
        let sum = |k: usize| loads.iter().map(|load| load.reduced[k]).sum();
        std::array::from_fn(|_| (0..self.n_modes()).map(sum).collect())
    }

    /// Loads over the free dofs, reduced.
    pub fn reduce(&self, loads: &[TimedLoad]) -> Vec<Load> {
        let reduce = |load: &TimedLoad| Load {
            reduced: reduced_load(self.basis.as_ref(), &load.force),
            when: load.when,
        };
        loads.iter().map(reduce).collect()
    }

    /// One step. No allocation.
    pub fn step(&self, state: &mut GalerkinState, forces: &ReducedForces) {
        let GalerkinState { history, right, weighted, next } = state;
        for (index, stage) in self.stages.iter().enumerate() {
            let known = 3 + index;
            weigh(&stage.mass[..known], &history[..known], right);
            if stage.stiffness[..known].iter().any(|&w| w != 0.0) {
                weigh(&stage.stiffness[..known], &history[..known], weighted);
                add_product(&self.stiffness, weighted, right);
            }
            for (force, &weight) in forces.iter().zip(&stage.load).filter(|(_, weight)| **weight != 0.0) {
                right.iter_mut().zip(force).for_each(|(sum, f)| *sum += weight * f);
            }
            solve(&stage.lower, right);
            history[known].copy_from_slice(right);
        }
        let known = 3 + self.stages.len();
        for (row, new) in self.table.finish.iter().zip(next.iter_mut()) {
            weigh(&row[..known], &history[..known], new);
        }
        history.iter_mut().zip(next).for_each(|(old, new)| old.copy_from_slice(new));
    }

    /// Coordinates at each instant of a march from rest, the start included; shape (r, steps + 1).
    pub fn play(&self, loads: &[TimedLoad], steps: usize) -> Mat<f64> {
        let loads = self.reduce(loads);
        let mut state = self.rest(&self.forces(&loads, 0));
        let mut coordinates = Mat::zeros(self.n_modes(), steps + 1);
        for step in 0..steps {
            self.step(&mut state, &self.forces(&loads, step));
            coordinates.col_as_slice_mut(step + 1).copy_from_slice(state.coordinates());
        }
        coordinates
    }

    /// The displacement over the free dofs, length n. Bound by reading the basis once.
    pub fn reconstruct_into(&self, state: &GalerkinState, out: &mut [f64]) {
        out.fill(0.0);
        add_product(&self.basis, state.coordinates(), out);
    }
}

/// A load as the reduced model sees it.
pub struct Load {
    /// `BᵀF` \[N\], length r.
    reduced: Vec<f64>,
    when: crate::scenario::Interval,
}

const _: () = assert!(HISTORY == 3 + MAX_STAGES && INSTANTS == 1 + MAX_STAGES);

/// `out ← Σ w_p x_p`, skipping zero weights.
fn weigh(weights: &[f64], terms: &[Vec<f64>], out: &mut [f64]) {
    out.fill(0.0);
    for (&weight, term) in weights.iter().zip(terms).filter(|(weight, _)| **weight != 0.0) {
        out.iter_mut().zip(term).for_each(|(sum, x)| *sum += weight * x);
    }
}

/// `out ← out + matrix x`, column by column.
fn add_product(matrix: &Mat<f64>, x: &[f64], out: &mut [f64]) {
    for (j, &value) in x.iter().enumerate() {
        out.iter_mut().zip(matrix.col_as_slice(j)).for_each(|(sum, a)| *sum += a * value);
    }
}

/// `x ← (L Lᵀ)⁻¹ x`, both triangles by the columns of `L`.
fn solve(lower: &Mat<f64>, x: &mut [f64]) {
    for j in 0..x.len() {
        let column = lower.col_as_slice(j);
        x[j] /= column[j];
        let value = x[j];
        x[j + 1..].iter_mut().zip(&column[j + 1..]).for_each(|(x, l)| *x -= l * value);
    }
    for j in (0..x.len()).rev() {
        let column = lower.col_as_slice(j);
        let known: f64 = x[j + 1..].iter().zip(&column[j + 1..]).map(|(x, l)| x * l).sum();
        x[j] = (x[j] - known) / column[j];
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dynamics::schemes::{bathe, generalized_alpha};
    use crate::march::stage_amplitudes;
    use crate::reduced::{BlockStep, FusedStep};
    use crate::response::StageResponse;
    use crate::scenario::Interval;
    use vademecum_format::scheme::{StepParameters, theta};

    /// The stages one after the other and fused are one march; damped, loaded, released within a step.
    #[test]
    fn agrees_with_the_fused_galerkin_step() {
        let stiffness = faer::mat![[5.0, -2.0, 0.3], [-2.0, 4.0, 0.1], [0.3, 0.1, 30.0]];
        let vectors = Mat::identity(3, 3);
        let basis = Basis { vectors, stiffness, eigenvalues: None, energy: vec![], singular_values: vec![] };
        let (dt, damping) = (0.1, Rayleigh { alpha: 0.3, beta: 0.02 });
        let when = Interval { start: 0.0, end: 1.05, ramp: 0.2 };
        let loads = [TimedLoad { column: 0, force: vec![1.0, -2.0, 0.5], when }];
        for table in [bathe(), generalized_alpha(0.8).expect("sound")] {
            let dense = DenseGalerkin::new(&basis, &table, dt, damping).play(&loads, 100);
            let fused = play_fused(&basis, &table, dt, damping, &loads[0], 100);
            // 100 steps of some hundred roundings each, in random order.
            let scale = fused.norm_max();
            assert!((&dense - &fused).norm_max() <= 1e4 * f64::EPSILON * scale);
            assert!(scale > 0.1);
        }
    }

    fn play_fused(
        basis: &Basis,
        table: &SchemeTable,
        dt: f64,
        damping: Rayleigh,
        load: &TimedLoad,
        steps: usize,
    ) -> Mat<f64> {
        let parameters = StepParameters {
            time_step: dt,
            alpha: damping.alpha,
            beta: damping.beta,
            density: 1.0,
            stiffness: 1.0,
        };
        let response = |i| {
            let theta = theta(table, &parameters, i).expect("sound");
            StageResponse::galerkin(basis.vectors.as_ref(), basis.stiffness.as_ref(), theta)
        };
        let responses: Vec<StageResponse> = (0..table.active().len()).map(response).collect();
        let step = BlockStep::fuse(table, &parameters, basis.vectors.as_ref(), &responses).expect("fused");
        let at = step.load_response(&load.force);
        let (mut y, mut work) = (vec![0.0; 9], vec![0.0; 9]);
        let start = load.when.factor(0.0) * dt * dt;
        y[6..].iter_mut().zip(&load.force).for_each(|(a, f)| *a = start * f);
        Mat::from_fn(3, steps + 1, |k, instant| {
            if k == 0 && instant > 0 {
                let amplitudes = stage_amplitudes(table, &factors(table, dt, instant - 1, &load.when));
                let mut force = vec![0.0; 9];
                step.add_load(&at, &amplitudes, &mut force);
                step.step(&mut y, &force, &mut work);
            }
            y[k]
        })
    }
}
