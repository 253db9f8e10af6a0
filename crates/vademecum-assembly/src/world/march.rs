//! The march of a world: steps, rows, and the account of a run.

use vademecum_build::progress::Listener;
use vademecum_eval::WorldReport;

use crate::file::AssemblyFile;
use crate::world::error::WorldRunError;
use crate::world::rows::{add_pairs, columns};
use crate::world::simulation::WorldSimulation;

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
    listener.stage("read the parts");
    let mut world = WorldSimulation::open(file.clone())?;
    let time_step = world.time_step();
    let steps = steps(file, time_step)?;
    let plan = plan(&world, steps);
    sink.begin(&plan)?;
    let (mut row, mut nodes) = (vec![], vec![[0.0; 3]; plan.part_of_node.len()]);
    let mut report = WorldRunReport { time_step, ..WorldRunReport::default() };
    let total = |world: &mut WorldSimulation| world.energy().map(|[own, potential]| own + potential);
    let mut before = total(&mut world)?;
    listener.stage("march");
    for step in 0..=steps {
        let time = step as f64 * time_step;
        if step > 0 {
            let done = world.step()?;
            let now = total(&mut world)?;
            report.add(&done, now - before);
            before = now;
        }
        if step % options.every == 0 {
            row.clear();
            row.extend([time, before]);
            row.extend(world.outputs()?.as_flattened());
            let named = world.file();
            world.with_bonds(|pairs, _| {
                world.with_touches(|touches| add_pairs(named, pairs, touches, &mut row));
            });
            let shown: &[[f64; 3]] = if options.surfaces { all_nodes(&mut world, &mut nodes)? } else { &[] };
            sink.show(&WorldRow { time, values: &row, nodes: shown })?;
        }
        if step % 64 == 0 {
            listener.checkpoint(step, steps).map_err(WorldRunError::from)?;
        }
    }
    Ok(report)
}

/// Nodes of the surfaces of the parts in space, one part after the other.
fn all_nodes<'n>(
    world: &mut WorldSimulation,
    nodes: &'n mut [[f64; 3]],
) -> Result<&'n [[f64; 3]], WorldRunError> {
    let mut rest = &mut *nodes;
    for part in 0..world.file().parts.len() {
        let count = world.surface(part).map_or(0, |surface| surface.nodes.len());
        let (own, behind) = rest.split_at_mut(count);
        world.nodes_into(part, own)?;
        rest = behind;
    }
    Ok(nodes)
}

/// Number of steps of the time of a world.
fn steps(file: &AssemblyFile, time_step: f64) -> Result<usize, WorldRunError> {
    let time = file.world.map_or(0.0, |entry| entry.time);
    let steps = (time / time_step).round();
    if !(1.0..=MAX_STEPS).contains(&steps) {
        let expected = format!("a time of 1 to {MAX_STEPS:e} steps of {time_step} s");
        return Err(file.refuse("world.time", time, expected).into());
    }
    Ok(steps as usize)
}

fn plan(world: &WorldSimulation, steps: usize) -> WorldPlan {
    let (mut triangles, mut part_of_node) = (vec![], vec![]);
    for part in 0..world.file().parts.len() {
        let Some(surface) = world.surface(part) else { continue };
        let first = part_of_node.len() as u32;
        triangles.extend(surface.triangles.iter().map(|triangle| triangle.map(|node| first + node)));
        part_of_node.extend(std::iter::repeat_n(part as f64, surface.nodes.len()));
    }
    let columns = columns(world.file());
    WorldPlan { steps, time_step: world.time_step(), columns, triangles, part_of_node }
}
