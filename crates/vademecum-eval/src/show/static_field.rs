//! Whole fields with the whole static answer: `u = B (q − Λ⁻¹BᵀF) + K⁻¹F`, by the factor of the stiffness,
//! where the file has it.
//!
//! `B q` leaves out of a field what the modes cannot follow, and the residual flexibility of contacts and
//! probes does not reach the rest of the body. Two triangular solves do. They cost far more than a step, so
//! nothing solves unless it is asked to, and one answer serves as long as the forces stay.

use crate::base::error::{BindError, OutputError};
use crate::base::scalar::Scalar;
use crate::kernels::kernel::add_row;
use crate::scene::equation::Stiffness;
use crate::scene::scene::Scene;
use crate::scene::shape::Shape;
use crate::scene::state::State;
use crate::sections::factor::Factor;
use crate::sections::rows::{Field, factors};
use vademecum_format::SectionKind;

/// The static answer of a body to the forces of a state, in lent memory.
#[derive(Debug)]
#[doc(alias = "static correction", alias = "mode acceleration")]
pub struct StaticField<'m, T> {
    shape: Shape,
    /// `K⁻¹F` at the stiffness of the file, in the order of the factor.
    answer: &'m mut [f64],
    /// `Λ⁻¹BᵀF` at the stiffness of the file: what the modes have of it.
    shares: &'m mut [f64],
    /// The coordinates of a state without that.
    rest: &'m mut [T],
}

impl<'m, T: Scalar> StaticField<'m, T> {
    /// No forces. `answer` and `rest` hold at least what [`Scene::static_field_sizes`] says; what is in them
    /// does not matter.
    ///
    /// # Errors
    /// [`BindError::LentMemory`].
    pub fn new(scene: &Scene<'_, T>, answer: &'m mut [f64], rest: &'m mut [T]) -> Result<Self, BindError> {
        let [of_answer, of_rest] = scene.static_field_sizes();
        let short = |found, needed| BindError::LentMemory { found, needed };
        let found = [answer.len(), rest.len()];
        let answer = answer.get_mut(..of_answer).ok_or(short(found[0], of_answer))?;
        let rest = rest.get_mut(..of_rest).ok_or(short(found[1], of_rest))?;
        answer.fill(0.0);
        let (answer, shares) = answer.split_at_mut(of_answer.saturating_sub(scene.shape.r));
        Ok(Self { shape: scene.shape, answer, shares, rest })
    }
}

/// Numbers of memory that the answer of a file with this factor wants.
pub(crate) fn static_field_sizes(factor: &Factor<'_>, shape: &Shape) -> [usize; 2] {
    let (order, r) = (factor.order.len(), shape.r);
    let known = factor.values.is_some() && shape.statics != [0; 2];
    let small = shape.is_modal();
    if known && small { [order + r, r] } else { [0; 2] }
}

impl<T: Scalar> Scene<'_, T> {
    /// Numbers of memory that a [`StaticField`] wants: `f64`, and of the precision of the scene. Zeros where
    /// the file does not have the factor of the stiffness, or has it compressed, and where the residual was
    /// left out of the options.
    #[must_use]
    pub fn static_field_sizes(&self) -> [usize; 2] {
        static_field_sizes(&self.sections.factor, &self.shape)
    }

    /// Solves for the static answer to the forces under which `state` made its last step, filtered ones under
    /// stiffness-proportional damping. It is worth doing only when they have changed. One pass forwards and
    /// one backwards through the factor.
    ///
    /// # Errors
    /// [`OutputError::Missing`] where the file does not have the factor or what goes with it,
    /// [`OutputError::Mismatch`] for a state of another scene; the field is then that of no forces.
    pub fn solve_static_field(
        &self,
        state: &State<'_, T>,
        field: &mut StaticField<'_, T>,
    ) -> Result<(), OutputError> {
        field.answer.fill(0.0);
        field.shares.fill(0.0);
        if state.shape != self.shape || field.shape != self.shape {
            return Err(OutputError::Mismatch);
        }
        let solved = self.answer_into(state, field);
        if solved.is_err() {
            field.answer.fill(0.0);
            field.shares.fill(0.0);
        }
        solved
    }

    fn answer_into(&self, state: &State<'_, T>, field: &mut StaticField<'_, T>) -> Result<(), OutputError> {
        let missing = |kind| OutputError::Missing { kind };
        let (factor, r) = (&self.sections.factor, self.shape.r);
        if field.answer.len() != factor.order.len() || field.shares.len() != r {
            return Err(missing(SectionKind::FactorValues));
        }
        let Stiffness::Diagonal(eigenvalues) = self.sections.matrices.stiffness else {
            return Err(missing(SectionKind::Eigenvalues));
        };
        let surface = self.sections.rows.surface.ok_or(missing(SectionKind::SurfaceBasis))?;
        let forces = || state.shown().forces();
        for (node, force) in forces() {
            for (component, force) in force.into_iter().enumerate() {
                let row = surface.row((3 * node + component) * r, r);
                add_row(row.ok_or(missing(SectionKind::SurfaceBasis))?, force, field.shares);
            }
        }
        if forces().next().is_some() {
            for (place, x) in factor.order.iter().zip(&mut *field.answer) {
                let place = u32::from_le_bytes(*place) as usize;
                for (_, force) in forces().filter(|&(node, _)| node == place / 3) {
                    *x += force.get(place % 3).copied().unwrap_or(0.0);
                }
            }
            factor.solve(field.answer).ok_or(missing(SectionKind::FactorValues))?;
        }
        for (pattern, amplitude) in state.shown().amplitudes() {
            let kind = SectionKind::PatternAnswer;
            let n = field.answer.len();
            let row = factor.patterns.and_then(|rows| rows.row(pattern.checked_mul(n)?, n));
            add_row(row.ok_or(missing(kind))?, amplitude, field.answer);
            let kind = SectionKind::PatternBasis;
            let row = self.sections.pattern_basis.and_then(|rows| rows.row(pattern.checked_mul(r)?, r));
            add_row(row.ok_or(missing(kind))?, amplitude, field.shares);
        }
        for (share, lambda) in field.shares.iter_mut().zip(eigenvalues) {
            *share /= f64::from_le_bytes(*lambda);
        }
        Ok(())
    }

    /// [`Scene::surface_into`] with the whole static answer that `statics` was solved for.
    ///
    /// # Errors
    /// [`OutputError`].
    pub fn surface_with(
        &self,
        state: &State<'_, T>,
        field: Field,
        statics: &mut StaticField<'_, T>,
        out: &mut [T],
    ) -> Result<(), OutputError> {
        let coordinates = self.without_statics(state, field, statics)?;
        self.sections.rows.surface_into(coordinates, out)?;
        self.add_answer(field, statics, out);
        Ok(())
    }

    /// [`Scene::body_into`] with the whole static answer that `statics` was solved for.
    ///
    /// # Errors
    /// [`OutputError`].
    pub fn body_with(
        &self,
        state: &State<'_, T>,
        field: Field,
        statics: &mut StaticField<'_, T>,
        out: &mut [T],
    ) -> Result<(), OutputError> {
        let coordinates = self.without_statics(state, field, statics)?;
        self.sections.rows.body_into(coordinates, out)?;
        self.add_answer(field, statics, out);
        Ok(())
    }

    /// The coordinates of a state without the static answer of the modes, which has no velocity.
    fn without_statics<'s>(
        &self,
        state: &'s State<'_, T>,
        field: Field,
        statics: &'s mut StaticField<'_, T>,
    ) -> Result<(&'s [T], f64), OutputError> {
        if state.shape != self.shape || statics.shape != self.shape {
            return Err(OutputError::Mismatch);
        }
        let (moving, scale) = factors(&state.y, field);
        if field == Field::Velocity || statics.rest.is_empty() {
            return Ok((moving, scale));
        }
        let stiffness = self.parameters.stiffness;
        for ((rest, &moving), &share) in statics.rest.iter_mut().zip(moving).zip(&*statics.shares) {
            *rest = T::from_f64(moving.to_f64() - share / stiffness);
        }
        Ok((&*statics.rest, scale))
    }

    /// Adds `K⁻¹F` to the nodes of `out`, shape `(any, 3)`.
    fn add_answer(&self, field: Field, statics: &StaticField<'_, T>, out: &mut [T]) {
        if field == Field::Velocity {
            return;
        }
        let stiffness = self.parameters.stiffness;
        for (place, answer) in self.sections.factor.order.iter().zip(&*statics.answer) {
            if let Some(out) = out.get_mut(u32::from_le_bytes(*place) as usize) {
                *out += T::from_f64(answer / stiffness);
            }
        }
    }
}
