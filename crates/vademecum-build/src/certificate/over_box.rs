//! What a parametric build measures over its box: trajectories and energy at the corners, stability at
//! corners and random points. A stage map that is off by 1e-6 is off by more after a thousand steps; only
//! marching tells.

use std::sync::atomic::{AtomicUsize, Ordering};

use vademecum_eval::{SceneOptions, StructureChoice};
use vademecum_format::File;

use super::error::CertificateError;
use super::evaluated::{Candidate, certify, spectral_radius};
use super::kept_certificate;
use super::unseen::UnseenLoads;
use super::verdict::StructureMeasured;
use crate::basis::Basis;
use crate::dynamics::{FirstMode, FullOrder, ModesError};
use crate::export::NodeOrder;
use crate::fem::Pencil;
use crate::parallel;
use crate::parametric::{Parametric, RadiusSample};
use crate::prepared::{ParameterSpace, Prepared, Setting};
use crate::progress::Quiet;
use crate::store::{Inputs, StageCache};

/// Random points at which stability is checked beside the corners.
const STABILITY_POINTS: usize = 100;
/// Where their draw starts.
const SEED: u64 = 9;

/// The certificate of a box and where its worst values lie.
#[derive(Clone, Debug)]
pub(crate) struct BoxCertificate {
    /// Worst values over the box, and the runs at every corner.
    pub(crate) worst: StructureMeasured,
    /// Parameter values at the corner of the largest trajectory error.
    pub(crate) worst_trajectory_at: Vec<f64>,
    /// Parameter values at the largest spectral radius.
    pub(crate) worst_radius_at: Vec<f64>,
    /// The spectral radius at the corners, at the values of the problem file and at random points, in this
    /// order.
    pub(crate) radius_samples: Vec<RadiusSample>,
}

/// Marches unseen loads at every corner of the box, full order beside the file's block structure, and checks
/// stability over it.
///
/// `bytes` is the whole file and `order` its order of nodes.
///
/// # Errors
/// [`CertificateError`]: a march that fails or is stopped, a file the evaluator refuses.
pub(crate) fn certify_box(
    bytes: &[u8],
    order: &NodeOrder,
    prepared: &Prepared,
    parametric: &Parametric,
    basis: &Basis,
    unseen: &UnseenLoads,
    kept: &StageCache<'_>,
) -> Result<BoxCertificate, CertificateError> {
    let space = &prepared.space;
    let file = File::parse(bytes)?;
    let corners = space.corners();
    let done = AtomicUsize::new(0);
    let pencil_at = |setting: &Setting| setting.pencil(prepared.body.model.pencil());
    // Ranks search for one at a time.
    let ahead = prepared.symbolic.is_spread().then(|| {
        let period = |values: &Vec<f64>| -> Result<f64, ModesError> {
            Ok(FirstMode::find(&pencil_at(&space.setting(values)), &prepared.symbolic)?.period())
        };
        corners.iter().map(period).collect::<Result<Vec<f64>, _>>()
    });
    let ahead = ahead.transpose()?;
    let at_corner = |corner: usize| -> Result<StructureMeasured, CertificateError> {
        let values = &corners[corner];
        let options = block_at(&file, values)?;
        let setting = space.setting(values);
        let responses = parametric.responses(&prepared.scheme, &setting)?;
        // Uniform factors are folded into θ by the evaluator and into the pencil for the full-order march.
        let pencil = pencil_at(&setting);
        let period = match &ahead {
            Some(known) => known[corner],
            None => FirstMode::find(&pencil, &prepared.symbolic)?.period(),
        };
        let unseen = &unseen.over(period / setting.step.time_step);
        let inputs = |inputs: Inputs| {
            inputs.value(&(&prepared.scheme, &setting)).with(basis).with(&responses[..]).with(unseen)
        };
        let march =
            || certify_corner(bytes, order, prepared, basis, (&setting, &pencil, &options), unseen, kept);
        let measured = kept_certificate(kept, &format!("certificate-{}", corner + 1), inputs, march)?;
        kept.listener.checkpoint(1 + done.fetch_add(1, Ordering::Relaxed), corners.len())?;
        Ok(measured.into_iter().next().expect("one candidate was measured"))
    };
    let measured = parallel::try_map(corners.len(), &at_corner)?;
    let radius_samples = sample_radius(&file, space, &corners)?;
    let by_radius = |a: &&RadiusSample, b: &&RadiusSample| a.spectral_radius.total_cmp(&b.spectral_radius);
    let least_stable = radius_samples.iter().max_by(by_radius).expect("a box has corners").clone();
    let by_error = |a: &&StructureMeasured, b: &&StructureMeasured| {
        a.certificate.trajectory_error.total_cmp(&b.certificate.trajectory_error)
    };
    let largest = measured.iter().max_by(by_error).expect("a box has corners");
    let at = measured.iter().position(|m| std::ptr::eq(m, largest)).expect("it is one of them");
    let worst_trajectory_at = corners[at].clone();
    let mut worst = measured.into_iter().reduce(StructureMeasured::worse).expect("a box has corners");
    worst.certificate.spectral_radius = least_stable.spectral_radius;
    (worst.certificate.map_error_rms, worst.certificate.map_error_max) = parametric.map_error;
    Ok(BoxCertificate { worst, worst_trajectory_at, worst_radius_at: least_stable.values, radius_samples })
}

/// The block structure of a file at values of its live parameters.
fn block_at(file: &File<'_>, values: &[f64]) -> Result<SceneOptions, CertificateError> {
    let mut options = SceneOptions { structure: StructureChoice::Block, ..SceneOptions::default() };
    for (parameter, &value) in values.iter().enumerate() {
        options.set(file.metadata(), &[(parameter, value)])?;
    }
    Ok(options)
}

/// Trajectories and energy at one corner.
fn certify_corner(
    bytes: &[u8],
    order: &NodeOrder,
    prepared: &Prepared,
    basis: &Basis,
    (setting, pencil, options): (&Setting, &Pencil, &SceneOptions),
    unseen: &UnseenLoads,
    kept: &StageCache<'_>,
) -> Result<Vec<StructureMeasured>, CertificateError> {
    let Prepared { body, symbolic, scheme, .. } = prepared;
    let full = FullOrder::new(pencil, symbolic, scheme, setting.step.time_step, setting.rayleigh())?;
    let mass = body.model.pencil().mass();
    let candidate = Candidate { bytes, basis, options };
    certify(&[candidate], order, mass, &full, unseen, &Quiet(kept.listener))
}

/// Spectral radius at the corners, at the values of the problem file and at random points.
fn sample_radius(
    file: &File<'_>,
    space: &ParameterSpace,
    corners: &[Vec<f64>],
) -> Result<Vec<RadiusSample>, CertificateError> {
    let random = space.random(STABILITY_POINTS, SEED);
    let points: Vec<Vec<f64>> = corners.iter().cloned().chain([space.nominal()]).chain(random).collect();
    parallel::try_map(points.len(), &|at| {
        let values = points[at].clone();
        let spectral_radius = spectral_radius(file, &block_at(file, &values)?)?;
        Ok(RadiusSample { values, spectral_radius })
    })
}
