//! Outputs of a state: probes, nodes, the surface, the body and the energy.

use super::scene::ChapterScene;
use super::state::ChapterState;
use crate::base::error::OutputError;
use crate::base::scalar::Scalar;
use crate::sections::rows::{Factors, Field, factors};
use crate::sections::surface::SurfacePoint;

impl<T: Scalar> ChapterScene<'_, T> {
    /// Value of probe `index`. `O(r)`.
    ///
    /// # Errors
    /// [`OutputError`].
    pub fn probe(&self, state: &ChapterState<'_, T>, index: usize, field: Field) -> Result<f64, OutputError> {
        self.rows.probe(index, self.multipliers(state, field)?)
    }

    /// Displacement or velocity of `node` (file order), three components. `O(r)`.
    ///
    /// # Errors
    /// [`OutputError`].
    pub fn node(
        &self,
        state: &ChapterState<'_, T>,
        node: usize,
        field: Field,
    ) -> Result<[f64; 3], OutputError> {
        self.rows.node(node, self.multipliers(state, field)?)
    }

    /// Displacement or velocity of a point of the surface, three components. `O(r)`.
    ///
    /// # Errors
    /// [`OutputError`].
    pub fn point(
        &self,
        state: &ChapterState<'_, T>,
        point: &SurfacePoint,
        field: Field,
    ) -> Result<[f64; 3], OutputError> {
        self.rows.point(&point.place, self.multipliers(state, field)?)
    }

    /// The surface, `out` of shape `(n_surface_nodes, 3)`. Bound by reading the basis once.
    ///
    /// # Errors
    /// [`OutputError`].
    pub fn surface_into(
        &self,
        state: &ChapterState<'_, T>,
        field: Field,
        out: &mut [T],
    ) -> Result<(), OutputError> {
        self.rows.surface_into(self.multipliers(state, field)?, out)
    }

    /// The whole body, `out` of shape `(n_nodes, 3)`. Bound by reading the basis once.
    ///
    /// # Errors
    /// [`OutputError`].
    pub fn body_into(
        &self,
        state: &ChapterState<'_, T>,
        field: Field,
        out: &mut [T],
    ) -> Result<(), OutputError> {
        self.rows.body_into(self.multipliers(state, field)?, out)
    }

    /// Kinetic plus elastic energy \[J\]. `O(r²)`.
    ///
    /// # Errors
    /// [`OutputError::Mismatch`].
    pub fn energy(&self, state: &ChapterState<'_, T>) -> Result<f64, OutputError> {
        self.check(state)?;
        Ok(self.equation().energy(&state.y).ok_or(OutputError::Mismatch)?.total())
    }

    fn multipliers<'s>(
        &self,
        state: &'s ChapterState<'_, T>,
        field: Field,
    ) -> Result<Factors<'s, T>, OutputError> {
        self.check(state)?;
        Ok(factors(&state.y, field))
    }

    fn check(&self, state: &ChapterState<'_, T>) -> Result<(), OutputError> {
        if state.shape == self.shape { Ok(()) } else { Err(OutputError::Mismatch) }
    }
}
