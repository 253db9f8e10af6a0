//! Binding a file with the chapter's structure.

use super::error::ChapterBindError;
use super::terms::{Piece, pieces};
use vademecum_eval::{BindError, RegionScales, Scalar, SceneOptions, StructureChoice};
use vademecum_format::scheme::{MAX_STAGES, StepParameters};
use vademecum_format::{Chapter, File, FormatError, Metadata, Numbers, SectionKind};

/// Lengths that a scene, its states and its loads share.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Shape {
    pub r: usize,
    pub n_stages: usize,
    /// Numbers of all factors, and of all terms.
    lengths: (usize, usize),
    /// `Δt` \[s\].
    pub time_step: f64,
}

/// An opened file with the chapter's structure, ready to step. States and loads are apart.
#[derive(Debug)]
pub struct ChapterScene<'m> {
    pub(super) shape: Shape,
    pub(super) metadata: Metadata<'m>,
    pub(super) chapter: Chapter<'m>,
    pub(super) pieces: Vec<Piece<'m>>,
    /// `BᵀKB`, `(r, r)`.
    stiffness: &'m [[u8; 8]],
    /// Rows of the basis, `None` where they are absent or compressed.
    pub(super) surface: Option<Numbers<'m>>,
    pub(super) interior: Option<Numbers<'m>>,
    pub(super) probes: Option<Numbers<'m>>,
    parameters: StepParameters,
    pub(super) rest_below: f64,
}

impl<'m> ChapterScene<'m> {
    /// Binds a file. Of the options only [`SceneOptions::rest_below`] is free. The others must be the file's:
    /// the defaults, or the same numbers. Cost: a look at every factor and term.
    ///
    /// # Errors
    /// [`ChapterBindError`].
    pub fn bind(file: &File<'m>, options: &SceneOptions) -> Result<Self, ChapterBindError> {
        let chapter = Chapter::read(file)?.ok_or(ChapterBindError::NoChapter)?;
        let metadata = *file.metadata();
        let parameters = fixed_parameters(&metadata, options)?;
        let pieces = pieces(&chapter);
        let mut numbers = pieces.iter().flat_map(|piece| piece.part.factors.iter().chain(piece.part.terms));
        if numbers.any(|&bytes| !f64::from_le_bytes(bytes).is_finite()) {
            return Err(BindError::NotFinite.into());
        }
        let stiffness = SectionKind::ReducedStiffness;
        let missing = FormatError::Missing { kind: stiffness.number() };
        let rows = |kind| file.section(kind).and_then(|section| section.numbers().ok());
        Ok(Self {
            shape: Shape {
                r: metadata.n_modes as usize,
                n_stages: metadata.scheme.active().len(),
                lengths: chapter.lengths(),
                time_step: metadata.time_step,
            },
            metadata,
            chapter,
            pieces,
            stiffness: file.section(stiffness).ok_or(missing)?.f64s()?,
            surface: rows(SectionKind::SurfaceBasis),
            interior: rows(SectionKind::InteriorBasis),
            probes: rows(SectionKind::ProbeRows),
            parameters,
            rest_below: options.rest_below.max(f64::REST),
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

    /// The largest energy \[J\] that a body of this scene can have when it is put at rest: as
    /// [`Scene::energy_at_rest`](vademecum_eval::Scene::energy_at_rest), with the sum of the diagonal of
    /// `K_r` for its largest eigenvalue.
    #[must_use]
    pub fn energy_at_rest(&self) -> f64 {
        let diagonal = self.stiffness.iter().step_by(self.shape.r + 1);
        let stiffness: f64 = diagonal.map(|&bytes| f64::from_le_bytes(bytes)).sum();
        let kinetic = 1.0 / (self.shape.time_step * self.shape.time_step);
        0.5 * self.rest_below * self.rest_below * stiffness.max(kinetic)
    }

    /// Row `k` of `K_r x`.
    pub(super) fn stiffness_row(&self, k: usize, x: &[f64]) -> f64 {
        let row = self.stiffness.iter().skip(k * self.shape.r);
        row.zip(x).map(|(&bytes, x)| f64::from_le_bytes(bytes) * x).sum()
    }
}

/// The parameters of the file, if the options leave them alone.
fn fixed_parameters(
    metadata: &Metadata<'_>,
    options: &SceneOptions,
) -> Result<StepParameters, ChapterBindError> {
    for value in [options.tolerance, options.rest_below] {
        if value.is_nan() || value < 0.0 {
            return Err(BindError::BadOption { value }.into());
        }
    }
    let Metadata { time_step, alpha, beta, .. } = *metadata;
    let own = |asked: Option<f64>, of_file: f64| asked.is_none_or(|asked| asked == of_file);
    let free = options.structure == StructureChoice::Auto && options.terms.is_none();
    let scales = [options.stiffness, options.density] == [1.0; 2] && options.regions == RegionScales::ONE;
    let step = own(options.time_step, time_step) && own(options.alpha, alpha) && own(options.beta, beta);
    if !(free && scales && step) {
        return Err(ChapterBindError::Fixed);
    }
    Ok(StepParameters { time_step, alpha, beta, density: 1.0, stiffness: 1.0 })
}
