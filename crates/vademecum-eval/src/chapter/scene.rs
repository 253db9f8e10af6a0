//! Binding a file with the chapter's structure.

use super::error::ChapterBindError;
use crate::base::error::BindError;
use crate::base::lend::Lender;
use crate::base::options::{SceneOptions, Sizes, StructureChoice};
use crate::base::scalar::Scalar;
use crate::kernels::coordinates::Parts;
use crate::scene::bind::{Asked, matrices, needed};
use crate::scene::equation::{Equation, Matrices, Stiffness};
use crate::scene::{rest, shape};
use crate::sections::rows::Rows;
use vademecum_format::scheme::{MAX_STAGES, StepParameters};
use vademecum_format::{Chapter, File, MAX_REGIONS, Metadata, SectionKind};

/// The scales of the regions: the structure knows the body as it was built.
const AS_BUILT: [f64; MAX_REGIONS] = [1.0; MAX_REGIONS];

/// The lengths a scene, its states and its loads agree on.
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

    /// Layout of the parts of a state.
    pub const fn parts(&self) -> Parts {
        Parts { count: 3, r: self.r, stride: self.r, padded: 3 * self.r }
    }

    /// Old and new state, the stages between them, and the weights of a part's terms.
    pub const fn state_len(&self) -> usize {
        (6 + self.n_stages) * self.r + self.n_terms
    }

    /// Additions of the loads to each stage and to the force at the start, twice, and the weights of a part's
    /// terms.
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
    pub(super) rest_below: T,
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
            rest_below: options.rest_threshold(),
            factors: numbers.take(shape.n_factors)?,
            terms: numbers.rest(),
        })
    }

    /// `r`: the number of modes.
    #[must_use]
    pub const fn n_modes(&self) -> usize {
        self.shape.r
    }

    /// The file's metadata.
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

    /// The largest energy \[J\] that a body of this scene can have when it is put at rest.
    #[must_use]
    pub fn energy_at_rest(&self) -> f64 {
        rest::energy(self.rest_below, &self.equation(), self.shape.r)
    }

    pub(super) const fn equation(&self) -> Equation<'_, '_> {
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
