//! The certificate of large displacements: pushes at full order beside the bytes that ship.

use faer::Mat;
use vademecum_eval::{Body as MovingBody, Place, SceneOptions};
use vademecum_format::File;
use vademecum_format::scheme::MAX_STAGES;

use super::error::CertificateError;
use super::evaluated::{body_memory, body_options};
use super::verdict::StructureMeasured;
use crate::dynamics::TrajectoryError;
use crate::export::NodeOrder;
use crate::large::{ProjectedRun, Push, ReferenceRun};
use crate::prepared::Body;

/// What was measured of one push.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct LargeRun {
    /// Whether the push comes and goes; else it is held and let go at once.
    pub pulse: bool,
    /// How far the surface moves at most \[m\], at full order.
    pub displacement: f64,
    /// What the motion at full order is itself off by, estimated by a march with steps of twice the length;
    /// no number where nobody looked.
    pub reference_error: f64,
    /// The least principal stretch in any element, at full order.
    pub least_stretch: f64,
    /// Error of the file: relative, over all dofs and steps, in the mass norm.
    pub error: f64,
    /// What no motion in its basis can be below.
    pub floor: f64,
    /// The part of the error that is the strain map: from what the basis holds of the motion to the file with
    /// 256 sub-steps in a step.
    pub closure_error: f64,
    /// The part that is the length of the sub-steps: from there to the file as it is.
    pub time_error: f64,
    /// The same error of the linear model with the same coordinates.
    pub linear_error: f64,
    /// Largest violation of the energy's identity in any step, over the largest energy.
    pub energy_identity: f64,
}

/// What was measured of a file of large displacements, as reports show it.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct LargeReport {
    /// How the strain map was found, in words.
    pub strain_map: String,
    /// Strain rows.
    pub rows: usize,
    /// Sub-steps of a step.
    pub substeps: usize,
    /// Geometric mean of the errors on the held-out pushes that chose the map, for it and the maps beside it.
    pub candidates: Vec<(String, f64)>,
    /// Wall time of a step of the file at full order \[s\]: four steps of Bathe's method, with as many pushes
    /// side by side as there are cores; the mean of the pushes of the certificate.
    pub full_order_seconds_per_step: f64,
    /// Pushes that no choice has seen.
    pub runs: Vec<LargeRun>,
}

impl LargeReport {
    /// The runs as the metadata of a file keep them.
    pub(crate) fn measured(&self, steps: usize) -> StructureMeasured {
        let run = |run: &LargeRun| TrajectoryError { error: run.error, floor: run.floor };
        StructureMeasured::of_runs(self.runs.iter().map(run).collect(), steps)
    }
}

/// Sub-steps in a step whose own error in time is far below any other.
pub const CONVERGED_SUBSTEPS: usize = 256;

/// Steps a push through a file: coordinates after each step, one a column, and, where it is `metered`, the
/// largest violation of the energy's identity over the largest energy. A metered step costs three.
///
/// # Errors
/// [`CertificateError`]: a file the evaluator refuses.
fn follow_push(
    bytes: &[u8],
    options: &SceneOptions,
    order: &NodeOrder,
    push: &Push,
    (steps, metered): (usize, bool),
) -> Result<(Mat<f64>, f64), CertificateError> {
    let file = File::parse(bytes)?;
    let options = body_options(options);
    let mut memory = body_memory(&file, &options)?;
    let mut body = MovingBody::bind(&file, &options, &mut memory)?;
    let dt = body.time_step();
    let mut found = Mat::zeros(body.scene().n_modes(), steps);
    let (mut worst, mut largest) = (0.0_f64, f64::MIN_POSITIVE);
    for step in 0..steps {
        // Just after the start of the step and just before its end: a push begins and ends on whole steps.
        let inside = |part: f64| push.within((step as f64 + part) * dt, (step as f64 + 0.5) * dt);
        let mut factors = [0.0; 1 + MAX_STAGES];
        (factors[0], factors[1]) = (inside(0.0), inside(1.0));
        body.clear();
        if factors.iter().any(|&f| f != 0.0) {
            for &(node, force) in &push.nodes {
                let at = order.file_node[node as usize];
                body.push_staged(&Place::triangle([at; 3], [1.0, 0.0, 0.0]), force, &factors)?;
            }
        }
        if metered {
            let (_, account) = body.with(|parts| parts.scene.step_metered(parts.state, parts.loads))?;
            worst = worst.max(account.violation().abs());
            largest = largest.max(account.after);
        } else {
            body.step()?;
        }
        found.col_as_slice_mut(step).copy_from_slice(body.state().zeta());
    }
    Ok((found, worst / largest))
}

/// The motion of a file under one push: coordinates after each step, one a column. With other sub-steps than
/// its own where it is asked for them.
///
/// # Errors
/// [`CertificateError`].
pub(crate) fn push_motion(
    bytes: &[u8],
    order: &NodeOrder,
    reference: &ReferenceRun,
    substeps: Option<usize>,
) -> Result<Mat<f64>, CertificateError> {
    let options = SceneOptions { substeps, ..SceneOptions::default() };
    Ok(follow_push(bytes, &options, order, &reference.push, (reference.displacements.len(), false))?.0)
}

/// One push measured: through the file as it is, with sub-steps so short that only the strain map is left,
/// and through the linear structure of the same file.
///
/// # Errors
/// [`CertificateError`].
pub(crate) fn certify_push(
    bytes: &[u8],
    order: &NodeOrder,
    body: &Body,
    (reference, seen): (&ReferenceRun, &ProjectedRun),
) -> Result<LargeRun, CertificateError> {
    let ReferenceRun { push, displacements, least_stretch, own_error, .. } = reference;
    let steps = displacements.len();
    let (found, energy_identity) = follow_push(bytes, &SceneOptions::default(), order, push, (steps, true))?;
    let linear =
        SceneOptions { structure: vademecum_eval::StructureChoice::Exact, ..SceneOptions::default() };
    let (straight, _) = follow_push(bytes, &linear, order, push, (steps, false))?;
    let short = SceneOptions { substeps: Some(CONVERGED_SUBSTEPS), ..SceneOptions::default() };
    let (converged, _) = follow_push(bytes, &short, order, push, (steps, false))?;
    let TrajectoryError { error, floor } = seen.error(&found);
    Ok(LargeRun {
        pulse: push.pulse,
        displacement: reference.largest_displacement(body),
        least_stretch: *least_stretch,
        reference_error: *own_error,
        error,
        floor,
        closure_error: seen.apart(&converged, &seen.coordinates),
        time_error: seen.apart(&found, &converged),
        linear_error: seen.error(&straight).error,
        energy_identity,
    })
}
