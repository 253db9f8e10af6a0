//! From a problem to its basis: which snapshots, which vectors, how many.

use faer::prelude::ReborrowMut;

use super::carrier::carrier_basis;
use super::error::BasisError;
use super::pod::{Apply, Pod, apply};
use super::ritz::{Basis, modes_basis, pod_basis, ritz_basis};
use super::snapshots::{CachedRuns, SnapshotError, SnapshotSchedule, compute, import};
use crate::dynamics::{FirstMode, FullOrder, Modes, lowest_modes_kept};
use crate::fem::Solve;
use crate::input::{BasisKind, InnerProduct, Problem};
use crate::prepared::{Body, Prepared};
use crate::progress::Listener;
use crate::residual::{ModeSearch, modes_within};
use crate::store::{CachedSolves, Inputs, StageCache};

/// The snapshots of the plan, or those of another program, decomposed; none for natural modes, which need
/// none.
///
/// # Errors
/// [`SnapshotError`].
pub fn decompose(
    problem: &Problem,
    body: &Body,
    full: Option<&FullOrder<'_>>,
    runs: &SnapshotSchedule,
    kept: &CachedRuns<'_>,
) -> Result<Option<Pod>, SnapshotError> {
    if problem.basis_kind() == BasisKind::Modes {
        return Ok(None);
    }
    let pencil = body.model.pencil();
    let (mass, stiffness) = (apply(pencil.mass()), apply(pencil.stiffness()));
    let identity = |x: faer::MatRef<'_, f64>, mut y: faer::MatMut<'_, f64>| y.copy_from(x);
    let inner_product: Apply<'_> = match problem.basis.inner_product {
        InnerProduct::Mass => &mass,
        InnerProduct::Stiffness => &stiffness,
        InnerProduct::Identity => &identity,
    };
    let imported = problem.snapshots.npy.is_some() || problem.snapshots.vtu.is_some();
    let rank = most_vectors(problem);
    let pod = if imported {
        import(body, problem, inner_product, rank, kept.kept.listener)?
    } else {
        compute(body, full.expect("snapshots are marched at full order"), runs, inner_product, rank, kept)?
    };
    Ok(Some(pod))
}

/// POD vectors kept while streaming: twice what the basis takes, so that truncation stays far below what is
/// used.
pub(crate) fn most_vectors(problem: &Problem) -> usize {
    const BY_ENERGY: usize = 128;
    2 * problem.basis.modes.map_or(BY_ENERGY, |r| r * oversampling(problem)).max(16)
}

fn oversampling(problem: &Problem) -> usize {
    if problem.basis_kind() == BasisKind::Ritz { problem.basis.oversampling } else { 1 }
}

const DEFAULT_MODES: usize = 8;

/// Snapshots and the basis of the kind asked for, with the number of snapshots. `full` marches the snapshots;
/// natural modes do without.
///
/// # Errors
/// [`BasisError`].
pub(crate) fn find_basis(
    problem: &Problem,
    prepared: &Prepared,
    full: Option<&FullOrder<'_>>,
    runs: &SnapshotSchedule,
    kept: &StageCache<'_>,
) -> Result<(Basis, usize), BasisError> {
    if prepared.space.has_region_parameters() && problem.basis_kind() != BasisKind::Modes {
        let count = problem.basis.modes.unwrap_or(DEFAULT_MODES);
        let carrier = carrier_basis(problem, prepared, runs, count, kept)?;
        return Ok((carrier.basis, carrier.n_snapshots));
    }
    let inputs = |inputs: Inputs| basis_inputs(inputs, problem, prepared, runs);
    let Prepared { scheme, step, body, .. } = prepared;
    let kept_runs = CachedRuns { kept, inputs: &|inputs| inputs.value(&(scheme, step)) };
    let solves = &kept.solves(&prepared.symbolic.solver());
    let find = || nominal_basis(problem, prepared, full, runs, (&kept_runs, solves));
    let found = kept.stage("basis", inputs, find)?;
    kept_runs.forget(body, runs);
    solves.forget();
    Ok(found)
}

/// The same at the values of the problem file.
fn nominal_basis(
    problem: &Problem,
    prepared: &Prepared,
    full: Option<&FullOrder<'_>>,
    runs: &SnapshotSchedule,
    (kept, solves): (&CachedRuns<'_>, &CachedSolves<'_>),
) -> Result<(Basis, usize), BasisError> {
    let (body, pencil) = (&prepared.body, prepared.body.model.pencil());
    let Some(pod) = decompose(problem, body, full, runs, kept)? else {
        let begun = (solves, prepared.first_mode.as_ref());
        let Modes { vectors, eigenvalues, .. } = match problem.basis.error {
            Some(error) => enough_modes(problem, prepared, error, kept.kept.listener, begun)?,
            None => {
                let count = problem.basis.modes.unwrap_or(DEFAULT_MODES);
                lowest_modes_kept(pencil, &prepared.symbolic, count, begun)?
            }
        };
        return Ok((modes_basis(vectors, eigenvalues), 0));
    };
    let found = pod.singular_values.len();
    let count = match (problem.basis.modes, problem.basis.energy) {
        (Some(count), _) => count,
        (None, Some(fraction)) => pod.count_for_energy(fraction),
        (None, None) => DEFAULT_MODES.min(found),
    };
    if count > found {
        return Err(BasisError::TooManyModes { path: problem.place("basis.modes"), asked: count, found });
    }
    Ok((basis_of_pod(problem, prepared, &pod, count)?, pod.n_snapshots))
}

/// The fewest natural modes that keep the bound asked for.
fn enough_modes(
    problem: &Problem,
    prepared: &Prepared,
    error: f64,
    listener: &dyn Listener,
    begun: (&CachedSolves<'_>, Option<&FirstMode>),
) -> Result<Modes, BasisError> {
    match modes_within(&prepared.body, &prepared.symbolic, error, listener, begun)? {
        ModeSearch::Modes(modes, reached) => {
            listener
                .note(&format!("{} natural modes have a bound of {reached:.2e}", modes.eigenvalues.len()));
            Ok(modes)
        }
        ModeSearch::Missed { modes, reached } => {
            let path = problem.place("basis.error");
            Err(BasisError::BoundMissed { path, asked: error, modes, reached })
        }
    }
}

/// The basis of the kind asked for, `pod` or `ritz`, from a decomposition of the snapshots.
///
/// # Errors
/// [`BasisError`]: a stiffness that does not factorise, numbers outside the range of double precision.
pub fn basis_of_pod(
    problem: &Problem,
    prepared: &Prepared,
    pod: &Pod,
    count: usize,
) -> Result<Basis, BasisError> {
    let pencil = prepared.body.model.pencil();
    let (mass, stiffness) = (apply(pencil.mass()), apply(pencil.stiffness()));
    let basis = if problem.basis_kind() == BasisKind::Pod {
        pod_basis(&mass, &stiffness, pod, count)?
    } else {
        let factor = prepared.symbolic.factor_of(pencil.stiffness())?;
        let static_response = |x: faer::MatRef<'_, f64>, mut y: faer::MatMut<'_, f64>| {
            pencil.mass().mul_into(x, y.rb_mut());
            Solve::new(&prepared.symbolic, y.ncols(), true).solve_in_place(&factor, y);
        };
        ritz_basis(&mass, &stiffness, &static_response, pod, count, problem.basis.oversampling)?
    };
    Ok(basis)
}

/// Inputs of the basis at the values of the problem file, besides the model.
fn basis_inputs(inputs: Inputs, problem: &Problem, prepared: &Prepared, runs: &SnapshotSchedule) -> Inputs {
    let Prepared { scheme, step, body, .. } = prepared;
    let plan = &problem.snapshots;
    let imported = plan.npy.iter().chain(plan.vtu.iter().flatten());
    match problem.basis_kind() {
        BasisKind::Modes => inputs.value(&problem.basis),
        _ if plan.npy.is_some() || plan.vtu.is_some() => {
            let known = inputs.value(&(&problem.basis, &plan.field, body.mesh_hash));
            imported.fold(known, |inputs, path| inputs.file(&problem.resolve(path)))
        }
        _ => inputs.value(&(&problem.basis, scheme, step, runs)),
    }
}
