//! Probes that a scenario brings along: components of the motion that the file was not built with, read at
//! its nodes or anywhere on its surface.

use vademecum_eval::{Field, Surface, SurfacePoint};
use vademecum_format::{Codec, File, SectionKind};

use crate::contents::numbers;
use crate::error::{FileError, StudyError};
use crate::near::{FAR, reach, within};
use crate::player::Playable;
use crate::scenario::{OutputProbe, ProbePlace, ProbeQuantity};

/// A probe of a scenario.
pub(crate) struct PlacedProbe {
    at: Site,
    direction: [f64; 3],
    quantity: ProbeQuantity,
    /// Its position at rest.
    pub(crate) position: [f64; 3],
}

/// Place of a probe.
enum Site {
    /// A node of the file.
    Node(usize),
    /// A point of the loadable surface, and true where the static answer of the whole body is known there.
    Surface(SurfacePoint, bool),
}

impl PlacedProbe {
    /// Unit of its values.
    pub(crate) fn unit(&self) -> &'static str {
        match self.quantity {
            ProbeQuantity::Displacement => "m",
            ProbeQuantity::Velocity => "m/s",
            ProbeQuantity::Acceleration => "m/s²",
        }
    }

    /// True if it reads the displacement of the whole surface.
    fn reads_surface(&self) -> bool {
        self.quantity == ProbeQuantity::Displacement && matches!(self.at, Site::Surface(_, true))
    }

    /// Displacement of its place \[m\], without the static answer away from contacts.
    pub(crate) fn displacement(&self, body: &dyn Playable<Number = f64>) -> Result<[f64; 3], FileError> {
        self.motion(body, Field::Displacement)
    }

    fn motion(&self, body: &dyn Playable<Number = f64>, field: Field) -> Result<[f64; 3], FileError> {
        match &self.at {
            Site::Node(node) => body.node(*node, field),
            Site::Surface(point, _) => body.point(point, field),
        }
    }
}

/// The probes of a scenario over a run.
pub(crate) struct ProbeReader<'a> {
    probes: &'a [PlacedProbe],
    time_step: f64,
    /// Displacement of the whole surface with its static answer; empty if no probe reads it.
    surface: Vec<f64>,
    /// Velocity of each at the end of the step, and its mean acceleration over the step.
    velocities: Vec<[f64; 2]>,
    started: bool,
}

impl<'a> ProbeReader<'a> {
    pub(crate) fn new(probes: &'a [PlacedProbe], n_surface_nodes: usize, time_step: f64) -> Self {
        let surface = if probes.iter().any(PlacedProbe::reads_surface) { 3 * n_surface_nodes } else { 0 };
        let velocities = vec![[0.0; 2]; probes.len()];
        Self { probes, time_step, surface: vec![0.0; surface], velocities, started: false }
    }

    /// Follows the velocities of a body; once for each step.
    pub(crate) fn follow(&mut self, body: &dyn Playable<Number = f64>) -> Result<(), FileError> {
        for (probe, [velocity, acceleration]) in self.probes.iter().zip(&mut self.velocities) {
            if probe.quantity == ProbeQuantity::Acceleration {
                let now = dot(probe.motion(body, Field::Velocity)?, probe.direction);
                *acceleration = if self.started { (now - *velocity) / self.time_step } else { 0.0 };
                *velocity = now;
            }
        }
        self.started = true;
        Ok(())
    }

    /// The values of all probes after a step that was followed.
    pub(crate) fn read(
        &mut self,
        body: &mut dyn Playable<Number = f64>,
        values: &mut [f64],
    ) -> Result<(), FileError> {
        if !self.surface.is_empty() {
            body.surface_into(Field::Displacement, &mut self.surface)?;
        }
        for ((probe, followed), value) in self.probes.iter().zip(&self.velocities).zip(values) {
            let moved = match (&probe.at, probe.quantity) {
                (_, ProbeQuantity::Acceleration) => {
                    *value = followed[1];
                    continue;
                }
                (_, ProbeQuantity::Velocity) => probe.motion(body, Field::Velocity)?,
                (Site::Surface(point, true), _) => {
                    let nodes = self.surface.as_chunks::<3>().0;
                    let of =
                        |c: usize| point.place.entries().map(|(node, w)| w * nodes[node as usize][c]).sum();
                    std::array::from_fn(of)
                }
                _ => probe.displacement(body)?,
            };
            *value = dot(moved, probe.direction);
        }
        Ok(())
    }
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// The probes of a scenario, each at its place on the file, and what is to tell of them.
///
/// # Errors
/// [`StudyError::ProbeTwice`]: a name that one of the file's own probes, `built`, has;
/// [`FileError::Missing`]: a file stripped of its nodes or their motion; [`StudyError::FarPoint`].
pub(crate) fn place(
    file: &File<'_>,
    entries: &[OutputProbe],
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
    let nodes = coordinates.as_chunks::<3>().0;
    for entry in entries {
        if built.contains(&entry.name) {
            return Err(StudyError::ProbeTwice { name: entry.name.clone() });
        }
        let (at, position) = match entry.at {
            ProbePlace::Node => on_node(file, entry, nodes, &mut notes)?,
            ProbePlace::Surface => on_surface(file, entry, &mut notes)?,
        };
        let length = dot(entry.direction, entry.direction).sqrt();
        let direction = entry.direction.map(|c| c / length);
        placed.push(PlacedProbe { at, direction, quantity: entry.quantity, position });
    }
    Ok((placed, notes))
}

/// The nearest node that a file can show, and where it is.
fn on_node(
    file: &File<'_>,
    entry: &OutputProbe,
    nodes: &[[f64; 3]],
    notes: &mut Vec<String>,
) -> Result<(Site, [f64; 3]), StudyError> {
    let metadata = file.metadata();
    let whole = file.section(SectionKind::InteriorBasis).is_some();
    let shown = if whole { metadata.n_nodes } else { metadata.n_surface_nodes } as usize;
    let square = |at: &[f64; 3]| (0..3).map(|c| (at[c] - entry.point[c]).powi(2)).sum::<f64>();
    let nearest = nodes.iter().take(shown).enumerate().min_by(|a, b| square(a.1).total_cmp(&square(b.1)));
    let (node, at) = nearest.ok_or(FileError::Missing { kind: SectionKind::NodeCoordinates })?;
    let (distance, size) = (square(at).sqrt(), at.iter().fold(0.0, |size: f64, x| size.max(x.abs())));
    if distance > FAR * size {
        let [x, y, z] = at;
        notes.push(format!(
            "probe `{}` looks at the nearest node, ({x:.6}, {y:.6}, {z:.6}), {distance:.3e} away from the point given; \
             `at = \"surface\"` takes the point of the surface itself",
            entry.name
        ));
    }
    Ok((Site::Node(node), *at))
}

/// The nearest point of the loadable surface, and where it is.
fn on_surface(
    file: &File<'_>,
    entry: &OutputProbe,
    notes: &mut Vec<String>,
) -> Result<(Site, [f64; 3]), StudyError> {
    vademecum_rewrite::check_coordinates(file)?;
    let found = Surface::new(file).map_err(FileError::from)?.locate(entry.point);
    let found = found.ok_or(FileError::NoSurface)?;
    let found = within(file, reach(file)?, found, || format!("probe `{}`", entry.name))?;
    let size = found.position.iter().fold(0.0, |size: f64, x| size.max(x.abs()));
    if found.distance > FAR * size {
        let [x, y, z] = found.position;
        notes.push(format!(
            "probe `{}` looks at the nearest point of the loadable surface, ({x:.6}, {y:.6}, {z:.6}), {:.3e} away from \
             the point given",
            entry.name, found.distance
        ));
    }
    let kind = SectionKind::FactorValues;
    let solved = file.section(kind).is_some_and(|factor| factor.codec() == Codec::Raw);
    if !solved && entry.quantity == ProbeQuantity::Displacement {
        notes.push(format!(
            "probe `{}` has no residual flexibility where no contact acts: the file has no factor of its stiffness; \
             build it with `static_fields = true`, or name the probe in the problem file",
            entry.name
        ));
    }
    Ok((Site::Surface(found, solved), found.position))
}
