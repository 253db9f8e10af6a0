//! The state of a body: `(ζ, Δt ζ̇, Δt² ζ̈)` in lent memory.

use crate::error::{BindError, StepError};
use crate::scalar::Scalar;
use crate::scene::Scene;
use crate::shape::Shape;

/// The state `y = (ζ, Δt ζ̇, Δt² ζ̈)` of length `3r` [m kg^½], old and new side by side in lent memory.
#[derive(Debug)]
pub struct State<'m, T> {
    pub(crate) shape: Shape,
    /// `Δt` \[s\] the velocity and acceleration are scaled by.
    pub(crate) time_step: f64,
    pub(crate) now: &'m mut [T],
    pub(crate) next: &'m mut [T],
    /// What a step of the canonical structure needs beside them.
    pub(crate) scratch: &'m mut [T],
    pub(crate) at_rest: bool,
}

impl<'m, T: Scalar> State<'m, T> {
    /// A body at rest. `memory` holds at least [`crate::Sizes::state`] numbers; what is in it does not matter.
    ///
    /// # Errors
    /// [`BindError::LentMemory`].
    pub fn new(scene: &Scene<'_, T>, memory: &'m mut [T]) -> Result<Self, BindError> {
        let (shape, found) = (scene.shape, memory.len());
        let short = BindError::LentMemory { found, needed: shape.state_len() };
        let memory = memory.get_mut(..shape.state_len()).ok_or(short)?;
        let (now, rest) = memory.split_at_mut_checked(shape.padded()).ok_or(short)?;
        let (next, scratch) = rest.split_at_mut_checked(shape.padded()).ok_or(short)?;
        now.fill(T::ZERO);
        next.fill(T::ZERO);
        Ok(Self { shape, time_step: scene.parameters.time_step, now, next, scratch, at_rest: true })
    }

    /// Puts the body at rest.
    pub fn rest(&mut self) {
        self.now.fill(T::ZERO);
        self.at_rest = true;
    }

    /// `Δt` \[s\] by which this state is scaled: that of the scene it was made for, set in or carried to.
    #[must_use]
    pub const fn time_step(&self) -> f64 {
        self.time_step
    }

    /// Carries the state over to the parameters of `scene`: displacement, velocity and acceleration stay what they are, so
    /// `Δt ζ̇` and `Δt² ζ̈` change when `Δt` has. Wanted after [`Scene::rebind`]; [`Scene::set_parameter`] does it itself.
    ///
    /// # Errors
    /// [`StepError::Mismatch`] for a scene of another shape, [`StepError::NotFinite`] if a number leaves the precision; the state
    /// is then unchanged.
    pub fn carry(&mut self, scene: &Scene<'_, T>) -> Result<(), StepError> {
        if self.shape != scene.shape {
            return Err(StepError::Mismatch);
        }
        self.scale_to(scene.parameters.time_step)?;
        self.accept(scene.parameters.time_step);
        Ok(())
    }

    /// Writes the state scaled by another `Δt` beside the current one.
    pub(crate) fn scale_to(&mut self, time_step: f64) -> Result<(), StepError> {
        let ratio = time_step / self.time_step;
        self.next.iter_mut().zip(&*self.now).for_each(|(next, &now)| *next = now);
        let stride = self.shape.stride();
        let (_, rates) = self.next.split_at_mut_checked(stride).unwrap_or_default();
        let (velocity, acceleration) = rates.split_at_mut_checked(stride).unwrap_or_default();
        for (part, factor) in [(velocity, ratio), (acceleration, ratio * ratio)] {
            part.iter_mut().for_each(|value| *value = T::from_f64(value.to_f64() * factor));
        }
        let finite = self.next.iter().all(|value| value.to_f64().is_finite());
        if finite { Ok(()) } else { Err(StepError::NotFinite) }
    }

    /// Takes what was written beside the state, scaled by `time_step`.
    pub(crate) fn accept(&mut self, time_step: f64) {
        core::mem::swap(&mut self.now, &mut self.next);
        self.time_step = time_step;
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

    /// Copies the state to `out`, length `3r`: `ζ`, then `Δt ζ̇`, then `Δt² ζ̈`. [`State::restore`] takes it back, bit for bit, in a state of
    /// the same [`State::time_step`].
    ///
    /// # Errors
    /// [`StepError::Mismatch`] if the length is not `3r`.
    pub fn save_into(&self, out: &mut [T]) -> Result<(), StepError> {
        if out.len() != 3 * self.shape.r {
            return Err(StepError::Mismatch);
        }
        for (place, out) in out.chunks_exact_mut(self.shape.r.max(1)).enumerate() {
            out.iter_mut().zip(self.part(place)).for_each(|(out, &value)| *out = value);
        }
        Ok(())
    }

    /// Takes back what [`State::save_into`] wrote at the same `Δt`.
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
            self.part_mut(place).iter_mut().zip(part).for_each(|(out, &value)| *out = value);
        }
        self.at_rest = saved.iter().all(|&value| value == T::ZERO);
        Ok(())
    }

    pub(crate) fn part(&self, place: usize) -> &[T] {
        let start = place * self.shape.stride();
        self.now.get(start..start + self.shape.r).unwrap_or_default()
    }

    pub(crate) fn part_mut(&mut self, place: usize) -> &mut [T] {
        let start = place * self.shape.stride();
        self.now.get_mut(start..start + self.shape.r).unwrap_or_default()
    }
}
