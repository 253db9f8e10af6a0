//! Parts of a world: bodies of files and rigid bodies, read and bound.

use vademecum_build::mesh::read_surface;
use vademecum_eval::{
    Body, BodyOptions, Lead, MAX_CONTACTS, Member, Pose, RigidBody, RigidMotion, RigidShape, SceneOptions,
};
use vademecum_format::{File, PortKind, PortRange, SectionKind};

use crate::entries::{LARGEST, RigidEntry};
use crate::error::AssemblyError;
use crate::file::{AssemblyFile, PartEntry};
use crate::source::read_part;
use crate::world::block::block;
use crate::world::error::WorldRunError;
use crate::world::mass::{is_closed, solid};

/// Files that are members of a world.
const EXPECTED: &str =
    "a linear body with exact steps, no live stiffness of a region, and no dashpots that couple modes";

/// Bytes of a file, owned by a world or shared.
pub type PartBytes = Box<dyn AsRef<[u8]> + Send + Sync>;

/// A part that is at hand, in place of the files that its entry names.
pub enum GivenPart {
    /// The file or surface that the entry names.
    Named,
    /// Bytes of a vademecum file, unpacked, and options and live parameters of its body. Step and room for
    /// contacts are those of the world.
    File(PartBytes, SceneOptions),
    /// Nodes \[m\] and triangles of the surface of a rigid body, counterclockwise from outside.
    Surface(Vec<[f64; 3]>, Vec<[u32; 3]>),
}

/// A part as it was read.
pub(crate) enum Source {
    /// The bytes of a file, unpacked, and options of its body.
    File(PartBytes, SceneOptions),
    /// A rigid body.
    Rigid(Shell),
}

impl Source {
    /// The file of a body; none of a rigid one.
    pub fn open(&self) -> Result<Option<File<'_>>, AssemblyError> {
        match self {
            Self::Rigid(_) => Ok(None),
            Self::File(bytes, _) => Ok(Some(File::parse((**bytes).as_ref())?)),
        }
    }

    /// Options of the body of a file in a world.
    pub fn options(&self, time_step: f64, contacts: usize) -> BodyOptions {
        let scene = match self {
            Self::File(_, scene) => *scene,
            Self::Rigid(_) => SceneOptions::default(),
        };
        let contacts = contacts.min(MAX_CONTACTS);
        let scene = SceneOptions { time_step: Some(time_step), contacts, ..scene };
        BodyOptions { scene, ..BodyOptions::default() }
    }
}

/// A rigid body: its surface, and its mass if it moves.
pub(crate) struct Shell {
    pub nodes: Vec<[f64; 3]>,
    pub triangles: Vec<[u32; 3]>,
    pub body: Option<RigidBody>,
}

/// Reads part `i`, or takes what is at hand.
pub(crate) fn read(file: &AssemblyFile, i: usize, given: GivenPart) -> Result<Source, WorldRunError> {
    let entry = &file.parts[i];
    let source = match (given, &entry.rigid) {
        (GivenPart::File(bytes, options), _) => Source::File(bytes, options),
        (GivenPart::Surface(nodes, triangles), rigid) => {
            let known = triangles.as_flattened().iter().all(|&node| (node as usize) < nodes.len());
            if !known || !nodes.as_flattened().iter().all(|x| x.abs() <= LARGEST) {
                let expected = "finite nodes, and triangles of nodes that there are";
                return Err(file
                    .refuse(&format!("part[{}].rigid", entry.entry), "another surface", expected)
                    .into());
            }
            let density = rigid.as_ref().and_then(|rigid| rigid.density);
            return shell(file, (nodes, triangles), density, entry).map(Source::Rigid);
        }
        (GivenPart::Named, Some(rigid)) => {
            return shell(file, surface(file, entry, rigid)?, rigid.density, entry).map(Source::Rigid);
        }
        (GivenPart::Named, None) => Source::File(Box::new(read_part(file, i)?), SceneOptions::default()),
    };
    if let Some(opened) = source.open()? {
        check(&entry.name, &opened)?;
    }
    Ok(source)
}

/// Refuses a file that is no member of a world.
fn check(part: &str, opened: &File<'_>) -> Result<(), AssemblyError> {
    let part = part.to_string();
    let metadata = opened.metadata();
    let kind =
        |found: &str| AssemblyError::Kind { part: part.clone(), found: found.into(), expected: EXPECTED };
    if opened.section(SectionKind::StrainSizes).is_some() {
        return Err(kind("is one of large displacements"));
    }
    if !metadata.diagonal || !metadata.scheme.is_exact() {
        return Err(kind("has no natural modes that are moved exactly"));
    }
    if opened.section(SectionKind::DampingRows).is_some() {
        return Err(kind("has dashpots that couple its modes"));
    }
    for kind in [SectionKind::NodeCoordinates, SectionKind::Triangles, SectionKind::SurfaceBasis] {
        if opened.section(kind).is_none() {
            return Err(AssemblyError::Missing { part, kind });
        }
    }
    Ok(())
}

/// Nodes and triangles of a surface.
type SurfaceArrays = (Vec<[f64; 3]>, Vec<[u32; 3]>);

/// The surface that the entry of a rigid body names.
fn surface(
    file: &AssemblyFile,
    entry: &PartEntry,
    rigid: &RigidEntry,
) -> Result<SurfaceArrays, WorldRunError> {
    Ok(match (&rigid.surface, rigid.block) {
        (Some(path), _) => {
            let read = read_surface(&file.folder.join(path), rigid.scale);
            let surface =
                read.map_err(|source| WorldRunError::Surface { part: entry.name.clone(), source })?;
            (surface.nodes, surface.triangles)
        }
        (None, shape) => block(shape.map_or([1.0; 3], |shape| shape.lengths)),
    })
}

fn shell(
    file: &AssemblyFile,
    (nodes, triangles): SurfaceArrays,
    density: Option<f64>,
    entry: &PartEntry,
) -> Result<Shell, WorldRunError> {
    let body = match density {
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
        source: &'m Source,
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
        let opened = source.open()?.expect("a part of a file");
        let bind = |source| WorldRunError::Bind { part: part(), source };
        let mut body = Body::bind(&opened, options, memory).map_err(bind)?;
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

    /// Placement of a part that is held.
    pub fn stand(&self) -> Option<Pose> {
        match self {
            Self::Elastic(body, stand) if body.motion().is_none() => Some(*stand),
            _ => None,
        }
    }

    /// Sets the placement of a part that is held.
    pub fn set_stand(&mut self, pose: Pose) {
        if let Self::Elastic(_, stand) = self {
            *stand = pose;
        }
    }

    /// Puts a held part elsewhere, or leads a rigid body without a mass there; `None` of any other part, and
    /// if a number is not finite.
    pub fn lead(&mut self, pose: Pose) -> Option<()> {
        match self {
            Self::Elastic(body, _) if body.motion().is_some() || !pose.is_sound() => None,
            Self::Elastic(_, stand) => {
                *stand = pose;
                Some(())
            }
            Self::Rigid(shape) => {
                if shape.body().is_none() {
                    shape.lead(pose)
                } else {
                    None
                }
            }
        }
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
#[derive(Clone, Debug)]
pub struct PartSurface {
    /// Nodes \[m\].
    pub nodes: Vec<[f64; 3]>,
    /// Triangles, counterclockwise from outside.
    pub triangles: Vec<[u32; 3]>,
}

impl PartSurface {
    /// Of a part.
    pub(crate) fn of(source: &Source, opened: Option<&File<'_>>) -> Result<Self, AssemblyError> {
        let opened = match (source, opened) {
            (Source::Rigid(shell), _) => {
                return Ok(Self { nodes: shell.nodes.clone(), triangles: shell.triangles.clone() });
            }
            (Source::File(..), opened) => opened.expect("a part of a file is opened"),
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
