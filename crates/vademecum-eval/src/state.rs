//! The state of a body: `(ζ, Δt ζ̇, Δt² ζ̈)` in lent memory.

use crate::error::{BindError, StepError};
use crate::scalar::Scalar;
use crate::scene::Scene;
use crate::shape::Shape;

/// The state `y = (ζ, Δt ζ̇, Δt² ζ̈)` of length `3r` [m kg^½], old and new side by side in lent memory.
#[derive(Debug)]
pub struct State<'m, T> {
    pub(crate) shape: Shape,
    pub(crate) now: &'m mut [T],
    pub(crate) next: &'m mut [T],
    pub(crate) at_rest: bool,
}

impl<'m, T: Scalar> State<'m, T> {
    /// A body at rest. `memory` holds at least [`crate::Sizes::state`] numbers; what is in it does not matter.
    ///
    /// # Errors
    /// [`BindError::LentMemory`].
    pub fn new(scene: &Scene<'_, T>, memory: &'m mut [T]) -> Result<Self, BindError> {
        let (shape, found) = (scene.shape, memory.len());
        let short = BindError::LentMemory {
            found,
            needed: shape.state_len(),
        };
        let memory = memory.get_mut(..shape.state_len()).ok_or(short)?;
        let (now, next) = memory.split_at_mut_checked(shape.padded()).ok_or(short)?;
        now.fill(T::ZERO);
        next.fill(T::ZERO);
        Ok(Self {
            shape,
            now,
            next,
            at_rest: true,
        })
    }

    /// Puts the body at rest.
    pub fn rest(&mut self) {
        self.now.fill(T::ZERO);
        self.at_rest = true;
    }

    /// `ζ`, length `r`.
    #[must_use]
    pub fn zeta(&self) -> &[T] {
        self.part(0)
    }

    /// `Δt ζ̇`, length `r`.
    #[must_use]
    pub fn scaled_velocity(&self) -> &[T] {
        self.part(1)
    }

    /// `Δt² ζ̈`, length `r`.
    #[must_use]
    pub fn scaled_acceleration(&self) -> &[T] {
        self.part(2)
    }

    /// Copies the state to `out`, length `3r`: `ζ`, then `Δt ζ̇`, then `Δt² ζ̈`. [`State::restore`] takes it back, bit for bit.
    ///
    /// # Errors
    /// [`StepError::Mismatch`] if the length is not `3r`.
    pub fn save_into(&self, out: &mut [T]) -> Result<(), StepError> {
        if out.len() != 3 * self.shape.r {
            return Err(StepError::Mismatch);
        }
        for (place, out) in out.chunks_exact_mut(self.shape.r.max(1)).enumerate() {
            out.iter_mut()
                .zip(self.part(place))
                .for_each(|(out, &value)| *out = value);
        }
        Ok(())
    }

    /// Takes back what [`State::save_into`] wrote.
    ///
    /// # Errors
    /// [`StepError::Mismatch`] if the length is not `3r`, [`StepError::NotFinite`] if a number is not; the state is then
    /// unchanged.
    pub fn restore(&mut self, saved: &[T]) -> Result<(), StepError> {
        let r = self.shape.r;
        if saved.len() != 3 * r {
            return Err(StepError::Mismatch);
        }
        if saved.iter().any(|value| !value.to_f64().is_finite()) {
            return Err(StepError::NotFinite);
        }
        for (place, part) in saved.chunks_exact(r.max(1)).enumerate() {
            self.part_mut(place)
                .iter_mut()
                .zip(part)
                .for_each(|(out, &value)| *out = value);
        }
        self.at_rest = saved.iter().all(|&value| value == T::ZERO);
        Ok(())
    }

    pub(crate) fn part(&self, place: usize) -> &[T] {
        let start = place * self.shape.stride();
        self.now
            .get(start..start + self.shape.r)
            .unwrap_or_default()
    }

    pub(crate) fn part_mut(&mut self, place: usize) -> &mut [T] {
        let start = place * self.shape.stride();
        self.now
            .get_mut(start..start + self.shape.r)
            .unwrap_or_default()
    }
}
