//! Bodies joined from vademecum files that were built apart.
//!
//! An [`AssemblyFile`] names parts and the joints between their ports; [`assemble`] reads the parts and joins
//! them by the evaluator's own synthesis (`vademecum_eval::Assembly`), which gives the bytes of one ordinary
//! vademecum file. Ports are patches and frames that `[[port]]` of a problem file names.

mod copies;
mod entries;
mod error;
mod file;
mod names;
mod refusal;
mod source;
mod world;

pub use entries::{BoxEntry, ContactEntry, NodesEntry, OutputEntry, RigidEntry, ShakeEntry, WorldEntry};
pub use error::AssemblyError;
pub use file::{AssemblyFile, JointEntry, JointKind, PartEntry};
pub use world::{
    GivenPart, PartBytes, PartPoint, PartSurface, SceneJoint, SceneMember, WorldPlan, WorldRow,
    WorldRunError, WorldRunOptions, WorldRunReport, WorldSavedError, WorldScene, WorldSimulation, WorldSink,
    run_world, world_scene,
};

use vademecum_build::mesh::{Mesh, hash};
use vademecum_eval::{Assembly, AssemblyOptions, End, Joint, Part, Pose};
use vademecum_format::{File, SectionKind};

use file::GROUND;
use refusal::{of_assembly, of_part};
use source::{hex, read_part};

/// A joined body.
#[derive(Debug)]
pub struct Assembled {
    /// The bytes of its file.
    pub bytes: Vec<u8>,
    /// Its parts and joints.
    pub report: AssemblyReport,
}

/// Report of a joined body.
#[derive(Clone, Debug, serde::Serialize)]
pub struct AssemblyReport {
    /// Line for people of the assembly file.
    pub title: String,
    /// Parts.
    pub parts: Vec<PartReport>,
    /// Joints.
    pub joints: Vec<JointReport>,
    /// Number of modes.
    pub modes: usize,
    /// The lowest natural frequencies \[Hz\], ten at most.
    pub frequencies_hz: Vec<f64>,
    /// `Rubin`, or `MacNeal` where a part has no inertia of what its modes leave out.
    pub synthesis: &'static str,
    /// Largest change of an answer at a natural frequency by damping that couples modes; 0 where none does.
    pub damping_coupling: f64,
    /// True if the file holds the damping that couples modes.
    pub damping_coupled: bool,
    /// Step \[s\].
    pub time_step: f64,
    /// Losses of the joined file against its parts.
    pub notes: Vec<String>,
}

/// A joint as a report names it.
#[derive(Clone, Debug, serde::Serialize)]
pub struct JointReport {
    /// Its name.
    pub name: String,
    /// Its kind.
    pub kind: JointKind,
    /// The ports it joins.
    pub between: [String; 2],
    /// Number of its rows.
    pub rows: usize,
    /// Largest distance between the ports \[m\].
    pub distance: f64,
}

/// A part as a report names it.
#[derive(Clone, Debug, serde::Serialize)]
pub struct PartReport {
    /// Its name.
    pub name: String,
    /// Its file.
    pub file: String,
    /// Mesh hash of the file.
    pub hash: String,
    /// Number of its modes, the rigid motions of a free body among them.
    pub modes: usize,
    /// True of a body that nothing holds.
    pub free: bool,
}

/// Sections of parts that the joined file has not, and what is lost with them.
const LOST: [(SectionKind, &str); 7] = [
    (SectionKind::StressBasis, "stress of it"),
    (SectionKind::ReactionBasis, "reactions of its supports"),
    (SectionKind::InteriorBasis, "fields inside it"),
    (SectionKind::FactorValues, "factor of its stiffness, so no static fields inside it"),
    (SectionKind::EmbeddedTriangles, "embedded surface of it: that of the mesh is drawn"),
    (SectionKind::BaseFrame, "motion of its base"),
    (SectionKind::ContactPatch, "flexibility between contacts on it: each is answered by itself"),
];

/// Joins the parts of an assembly file.
///
/// # Errors
/// [`AssemblyError`]: files that cannot be read or joined, ports that do not meet, redundant joints, a body
/// that is not held.
pub fn assemble(file: &AssemblyFile) -> Result<Assembled, AssemblyError> {
    file.refuse_world()?;
    let raw = (0..file.parts.len()).map(|i| read_part(file, i)).collect::<Result<Vec<_>, _>>()?;
    let mut parts = vec![];
    for (entry, bytes) in file.parts.iter().zip(&raw) {
        let pose = Pose::new(entry.position, entry.rotation);
        let part = Part::new(&entry.name, File::parse(bytes)?, pose);
        parts.push(part.map_err(|fault| of_part(&entry.name, fault))?);
    }
    let joints = joints(file, &parts)?;
    join(file, &parts, &joints)
}

/// The joints of the file, between the ports that they name.
fn joints<'f>(file: &'f AssemblyFile, parts: &[Part<'_>]) -> Result<Vec<Joint<'f>>, AssemblyError> {
    let end = |index: usize, name: &str| {
        End::find(parts, name).ok_or_else(|| {
            let of_part = |part: &Part<'_>| -> Vec<String> {
                part.port_names().map(|port| format!("{}.{port}", part.name())).collect()
            };
            let known: Vec<String> = parts.iter().flat_map(of_part).collect();
            let expected = match known.is_empty() {
                true => "a port, `part.port`; no part has one: build it with `[[port]]`".to_string(),
                false => format!("a port, `part.port`, one of {}", known.join(", ")),
            };
            AssemblyError::from(file.refuse(
                &format!("joint[{index}].between"),
                format!("`{name}`"),
                expected,
            ))
        })
    };
    let mut joints = vec![];
    for (index, entry) in file.joints.iter().enumerate() {
        let [first, second] = &entry.between;
        let first = end(index, first)?;
        let second = if second == GROUND { None } else { Some(end(index, second)?) };
        let stiffness = entry.stiffness.as_deref().unwrap_or_default();
        let joint = match entry.kind {
            JointKind::Weld => Joint::weld(first, second),
            JointKind::Bushing => Joint::bushing(first, second, stiffness),
            JointKind::Spring => Joint::spring(first, second, stiffness),
            JointKind::Hinge => Joint::hinge(first, second),
            JointKind::Ball => Joint::ball(first, second),
            JointKind::Slider => Joint::slider(first, second),
            JointKind::Cable => {
                let expected = "a joint that stays as it is; a cable is one of a world";
                return Err(file.refuse(&format!("joint[{index}].kind"), "`cable`", expected).into());
            }
        };
        joints.push(match entry.distance {
            Some(distance) => joint.within(distance),
            None => joint,
        });
    }
    Ok(joints)
}

/// Joins parts and writes what is said of them.
fn join(file: &AssemblyFile, parts: &[Part<'_>], joints: &[Joint<'_>]) -> Result<Assembled, AssemblyError> {
    let nodes = |part: &Part<'_>| part.file().metadata().n_surface_nodes as usize;
    let places = parts.iter().flat_map(|part| (0..nodes(part)).map(|node| part.place(node)));
    let options = AssemblyOptions {
        time_step: file.step,
        program: concat!("vademecum ", env!("CARGO_PKG_VERSION"), ", assembled"),
        problem: &file.text,
        // Of the nodes of all parts at their places: no mesh is that of the joined body.
        mesh_hash: Some(hash(&Mesh::of_points(places.collect()))),
        ..AssemblyOptions::default()
    };
    let refused = |error| of_assembly(file, error);
    let sizes = Assembly::sizes(parts, joints, &options).map_err(refused)?;
    let (mut memory, mut work) = (vec![0.0; sizes.memory], vec![0.0; sizes.work]);
    let mut bytes = vec![0; sizes.bytes];
    let assembly =
        Assembly::bind(parts, joints, &options, &mut bytes, &mut memory, &mut work).map_err(refused)?;
    let report = report(file, parts, joints, &assembly)?;
    let length = assembly.bytes().len();
    bytes.truncate(length);
    Ok(Assembled { bytes, report })
}

fn report(
    file: &AssemblyFile,
    parts: &[Part<'_>],
    joints: &[Joint<'_>],
    assembly: &Assembly<'_>,
) -> Result<AssemblyReport, AssemblyError> {
    let numbers = assembly.report();
    let of_part = |(part, entry): (&Part<'_>, &PartEntry)| PartReport {
        name: entry.name.clone(),
        file: entry.file.display().to_string(),
        hash: hex(&part.file().metadata().mesh_hash),
        modes: part.n_coordinates(),
        free: part.rigid().is_some(),
    };
    let of_joint = |index: usize| -> Result<JointReport, AssemblyError> {
        let (entry, joint) = (&file.joints[index], &joints[index]);
        Ok(JointReport {
            name: entry.name(index),
            kind: entry.kind,
            between: entry.between.clone(),
            rows: joint.n_rows(parts).map_err(|fault| refusal::of_joint(file, index, fault))?,
            distance: numbers.distances[index],
        })
    };
    let frequency = |value: &f64| value.sqrt() / std::f64::consts::TAU;
    Ok(AssemblyReport {
        title: file.title.clone(),
        parts: parts.iter().zip(&file.parts).map(of_part).collect(),
        joints: (0..joints.len()).map(of_joint).collect::<Result<_, _>>()?,
        modes: numbers.eigenvalues.len(),
        frequencies_hz: numbers.eigenvalues.iter().take(10).map(frequency).collect(),
        synthesis: if numbers.rubin { "Rubin" } else { "MacNeal" },
        damping_coupling: numbers.damping_coupling,
        damping_coupled: numbers.damping_coupled,
        time_step: numbers.time_step,
        notes: notes(parts, assembly),
    })
}

/// Losses of the joined body against its parts.
fn notes(parts: &[Part<'_>], assembly: &Assembly<'_>) -> Vec<String> {
    let mut notes = vec![];
    let has = |part: &Part<'_>, kind| part.file().section(kind).is_some();
    let loadable = |part: &&Part<'_>| part.file().metadata().n_load_nodes > 0;
    let without = |part: &&Part<'_>| !has(part, SectionKind::ContactResidual);
    if let Some(part) = parts.iter().filter(loadable).find(without) {
        notes.push(format!(
            "part `{}` has no residual flexibility, so the joined body has none under contacts",
            part.name()
        ));
    }
    let of_stiffness = |part: &Part<'_>| part.file().metadata().beta > 0.0;
    if assembly.file().metadata().beta == 0.0 && parts.iter().any(of_stiffness) {
        notes.push(
            "parts with different damping: under contacts, what the modes leave out answers at once, without \
             the damping by the stiffness of its part"
                .into(),
        );
    }
    for (kind, lost) in LOST {
        for part in parts.iter().filter(|part| has(part, kind)) {
            notes.push(format!("part `{}`: the joined file has no {lost}", part.name()));
        }
    }
    notes
}
