//! Snapshots: full-order fields under a plan of loads, or the fields of another program.
//!
//! Runs are marched several at a time (many right-hand sides cost little more than one) and streamed into the
//! POD, so memory does not grow with the plan. Runs that are done are kept until their basis is, so that a
//! build that was stopped marches the others only.

use std::path::PathBuf;
use std::sync::atomic::{AtomicUsize, Ordering};

use faer::prelude::ReborrowMut;
use faer::{Mat, MatMut, MatRef};

use super::pod::{Apply, Pod, StreamingPod};
use crate::dynamics::{FullOrder, Interval, MarchError, TimedLoad, march_full_order};
use crate::field;
use crate::input::{Problem, SnapshotPlan};
use crate::linalg::NoConvergence;
use crate::parallel;
use crate::prepared::Body;
use crate::progress::{Cancelled, Listener, Quiet};
use crate::store::{Inputs, StageCache};

/// Runs marched at once by one thread; past 16 right-hand sides a solve gains nothing more.
const RUNS_AT_ONCE: usize = 16;
/// Snapshots of one group of runs held before the POD takes them \[numbers\].
const GROUP_LIMIT: usize = 1 << 25;
/// Snapshots per run unless the plan gives a stride.
const SNAPSHOTS_PER_RUN: usize = 60;

/// Why there are no snapshots.
#[derive(Debug, thiserror::Error)]
pub enum SnapshotError {
    /// The march failed.
    #[error("snapshots")]
    March(#[from] MarchError),
    /// On request.
    #[error("snapshots")]
    Cancelled(#[from] Cancelled),
    /// A file cannot be read.
    #[error("snapshots")]
    Field(#[from] field::FieldError),
    /// A file holds another number of dofs than the mesh.
    #[error("{path}: {found} rows; expected {expected}, three per node of the mesh")]
    Rows {
        /// The file.
        path: PathBuf,
        /// Rows found.
        found: usize,
        /// Three times the number of nodes.
        expected: usize,
    },
    /// Snapshots that are not finite numbers, or are too far apart for double precision.
    #[error("snapshots")]
    NoConvergence(#[from] NoConvergence),
    /// No snapshot moves.
    #[error("all snapshots are zero: no load of the plan moves the body")]
    Zero,
}

/// The plan with all its defaults filled in.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct SnapshotSchedule {
    /// Mesh nodes that are loaded, one after the other.
    pub nodes: Vec<u32>,
    /// Directions of the unit force at each.
    pub directions: Vec<[f64; 3]>,
    /// Duration of each force \[s\].
    pub hold: f64,
    /// Steps of each run.
    pub steps: usize,
    /// Steps between snapshots.
    pub stride: usize,
}

impl SnapshotSchedule {
    /// Fills in the defaults from the first natural period \[s\].
    pub fn plan(plan: &SnapshotPlan, body: &Body, time_step: f64, first_period: f64) -> Self {
        let duration = plan.duration.unwrap_or(3.0 * first_period);
        let steps = ((duration / time_step).ceil() as usize).max(2);
        Self {
            nodes: spread_nodes(body, plan.positions),
            directions: plan.directions.clone(),
            hold: plan.hold.unwrap_or(0.5 * first_period).max(time_step),
            steps,
            stride: plan.stride.unwrap_or((steps / SNAPSHOTS_PER_RUN).max(1)),
        }
    }

    /// Node and direction of the force of each run.
    fn loads(&self) -> Vec<(u32, [f64; 3])> {
        self.nodes.iter().flat_map(|&node| self.directions.iter().map(move |&d| (node, d))).collect()
    }

    /// The same in groups marched together.
    pub fn groups(&self) -> Vec<Vec<(u32, [f64; 3])>> {
        self.loads().chunks(RUNS_AT_ONCE).map(<[_]>::to_vec).collect()
    }

    /// Snapshots kept of one run.
    pub(crate) fn snapshots_per_run(&self) -> usize {
        self.steps / self.stride
    }

    /// Runs that one thread marches at once, on a body of `n` dofs: as many as their snapshots leave room
    /// for.
    pub fn side_by_side(&self, n: usize) -> usize {
        (GROUP_LIMIT / n.saturating_mul(self.snapshots_per_run().saturating_add(1))).clamp(1, RUNS_AT_ONCE)
    }

    /// Number of runs.
    pub fn count(&self) -> usize {
        self.nodes.len() * self.directions.len()
    }
}

/// Squared distances closer than this are alike, relative to the larger: what rounding makes of a body that
/// is turned, and far less than what tells two places apart.
const ALIKE: f64 = 1e-9;

/// Loadable nodes far from each other: the first is farthest from the centroid, each next one from all
/// before. Of places that are alike in that, the one with the larger sum of distances to all before is taken,
/// then the first: the choice follows the body when it is turned.
pub fn spread_nodes(body: &Body, count: usize) -> Vec<u32> {
    let mut candidates = body.load_nodes.clone();
    let free = |node: &u32| (0..3).any(|c| !body.model.dofs().is_held(3 * *node as usize + c));
    candidates.retain(free);
    let position = |&node: &u32| body.model.mesh().nodes[node as usize];
    let positions: Vec<[f64; 3]> = candidates.iter().map(position).collect();
    spread(&positions, count).into_iter().map(|place| candidates[place]).collect()
}

/// Places of points far from each other, at most `count`.
fn spread(points: &[[f64; 3]], count: usize) -> Vec<usize> {
    let centroid: [f64; 3] =
        std::array::from_fn(|c| points.iter().map(|point| point[c]).sum::<f64>() / points.len() as f64);
    let squared = |a: &[f64; 3], b: &[f64; 3]| (0..3).map(|c| (a[c] - b[c]).powi(2)).sum::<f64>();
    let mut nearest: Vec<f64> = points.iter().map(|point| squared(point, &centroid)).collect();
    let mut sum = vec![0.0; points.len()];
    let mut chosen = vec![];
    let larger = |a: f64, b: f64| a > b + ALIKE * b.abs();
    while chosen.len() < count.min(points.len()) {
        let farther = |a: usize, b: usize| {
            let alike = !larger(nearest[b], nearest[a]) && !larger(nearest[a], nearest[b]);
            let b_first = if alike { larger(sum[b], sum[a]) } else { nearest[b] > nearest[a] };
            if b_first { b } else { a }
        };
        let farthest = (0..points.len()).reduce(farther).expect("there are points left");
        for (i, point) in points.iter().enumerate() {
            let to_new = squared(point, &points[farthest]);
            nearest[i] = if chosen.is_empty() { to_new } else { nearest[i].min(to_new) };
            sum[i] += to_new.sqrt();
        }
        chosen.push(farthest);
    }
    chosen
}

/// Runs of one setting, as a build keeps them.
pub struct CachedRuns<'a> {
    /// The finished stages of the build.
    pub kept: &'a StageCache<'a>,
    /// Inputs of the march besides the model and the runs themselves.
    pub inputs: &'a (dyn Fn(Inputs) -> Inputs + Sync),
}

impl CachedRuns<'_> {
    /// Snapshots of the runs from `first` on, marched if they are not kept.
    fn group(
        &self,
        runs: &SnapshotSchedule,
        first: usize,
        group: &[(u32, [f64; 3])],
        march: impl FnOnce() -> Result<Vec<f64>, MarchError>,
    ) -> Result<Vec<f64>, MarchError> {
        let inputs = |inputs| (self.inputs)(inputs).value(&(runs, group));
        self.kept.stage(&name(first, group.len()), inputs, march)
    }

    /// Removes what is kept of the runs, once the basis that they led to is kept itself.
    pub fn forget(&self, body: &Body, runs: &SnapshotSchedule) {
        let loads = runs.loads();
        let at_once = runs.side_by_side(body.n_dof());
        for (i, group) in loads.chunks(at_once).enumerate() {
            let inputs = |inputs| (self.inputs)(inputs).value(&(runs, group));
            self.kept.forget(&name(i * at_once, group.len()), inputs);
        }
    }
}

/// The stage of some runs: their numbers, from 1.
fn name(first: usize, count: usize) -> String {
    format!("runs-{}-to-{}", first + 1, first + count)
}

/// Marches the plan and streams every snapshot into a POD of at most `max_rank` vectors.
///
/// # Errors
/// [`SnapshotError`].
pub(crate) fn compute(
    body: &Body,
    full: &FullOrder<'_>,
    runs: &SnapshotSchedule,
    inner_product: Apply<'_>,
    max_rank: usize,
    kept: &CachedRuns<'_>,
) -> Result<Pod, SnapshotError> {
    let (n, listener) = (body.n_dof(), kept.kept.listener);
    let loads = runs.loads();
    let at_once = runs.side_by_side(n);
    let groups: Vec<_> = loads.chunks(at_once).enumerate().collect();
    let mut pod = StreamingPod::new(inner_product, n, max_rank);
    // Bars move with the steps of all runs: a group of runs may take most of the time there is.
    let (done, steps) = (AtomicUsize::new(0), runs.steps * loads.len());
    let stepped = |count: usize| listener.advance(count + done.fetch_add(count, Ordering::Relaxed), steps);
    for side_by_side in groups.chunks(rayon::current_num_threads()) {
        if listener.cancelled() {
            return Err(Cancelled.into());
        }
        // Groups are independent and pushed in order: the same bytes come out for any number of threads.
        let march = |at: usize| -> Result<Vec<f64>, MarchError> {
            let (i, group) = side_by_side[at];
            let mut marched = false;
            let fields = kept.group(runs, i * at_once, group, || {
                marched = true;
                run_group(body, full, runs, group, listener, &stepped)
            })?;
            if !marched {
                stepped(runs.steps * group.len());
            }
            Ok(fields)
        };
        for fields in parallel::map(side_by_side.len(), &march) {
            let fields = fields?;
            pod.push(MatRef::from_column_major_slice(&fields, n, fields.len() / n))?;
        }
    }
    finish(pod)
}

/// The forces of runs marched together, one trajectory each.
pub fn run_loads(body: &Body, runs: &SnapshotSchedule, group: &[(u32, [f64; 3])]) -> Vec<TimedLoad> {
    let when = Interval { start: 0.0, end: runs.hold, ramp: 0.0 };
    let load = |(column, &(node, direction)): (usize, &(u32, [f64; 3]))| {
        let mut force = vec![0.0; body.n_dof()];
        body.model.add_point_force(&[node], &[1.0], direction, &mut force);
        TimedLoad { column, force, when: when.into() }
    };
    group.iter().enumerate().map(load).collect()
}

/// Marches runs together and tells `stepped` of their steps; snapshots as columns, shape
/// (n, runs × snapshots), column after column.
fn run_group(
    body: &Body,
    full: &FullOrder<'_>,
    runs: &SnapshotSchedule,
    group: &[(u32, [f64; 3])],
    listener: &dyn Listener,
    stepped: &(dyn Fn(usize) + Sync),
) -> Result<Vec<f64>, MarchError> {
    let (loads, n) = (run_loads(body, runs, group), body.n_dof());
    let columns = group.len() * runs.snapshots_per_run();
    let mut fields = vec![0.0; n * columns];
    let mut snapshots = MatMut::from_column_major_slice_mut(&mut fields, n, columns);
    let mut next = 0;
    march_full_order(full, &loads, group.len(), runs.steps, &Quiet(listener), |step, state| {
        if step > 0 {
            stepped(group.len());
        }
        if step > 0 && step % runs.stride == 0 {
            snapshots.rb_mut().subcols_mut(next, group.len()).copy_from(&state.displacement);
            next += group.len();
        }
    })?;
    Ok(fields)
}

/// Streams the snapshots of another program into a POD.
///
/// # Errors
/// [`SnapshotError`] if a file cannot be read or does not fit the mesh.
pub(crate) fn import(
    body: &Body,
    problem: &Problem,
    inner_product: Apply<'_>,
    max_rank: usize,
    listener: &dyn Listener,
) -> Result<Pod, SnapshotError> {
    let mut pod = StreamingPod::new(inner_product, body.n_dof(), max_rank);
    if let Some(path) = &problem.snapshots.npy {
        let path = problem.resolve(path);
        let matrix = field::read_npy(&path)?;
        check_rows(body, &path, matrix.rows)?;
        for column in matrix.data.chunks_exact(matrix.rows.max(1)) {
            pod.push(restrict(body, column).as_ref())?;
        }
    }
    if let Some(files) = &problem.snapshots.vtu {
        let files: Vec<PathBuf> = files.iter().map(|path| problem.resolve(path)).collect();
        // One file at a time: a series may be longer than memory.
        for (i, file) in files.iter().enumerate() {
            let name = &problem.snapshots.field;
            let matrix = field::read_displacements(std::slice::from_ref(file), name, body.model.mesh())?;
            pod.push(restrict(body, matrix.column(0)).as_ref())?;
            listener.checkpoint(i + 1, files.len())?;
        }
    }
    finish(pod)
}

fn check_rows(body: &Body, path: &std::path::Path, found: usize) -> Result<(), SnapshotError> {
    let expected = body.model.dofs().n_dof();
    if found == expected { Ok(()) } else { Err(SnapshotError::Rows { path: path.into(), found, expected }) }
}

fn restrict(body: &Body, full: &[f64]) -> Mat<f64> {
    let mut free = Mat::zeros(body.n_dof(), 1);
    body.model.dofs().restrict_into(full, free.col_as_slice_mut(0));
    free
}

fn finish(pod: StreamingPod<'_>) -> Result<Pod, SnapshotError> {
    let pod = pod.finish()?;
    if pod.singular_values.is_empty() { Err(SnapshotError::Zero) } else { Ok(pod) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The surface of a box of 5 × 3 × 3 points, in lengths that binary numbers do not hold.
    fn points() -> Vec<[f64; 3]> {
        let grid = (0..45).map(|i| [i / 9, i / 3 % 3, i % 3]);
        grid.map(|[x, y, z]| [0.3 * x as f64, 0.1 * y as f64 + 0.7, 0.1 * z as f64]).collect()
    }

    #[test]
    fn the_chosen_places_follow_a_body_that_is_turned_or_moved() {
        let points = points();
        let chosen = spread(&points, 12);
        let (sine, cosine) = 0.7_f64.sin_cos();
        type Turn = fn([f64; 3], f64, f64) -> [f64; 3];
        let turned: [Turn; 4] = [
            |[x, y, z], _, _| [-y, x, z],
            |[x, y, z], _, _| [z, x, y],
            |[x, y, z], _, _| [x + 0.1, y - 3.3, z + 1e-3],
            |[x, y, z], s, c| [c * x - s * y, s * x + c * y, z],
        ];
        for turn in turned {
            let image: Vec<[f64; 3]> = points.iter().map(|&p| turn(p, sine, cosine)).collect();
            assert_eq!(spread(&image, 12), chosen);
        }
    }
}
