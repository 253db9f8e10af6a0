//! The state of a body that is stepped by the chapter's structure.

use super::error::ChapterBindError;
use super::scene::ChapterScene;
use crate::base::error::{BindError, StepError};
use crate::base::lend::Lender;
use crate::base::scalar::Scalar;
use crate::kernels::coordinates::Coordinates;

use super::scene::Shape;

/// The state `(ζ, Δt ζ̇, Δt² ζ̈)` of length `3r` [m kg^½], with what a step writes beside it, in lent memory.
#[derive(Debug)]
pub struct ChapterState<'m, T> {
    pub(super) shape: Shape,
    pub(super) y: Coordinates<'m, T>,
    /// `ζ_i` of each stage, `(n_stages, r)`.
    pub(super) stages: &'m mut [T],
    /// Weights of the terms of a part.
    pub(super) weights: &'m mut [T],
}

impl<'m, T: Scalar> ChapterState<'m, T> {
    /// A body at rest, which has not started yet. `memory` holds at least
    /// [`Sizes::state`](crate::Sizes::state) numbers; what is in it does not matter.
    ///
    /// # Errors
    /// [`BindError::LentMemory`].
    pub fn new(scene: &ChapterScene<'_, T>, memory: &'m mut [T]) -> Result<Self, ChapterBindError> {
        let shape = scene.shape;
        let (found, needed) = (memory.len(), shape.state_len());
        let memory = memory.get_mut(..needed).ok_or(BindError::LentMemory { found, needed })?;
        let mut memory = Lender::new(memory);
        let y = Coordinates::new(shape.parts(), shape.time_step, &mut memory)?;
        let (stages, weights) = (memory.take(shape.n_stages * shape.r)?, memory.take(shape.n_terms)?);
        Ok(Self { shape, y, stages, weights })
    }

    /// Puts the body at rest, as [`ChapterState::new`] does.
    pub fn rest(&mut self) {
        self.y.rest();
    }

    /// `ζ`, length `r`.
    #[must_use]
    pub fn zeta(&self) -> &[T] {
        self.y.part(0)
    }

    /// `Δt ζ̇`, length `r`.
    #[must_use]
    pub fn scaled_velocity(&self) -> &[T] {
        self.y.part(1)
    }

    /// `Δt² ζ̈`, length `r`.
    #[must_use]
    pub fn scaled_acceleration(&self) -> &[T] {
        self.y.part(2)
    }

    /// Copies the state to `out`, length `3r`: `ζ`, then `Δt ζ̇`, then `Δt² ζ̈`. [`ChapterState::restore`]
    /// takes it back, bit for bit.
    ///
    /// # Errors
    /// [`StepError::Mismatch`] if the length is not `3r`.
    pub fn save_into(&self, out: &mut [T]) -> Result<(), StepError> {
        self.y.save_into(out)
    }

    /// Takes back what [`ChapterState::save_into`] wrote.
    ///
    /// # Errors
    /// [`StepError::Mismatch`] if the length is not `3r`, [`StepError::NotFinite`] if a number is not; the
    /// state is then unchanged.
    pub fn restore(&mut self, saved: &[T]) -> Result<(), StepError> {
        self.y.restore(saved)
    }
}
