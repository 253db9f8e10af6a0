//! Cotangents of outputs after a step: by how much a scalar of the whole march changes with each of them.

use crate::adjoint::error::AdjointError;
use crate::adjoint::shown::Shown;
use crate::base::error::OutputError;
use crate::base::lend::Lender;
use crate::base::options::Structure;
use crate::base::scalar::Scalar;
use crate::kernels::kernel::add_row;
use crate::scene::loads::check_range;
use crate::scene::scene::Scene;
use crate::scene::shape::Shape;
use crate::sections::contact::Contact;
use crate::sections::place::Place;
use crate::sections::rows::Field;
use vademecum_format::scheme::StepParameters;
use vademecum_format::{MAX_REGIONS, Numbers};

/// Cotangents `∂J/∂o` of the outputs `o` after a step, in lent memory: what is added stays until it is
/// cleared. Each unit is that of the scalar `J` over that of the output.
#[derive(Debug)]
pub struct Cotangents<'m, T> {
    pub(crate) shape: Shape,
    /// Of the state `(ζ, Δt ζ̇)`, laid out like one.
    pub(crate) state: &'m mut [T],
    /// Of what outputs show of the forces at the end of the step.
    pub(crate) shown: Shown<'m, T>,
    /// Of these forces along the modes, which accelerations follow at once; `r` numbers.
    pub(crate) force: &'m mut [T],
    /// Of the scene: velocities, stress and reactions are read by its parameters.
    generation: u64,
    parameters: StepParameters,
}

/// Refuses a scene that does not take exact steps.
pub(crate) fn check_exact<T: Scalar>(scene: &Scene<'_, T>) -> Result<(), AdjointError> {
    match scene.structure() {
        Structure::Exact => Ok(()),
        found => Err(AdjointError::Structure { found }),
    }
}

impl<'m, T: Scalar> Cotangents<'m, T> {
    /// Numbers of `T` to lend.
    ///
    /// # Errors
    /// [`AdjointError::Structure`].
    pub fn len_for(scene: &Scene<'_, T>) -> Result<usize, AdjointError> {
        check_exact(scene)?;
        Ok(scene.shape.padded() + Shown::len(scene, scene.shape.statics[0]) + scene.shape.r)
    }

    /// None. `memory` holds at least [`Cotangents::len_for`] numbers; what is in it does not matter.
    ///
    /// # Errors
    /// [`AdjointError::Structure`], [`AdjointError::Bind`].
    pub fn new(scene: &Scene<'_, T>, memory: &'m mut [T]) -> Result<Self, AdjointError> {
        check_exact(scene)?;
        let mut memory = Lender::new(memory);
        let state = memory.take(scene.shape.padded())?;
        state.fill(T::ZERO);
        let shown = Shown::new(scene, scene.shape.statics[0], &mut memory)?;
        let force = memory.take(scene.shape.r)?;
        force.fill(T::ZERO);
        let (generation, parameters) = (scene.generation, scene.parameters);
        Ok(Self { shape: scene.shape, state, shown, force, generation, parameters })
    }

    /// Takes all of them away.
    pub fn clear(&mut self) {
        self.state.fill(T::ZERO);
        self.shown.clear();
        self.force.fill(T::ZERO);
    }

    fn check(&self, scene: &Scene<'_, T>, own: &[f64]) -> Result<(), AdjointError> {
        self.check_scene(scene)?;
        check_range::<T>(own.iter()).map_err(|_| AdjointError::NotFinite)
    }

    /// Part of the state that a field reads, and the factor on it.
    fn part(&mut self, field: Field) -> (&mut [T], f64) {
        let (stride, r) = (self.shape.stride(), self.shape.r);
        let (first, scale) = match field {
            Field::Displacement => (0, 1.0),
            Field::Velocity => (stride, 1.0 / self.parameters.time_step),
        };
        (self.state.get_mut(first..first + r).unwrap_or_default(), scale)
    }

    fn add(&mut self, row: Numbers<'_>, field: Field, own: f64) {
        let (part, scale) = self.part(field);
        add_row(row, T::from_f64(scale * own), part);
    }

    /// Adds cotangents of the reduced coordinates `ζ` and of their rates `ζ̇`, `r` numbers each: with them
    /// any scalar of the state has its gradient, such as an energy.
    ///
    /// # Errors
    /// [`AdjointError::Length`], [`AdjointError::NotFinite`], [`AdjointError::Mismatch`].
    pub fn add_coordinates(
        &mut self,
        scene: &Scene<'_, T>,
        zeta: &[f64],
        zeta_dot: &[f64],
    ) -> Result<(), AdjointError> {
        for (field, own) in [(Field::Displacement, zeta), (Field::Velocity, zeta_dot)] {
            let (found, needed) = (own.len(), self.shape.r);
            if found != needed {
                return Err(AdjointError::Length { found, needed });
            }
            self.check(scene, own)?;
            let (part, scale) = self.part(field);
            part.iter_mut().zip(own).for_each(|(sum, x)| *sum += T::from_f64(scale * x));
        }
        Ok(())
    }

    /// Adds that of a probe, as [`Scene::probe`] reads it. `O(r)`.
    ///
    /// # Errors
    /// [`AdjointError`].
    pub fn add_probe(
        &mut self,
        scene: &Scene<'_, T>,
        probe: usize,
        field: Field,
        own: f64,
    ) -> Result<(), AdjointError> {
        self.check(scene, &[own])?;
        self.add(scene.sections.rows.probe_row(probe)?, field, own);
        if let Some(sum) = self.shown.probes.get_mut(probe).filter(|_| field == Field::Displacement) {
            *sum += T::from_f64(own);
        }
        Ok(())
    }

    /// Adds those of the three components at a place, as [`Scene::point`] reads them; with
    /// [`Place::node`] as [`Scene::node`] does. `O(r)`.
    ///
    /// # Errors
    /// [`AdjointError`]; nothing is added then.
    pub fn add_point(
        &mut self,
        scene: &Scene<'_, T>,
        at: &impl AsRef<Place>,
        field: Field,
        own: [f64; 3],
    ) -> Result<(), AdjointError> {
        self.check(scene, &own)?;
        let (place, rows) = (*at.as_ref(), &scene.sections.rows);
        place.check().map_err(OutputError::from)?;
        for (node, _) in place.entries() {
            rows.node_row(node as usize, 0)?;
        }
        let shows = field == Field::Displacement && scene.shape.statics[0] > 0;
        let contact = Contact::new(place, own);
        if shows && self.shown.nodes.check(&contact, 1).is_err() {
            return Err(AdjointError::TooManyNodes { nodes: scene.shape.statics[0] });
        }
        for (node, weight) in place.entries() {
            for (component, own) in own.into_iter().enumerate() {
                self.add(rows.node_row(node as usize, component)?, field, weight * own);
            }
        }
        if shows {
            self.shown.nodes.add_contact(&contact, 1.0);
        }
        Ok(())
    }

    /// Adds those of the six components of a stress, as [`Scene::stress`] reads it. `O(r)`.
    ///
    /// # Errors
    /// [`AdjointError`].
    pub fn add_stress(
        &mut self,
        scene: &Scene<'_, T>,
        point: usize,
        own: [f64; 6],
    ) -> Result<(), AdjointError> {
        self.check(scene, &own)?;
        let stress = &scene.sections.stress;
        let region = stress.point(point).map_or(MAX_REGIONS, |point| point.region as usize);
        let scale =
            scene.parameters.stiffness * scene.options.regions.stiffness().get(region).unwrap_or(&1.0);
        for (component, own) in own.into_iter().enumerate() {
            self.add(stress.row(point, component)?, Field::Displacement, scale * own);
        }
        let place = self.shown.stress.as_chunks_mut::<6>().0.get_mut(point);
        for (sum, own) in place.into_iter().flatten().zip(own) {
            *sum += T::from_f64(own);
        }
        Ok(())
    }

    /// Adds those of the force and the moment that a support exerts, as [`Reaction::total`] of
    /// [`Scene::reaction`]. `O(r)` for each row of dashpots.
    ///
    /// [`Reaction::total`]: crate::Reaction::total
    ///
    /// # Errors
    /// [`AdjointError`].
    pub fn add_reaction(
        &mut self,
        scene: &Scene<'_, T>,
        support: usize,
        own: [f64; 6],
    ) -> Result<(), AdjointError> {
        self.check(scene, &own)?;
        let (stride, r) = (self.shape.stride(), self.shape.r);
        scene.check_reaction(support)?;
        let (displacement, rates) = self.state.split_at_mut_checked(stride).ok_or(AdjointError::Mismatch)?;
        let share = |mode: usize| scene.reaction_share(support, mode, &own);
        for (mode, ((of_zeta, of_rate), of_force)) in
            displacement.iter_mut().zip(&mut *rates).zip(&mut *self.force).enumerate().take(r)
        {
            // The acceleration is f/ρ − decay ζ̇ − λ ζ, and the drag of the mass α ζ̇.
            let [lambda, decay] = scene.mode_equation(mode);
            let scale = share(mode) * scene.parameters.density;
            let drag = (scene.parameters.alpha - decay) / self.parameters.time_step;
            *of_zeta += T::from_f64(-scale * lambda);
            *of_rate += T::from_f64(scale * drag);
            *of_force += T::from_f64(share(mode));
        }
        for row in scene.sections.damping_rows.unwrap_or(&[]).chunks_exact(r.max(1)) {
            let along: f64 = row.iter().enumerate().map(|(k, &d)| f64::from_le_bytes(d) * share(k)).sum();
            for (of_rate, &d) in rates.iter_mut().zip(row) {
                *of_rate += T::from_f64(-along * f64::from_le_bytes(d) / self.parameters.time_step);
            }
        }
        let place = self.shown.reactions.as_chunks_mut::<6>().0.get_mut(support);
        place.into_iter().flatten().zip(own).for_each(|(sum, own)| *sum += T::from_f64(own));
        Ok(())
    }

    /// Refuses another scene, and other parameters of the same.
    pub(crate) fn check_scene(&self, scene: &Scene<'_, T>) -> Result<(), AdjointError> {
        if self.shape != scene.shape {
            return Err(AdjointError::Mismatch);
        }
        let same = self.generation == scene.generation && self.parameters == scene.parameters;
        if same { Ok(()) } else { Err(AdjointError::Stale) }
    }
}
