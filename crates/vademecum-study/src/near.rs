//! Points that somebody names, held to the body: one that is further from the surface than the body is large
//! is most likely in another unit, and the nearest point of the surface would not be what was meant.

use vademecum_eval::{Surface, SurfacePoint};
use vademecum_format::{File, SectionKind};

use crate::contents::numbers;
use crate::error::{FileError, StudyError};

/// A place this far from the point given, relative to its largest coordinate, is worth a note.
pub(crate) const FAR: f64 = 1e-6;

/// Largest accepted distance of a point from the surface \[m\], that of the evaluator's bodies.
pub(crate) fn reach(file: &File<'_>) -> Result<f64, FileError> {
    Ok(Surface::new(file)?.reach())
}

/// The point of the loadable surface that was found for `what`, unless it is further away than `reach`.
pub(crate) fn within(
    file: &File<'_>,
    reach: f64,
    found: SurfacePoint,
    what: impl FnOnce() -> String,
) -> Result<SurfacePoint, StudyError> {
    if found.distance > reach {
        let [low, high] = loadable_box(file)?;
        return Err(StudyError::FarPoint { what: what(), distance: found.distance, low, high });
    }
    Ok(found)
}

/// The box around the loadable nodes of a file, which are its first: lower and upper corner.
fn loadable_box(file: &File<'_>) -> Result<[[f64; 3]; 2], FileError> {
    let coordinates = numbers(file, SectionKind::NodeCoordinates)?;
    let nodes = coordinates.as_chunks::<3>().0;
    let count = file.metadata().n_load_nodes as usize;
    let fold = |start: f64, pick: fn(f64, f64) -> f64| {
        std::array::from_fn(|c| nodes.iter().take(count).fold(start, |x, node| pick(x, node[c])))
    };
    Ok([fold(f64::INFINITY, f64::min), fold(f64::NEG_INFINITY, f64::max)])
}
