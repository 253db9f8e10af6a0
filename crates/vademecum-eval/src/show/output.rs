//! Reading a state: probes, nodes, the surface, the whole body, energy. Each costs what it reads and nothing
//! else.

use crate::base::error::OutputError;
use crate::base::scalar::Scalar;
use crate::scene::equation::Energy;
use crate::scene::scene::Scene;
use crate::scene::state::State;
use crate::sections::place::Place;
use crate::sections::rows::{Factors, Field, factors};

impl<T: Scalar> Scene<'_, T> {
    /// Value of probe `index`. `O(r)`.
    ///
    /// ```
    /// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/bound.rs"));
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// # bound!(BODY, Auto: file, sizes, scene, state, loads, work);
    /// # loads.add_pattern(&scene, 0, 1.0)?;
    /// # scene.step(&mut state, &loads)?;
    /// let [displacement, velocity] = [Field::Displacement, Field::Velocity].map(|field| scene.probe(&state, 0, field));
    /// assert!(displacement? != 0.0 && velocity? != 0.0); // one step after a load came on
    /// assert_eq!(scene.probe(&state, 3, Field::Velocity), Err(OutputError::OutOfRange { index: 3, count: 3 }));
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// [`OutputError`].
    pub fn probe(&self, state: &State<'_, T>, index: usize, field: Field) -> Result<f64, OutputError> {
        let moving = self.sections.rows.probe(index, self.factors(state, field)?)?;
        if !shows_statics(state, field) {
            return Ok(moving);
        }
        Ok(moving + self.sections.residual.probe(index, state.shown()) / self.parameters.stiffness)
    }

    /// Displacement or velocity of `node` (file order), three components. `O(r)`.
    ///
    /// ```
    /// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/bound.rs"));
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// # bound!(BODY, Auto: file, sizes, scene, state, loads, work);
    /// # loads.add_pattern(&scene, 0, 1.0)?;
    /// # scene.step(&mut state, &loads)?;
    /// // The surface holds the first nodes of the file, three numbers each.
    /// let mut surface = vec![0.0; 3 * file.metadata().n_surface_nodes as usize];
    /// scene.surface_into(&state, Field::Displacement, &mut surface)?;
    /// let node = scene.node(&state, 5, Field::Displacement)?;
    /// for component in 0..3 {
    ///     assert!((node[component] - surface[3 * 5 + component]).abs() < 1e-15);
    /// }
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// [`OutputError`].
    pub fn node(&self, state: &State<'_, T>, node: usize, field: Field) -> Result<[f64; 3], OutputError> {
        let mut value = self.sections.rows.node(node, self.factors(state, field)?)?;
        self.add_static(state, field, node, 1.0, &mut value);
        Ok(value)
    }

    /// Displacement or velocity of a place, such as a [`SurfacePoint`](crate::SurfacePoint).
    /// `O(r)`.
    ///
    /// ```
    /// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/bound.rs"));
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// # bound!(BODY, Auto: file, sizes, scene, state, loads, work);
    /// # loads.add_pattern(&scene, 0, 1.0)?;
    /// # scene.step(&mut state, &loads)?;
    /// // Half way between two nodes, the mean of both.
    /// let middle = Place::new(&[0, 1], &[0.5, 0.5])?;
    /// let there = scene.point(&state, &middle, Field::Displacement)?;
    /// let [a, b] = [scene.node(&state, 0, Field::Displacement)?, scene.node(&state, 1, Field::Displacement)?];
    /// for component in 0..3 {
    ///     assert_eq!(there[component], 0.5 * a[component] + 0.5 * b[component]);
    /// }
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// [`OutputError`].
    pub fn point(
        &self,
        state: &State<'_, T>,
        at: &impl AsRef<Place>,
        field: Field,
    ) -> Result<[f64; 3], OutputError> {
        let place = at.as_ref();
        let mut value = self.sections.rows.point(place, self.factors(state, field)?)?;
        for (node, weight) in place.entries() {
            self.add_static(state, field, node as usize, weight, &mut value);
        }
        Ok(value)
    }

    /// The surface, `out` of shape `(n_surface_nodes, 3)`. Bound by reading the basis once.
    ///
    /// ```
    /// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/bound.rs"));
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// # bound!(BODY, Auto: file, sizes, scene, state, loads, work);
    /// # loads.add_pattern(&scene, 0, 1.0)?;
    /// # scene.step(&mut state, &loads)?;
    /// let mut moved = vec![0.0; 3 * file.metadata().n_surface_nodes as usize]; // a vertex array
    /// scene.surface_into(&state, Field::Displacement, &mut moved)?;
    /// assert!(moved.iter().any(|&x| x != 0.0));
    /// let wrong = scene.surface_into(&state, Field::Displacement, &mut moved[1..]);
    /// assert_eq!(wrong, Err(OutputError::Length { found: 26, needed: 27 }));
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// [`OutputError`].
    pub fn surface_into(&self, state: &State<'_, T>, field: Field, out: &mut [T]) -> Result<(), OutputError> {
        self.sections.rows.surface_into(self.factors(state, field)?, out)?;
        self.add_static_field(state, field, out);
        Ok(())
    }

    /// The whole body, `out` of shape `(n_nodes, 3)`. Bound by reading the basis once.
    ///
    /// # Errors
    /// [`OutputError`].
    pub fn body_into(&self, state: &State<'_, T>, field: Field, out: &mut [T]) -> Result<(), OutputError> {
        self.sections.rows.body_into(self.factors(state, field)?, out)?;
        self.add_static_field(state, field, out);
        Ok(())
    }

    /// Kinetic plus elastic energy \[J\]: `½ s_ρ ζ̇ᵀ M_r ζ̇ + ½ s_K ζᵀ K_r ζ`, with the scales of the regions
    /// in `M_r = Σ ρ_q BᵀM_qB` and `K_r = Σ κ_q BᵀK_qB`. `O(r)`, or `O(r²)` times the regions that count.
    /// With the strain structure the energy that its scheme keeps, for about the cost of a step.
    ///
    /// ```
    /// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/bound.rs"));
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// # bound!(BODY, Auto: file, sizes, scene, state, loads, work);
    /// # loads.add_pattern(&scene, 0, 1.0)?;
    /// # scene.step(&mut state, &loads)?;
    /// assert!(scene.energy(&state)? > 0.0);
    /// state.rest();
    /// assert_eq!(scene.energy(&state)?, 0.0);
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// [`OutputError::Mismatch`].
    pub fn energy(&self, state: &State<'_, T>) -> Result<f64, OutputError> {
        Ok(self.energy_of_modes(state)?.total() + self.residual_energy(state))
    }

    /// Kinetic energy \[J\]: the first part of [`Scene::energy`].
    ///
    /// # Errors
    /// [`OutputError::Mismatch`].
    pub fn kinetic_energy(&self, state: &State<'_, T>) -> Result<f64, OutputError> {
        Ok(self.energy_of_modes(state)?.kinetic)
    }

    /// Strain energy \[J\], with that of the residual flexibility: the rest of [`Scene::energy`].
    ///
    /// # Errors
    /// [`OutputError::Mismatch`].
    pub fn strain_energy(&self, state: &State<'_, T>) -> Result<f64, OutputError> {
        Ok(self.energy_of_modes(state)?.elastic + self.residual_energy(state))
    }

    /// Derivatives of the kinetic and of the strain energy at `state` along `direction`, a state of the same
    /// scene: the answer to a change of the loads, for one \[J\]. The other outputs of the linear structures
    /// are linear in the state, so that their derivative is their value at `direction`. `O(r)`, or `O(r²)`
    /// for dense matrices.
    ///
    /// # Errors
    /// [`OutputError::Mismatch`]; [`OutputError::NotWithStrain`].
    pub fn energies_along(
        &self,
        state: &State<'_, T>,
        direction: &State<'_, T>,
    ) -> Result<[f64; 2], OutputError> {
        self.check(state)?;
        self.check(direction)?;
        if self.shape.is_strain() {
            return Err(OutputError::NotWithStrain);
        }
        let modes = self.equation().energy_along(&state.y, &direction.y).ok_or(OutputError::Mismatch)?;
        let residual = self.sections.residual.energy_along(state.shown(), direction.shown());
        Ok([modes.kinetic, modes.elastic + residual / self.parameters.stiffness])
    }

    pub(crate) fn energy_of_modes(&self, state: &State<'_, T>) -> Result<Energy, OutputError> {
        self.check(state)?;
        if self.shape.is_strain() {
            // It goes with the fourth power of the motion, which is bounded for squares.
            let energy = self.kept_energy(state)?;
            return if energy.total().is_finite() { Ok(energy) } else { Err(OutputError::NotFinite) };
        }
        self.equation().energy(&state.y).ok_or(OutputError::Mismatch)
    }

    /// Strain energy of the forces of the last step in the residual flexibility.
    fn residual_energy(&self, state: &State<'_, T>) -> f64 {
        if state.shown().is_empty() {
            return 0.0;
        }
        self.sections.residual.energy(state.shown()) / self.parameters.stiffness
    }

    /// Adds to `value` what the modes leave out of the displacement of a node.
    fn add_static(&self, state: &State<'_, T>, field: Field, node: usize, weight: f64, value: &mut [f64; 3]) {
        if shows_statics(state, field) {
            let rest = self.sections.residual.node(node, state.shown());
            let scale = weight / self.parameters.stiffness;
            value.iter_mut().zip(rest).for_each(|(value, rest)| *value += scale * rest);
        }
    }

    /// The same for the nodes around contacts of a whole field; the loadable nodes are its first.
    fn add_static_field(&self, state: &State<'_, T>, field: Field, out: &mut [T]) {
        if shows_statics(state, field) {
            let scale = 1.0 / self.parameters.stiffness;
            self.sections.residual.add_to_surface(state.shown(), scale, out);
        }
    }

    fn factors<'s>(&self, state: &'s State<'_, T>, field: Field) -> Result<Factors<'s, T>, OutputError> {
        self.check(state)?;
        Ok(factors(&state.y, field))
    }

    pub(crate) fn check(&self, state: &State<'_, T>) -> Result<(), OutputError> {
        if state.shape == self.shape { Ok(()) } else { Err(OutputError::Mismatch) }
    }
}

/// The residual is static: it has no velocity.
fn shows_statics<T: Scalar>(state: &State<'_, T>, field: Field) -> bool {
    field == Field::Displacement && !state.shown().is_empty()
}
