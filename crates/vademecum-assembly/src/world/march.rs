//! The march of a world: parts bound, steps, rows, and the account of a run.

use vademecum_build::progress::Listener;
use vademecum_eval::{
    Body, Member, Nodes, Pose, RigidShape, Touching, World, WorldBuffers, WorldError, WorldJoint,
    WorldOptions, WorldReport,
};
use vademecum_format::File;

use crate::entries::NodesEntry;
use crate::error::AssemblyError;
use crate::file::{AssemblyFile, GROUND};
use crate::world::error::WorldRunError;
use crate::world::joints::Joined;
use crate::world::overlap::{Skin, overlap};
use crate::world::parts::{Bound, Shape, Source, body_options, ports, read};
use crate::world::rows::{Shown, add_pairs, add_positions, columns, nodes_in_space, outputs, potential};

/// Most steps of a run.
const MAX_STEPS: f64 = 1e9;

/// Options of the run of a world.
#[derive(Clone, Copy, Debug)]
pub struct WorldRunOptions {
    /// Steps between two rows.
    pub every: usize,
    /// True if rows have the surfaces of the parts.
    pub surfaces: bool,
}

/// Plan of a run before its first row.
#[derive(Clone, Debug)]
pub struct WorldPlan {
    /// Number of steps.
    pub steps: usize,
    /// Step \[s\].
    pub time_step: f64,
    /// Names of the columns, with units.
    pub columns: Vec<String>,
    /// Triangles of the surfaces of all parts, one part after the other.
    pub triangles: Vec<[u32; 3]>,
    /// Number of the part of each node of the surfaces.
    pub part_of_node: Vec<f64>,
}

/// A row of a run.
#[derive(Clone, Copy, Debug)]
pub struct WorldRow<'a> {
    /// Time \[s\].
    pub time: f64,
    /// Values of the columns, time and energy first.
    pub values: &'a [f64],
    /// Nodes of the surfaces in space \[m\]; empty if they were not asked for.
    pub nodes: &'a [[f64; 3]],
}

/// Account of a run.
#[derive(Clone, Debug, Default, serde::Serialize)]
pub struct WorldRunReport {
    /// Number of steps.
    pub steps: usize,
    /// Step \[s\].
    pub time_step: f64,
    /// Most contacts in a step, without those for which there was no room.
    pub contacts_at_most: usize,
    /// Steps in which there was no room for a contact.
    pub steps_without_room: usize,
    /// Sweeps of a step, in the mean.
    pub mean_sweeps: f64,
    /// Steps whose solution was not within the tolerance.
    pub steps_not_converged: usize,
    /// Joints that broke.
    pub joints_broken: usize,
    /// Deepest overlap at the end of a step \[m\].
    pub deepest_overlap: f64,
    /// Energy that contacts took from the parts \[J\].
    pub energy_given_away: f64,
    /// Sum of the rises of the energy in a step \[J\].
    pub energy_rises: f64,
    /// Largest rise of the energy in a step \[J\].
    pub largest_energy_rise: f64,
}

impl WorldRunReport {
    fn add(&mut self, report: &WorldReport, rise: f64) {
        self.steps += 1;
        self.contacts_at_most = self.contacts_at_most.max(report.contacts);
        self.steps_without_room += usize::from(report.left_out > 0);
        self.mean_sweeps += (report.sweeps as f64 - self.mean_sweeps) / self.steps as f64;
        self.steps_not_converged += usize::from(!report.converged);
        self.joints_broken += report.broken;
        self.deepest_overlap = self.deepest_overlap.max(report.worst_gap);
        self.energy_given_away += report.energy_given_away;
        self.energy_rises += rise.max(0.0);
        self.largest_energy_rise = self.largest_energy_rise.max(rise);
    }
}

/// Receiver of the rows of a run.
pub trait WorldSink {
    /// Failure of the receiver or of the run.
    type Error: From<WorldRunError>;

    /// The run is about to begin: nothing of the file is refused any more.
    ///
    /// # Errors
    /// Of the receiver; the run ends.
    fn begin(&mut self, plan: &WorldPlan) -> Result<(), Self::Error>;

    /// A row.
    ///
    /// # Errors
    /// Of the receiver; the run ends.
    fn show(&mut self, row: &WorldRow<'_>) -> Result<(), Self::Error>;
}

/// A world that is set up, before its first step.
pub(crate) struct Ready<'r, 'w, 'm, 'x> {
    pub file: &'r AssemblyFile,
    pub time_step: f64,
    pub steps: usize,
    pub sources: &'r [Source],
    pub shapes: &'r [Shape],
    pub shown: &'r [(usize, Shown)],
    pub pairs: &'r [Touching],
    pub joints: &'r [WorldJoint],
    /// The parts, and the ground behind them where a joint holds it.
    pub members: &'r mut [Member<'w, 'm, f64>],
    pub world: &'r mut World<'x, f64>,
}

/// Sets the world of an assembly file up.
pub(crate) fn set_up<R, E: From<WorldRunError>>(
    file: &AssemblyFile,
    listener: &dyn Listener,
    run: impl FnOnce(Ready<'_, '_, '_, '_>) -> Result<R, E>,
) -> Result<R, E> {
    listener.stage("read the parts");
    let mut sources: Vec<Source> = vec![];
    for i in 0..file.parts.len() {
        // Copies are read once.
        let same = |before: usize| file.parts[before].entry == file.parts[i].entry;
        let source = match i.checked_sub(1).filter(|before| same(*before)) {
            Some(before) => sources[before].clone(),
            None => read(file, i)?,
        };
        sources.push(source);
    }
    let opened: Vec<Option<File<'_>>> = sources.iter().map(open).collect::<Result<_, _>>()?;
    let (time_step, steps) = time(file, &opened)?;
    let entry = file.world.expect("a world");
    let body_options = body_options(time_step, entry.contacts);
    let mut memory = vec![];
    for (part, opened) in file.parts.iter().zip(&opened) {
        let length = opened.as_ref().map_or(Ok(0), |opened| Body::<f64>::len_for(opened, &body_options));
        let bind = |source| WorldRunError::Bind { part: part.name.clone(), source };
        memory.push(vec![0.0; length.map_err(bind)?]);
    }
    let shapes = sources.iter().zip(&opened).map(|(source, opened)| Shape::of(source, opened.as_ref()));
    let shapes: Vec<Shape> = shapes.collect::<Result<_, _>>().map_err(WorldRunError::from)?;
    let mut bound = vec![];
    for (i, memory) in memory.iter_mut().enumerate() {
        bound.push(Bound::new(file, i, (&sources[i], opened[i].as_ref()), &body_options, memory)?);
    }
    let shown = outputs(file, &bound, &shapes).map_err(WorldRunError::from)?;
    let (pairs, joints) = bonds(file, &opened, &shapes)?;
    if file.joints.iter().any(|joint| joint.between[1] == GROUND) {
        let ground = RigidShape::led(&[], &[], Pose::IDENTITY);
        bound.extend(ground.map(|shape| Bound::Rigid(Box::new(shape))));
    }
    let mut members: Vec<Member<'_, '_, f64>> = bound.iter_mut().map(Bound::member).collect();
    let world_options = WorldOptions {
        gravity: entry.gravity,
        reach: entry.reach,
        tolerance: entry.tolerance,
        sweeps: entry.sweeps,
        contacts: entry.contacts,
        ..WorldOptions::default()
    };
    let refused = |source| WorldRunError::World { subject: subject(file, &source), source };
    let sizes = World::sizes(&members, &joints, &world_options).map_err(refused)?;
    let mut lent = WorldBuffers::new(&sizes);
    let world = World::new(&members, &pairs, &joints, &world_options, lent.lend());
    let mut world = world.map_err(refused)?;
    run(Ready {
        file,
        time_step,
        steps,
        sources: &sources,
        shapes: &shapes,
        shown: &shown,
        pairs: &pairs,
        joints: &joints,
        members: &mut members,
        world: &mut world,
    })
}

/// Marches the world of an assembly file.
///
/// # Errors
/// [`WorldRunError`], or that of the receiver.
pub fn run_world<S: WorldSink>(
    file: &AssemblyFile,
    options: &WorldRunOptions,
    listener: &dyn Listener,
    sink: &mut S,
) -> Result<WorldRunReport, S::Error> {
    set_up(file, listener, |ready| march(ready, options, listener, sink))
}

fn march<S: WorldSink>(
    ready: Ready<'_, '_, '_, '_>,
    options: &WorldRunOptions,
    listener: &dyn Listener,
    sink: &mut S,
) -> Result<WorldRunReport, S::Error> {
    let Ready { file, time_step, steps, shapes, shown, pairs, members, world, .. } = ready;
    let gravity = file.world.expect("a world").gravity;
    let refused = |source| WorldRunError::World { subject: subject(file, &source), source };
    let ways: Vec<_> = file.parts.iter().enumerate().filter_map(|(i, part)| Some((i, part.way()?))).collect();
    let lead = |members: &mut [Member<'_, '_, f64>], time: f64| {
        for (i, way) in &ways {
            let (part, by) = (&file.parts[*i], way.at(time));
            let position = std::array::from_fn(|k| part.position[k] + by[k]);
            members[*i].lead(Pose::new(position, part.rotation)).expect("a part that is led");
        }
    };
    lead(members, 0.0);
    sink.begin(&plan(file, shapes, steps, time_step))?;
    let (mut row, mut nodes) = (vec![], vec![]);
    let mut report = WorldRunReport { time_step, ..WorldRunReport::default() };
    let mut before = world.energy(members).map_err(refused)? + potential(members, gravity);
    listener.stage("march");
    for step in 0..=steps {
        let time = step as f64 * time_step;
        if step > 0 {
            lead(members, time);
            let done = world.step(members).map_err(|source| {
                let time = (step - 1) as f64 * time_step;
                WorldRunError::Step { time, subject: subject(file, &source), source }
            })?;
            let now = world.energy(members).map_err(refused)? + potential(members, gravity);
            report.add(&done, now - before);
            before = now;
        }
        if step % options.every == 0 {
            row.clear();
            row.extend([time, before]);
            add_positions(file, members, shown, &mut row)?;
            add_pairs(file, pairs, world.touches(), &mut row);
            if options.surfaces {
                nodes_in_space(file, members, shapes, &mut nodes)?;
            }
            sink.show(&WorldRow { time, values: &row, nodes: &nodes })?;
        }
        if step % 64 == 0 {
            listener.checkpoint(step, steps).map_err(WorldRunError::from)?;
        }
    }
    Ok(report)
}

fn open(source: &Source) -> Result<Option<File<'_>>, WorldRunError> {
    match source {
        Source::Rigid(_) => Ok(None),
        Source::File(bytes) => Ok(Some(File::parse(bytes).map_err(AssemblyError::from)?)),
    }
}

/// Step \[s\], and number of steps.
fn time(file: &AssemblyFile, opened: &[Option<File<'_>>]) -> Result<(f64, usize), WorldRunError> {
    let entry = file.world.expect("a world");
    let own = opened.iter().flatten().map(|opened| opened.metadata().time_step);
    let smallest = own.fold(f64::INFINITY, f64::min);
    if smallest == f64::INFINITY {
        let expected = "at least one part with a `file`";
        return Err(file.refuse("part", "rigid bodies alone", expected).into());
    }
    let time_step = entry.step.or(file.step).unwrap_or(smallest);
    let steps = (entry.time / time_step).round();
    if !(1.0..=MAX_STEPS).contains(&steps) {
        let expected = format!("a time of 1 to {MAX_STEPS:e} steps of {time_step} s");
        return Err(file.refuse("world.time", entry.time, expected).into());
    }
    Ok((time_step, steps as usize))
}

/// Pairs and joints; parts that overlap are refused.
fn bonds(
    file: &AssemblyFile,
    opened: &[Option<File<'_>>],
    shapes: &[Shape],
) -> Result<(Vec<Touching>, Vec<WorldJoint>), WorldRunError> {
    let skin = |part: usize| {
        let pose = Pose::new(file.parts[part].position, file.parts[part].rotation);
        let nodes = shapes[part].nodes.iter().map(|node| pose.place(*node)).collect();
        Skin { nodes, triangles: &shapes[part].triangles }
    };
    let mut pairs = vec![];
    for contact in &file.contacts {
        let members = contact.between.each_ref().map(|name| file.part(name).expect("was checked"));
        if let Some(depth) = overlap(&skin(members[0]), &skin(members[1])) {
            let [a, b] = &contact.between;
            let found = format!("`{a}` and `{b}`, which overlap by {depth:.3e} m at the start");
            let expected = "parts that are apart or touch";
            let key = format!("contact[{}].between", contact.entry);
            return Err(file.refuse(&key, found, expected).into());
        }
        let nodes = match contact.nodes {
            NodesEntry::Both => Nodes::Both,
            NodesEntry::First => Nodes::First,
            NodesEntry::Second => Nodes::Second,
        };
        let (friction, restitution) = (contact.friction, contact.restitution);
        pairs.push(Touching { members, friction, restitution, nodes });
    }
    let of_part = |opened: &Option<File<'_>>| opened.as_ref().map_or(Ok(vec![]), ports);
    let ports = opened.iter().map(of_part).collect::<Result<Vec<_>, _>>()?;
    let sizes: Vec<f64> = (0..shapes.len()).map(|part| skin(part).size()).collect();
    let joints = Joined { file, ports: &ports, sizes: &sizes }.joints()?;
    Ok((pairs, joints))
}

fn plan(file: &AssemblyFile, shapes: &[Shape], steps: usize, time_step: f64) -> WorldPlan {
    let (mut triangles, mut part_of_node) = (vec![], vec![]);
    for (part, shape) in shapes.iter().enumerate() {
        let first = part_of_node.len() as u32;
        triangles.extend(shape.triangles.iter().map(|triangle| triangle.map(|node| first + node)));
        part_of_node.extend(std::iter::repeat_n(part as f64, shape.nodes.len()));
    }
    WorldPlan { steps, time_step, columns: columns(file), triangles, part_of_node }
}

/// The part, pair or joint of a world that an error is about.
fn subject(file: &AssemblyFile, error: &WorldError) -> String {
    match *error {
        WorldError::Member { member, .. } => {
            file.parts.get(member).map_or("the ground".into(), |part| format!("part `{}`", part.name))
        }
        WorldError::Pair { pair } => file.contacts.get(pair).map_or("a pair".into(), |contact| {
            format!("contact of `{}` and `{}`", contact.between[0], contact.between[1])
        }),
        WorldError::Joint { joint } | WorldError::Redundant { joint } => {
            file.joints.get(joint).map_or("a joint".into(), |entry| format!("joint `{}`", entry.name(joint)))
        }
        _ => "the world".into(),
    }
}
