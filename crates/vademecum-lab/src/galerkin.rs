//! The plain reduced solver: Galerkin on a basis, the scheme's stages solved one after the other with dense
//! factors.
//!
//! What a reduced model usually is, written as well as it can be without fusing the stages: `BᵀMB = I` and
//! `A = BᵀKB` are formed once, each stage's matrix `(m + αΔt d) I + (k Δt² + βΔt d) A` is factorised once,
//! and a step is one right-hand side and one pair of triangular solves per stage. It is the baseline the
//! fused step is measured against.

use faer::Mat;
use vademecum_format::scheme::{HISTORY, SchemeTable};

use super::staged::{Frame, ReducedSolver, add_product, add_weighted};
use vademecum_build::basis::Basis;
use vademecum_build::dynamics::INSTANTS;
use vademecum_build::dynamics::Rayleigh;
use vademecum_build::linalg::project;
use vademecum_study::parts::{Study, Timed};

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
    frame: Frame,
    /// Weights of the new `(u, Δt u̇, Δt² ü)` on the history.
    finish: [[f64; HISTORY]; 3],
    /// `A = BᵀKB`, shape (r, r).
    stiffness: Mat<f64>,
    stages: Vec<Stage>,
}

impl DenseGalerkin {
    /// The solver of a study in a basis, with its scheme, step and damping.
    pub fn of_study(study: &Study, basis: &Basis) -> Timed<Self> {
        let prepared = study.prepared();
        Timed::new(|| Self::new(basis, &prepared.scheme, study.time_step(), prepared.rayleigh()))
    }

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
        let frame = Frame::staged(basis.vectors.as_ref(), table, dt);
        Self { frame, finish: table.finish, stiffness: stiffness.clone(), stages }
    }
}

impl ReducedSolver for DenseGalerkin {
    fn frame(&self) -> &Frame {
        &self.frame
    }

    fn responses(&self, force: &[f64]) -> [Vec<f64>; INSTANTS] {
        let reduced = project(self.frame.basis.as_ref(), force);
        let at = |j: usize| self.stages.iter().flat_map(move |stage| [stage.load[j]]).collect::<Vec<_>>();
        std::array::from_fn(|j| at(j).iter().flat_map(|w| reduced.iter().map(move |f| w * f)).collect())
    }

    fn step(&self, state: &mut [f64], load: &[f64], work: &mut [f64]) {
        let r = self.frame.n_modes();
        let (right, weighted) = work[..2 * r].split_at_mut(r);
        for (index, stage) in self.stages.iter().enumerate() {
            let known = 3 + index;
            right.copy_from_slice(&load[index * r..][..r]);
            add_weighted(&stage.mass[..known], state, right);
            if stage.stiffness[..known].iter().any(|&w| w != 0.0) {
                weighted.fill(0.0);
                add_weighted(&stage.stiffness[..known], state, weighted);
                add_product(&self.stiffness, weighted, right);
            }
            solve(&stage.lower, right);
            state[known * r..][..r].copy_from_slice(right);
        }
        let known = 3 + self.stages.len();
        work.fill(0.0);
        for (row, new) in self.finish.iter().zip(work.chunks_exact_mut(r)) {
            add_weighted(&row[..known], state, new);
        }
        state[..3 * r].copy_from_slice(work);
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
