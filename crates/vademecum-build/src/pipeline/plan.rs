//! The cost of a build ahead: full-order steps, time and memory, before it takes them.
//!
//! Memory is counted from below: what is certainly allocated at once by the largest stage. Time is measured
//! on two steps and multiplied. Both are said to the user, and refused above a limit.

use super::error::BuildError;
use crate::basis::{SnapshotSchedule, most_vectors, sample_settings};
use crate::certificate::TRAJECTORIES;
use crate::dynamics::{FullOrder, Work, search_vectors, seconds_per_step};
use crate::input::{BasisKind, Problem};
use crate::large::{CANDIDATES, LargeOptions};
use crate::limits::{Memory, TooMuchMemory, memory_in_words};
use crate::prepared::Prepared;
use crate::report::BuildPlan;
use crate::residual;

/// Bytes of a number.
const NUMBER: f64 = 8.0;
/// Terms that a separated solution has at least, of those it may have.
const FEW_TERMS: usize = 10;
/// Vectors of one trajectory in a march: state, stages, forces, right-hand sides.
const PER_TRAJECTORY: f64 = 12.0;

/// Threads of a march.
fn threads() -> f64 {
    rayon::current_num_threads() as f64
}

/// Memory for matrices, factors and the basis, known before anything is factorised \[bytes\].
fn model_memory(problem: &Problem, prepared: &Prepared) -> f64 {
    let n = prepared.body.n_dof() as f64;
    let (pencil, space) = (prepared.body.model.pencil(), &prepared.space);
    let matrices = pencil.bytes() as f64;
    let live = space.has_region_parameters();
    // One per distinct stage matrix, and one of the stiffness; every thread has its own at the samples.
    let stages = prepared.scheme.active().len() as f64;
    let marches = !(prepared.exact && problem.basis_kind() == BasisKind::Modes);
    let count = if live {
        threads()
    } else if marches {
        stages
    } else {
        0.0
    };
    let symbolic = &prepared.symbolic;
    let own = if prepared.exact { symbolic.stiffness_bytes() } else { symbolic.factor_bytes() };
    let factors = own as f64 + symbolic.factor_bytes() as f64 * count;
    let modes = problem.basis.modes.unwrap_or(8) as f64;
    let vectors = match problem.basis_kind() {
        // The Krylov space, and the block that joins it.
        BasisKind::Modes => (search_vectors(modes as usize + problem.contact_modes()) as f64).min(n) + 128.0,
        // The snapshots' vectors, a batch of as many, and their orthonormal copies.
        _ => 4.0 * most_vectors(problem) as f64,
    };
    let terms =
        if space.parameters.is_empty() { stages } else { FEW_TERMS.min(problem.tolerance.max_terms) as f64 };
    let chapter = problem.chapter().map_or(0.0, |c| {
        let terms = c.max_terms.map_or(3.0 * modes, |most| most.min(3 * modes as usize) as f64);
        3.0 * modes * c.points as f64 * terms * stages
    });
    matrices + factors + NUMBER * (n * (vectors + terms * modes) + (3.0 * modes).powi(2) + chapter)
}

/// Refuses a model that does not fit, before its factors are allocated.
///
/// # Errors
/// [`TooMuchMemory`].
pub(super) fn check_model(
    problem: &Problem,
    prepared: &Prepared,
    memory: Memory,
) -> Result<(), TooMuchMemory> {
    memory.check(model_memory(problem, prepared), ": a coarser mesh, fewer `basis.modes`", || {
        format!("matrices, factors and basis of {} free dofs", prepared.body.n_dof())
    })
}

/// True where a file gets the residual flexibility, if its basis is diagonal.
pub(super) fn wants_residual(problem: &Problem, prepared: &Prepared) -> bool {
    let diagonal = problem.chapter().is_none() && problem.basis_kind() != BasisKind::Pod;
    let apart = prepared.is_parametric(problem) || !prepared.space.has_region_parameters();
    problem.output.residual.unwrap_or(prepared.exact) && diagonal && apart
}

/// Bytes while the residual flexibility is computed: matrices, what marches, modes, and its own. Its time is
/// reported by its own progress.
fn residual_ahead(problem: &Problem, prepared: &Prepared, full: bool) -> f64 {
    if problem.basis.error.is_none() && !wants_residual(problem, prepared) {
        return 0.0;
    }
    let Prepared { body, symbolic, scheme, .. } = prepared;
    let modes = problem.basis.modes.unwrap_or(8) + problem.contact_modes();
    let stages = if full { scheme.active().len() } else { 0 };
    let factors = symbolic.stiffness_bytes() as f64 + stages as f64 * symbolic.factor_bytes() as f64;
    let kept = body.model.pencil().bytes() as f64 + factors;
    let own = residual::memory(body, symbolic, modes);
    kept + NUMBER * body.n_dof() as f64 * modes as f64 + own
}

/// Bytes of a build of large displacements: matrices, factors, and the largest of what shapes of least
/// energy, strain maps and pushes take. Of a strain map that are the strains of all states and products;
/// `strains` is how many there are. `instants` are the displacements that pushes are kept at, those that
/// choose and those that certify.
pub(super) fn large_memory(
    prepared: &Prepared,
    options: &LargeOptions,
    strains: usize,
    instants: [usize; 2],
) -> f64 {
    let n = prepared.body.n_dof() as f64;
    let [strains, r, states] = [strains, options.coordinates, options.states].map(|count| count as f64);
    let products = 0.5 * r * (r + 1.0);
    let matrices = prepared.body.model.pencil().bytes() as f64;
    let factor = prepared.symbolic.factor_bytes() as f64;
    let [choosing, certifying] = instants.map(|count| NUMBER * n * count as f64);
    // A tangent and its factor on every thread; the states, and once more on their way to the basis.
    let shapes = threads() * (0.5 * matrices + factor) + NUMBER * n * 2.0 * states;
    // The products move the body, and a solve has a copy of that. Regressions have the products of all states
    // three times and some Gram matrices; rows are cut on every thread from a few more.
    let cut = states + 6.0 * products;
    let regression = products * (3.0 * states + 8.0 * products + threads() * cut);
    let maps =
        NUMBER * (strains * (states + r + products) + n * (2.0 * products + 2.0 * states) + regression);
    // The rough march of the certificate and the refined one, beside what chose the map.
    let pushes = threads() * (0.5 * matrices + factor) + choosing + 2.0 * certifying;
    // Every candidate has a basis of its own.
    let bases = NUMBER * n * r * (1 + CANDIDATES) as f64;
    matrices + factor + bases + shapes.max(maps).max(pushes)
}

/// The cost ahead for one size of the basis; `unseen` are the steps of a run of the certificate.
fn plan(
    problem: &Problem,
    prepared: &Prepared,
    full: Option<&FullOrder<'_>>,
    runs: &SnapshotSchedule,
    unseen: usize,
) -> BuildPlan {
    let n = prepared.body.n_dof();
    let live = prepared.space.has_region_parameters();
    let imported = problem.snapshots.npy.is_some() || problem.snapshots.vtu.is_some();
    let marched = problem.basis_kind() != BasisKind::Modes && (live || !imported);
    let mut work = Work::default();
    let mut snapshots = 0.0;
    if let Some(full) = full.filter(|_| marched) {
        let side_by_side = runs.side_by_side(n).min(runs.count());
        let groups = (runs.count() as f64 / side_by_side as f64).ceil();
        let at_once = threads().min(groups);
        let samples = if live { sample_settings(&prepared.space).len() as f64 } else { 1.0 };
        let steps = runs.steps as f64;
        let one = seconds_per_step(full, side_by_side);
        let marches =
            Work { steps: steps * runs.count() as f64, seconds: steps * one * (groups / at_once).ceil() };
        work = work.and(marches.times(samples));
        // Once in memory, and once more on their way to the work folder.
        let kept = 2.0 * runs.snapshots_per_run() as f64 + PER_TRAJECTORY;
        snapshots = NUMBER * n as f64 * side_by_side as f64 * at_once * kept;
    }
    let steps = unseen as f64;
    let seconds = |columns: usize| full.map_or(0.0, |full| seconds_per_step(full, columns));
    let march = Work { steps: TRAJECTORIES as f64 * steps, seconds: steps * seconds(TRAJECTORIES) };
    let corners = if prepared.space.parameters.is_empty() { 1 } else { prepared.space.corners().len() };
    let certificates = corners as f64 + if live { 0.0 } else { f64::from(u8::from(corners > 1)) };
    if !prepared.exact {
        work = work.and(march.times(certificates));
    }
    // Snapshots and the space of the modes are gone when the residual begins.
    let residual = residual_ahead(problem, prepared, full.is_some());
    BuildPlan { work, memory_bytes: (model_memory(problem, prepared) + snapshots).max(residual) }
}

/// The cost ahead, if it fits the machine and does not take longer than was asked for.
///
/// # Errors
/// [`BuildError::Work`], [`BuildError::Memory`].
pub(super) fn checked(
    problem: &Problem,
    (long, memory): (bool, Memory),
    (prepared, full, runs): (&Prepared, Option<&FullOrder<'_>>, &SnapshotSchedule),
    unseen: usize,
) -> Result<BuildPlan, BuildError> {
    let plan = plan(problem, prepared, full, runs, unseen);
    plan.work.check(long, || "this build".into())?;
    let instead = ": a larger `snapshots.stride`, fewer `basis.modes`, a coarser mesh";
    memory.check(plan.memory_bytes, instead, || "matrices, factors, snapshots and basis".into())?;
    Ok(plan)
}

/// In words, for the user.
pub(super) fn in_words(plan: &BuildPlan) -> String {
    let memory = memory_in_words(plan.memory_bytes as u64);
    if plan.work.steps == 0.0 {
        return format!("no time integration needed, at least {memory} of memory");
    }
    format!("{}; {memory} of memory at least", plan.work.in_words())
}
