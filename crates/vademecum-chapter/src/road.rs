//! The chapter's road through a build.

use vademecum_build::certificate::FileFigures;
use vademecum_build::export::Draft;
use vademecum_build::input::{ChapterEntry, Problem};
use vademecum_build::pipeline::{
    self, BuildContext, BuildError, BuildOptions, CertifiedFile, FileStep, Outcome, ReducedModel,
    encode_file, with_context,
};
use vademecum_build::progress::{Listener, Stopwatch};
use vademecum_build::report::CertificateReport;

use crate::certificate::{ChapterCertificate, ChapterUnseen, certify_chapter};
use crate::error::ChapterError;
use crate::map::ChapterSetting;
use crate::report::report_of;
use crate::sections::sections;

/// Runs the whole build of any problem: the chapter's representation here, every other one by
/// [`vademecum_build::pipeline::build`].
///
/// # Errors
/// [`BuildError`], by stage; [`BuildError::Other`] with a [`ChapterError`].
pub fn build(
    problem: &Problem,
    options: &BuildOptions<'_>,
    listener: &dyn Listener,
) -> Result<Outcome, BuildError> {
    let Some(entry) = problem.chapter() else { return pipeline::build(problem, options, listener) };
    with_context(problem, options, listener, |context, watch| {
        let plan = context.plan(problem)?;
        let mut model = ReducedModel::new(context, problem, &plan, watch)?;
        model.add_residual(context, problem, watch)?;
        let certified = certified(context, problem, &entry, &model, watch);
        context.check_engine()?;
        let built = certified?.reported(context, problem, (&model.basis, model.snapshots), plan, watch);
        Ok(if built.report.certificate.holds() {
            Outcome::Kept(built)
        } else {
            listener.note(&format!("{} modes do not keep the tolerance", built.report.modes));
            Outcome::Missed(built)
        })
    })
}

fn other(error: ChapterError) -> BuildError {
    BuildError::Other(Box::new(error))
}

/// A file of the chapter's structure.
fn certified(
    context: &BuildContext<'_>,
    problem: &Problem,
    entry: &ChapterEntry,
    model: &ReducedModel,
    watch: &mut Stopwatch<'_>,
) -> Result<CertifiedFile, BuildError> {
    let BuildContext { prepared, runs, order, .. } = *context;
    let (full, listener, basis) = (context.full(), context.kept.listener, &model.basis);
    let setting = watch
        .stage("ranges of the axes", || ChapterSetting::new(entry, prepared, basis, full, runs, listener))
        .map_err(other)?;
    let map = watch.stage("chapter separation", || setting.separate(prepared, basis)).map_err(other)?;
    let encode = |certificate: &ChapterCertificate| {
        let sections: Vec<Draft> = sections(&map, certificate, order);
        let figures = FileFigures { chapter: certificate.structure.figures, ..FileFigures::default() };
        let step = FileStep { figures, ..FileStep::default() };
        encode_file(context, problem, basis, step, model.sections.iter().chain(&sections))
    };
    let certify = || -> Result<ChapterCertificate, BuildError> {
        let bytes = encode(&ChapterCertificate::of_maps(&map))?;
        let unseen = ChapterUnseen::draw(&map, &prepared.body, order, runs, context.unseen.steps);
        let mass = prepared.body.model.pencil().mass();
        let found = certify_chapter(&[(&map, &bytes)], &unseen, mass, full, basis, listener);
        Ok(found.map_err(other)?.remove(0))
    };
    let certificate = watch.stage("certificate", certify)?;
    if let Some((step, outside)) = &certificate.left {
        listener.note(&format!("step {step} of the certificate left its axes: {outside}"));
    }
    let bytes = watch.stage("encode", || encode(&certificate))?;
    let chapter = Some(report_of(&certificate));
    let certificate = CertificateReport { chapter, ..CertificateReport::within(&problem.tolerance) };
    Ok(CertifiedFile { bytes, certificate, separation: None, large: None })
}
