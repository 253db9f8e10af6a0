//! The named points of an FMU.

use std::path::PathBuf;

use vademecum_build::input::Problem;
use vademecum_eval::{Place, Surface};
use vademecum_fmu::points::{LONGEST_NAME, MOST, Point, StressPlace};
use vademecum_format::{File, SectionKind};

use super::error::FmuError;
use crate::contents::numbers;
use crate::error::FileError;
use crate::near::reach;
use crate::stress::stress_places;

/// A probe within this part of the body's size from the loadable surface is taken to be meant on it.
const NEAR: f64 = 1e-2;

/// A point that is asked for.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedPoint {
    /// Its name.
    pub name: String,
    /// Position in the unit of the file.
    pub at: [f64; 3],
}

/// A point on the loadable surface.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct PlacedPoint {
    /// Its name.
    pub name: String,
    /// Position.
    pub position: [f64; 3],
    /// Distance from the requested point.
    pub distance: f64,
    /// Nodes of its facet, and their shares.
    #[serde(skip)]
    pub place: Place,
}

impl PlacedPoint {
    /// As the instance reads it.
    pub(super) fn row(&self) -> Point<'_> {
        Point { name: &self.name, place: self.place }
    }
}

/// A place whose stress is reported.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct PlacedStress {
    /// Its name.
    pub name: String,
    /// Position of its node.
    pub position: [f64; 3],
    /// Distance from the requested point.
    pub distance: f64,
    /// The node.
    #[serde(skip)]
    pub node: u32,
}

impl PlacedStress {
    /// As the instance reads it.
    pub(super) fn row(&self) -> StressPlace<'_> {
        StressPlace { name: &self.name, node: self.node }
    }
}

fn check_names(asked: &[NamedPoint]) -> Result<(), FmuError> {
    if asked.len() > MOST {
        return Err(FmuError::TooManyPoints { found: asked.len() });
    }
    let bad = |name: &str| name.is_empty() || name.len() > LONGEST_NAME || name.chars().any(char::is_control);
    match asked.iter().find(|point| bad(&point.name)) {
        Some(NamedPoint { name, .. }) => Err(FmuError::BadName { name: name.clone() }),
        None => Ok(()),
    }
}

/// The nodes nearest to these points that the file knows the stress of.
///
/// # Errors
/// [`FmuError`]: a bad name, a file without stress, a point that is far away.
pub(super) fn place_stresses(file: &File<'_>, asked: &[NamedPoint]) -> Result<Vec<PlacedStress>, FmuError> {
    check_names(asked)?;
    let Some(NamedPoint { name, .. }) = asked.first() else { return Ok(vec![]) };
    let places = stress_places(file)?;
    if places.is_empty() {
        return Err(FmuError::NoStress { name: name.clone() });
    }
    let kind = SectionKind::NodeCoordinates;
    file.section(kind).ok_or(FileError::Missing { kind })?;
    vademecum_rewrite::check_coordinates(file)?;
    let all = numbers(file, kind)?;
    let nodes = all.as_chunks::<3>().0;
    let size = reach(file)?;
    let apart = |at: [f64; 3], node: usize| -> f64 {
        let position = nodes.get(node).copied().unwrap_or([f64::INFINITY; 3]);
        (0..3).map(|c| (position[c] - at[c]).powi(2)).sum::<f64>().sqrt()
    };
    let locate = |NamedPoint { name, at }: &NamedPoint| {
        let known = places.iter().map(|place| (apart(*at, place.node), place.node));
        let (distance, node) = known.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((f64::INFINITY, 0));
        let name = name.clone();
        // A point that is not finite is nowhere.
        if distance.is_nan() || distance > size {
            return Err(FmuError::FarStress { name, distance, size });
        }
        Ok(PlacedStress { name, position: nodes[node], distance, node: node as u32 })
    };
    asked.iter().map(locate).collect()
}

/// Locates points on the loadable surface; without any, those of the file's probes.
///
/// # Errors
/// [`FmuError`]: a bad name, a point that is far away, a file without a surface.
pub(super) fn place(file: &File<'_>, asked: &[NamedPoint]) -> Result<Vec<PlacedPoint>, FmuError> {
    check_names(asked)?;
    let loadable = file.metadata().n_load_triangles > 0;
    let held = [SectionKind::NodeCoordinates, SectionKind::Triangles, SectionKind::SurfaceBasis];
    let lost = held.into_iter().find(|&kind| file.section(kind).is_none());
    match lost {
        Some(kind) if !asked.is_empty() => return Err(FileError::Missing { kind }.into()),
        None if !loadable && !asked.is_empty() => return Err(FileError::NoSurface.into()),
        Some(_) => return Ok(vec![]),
        None if !loadable => return Ok(vec![]),
        None => {}
    }
    vademecum_rewrite::check_coordinates(file)?;
    let size = reach(file)?;
    let surface = Surface::new(file).map_err(FileError::from)?;
    let locate = |NamedPoint { name, at }: &NamedPoint| {
        let found = surface.locate(*at).ok_or(FileError::NoSurface)?;
        let (position, distance, place) = (found.position, found.distance, found.place);
        let name = name.clone();
        Ok::<_, FmuError>(PlacedPoint { name, position, distance, place })
    };
    if asked.is_empty() {
        let all = of_probes(file).iter().map(locate).collect::<Result<Vec<_>, _>>()?;
        return Ok(all.into_iter().filter(|point| point.distance <= NEAR * size).collect());
    }
    let placed = asked.iter().map(locate).collect::<Result<Vec<_>, _>>()?;
    // A point that is not finite is nowhere.
    match placed.iter().find(|point| point.distance > size) {
        Some(PlacedPoint { name, distance, .. }) => {
            Err(FmuError::FarPoint { name: name.clone(), distance: *distance, size })
        }
        None => Ok(placed),
    }
}

/// Places of the probes in the problem that the file keeps, each place once, under the name of its first
/// probe. A file of a problem that this program no longer reads has none.
fn of_probes(file: &File<'_>) -> Vec<NamedPoint> {
    let text = file.metadata().problem;
    let Ok(problem) = Problem::parse(text, "the problem in the file", PathBuf::new()) else { return vec![] };
    let mut places: Vec<NamedPoint> = vec![];
    for probe in problem.output.probes {
        let known = places.iter().any(|place| place.at == probe.point || place.name == probe.name);
        let named = !probe.name.is_empty() && probe.name.len() <= LONGEST_NAME;
        if !known && named && places.len() < MOST {
            places.push(NamedPoint { name: probe.name, at: probe.point });
        }
    }
    places
}
