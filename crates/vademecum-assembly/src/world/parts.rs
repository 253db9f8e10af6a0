//! Parts of a world: bodies of files and rigid bodies, read and bound.

use vademecum_build::mesh::read_surface;
use vademecum_eval::{Body, BodyOptions, Lead, MAX_CONTACTS, Member, RigidBody, RigidMotion, RigidShape};
use vademecum_format::{File, PortKind, PortRange, SectionKind};

use crate::entries::RigidEntry;
use crate::error::AssemblyError;
use crate::file::{AssemblyFile, PartEntry};
use crate::source::read_part;
use crate::world::block::block;
use crate::world::error::WorldRunError;
use crate::world::mass::{is_closed, solid};
use vademecum_eval::Pose;

/// Files that are members of a world.
const EXPECTED: &str =
    "a linear body with exact steps, no live stiffness of a region, and no dashpots that couple modes";

/// A part as it was read.
#[derive(Clone)]
pub(crate) enum Source {
    /// The bytes of a file, unpacked.
    File(Vec<u8>),
    /// A rigid body.
    Rigid(Shell),
}

/// A rigid body: its surface, and its mass if it moves.
#[derive(Clone)]
pub(crate) struct Shell {
    pub nodes: Vec<[f64; 3]>,
    pub triangles: Vec<[u32; 3]>,
    pub body: Option<RigidBody>,
}

/// Reads part `i`.
pub(crate) fn read(file: &AssemblyFile, i: usize) -> Result<Source, WorldRunError> {
    let entry = &file.parts[i];
    match &entry.rigid {
        None => read_file(file, i).map(Source::File),
        Some(rigid) => shell(file, entry, rigid).map(Source::Rigid),
    }
}

fn read_file(file: &AssemblyFile, i: usize) -> Result<Vec<u8>, WorldRunError> {
    let part = file.parts[i].name.clone();
    let bytes = read_part(file, i)?;
    let opened = File::parse(&bytes).map_err(AssemblyError::from)?;
    let metadata = opened.metadata();
    let kind =
        |found: &str| AssemblyError::Kind { part: part.clone(), found: found.into(), expected: EXPECTED };
    if opened.section(SectionKind::StrainSizes).is_some() {
        return Err(kind("is one of large displacements").into());
    }
    if !metadata.diagonal || !metadata.scheme.is_exact() {
        return Err(kind("has no natural modes that are moved exactly").into());
    }
    if opened.section(SectionKind::DampingRows).is_some() {
        return Err(kind("has dashpots that couple its modes").into());
    }
    for kind in [SectionKind::NodeCoordinates, SectionKind::Triangles, SectionKind::SurfaceBasis] {
        if opened.section(kind).is_none() {
            return Err(AssemblyError::Missing { part, kind }.into());
        }
    }
    Ok(bytes)
}

fn shell(file: &AssemblyFile, entry: &PartEntry, rigid: &RigidEntry) -> Result<Shell, WorldRunError> {
    let (nodes, triangles) = match (&rigid.surface, rigid.block) {
        (Some(path), _) => {
            let read = read_surface(&file.folder.join(path), rigid.scale);
            let surface =
                read.map_err(|source| WorldRunError::Surface { part: entry.name.clone(), source })?;
            (surface.nodes, surface.triangles)
        }
        (None, shape) => block(shape.map_or([1.0; 3], |shape| shape.lengths)),
    };
    let body = match rigid.density {
        None => None,
        Some(density) => {
            let body = if is_closed(&triangles) { solid(&nodes, &triangles, density) } else { None };
            let key = format!("part[{}].rigid", entry.entry);
            let expected = "a closed surface around a body that has a density";
            let found = format!("{} triangles that enclose nothing", triangles.len());
            Some(body.ok_or_else(|| file.refuse(&key, found, expected))?)
        }
    };
    Ok(Shell { nodes, triangles, body })
}

/// Options of the bodies of a world.
pub(crate) fn body_options(time_step: f64, contacts: usize) -> BodyOptions {
    let mut options = BodyOptions::default();
    options.scene.time_step = Some(time_step);
    options.scene.contacts = contacts.min(MAX_CONTACTS);
    options
}

/// A part that is bound, and the ground behind the parts.
pub(crate) enum Bound<'m> {
    /// A body of a file, and its placement if it is held.
    Elastic(Box<Body<'m, f64>>, Pose),
    /// A rigid body.
    Rigid(Box<RigidShape<'m>>),
}

impl<'m> Bound<'m> {
    /// Binds a part to memory.
    pub fn new(
        file: &AssemblyFile,
        i: usize,
        (source, opened): (&'m Source, Option<&File<'m>>),
        options: &BodyOptions,
        memory: &'m mut [f64],
    ) -> Result<Self, WorldRunError> {
        let entry = &file.parts[i];
        let part = || entry.name.clone();
        let stand = Pose::new(entry.position, entry.rotation);
        let key = |name: &str| format!("part[{}].{name}", entry.entry);
        let far = || file.refuse(&key("position"), "too large", "smaller numbers");
        if let Source::Rigid(Shell { nodes, triangles, body }) = source {
            let shape = match body {
                None => RigidShape::led(nodes, triangles, stand),
                Some(body) => RigidShape::moving(nodes, triangles, *body, start(entry, body)),
            };
            return Ok(Self::Rigid(Box::new(shape.ok_or_else(far)?)));
        }
        let opened = opened.expect("a part of a file is opened");
        let bind = |source| WorldRunError::Bind { part: part(), source };
        let mut body = Body::bind(opened, options, memory).map_err(bind)?;
        match body.rigid_body() {
            Some(rigid) => {
                body.set_motion(start(entry, &rigid)).ok_or_else(far)?;
                for (name, given) in [("path", entry.path.is_some()), ("shake", entry.shake.is_some())] {
                    if given {
                        let expected = "a part that its supports hold: this one moves freely";
                        return Err(file.refuse(&key(name), "given", expected).into());
                    }
                }
            }
            None => {
                for (name, value) in [("velocity", entry.velocity), ("spin", entry.spin)] {
                    if value.is_some() {
                        let expected = "a part that moves freely: this one is held by its supports";
                        return Err(file.refuse(&key(name), "given", expected).into());
                    }
                }
            }
        }
        Ok(Self::Elastic(Box::new(body), stand))
    }

    /// It as a member of a world.
    pub fn member<'w>(&'w mut self) -> Member<'w, 'm, f64> {
        match self {
            Self::Elastic(body, stand) => {
                if body.motion().is_some() {
                    Member::Free(body)
                } else {
                    Member::Held(body, *stand)
                }
            }
            Self::Rigid(shape) => Member::Rigid(shape),
        }
    }
}

impl PartEntry {
    /// Its way over time; `None` of a part that stands or moves freely.
    pub(crate) fn way(&self) -> Option<Lead<'_>> {
        let led = self.path.is_some() || self.shake.is_some();
        let (amplitude, frequency, ramp) =
            self.shake.map_or(([0.0; 3], 0.0, 0.0), |shake| (shake.amplitude, shake.frequency, shake.ramp));
        let stops = self.path.as_deref().unwrap_or_default();
        led.then_some(Lead { stops, amplitude, frequency, ramp })
    }
}

/// Motion of a part at the start.
fn start(entry: &PartEntry, body: &RigidBody) -> RigidMotion {
    let mut motion = RigidMotion {
        position: Pose::new(entry.position, entry.rotation).place(body.centre),
        attitude: entry.rotation,
        momentum: entry.velocity.unwrap_or_default().map(|v| body.mass * v),
        angular_momentum: [0.0; 3],
    };
    let spin = motion.to_body(entry.spin.unwrap_or_default());
    motion.angular_momentum = motion.to_space(body.angular_momentum_of(spin));
    motion
}

/// Surface of a part at rest, in its own coordinates.
pub(crate) struct Shape {
    pub nodes: Vec<[f64; 3]>,
    pub triangles: Vec<[u32; 3]>,
}

impl Shape {
    /// Of a part.
    pub fn of(source: &Source, opened: Option<&File<'_>>) -> Result<Self, AssemblyError> {
        let opened = match (source, opened) {
            (Source::Rigid(shell), _) => {
                return Ok(Self { nodes: shell.nodes.clone(), triangles: shell.triangles.clone() });
            }
            (Source::File(_), opened) => opened.expect("a part of a file is opened"),
        };
        let section = |kind| opened.section(kind).expect("was looked for");
        let coordinates = section(SectionKind::NodeCoordinates).numbers()?;
        let count = opened.metadata().n_surface_nodes as usize;
        let numbers: Vec<f64> = coordinates.iter().take(3 * count).collect();
        let nodes = numbers.as_chunks::<3>().0.to_vec();
        let triangles = section(SectionKind::Triangles).u32s()?.as_chunks::<3>().0;
        Ok(Self { nodes, triangles: triangles.iter().map(|t| t.map(u32::from_le_bytes)).collect() })
    }
}

/// A port of a part.
pub(crate) struct PortAt {
    pub name: String,
    pub kind: PortKind,
    /// Origin and three axes of a frame.
    pub frame: [[f64; 3]; 4],
}

/// Ports of a file.
pub(crate) fn ports(opened: &File<'_>) -> Result<Vec<PortAt>, AssemblyError> {
    let Some(names) = opened.section(SectionKind::PortNames) else { return Ok(vec![]) };
    let frames = opened.section(SectionKind::PortFrames).map(|section| section.numbers()).transpose()?;
    let numbers: Vec<f64> = frames.iter().flat_map(|frames| frames.iter()).collect();
    let ranges = opened.port_table()?.iter().filter_map(PortRange::of);
    let each = names.text()?.split('\n').zip(ranges).zip(numbers.as_chunks::<12>().0);
    let port = |((name, range), frame): ((&str, PortRange), &[f64; 12])| PortAt {
        name: name.into(),
        kind: range.kind,
        frame: std::array::from_fn(|row| std::array::from_fn(|k| frame[3 * row + k])),
    };
    Ok(each.map(port).collect())
}
