//! The two kinds of scene a scenario is played on, alike.

use std::error::Error;

use vademecum_eval::chapter::{ChapterLoads, ChapterScene, ChapterState};
use vademecum_eval::{Contact, Field, Loads, Scalar, Scene, State, Structure};

/// Why a scene refused.
pub type Refusal = Box<dyn Error>;

/// A scene with a state and loads.
pub struct Body<Scene, State, Loads> {
    /// The bound file.
    pub scene: Scene,
    /// Where the body is.
    pub state: State,
    /// What acts on it.
    pub loads: Loads,
}

/// What playing a scenario asks of a body, whatever its scene.
pub trait Playable {
    /// Precision of the march.
    type Number: Scalar;

    /// Name of the structure on the command line and in reports.
    fn structure(&self) -> &'static str;
    /// `Δt` \[s\].
    fn time_step(&self) -> f64;
    /// Instants of a step at which a load is asked for, as fractions of the step.
    fn instants(&self) -> [f64; 4];
    /// Takes all loads away.
    fn clear_loads(&mut self);
    /// Adds a contact with its amplitudes at the instants.
    fn add_contact(&mut self, contact: &Contact, amplitudes: &[f64; 4]) -> Result<(), Refusal>;
    /// Adds a load pattern with its amplitudes at the instants.
    fn add_pattern(&mut self, index: usize, amplitudes: &[f64; 4]) -> Result<(), Refusal>;
    /// Puts the body where it is undeformed and does not move yet; its acceleration follows from the loads.
    fn start(&mut self) -> Result<(), Refusal>;
    /// One step.
    fn step(&mut self) -> Result<(), Refusal>;
    /// Reduced coordinates.
    fn zeta(&self) -> &[Self::Number];
    /// Energy \[J\].
    fn energy(&self) -> Result<f64, Refusal>;
    /// Displacement of a probe \[m\].
    fn probe(&self, index: usize) -> Result<f64, Refusal>;
    /// A field of the surface, shape (n_surface_nodes, 3).
    fn surface_into(&self, field: Field, out: &mut [Self::Number]) -> Result<(), Refusal>;
    /// A field of the whole body, shape (n_nodes, 3).
    fn body_into(&self, field: Field, out: &mut [Self::Number]) -> Result<(), Refusal>;
}

/// What both kinds of scene do by methods of the same names.
macro_rules! alike {
    () => {
        type Number = T;

        fn time_step(&self) -> f64 {
            self.scene.parameters().time_step
        }

        fn instants(&self) -> [f64; 4] {
            self.scene.instants()
        }

        fn clear_loads(&mut self) {
            self.loads.clear();
        }

        fn add_contact(&mut self, contact: &Contact, amplitudes: &[f64; 4]) -> Result<(), Refusal> {
            Ok(self.loads.add_contact_staged(self.scene, contact, amplitudes)?)
        }

        fn start(&mut self) -> Result<(), Refusal> {
            let zero = vec![0.0; self.scene.n_modes()];
            Ok(self.scene.set(self.state, &zero, &zero, self.loads)?)
        }

        #[inline]
        fn step(&mut self) -> Result<(), Refusal> {
            self.scene.step(self.state, self.loads)?;
            Ok(())
        }

        fn zeta(&self) -> &[T] {
            self.state.zeta()
        }

        fn energy(&self) -> Result<f64, Refusal> {
            Ok(self.scene.energy(self.state)?)
        }

        fn probe(&self, index: usize) -> Result<f64, Refusal> {
            Ok(self.scene.probe(self.state, index, Field::Displacement)?)
        }

        fn surface_into(&self, field: Field, out: &mut [T]) -> Result<(), Refusal> {
            Ok(self.scene.surface_into(self.state, field, out)?)
        }

        fn body_into(&self, field: Field, out: &mut [T]) -> Result<(), Refusal> {
            Ok(self.scene.body_into(self.state, field, out)?)
        }
    };
}

impl<T: Scalar> Playable for Body<&Scene<'_, T>, &mut State<'_, T>, &mut Loads<'_, T>> {
    alike!();

    fn structure(&self) -> &'static str {
        match self.scene.structure() {
            Structure::Diagonal => "diagonal",
            Structure::Block => "block",
        }
    }

    fn add_pattern(&mut self, index: usize, amplitudes: &[f64; 4]) -> Result<(), Refusal> {
        Ok(self.loads.add_pattern_staged(self.scene, index, amplitudes)?)
    }
}

impl<T: Scalar> Playable for Body<&ChapterScene<'_, T>, &mut ChapterState<'_, T>, &mut ChapterLoads<'_, T>> {
    alike!();

    fn structure(&self) -> &'static str {
        "canonical"
    }

    fn add_pattern(&mut self, _: usize, _: &[f64; 4]) -> Result<(), Refusal> {
        Err("the canonical structure has no axis for load patterns".into())
    }
}
