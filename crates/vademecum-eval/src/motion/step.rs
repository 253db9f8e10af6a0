//! The step of a scene, and what a state and loads must agree on with it.

use crate::base::error::StepError;
use crate::base::options::{Status, Structure};
use crate::base::scalar::Scalar;
use crate::kernels::kernel::{blocks, step_dense, step_diagonal, step_exact};
use crate::scene::loads::Loads;
use crate::scene::scene::Scene;
use crate::scene::state::State;

impl<T: Scalar> Scene<'_, T> {
    /// Advances `state` by `Δt` under `loads`.
    ///
    /// The first step of a [`State::new`] starts with the acceleration that `loads` demand at its start, as
    /// [`Scene::set`] would give it: the body has been at rest, and the loads act from the start of this
    /// step. A load that is added or taken away later meets the body as the last step left it, as in the
    /// full-order march. Its jump is then spread over the step by the time scheme.
    ///
    /// ```
    /// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/bound.rs"));
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// # bound!(BODY, Auto: file, sizes, scene, state, loads, work);
    /// assert_eq!(scene.step(&mut state, &loads)?, Status::AtRest); // nothing acts, nothing moves
    /// loads.add_pattern(&scene, 0, 1.0)?;
    /// for _ in 0..100 {
    ///     assert_eq!(scene.step(&mut state, &loads)?, Status::Moving);
    /// }
    /// loads.clear();
    /// let released = scene.energy(&state)?;
    /// for _ in 0..1000 {
    ///     scene.step(&mut state, &loads)?;
    /// }
    /// assert!(scene.energy(&state)? < released); // the body is damped
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// [`StepError`]; the state is then unchanged.
    pub fn step(&self, state: &mut State<'_, T>, loads: &Loads<'_, T>) -> Result<Status, StepError> {
        if state.shape != self.shape || loads.shape != self.shape {
            return Err(StepError::Mismatch);
        }
        self.check_carried(state)?;
        if state.y.at_rest {
            if !loads.active {
                state.y.unstarted = false;
                state.statics.clear();
                if self.shape.is_filtered() {
                    return Ok(self.follow(state, loads, Status::AtRest));
                }
                return Ok(Status::AtRest);
            }
            if self.shape.n_parts() > 2 && state.y.unstarted {
                return self.first_step(state, loads);
            }
        }
        self.check_fresh(loads)?;
        self.advance(state, loads)
    }

    /// The first step of a body, which starts with the acceleration that the loads demand.
    #[cold]
    fn first_step(&self, state: &mut State<'_, T>, loads: &Loads<'_, T>) -> Result<Status, StepError> {
        self.check_fresh(loads)?;
        self.equation().start(&mut state.y, loads.force)?;
        let status = self.advance(state, loads);
        if status.is_err() {
            state.y.rest();
        }
        status
    }

    #[inline(always)]
    fn advance(&self, state: &mut State<'_, T>, loads: &Loads<'_, T>) -> Result<Status, StepError> {
        if self.shape.is_strain() {
            return self.march_strain(state, loads, None);
        }
        let filters = self.shape.is_filtered();
        if filters {
            state.filtered.check(&loads.drive)?;
        }
        let magnitude = self.step_into(state.y.now, loads.increment, state.y.next)?;
        let status = state.y.settle(magnitude, loads.active, self.rest_below)?;
        state.statics.copy(&loads.statics);
        Ok(if filters { self.follow(state, loads, status) } else { status })
    }

    /// The coordinates after a step, for the structures whose step is a map; `Σ|y|`.
    #[inline(always)]
    pub(crate) fn step_into(&self, old: &[T], load: &[T], new: &mut [T]) -> Result<T, StepError> {
        Ok(match self.shape.structure() {
            Structure::Diagonal => step_diagonal(blocks(self.map), old, load, new)?,
            Structure::Exact if self.shape.is_coupled() => self.step_together(old, load, new),
            Structure::Exact => step_exact(blocks(self.map), old, load, new)?,
            Structure::Block => self.step_together(old, load, new),
            Structure::Strain => return Err(StepError::Mismatch),
        })
    }

    /// A step of all coordinates together.
    pub(crate) fn step_together(&self, old: &[T], load: &[T], new: &mut [T]) -> T {
        step_dense(self.map.as_chunks().0, self.shape.columns(), old, load, new)
    }

    /// The filtered forces after a step. A body is not at rest before they are gone.
    #[inline(never)]
    fn follow(&self, state: &mut State<'_, T>, loads: &Loads<'_, T>, status: Status) -> Status {
        state.filtered.step(&self.filter, &loads.drive);
        if state.filtered.forces.is_empty() { status } else { Status::Moving }
    }

    pub(crate) fn check_carried(&self, state: &State<'_, T>) -> Result<(), StepError> {
        if state.y.time_step == self.parameters.time_step { Ok(()) } else { Err(StepError::NotCarried) }
    }

    pub(crate) fn check_fresh(&self, loads: &Loads<'_, T>) -> Result<(), StepError> {
        if loads.active && loads.generation != self.generation { Err(StepError::StaleLoads) } else { Ok(()) }
    }
}
