//! Measurements of a parametric file over the box of its parameters: at fresh points beside a reference, and
//! at two of them closer.

use std::sync::atomic::{AtomicUsize, Ordering};

use faer::{Mat, MatRef};
use vademecum_eval::{Parametric, SceneOptions, StructureChoice};
use vademecum_format::{File, SectionKind, checksum};

use super::{BuildContext, BuildError};
use crate::basis::Basis;
use crate::certificate::{
    Candidate, CertificateError, StructureMeasured, UnseenLoads, certify_beside, distance_at_full_order,
    kept_certificate,
};
use crate::dynamics::{FirstMode, ReferenceSolution};
use crate::export::{Draft, PointMeasured, PointWitnessed, live_certificate, live_witnesses};
use crate::fem::Pencil;
use crate::parallel;
use crate::prepared::{Design, Setting};
use crate::progress::Quiet;
use crate::residual::{ResidualBasis, static_bound};
use crate::store::Inputs;

/// The worst of all points, and the sections of the points; with a closer look if the file is taken for its
/// error.
pub(super) fn measured_over_box(
    context: &BuildContext<'_>,
    (bytes, basis): (&[u8], &Basis),
    (design, is_taken): (&Design, &dyn Fn(f64) -> bool),
) -> Result<(StructureMeasured, Vec<Draft>), BuildError> {
    let BuildContext { prepared, kept, .. } = *context;
    let done = AtomicUsize::new(0);
    let at = |place: usize| -> Result<StructureMeasured, CertificateError> {
        let values = &design.fresh[place];
        let inputs = |inputs: Inputs| inputs.value(&(values, checksum(bytes))).with(context.unseen);
        let nothing = |_: &BodyAt, _: &ReferenceSolution<'_>, _: &UnseenLoads| Ok(());
        let march = || {
            let body = BodyAt::new(context, (bytes, basis), values)?;
            Ok::<_, CertificateError>(vec![body.measured(context, nothing)?.0])
        };
        let found = kept_certificate(kept, &format!("certificate-point-{}", place + 1), inputs, march)?;
        let finished = 1 + done.fetch_add(1, Ordering::Relaxed);
        kept.listener.checkpoint(finished, design.fresh.len())?;
        Ok(found.into_iter().next().expect("one structure was measured"))
    };
    let at_once = !prepared.symbolic.is_spread();
    let found = match at_once {
        true => parallel::try_map(design.fresh.len(), &at)?,
        false => (0..design.fresh.len()).map(at).collect::<Result<Vec<_>, _>>()?,
    };
    let points = design.fresh.iter().zip(&found).map(|(values, found)| PointMeasured {
        values: values.clone(),
        trained: false,
        error: found.certificate.trajectory_error,
    });
    let points: Vec<PointMeasured> = points.collect();
    note_points(context, &points);
    let worst = points.iter().max_by(|a, b| a.error.total_cmp(&b.error)).expect("fresh points");
    let mut sections = vec![live_certificate(&points)];
    let measured = found.into_iter().reduce(StructureMeasured::worse).expect("a design has fresh points");
    if !is_taken(worst.error) {
        return Ok((measured, sections));
    }
    let closer = [&design.centre, &worst.values];
    let witness = |place: usize| witnessed(context, (bytes, basis), closer[place], place);
    let witnesses = match at_once {
        true => parallel::try_map(closer.len(), &witness)?,
        false => (0..closer.len()).map(witness).collect::<Result<Vec<_>, _>>()?,
    };
    note_witnesses(context, &witnesses);
    sections.push(live_witnesses(&witnesses));
    Ok((measured, sections))
}

fn note_points(context: &BuildContext<'_>, points: &[PointMeasured]) {
    let mut errors: Vec<f64> = points.iter().map(|point| point.error).collect();
    errors.sort_by(f64::total_cmp);
    let at = |share: f64| errors[((errors.len() - 1) as f64 * share).round() as usize];
    context.kept.listener.note(&format!(
        "relative error of trajectories at {} points that trained nothing, the worst load of each: {:.1e} in the \
         median, {:.1e} in 95 %, {:.1e} at worst",
        points.len(),
        at(0.5),
        at(0.95),
        at(1.0)
    ));
}

fn note_witnesses(context: &BuildContext<'_>, witnesses: &[PointWitnessed]) {
    let [centre, worst] = witnesses else { return };
    context.kept.listener.note(&format!(
        "at the centre of the box and at the worst of these points the reference is within {:.1e} and {:.1e} of a \
         march at full order",
        centre.reference, worst.reference
    ));
    if let [Some(centre), Some(worst)] = [centre.bound, worst.bound] {
        context.kept.listener.note(&format!(
            "estimated truncation of a point load there, over all places and directions: {:.1e} and {:.1e} in the \
             median, {:.1e} and {:.1e} in 95 %, {:.1e} and {:.1e} at worst",
            centre[0], worst[0], centre[1], worst[1], centre[2], worst[2]
        ));
    }
}

/// The trajectories at a point, their reference beside the full order, and the truncation bound there.
fn witnessed(
    context: &BuildContext<'_>,
    (bytes, basis): (&[u8], &Basis),
    values: &[f64],
    place: usize,
) -> Result<PointWitnessed, CertificateError> {
    let BuildContext { prepared, order, kept, .. } = *context;
    let inputs = |inputs: Inputs| inputs.value(&(values, checksum(bytes))).with(context.unseen);
    let measure = || -> Result<_, CertificateError> {
        let body = BodyAt::new(context, (bytes, basis), values)?;
        let (measured, reference) = body.measured(context, |body, truth, unseen| {
            let (loads, quiet) = (unseen.timed(), Quiet(kept.listener));
            let step = (&prepared.scheme, body.setting.step.time_step, body.setting.rayleigh());
            let model = (&body.pencil, &prepared.symbolic);
            distance_at_full_order(model, truth, step, (&loads, unseen.steps), &quiet)
        })?;
        let nodes = &order.nodes[..order.n_load];
        let has_residual = File::parse(bytes)?.section(SectionKind::ContactResidual).is_some();
        let bound = match has_residual {
            true => {
                let vectors = body.own.vectors.as_ref();
                let reduced = ResidualBasis {
                    body: &prepared.body,
                    pencil: &body.pencil,
                    symbolic: &prepared.symbolic,
                    vectors,
                    eigenvalues: &body.eigenvalues,
                    rigorous: false,
                };
                let found = static_bound(&reduced, nodes, &Quiet(kept.listener))?;
                Some([found.median, found.most, found.worst])
            }
            false => None,
        };
        let error = measured.certificate.trajectory_error;
        Ok(PointWitnessed { values: values.to_vec(), error, reference, bound })
    };
    kept.stage(&format!("certificate-witness-{}", place + 1), inputs, measure)
}

/// A file at values of its parameters, beside the full model there.
struct BodyAt {
    /// An ordinary file.
    bytes: Vec<u8>,
    /// Its modes.
    own: Basis,
    eigenvalues: Vec<f64>,
    setting: Setting,
    pencil: Pencil,
}

impl BodyAt {
    fn new(
        context: &BuildContext<'_>,
        (bytes, basis): (&[u8], &Basis),
        values: &[f64],
    ) -> Result<Self, CertificateError> {
        let prepared = context.prepared;
        let file = File::parse(bytes)?;
        let model = Parametric::new(&file)?;
        let modes = model.usual_modes();
        let sizes = model.sizes(modes)?;
        let (mut memory, mut work) = (vec![0.0; sizes.memory], vec![0.0; sizes.work.max(sizes.write_work)]);
        let tuned = model.solve(values, modes, &mut memory, &mut work)?;
        let mut lent = vec![0; sizes.bytes];
        let bytes = tuned.write(&model, &mut lent, &mut work)?.bytes().to_vec();
        let shapes = MatRef::from_column_major_slice(tuned.shapes(), basis.n_modes(), modes);
        let eigenvalues = tuned.eigenvalues().to_vec();
        let own = Basis {
            vectors: &basis.vectors * shapes,
            stiffness: Mat::from_fn(modes, modes, |i, j| if i == j { eigenvalues[i] } else { 0.0 }),
            eigenvalues: Some(eigenvalues.clone()),
            energy: vec![],
            singular_values: vec![],
        };
        let setting = prepared.space.setting(values);
        let pencil = setting.pencil(prepared.body.model.pencil());
        Ok(Self { bytes, own, eigenvalues, setting, pencil })
    }

    /// Trajectories beside the reference, and what `look` finds of it.
    fn measured<T>(
        &self,
        context: &BuildContext<'_>,
        look: impl FnOnce(&Self, &ReferenceSolution<'_>, &UnseenLoads) -> Result<T, CertificateError>,
    ) -> Result<(StructureMeasured, T), CertificateError> {
        let BuildContext { prepared, unseen, order, kept, .. } = *context;
        let rayleigh = self.setting.rayleigh();
        let decay = |lambda: f64, _| prepared.ratios.decay(&rayleigh, &self.eigenvalues, lambda);
        let period = FirstMode::find(&self.pencil, &prepared.symbolic)?.period();
        let unseen = &unseen.over(period / self.setting.step.time_step);
        let options = SceneOptions { structure: StructureChoice::Exact, ..SceneOptions::default() };
        let candidate = Candidate { bytes: &self.bytes, basis: &self.own, options: &options };
        let none = self.own.vectors.subcols(0, 0);
        let model = (&self.pencil, &prepared.symbolic, none);
        let nodes = (order, prepared.body.model.dofs());
        let look = |truth: &ReferenceSolution<'_>, unseen: &UnseenLoads| look(self, truth, unseen);
        certify_beside(&candidate, nodes, model, &decay, unseen, &Quiet(kept.listener), look)
    }
}
