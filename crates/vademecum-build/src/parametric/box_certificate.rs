//! What a parametric build measures over its box: trajectories and energy at the corners, stability at corners and
//! random points. A stage map that is off by 1e-6 is off by more after a thousand steps; only marching tells.

use faer::Mat;
use rayon::prelude::*;
use vademecum_format::StructureCertificate;
use vademecum_format::scheme::SchemeTable;

use super::{ParameterSpace, Parametric, Setting};
use crate::certificate::{ReducedMatrices, UnseenLoads, certify};
use crate::dynamics::FullOrder;
use crate::pipeline::{BuildError, Prepared};
use crate::pod::Basis;
use crate::progress::{Listener, Quiet};
use crate::reduced::{BlockStep, FusedStep, fused_radius};

/// Random points at which stability is checked beside the corners.
const STABILITY_POINTS: usize = 100;

/// The spectral radius of the fused step at a point of the box.
#[derive(Clone, Debug, serde::Serialize)]
pub struct RadiusSample {
    /// Parameter values, in the order of the problem file.
    pub values: Vec<f64>,
    /// Of the block structure's fused step.
    pub spectral_radius: f64,
}

/// The certificate of a box and where its worst values lie.
#[derive(Clone, Debug)]
pub struct BoxCertificate {
    /// Worst values over the box, as the file keeps them.
    pub worst: StructureCertificate,
    /// Parameter values at the corner of the worst trajectory.
    pub worst_trajectory_at: Vec<f64>,
    /// Parameter values at the largest spectral radius.
    pub worst_radius_at: Vec<f64>,
    /// The spectral radius at the corners, at the values of the problem file and at random points, in this order.
    pub radius_samples: Vec<RadiusSample>,
}

/// Marches unseen loads at every corner, full order beside the separated map, and checks stability over the box.
///
/// # Errors
/// If a march fails or is cancelled.
pub fn certify_box(
    prepared: &Prepared,
    parametric: &Parametric,
    basis: &Basis,
    unseen: &UnseenLoads,
    listener: &dyn Listener,
) -> Result<BoxCertificate, BuildError> {
    let Prepared { scheme, space, .. } = prepared;
    let corners = space.corners();
    let done = std::sync::atomic::AtomicUsize::new(0);
    let at_corner = |values: &Vec<f64>| -> Result<StructureCertificate, BuildError> {
        let setting = space.setting(values);
        let certificate = certify_setting(prepared, parametric, basis, &setting, unseen, listener)?;
        let finished = 1 + done.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
        listener.checkpoint(finished, corners.len())?;
        Ok(certificate)
    };
    let measured = corners.par_iter().map(at_corner).collect::<Result<Vec<_>, _>>()?;
    let radius_samples = sample_radius(scheme, space, parametric, &corners)?;
    let by_radius = |a: &&RadiusSample, b: &&RadiusSample| a.spectral_radius.total_cmp(&b.spectral_radius);
    let least_stable = radius_samples.iter().max_by(by_radius).expect("a box has corners").clone();
    let excess = |c: &StructureCertificate| c.trajectory_error / c.projection_floor.max(f64::MIN_POSITIVE);
    let worst = (0..corners.len()).max_by(|&a, &b| excess(&measured[a]).total_cmp(&excess(&measured[b])));
    let worst = worst.expect("a box has corners");
    let energy_ratio = measured.iter().map(|c| c.energy_ratio).fold(0.0, f64::max);
    Ok(BoxCertificate {
        worst: StructureCertificate {
            spectral_radius: least_stable.spectral_radius,
            energy_ratio,
            map_error_rms: parametric.map_error.0,
            map_error_max: parametric.map_error.1,
            ..measured[worst]
        },
        worst_trajectory_at: corners[worst].clone(),
        worst_radius_at: least_stable.values,
        radius_samples,
    })
}

/// Trajectories and energy at one setting.
fn certify_setting(
    prepared: &Prepared,
    parametric: &Parametric,
    basis: &Basis,
    setting: &Setting,
    unseen: &UnseenLoads,
    listener: &dyn Listener,
) -> Result<StructureCertificate, BuildError> {
    let Prepared { body, symbolic, scheme, .. } = prepared;
    // Uniform factors are folded into θ for the reduced step and into the pencil for the full-order one.
    let pencil = setting.pencil(body.model.pencil());
    let full = FullOrder::new(&pencil, symbolic, scheme, setting.step.time_step, setting.rayleigh())?;
    let responses = parametric.responses(scheme, setting)?;
    let step = BlockStep::fuse(scheme, &setting.step, basis.vectors.as_ref(), &responses)?;
    let matrices = ReducedMatrices::new(&pencil, basis.vectors.as_ref());
    let structures: [&dyn FusedStep; 1] = [&step];
    let measured = certify(body, &full, basis, &matrices, &structures, unseen, &Quiet(listener))?;
    Ok(measured[0])
}

/// Spectral radius at the corners, at the values of the problem file and at random points.
fn sample_radius(
    scheme: &SchemeTable,
    space: &ParameterSpace,
    parametric: &Parametric,
    corners: &[Vec<f64>],
) -> Result<Vec<RadiusSample>, BuildError> {
    let points: Vec<Vec<f64>> =
        corners.iter().cloned().chain([space.nominal()]).chain(space.random(STABILITY_POINTS, 9)).collect();
    let sample = |values: Vec<f64>| -> Result<RadiusSample, BuildError> {
        let setting = space.setting(&values);
        let states: Vec<Mat<f64>> = parametric.states(scheme, &setting)?;
        Ok(RadiusSample { values, spectral_radius: fused_radius(scheme, &setting.step, &states)? })
    };
    points.into_par_iter().map(sample).collect()
}
