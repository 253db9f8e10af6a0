//! Binding a file with the chapter's structure, the step, and what can be read of a state.

use super::error::{ChapterBindError, ChapterStepError};
use super::loads::ChapterLoads;
use super::state::ChapterState;
use super::terms::{Unknown, pieces};
use crate::bind::{Asked, matrices, needed};
use crate::coordinates::Parts;
use crate::equation::{Equation, Matrices, Stiffness};
use crate::error::{BindError, OutputError, StepError};
use crate::kernel::flushed;
use crate::lend::{Lender, Short};
use crate::options::{SceneOptions, Sizes, Status, StructureChoice};
use crate::rows::{Factors, Field, Rows, factors};
use crate::scalar::Scalar;
use crate::surface::SurfacePoint;
use crate::{rest, shape};
use vademecum_format::scheme::{MAX_STAGES, StepParameters};
use vademecum_format::{Chapter, ChapterAxis, ChapterRole, File, MAX_REGIONS, Metadata, SectionKind};

/// The scales of the regions: the structure knows the body as it was built.
const AS_BUILT: [f64; MAX_REGIONS] = [1.0; MAX_REGIONS];

/// What a scene, its states and its loads agree on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Shape {
    pub r: usize,
    pub n_stages: usize,
    /// Most terms of a part.
    pub n_terms: usize,
    /// Numbers of all factors.
    n_factors: usize,
    /// `Δt` \[s\].
    pub time_step: f64,
}

impl Shape {
    fn of(file: &File<'_>, chapter: &Chapter<'_>) -> Self {
        let metadata = file.metadata();
        Self {
            r: metadata.n_modes as usize,
            n_stages: metadata.scheme.active().len(),
            n_terms: chapter.max_terms(),
            n_factors: chapter.lengths().0,
            time_step: metadata.time_step,
        }
    }

    /// Where the parts of a state lie.
    pub const fn parts(&self) -> Parts {
        Parts { r: self.r, stride: self.r, padded: 3 * self.r }
    }

    /// Old and new state, the stages between them, and the weights of a part's terms.
    pub const fn state_len(&self) -> usize {
        (6 + self.n_stages) * self.r + self.n_terms
    }

    /// What loads add to each stage and to the force at the start, twice, and the weights of a part's terms.
    pub const fn loads_len(&self) -> usize {
        2 * (self.n_stages + 1) * self.r + self.n_terms
    }
}

/// An opened file with the chapter's structure, ready to step. States and loads are apart.
#[derive(Debug)]
pub struct ChapterScene<'m, T> {
    pub(super) shape: Shape,
    pub(super) metadata: Metadata<'m>,
    pub(super) chapter: Chapter<'m>,
    pub(super) rows: Rows<'m>,
    matrices: Matrices<'m>,
    parameters: StepParameters,
    rest_below: T,
    /// Factors of all parts in the order of the file, rounded.
    pub(super) factors: &'m [T],
    /// Terms of all parts in the order of the file, rounded.
    pub(super) terms: &'m [T],
}

impl<'m, T: Scalar> ChapterScene<'m, T> {
    /// The memory that a scene, a state and loads ask for; no work memory.
    ///
    /// # Errors
    /// [`ChapterBindError::NoChapter`], and [`ChapterBindError::Bind`] if the tables are compressed.
    pub fn sizes(file: &File<'_>) -> Result<Sizes, ChapterBindError> {
        let chapter = Chapter::read(file)?.ok_or(ChapterBindError::NoChapter)?;
        let shape = Shape::of(file, &chapter);
        let (n_factors, n_numbers) = chapter.lengths();
        Ok(Sizes {
            scene: n_factors.saturating_add(n_numbers),
            work: 0,
            state: shape.state_len(),
            loads: shape.loads_len(),
        })
    }

    /// Binds a file. `memory` holds at least what [`ChapterScene::sizes`] says; what is in it does not
    /// matter.
    ///
    /// Of the options only [`SceneOptions::rest_below`] is free. The others must be the file's: the defaults,
    /// or the same numbers. Cost: every factor and term is rounded once.
    ///
    /// # Errors
    /// [`ChapterBindError`].
    pub fn bind(
        file: &File<'m>,
        options: &SceneOptions,
        memory: &'m mut [T],
    ) -> Result<Self, ChapterBindError> {
        let chapter = Chapter::read(file)?.ok_or(ChapterBindError::NoChapter)?;
        let metadata = *file.metadata();
        shape::check(options)?;
        let asked = Asked::new(&metadata, options);
        let free = options.structure == StructureChoice::Auto && options.terms.is_none();
        if !free || asked != Asked::new(&metadata, &SceneOptions::default()) {
            return Err(ChapterBindError::Fixed);
        }
        let (found, needed_len) = (memory.len(), Self::sizes(file)?.scene);
        let memory =
            memory.get_mut(..needed_len).ok_or(BindError::LentMemory { found, needed: needed_len })?;
        round(&chapter, memory)?;
        let shape = Shape::of(file, &chapter);
        let mut numbers = Lender::new(&*memory);
        Ok(Self {
            shape,
            metadata,
            chapter,
            rows: Rows::of(file),
            matrices: matrices(file, Stiffness::Dense(needed(file, SectionKind::ReducedStiffness)?)),
            parameters: asked.step,
            rest_below: rest::threshold(options),
            factors: numbers.take(shape.n_factors)?,
            terms: numbers.rest(),
        })
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

    /// The parameters of the step: the file's.
    #[must_use]
    pub const fn parameters(&self) -> &StepParameters {
        &self.parameters
    }

    /// Instants at which a step needs a changing load, as fractions of it: 0, then one per stage; the rest
    /// is 0.
    #[must_use]
    pub fn instants(&self) -> [f64; 1 + MAX_STAGES] {
        self.metadata.scheme.instants()
    }

    /// Sets displacement and velocity in reduced coordinates and computes the acceleration that goes with
    /// them under `loads`, as [`Scene::set`](crate::Scene::set) does.
    ///
    /// # Errors
    /// [`StepError`]; the state is then unchanged.
    pub fn set(
        &self,
        state: &mut ChapterState<'_, T>,
        zeta: &[f64],
        zeta_dot: &[f64],
        loads: &ChapterLoads<'_, T>,
    ) -> Result<(), StepError> {
        if state.shape != self.shape || loads.shape != self.shape {
            return Err(StepError::Mismatch);
        }
        self.equation().place(&mut state.y, zeta, zeta_dot, loads.force)
    }

    /// Advances `state` by `Δt` under `loads`.
    ///
    /// # Errors
    /// [`ChapterStepError`]; the state is then unchanged.
    pub fn step(
        &self,
        state: &mut ChapterState<'_, T>,
        loads: &ChapterLoads<'_, T>,
    ) -> Result<Status, ChapterStepError> {
        if state.shape != self.shape || loads.shape != self.shape {
            return Err(StepError::Mismatch.into());
        }
        if state.y.at_rest && !loads.active {
            return Ok(Status::AtRest);
        }
        self.stages(state, loads)?;
        let magnitude = self.finish(state)?;
        Ok(state.y.settle(magnitude, loads.active, self.rest_below)?)
    }

    /// The stages in order, from the state and the loads.
    fn stages(
        &self,
        state: &mut ChapterState<'_, T>,
        loads: &ChapterLoads<'_, T>,
    ) -> Result<(), ChapterStepError> {
        let (r, now) = (self.shape.r, &*state.y.now);
        state.stages.iter_mut().zip(&*loads.increment).for_each(|(stage, &load)| *stage = load);
        for piece in pieces(&self.chapter, self.factors, self.terms) {
            let piece = piece?;
            if !piece.part.has_state() {
                continue;
            }
            let stage = piece.part.stage;
            let mut stages = Lender::new(&mut *state.stages);
            let (earlier, out) = (stages.take(stage.saturating_mul(r))?, stages.take(r)?);
            let value = |role: ChapterRole| match role {
                ChapterRole::State { family, mode } => entry(now, earlier, r, family, mode),
                other => loads.held.value(other, stage),
            };
            piece.add(value, state.weights, out).map_err(|unknown| match unknown {
                Unknown::Outside(ChapterAxis { role, lower, upper, .. }, value) => {
                    ChapterStepError::OutsideAxis { stage, role, value, lower, upper }
                }
                Unknown::Short(short) => short.into(),
            })?;
        }
        Ok(())
    }

    /// The scheme's finish, beside the state. Gives `Σ|y|` of the new one.
    fn finish(&self, state: &mut ChapterState<'_, T>) -> Result<T, Short> {
        let (r, now) = (self.shape.r, &*state.y.now);
        let mut sum = T::ZERO;
        let rows = self.metadata.scheme.finish.iter();
        for (row, new) in rows.zip(state.y.next.chunks_exact_mut(r.max(1))) {
            for (mode, new) in new.iter_mut().enumerate() {
                let terms = row.iter().take(3 + self.shape.n_stages).enumerate();
                let weighted = terms.map(|(family, w)| Ok(w * entry(now, state.stages, r, family, mode)?));
                *new = flushed(T::from_f64(weighted.sum::<Result<f64, Short>>()?), &mut sum);
            }
        }
        Ok(sum)
    }

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
        self.rows.point(point, self.multipliers(state, field)?)
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
        self.equation().energy(&state.y).ok_or(OutputError::Mismatch)
    }

    /// The largest energy \[J\] that a body of this scene can have when it is put at rest.
    #[must_use]
    pub fn energy_at_rest(&self) -> f64 {
        rest::energy(self.rest_below, &self.equation(), self.shape.r)
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

    const fn equation(&self) -> Equation<'_, '_> {
        Equation {
            matrices: &self.matrices,
            parameters: &self.parameters,
            region_stiffness: &AS_BUILT,
            region_density: &AS_BUILT,
        }
    }
}

/// Rounds factors and terms to the scene's precision, factors first, in the order of the file.
fn round<T: Scalar>(chapter: &Chapter<'_>, out: &mut [T]) -> Result<(), BindError> {
    let factors = chapter.parts().flat_map(|part| part.factors);
    let numbers = factors.chain(chapter.parts().flat_map(|part| part.terms));
    for (out, &bytes) in out.iter_mut().zip(numbers) {
        *out = T::from_f64(f64::from_le_bytes(bytes));
        if !out.to_f64().is_finite() {
            return Err(BindError::NotFinite);
        }
    }
    Ok(())
}

/// An entry of the history `(ζ, Δt ζ̇, Δt² ζ̈, ζ_1, …)`.
fn entry<T: Scalar>(now: &[T], stages: &[T], r: usize, family: usize, mode: usize) -> Result<f64, Short> {
    let (from, family) = if family < 3 { (now, family) } else { (stages, family - 3) };
    let at = family * r + mode;
    from.get(at).map(|x| x.to_f64()).ok_or(Short { found: from.len(), needed: at.saturating_add(1) })
}
