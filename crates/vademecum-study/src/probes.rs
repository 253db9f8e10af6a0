//! Probes that a scenario brings along: displacement components that the file was not built with, read at its
//! nodes.

use vademecum_build::input::ProbeEntry;
use vademecum_format::{File, SectionKind};

use crate::contents::numbers;
use crate::error::{FileError, StudyError};
use crate::player::Playable;

/// A probe this far from the point given, relative to the node's largest coordinate, is worth a note.
const FAR: f64 = 1e-6;

/// A probe of a scenario, at a node of the file.
pub(crate) struct PlacedProbe {
    node: usize,
    direction: [f64; 3],
    /// Position of the node at rest.
    pub(crate) position: [f64; 3],
}

impl PlacedProbe {
    /// Displacement along its direction \[m\].
    pub(crate) fn value(&self, body: &dyn Playable<Number = f64>) -> Result<f64, FileError> {
        let moved = self.displacement(body)?;
        Ok((0..3).map(|c| moved[c] * self.direction[c]).sum())
    }

    /// Displacement of its node \[m\].
    pub(crate) fn displacement(&self, body: &dyn Playable<Number = f64>) -> Result<[f64; 3], FileError> {
        body.node(self.node)
    }
}

/// The probes of a scenario, each at the nearest node that the file can show, and what is to tell of them.
///
/// # Errors
/// [`StudyError::ProbeTwice`]: a name that one of the file's own probes, `built`, has;
/// [`FileError::Missing`]: a file stripped of its nodes or their motion.
pub(crate) fn place(
    file: &File<'_>,
    entries: &[ProbeEntry],
    built: &[String],
) -> Result<(Vec<PlacedProbe>, Vec<String>), StudyError> {
    let (mut placed, mut notes) = (vec![], vec![]);
    if entries.is_empty() {
        return Ok((placed, notes));
    }
    for kind in [SectionKind::NodeCoordinates, SectionKind::SurfaceBasis] {
        file.section(kind).ok_or(FileError::Missing { kind })?;
    }
    let coordinates = numbers(file, SectionKind::NodeCoordinates)?;
    let metadata = file.metadata();
    let whole = file.section(SectionKind::InteriorBasis).is_some();
    let shown = if whole { metadata.n_nodes } else { metadata.n_surface_nodes } as usize;
    for entry in entries {
        if built.contains(&entry.name) {
            return Err(StudyError::ProbeTwice { name: entry.name.clone() });
        }
        let square = |at: &[f64; 3]| (0..3).map(|c| (at[c] - entry.point[c]).powi(2)).sum::<f64>();
        let nodes = coordinates.as_chunks::<3>().0.iter().take(shown).enumerate();
        let nearest = nodes.min_by(|a, b| square(a.1).total_cmp(&square(b.1)));
        let (node, at) = nearest.ok_or(FileError::Missing { kind: SectionKind::NodeCoordinates })?;
        let (distance, size) = (square(at).sqrt(), at.iter().fold(0.0, |size: f64, x| size.max(x.abs())));
        if distance > FAR * size {
            let [x, y, z] = at;
            notes.push(format!(
                "probe `{}` looks at the nearest node, ({x:.6}, {y:.6}, {z:.6}), {distance:.3e} away from the point given",
                entry.name
            ));
        }
        let length = entry.direction.iter().map(|c| c * c).sum::<f64>().sqrt();
        placed.push(PlacedProbe { node, direction: entry.direction.map(|c| c / length), position: *at });
    }
    Ok((placed, notes))
}
