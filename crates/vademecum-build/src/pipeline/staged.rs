//! Separated time steps at fixed parameters: one response per stage of the scheme.

use vademecum_eval::{SceneOptions, StructureChoice};

use super::file::{CertifiedFile, FileStep, encode_file};
use super::{BuildContext, BuildError, ReducedModel};
use crate::certificate::{Candidate, StructureMeasured, StructureReport, certify, kept_certificate};
use crate::input::Problem;
use crate::progress::Stopwatch;
use crate::report::CertificateReport;
use crate::response::{BlockTerms, stage_responses};
use crate::store::Inputs;

/// A file of both structures, the block one and, where the basis is diagonal, the diagonal one.
pub(super) fn certified(
    context: &BuildContext<'_>,
    problem: &Problem,
    model: &ReducedModel,
    watch: &mut Stopwatch<'_>,
) -> Result<CertifiedFile, BuildError> {
    let basis = &model.basis;
    let responses = watch.stage("stage responses", || stage_responses(context.prepared, basis))?;
    let residual = responses.iter().map(|r| r.residual).fold(0.0, f64::max);
    let mut structures = vec![StructureChoice::Block];
    structures.extend(basis.eigenvalues.is_some().then_some(StructureChoice::Diagonal));
    let terms = || Ok(BlockTerms::fixed(&responses));
    let march = || march(context, "certificate", problem, model, terms, &structures);
    let mut found = watch.stage("certificate", march)?.into_iter();
    let mut block = found.next().expect("the block structure was marched");
    (block.certificate.map_error_rms, block.certificate.map_error_max) = (residual, residual);
    let diagonal = found.next();
    let encode = || {
        let measured = diagonal.clone().unwrap_or_default();
        let step = FileStep::measured(Some(BlockTerms::fixed(&responses)), &measured, &block);
        encode_file(context, problem, basis, step, &model.sections)
    };
    let bytes = watch.stage("encode", encode)?;
    let certificate = CertificateReport {
        diagonal: diagonal.as_ref().map(StructureReport::measured),
        block: Some(StructureReport::measured(&block)),
        ..CertificateReport::within(&problem.tolerance)
    };
    Ok(CertifiedFile { bytes, certificate, separation: None, large: None })
}

/// The unseen loads at the values of the problem file, full order beside structures of the encoded file.
pub(super) fn march<'t>(
    context: &BuildContext<'_>,
    name: &str,
    problem: &Problem,
    model: &ReducedModel,
    block: impl FnOnce() -> Result<BlockTerms<'t>, BuildError>,
    structures: &[StructureChoice],
) -> Result<Vec<StructureMeasured>, BuildError> {
    let BuildContext { prepared, unseen, order, kept, .. } = *context;
    let basis = &model.basis;
    let inputs = |inputs: Inputs| {
        let step = (&prepared.scheme, &prepared.step, problem.output.precision);
        inputs.value(&step).with(basis).with(unseen)
    };
    kept_certificate(kept, name, inputs, || {
        let step = FileStep::unmeasured(Some(block()?));
        let bytes = encode_file(context, problem, basis, step, &model.sections)?;
        let options = |&structure| SceneOptions { structure, ..SceneOptions::default() };
        let options: Vec<SceneOptions> = structures.iter().map(options).collect();
        let candidate = |options| Candidate { bytes: &bytes, basis, options };
        let candidates: Vec<Candidate<'_>> = options.iter().map(candidate).collect();
        let mass = prepared.body.model.pencil().mass();
        Ok(certify(&candidates, order, mass, context.full(), unseen, kept.listener)?)
    })
}
