//! One reduced basis for a box of live regions: natural modes at many points of the box, and their proper
//! orthogonal decomposition.
//!
//! Modes at each sample come weighted by 1/λ, as they answer a static load, and are compared in
//! `K + √(λ₁λ_m) M` with the matrices as built. In the basis the stiffness of every point of the box is a sum
//! of one small matrix for each region, so the cost of a point does not depend on the number of elements.

use faer::Mat;

use super::error::BasisError;
use super::pod::{Pod, StreamingPod, apply};
use super::ritz::{Basis, pod_basis, ritz_coordinates};
use crate::dynamics::lowest_modes;
use crate::parallel;
use crate::prepared::{Design, Prepared};
use crate::progress::Listener;
use crate::store::StageCache;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Modes of a sample, and of a sample of up to two live factors, where samples are few.
const MODES: [usize; 2] = [16, 32];
/// Most vectors of the pool.
const MOST: usize = 512;

/// The decomposition of the modes of all samples.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub(crate) struct ModePool {
    /// Vectors, most energetic first, shape (n, up to 512).
    #[serde(with = "crate::linalg::stored")]
    pub(crate) vectors: Mat<f64>,
    /// Their singular values.
    pub(crate) singular_values: Vec<f64>,
    /// Number of modes that were pooled.
    pub(crate) pooled: usize,
}

/// Modes that are taken at each sample.
pub(crate) fn modes_of_sample(prepared: &Prepared, factors: usize) -> usize {
    let wanted = if factors <= 2 { MODES[1] } else { MODES[0] };
    wanted.min(prepared.body.model.pencil().n_elastic())
}

/// The pool of a design.
///
/// # Errors
/// [`BasisError`]: modes of a sample that are not found.
pub(crate) fn pool_modes(
    prepared: &Prepared,
    design: &Design,
    factors: usize,
    kept: &StageCache<'_>,
) -> Result<ModePool, BasisError> {
    let count = modes_of_sample(prepared, factors);
    let samples = design.trained.len();
    let n = prepared.body.n_dof();
    let inputs =
        |inputs: crate::store::Inputs| inputs.value(&(&design.trained, count, prepared.space.effect()));
    kept.stage("modes-of-samples", inputs, || {
        let nominal = prepared.body.model.pencil();
        let done = AtomicUsize::new(0);
        let at = |sample: usize| -> Result<(Mat<f64>, Vec<f64>), BasisError> {
            let setting = prepared.space.setting(&design.trained[sample]);
            let pencil = setting.regional().pencil(nominal);
            let modes = lowest_modes(&pencil, &prepared.symbolic, count)?;
            report(kept.listener, 1 + done.fetch_add(1, Ordering::Relaxed), samples)?;
            Ok((modes.vectors, modes.eigenvalues))
        };
        // Samples of one round are in memory at once; ranks search for one at a time.
        let spread = prepared.symbolic.is_spread();
        let round = if spread { 1 } else { rayon::current_num_threads() };
        let found_from = |begin: usize| match spread {
            true => Ok(vec![at(begin)?]),
            false => parallel::try_map(round.min(samples - begin), &|place| at(begin + place)),
        };
        let mut found = found_from(0)?;
        let values = found[0].1.clone();
        let shift = (values[0] * values[values.len() - 1]).sqrt();
        let shifted = nominal.combine(shift, 1.0);
        let inner_product = apply(&shifted);
        let mut pool = StreamingPod::new(&inner_product, n, most_kept(n, samples * count));
        let mut begin = 0;
        loop {
            for (vectors, eigenvalues) in found.drain(..) {
                let weighed = |i, k| vectors[(i, k)] * values[0] / eigenvalues[k];
                pool.push(Mat::from_fn(n, eigenvalues.len(), weighed).as_ref())?;
            }
            begin += round;
            if begin >= samples {
                break;
            }
            found = found_from(begin)?;
        }
        let pool = pool.finish()?;
        Ok(ModePool {
            vectors: pool.vectors,
            singular_values: pool.singular_values,
            pooled: pool.n_snapshots,
        })
    })
}

/// Most vectors that are kept of so many modes.
fn most_kept(n: usize, modes: usize) -> usize {
    MOST.min(n).min(modes)
}

/// Bytes of a pool while it is merged, counted from below: vectors kept and new, their sum, and its
/// orthonormal factor beside it.
pub(crate) fn pool_memory(prepared: &Prepared, samples: usize, factors: usize) -> f64 {
    let count = modes_of_sample(prepared, factors);
    let n = prepared.body.n_dof();
    let kept = most_kept(n, samples * count);
    let merged = (2 * kept).min(samples * count);
    let round = rayon::current_num_threads().min(samples) * count;
    (size_of::<f64>() * n * (2 * kept + 3 * merged + round)) as f64
}

fn report(listener: &dyn Listener, done: usize, of: usize) -> Result<(), BasisError> {
    listener.checkpoint(done, of).map_err(|cancelled| BasisError::Modes(cancelled.into()))
}

/// The first `count` vectors of a pool, and others beside them, as Ritz vectors of the matrices as built.
///
/// # Errors
/// [`BasisError::NoConvergence`].
pub(crate) fn basis_of_pool(
    prepared: &Prepared,
    pool: &ModePool,
    count: usize,
    others: &Mat<f64>,
) -> Result<Basis, BasisError> {
    let pencil = prepared.body.model.pencil();
    let (mass, stiffness) = (apply(pencil.mass()), apply(pencil.stiffness()));
    let count = count.min(pool.vectors.ncols());
    let mut vectors = Mat::zeros(pool.vectors.nrows(), count + others.ncols());
    vectors.subcols_mut(0, count).copy_from(pool.vectors.subcols(0, count));
    vectors.subcols_mut(count, others.ncols()).copy_from(others);
    let mut singular_values = pool.singular_values[..count].to_vec();
    singular_values.resize(vectors.ncols(), 0.0);
    let pod = Pod {
        vectors,
        singular_values,
        total_energy: pool.singular_values.iter().map(|s| s * s).sum(),
        n_snapshots: pool.pooled,
    };
    let basis = ritz_coordinates(pod_basis(&mass, &stiffness, &pod, count + others.ncols())?)?;
    let eigenvalues = Some((0..basis.n_modes()).map(|k| basis.stiffness[(k, k)]).collect());
    // Ritz values ascend, and no snapshots stand behind them.
    Ok(Basis { eigenvalues, energy: vec![], singular_values: pool.singular_values.clone(), ..basis })
}
