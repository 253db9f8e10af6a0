//! Ranges of the axes: what the full-order runs of the snapshots visit, seen in the basis.

use faer::{Mat, MatRef};
use vademecum_format::scheme::HISTORY;

use vademecum_build::basis::{SnapshotError, SnapshotSchedule, run_loads};
use vademecum_build::dynamics::{FullOrder, MarchError, State, Workspace, march_stages};
use vademecum_build::input::ChapterEntry;
use vademecum_build::parallel;
use vademecum_build::prepared::Body;
use vademecum_build::progress::{Cancelled, Listener, Quiet};

/// Width given to a coordinate the runs do not move, relative to the widest of its family.
const LEAST_WIDTH: f64 = 1e-6;

/// Smallest and largest value of each entry of the history, `[family][mode]`, zero included.
#[derive(Clone)]
struct Extremes(Vec<Vec<(f64, f64)>>);

impl Extremes {
    fn rest(r: usize) -> Self {
        Self(vec![vec![(0.0, 0.0); r]; HISTORY])
    }

    /// Takes in coordinates `(r, c)` of one family.
    fn see(&mut self, family: usize, coordinates: MatRef<'_, f64>) {
        for (mode, range) in self.0[family].iter_mut().enumerate() {
            for &x in coordinates.row(mode).iter() {
                *range = (range.0.min(x), range.1.max(x));
            }
        }
    }

    fn join(mut self, other: Self) -> Self {
        for (own, other) in self.0.iter_mut().flatten().zip(other.0.iter().flatten()) {
            *own = (own.0.min(other.0), own.1.max(other.1));
        }
        self
    }
}

/// Range of each entry of the history `(ζ, Δt ζ̇, Δt² ζ̈, ζ_1, …)`, `[family][mode]`: the extremes of all
/// runs, times the load's range, widened by the margin. `projector` is `P` with `ζ = Pᵀu`, `(n, r)`.
///
/// # Errors
/// [`SnapshotError`]: a march that is stopped.
pub(super) fn history_ranges(
    body: &Body,
    full: &FullOrder<'_>,
    runs: &SnapshotSchedule,
    projector: MatRef<'_, f64>,
    entry: &ChapterEntry,
    listener: &dyn Listener,
) -> Result<Vec<Vec<(f64, f64)>>, SnapshotError> {
    let groups = runs.groups();
    let mut all = Extremes::rest(projector.ncols());
    let mut done = 0;
    for side_by_side in groups.chunks(rayon::current_num_threads()) {
        if listener.cancelled() {
            return Err(Cancelled.into());
        }
        let of = |at: usize| group_extremes(body, full, runs, &side_by_side[at], projector, listener);
        for extremes in parallel::map(side_by_side.len(), &of) {
            all = all.join(extremes?);
        }
        done += side_by_side.len();
        listener.advance(done, groups.len());
    }
    Ok(all.0.iter().map(|family| widened(family, entry)).collect())
}

fn group_extremes(
    body: &Body,
    full: &FullOrder<'_>,
    runs: &SnapshotSchedule,
    group: &[(u32, [f64; 3])],
    projector: MatRef<'_, f64>,
    listener: &dyn Listener,
) -> Result<Extremes, MarchError> {
    let mut extremes = Extremes::rest(projector.ncols());
    let mut before = Mat::zeros(projector.ncols(), group.len());
    let n_stages = full.table().active().len();
    let loads = run_loads(body, runs, group);
    let observe = |step: usize, state: &State, work: &Workspace| {
        let parts = [&state.displacement, &state.dt_velocity, &state.dt2_acceleration];
        for (family, part) in parts.into_iter().enumerate() {
            let coordinates = projector.transpose() * part;
            extremes.see(family, coordinates.as_ref());
            if family == 0 {
                for stage in (0..n_stages).filter(|_| step > 0) {
                    let moved = &before + projector.transpose() * work.increment(stage);
                    extremes.see(3 + stage, moved.as_ref());
                }
                before = coordinates;
            }
        }
    };
    march_stages(full, &loads, group.len(), runs.steps, &Quiet(listener), observe)?;
    Ok(extremes)
}

/// Unit forces to the load's range, then the margin; no range without width.
fn widened(family: &[(f64, f64)], entry: &ChapterEntry) -> Vec<(f64, f64)> {
    let [lower, upper] = entry.load;
    // A component can point both ways.
    let factors = if entry.components { [-upper.max(-lower), upper.max(-lower)] } else { [lower, upper] };
    let hull = |&(low, high): &(f64, f64)| {
        let ends = factors.iter().flat_map(|f| [f * low, f * high]);
        ends.fold((0.0f64, 0.0f64), |(a, b), x| (a.min(x), b.max(x)))
    };
    let hulls: Vec<(f64, f64)> = family.iter().map(hull).collect();
    let widest = hulls.iter().map(|(low, high)| high - low).fold(f64::MIN_POSITIVE, f64::max);
    let wide = |&(low, high): &(f64, f64)| {
        let more = (entry.margin * (high - low)).max(LEAST_WIDTH * widest);
        (low - more, high + more)
    };
    hulls.iter().map(wide).collect()
}
