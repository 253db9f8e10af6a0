//! What playing a scenario asks of a body.

use vademecum_build::dynamics::INSTANTS;
use vademecum_eval::{
    Body, Contact, Field, FreeBody, Quantity, Scalar, SceneOptions, Structure, SurfacePoint, Tensor, Training,
};
use vademecum_format::SectionKind;

use crate::error::FileError;

/// Name of a structure on the command line and in reports.
pub fn structure_name(structure: Structure) -> &'static str {
    match structure {
        Structure::Diagonal => "diagonal",
        Structure::Block => "block",
        Structure::Exact => "exact",
        Structure::Strain => "strain",
    }
}

/// What playing a scenario asks of a body: the evaluator's [`Body`], or the chapter's. What only the first
/// can do has a default.
pub trait Playable {
    /// Precision of the march.
    type Number: Scalar;

    /// Name of the structure on the command line and in reports.
    fn structure(&self) -> &'static str;
    /// `Δt` \[s\].
    fn time_step(&self) -> f64;
    /// Instants of a step at which a load is asked for, as fractions of the step.
    fn instants(&self) -> [f64; INSTANTS];
    /// Whether a step takes a load as linear from its start to its end, and any step can be taken in pieces.
    fn is_exact(&self) -> bool {
        false
    }
    /// Whether a step takes a load as linear from its start to its end, and cannot be taken in pieces.
    fn takes_ends(&self) -> bool {
        false
    }
    /// The rigid motion of a free body that was thrown; none of any other.
    fn flight(&self) -> Option<&FreeBody> {
        None
    }
    /// Takes all loads away.
    fn clear(&mut self);
    /// Pulls a body that flies with this acceleration of gravity \[m/s²\] in the coming step.
    ///
    /// # Errors
    /// A load that the evaluator refuses.
    fn pull(&mut self, _gravity: [f64; 3]) -> Result<(), FileError> {
        Ok(())
    }
    /// Adds a contact with its amplitudes at the instants.
    ///
    /// # Errors
    /// A contact that the evaluator refuses.
    fn push(&mut self, contact: &Contact, amplitudes: &[f64; INSTANTS]) -> Result<(), FileError>;
    /// Adds a load pattern with its amplitudes at the instants.
    ///
    /// # Errors
    /// A pattern that the evaluator refuses.
    fn push_pattern(&mut self, _index: usize, _amplitudes: &[f64; INSTANTS]) -> Result<(), FileError> {
        Err(FileError::NoPatterns)
    }
    /// Puts the body where it is undeformed and does not move yet; its acceleration follows from the loads.
    ///
    /// # Errors
    /// As [`Playable::step`].
    fn start(&mut self) -> Result<(), FileError>;
    /// One step.
    ///
    /// # Errors
    /// A step that the evaluator refuses.
    fn step(&mut self) -> Result<(), FileError>;
    /// Takes `parts` parts of a step of this length, each under the loads that `apply` adds for it. The loads
    /// of the body are stale then.
    ///
    /// # Errors
    /// A load or a step that the evaluator refuses.
    fn step_parts(
        &mut self,
        _length: f64,
        _parts: usize,
        _apply: impl Fn(usize, &mut Self) -> Result<(), FileError>,
    ) -> Result<(), FileError>
    where
        Self: Sized,
    {
        self.step()
    }
    /// Reduced coordinates.
    fn zeta(&self) -> &[Self::Number];
    /// Energy \[J\].
    ///
    /// # Errors
    /// A file that cannot tell it.
    fn energy(&self) -> Result<f64, FileError>;
    /// A scalar of the whole body, one of [`Quantity::totals`].
    ///
    /// # Errors
    /// [`FileError::NoQuantities`]: the chapter's structure.
    fn total(&self, _quantity: Quantity) -> Result<f64, FileError> {
        Err(FileError::NoQuantities)
    }
    /// The state beside those of the training; none of linear motion.
    fn training(&self) -> Option<Training> {
        None
    }
    /// Displacement of a probe \[m\].
    ///
    /// # Errors
    /// A file without this probe.
    fn probe(&self, index: usize) -> Result<f64, FileError>;
    /// Stress at one of the points of the file \[Pa\].
    ///
    /// # Errors
    /// A file without this point.
    fn stress(&self, _point: usize) -> Result<Tensor, FileError> {
        Err(FileError::Missing { kind: SectionKind::StressBasis })
    }
    /// Force and moment that a support exerts on the body \[N, N m\].
    ///
    /// # Errors
    /// A file without reactions.
    fn reaction(&self, _support: usize) -> Result<[f64; 6], FileError> {
        Err(FileError::Missing { kind: SectionKind::ReactionBasis })
    }
    /// Displacement or velocity of a node of the file \[m, m/s\].
    ///
    /// # Errors
    /// A file that does not show the node.
    fn node(&self, node: usize, field: Field) -> Result<[f64; 3], FileError>;
    /// Displacement or velocity of a point of the surface \[m, m/s\].
    ///
    /// # Errors
    /// A file without its surface.
    fn point(&self, point: &SurfacePoint, field: Field) -> Result<[f64; 3], FileError>;
    /// A field of the surface, shape (n_surface_nodes, 3), with the static answer of the whole body where the
    /// body has room for it.
    ///
    /// # Errors
    /// A file without its surface.
    fn surface_into(&mut self, field: Field, out: &mut [Self::Number]) -> Result<(), FileError>;
    /// The same of the whole body, shape (n_nodes, 3).
    ///
    /// # Errors
    /// A file without all of its nodes.
    fn body_into(&mut self, field: Field, out: &mut [Self::Number]) -> Result<(), FileError>;
}

impl<T: Scalar> Playable for Body<'_, T> {
    type Number = T;

    fn structure(&self) -> &'static str {
        structure_name(self.structure())
    }

    fn time_step(&self) -> f64 {
        self.time_step()
    }

    fn instants(&self) -> [f64; INSTANTS] {
        self.instants()
    }

    // The step of a body that flies is not cut where a load jumps: the rigid motion takes it whole, under the
    // mean of each load over the step.
    fn is_exact(&self) -> bool {
        self.structure() == Structure::Exact && self.flight().is_none()
    }

    fn takes_ends(&self) -> bool {
        self.structure() == Structure::Strain && self.flight().is_none()
    }

    fn flight(&self) -> Option<&FreeBody> {
        self.flight()
    }

    fn clear(&mut self) {
        self.clear();
    }

    fn pull(&mut self, gravity: [f64; 3]) -> Result<(), FileError> {
        let Some(mass) = self.flight().map(|free| free.body().mass) else { return Ok(()) };
        Ok(self.pull(gravity.map(|g| mass * g))?)
    }

    fn push(&mut self, contact: &Contact, amplitudes: &[f64; INSTANTS]) -> Result<(), FileError> {
        Ok(self.push_staged(contact, contact.force, amplitudes)?)
    }

    fn push_pattern(&mut self, index: usize, amplitudes: &[f64; INSTANTS]) -> Result<(), FileError> {
        Ok(self.push_pattern_staged(index, amplitudes)?)
    }

    fn start(&mut self) -> Result<(), FileError> {
        let zero = vec![0.0; self.scene().n_modes()];
        Ok(self.set(&zero, &zero)?)
    }

    #[inline]
    fn step(&mut self) -> Result<(), FileError> {
        self.step()?;
        Ok(())
    }

    fn step_parts(
        &mut self,
        length: f64,
        parts: usize,
        apply: impl Fn(usize, &mut Self) -> Result<(), FileError>,
    ) -> Result<(), FileError> {
        let whole = *self.scene().options();
        // Loads are added anew for each part.
        let _ = self.rebind(&SceneOptions { time_step: Some(length), ..whole })?;
        for part in 0..parts {
            apply(part, self)?;
            self.step()?;
        }
        let _ = self.rebind(&whole)?;
        Ok(())
    }

    fn zeta(&self) -> &[T] {
        self.state().zeta()
    }

    fn energy(&self) -> Result<f64, FileError> {
        Ok(self.energy()?)
    }

    fn total(&self, quantity: Quantity) -> Result<f64, FileError> {
        Ok(self.total(quantity)?)
    }

    fn training(&self) -> Option<Training> {
        self.scene().training(self.state()).ok()
    }

    fn probe(&self, index: usize) -> Result<f64, FileError> {
        Ok(self.probe(index, Field::Displacement)?)
    }

    fn stress(&self, point: usize) -> Result<Tensor, FileError> {
        Ok(self.scene().stress(self.state(), point)?)
    }

    fn reaction(&self, support: usize) -> Result<[f64; 6], FileError> {
        Ok(self.scene().reaction(self.state(), support)?.total())
    }

    fn node(&self, node: usize, field: Field) -> Result<[f64; 3], FileError> {
        Ok(self.node(node, field)?)
    }

    fn point(&self, point: &SurfacePoint, field: Field) -> Result<[f64; 3], FileError> {
        Ok(self.point(point, field)?)
    }

    fn surface_into(&mut self, field: Field, out: &mut [T]) -> Result<(), FileError> {
        if field == Field::Velocity || !self.has_static_field() {
            return Ok(Body::surface_into(self, field, out)?);
        }
        self.solve_static_field()?;
        Ok(self.surface_with_statics(field, out)?)
    }

    fn body_into(&mut self, field: Field, out: &mut [T]) -> Result<(), FileError> {
        if field == Field::Velocity || !self.has_static_field() {
            return Ok(Body::body_into(self, field, out)?);
        }
        self.solve_static_field()?;
        Ok(self.body_with_statics(field, out)?)
    }
}
