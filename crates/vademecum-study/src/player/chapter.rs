//! The chapter's structure, played: all that this crate knows of its scene.
//!
//! Its maps have an axis for the node that a load stands at, so a contact is moved to the nearest of those
//! nodes. Its other axes end, so a march can leave them.

use vademecum_build::certificate::spectral_radius;
use vademecum_build::dynamics::INSTANTS;
use vademecum_chapter::{ChapterLoads, ChapterScene, ChapterState, ChapterStepError, report_of_file};
use vademecum_eval::{Contact, Field, Place, SurfacePoint};
use vademecum_format::{Chapter, File, SectionKind};

use super::PlayOptions;
use super::body::Playable;
use crate::contents::{numbers, section};
use crate::error::{FileError, StudyError};

/// Where a file of the chapter's structure can take loads: nodes and where they are.
pub(super) fn positions_of(
    file: &File<'_>,
    chapter: &Chapter<'_>,
) -> Result<Vec<(u32, [f64; 3])>, FileError> {
    section(file, SectionKind::NodeCoordinates).map_err(|_| FileError::NoSurface)?;
    let coordinates = numbers(file, SectionKind::NodeCoordinates)?;
    let at = |node: u32| [0, 1, 2].map(|c| coordinates[3 * node as usize + c]);
    Ok(chapter.positions().map(|node| (node, at(node))).collect())
}

/// The nearest of these positions.
pub(super) fn nearest_position(
    positions: &[(u32, [f64; 3])],
    point: [f64; 3],
) -> Result<SurfacePoint, FileError> {
    let distance = |x: [f64; 3]| (0..3).map(|c| (x[c] - point[c]).powi(2)).sum::<f64>().sqrt();
    let places = positions.iter().map(|&(node, at)| (node, at, distance(at)));
    let nearest = places.min_by(|a, b| a.2.total_cmp(&b.2));
    let (node, position, distance) = nearest.ok_or(FileError::NoSurface)?;
    Ok(SurfacePoint { place: Place::triangle([node; 3], [1.0, 0.0, 0.0]), position, distance })
}

/// A body of the chapter's structure.
pub struct ChapterBody<'s, 'm> {
    /// The bound file, which several bodies can share.
    pub scene: &'s ChapterScene<'m>,
    /// Where the body is.
    pub state: ChapterState,
    /// Its loads.
    pub loads: ChapterLoads,
}

impl<'s, 'm> ChapterBody<'s, 'm> {
    /// A body at rest and unloaded.
    #[must_use]
    pub fn new(scene: &'s ChapterScene<'m>) -> Self {
        Self { scene, state: ChapterState::new(scene), loads: ChapterLoads::new(scene) }
    }
}

impl Playable for ChapterBody<'_, '_> {
    type Number = f64;

    fn structure(&self) -> &'static str {
        "canonical"
    }

    fn time_step(&self) -> f64 {
        self.scene.parameters().time_step
    }

    fn instants(&self) -> [f64; INSTANTS] {
        self.scene.instants()
    }

    fn clear(&mut self) {
        self.loads.clear();
    }

    fn push(&mut self, contact: &Contact, amplitudes: &[f64; INSTANTS]) -> Result<(), FileError> {
        Ok(self.loads.add_contact_staged(self.scene, contact, amplitudes)?)
    }

    fn start(&mut self) -> Result<(), FileError> {
        let zero = vec![0.0; self.scene.n_modes()];
        Ok(self.scene.set(&mut self.state, &zero, &zero, &self.loads)?)
    }

    #[inline]
    fn step(&mut self) -> Result<(), FileError> {
        self.scene.step(&mut self.state, &self.loads)?;
        Ok(())
    }

    fn zeta(&self) -> &[f64] {
        self.state.zeta()
    }

    fn energy(&self) -> Result<f64, FileError> {
        Ok(self.scene.energy(&self.state)?)
    }

    fn probe(&self, index: usize) -> Result<f64, FileError> {
        Ok(self.scene.probe(&self.state, index, Field::Displacement)?)
    }

    fn node(&self, node: usize, field: Field) -> Result<[f64; 3], FileError> {
        Ok(self.scene.node(&self.state, node, field)?)
    }

    fn point(&self, point: &SurfacePoint, field: Field) -> Result<[f64; 3], FileError> {
        Ok(self.scene.point(&self.state, point, field)?)
    }

    fn surface_into(&mut self, field: Field, out: &mut [f64]) -> Result<(), FileError> {
        Ok(self.scene.surface_into(&self.state, field, out)?)
    }

    fn body_into(&mut self, field: Field, out: &mut [f64]) -> Result<(), FileError> {
        Ok(self.scene.body_into(&self.state, field, out)?)
    }
}

/// Why a march has no further step: it left the ranges of the maps, in words.
///
/// # Errors
/// Any other refusal.
pub fn left_ranges(error: ChapterStepError) -> Result<String, FileError> {
    match error {
        ChapterStepError::OutsideAxis { .. } => Ok(error.to_string()),
        other => Err(other.into()),
    }
}

/// Spectral radius of the step: of the map as the evaluator marches it, but for the chapter's structure,
/// whose axes unit states are far off, the one that the build found by linearising the step. NaN where a file
/// does not keep it.
///
/// # Errors
/// [`StudyError`]: a file that the evaluator refuses, eigenvalues that do not converge.
pub fn step_radius(file: &File<'_>, options: &PlayOptions) -> Result<f64, StudyError> {
    if options.takes_chapter(file) {
        let report = report_of_file(file)?;
        return Ok(report.map_or(f64::NAN, |report| report.structure.spectral_radius));
    }
    Ok(spectral_radius(file, &options.scene)?)
}
