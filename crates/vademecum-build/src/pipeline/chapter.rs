//! The chapter's representation.

use super::file::{CertifiedFile, FileStep, encode_file};
use super::{BuildContext, BuildError, ReducedModel};
use crate::certificate::FileFigures;
use crate::chapter::{
    ChapterCertificate, ChapterReport, ChapterSetting, ChapterUnseen, certify_chapter, sections,
};
use crate::export::Draft;
use crate::input::{ChapterEntry, Problem};
use crate::progress::Stopwatch;
use crate::report::CertificateReport;

/// A file of the chapter's structure.
pub(super) fn certified(
    context: &BuildContext<'_>,
    problem: &Problem,
    entry: &ChapterEntry,
    model: &ReducedModel,
    watch: &mut Stopwatch<'_>,
) -> Result<CertifiedFile, BuildError> {
    let BuildContext { prepared, runs, order, .. } = *context;
    let (full, listener, basis) = (context.full(), context.kept.listener, &model.basis);
    let setting = watch
        .stage("ranges of the axes", || ChapterSetting::new(entry, prepared, basis, full, runs, listener))?;
    let map = watch.stage("chapter separation", || setting.separate(prepared, basis))?;
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
        Ok(certify_chapter(&[(&map, &bytes)], &unseen, mass, full, basis, listener)?.remove(0))
    };
    let certificate = watch.stage("certificate", certify)?;
    if let Some((step, outside)) = &certificate.left {
        listener.note(&format!("step {step} of the certificate left its axes: {outside}"));
    }
    let bytes = watch.stage("encode", || encode(&certificate))?;
    let chapter = Some(ChapterReport::new(&certificate));
    let certificate = CertificateReport { chapter, ..CertificateReport::within(&problem.tolerance) };
    Ok(CertifiedFile { bytes, certificate, separation: None, large: None })
}
