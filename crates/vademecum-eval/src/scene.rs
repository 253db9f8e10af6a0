//! Binding a file to parameters and memory, and the step.
//!
//! Binding fuses the stages (see `vademecum_format::scheme`), so a step is one small matrix-vector product. The diagonal
//! structure keeps a 3×3 block per mode and takes any `Δt`, stiffness, density and damping exactly; the block structure
//! keeps the dense `3r × 3r` map and takes what its axes allow.

use crate::bind::{Lent, Sections, fuse_block, fuse_modes, sections, step_parameters};
use crate::error::{BindError, StepError};
use crate::kernel::{step_dense, step_diagonal};
use crate::loads::Loads;
use crate::options::{SceneOptions, Sizes, Status, Structure};
use crate::scalar::Scalar;
use crate::shape::{Shape, shape};
use crate::state::State;
use vademecum_format::scheme::{MAX_STAGES, StepParameters};
use vademecum_format::{File, Metadata};

/// An opened file bound to parameters, ready to step. Immutable; states and loads are apart.
#[derive(Debug)]
pub struct Scene<'m, T> {
    pub(crate) shape: Shape,
    pub(crate) metadata: Metadata<'m>,
    pub(crate) parameters: StepParameters,
    pub(crate) sections: Sections<'m>,
    rest_below: T,
    map: &'m [T],
    load_maps: &'m [T],
    pub(crate) weights: &'m [T],
}

impl<'m, T: Scalar> Scene<'m, T> {
    /// The memory a scene of these options asks for.
    ///
    /// # Errors
    /// [`BindError::NoStructure`] and [`BindError::BadOption`].
    pub fn sizes(file: &File<'_>, options: &SceneOptions) -> Result<Sizes, BindError> {
        Ok(shape(file.metadata(), options)?.sizes())
    }

    /// Binds a file. `memory` and `work` hold at least what [`Scene::sizes`] says; what is in them does not matter.
    ///
    /// Cost: `O(r)` for the diagonal structure, `O(r³)` for the block structure. The basis is not touched.
    ///
    /// # Errors
    /// [`BindError`].
    pub fn bind(
        file: &File<'m>,
        options: &SceneOptions,
        memory: &'m mut [T],
        work: &mut [f64],
    ) -> Result<Self, BindError> {
        let metadata = *file.metadata();
        let shape = shape(&metadata, options)?;
        let sizes = shape.sizes();
        let parameters = step_parameters(&metadata, options);
        let short = |found, needed| BindError::LentMemory { found, needed };
        let (lent, lent_work) = (memory.len(), work.len());
        let memory = memory
            .get_mut(..sizes.scene)
            .ok_or(short(lent, sizes.scene))?;
        let work = work
            .get_mut(..sizes.work)
            .ok_or(short(lent_work, sizes.work))?;
        memory.fill(T::ZERO);
        let (map, rest) = memory
            .split_at_mut_checked(shape.map_len())
            .unwrap_or_default();
        let (load_maps, weights) = rest
            .split_at_mut_checked(shape.n_stages * shape.load_map_len())
            .unwrap_or_default();
        let sections = sections(file, shape.structure)?;
        match shape.structure {
            Structure::Diagonal => {
                fuse_modes(
                    &metadata.scheme,
                    &parameters,
                    &sections.stiffness,
                    shape,
                    map,
                    load_maps,
                )?;
            }
            Structure::Block => {
                fuse_block(
                    file,
                    &parameters,
                    shape,
                    Lent {
                        map,
                        load_maps,
                        weights,
                        work,
                    },
                )?;
            }
        }
        let mut bound = map.iter().chain(load_maps.iter()).chain(weights.iter());
        if bound.any(|value| !value.to_f64().is_finite()) {
            return Err(BindError::NotFinite);
        }
        let rest_below = T::from_f64(options.rest_below);
        Ok(Self {
            shape,
            metadata,
            parameters,
            sections,
            rest_below,
            map,
            load_maps,
            weights,
        })
    }

    /// The structure the scene took.
    #[must_use]
    pub const fn structure(&self) -> Structure {
        self.shape.structure
    }

    /// `r`: the number of modes.
    #[must_use]
    pub const fn n_modes(&self) -> usize {
        self.shape.r
    }

    /// What the file says about itself.
    #[must_use]
    pub const fn metadata(&self) -> &Metadata<'m> {
        &self.metadata
    }

    /// The parameters the scene is bound to.
    #[must_use]
    pub const fn parameters(&self) -> &StepParameters {
        &self.parameters
    }

    /// Instants at which a step needs a changing load, as fractions of it: 0, then one per stage; the rest is 0.
    #[must_use]
    pub fn instants(&self) -> [f64; 1 + MAX_STAGES] {
        self.metadata.scheme.instants()
    }

    /// Advances `state` by `Δt` under `loads`.
    ///
    /// # Errors
    /// [`StepError`]; the state is then unchanged.
    pub fn step(
        &self,
        state: &mut State<'_, T>,
        loads: &Loads<'_, T>,
    ) -> Result<Status, StepError> {
        if state.shape != self.shape || loads.shape != self.shape {
            return Err(StepError::Mismatch);
        }
        if state.at_rest && !loads.active {
            return Ok(Status::AtRest);
        }
        let (old, new, load) = (&*state.now, &mut *state.next, &*loads.increment);
        let magnitude = match self.shape.structure {
            Structure::Diagonal => {
                step_diagonal(self.map.as_chunks().0.as_chunks().0, old, load, new)
            }
            Structure::Block => {
                step_dense(self.map.as_chunks().0, 3 * self.shape.r, old, load, new)
            }
        };
        if !magnitude.to_f64().is_finite() {
            return Err(StepError::NotFinite);
        }
        core::mem::swap(&mut state.now, &mut state.next);
        state.at_rest = false;
        if !loads.active && (magnitude <= self.rest_below || magnitude == T::ZERO) {
            state.rest();
            return Ok(Status::AtRest);
        }
        Ok(Status::Moving)
    }

    /// Sets displacement and velocity in reduced coordinates and computes the acceleration that goes with them under `loads`
    /// (their force at the start of a step): `ζ̈ = (BᵀF − s_K BᵀKB ζ)/s_ρ − (α + β s_K/s_ρ BᵀKB) ζ̇`.
    ///
    /// `zeta` \[m kg^½\] and `zeta_dot` \[m kg^½/s\] have length `r`.
    ///
    /// # Errors
    /// [`StepError`]; the state is then unchanged.
    pub fn set(
        &self,
        state: &mut State<'_, T>,
        zeta: &[f64],
        zeta_dot: &[f64],
        loads: &Loads<'_, T>,
    ) -> Result<(), StepError> {
        let r = self.shape.r;
        if state.shape != self.shape
            || loads.shape != self.shape
            || zeta.len() != r
            || zeta_dot.len() != r
        {
            return Err(StepError::Mismatch);
        }
        let StepParameters {
            time_step: dt,
            alpha,
            beta,
            density,
            stiffness,
        } = self.parameters;
        let spare = &mut *state.next;
        spare.fill(T::ZERO);
        let stride = self.shape.stride();
        for (k, ((&zeta_k, &rate_k), force)) in zeta
            .iter()
            .zip(zeta_dot)
            .zip(loads.force.iter())
            .enumerate()
        {
            let elastic =
                stiffness * (self.stiffness_row(k, zeta) + beta * self.stiffness_row(k, zeta_dot));
            let acceleration = (force.to_f64() - elastic) / density - alpha * rate_k;
            for (place, value) in [zeta_k, dt * rate_k, dt * dt * acceleration]
                .into_iter()
                .enumerate()
            {
                let value = T::from_f64(value);
                if !value.to_f64().is_finite() {
                    return Err(StepError::NotFinite);
                }
                spare
                    .iter_mut()
                    .skip(place * stride + k)
                    .take(1)
                    .for_each(|out| *out = value);
            }
        }
        core::mem::swap(&mut state.now, &mut state.next);
        state.at_rest = state.now.iter().all(|&value| value == T::ZERO);
        Ok(())
    }

    /// `Σ_j (BᵀKB)_kj x_j`.
    pub(crate) fn stiffness_row(&self, k: usize, x: &[f64]) -> f64 {
        let r = self.shape.r;
        match self.shape.structure {
            Structure::Diagonal => {
                self.sections.stiffness.get(k).unwrap_or_default()
                    * x.get(k).copied().unwrap_or_default()
            }
            Structure::Block => {
                let row = self.sections.stiffness.row(k * r, r);
                row.map_or(0.0, |row| row.iter().zip(x).map(|(k, x)| k * x).sum())
            }
        }
    }

    /// The load map of a stage.
    pub(crate) fn load_map(&self, stage: usize) -> &[T] {
        let length = self.shape.load_map_len();
        self.load_maps
            .get(stage * length..(stage + 1) * length)
            .unwrap_or_default()
    }
}
