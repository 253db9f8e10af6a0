//! Setting a state and advancing it, stage by stage.

use super::error::ChapterStepError;
use super::loads::ChapterLoads;
use super::scene::ChapterScene;
use super::state::ChapterState;
use super::terms::Outside;
use vademecum_eval::{Scalar, Status, StepError};
use vademecum_format::scheme::StepParameters;
use vademecum_format::{ChapterAxis, ChapterRole};

impl ChapterScene<'_> {
    /// Sets displacement and velocity in reduced coordinates and computes the acceleration that goes with
    /// them under `loads`.
    ///
    /// # Errors
    /// [`StepError`]; the state is then unchanged.
    pub fn set(
        &self,
        state: &mut ChapterState,
        zeta: &[f64],
        zeta_dot: &[f64],
        loads: &ChapterLoads,
    ) -> Result<(), StepError> {
        self.check_same(state, loads)?;
        self.place(state, zeta, zeta_dot, &loads.force)?;
        (state.at_rest, state.unstarted) = (false, false);
        if state.y.iter().all(|&value| value == 0.0) {
            state.come_to_rest();
        }
        Ok(())
    }

    /// Advances `state` by `Δt` under `loads`. The first step starts with the acceleration that they demand.
    ///
    /// # Errors
    /// [`ChapterStepError`]; the state is then unchanged.
    pub fn step(&self, state: &mut ChapterState, loads: &ChapterLoads) -> Result<Status, ChapterStepError> {
        self.check_same(state, loads)?;
        if state.at_rest && !loads.active {
            state.unstarted = false;
            return Ok(Status::AtRest);
        }
        if !state.unstarted {
            return self.advance(state, loads);
        }
        let zero = vec![0.0; self.shape.r];
        self.place(state, &zero, &zero, &loads.force)?;
        let status = self.advance(state, loads);
        if status.is_err() {
            state.rest();
        }
        status
    }

    fn check_same(&self, state: &ChapterState, loads: &ChapterLoads) -> Result<(), StepError> {
        let same = state.shape == self.shape && loads.shape == self.shape;
        if same { Ok(()) } else { Err(StepError::Mismatch) }
    }

    /// Displacement, velocity and `ζ̈ = BᵀF − C_r ζ̇ − K_r ζ`, all of it or nothing: the basis is orthonormal
    /// in the mass, and `C_r = α + β K_r`.
    fn place(
        &self,
        state: &mut ChapterState,
        zeta: &[f64],
        zeta_dot: &[f64],
        force: &[f64],
    ) -> Result<(), StepError> {
        let (r, StepParameters { time_step: dt, alpha, beta, .. }) = (self.shape.r, *self.parameters());
        if [zeta.len(), zeta_dot.len()] != [r; 2] {
            return Err(StepError::Mismatch);
        }
        for k in 0..r {
            let elastic = self.stiffness_row(k, zeta) + beta * self.stiffness_row(k, zeta_dot);
            state.next[k] = zeta[k];
            state.next[r + k] = dt * zeta_dot[k];
            state.next[2 * r + k] = dt * dt * (force[k] - elastic - alpha * zeta_dot[k]);
        }
        if state.next.iter().any(|value| !value.is_finite()) {
            return Err(StepError::NotFinite);
        }
        std::mem::swap(&mut state.y, &mut state.next);
        Ok(())
    }

    /// A step of a body that has started; an unloaded one that is small enough rests then.
    fn advance(&self, state: &mut ChapterState, loads: &ChapterLoads) -> Result<Status, ChapterStepError> {
        self.stages(state, loads)?;
        let magnitude = self.finish(state);
        if !magnitude.is_finite() {
            return Err(StepError::NotFinite.into());
        }
        std::mem::swap(&mut state.y, &mut state.next);
        (state.at_rest, state.unstarted) = (false, false);
        if !loads.active && magnitude <= self.rest_below {
            state.come_to_rest();
            return Ok(Status::AtRest);
        }
        Ok(Status::Moving)
    }

    /// The stages in order, from the state and the loads.
    fn stages(&self, state: &mut ChapterState, loads: &ChapterLoads) -> Result<(), ChapterStepError> {
        let r = self.shape.r;
        state.stages.copy_from_slice(&loads.increment);
        for piece in self.pieces.iter().filter(|piece| piece.part.has_state()) {
            let stage = piece.part.stage;
            let (earlier, rest) = state.stages.split_at_mut(stage * r);
            let value = |role: ChapterRole| match role {
                ChapterRole::State { family, mode } => entry(&state.y, earlier, r, family, mode),
                other => loads.held.value(other, stage),
            };
            let outside = |Outside { axis: ChapterAxis { role, lower, upper, .. }, value }| {
                ChapterStepError::OutsideAxis { stage, role, value, lower, upper }
            };
            piece.add(value, &mut state.weights, &mut rest[..r]).map_err(outside)?;
        }
        Ok(())
    }

    /// The scheme's finish, beside the state. Gives `Σ|y|` of the new one. Numbers below the evaluator's
    /// floor are set to zero.
    fn finish(&self, state: &mut ChapterState) -> f64 {
        let (r, n_families) = (self.shape.r, 3 + self.shape.n_stages);
        let mut sum = 0.0;
        for (row, new) in self.metadata.scheme.finish.iter().zip(state.next.chunks_exact_mut(r)) {
            for (mode, new) in new.iter_mut().enumerate() {
                let terms = row.iter().take(n_families).enumerate();
                let value: f64 =
                    terms.map(|(family, w)| w * entry(&state.y, &state.stages, r, family, mode)).sum();
                sum += value.abs();
                *new = if value.abs() < f64::FLOOR { 0.0 } else { value };
            }
        }
        sum
    }
}

/// An entry of the history `(ζ, Δt ζ̇, Δt² ζ̈, ζ_1, …)`.
fn entry(y: &[f64], stages: &[f64], r: usize, family: usize, mode: usize) -> f64 {
    if family < 3 { y[family * r + mode] } else { stages[(family - 3) * r + mode] }
}
