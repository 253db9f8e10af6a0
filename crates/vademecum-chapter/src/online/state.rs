//! The state of a body that is stepped by the chapter's structure.

use super::scene::{ChapterScene, Shape};
use vademecum_eval::StepError;

/// The state `(ζ, Δt ζ̇, Δt² ζ̈)` of length `3r` [m kg^½], with what a step writes beside it.
#[derive(Clone, Debug)]
pub struct ChapterState {
    pub(super) shape: Shape,
    pub(super) y: Vec<f64>,
    /// The new `y` of a step.
    pub(super) next: Vec<f64>,
    /// `ζ_i` of each stage, `(n_stages, r)`.
    pub(super) stages: Vec<f64>,
    /// Weights of the terms of a part.
    pub(super) weights: Vec<f64>,
    pub(super) at_rest: bool,
    /// Neither stepped nor set since it was put at rest: its first step begins with the acceleration that the
    /// loads demand.
    pub(super) unstarted: bool,
}

impl ChapterState {
    /// A body at rest, which has not started yet.
    #[must_use]
    pub fn new(scene: &ChapterScene<'_>) -> Self {
        let shape = scene.shape;
        let y = vec![0.0; 3 * shape.r];
        let stages = vec![0.0; shape.n_stages * shape.r];
        Self { shape, next: y.clone(), y, stages, weights: vec![], at_rest: true, unstarted: true }
    }

    /// Puts the body at rest, as [`ChapterState::new`] does.
    pub fn rest(&mut self) {
        self.come_to_rest();
        self.unstarted = true;
    }

    /// Lets a body that was stepped or set rest.
    pub(super) fn come_to_rest(&mut self) {
        self.y.fill(0.0);
        (self.at_rest, self.unstarted) = (true, false);
    }

    /// `ζ`, length `r`.
    #[must_use]
    pub fn zeta(&self) -> &[f64] {
        self.part(0)
    }

    /// `Δt ζ̇`, length `r`.
    #[must_use]
    pub fn scaled_velocity(&self) -> &[f64] {
        self.part(1)
    }

    /// `Δt² ζ̈`, length `r`.
    #[must_use]
    pub fn scaled_acceleration(&self) -> &[f64] {
        self.part(2)
    }

    fn part(&self, place: usize) -> &[f64] {
        &self.y[place * self.shape.r..(place + 1) * self.shape.r]
    }

    /// Copies the state to `out`, length `3r`: `ζ`, then `Δt ζ̇`, then `Δt² ζ̈`. [`ChapterState::restore`]
    /// takes it back, bit for bit; the sign of the last number, a zero, marks a body that has not started
    /// yet.
    ///
    /// # Errors
    /// [`StepError::Mismatch`] if the length is not `3r`.
    pub fn save_into(&self, out: &mut [f64]) -> Result<(), StepError> {
        if out.len() != self.y.len() {
            return Err(StepError::Mismatch);
        }
        out.copy_from_slice(&self.y);
        if let Some(last) = out.last_mut().filter(|_| self.unstarted) {
            *last = -0.0;
        }
        Ok(())
    }

    /// Takes back what [`ChapterState::save_into`] wrote.
    ///
    /// # Errors
    /// [`StepError::Mismatch`] if the length is not `3r`, [`StepError::NotFinite`] if a number is not; the
    /// state is then unchanged.
    pub fn restore(&mut self, saved: &[f64]) -> Result<(), StepError> {
        if saved.len() != self.y.len() {
            return Err(StepError::Mismatch);
        }
        if saved.iter().any(|value| !value.is_finite()) {
            return Err(StepError::NotFinite);
        }
        self.y.copy_from_slice(saved);
        (self.at_rest, self.unstarted) = (false, false);
        if saved.iter().all(|&value| value == 0.0) {
            self.come_to_rest();
            self.unstarted = saved.last().is_some_and(|last| last.is_sign_negative());
        }
        Ok(())
    }
}
