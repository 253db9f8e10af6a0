//! The state of a body: `(ζ, Δt ζ̇, Δt² ζ̈)` in lent memory.

use crate::base::error::{BindError, StepError};
use crate::base::lend::Lender;
use crate::base::scalar::Scalar;
use crate::kernels::coordinates::Coordinates;
use crate::scene::loads::Loads;
use crate::scene::scene::Scene;
use crate::scene::shape::Shape;
use crate::sections::filter::Filtered;
use crate::sections::residual::Statics;

/// The state `y = (ζ, Δt ζ̇, Δt² ζ̈)` of length `3r` [m kg^½], old and new side by side in lent memory.
#[derive(Debug)]
pub struct State<'m, T> {
    pub(crate) shape: Shape,
    pub(crate) y: Coordinates<'m, T>,
    /// Forces of the last step, for what the modes leave out.
    pub(crate) statics: Statics<'m, T>,
    /// The same through the filter of stiffness-proportional damping; no room without one.
    pub(crate) filtered: Filtered<'m, T>,
    /// Scratch of a step of the strain structure.
    pub(crate) scratch: &'m mut [T],
}

impl<'m, T: Scalar> State<'m, T> {
    /// A body at rest, which has not started yet: its first [`Scene::step`] starts with the acceleration that
    /// the loads of that step demand. `memory` holds at least [`crate::Sizes::state`] numbers; what is in it
    /// does not matter.
    ///
    /// ```
    /// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/bound.rs"));
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// # bound!(BODY, Auto: file, sizes, scene, state, loads, work);
    /// let mut memory = vec![f64::NAN; sizes.state];
    /// let state = State::new(&scene, &mut memory)?;
    /// assert_eq!(state.zeta(), [0.0; 3]);
    /// assert_eq!(state.time_step(), 1e-3);
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// [`BindError::LentMemory`].
    pub fn new(scene: &Scene<'_, T>, memory: &'m mut [T]) -> Result<Self, BindError> {
        let (shape, found) = (scene.shape, memory.len());
        let short = BindError::LentMemory { found, needed: shape.state_len() };
        let memory = memory.get_mut(..shape.state_len()).ok_or(short)?;
        let mut memory = Lender::new(memory);
        let y = Coordinates::new(shape.parts(), scene.parameters.time_step, &mut memory)?;
        let statics = Statics::new(shape.statics, &mut memory)?;
        let filtered = Filtered::new(shape.filtered, &mut memory)?;
        let scratch = memory.take(shape.scratch_len())?;
        scratch.fill(T::ZERO);
        Ok(Self { shape, y, statics, filtered, scratch })
    }

    /// Puts the body at rest, as [`State::new`] does: the next step is again a first one.
    pub fn rest(&mut self) {
        self.y.rest();
        self.statics.clear();
        self.clear_filtered();
    }

    /// Drops all filtered forces.
    pub(crate) fn clear_filtered(&mut self) {
        if self.shape.is_filtered() {
            self.filtered.clear();
        }
    }

    /// `Δt` \[s\] by which this state is scaled: that of the scene it was made for, set in or carried to.
    #[must_use]
    pub const fn time_step(&self) -> f64 {
        self.y.time_step
    }

    /// Carries the state over to the parameters of `scene`: displacement, velocity and acceleration stay what
    /// they are, so `Δt ζ̇` and `Δt² ζ̈` change when `Δt` has. Wanted after [`Scene::rebind`];
    /// [`Scene::set_parameters`] does it itself.
    ///
    /// # Errors
    /// [`StepError::Mismatch`] for a scene of another shape, [`StepError::NotFinite`] if a number leaves the
    /// precision; the state is then unchanged.
    pub fn carry(&mut self, scene: &Scene<'_, T>) -> Result<(), StepError> {
        if self.shape != scene.shape {
            return Err(StepError::Mismatch);
        }
        self.y.scale_to(scene.parameters.time_step)?;
        self.y.accept(scene.parameters.time_step);
        Ok(())
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

    /// Copies the state to `out`, length `3r`: `ζ`, then `Δt ζ̇`, then `Δt² ζ̈`. [`State::restore`] takes it
    /// back, bit for bit, in a state of the same [`State::time_step`]. A state that has not started yet is
    /// all zeros, and its last zero has the negative sign, so that it is restored as one.
    ///
    /// ```
    /// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/bound.rs"));
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// # bound!(BODY, Auto: file, sizes, scene, state, loads, work);
    /// loads.add_pattern(&scene, 0, 1.0)?;
    /// scene.step(&mut state, &loads)?;
    /// let mut saved = vec![0.0; 3 * scene.n_modes()];
    /// state.save_into(&mut saved)?;
    /// assert_eq!(saved[..3], *state.zeta());
    /// assert_eq!(saved[3..6], *state.scaled_velocity());
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// [`StepError::Mismatch`] if the length is not `3r`.
    pub fn save_into(&self, out: &mut [T]) -> Result<(), StepError> {
        self.y.save_into(out)
    }

    /// Takes back what [`State::save_into`] wrote at the same `Δt`. Until the next step outputs leave out
    /// what the modes leave out, and reactions are refused: the forces of the last step are not part of it.
    ///
    /// ```
    /// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/bound.rs"));
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// # bound!(BODY, Auto: file, sizes, scene, state, loads, work);
    /// loads.add_pattern(&scene, 0, 1.0)?;
    /// scene.step(&mut state, &loads)?;
    /// let mut saved = vec![0.0; 3 * scene.n_modes()];
    /// state.save_into(&mut saved)?;
    /// scene.step(&mut state, &loads)?;
    /// let once = state.zeta().to_vec();
    /// state.restore(&saved)?;
    /// scene.step(&mut state, &loads)?;
    /// assert_eq!(state.zeta(), once); // every bit
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// [`StepError::Mismatch`] if the length is not `3r`, [`StepError::NotFinite`] if a number is not; the
    /// state is then unchanged.
    pub fn restore(&mut self, saved: &[T]) -> Result<(), StepError> {
        self.y.restore(saved)?;
        self.statics.forget();
        self.clear_filtered();
        Ok(())
    }

    /// [`State::restore`] of a state that was saved after a step under `loads`: outputs add again what the
    /// modes leave out of the answer to them. With stiffness-proportional damping the residual is taken to be
    /// in equilibrium with these loads; [`Body::restore`](crate::Body::restore) brings back every bit.
    ///
    /// ```
    /// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/bound.rs"));
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// # bound!(BODY, Auto: file, sizes, scene, state, loads, work);
    /// loads.add_pattern(&scene, 0, 1.0)?;
    /// scene.step(&mut state, &loads)?;
    /// let mut saved = vec![0.0; scene.state_numbers()];
    /// state.save_into(&mut saved)?;
    /// let shown = scene.probe(&state, 0, Field::Displacement)?;
    /// state.rest();
    /// state.restore_under(&saved, &loads)?;
    /// assert_eq!(scene.probe(&state, 0, Field::Displacement)?, shown); // every bit
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// As [`State::restore`]; [`StepError::Mismatch`] for loads of another shape.
    pub fn restore_under(&mut self, saved: &[T], loads: &Loads<'_, T>) -> Result<(), StepError> {
        if loads.shape != self.shape {
            return Err(StepError::Mismatch);
        }
        self.y.restore(saved)?;
        self.settle_residual(loads);
        Ok(())
    }

    /// Remembers the forces of `loads`, and a residual in equilibrium with them.
    pub(crate) fn settle_residual(&mut self, loads: &Loads<'_, T>) {
        self.statics.copy(&loads.statics);
        if self.shape.is_filtered() {
            self.filtered.settle(&loads.statics);
        }
    }

    /// Numbers of filtered forces, which the residual flexibility shows under stiffness-proportional damping;
    /// 0 without.
    #[must_use]
    pub const fn filter_numbers(&self) -> usize {
        self.filtered.numbers()
    }

    /// Copies the filtered forces to `out`, [`State::filter_numbers`] numbers, for
    /// [`State::restore_filter`].
    ///
    /// # Errors
    /// [`StepError::Mismatch`] for another length.
    pub fn save_filter_into(&self, out: &mut [T]) -> Result<(), StepError> {
        Ok(self.filtered.save_into(out)?)
    }

    /// Takes back what [`State::save_filter_into`] wrote, bit for bit; after [`State::restore`] or
    /// [`State::restore_under`].
    ///
    /// # Errors
    /// [`StepError::Mismatch`] for other numbers; nothing has changed then.
    pub fn restore_filter(&mut self, saved: &[T]) -> Result<(), StepError> {
        self.filtered.restore(saved).ok_or(StepError::Mismatch)
    }

    /// The forces that the residual flexibility answers: filtered where the damping asks for it.
    #[inline(always)]
    pub(crate) const fn shown(&self) -> &Statics<'m, T> {
        if self.shape.is_filtered() { &self.filtered.forces } else { &self.statics }
    }
}
