//! Modal superposition, exact in time: the basis is all there is to the step.

use vademecum_eval::{SceneOptions, StructureChoice};
use vademecum_format::{File, SectionKind};

use super::file::{CertifiedFile, FileStep, encode_file, ratios_of};
use super::reduced::{ReducedModel, factor, factor_bytes};
use super::{BuildContext, BuildError};
use crate::basis::{Basis, BasisError};
use crate::certificate::{
    Candidate, CertificateError, StructureMeasured, StructureReport, certify_exact, kept_certificate,
};
use crate::dynamics::{COUPLED, ModalRatios, coupling_error, fewest_rows};
use crate::export::Draft;
use crate::input::{BasisKind, Fields, Problem};
use crate::prepared::Prepared;
use crate::progress::Stopwatch;
use crate::report::CertificateReport;
use crate::store::Inputs;

/// Largest factor of the stiffness that a file takes without being asked to \[bytes\].
const MAX_FACTOR_UNASKED: usize = 256_000_000;

/// A file of modes that are moved exactly.
///
/// The factor of the stiffness joins it where whole fields need it and the problem leaves that open. Without
/// it the residual flexibility moves no mode, and is added once the reference of the certificate has been
/// solved for with the factor.
pub(super) fn certified(
    context: &BuildContext<'_>,
    problem: &Problem,
    model: &mut ReducedModel,
    watch: &mut Stopwatch<'_>,
) -> Result<CertifiedFile, BuildError> {
    check_ratios(problem, &context.prepared.ratios, &model.basis)?;
    let damping = damping_sections(context, &model.basis)?;
    let mut measured = None;
    if !model.has_factor {
        let sections: Vec<&Draft> = model.sections.iter().chain(&damping).collect();
        let march = || certify(context, problem, &model.basis, &sections, "exact");
        measured = Some(watch.stage("certificate", march)?);
    }
    model.add_residual(context, problem, watch)?;
    let (model, basis) = (&*model, &model.basis);
    let mut sections: Vec<&Draft> = model.sections.iter().chain(&damping).collect();
    let added;
    if measured.as_ref().is_some_and(|measured| wants_factor(context, problem, model, measured)) {
        added = factor(context, problem, watch)?;
        sections.extend(&added);
        measured = None;
    }
    let measured = match measured {
        Some(measured) => measured,
        None => watch.stage("certificate", || certify(context, problem, basis, &sections, "fields"))?,
    };
    let step = FileStep::measured(None, &measured, &StructureMeasured::default());
    let bytes = watch.stage("encode", || encode_file(context, problem, basis, step, sections))?;
    let diagonal = basis.eigenvalues.is_some().then(|| StructureReport::measured(&measured));
    let certificate = CertificateReport { diagonal, ..CertificateReport::within(&problem.tolerance) };
    Ok(CertifiedFile { bytes, certificate, separation: None, large: None })
}

/// Damping ratios of the modes, where there are any.
pub(super) fn damping_section(ratios: &ModalRatios, r: usize) -> Option<Draft> {
    let values = (0..r).map(|k| ratios.of(k));
    (!ratios.is_empty()).then(|| Draft::f64s(SectionKind::DampingRatios, [r, 1, 1], values))
}

/// Damping of the modes beside Rayleigh's: a ratio for each, or, where dashpots couple them by more than
/// [`COUPLED`], the rows of the dashpots along them, and the ratios of what else damps them.
fn damping_sections(context: &BuildContext<'_>, basis: &Basis) -> Result<Vec<Draft>, BuildError> {
    let (prepared, r) = (context.prepared, basis.n_modes());
    let dampers = prepared.body.model.pencil().dampers();
    let change =
        basis.eigenvalues.as_deref().map_or(0.0, |eigenvalues| coupling(prepared, eigenvalues, basis));
    if change <= COUPLED {
        return Ok(damping_section(&ratios_of(prepared, basis), r).into_iter().collect());
    }
    context.kept.listener.note(&format!(
        "dashpots couple the modes: one that is driven at its natural frequency answers up to {:.2} % otherwise; \
         the file holds their damping matrix, and moves all modes together, {} multiply-adds a step",
        100.0 * change,
        4 * r * r
    ));
    let rows = fewest_rows(dampers.along(basis.vectors.as_ref())).map_err(BasisError::from)?;
    let values = (0..rows.nrows()).flat_map(|i| (0..r).map(move |k| (i, k))).map(|place| rows[place]);
    let rows = Draft::f64s(SectionKind::DampingRows, [rows.nrows(), r, 1], values);
    let ratios = match &basis.eigenvalues {
        Some(values) => prepared.modal_ratios(prepared.body.model.pencil(), values, basis.vectors.as_ref()),
        None => prepared.ratios.clone(),
    };
    Ok(damping_section(&ratios, r).into_iter().chain([rows]).collect())
}

/// Change by the coupling that ratios leave out: see [`coupling_error`].
fn coupling(prepared: &Prepared, eigenvalues: &[f64], basis: &Basis) -> f64 {
    let dampers = prepared.body.model.pencil().dampers();
    if dampers.is_empty() {
        return 0.0;
    }
    let vectors = basis.vectors.as_ref();
    let ratios = prepared.modal_ratios(prepared.body.model.pencil(), eigenvalues, vectors);
    let mut damping = dampers.project(vectors);
    for (k, value) in eigenvalues.iter().enumerate() {
        damping[(k, k)] += 2.0 * ratios.decay(&prepared.rayleigh(), eigenvalues, *value);
    }
    coupling_error(eigenvalues, damping.as_ref())
}

/// True where whole fields need the whole static answer: the problem leaves it open, its error is too large
/// without, and the factor is not too large.
fn wants_factor(
    context: &BuildContext<'_>,
    problem: &Problem,
    model: &ReducedModel,
    measured: &StructureMeasured,
) -> bool {
    let whole = problem.output.fields == Fields::Body && model.has_residual;
    // Fields from the factor are those of free dofs, which every node has where nothing is attached.
    let direct = !problem.is_free() && !problem.has_attachments();
    let open = problem.output.static_fields.is_none() && whole && direct;
    let large = measured.certificate.trajectory_error > problem.tolerance.error;
    open && large && factor_bytes(context, problem) <= MAX_FACTOR_UNASKED
}

/// The worst error of the file at the values of the problem file and at the corners of the box of its
/// parameters.
fn certify(
    context: &BuildContext<'_>,
    problem: &Problem,
    basis: &Basis,
    sections: &[&Draft],
    name: &str,
) -> Result<StructureMeasured, BuildError> {
    let BuildContext { prepared, unseen, order, kept, .. } = *context;
    let space = &prepared.space;
    let mut settings = vec![space.nominal()];
    if !space.parameters.is_empty() {
        settings.extend(space.corners());
    }
    // They stay modes where one factor scales all stiffness, and one all mass.
    let natural = problem.basis_kind() == BasisKind::Modes && !space.has_region_parameters();
    let modes = basis.vectors.subcols(0, if natural { basis.n_modes() } else { 0 });
    let bytes = encode_file(context, problem, basis, FileStep::unmeasured(None), sections.iter().copied())?;
    let file = File::parse(&bytes)?;
    let mut worst: Option<StructureMeasured> = None;
    for (place, values) in settings.iter().enumerate() {
        let setting = space.setting(values);
        let mut options = SceneOptions { structure: StructureChoice::Exact, ..SceneOptions::default() };
        for (parameter, &value) in values.iter().enumerate() {
            options.set(file.metadata(), &[(parameter, value)]).map_err(CertificateError::from)?;
        }
        let inputs = |inputs: Inputs| {
            let coupled = sections.iter().any(|section| section.kind == SectionKind::DampingRows);
            let step = (&setting, problem.output.precision, name, ratios_of(prepared, basis), coupled);
            inputs.value(&step).with(basis).with(unseen)
        };
        let measure = || -> Result<_, CertificateError> {
            let pencil = setting.pencil(prepared.body.model.pencil());
            let rayleigh = setting.rayleigh();
            let scale = setting.step.stiffness / setting.step.density;
            let eigenvalues = basis.eigenvalues.iter().flatten();
            let eigenvalues: Vec<f64> = eigenvalues.map(|value| scale * value).collect();
            let decay = |lambda: f64, _| prepared.ratios.decay(&rayleigh, &eigenvalues, lambda);
            let candidate = Candidate { bytes: &bytes, basis, options: &options };
            let model = (&pencil, &prepared.symbolic, modes);
            let nodes = (order, prepared.body.model.dofs());
            Ok(vec![certify_exact(&candidate, nodes, model, &decay, unseen, kept.listener)?])
        };
        let found = kept_certificate(kept, &format!("certificate-{name}-{place}"), inputs, measure)?;
        let found = found.into_iter().next().expect("one structure was measured");
        worst = Some(worst.map_or(found.clone(), |worst| worst.worse(found)));
    }
    Ok(worst.expect("a setting"))
}

/// Ratios of modes that the basis does not have would be lost, and modes of one frequency are any two of
/// their plane, so that different ratios would damp whichever came out of the solver.
fn check_ratios(problem: &Problem, ratios: &ModalRatios, basis: &Basis) -> Result<(), BuildError> {
    const ALIKE: f64 = 1e-6;
    let path = || problem.place("damping.modal");
    let (given, modes) = (ratios.0.len(), basis.n_modes());
    if given > modes {
        return Err(BuildError::RatiosBeyond { path: path(), given, modes });
    }
    let values = basis.eigenvalues.as_deref().unwrap_or(&[]);
    for (k, pair) in values.windows(2).enumerate() {
        let [first, second] = [k, k + 1].map(|k| ratios.of(k));
        if first != second && pair[1] - pair[0] <= ALIKE * pair[1] {
            let hertz = pair[0].sqrt() / std::f64::consts::TAU;
            return Err(BuildError::RatiosOfOneFrequency { path: path(), mode: k + 1, hertz, first, second });
        }
    }
    Ok(())
}
