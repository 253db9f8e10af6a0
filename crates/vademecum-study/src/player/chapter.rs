//! The chapter's structure, played: all that this crate knows of its scene.
//!
//! Its maps have an axis for the node that a load stands at, so a contact is moved to the nearest of those
//! nodes. Its other axes end, so a march can leave them.

use vademecum_build::certificate::spectral_radius;
use vademecum_chapter::report_of_file;
use vademecum_eval::chapter::{ChapterLoads, ChapterScene, ChapterState, ChapterStepError};
use vademecum_eval::{Place, Scalar, SceneOptions, SurfacePoint};
use vademecum_format::{Chapter, File, SectionKind};

use super::PlayOptions;
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

/// Binds a scene of the chapter's structure in memory of its own and hands it over, at rest and unloaded.
///
/// # Errors
/// [`StudyError::File`]: a file that the evaluator refuses; those of `work`.
pub fn with_chapter<T: Scalar, R>(
    file: &File<'_>,
    options: &SceneOptions,
    work: impl FnOnce(
        &ChapterScene<'_, T>,
        &mut ChapterState<'_, T>,
        &mut ChapterLoads<'_, T>,
    ) -> Result<R, StudyError>,
) -> Result<R, StudyError> {
    let sizes = ChapterScene::<T>::sizes(file)?;
    let mut memory = vec![T::ZERO; sizes.scene];
    let (mut state_memory, mut load_memory) = (vec![T::ZERO; sizes.state], vec![T::ZERO; sizes.loads]);
    let scene = ChapterScene::bind(file, options, &mut memory)?;
    let mut state = ChapterState::new(&scene, &mut state_memory)?;
    let mut loads = ChapterLoads::new(&scene, &mut load_memory)?;
    work(&scene, &mut state, &mut loads)
}

/// States of several marches through one scene, each with its loads.
pub type Marches<'m> = Vec<(ChapterState<'m, f64>, ChapterLoads<'m, f64>)>;

/// Binds a file once and hands over a state and loads for each of `count` marches.
///
/// # Errors
/// A file without the scene of the chapter, or with a time step that it refuses.
pub fn with_marches<R>(
    file: &File<'_>,
    time_step: Option<f64>,
    count: usize,
    work: impl FnOnce(&ChapterScene<'_, f64>, &mut Marches<'_>) -> Result<R, StudyError>,
) -> Result<R, StudyError> {
    let options = SceneOptions { time_step, ..SceneOptions::default() };
    let sizes = ChapterScene::<f64>::sizes(file)?;
    let mut memory = vec![(vec![0.0; sizes.state], vec![0.0; sizes.loads]); count];
    with_chapter::<f64, _>(file, &options, |scene, _, _| {
        let mut marches = vec![];
        for (state, loads) in &mut memory {
            let state = ChapterState::new(scene, state)?;
            marches.push((state, ChapterLoads::new(scene, loads)?));
        }
        work(scene, &mut marches)
    })
}

/// Why a march has no further step: it left the ranges of the maps. The words of the evaluator.
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
