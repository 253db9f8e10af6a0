//! Separated time steps over live parameters.

use vademecum_eval::StructureChoice;
use vademecum_format::policy::STABLE_RADIUS;

use super::file::{CertifiedFile, FileStep, encode_file};
use super::staged::march;
use super::{BuildContext, BuildError, ReducedModel};
use crate::basis::Basis;
use crate::certificate::{StructureMeasured, StructureReport, certify_box};
use crate::input::{Problem, Tolerances};
use crate::parametric::{Parametric, SeparationOptions, SeparationRecord, separate_responses};
use crate::prepared::Prepared;
use crate::progress::Stopwatch;
use crate::report::CertificateReport;
use crate::separated::StopReason;
use crate::store::Inputs;

/// Separations of one file at most, after the first.
const MAX_REPAIRS: usize = 4;

/// Errors of the diagonal and of the block structure over the box.
struct BoxMeasured {
    diagonal: Option<StructureMeasured>,
    block: StructureMeasured,
}

/// A file of the separated solution; with `repair` it is separated as often as it takes to make the step
/// stable.
///
/// The stage is Galerkin in its lifted space already (with live regions) or the full-order projection
/// (without), and either is stable as it is: what makes the separated step unstable is what the terms
/// miss. So the repair is more terms.
pub(super) fn certified(
    context: &BuildContext<'_>,
    problem: &Problem,
    model: &ReducedModel,
    watch: &mut Stopwatch<'_>,
) -> Result<CertifiedFile, BuildError> {
    let basis = &model.basis;
    let (parametric, measured, record) = stable(context, problem, model, watch)?;
    let encode = || {
        let diagonal = measured.diagonal.clone().unwrap_or_default();
        let step = FileStep::measured(Some(parametric.terms()?), &diagonal, &measured.block);
        encode_file(context, problem, basis, FileStep { separation: Some(&record), ..step }, &model.sections)
    };
    let bytes = watch.stage("encode", encode)?;
    let certificate = CertificateReport {
        diagonal: measured.diagonal.as_ref().map(StructureReport::measured),
        block: Some(StructureReport::measured(&measured.block)),
        ..CertificateReport::within(&problem.tolerance)
    };
    Ok(CertifiedFile { bytes, certificate, separation: Some(record), large: None })
}

/// Separates until the step is stable, or the options or [`MAX_REPAIRS`] end it.
fn stable(
    context: &BuildContext<'_>,
    problem: &Problem,
    model: &ReducedModel,
    watch: &mut Stopwatch<'_>,
) -> Result<(Parametric, BoxMeasured, SeparationRecord), BuildError> {
    let tolerance = &problem.tolerance;
    let mut asked = SeparationOptions { tolerance: tolerance.map, max_terms: tolerance.max_terms };
    let mut repairs = vec![];
    loop {
        let separate = || separate(context, &model.basis, &asked);
        let parametric = watch.stage("separate over the parameters", separate)?;
        if let Some(note) = missed_maps(&parametric, tolerance) {
            context.kept.listener.note(&note);
        }
        let certify = || over_box(context, problem, model, &parametric);
        let (measured, mut record) = watch.stage("certificate", certify)?;
        let radius = measured.block.certificate.spectral_radius;
        if !context.options.repair || radius <= STABLE_RADIUS || repairs.len() == MAX_REPAIRS {
            record.repairs = repairs;
            return Ok((parametric, measured, record));
        }
        let terms = record.terms;
        asked = SeparationOptions {
            tolerance: (0.1 * asked.tolerance).max(1e-11),
            max_terms: 2 * asked.max_terms,
        };
        let done = format!(
            "spectral radius 1{:+.1e} at {} with {terms} terms: separated again to {:.0e}, at most {} terms",
            radius - 1.0,
            record.place(&record.worst_radius_at),
            asked.tolerance,
            asked.max_terms
        );
        context.kept.listener.note(&done);
        repairs.push(done);
    }
}

/// Note that a separation misses the tolerance of its maps: what follows takes long, and cannot mend it.
fn missed_maps(parametric: &Parametric, tolerance: &Tolerances) -> Option<String> {
    let (rms, worst) = parametric.map_error;
    let kept = rms <= tolerance.map && worst <= 10.0 * tolerance.map;
    (!kept).then(|| {
        format!(
            "the separated maps of {} terms miss their tolerance: error {rms:.1e} rms, {worst:.1e} at worst, \
             `tolerance.map` is {:.1e}; {}. What follows measures them, and no file is written unless a larger basis \
             keeps the tolerance or `--keep-missed` is given",
            parametric.record().terms,
            tolerance.map,
            match parametric.record().stop {
                StopReason::MaxTerms => "raise `tolerance.max_terms` or `tolerance.map`, or narrow the ranges",
                _ => "more terms did not lower it: raise `tolerance.map`, or narrow the ranges",
            }
        )
    })
}

fn separate(
    context: &BuildContext<'_>,
    basis: &Basis,
    asked: &SeparationOptions,
) -> Result<Parametric, BuildError> {
    let (prepared, listener) = (context.prepared, context.kept.listener);
    let inputs =
        |inputs: Inputs| inputs.value(&(&prepared.scheme, prepared.space.effect(), asked)).with(basis);
    let Prepared { body, symbolic, scheme, space, .. } = prepared;
    let pencil = body.model.pencil();
    context.kept.stage("separation", inputs, || {
        Ok(separate_responses(pencil, symbolic, basis, space, scheme, asked, listener)?)
    })
}

/// The block structure over the box; the diagonal structure, closed form in every parameter it allows, at
/// the values of the problem file.
fn over_box(
    context: &BuildContext<'_>,
    problem: &Problem,
    model: &ReducedModel,
    parametric: &Parametric,
) -> Result<(BoxMeasured, SeparationRecord), BuildError> {
    let BuildContext { prepared, order, unseen, kept, .. } = *context;
    let basis = &model.basis;
    let terms = || Ok(parametric.terms()?);
    let bytes = encode_file(context, problem, basis, FileStep::unmeasured(Some(terms()?)), &model.sections)?;
    let found = certify_box(&bytes, order, prepared, parametric, basis, unseen, kept)?;
    let diagonal = || {
        let structures = [StructureChoice::Diagonal];
        let found = march(context, "certificate-diagonal", problem, model, terms, &structures)?;
        Ok::<_, BuildError>(found.into_iter().next().expect("one structure was marched"))
    };
    let diagonal = basis.eigenvalues.is_some().then(diagonal).transpose()?;
    let mut record = parametric.record();
    record.parameters = prepared.space.parameters.iter().map(|p| p.name.clone()).collect();
    record.worst_trajectory_at = found.worst_trajectory_at;
    record.worst_radius_at = found.worst_radius_at;
    record.radius_samples = found.radius_samples;
    Ok((BoxMeasured { diagonal, block: found.worst }, record))
}
