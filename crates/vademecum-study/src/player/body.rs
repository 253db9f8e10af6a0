//! What playing a scenario asks of a body.

use vademecum_build::dynamics::INSTANTS;
use vademecum_eval::chapter::{ChapterLoads, ChapterScene, ChapterState};
use vademecum_eval::{
    Contact, Field, Loads, OutputError, RigidBody, RigidMotion, Scalar, Scene, State, StaticField, Structure,
    SurfacePoint, Tensor,
};
use vademecum_format::SectionKind;

use crate::error::FileError;

/// Name of a structure on the command line and in reports.
pub(crate) fn structure_name(structure: Structure) -> &'static str {
    match structure {
        Structure::Diagonal => "diagonal",
        Structure::Block => "block",
        Structure::Exact => "exact",
        Structure::Strain => "strain",
    }
}

/// A scene with a state and loads.
pub struct Body<Scene, State, Loads> {
    /// The bound file.
    pub scene: Scene,
    /// Where the body is.
    pub state: State,
    /// What acts on it.
    pub loads: Loads,
}

/// What takes loads.
pub trait Loadable {
    /// Takes all loads away.
    fn clear_loads(&mut self);
    /// Adds a contact with its amplitudes at the instants.
    ///
    /// # Errors
    /// A contact that the evaluator refuses.
    fn add_contact(&mut self, contact: &Contact, amplitudes: &[f64; INSTANTS]) -> Result<(), FileError>;
    /// Adds a load pattern with its amplitudes at the instants.
    ///
    /// # Errors
    /// A pattern that the evaluator refuses.
    fn add_pattern(&mut self, index: usize, amplitudes: &[f64; INSTANTS]) -> Result<(), FileError>;
}

/// What playing a scenario asks of a body, whatever its scene.
pub trait Playable: Loadable {
    /// Precision of the march.
    type Number: Scalar;

    /// Name of the structure on the command line and in reports.
    fn structure(&self) -> &'static str;
    /// `Δt` \[s\].
    fn time_step(&self) -> f64;
    /// Instants of a step at which a load is asked for, as fractions of the step.
    fn instants(&self) -> [f64; INSTANTS];
    /// Puts the body where it is undeformed and does not move yet; its acceleration follows from the loads.
    ///
    /// # Errors
    /// As [`Playable::step`].
    fn start(&mut self) -> Result<(), FileError>;
    /// Whether a step takes a load as linear from its start to its end, and any step can be taken in pieces.
    fn is_exact(&self) -> bool;
    /// Whether a step takes a load as linear from its start to its end, and cannot be taken in pieces.
    fn takes_ends(&self) -> bool {
        false
    }
    /// Takes `parts` parts of a step of this length, each under the loads that `apply` adds for it.
    ///
    /// # Errors
    /// A load or a step that the evaluator refuses.
    fn step_parts(
        &mut self,
        length: f64,
        parts: usize,
        apply: &dyn Fn(usize, &mut dyn Loadable) -> Result<(), FileError>,
    ) -> Result<(), FileError>;
    /// One step.
    ///
    /// # Errors
    /// A step that the evaluator refuses.
    fn step(&mut self) -> Result<(), FileError>;
    /// Reduced coordinates.
    fn zeta(&self) -> &[Self::Number];
    /// Energy \[J\].
    ///
    /// # Errors
    /// A file that cannot tell it.
    fn energy(&self) -> Result<f64, FileError>;
    /// Displacement of a probe \[m\].
    ///
    /// # Errors
    /// A file without this probe.
    fn probe(&self, index: usize) -> Result<f64, FileError>;
    /// Stress at one of the points of the file \[Pa\].
    ///
    /// # Errors
    /// A file without this point.
    fn stress(&self, point: usize) -> Result<Tensor, FileError>;
    /// Force and moment that a support exerts on the body \[N, N m\].
    ///
    /// # Errors
    /// A file without reactions.
    fn reaction(&self, support: usize) -> Result<[f64; 6], FileError>;
    /// Displacement of a node of the file \[m\].
    ///
    /// # Errors
    /// A file that does not show the node.
    fn node(&self, node: usize) -> Result<[f64; 3], FileError>;
    /// Displacement of a point of the surface \[m\].
    ///
    /// # Errors
    /// A file without its surface.
    fn point(&self, point: &SurfacePoint) -> Result<[f64; 3], FileError>;
    /// A field of the surface, shape (n_surface_nodes, 3).
    ///
    /// # Errors
    /// A file without its surface.
    fn surface_into(&self, field: Field, out: &mut [Self::Number]) -> Result<(), FileError>;
    /// A field of the whole body, shape (n_nodes, 3).
    ///
    /// # Errors
    /// A file without all of its nodes.
    fn body_into(&self, field: Field, out: &mut [Self::Number]) -> Result<(), FileError>;
    /// The rigid motion of a free body that was thrown; none of any other.
    fn flight(&self) -> Option<(&RigidBody, &RigidMotion)> {
        None
    }
}

/// What both kinds of scene do by methods of the same names.
macro_rules! alike {
    () => {
        type Number = T;

        fn time_step(&self) -> f64 {
            self.scene.parameters().time_step
        }

        fn instants(&self) -> [f64; INSTANTS] {
            self.scene.instants()
        }

        fn start(&mut self) -> Result<(), FileError> {
            let zero = vec![0.0; self.scene.n_modes()];
            Ok(self.scene.set(self.state, &zero, &zero, self.loads)?)
        }

        #[inline]
        fn step(&mut self) -> Result<(), FileError> {
            self.scene.step(self.state, self.loads)?;
            Ok(())
        }

        fn zeta(&self) -> &[T] {
            self.state.zeta()
        }

        fn energy(&self) -> Result<f64, FileError> {
            Ok(self.scene.energy(self.state)?)
        }

        fn probe(&self, index: usize) -> Result<f64, FileError> {
            Ok(self.scene.probe(self.state, index, Field::Displacement)?)
        }

        fn node(&self, node: usize) -> Result<[f64; 3], FileError> {
            Ok(self.scene.node(self.state, node, Field::Displacement)?)
        }

        fn point(&self, point: &SurfacePoint) -> Result<[f64; 3], FileError> {
            Ok(self.scene.point(self.state, point, Field::Displacement)?)
        }
    };
}

/// What both kinds of loads do by methods of the same names.
macro_rules! loads_alike {
    () => {
        fn clear_loads(&mut self) {
            self.loads.clear();
        }

        fn add_contact(&mut self, contact: &Contact, amplitudes: &[f64; INSTANTS]) -> Result<(), FileError> {
            Ok(self.loads.add_contact_staged(self.scene, contact, amplitudes)?)
        }
    };
}

impl<T: Scalar> Playable for Body<&Scene<'_, T>, &mut State<'_, T>, &mut Loads<'_, T>> {
    alike!();

    fn structure(&self) -> &'static str {
        structure_name(self.scene.structure())
    }

    fn stress(&self, point: usize) -> Result<Tensor, FileError> {
        Ok(self.scene.stress(self.state, point)?)
    }

    fn surface_into(&self, field: Field, out: &mut [T]) -> Result<(), FileError> {
        if !self.shows_statics(field) {
            return Ok(self.scene.surface_into(self.state, field, out)?);
        }
        self.with_statics(|statics| self.scene.surface_with(self.state, field, statics, out))
    }

    fn body_into(&self, field: Field, out: &mut [T]) -> Result<(), FileError> {
        if !self.shows_statics(field) {
            return Ok(self.scene.body_into(self.state, field, out)?);
        }
        self.with_statics(|statics| self.scene.body_with(self.state, field, statics, out))
    }

    fn reaction(&self, support: usize) -> Result<[f64; 6], FileError> {
        Ok(self.scene.reaction(self.state, support)?.total())
    }

    fn is_exact(&self) -> bool {
        self.scene.structure() == Structure::Exact
    }

    fn takes_ends(&self) -> bool {
        self.scene.structure() == Structure::Strain
    }

    fn step_parts(
        &mut self,
        length: f64,
        parts: usize,
        apply: &dyn Fn(usize, &mut dyn Loadable) -> Result<(), FileError>,
    ) -> Result<(), FileError> {
        // A scene of their own for the parts: binding modes is cheap, and the body's scene stays as it is.
        let sizes = self.scene.own_sizes();
        let (mut memory, mut work) = (vec![T::ZERO; sizes.scene], vec![0.0; sizes.work]);
        let mut load_memory = vec![T::ZERO; sizes.loads];
        let part = self.scene.with_time_step(length, &mut memory, &mut work)?;
        let mut loads = Loads::new(&part, &mut load_memory)?;
        self.state.carry(&part)?;
        for number in 0..parts {
            apply(number, &mut Body { scene: &part, state: &mut *self.state, loads: &mut loads })?;
            part.step(self.state, &loads)?;
        }
        Ok(self.state.carry(self.scene)?)
    }
}

impl<T: Scalar> Body<&Scene<'_, T>, &mut State<'_, T>, &mut Loads<'_, T>> {
    /// Whether a field of the file has the whole static answer.
    fn shows_statics(&self, field: Field) -> bool {
        field == Field::Displacement && self.scene.static_field_sizes() != [0; 2]
    }

    /// The static answer to the forces of the last step.
    fn with_statics(
        &self,
        show: impl FnOnce(&mut StaticField<'_, T>) -> Result<(), OutputError>,
    ) -> Result<(), FileError> {
        let [answer, rest] = self.scene.static_field_sizes();
        let (mut answer, mut rest) = (vec![0.0; answer], vec![T::ZERO; rest]);
        let mut statics = StaticField::new(self.scene, &mut answer, &mut rest)?;
        self.scene.solve_static_field(self.state, &mut statics)?;
        Ok(show(&mut statics)?)
    }
}

impl<T: Scalar> Loadable for Body<&Scene<'_, T>, &mut State<'_, T>, &mut Loads<'_, T>> {
    loads_alike!();

    fn add_pattern(&mut self, index: usize, amplitudes: &[f64; INSTANTS]) -> Result<(), FileError> {
        Ok(self.loads.add_pattern_staged(self.scene, index, amplitudes)?)
    }
}

impl<T: Scalar> Playable for Body<&ChapterScene<'_, T>, &mut ChapterState<'_, T>, &mut ChapterLoads<'_, T>> {
    alike!();

    fn structure(&self) -> &'static str {
        "canonical"
    }

    fn stress(&self, _: usize) -> Result<Tensor, FileError> {
        Err(FileError::Missing { kind: SectionKind::StressBasis })
    }

    fn surface_into(&self, field: Field, out: &mut [T]) -> Result<(), FileError> {
        Ok(self.scene.surface_into(self.state, field, out)?)
    }

    fn body_into(&self, field: Field, out: &mut [T]) -> Result<(), FileError> {
        Ok(self.scene.body_into(self.state, field, out)?)
    }

    fn reaction(&self, _: usize) -> Result<[f64; 6], FileError> {
        Err(FileError::Missing { kind: SectionKind::ReactionBasis })
    }

    fn is_exact(&self) -> bool {
        false
    }

    fn step_parts(
        &mut self,
        _: f64,
        _: usize,
        _: &dyn Fn(usize, &mut dyn Loadable) -> Result<(), FileError>,
    ) -> Result<(), FileError> {
        self.step()
    }
}

impl<T: Scalar> Loadable for Body<&ChapterScene<'_, T>, &mut ChapterState<'_, T>, &mut ChapterLoads<'_, T>> {
    loads_alike!();

    fn add_pattern(&mut self, _: usize, _: &[f64; INSTANTS]) -> Result<(), FileError> {
        Err(FileError::NoPatterns)
    }
}
