//! The time schemes as textbooks print them: unfused, unscaled, one solve after the other. The reference of
//! the fused step.
//!
//! Everything happens in the eigenvectors of a [`crate::synthetic::Body`], where mass is one, stiffness is
//! `ω²` and a solve is a division. Each stage is solved in the full space and projected with `BᵀM = Wᵀ`
//! (block structure), or, with `W = I` and `ω² = λ`, in the reduced space (Galerkin, diagonal structure).

use crate::synthetic::Body;
use vademecum_format::scheme::StepParameters;

/// A march by printed formulas.
pub struct Textbook {
    omega2: Vec<f64>,
    mixing: Vec<f64>,
    /// Rows that turn a force on a dof into a modal force: `(3n, N)`.
    force_rows: Vec<f64>,
    r: usize,
    step: StepParameters,
    /// `ζ, ζ̇, ζ̈`.
    pub state: [Vec<f64>; 3],
}

impl Textbook {
    /// Full-space solves projected with the mass: what the block structure stands for.
    #[must_use]
    pub fn projected(body: &Body, step: StepParameters) -> Self {
        let r = body.layout.r;
        let (omega2, mixing) = (body.omega2.clone(), body.mixing.clone());
        let state = [vec![0.0; r], vec![0.0; r], vec![0.0; r]];
        Self { omega2, mixing, force_rows: body.eigenvectors.clone(), r, step, state }
    }

    /// Reduced solves: what the diagonal structure stands for.
    #[must_use]
    pub fn galerkin(body: &Body, step: StepParameters) -> Self {
        let r = body.layout.r;
        let mixing = (0..r * r).map(|i| f64::from(u8::from(i / r == i % r))).collect();
        let state = [vec![0.0; r], vec![0.0; r], vec![0.0; r]];
        Self { omega2: body.lambda.clone(), mixing, force_rows: body.basis.clone(), r, step, state }
    }

    /// Modal force of forces on dofs.
    #[must_use]
    pub fn force(&self, dofs: &[(usize, f64)]) -> Vec<f64> {
        let n = self.omega2.len();
        (0..n).map(|i| dofs.iter().map(|&(dof, force)| self.force_rows[dof * n + i] * force).sum()).collect()
    }

    /// `Wᵀ (f + M (…) + C (…)) / (m M + d C + K)`, histories given in reduced coordinates.
    fn solve(&self, m: f64, d: f64, force: &[f64], mass_side: &[f64], damping_side: &[f64]) -> Vec<f64> {
        let StepParameters { alpha, beta, density, stiffness, .. } = self.step;
        let mut zeta = vec![0.0; self.r];
        for ((row, &omega2), &force) in self.mixing.chunks_exact(self.r).zip(&self.omega2).zip(force) {
            let (mass, k) = (density, stiffness * omega2);
            let c = alpha * mass + beta * k;
            let full = |reduced: &[f64]| -> f64 { row.iter().zip(reduced).map(|(w, z)| w * z).sum() };
            let q = (force + mass * full(mass_side) + c * full(damping_side)) / (m * mass + d * c + k);
            zeta.iter_mut().zip(row).for_each(|(zeta, w)| *zeta += w * q);
        }
        zeta
    }

    /// One Bathe step under modal forces at the half and the whole step.
    pub fn bathe(&mut self, half: &[f64], whole: &[f64]) {
        let dt = self.step.time_step;
        let [u, v, a] = &self.state;
        let mix = |terms: &[(f64, &Vec<f64>)]| -> Vec<f64> {
            (0..self.r).map(|k| terms.iter().map(|(c, x)| c * x[k]).sum()).collect()
        };
        let (m, d) = (16.0 / (dt * dt), 4.0 / dt);
        let u_half =
            self.solve(m, d, half, &mix(&[(m, u), (8.0 / dt, v), (1.0, a)]), &mix(&[(d, u), (1.0, v)]));
        let (m, d) = (9.0 / (dt * dt), 3.0 / dt);
        let mass_side = mix(&[(28.0 / (dt * dt), &u_half), (-19.0 / (dt * dt), u), (-5.0 / dt, v)]);
        let damping_side = mix(&[(4.0 / dt, &u_half), (-1.0 / dt, u)]);
        let u_new = self.solve(m, d, whole, &mass_side, &damping_side);
        let v_half = mix(&[(4.0 / dt, &u_half), (-4.0 / dt, u), (-1.0, v)]);
        let v_new = mix(&[(1.0 / dt, u), (-4.0 / dt, &u_half), (3.0 / dt, &u_new)]);
        let a_new = mix(&[(1.0 / dt, v), (-4.0 / dt, &v_half), (3.0 / dt, &v_new)]);
        self.state = [u_new, v_new, a_new];
    }

    /// One Newmark step under the modal force at its end.
    pub fn newmark(&mut self, beta: f64, gamma: f64, force: &[f64]) {
        let dt = self.step.time_step;
        let [u, v, a] = &self.state;
        let mix = |terms: &[(f64, &Vec<f64>)]| -> Vec<f64> {
            (0..self.r).map(|k| terms.iter().map(|(c, x)| c * x[k]).sum()).collect()
        };
        let (m, d) = (1.0 / (beta * dt * dt), gamma / (beta * dt));
        let mass_side = mix(&[(m, u), (1.0 / (beta * dt), v), (0.5 / beta - 1.0, a)]);
        let damping_side = mix(&[(d, u), (gamma / beta - 1.0, v), (dt * (0.5 * gamma / beta - 1.0), a)]);
        let u_new = self.solve(m, d, force, &mass_side, &damping_side);
        let a_new = mix(&[(m, &u_new), (-m, u), (-1.0 / (beta * dt), v), (1.0 - 0.5 / beta, a)]);
        let v_new = mix(&[(1.0, v), (dt * (1.0 - gamma), a), (dt * gamma, &a_new)]);
        self.state = [u_new, v_new, a_new];
    }
}
