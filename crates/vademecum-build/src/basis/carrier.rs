//! One basis for a box of region scales: the eigenvectors turn with the contrast between regions, so the
//! basis is the POD of the energy-weighted Ritz vectors of several parameter samples
//! (docs/explanation/4-basis.md).

use faer::{Mat, MatMut, MatRef};

use super::error::BasisError;
use super::pod::{StreamingPod, apply};
use super::ritz::{Basis, pod_basis, ritz_basis, ritz_coordinates};
use super::snapshots::{CachedRuns, SnapshotSchedule, compute};
use crate::dynamics::FullOrder;
use crate::fem::{Pencil, Solve};
use crate::input::Problem;
use crate::prepared::{ParameterSpace, Prepared, Setting};
use crate::store::{Inputs, StageCache};

/// Parameter samples at most: nominal and the corners of the region scales.
const MAX_SAMPLES: usize = 9;

/// The basis and how many snapshots stand behind it.
#[doc(alias = "Krylov enrichment")]
pub(crate) struct Carrier {
    /// The basis, M-orthonormal in the nominal mass.
    pub(crate) basis: Basis,
    /// Snapshots of all samples.
    pub(crate) n_snapshots: usize,
}

/// Snapshots and Ritz vectors at the nominal values and at the corners of the region scales, then their POD.
///
/// # Errors
/// If a march or a factorisation fails, or the samples span fewer dimensions than modes are asked for.
pub(crate) fn carrier_basis(
    problem: &Problem,
    prepared: &Prepared,
    runs: &SnapshotSchedule,
    count: usize,
    kept: &StageCache<'_>,
) -> Result<Carrier, BasisError> {
    let body = &prepared.body;
    let nominal = body.model.pencil();
    let settings = sample_settings(&prepared.space);
    let mut samples = vec![];
    let mut n_snapshots = 0;
    for (i, setting) in settings.iter().enumerate() {
        kept.listener.stage(&format!("snapshots, parameter sample {} of {}", i + 1, settings.len()));
        let wanted = (count, problem.basis.oversampling);
        let inputs = |inputs: Inputs| inputs.value(&(&prepared.scheme, setting, runs, wanted));
        let kept_runs = CachedRuns { kept, inputs: &|inputs| inputs.value(&(&prepared.scheme, setting)) };
        let (ritz, seen) = kept.stage(&format!("sample-{}", i + 1), inputs, || {
            let pencil = setting.pencil(nominal);
            ritz_at(problem, prepared, setting, &pencil, runs, count, &kept_runs)
        })?;
        kept_runs.forget(body, runs);
        n_snapshots += seen;
        samples.push(ritz);
    }
    let shift = middle_eigenvalue(&samples[0]);
    let shifted = nominal.combine(shift, 1.0);
    let inner_product = apply(&shifted);
    let mut union = StreamingPod::new(&inner_product, body.n_dof(), count * settings.len());
    for ritz in &samples {
        // Each vector counts with its energy.
        let weight = |k: usize| (ritz.energy[k] / (shift + ritz.stiffness[(k, k)])).sqrt();
        let weighted =
            Mat::from_fn(body.n_dof(), ritz.n_modes(), |row, k| ritz.vectors[(row, k)] * weight(k));
        union.push(weighted.as_ref())?;
    }
    let pod = union.finish()?;
    let found = pod.singular_values.len();
    if count > found {
        return Err(BasisError::TooManyModes { path: problem.place("basis.modes"), asked: count, found });
    }
    let (mass, stiffness) = (apply(nominal.mass()), apply(nominal.stiffness()));
    let basis = ritz_coordinates(pod_basis(&mass, &stiffness, &pod, count)?)?;
    Ok(Carrier { basis, n_snapshots })
}

/// Geometric mean of the Ritz values: where the inner product `K + λM` of the union turns from mass to
/// stiffness.
///
/// The error of a mode in the energy norm shifts its frequency, so the mass norm alone lets the low modes
/// drift; the energy norm alone spends vectors on stiff local shapes. Measured on a two-material beam at r =
/// 8 over 500 steps: mass 7e-3, energy 6e-4, this 2.4e-4 (floor 2.2e-4).
fn middle_eigenvalue(ritz: &Basis) -> f64 {
    let logarithms = (0..ritz.n_modes()).map(|k| ritz.stiffness[(k, k)].ln());
    (logarithms.sum::<f64>() / ritz.n_modes() as f64).exp()
}

/// The nominal setting and the distinct region scales of the corners, uniform parameters at their nominal
/// values.
pub(crate) fn sample_settings(space: &ParameterSpace) -> Vec<Setting> {
    let nominal = space.setting(&space.nominal());
    let mut settings = vec![nominal.clone()];
    for values in space.corners() {
        let corner = space.setting(&values);
        let setting = Setting { step: nominal.step, ..corner };
        if settings.len() < MAX_SAMPLES && !settings.contains(&setting) {
            settings.push(setting);
        }
    }
    settings
}

/// Ritz vectors of the snapshots at one setting, orthonormal in its mass, and the number of snapshots.
fn ritz_at(
    problem: &Problem,
    prepared: &Prepared,
    setting: &Setting,
    pencil: &Pencil,
    runs: &SnapshotSchedule,
    count: usize,
    kept: &CachedRuns<'_>,
) -> Result<(Basis, usize), BasisError> {
    let Prepared { body, symbolic, scheme, .. } = prepared;
    let full = FullOrder::new(pencil, symbolic, scheme, setting.step.time_step, setting.rayleigh())?;
    let mass = apply(pencil.mass());
    let stiffness = apply(pencil.stiffness());
    let oversampling = problem.basis.oversampling.max(1);
    let pod = compute(body, &full, runs, &mass, 2 * count * oversampling, kept)?;
    let factor = symbolic.factorize(pencil.stiffness().clone())?;
    let static_response = |x: MatRef<'_, f64>, mut y: MatMut<'_, f64>| {
        pencil.mass().mul_into(x, y.as_mut());
        Solve::new(symbolic, y.ncols(), true).solve_in_place(&factor, y);
    };
    let count = count.min(pod.singular_values.len());
    let basis = ritz_basis(&mass, &stiffness, &static_response, &pod, count, oversampling)?;
    Ok((basis, pod.n_snapshots))
}
