//! Setting a state and advancing it, stage by stage.

use super::error::ChapterStepError;
use super::loads::ChapterLoads;
use super::scene::ChapterScene;
use super::state::ChapterState;
use super::terms::{Unknown, pieces};
use crate::base::error::StepError;
use crate::base::lend::{Lender, Short};
use crate::base::options::Status;
use crate::base::scalar::Scalar;
use crate::kernels::kernel::flushed;
use vademecum_format::{ChapterAxis, ChapterRole};

impl<T: Scalar> ChapterScene<'_, T> {
    /// Sets displacement and velocity in reduced coordinates and computes the acceleration that goes with
    /// them under `loads`, as [`Scene::set`](crate::Scene::set) does.
    ///
    /// # Errors
    /// [`StepError`]; the state is then unchanged.
    pub fn set(
        &self,
        state: &mut ChapterState<'_, T>,
        zeta: &[f64],
        zeta_dot: &[f64],
        loads: &ChapterLoads<'_, T>,
    ) -> Result<(), StepError> {
        if state.shape != self.shape || loads.shape != self.shape {
            return Err(StepError::Mismatch);
        }
        self.equation().place(&mut state.y, zeta, zeta_dot, loads.force)
    }

    /// Advances `state` by `Δt` under `loads`. The first step starts with the acceleration that they demand,
    /// as that of [`Scene::step`](crate::Scene::step) does.
    ///
    /// # Errors
    /// [`ChapterStepError`]; the state is then unchanged.
    pub fn step(
        &self,
        state: &mut ChapterState<'_, T>,
        loads: &ChapterLoads<'_, T>,
    ) -> Result<Status, ChapterStepError> {
        if state.shape != self.shape || loads.shape != self.shape {
            return Err(StepError::Mismatch.into());
        }
        if state.y.at_rest && !loads.active {
            state.y.unstarted = false;
            return Ok(Status::AtRest);
        }
        if !state.y.unstarted {
            return self.advance(state, loads);
        }
        self.equation().start(&mut state.y, loads.force)?;
        let status = self.advance(state, loads);
        if status.is_err() {
            state.y.rest();
        }
        status
    }

    fn advance(
        &self,
        state: &mut ChapterState<'_, T>,
        loads: &ChapterLoads<'_, T>,
    ) -> Result<Status, ChapterStepError> {
        self.stages(state, loads)?;
        let magnitude = self.finish(state)?;
        Ok(state.y.settle(magnitude, loads.active, self.rest_below)?)
    }

    /// The stages in order, from the state and the loads.
    fn stages(
        &self,
        state: &mut ChapterState<'_, T>,
        loads: &ChapterLoads<'_, T>,
    ) -> Result<(), ChapterStepError> {
        let (r, now) = (self.shape.r, &*state.y.now);
        state.stages.iter_mut().zip(&*loads.increment).for_each(|(stage, &load)| *stage = load);
        for piece in pieces(&self.chapter, self.factors, self.terms) {
            let piece = piece?;
            if !piece.part.has_state() {
                continue;
            }
            let stage = piece.part.stage;
            let mut stages = Lender::new(&mut *state.stages);
            let (earlier, out) = (stages.take(stage.saturating_mul(r))?, stages.take(r)?);
            let value = |role: ChapterRole| match role {
                ChapterRole::State { family, mode } => entry(now, earlier, r, family, mode),
                other => loads.held.value(other, stage),
            };
            piece.add(value, state.weights, out).map_err(|unknown| match unknown {
                Unknown::Outside(ChapterAxis { role, lower, upper, .. }, value) => {
                    ChapterStepError::OutsideAxis { stage, role, value, lower, upper }
                }
                Unknown::Short(short) => short.into(),
            })?;
        }
        Ok(())
    }

    /// The scheme's finish, beside the state. Gives `Σ|y|` of the new one.
    fn finish(&self, state: &mut ChapterState<'_, T>) -> Result<T, Short> {
        let (r, now) = (self.shape.r, &*state.y.now);
        let mut sum = T::ZERO;
        let rows = self.metadata.scheme.finish.iter();
        for (row, new) in rows.zip(state.y.next.chunks_exact_mut(r.max(1))) {
            for (mode, new) in new.iter_mut().enumerate() {
                let terms = row.iter().take(3 + self.shape.n_stages).enumerate();
                let weighted = terms.map(|(family, w)| Ok(w * entry(now, state.stages, r, family, mode)?));
                *new = flushed(T::from_f64(weighted.sum::<Result<f64, Short>>()?), &mut sum);
            }
        }
        Ok(sum)
    }
}

/// An entry of the history `(ζ, Δt ζ̇, Δt² ζ̈, ζ_1, …)`.
fn entry<T: Scalar>(now: &[T], stages: &[T], r: usize, family: usize, mode: usize) -> Result<f64, Short> {
    let (from, family) = if family < 3 { (now, family) } else { (stages, family - 3) };
    let at = family * r + mode;
    from.get(at).map(|x| x.to_f64()).ok_or(Short { found: from.len(), needed: at.saturating_add(1) })
}
