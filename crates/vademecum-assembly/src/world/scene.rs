//! A world as a page takes it: files, and everything else as numbers.

use serde::Serialize;
use vademecum_build::progress::Listener;
use vademecum_eval::{Anchor, JointKind, Nodes, RigidBody, Touching, WorldJoint};

use crate::file::{AssemblyFile, GROUND, PartEntry};
use crate::world::error::WorldRunError;
use crate::world::parts::{Source, ports};
use crate::world::simulation::WorldSimulation;

/// A world as a page takes it.
#[derive(Clone, Debug, Serialize)]
pub struct WorldScene {
    /// Line for people.
    pub title: String,
    /// Step \[s\].
    pub step: f64,
    /// Acceleration of gravity \[m/s²\].
    pub gravity: [f64; 3],
    /// Distance up to which nodes and triangles are paired \[m\]; None: that of the evaluator.
    pub reach: Option<f64>,
    /// Largest change in the last sweep \[m\]; None: that of the evaluator.
    pub tolerance: Option<f64>,
    /// Most sweeps of a step.
    pub sweeps: usize,
    /// Contacts for which there is room.
    pub contacts: usize,
    /// Members: the parts, and the ground behind them where a joint holds it.
    pub members: Vec<SceneMember>,
    /// Pairs: numbers of the two members, friction, restitution, and whose nodes (0 both, 1 first, 2 second).
    pub pairs: Vec<(usize, usize, f64, f64, u8)>,
    /// Joints.
    pub joints: Vec<SceneJoint>,
    /// Bytes of the files, each once.
    #[serde(skip)]
    pub files: Vec<Vec<u8>>,
}

/// A member of a scene.
#[derive(Clone, Debug, Serialize)]
pub struct SceneMember {
    /// Its name.
    pub name: String,
    /// Number of its file; None of a rigid body.
    pub file: Option<usize>,
    /// Surface of a rigid body.
    pub nodes: Vec<[f64; 3]>,
    /// Triangles of that surface.
    pub triangles: Vec<[u32; 3]>,
    /// Mass, centre, moments and axes of a rigid body that moves, one after the other.
    pub mass: Option<Vec<f64>>,
    /// Position, quaternion, velocity and angular velocity at the start, one after the other.
    pub start: Vec<f64>,
    /// Stops of a member that is led.
    pub stops: Option<Vec<[f64; 4]>>,
    /// Amplitude, frequency and ramp of its shake, one after the other.
    pub shake: Vec<f64>,
}

/// A joint of a scene.
#[derive(Clone, Debug, Serialize)]
pub struct SceneJoint {
    /// Its name.
    pub name: String,
    /// 0 ball, 1 hinge, 2 slider, 3 cable.
    pub kind: u8,
    /// Numbers of the two members.
    pub members: [usize; 2],
    /// Compliance, force at which it breaks (below 0 for none), length of a cable; for each side the number
    /// of a port, or −1, point and axes.
    pub numbers: Vec<f64>,
    /// Where it is on each member, in its coordinates \[m\].
    pub points: [[f64; 3]; 2],
}

/// The world of an assembly file for a page. It is set up here once, so that what cannot be shown is refused.
///
/// # Errors
/// [`WorldRunError`].
pub fn world_scene(file: &AssemblyFile, listener: &dyn Listener) -> Result<WorldScene, WorldRunError> {
    listener.stage("read the parts");
    let world = WorldSimulation::open(file.clone())?;
    world.with_bonds(|pairs, joints| scene(&world, pairs, joints))
}

fn scene(
    world: &WorldSimulation,
    pairs: &[Touching],
    joints: &[WorldJoint],
) -> Result<WorldScene, WorldRunError> {
    let (file, sources) = (world.file(), world.sources());
    let entry = file.world.expect("a world");
    let mut files: Vec<Vec<u8>> = vec![];
    let mut all = vec![];
    for (part, source) in file.parts.iter().zip(sources) {
        all.push(member(part, source, &mut files));
    }
    if file.joints.iter().any(|joint| joint.between[1] == GROUND) {
        all.push(SceneMember { start: start(None), ..empty("ground") });
    }
    let points = |member: usize, anchor: &Anchor| -> Result<[f64; 3], WorldRunError> {
        match anchor {
            Anchor::Point { at, .. } => Ok(*at),
            Anchor::Frame(port) => {
                let opened = sources.get(member).map(Source::open).transpose()?.flatten();
                let Some(opened) = opened else { return Ok([0.0; 3]) };
                let ports = ports(&opened)?;
                Ok(ports.get(*port).map_or([0.0; 3], |port| port.frame[0]))
            }
            Anchor::Place(_) => Ok([0.0; 3]),
        }
    };
    let mut bonds = vec![];
    for (i, joint) in joints.iter().enumerate() {
        let [a, b] = &joint.anchors;
        let points = [points(joint.members[0], a)?, points(joint.members[1], b)?];
        bonds.push(bond(file.joints[i].name(i), joint, points));
    }
    Ok(WorldScene {
        title: file.title.clone(),
        step: world.time_step(),
        gravity: entry.gravity,
        reach: entry.reach,
        tolerance: entry.tolerance,
        sweeps: entry.sweeps,
        contacts: entry.contacts,
        members: all,
        pairs: pairs.iter().map(pair).collect(),
        joints: bonds,
        files,
    })
}

fn empty(name: &str) -> SceneMember {
    SceneMember {
        name: name.into(),
        file: None,
        nodes: vec![],
        triangles: vec![],
        mass: None,
        start: vec![],
        stops: None,
        shake: vec![],
    }
}

fn start(part: Option<&PartEntry>) -> Vec<f64> {
    let still = ([0.0; 3], [1.0, 0.0, 0.0, 0.0], [0.0; 3], [0.0; 3]);
    let (position, rotation, velocity, spin) = part.map_or(still, |part| {
        (part.position, part.rotation, part.velocity.unwrap_or_default(), part.spin.unwrap_or_default())
    });
    position.into_iter().chain(rotation).chain(velocity).chain(spin).collect()
}

fn member(part: &PartEntry, source: &Source, files: &mut Vec<Vec<u8>>) -> SceneMember {
    let way = part.way();
    let of_part = SceneMember {
        start: start(Some(part)),
        stops: way.map(|way| way.stops.to_vec()),
        shake: way.map_or(vec![], |way| way.amplitude.into_iter().chain([way.frequency, way.ramp]).collect()),
        ..empty(&part.name)
    };
    match source {
        Source::File(bytes, _) => {
            let bytes = (**bytes).as_ref();
            let number = files.iter().position(|known| known == bytes).unwrap_or_else(|| {
                files.push(bytes.to_vec());
                files.len() - 1
            });
            SceneMember { file: Some(number), ..of_part }
        }
        Source::Rigid(shell) => SceneMember {
            nodes: shell.nodes.clone(),
            triangles: shell.triangles.clone(),
            mass: shell.body.as_ref().map(mass),
            ..of_part
        },
    }
}

fn mass(body: &RigidBody) -> Vec<f64> {
    let axes = body.axes.into_iter().flatten();
    [body.mass].into_iter().chain(body.centre).chain(body.moments).chain(axes).collect()
}

fn pair(pair: &Touching) -> (usize, usize, f64, f64, u8) {
    let nodes = match pair.nodes {
        Nodes::Both => 0,
        Nodes::First => 1,
        Nodes::Second => 2,
    };
    (pair.members[0], pair.members[1], pair.friction, pair.restitution, nodes)
}

fn bond(name: String, joint: &WorldJoint, points: [[f64; 3]; 2]) -> SceneJoint {
    let (kind, length) = match joint.kind {
        JointKind::Ball => (0, 0.0),
        JointKind::Hinge => (1, 0.0),
        JointKind::Slider => (2, 0.0),
        JointKind::Cable { length } => (3, length),
    };
    let breaks_at = if joint.breaks_at.is_finite() { joint.breaks_at } else { -1.0 };
    let mut numbers = vec![joint.compliance, breaks_at, length];
    for anchor in &joint.anchors {
        let first = numbers.len();
        match anchor {
            Anchor::Frame(port) => numbers.push(*port as f64),
            Anchor::Point { at, axes } => {
                numbers.push(-1.0);
                numbers.extend(at.iter().chain(axes.as_flattened()));
            }
            Anchor::Place(_) => {}
        }
        numbers.resize(first + 13, 0.0);
    }
    SceneJoint { name, kind, members: joint.members, numbers, points }
}
