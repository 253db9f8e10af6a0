//! A superelement of a vademecum file at its ports: the file has natural modes, and at its ports the residual
//! flexibility and its inertia, which are all that the methods of Rubin and MacNeal need.

use vademecum_build::Matrix;
use vademecum_build::input::InterfaceEntry;
use vademecum_build::linalg::vec3::{cross, sub};
use vademecum_build::prepared::{Coordinate, Interface, InterfaceRows};
use vademecum_build::superelement::{AtInterface, ByForces, Method, Superelement};
use vademecum_eval::{Part, PartFault, Pose, RigidBody};
use vademecum_format::{File, Numbers, PortKind, PortRange, SectionKind as S};

use super::body::ReducedBody;
use super::error::PortError;
use crate::error::{FileError, StudyError};

/// The numbers of a file at its ports.
struct Contents<'a> {
    file: File<'a>,
    rigid: Option<RigidBody>,
    /// Modes of the file, and those that are kept.
    all: usize,
    kept: usize,
    eigenvalues: Vec<f64>,
    surface_nodes: usize,
    /// Rows of all ports.
    rows: usize,
    places: Vec<[f64; 3]>,
}

/// A file at its ports, or those of these names, by Rubin's or MacNeal's method; `modes` of its modes, or
/// all. What the other ones answer statically joins the residual flexibility.
///
/// # Errors
/// [`StudyError::Ports`], [`StudyError::File`].
pub fn file_at_ports(
    file: File<'_>,
    entries: &[InterfaceEntry],
    method: Method,
    modes: Option<usize>,
) -> Result<ReducedBody, StudyError> {
    let weighed = match method {
        Method::Rubin => true,
        Method::Macneal => false,
        other => return Err(PortError::Method { method: other.word() }.into()),
    };
    let is_name = |entry: &&InterfaceEntry| entry.kind.is_none() && entry.on.is_none();
    if let Some(entry) = entries.iter().find(|entry| !is_name(entry)) {
        return Err(PortError::NotAPort { name: entry.name.clone() }.into());
    }
    let names: Vec<String> = entries.iter().map(|entry| entry.name.clone()).collect();
    let contents = Contents::new(file, modes)?;
    // Sections that fit one another.
    let part = Part::new("", file, Pose::at([0.0; 3])).map_err(PortError::from)?;
    let (interfaces, rows) = contents.interfaces(part.port_names(), &names)?;
    let m = rows.len();
    let compliance = contents.needed(S::PortCompliance)?;
    let inertia = contents.numbers(S::PortInertia)?;
    if weighed && inertia.is_none() {
        return Err(PortError::NoInertia.into());
    }
    let mode_rows = contents.needed(S::PortRows)?;
    let row = |i: usize, k: usize| value(mode_rows, rows[i] * contents.all + k);
    // Modes that are left out answer as if they had no mass, but for the inertia of that.
    let left_out = |i: usize, j: usize, power: i32| -> f64 {
        let of_mode = |k: usize| row(i, k) * row(j, k) / contents.eigenvalues[k].powi(power);
        (contents.kept..contents.all).map(of_mode).sum()
    };
    let at = |numbers, i: usize, j: usize| value(numbers, rows[i] * contents.rows + rows[j]);
    let flexibility = Matrix::from_fn(m, m, |i, j| at(compliance, i, j) + left_out(i, j, 1));
    let inertia = inertia
        .filter(|_| weighed)
        .map(|numbers| Matrix::from_fn(m, m, |i, j| at(numbers, i, j) + left_out(i, j, 2)));
    let first = contents.first();
    let rigid_rows = contents.rigid_rows(&interfaces);
    let modes = Matrix::from_fn(m, first + contents.kept, |i, k| match k.checked_sub(first) {
        None => rigid_rows[i][k],
        Some(mode) => row(i, mode),
    });
    let own = contents.eigenvalues[..contents.kept].iter().copied();
    let eigenvalues: Vec<f64> = std::iter::repeat_n(0.0, first).chain(own).collect();
    let at_interface = AtInterface {
        modes: modes.as_ref(),
        eigenvalues: &eigenvalues,
        flexibility: flexibility.as_ref(),
        inertia: inertia.as_ref().map(|inertia| inertia.as_ref()),
    };
    let reduced = at_interface.reduced().ok_or(PortError::Singular { coordinates: m })?;
    let damping = contents.damping(&reduced, m)?;
    let transformation = contents.transformation(&reduced, &rows)?;
    let rigid_motions = contents.rigid_motions(&interfaces, reduced.mass.nrows());
    let superelement = Superelement {
        method,
        interfaces,
        coordinates: m,
        frequencies_hz: eigenvalues[first..]
            .iter()
            .map(|value| value.sqrt() / std::f64::consts::TAU)
            .collect(),
        mass: reduced.mass,
        stiffness: reduced.stiffness,
        damping,
        transformation,
        rigid_motions,
        full_order: None,
    };
    contents.reduced_body(superelement)
}

/// A number; 0 beyond the end, which the sections of a checked part do not reach.
fn value(numbers: Numbers<'_>, index: usize) -> f64 {
    numbers.get(index).unwrap_or(0.0)
}

impl<'a> Contents<'a> {
    fn new(file: File<'a>, modes: Option<usize>) -> Result<Self, StudyError> {
        let metadata = *file.metadata();
        let all = metadata.n_modes as usize;
        let kept = modes.unwrap_or(all);
        if kept == 0 || kept > all {
            return Err(PortError::Modes { asked: kept, found: all }.into());
        }
        let rows = file.section(S::PortRows).map_or(0, |section| section.shape()[0] as usize);
        if rows == 0 {
            return Err(PortError::NoPorts.into());
        }
        let surface_nodes = metadata.n_surface_nodes as usize;
        let rigid = RigidBody::of(&file);
        let mut found =
            Self { file, rigid, all, kept, eigenvalues: vec![], surface_nodes, rows, places: vec![] };
        found.eigenvalues = found.needed(S::Eigenvalues)?.iter().collect();
        let coordinates = found.needed(S::NodeCoordinates)?;
        let place = |node: usize| std::array::from_fn(|c| value(coordinates, 3 * node + c));
        found.places = (0..surface_nodes).map(place).collect();
        Ok(found)
    }

    fn numbers(&self, kind: S) -> Result<Option<Numbers<'a>>, StudyError> {
        let read = self.file.section(kind).map(|section| section.numbers()).transpose();
        Ok(read.map_err(FileError::from)?)
    }

    fn needed(&self, kind: S) -> Result<Numbers<'a>, StudyError> {
        Ok(self.numbers(kind)?.ok_or(PortError::Fault(PartFault::Missing { kind }))?)
    }

    /// Rigid motions before the modes.
    fn first(&self) -> usize {
        if self.rigid.is_some() { 6 } else { 0 }
    }

    /// The ports of these names, all without any, and their rows in the file.
    fn interfaces(
        &self,
        ports: impl Iterator<Item = &'a str>,
        names: &[String],
    ) -> Result<(Vec<Interface>, Vec<usize>), StudyError> {
        let all: Vec<&str> = ports.collect();
        if let Some(name) = names.iter().find(|name| !all.contains(&name.as_str())) {
            let known = all.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ");
            return Err(PortError::Unknown { name: name.clone(), known }.into());
        }
        let wanted: Vec<usize> = match names {
            [] => (0..all.len()).collect(),
            names => names.iter().filter_map(|name| all.iter().position(|port| port == name)).collect(),
        };
        let table = self.file.port_table().map_err(FileError::from)?;
        let frames = self.needed(S::PortFrames)?;
        let nodes: Vec<u32> = match self.file.section(S::PortNodes) {
            Some(section) => {
                let bytes = section.u32s().map_err(FileError::from)?;
                bytes.iter().map(|bytes| u32::from_le_bytes(*bytes)).collect()
            }
            None => vec![],
        };
        let (mut interfaces, mut rows) = (vec![], vec![]);
        for place in wanted {
            let fault = PortError::Fault(PartFault::Disagrees { kind: S::PortTable });
            let range = table.get(place).and_then(PortRange::of).ok_or(fault)?;
            let own = nodes[range.nodes[0]..range.nodes[0] + range.nodes[1]].to_vec();
            let (kind, coordinates): (_, Vec<Coordinate>) = match range.kind {
                PortKind::Frame => {
                    ("frame", (0..6).map(|motion| Coordinate { node: None, motion }).collect())
                }
                PortKind::Patch => {
                    let of_node =
                        |&node: &u32| (0..3).map(move |motion| Coordinate { node: Some(node), motion });
                    ("patch", own.iter().flat_map(of_node).collect())
                }
            };
            let frame = |k: usize| value(frames, 12 * place + k);
            rows.extend(range.rows[0]..range.rows[0] + range.rows[1]);
            interfaces.push(Interface {
                name: all[place].into(),
                kind,
                weights: vec![1.0 / own.len().max(1) as f64; own.len()],
                nodes: own,
                origin: std::array::from_fn(frame),
                axes: std::array::from_fn(|a| std::array::from_fn(|c| frame(3 + 3 * a + c))),
                coordinates,
                rows: InterfaceRows::Means(vec![]),
            });
        }
        Ok((interfaces, rows))
    }

    /// Coordinates of interfaces under a motion: displacement of points, and rotation.
    fn moved(
        &self,
        interfaces: &[Interface],
        shift: impl Fn([f64; 3]) -> [f64; 3],
        turn: [f64; 3],
    ) -> Vec<f64> {
        let dot = |a: [f64; 3], b: [f64; 3]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let of = |interface: &Interface| -> Vec<f64> {
            let one = |own: &Coordinate| match own.node {
                Some(node) => shift(self.places[node as usize])[own.motion],
                None if own.motion < 3 => dot(interface.axes[own.motion], shift(interface.origin)),
                None => dot(interface.axes[own.motion - 3], turn),
            };
            interface.coordinates.iter().map(one).collect()
        };
        interfaces.iter().flat_map(of).collect()
    }

    /// The rigid motions of unit modal mass at the coordinates: along the axes of space, and about the
    /// principal axes of the body.
    fn rigid_rows(&self, interfaces: &[Interface]) -> Vec<[f64; 6]> {
        let Some(rigid) = &self.rigid else { return vec![[0.0; 6]; self.rows] };
        let columns: Vec<Vec<f64>> = (0..6)
            .map(|k| {
                let (along, turn) = unit_motion(rigid, k);
                self.moved(interfaces, |x| add(along, cross(turn, sub(x, rigid.centre))), turn)
            })
            .collect();
        (0..columns[0].len()).map(|i| std::array::from_fn(|k| columns[k][i])).collect()
    }

    /// All coordinates under three shifts along the axes of space and three turns about its origin.
    fn rigid_motions(&self, interfaces: &[Interface], size: usize) -> Option<Matrix> {
        let rigid = self.rigid.as_ref()?;
        let mut motions = Matrix::zeros(size, 6);
        for k in 0..6 {
            let unit = |c: usize| std::array::from_fn(|i| f64::from(u8::from(i == c)));
            let (along, turn) = if k < 3 { (unit(k), [0.0; 3]) } else { ([0.0; 3], unit(k - 3)) };
            let shift = |x: [f64; 3]| add(along, cross(turn, x));
            let own = self.moved(interfaces, shift, turn);
            let centre = shift(rigid.centre);
            let dot = |a: [f64; 3]| a.iter().zip(turn).map(|(a, b)| a * b).sum::<f64>();
            let rotation = (0..3).map(|a| rigid.moments[a].sqrt() * dot(rigid.axes[a]));
            let share = centre.iter().map(|u| rigid.mass.sqrt() * u).chain(rotation);
            for (i, q) in own.iter().copied().chain(share).enumerate() {
                motions[(i, k)] = q;
            }
        }
        Some(motions)
    }

    /// `α M + β K`, ratios of modes and dashpots.
    fn damping(&self, reduced: &ByForces, m: usize) -> Result<Matrix, StudyError> {
        let (metadata, r) = (self.file.metadata(), reduced.mass.nrows());
        let entry = |i: usize, k: usize| {
            metadata.alpha * reduced.mass[(i, k)] + metadata.beta * reduced.stiffness[(i, k)]
        };
        let mut damping = Matrix::from_fn(r, r, entry);
        let first = m + self.first();
        if let Some(ratios) = self.numbers(S::DampingRatios)? {
            for k in 0..self.kept {
                damping[(first + k, first + k)] += 2.0 * value(ratios, k) * self.eigenvalues[k].sqrt();
            }
        }
        if let Some(dashpots) = self.numbers(S::DampingRows)? {
            for row in 0..dashpots.len() / self.all {
                let of = |k: usize| value(dashpots, row * self.all + k);
                for i in 0..self.kept {
                    (0..self.kept).for_each(|k| damping[(first + i, first + k)] += of(i) * of(k));
                }
            }
        }
        Ok(damping)
    }

    /// `T` at the nodes of the surface.
    fn transformation(&self, reduced: &ByForces, rows: &[usize]) -> Result<Matrix, StudyError> {
        let (m, r, first) = (rows.len(), reduced.mass.nrows(), self.first());
        if self.surface_nodes == 0 {
            return Ok(Matrix::zeros(0, r));
        }
        let (surface, residual) = (self.needed(S::SurfaceBasis)?, self.needed(S::PortResidual)?);
        let mode_rows = self.needed(S::PortRows)?;
        let mode = |dof: usize, k: usize| value(surface, dof * self.all + k);
        // Answers to forces along the coordinates.
        let answers = Matrix::from_fn(3 * self.surface_nodes, m, |dof, i| {
            let left_out = (self.kept..self.all)
                .map(|k| mode(dof, k) * value(mode_rows, rows[i] * self.all + k) / self.eigenvalues[k]);
            value(residual, rows[i] * 3 * self.surface_nodes + dof) + left_out.sum::<f64>()
        });
        let moved = &answers * &reduced.forces;
        let of_mode = |dof: usize, k: usize| match k.checked_sub(first) {
            Some(k) => mode(dof, k),
            None => self.rigid.as_ref().map_or(0.0, |rigid| {
                let (along, turn) = unit_motion(rigid, k);
                add(along, cross(turn, sub(self.places[dof / 3], rigid.centre)))[dof % 3]
            }),
        };
        Ok(Matrix::from_fn(3 * self.surface_nodes, r, |dof, k| {
            moved[(dof, k)] + k.checked_sub(m).map_or(0.0, |k| of_mode(dof, k))
        }))
    }

    fn reduced_body(self, superelement: Superelement) -> Result<ReducedBody, StudyError> {
        let metadata = *self.file.metadata();
        let ids = match self.file.section(S::NodeIds) {
            Some(section) => {
                let bytes = section.u64s().map_err(FileError::from)?;
                bytes.iter().take(self.surface_nodes).map(|id| u64::from_le_bytes(*id)).collect()
            }
            None => (0..self.surface_nodes as u64).collect(),
        };
        let triangles = self.file.indices(S::Triangles).map_err(FileError::from)?.unwrap_or_default();
        let corners: Vec<u32> = triangles.iter().map(|bytes| u32::from_le_bytes(*bytes)).collect();
        Ok(ReducedBody {
            superelement,
            title: String::new(),
            units: metadata.units.into(),
            nodes: self.places,
            node_ids: ids,
            triangles: corners.as_chunks().0.to_vec(),
            rayleigh: [metadata.alpha, metadata.beta],
            dofs: None,
            model: None,
        })
    }
}

/// A rigid motion of unit modal mass: displacement of the centre and rotation.
fn unit_motion(rigid: &RigidBody, k: usize) -> ([f64; 3], [f64; 3]) {
    match k.checked_sub(3) {
        None => {
            let along = std::array::from_fn(|c| if c == k { 1.0 / rigid.mass.sqrt() } else { 0.0 });
            (along, [0.0; 3])
        }
        Some(axis) => ([0.0; 3], rigid.axes[axis].map(|a| a / rigid.moments[axis].sqrt())),
    }
}

fn add(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|c| a[c] + b[c])
}
