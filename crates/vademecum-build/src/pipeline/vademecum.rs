//! The three kinds of vademecum a build can make, certified through the evaluator on the bytes that ship.

use vademecum_eval::{SceneOptions, StructureChoice};
use vademecum_format::policy::STABLE_RADIUS;
use vademecum_format::{Certificate, File, SectionKind};

use super::plan::wants_residual;
use super::{BuildError, FACTOR_UNASKED, Stages};
use crate::basis::Basis;
use crate::certificate::{
    Candidate, CertificateError, FIGURES, Figures, FileFigures, StructureMeasured, StructureReport, certify,
    certify_box, certify_exact, kept_certificate,
};
use crate::chapter::{
    self, ChapterCertificate, ChapterMap, ChapterReport, ChapterSetting, ChapterUnseen, certify_chapter,
};
use crate::dynamics::{ModalRatios, ModeRow, mode_table, table_matrix};
use crate::export::{
    Draft, Parts, encode, factor_sections, program, reaction_sections, residual_sections, stress_order,
    stress_sections,
};
use crate::fem::{COMPONENTS, StressRows};
use crate::input::{BasisKind, ChapterEntry, Fields, Precision, Problem, STRESS_UNASKED};
use crate::limits::memory_in_words;
use crate::parametric::{Parametric, SeparationOptions, SeparationRecord, separate_responses};
use crate::prepared::{Body, Prepared};
use crate::progress::{StageTiming, Stopwatch};
use crate::reaction::reactions;
use crate::report::{BuildPlan, BuildReport, CertificateReport};
use crate::residual::{BlockMethod, ResidualBasis, ResidualFlexibility, static_residual, stress_residual};
use crate::response::{BlockTerms, StageResponse, stage_responses};
use crate::store::Inputs;

/// The scheme of large displacements, for people.
const STRAIN_SCHEME: &str = "polarised strain";

/// What the step is made of.
enum Vademecum {
    /// Stage responses at the values of the problem file.
    Fixed(Vec<StageResponse>),
    /// Modes that are moved exactly: the basis is all there is.
    Exact,
    /// Large displacements: the strain map is in sections of its own.
    Large,
    /// Stage responses over the box of the live parameters.
    Parametric(Box<Parametric>),
    /// Stage maps in the chapter's representation, and what was measured of them.
    Chapter(Box<ChapterMap>, ChapterCertificate),
}

/// The same, lent to the encoder.
#[derive(Clone, Copy)]
enum Step<'a> {
    Fixed(&'a [StageResponse]),
    Exact,
    Parametric(&'a Parametric),
    Chapter(&'a ChapterMap, &'a ChapterCertificate),
}

impl Vademecum {
    fn step(&self) -> Step<'_> {
        match self {
            Self::Fixed(responses) => Step::Fixed(responses),
            Self::Exact | Self::Large => Step::Exact,
            Self::Parametric(parametric) => Step::Parametric(parametric),
            Self::Chapter(map, certificate) => Step::Chapter(map, certificate),
        }
    }
}

/// What was measured, per structure; nothing where a file does not have it.
#[derive(Default)]
struct Measured {
    diagonal: StructureMeasured,
    block: StructureMeasured,
}

impl Measured {
    /// As the metadata of the file keep it.
    fn certificate(&self) -> Certificate {
        Certificate { diagonal: self.diagonal.known(), block: self.block.known() }
    }
}

/// A vademecum and what was measured of it.
pub(super) struct Certified {
    vademecum: Vademecum,
    measured: Measured,
    separation: Option<SeparationRecord>,
}

impl Certified {
    /// Of large displacements, whose strain map is in sections of its own.
    pub(super) fn large(measured: StructureMeasured) -> Self {
        let measured = Measured { diagonal: measured, block: StructureMeasured::default() };
        Self { vademecum: Vademecum::Large, measured, separation: None }
    }
}

impl Stages<'_> {
    /// What the basis leaves out of static answers, where the file has the diagonal structure.
    pub(super) fn static_residual(
        &self,
        problem: &Problem,
        basis: &Basis,
        watch: &mut Stopwatch<'_>,
    ) -> Result<Option<ResidualFlexibility>, BuildError> {
        let Self { prepared, order, kept, .. } = *self;
        let body = &prepared.body;
        let wanted = wants_residual(problem, prepared) && order.n_load > 0;
        let Some(eigenvalues) = basis.eigenvalues.as_ref().filter(|_| wanted) else { return Ok(None) };
        let reduced = self.reduced(basis, eigenvalues, problem);
        let nodes = &order.nodes[..order.n_load];
        let triangles = &order.triangles[..order.n_load_triangles];
        let way = BlockMethod::cheaper(body, &prepared.symbolic, eigenvalues.len(), nodes.len());
        let inputs = |inputs: Inputs| {
            let probes: Vec<_> = body.probes.iter().map(|probe| &probe.nodes).collect();
            let inputs = inputs.value(&(reduced.rigorous, way, probes)).with(basis).indices(nodes);
            let inputs = inputs.indices(triangles.as_flattened());
            body.patterns.iter().fold(inputs, |inputs, (_, force)| inputs.numbers(force))
        };
        let solve = || static_residual(&reduced, way, nodes, triangles, kept.listener);
        let found = watch.stage("static residual", || kept.stage("residual", inputs, solve))?;
        Ok(Some(found))
    }

    /// Sections of the stress, with what the modes leave out of it if the file has a `residual`.
    pub(super) fn stress(
        &self,
        problem: &Problem,
        basis: &Basis,
        residual: bool,
        watch: &mut Stopwatch<'_>,
    ) -> Result<Vec<Draft>, BuildError> {
        let Self { prepared, order, kept, .. } = *self;
        let Body { model, stress, .. } = &prepared.body;
        if stress.is_empty() {
            return Ok(vec![]);
        }
        let (output, nodes) = (&problem.output, &order.nodes[..order.n_load]);
        let points = stress_order(stress, order);
        let bytes = (size_of::<f64>() * 3 * COMPONENTS * points.len() * nodes.len()) as u64;
        let contacts = residual && output.stress_residual.unwrap_or(bytes <= STRESS_UNASKED);
        if residual && !contacts && output.stress_residual.is_none() {
            let size = memory_in_words(bytes);
            kept.listener.note(&format!(
                "stress at {} points shows the modes alone under contacts: with all of it the file would hold {size} \
                 more; `output.stress_residual = true` keeps it, and so do fewer nodes in `output.stress`",
                points.len()
            ));
        }
        let vectors = basis.vectors.as_ref();
        let make = || {
            let rows = StressRows::new(model, points)?;
            let eigenvalues = basis.eigenvalues.as_deref().unwrap_or(&[]);
            let reduced = self.reduced(basis, eigenvalues, problem);
            let solve = || stress_residual(&reduced, &rows, nodes, contacts, kept.listener);
            let inputs = |inputs: Inputs| {
                let inputs = inputs.value(&(contacts, &rows.points)).with(basis).indices(nodes);
                prepared.body.patterns.iter().fold(inputs, |inputs, (_, force)| inputs.numbers(force))
            };
            let found = if residual { Some(kept.stage("stress", inputs, solve)?) } else { None };
            let body = (order, model.dofs(), model.materials());
            Ok(stress_sections(&rows, found.as_ref(), vectors, body, output.precision))
        };
        watch.stage("stress", make)
    }

    /// The basis beside the body.
    fn reduced<'b>(
        &'b self,
        basis: &'b Basis,
        eigenvalues: &'b [f64],
        problem: &Problem,
    ) -> ResidualBasis<'b> {
        let Prepared { body, symbolic, exact, .. } = self.prepared;
        // A scheme without stages is exact in time.
        let rigorous = problem.basis_kind() == BasisKind::Modes && *exact;
        ResidualBasis { body, symbolic, vectors: basis.vectors.as_ref(), eigenvalues, rigorous }
    }

    /// The reactions of the supports as the file keeps them, where they are asked for.
    pub(super) fn reactions(
        &self,
        problem: &Problem,
        basis: &Basis,
        watch: &mut Stopwatch<'_>,
    ) -> Result<Vec<Draft>, BuildError> {
        let Self { prepared: Prepared { body, symbolic, .. }, order, .. } = *self;
        if !problem.output.reactions {
            return Ok(vec![]);
        }
        let nodes = &order.nodes[..order.n_load];
        let find = || reactions(body, symbolic, basis.vectors.as_ref(), nodes);
        let found = watch.stage("reactions", find).map_err(BuildError::Reactions)?;
        Ok(reaction_sections(&body.supports, &found))
    }

    /// Whether whole fields need the whole static answer: the problem leaves it open, its error is too large
    /// without, and the factor is not too large.
    pub(super) fn wants_factor(&self, problem: &Problem, certified: &Certified) -> bool {
        let whole = problem.output.fields == Fields::Body && self.residual.is_some();
        let open = problem.output.static_fields.is_none() && whole && !problem.is_free();
        let error = certified.measured.diagonal.certificate.trajectory_error;
        let exact = matches!(certified.vademecum, Vademecum::Exact);
        open && exact && error > problem.tolerance.error && self.factor_bytes(problem) <= FACTOR_UNASKED
    }

    /// Bytes of the factor in a file, without its indices.
    fn factor_bytes(&self, problem: &Problem) -> usize {
        let bytes = self.prepared.symbolic.factor_bytes();
        if problem.output.precision == Precision::F32 { bytes / 2 } else { bytes }
    }

    /// The factor of the stiffness as the file keeps it.
    pub(super) fn factor(
        &self,
        problem: &Problem,
        watch: &mut Stopwatch<'_>,
    ) -> Result<Vec<Draft>, BuildError> {
        let Self { prepared, order, kept, .. } = *self;
        let bytes = memory_in_words(self.factor_bytes(problem) as u64);
        kept.listener.note(&format!(
            "the file keeps the factor of the stiffness, about {bytes}: whole fields show the whole static answer"
        ));
        let precision = problem.output.precision;
        let sections = || factor_sections(&prepared.body, &prepared.symbolic, order, precision);
        Ok(watch.stage("factor for whole fields", sections)?)
    }

    /// The vademecum a problem asks for, and its certificate.
    pub(super) fn certified(
        &self,
        problem: &Problem,
        basis: &Basis,
        watch: &mut Stopwatch<'_>,
    ) -> Result<Certified, BuildError> {
        if let Some(entry) = problem.chapter() {
            self.chapter(problem, &entry, basis, watch)
        } else if self.prepared.exact {
            self.exact(problem, basis, watch)
        } else if self.prepared.space.parameters.is_empty() {
            self.fixed(problem, basis, watch)
        } else {
            self.parametric(problem, basis, watch)
        }
    }

    /// Modes moved exactly, at the values of the problem file and at the corners of the box of its
    /// parameters.
    fn exact(
        &self,
        problem: &Problem,
        basis: &Basis,
        watch: &mut Stopwatch<'_>,
    ) -> Result<Certified, BuildError> {
        let Self { prepared, unseen, order, kept, .. } = *self;
        let space = &prepared.space;
        check_ratios(problem, &prepared.ratios, basis)?;
        let mut settings = vec![space.nominal()];
        if !space.parameters.is_empty() {
            settings.extend(space.corners());
        }
        let name = if self.factor.is_empty() { "exact" } else { "fields" };
        // They stay modes where one factor scales all stiffness, and one all mass.
        let natural = problem.basis_kind() == BasisKind::Modes && !space.has_region_parameters();
        let modes = basis.vectors.subcols(0, if natural { basis.n_modes() } else { 0 });
        let certify = || {
            let bytes = self.encode(problem, basis, Step::Exact, &Measured::default(), None)?;
            let file = File::parse(&bytes)?;
            let mut worst: Option<StructureMeasured> = None;
            for (place, values) in settings.iter().enumerate() {
                let setting = space.setting(values);
                let mut options =
                    SceneOptions { structure: StructureChoice::Exact, ..SceneOptions::default() };
                for (parameter, &value) in values.iter().enumerate() {
                    options.set(file.metadata(), parameter, value).map_err(CertificateError::from)?;
                }
                let inputs = |inputs: Inputs| {
                    let step = (&setting, problem.output.precision, name, &prepared.ratios);
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
            Ok::<_, BuildError>(worst.expect("a setting"))
        };
        let diagonal = watch.stage("certificate", certify)?;
        let measured = Measured { diagonal, block: StructureMeasured::default() };
        Ok(Certified { vademecum: Vademecum::Exact, measured, separation: None })
    }

    /// Both structures at fixed parameters.
    fn fixed(
        &self,
        problem: &Problem,
        basis: &Basis,
        watch: &mut Stopwatch<'_>,
    ) -> Result<Certified, BuildError> {
        let responses = watch.stage("stage responses", || stage_responses(self.prepared, basis))?;
        let residual = responses.iter().map(|r| r.residual).fold(0.0, f64::max);
        let mut structures = vec![StructureChoice::Block];
        structures.extend(basis.eigenvalues.is_some().then_some(StructureChoice::Diagonal));
        let march = || self.march("certificate", problem, basis, Step::Fixed(&responses), &structures);
        let mut found = watch.stage("certificate", march)?.into_iter();
        let mut block = found.next().expect("the block structure was marched");
        (block.certificate.map_error_rms, block.certificate.map_error_max) = (residual, residual);
        let measured = Measured { block, diagonal: found.next().unwrap_or_default() };
        Ok(Certified { vademecum: Vademecum::Fixed(responses), measured, separation: None })
    }

    /// The separated solution and its certificate; with `repair`, as often as it takes to make the step
    /// stable.
    ///
    /// The stage is Galerkin in its lifted space already (with live regions) or the full-order projection
    /// (without), and either is stable as it is: what makes the separated step unstable is what the terms
    /// miss. So the repair is more terms.
    fn parametric(
        &self,
        problem: &Problem,
        basis: &Basis,
        watch: &mut Stopwatch<'_>,
    ) -> Result<Certified, BuildError> {
        const MOST_REPAIRS: usize = 4;
        let tolerance = &problem.tolerance;
        let mut asked = SeparationOptions { tolerance: tolerance.map, max_terms: tolerance.max_terms };
        let mut repairs = vec![];
        loop {
            let separate = || self.separate(basis, &asked);
            let parametric = watch.stage("separate over the parameters", separate)?;
            let certify = || self.over_box(problem, basis, &parametric);
            let (measured, mut record) = watch.stage("certificate", certify)?;
            let radius = measured.block.certificate.spectral_radius;
            if !self.options.repair || radius <= STABLE_RADIUS || repairs.len() == MOST_REPAIRS {
                record.repairs = repairs;
                let vademecum = Vademecum::Parametric(Box::new(parametric));
                return Ok(Certified { vademecum, measured, separation: Some(record) });
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
            self.kept.listener.note(&done);
            repairs.push(done);
        }
    }

    fn separate(&self, basis: &Basis, asked: &SeparationOptions) -> Result<Parametric, BuildError> {
        let (prepared, listener) = (self.prepared, self.kept.listener);
        let inputs =
            |inputs: Inputs| inputs.value(&(&prepared.scheme, prepared.space.effect(), asked)).with(basis);
        let Prepared { body, symbolic, scheme, space, .. } = prepared;
        let pencil = body.model.pencil();
        self.kept.stage("separation", inputs, || {
            Ok(separate_responses(pencil, symbolic, basis, space, scheme, asked, listener)?)
        })
    }

    /// The block structure over the box; the diagonal structure, closed form in every parameter it allows, at
    /// the values of the problem file.
    fn over_box(
        &self,
        problem: &Problem,
        basis: &Basis,
        parametric: &Parametric,
    ) -> Result<(Measured, SeparationRecord), BuildError> {
        let step = Step::Parametric(parametric);
        let bytes = self.encode(problem, basis, step, &Measured::default(), None)?;
        let Self { prepared, order, unseen, kept, .. } = *self;
        let found = certify_box(&bytes, order, prepared, parametric, basis, unseen, kept)?;
        let diagonal = match basis.eigenvalues {
            Some(_) => {
                let structures = [StructureChoice::Diagonal];
                let found = self.march("certificate-diagonal", problem, basis, step, &structures)?;
                found.into_iter().next().expect("one structure was marched")
            }
            None => StructureMeasured::default(),
        };
        let mut record = parametric.record();
        record.parameters = prepared.space.parameters.iter().map(|p| p.name.clone()).collect();
        record.worst_trajectory_at = found.worst_trajectory_at;
        record.worst_radius_at = found.worst_radius_at;
        record.radius_samples = found.radius_samples;
        Ok((Measured { diagonal, block: found.worst }, record))
    }

    /// The unseen loads at the values of the problem file, full order beside structures of the encoded file.
    fn march(
        &self,
        name: &str,
        problem: &Problem,
        basis: &Basis,
        vademecum: Step<'_>,
        structures: &[StructureChoice],
    ) -> Result<Vec<StructureMeasured>, BuildError> {
        let Self { prepared, unseen, order, kept, .. } = *self;
        let inputs = |inputs: Inputs| {
            let step = (&prepared.scheme, &prepared.step, problem.output.precision);
            inputs.value(&step).with(basis).with(unseen)
        };
        kept_certificate(kept, name, inputs, || {
            let bytes = self.encode(problem, basis, vademecum, &Measured::default(), None)?;
            let options = |&structure| SceneOptions { structure, ..SceneOptions::default() };
            let options: Vec<SceneOptions> = structures.iter().map(options).collect();
            let candidate = |options| Candidate { bytes: &bytes, basis, options };
            let candidates: Vec<Candidate<'_>> = options.iter().map(candidate).collect();
            let mass = prepared.body.model.pencil().mass();
            Ok(certify(&candidates, order, mass, self.full(), unseen, kept.listener)?)
        })
    }

    /// The chapter's representation and what is measured of it.
    fn chapter(
        &self,
        problem: &Problem,
        entry: &ChapterEntry,
        basis: &Basis,
        watch: &mut Stopwatch<'_>,
    ) -> Result<Certified, BuildError> {
        let Self { prepared, runs, order, .. } = *self;
        let full = self.full();
        let listener = self.kept.listener;
        let setting = watch.stage("ranges of the axes", || {
            ChapterSetting::new(entry, prepared, basis, full, runs, listener)
        })?;
        let map = watch.stage("chapter separation", || setting.separate(prepared, basis))?;
        let certify = || -> Result<ChapterCertificate, BuildError> {
            let maps = ChapterCertificate::of_maps(&map);
            let bytes =
                self.encode(problem, basis, Step::Chapter(&map, &maps), &Measured::default(), None)?;
            let (body, steps) = (&prepared.body, self.unseen.steps);
            let unseen = ChapterUnseen::draw(&map, body, order, runs, steps);
            let mass = body.model.pencil().mass();
            Ok(certify_chapter(&[(&map, &bytes)], &unseen, mass, full, basis, listener)?.remove(0))
        };
        let certificate = watch.stage("certificate", certify)?;
        if let Some((step, outside)) = &certificate.left {
            listener.note(&format!("step {step} of the certificate left its axes: {outside}"));
        }
        let vademecum = Vademecum::Chapter(Box::new(map), certificate);
        Ok(Certified { vademecum, measured: Measured::default(), separation: None })
    }

    /// The bytes of the file.
    pub(super) fn file(
        &self,
        problem: &Problem,
        basis: &Basis,
        built: &Certified,
    ) -> Result<Vec<u8>, BuildError> {
        let Certified { vademecum, measured, separation } = built;
        self.encode(problem, basis, vademecum.step(), measured, separation.as_ref())
    }

    fn encode(
        &self,
        problem: &Problem,
        basis: &Basis,
        vademecum: Step<'_>,
        measured: &Measured,
        separation: Option<&SeparationRecord>,
    ) -> Result<Vec<u8>, BuildError> {
        let Self { prepared, order, .. } = *self;
        let (block, mut others) = match vademecum {
            Step::Fixed(responses) => (Some(BlockTerms::fixed(responses)), vec![]),
            Step::Exact if prepared.ratios.is_empty() => (None, vec![]),
            Step::Exact => {
                let r = basis.n_modes();
                let ratios = (0..r).map(|k| prepared.ratios.of(k));
                (None, vec![Draft::f64s(SectionKind::DampingRatios, [r, 1, 1], ratios)])
            }
            Step::Parametric(parametric) => (Some(parametric.terms()?), vec![]),
            Step::Chapter(map, certificate) => (None, chapter::sections(map, certificate, order)),
        };
        let chapter = match vademecum {
            Step::Chapter(_, certificate) => certificate.structure.figures,
            _ => Figures::default(),
        };
        let [diagonal, of_block] = [&measured.diagonal, &measured.block].map(|m| m.figures);
        let figures = FileFigures { diagonal, block: of_block, chapter };
        others.push(Draft::f64s(SectionKind::StructureFigures, [3, FIGURES, 1], figures.numbers()));
        let residual = self.residual.map(|residual| residual_sections(residual, problem.output.precision));
        others.extend(residual.into_iter().flatten());
        let apart = self.factor.iter().chain(self.stress).chain(self.reactions).chain(self.strain);
        others.extend(apart.cloned());
        let parts = Parts {
            program: program(prepared.symbolic.solver()),
            problem,
            body: &prepared.body,
            order,
            basis,
            scheme_name: &if problem.is_large() {
                STRAIN_SCHEME.into()
            } else {
                problem.scheme().to_string()
            },
            scheme: prepared.file_scheme(),
            time_step: prepared.step.time_step,
            rayleigh: prepared.rayleigh(),
            diagonal: block.is_some() || matches!(vademecum, Step::Exact),
            block,
            others,
            parameters: Some(&prepared.space),
            separation,
            certificate: measured.certificate(),
            mode_table: table_matrix(&self.modes(basis)),
        };
        Ok(encode(&parts)?)
    }

    fn modes(&self, basis: &Basis) -> Vec<ModeRow> {
        let Self { prepared, .. } = *self;
        let (dt, rayleigh) = (prepared.step.time_step, prepared.rayleigh());
        mode_table(
            &basis.quotients(),
            &basis.energy,
            prepared.file_scheme(),
            (&rayleigh, &prepared.ratios),
            dt,
        )
    }

    /// What was done and measured.
    pub(super) fn report(
        &self,
        problem: &Problem,
        basis: &Basis,
        built: &Certified,
        snapshots: usize,
        timings: Vec<StageTiming>,
        file_bytes: usize,
    ) -> BuildReport {
        let body = &self.prepared.body;
        BuildReport {
            title: problem.title.clone(),
            nodes: body.model.mesh().nodes.len(),
            elements: body.model.mesh().element_region.len(),
            dofs: body.n_dof(),
            modes: basis.n_modes(),
            steps_per_first_period: self.first_period / self.prepared.step.time_step,
            mode_table: self.modes(basis),
            singular_values: basis.singular_values.clone(),
            snapshots,
            certificate: certificate_report(problem, basis, built),
            separation: built.separation.clone(),
            timings,
            file_bytes,
            plan: BuildPlan::default(),
            large: None,
        }
    }
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

/// The certificate as a report shows it.
fn certificate_report(problem: &Problem, basis: &Basis, built: &Certified) -> CertificateReport {
    let (diagonal, block, chapter) = match &built.vademecum {
        Vademecum::Chapter(_, certificate) => (None, None, Some(ChapterReport::new(certificate))),
        _ => {
            let diagonal = basis.eigenvalues.is_some();
            let diagonal = diagonal.then(|| StructureReport::measured(&built.measured.diagonal));
            let block = !matches!(built.vademecum, Vademecum::Exact | Vademecum::Large);
            (diagonal, block.then(|| StructureReport::measured(&built.measured.block)), None)
        }
    };
    CertificateReport {
        diagonal,
        block,
        chapter,
        large: matches!(built.vademecum, Vademecum::Large),
        floor_ratio: problem.tolerance.floor_ratio,
        absolute: problem.tolerance.absolute,
        error: problem.tolerance.error,
        map: problem.tolerance.map,
    }
}
