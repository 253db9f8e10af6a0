//! The whole build on one page, one call per stage: mesh → model → snapshots → basis → vademecum → bytes.

mod live;

use live::{build_with_growing_carrier, carrier_size_is_free, separate_and_certify};

use faer::prelude::ReborrowMut;
use vademecum_format::FormatError;
use vademecum_format::scheme::SchemeTable;
use vademecum_format::scheme::{StepParameters, TableError};
use vademecum_format::{Certificate, StructureCertificate};

use crate::body::{Body, BodyError, read_mesh};
use crate::canonical::{CanonicalCertificate, CanonicalMap, CanonicalSetting, certify_canonical};
use crate::certificate::{ReducedMatrices, UnseenLoads, certify};
use crate::dynamics::{
    DampingError, FullOrder, FullOrderError, Modes, ModesError, Rayleigh, lowest_modes, numerical_damping,
};
use crate::export::{BlockTerms, Parts, encode};
use crate::fem::{FactorError, Solve, Symbolic};
use crate::march::MarchError;
use crate::mesh::{Mesh, Order};
use crate::parametric::{
    ParameterSpace, Parametric, ParametricError, SeparationOptions, carrier_basis, certify_box,
    separate_responses,
};
use crate::pod::{Apply, Basis, Pod, apply, modes_basis, pod_basis, ritz_basis};
use crate::problem::{BasisKind, CanonicalEntry, InnerProduct, Problem};
use crate::progress::{Cancelled, Listener, Stopwatch};
use crate::reduced::{BlockStep, DiagonalStep, FusedStep};
pub use crate::report::{
    CanonicalReport, CertificateReport, ModeRow, Report, SeparationReport, StructureReport,
};
use crate::report::{canonical_report, certificate_report};
pub(crate) use crate::report::{mode_table, table_matrix};
use crate::response::StageResponse;
use crate::resume::{Inputs, Kept, Store};
use crate::separated::SeparatedError;
use crate::snapshots::{self, Runs, SnapshotError};

/// Why a build ended without a file.
#[derive(Debug, thiserror::Error)]
pub enum BuildError {
    /// Problem and mesh do not fit.
    #[error(transparent)]
    Body(#[from] BodyError),
    /// The damping feeds energy into some mode.
    #[error("`damping`")]
    Damping(#[from] DampingError),
    /// The scheme's parameters are unusable.
    #[error("`time.scheme`")]
    Scheme(#[from] crate::dynamics::SchemeError),
    /// The scheme's table is unusable.
    #[error("`time.scheme`")]
    Table(#[from] TableError),
    /// A matrix does not factorise.
    #[error("a matrix of the model does not factorise")]
    Factor(#[from] FactorError),
    /// The full-order march cannot start.
    #[error("the full-order march cannot start")]
    FullOrder(#[from] FullOrderError),
    /// No natural modes.
    #[error("natural modes")]
    Modes(#[from] ModesError),
    /// No snapshots.
    #[error(transparent)]
    Snapshots(#[from] SnapshotError),
    /// The certificate's march failed.
    #[error("certificate")]
    March(#[from] MarchError),
    /// More modes asked for than the snapshots span.
    #[error(
        "{path}: `basis.modes` is {asked}; the snapshots span {found} dimensions: add positions, directions or time to `[snapshots]`"
    )]
    TooManyModes {
        /// The problem file and line.
        path: String,
        /// Modes asked for.
        asked: usize,
        /// Dimension of the snapshots.
        found: usize,
    },
    /// The file cannot hold what was built.
    #[error("the file cannot hold what was built")]
    Format(#[from] FormatError),
    /// The canonical separation of a stage failed.
    #[error("the canonical representation")]
    Canonical(#[from] SeparatedError),
    /// The separated solution over the parameters failed.
    #[error("the separated solution over the parameters")]
    Parametric(#[from] ParametricError),
    /// No structure keeps the tolerance.
    #[error("{}", .0.missed())]
    ToleranceMissed(Box<Report>),
    /// On request.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// A finished build.
pub struct Built {
    /// The file.
    pub bytes: Vec<u8>,
    /// What was done and measured.
    pub report: Report,
}

/// What the user may change without changing the problem.
#[derive(Clone, Copy, Debug, Default)]
pub struct BuildOptions<'a> {
    /// Write the file even if no structure keeps the tolerance; the certificate in it says so.
    pub keep_missed: bool,
    /// Where finished stages are kept and found again; the file is the same with and without.
    pub store: Option<&'a Store>,
    /// Add terms where the fused step is unstable over live parameters; report and file say what was done.
    pub repair: bool,
}

/// A model ready to be marched: what `build`, `verify` and `modes` start from.
pub struct Prepared {
    /// The body.
    pub body: Body,
    /// Symbolic factorisation of its pattern.
    pub symbolic: Symbolic,
    /// The scheme.
    pub scheme: SchemeTable,
    /// Live parameters.
    pub space: ParameterSpace,
    /// The step at the values of the problem file.
    pub step: StepParameters,
}

impl Prepared {
    /// Rayleigh damping at the values of the problem file.
    pub fn rayleigh(&self) -> Rayleigh {
        Rayleigh { alpha: self.step.alpha, beta: self.step.beta }
    }
}

/// Reads the mesh and assembles the model of a problem.
///
/// # Errors
/// [`BuildError`], by cause.
pub fn prepare(
    problem: &Problem,
    watch: &mut Stopwatch<'_>,
    listener: &dyn Listener,
) -> Result<Prepared, BuildError> {
    // Faer's dense kernels split sums by the number of threads; one order for all makes the same bytes on every machine.
    faer::set_global_parallelism(faer::Par::Seq);
    let scheme = problem.time.scheme.table()?;
    let rayleigh = problem.damping.damping().rayleigh()?;
    let mesh = watch.stage("read mesh", || read_mesh(problem))?;
    mesh.notes.iter().for_each(|note| listener.note(note));
    note_locking(problem, &mesh, listener);
    let space = ParameterSpace::new(problem, &mesh, rayleigh)?;
    let step = space.setting(&space.nominal()).step;
    let body = watch.stage("assemble", || Body::build(problem, mesh))?;
    let symbolic = watch.stage("order and analyse", || Symbolic::analyze(body.model.pencil()))?;
    Ok(Prepared { body, symbolic, scheme, space, step })
}

/// Runs the whole build.
///
/// # Errors
/// [`BuildError`], by cause. Nothing is written here; the caller has the bytes or nothing.
pub fn build(
    problem: &Problem,
    options: &BuildOptions<'_>,
    listener: &dyn Listener,
) -> Result<Built, BuildError> {
    let mut watch = Stopwatch::new(listener);
    let prepared = prepare(problem, &mut watch, listener)?;
    if carrier_size_is_free(problem, &prepared.space) {
        return build_with_growing_carrier(problem, options, listener);
    }
    let Prepared { body, symbolic, scheme, space, step } = &prepared;
    let (pencil, rayleigh) = (body.model.pencil(), prepared.rayleigh());

    let first = watch.stage("first natural mode", || lowest_modes(pencil, symbolic, 1))?;
    let first_period = 1.0 / first.frequencies_hz()[0];
    warn_about_step(first_period / step.time_step, scheme, step.time_step, first_period, listener);
    let full = watch
        .stage("factorise stages", || FullOrder::new(pencil, symbolic, scheme, step.time_step, rayleigh))?;
    let runs = Runs::plan(&problem.snapshots, body, step.time_step, first_period);
    let kept = &Kept::new(options.store, &prepared, listener);
    let (basis, n_snapshots) =
        watch.stage("snapshots and basis", || make_basis(problem, &prepared, &full, &runs, kept))?;
    let unseen = UnseenLoads::draw(body, &runs, problem.tolerance.steps);
    let context = Context { problem, prepared: &prepared, full: &full, basis: &basis, unseen: &unseen, kept };
    let fixed;
    let parametric;
    let canonical = match problem.canonical() {
        Some(entry) => Some(context.canonical(&entry, &runs, &mut watch)?),
        None => None,
    };
    let (block, certificate, separation) = if canonical.is_some() {
        (None, Certificate::default(), None)
    } else if space.parameters.is_empty() {
        fixed = watch.stage("stage responses", || stage_responses(&prepared, &basis))?;
        let certificate = watch.stage("certificate", || context.certify_fixed(&fixed))?;
        (Some(BlockTerms::fixed(&fixed)), certificate, None)
    } else {
        let found = separate_and_certify(&context, options.repair, &mut watch)?;
        let (certificate, report);
        (parametric, certificate, report) = found;
        (Some(parametric.terms()?), certificate, Some(report))
    };

    let mode_table = mode_table(&basis, scheme, &rayleigh, step.time_step);
    let scheme_name = problem.time.scheme.to_string();
    let parts = Parts {
        problem,
        body,
        basis: &basis,
        scheme_name: &scheme_name,
        scheme,
        rayleigh,
        block,
        canonical: canonical.as_ref().map(|(map, certificate)| (map, certificate)),
        parameters: Some(space),
        separation: separation.as_ref(),
        certificate,
        mode_table: table_matrix(&mode_table),
    };
    let bytes = watch.stage("encode", || encode(&parts))?;
    let report = Report {
        title: problem.title.clone(),
        nodes: body.model.mesh().nodes.len(),
        elements: body.model.mesh().element_region.len(),
        dofs: body.n_dof(),
        modes: basis.n_modes(),
        steps_per_first_period: first_period / step.time_step,
        mode_table,
        singular_values: basis.singular_values.clone(),
        snapshots: n_snapshots,
        certificate: match &canonical {
            Some((_, certificate)) => canonical_report(problem, certificate),
            None => certificate_report(problem, &certificate, basis.eigenvalues.is_some()),
        },
        separation,
        timings: watch.timings(),
        file_bytes: bytes.len(),
    };
    if !report.certificate.holds() && !options.keep_missed {
        return Err(BuildError::ToleranceMissed(Box::new(report)));
    }
    Ok(Built { bytes, report })
}

/// What the certificate needs of a build.
struct Context<'a> {
    problem: &'a Problem,
    prepared: &'a Prepared,
    full: &'a FullOrder<'a>,
    basis: &'a Basis,
    unseen: &'a UnseenLoads,
    kept: &'a Kept<'a>,
}

impl Context<'_> {
    /// Both structures at fixed parameters.
    fn certify_fixed(&self, responses: &[StageResponse]) -> Result<Certificate, BuildError> {
        let Prepared { body, scheme, step, .. } = self.prepared;
        let block = BlockStep::fuse(scheme, step, self.basis.vectors.as_ref(), responses)?;
        let diagonal = self.diagonal_step()?;
        let mut structures: Vec<&dyn FusedStep> = vec![&block];
        structures.extend(diagonal.as_ref().map(|d| d as &dyn FusedStep));
        let matrices = ReducedMatrices::new(body.model.pencil(), self.basis.vectors.as_ref());
        let measured = self.march("certificate", &matrices, &structures)?;
        let residual = responses.iter().map(|r| r.residual).fold(0.0, f64::max);
        Ok(Certificate {
            block: StructureCertificate { map_error_rms: residual, map_error_max: residual, ..measured[0] },
            diagonal: measured.get(1).copied().unwrap_or_default(),
        })
    }

    /// The unseen loads at the values of the problem file, full order beside the structures.
    fn march(
        &self,
        name: &str,
        matrices: &ReducedMatrices,
        structures: &[&dyn FusedStep],
    ) -> Result<Vec<StructureCertificate>, BuildError> {
        let Prepared { body, scheme, step, .. } = self.prepared;
        let (basis, unseen, kept) = (self.basis, self.unseen, self.kept);
        let inputs = |inputs: Inputs| inputs.value(&(scheme, step)).basis(basis).unseen(unseen);
        kept.certificate(name, inputs, || {
            Ok(certify(body, self.full, basis, matrices, structures, unseen, kept.listener)?)
        })
    }

    fn diagonal_step(&self) -> Result<Option<DiagonalStep<'_>>, BuildError> {
        let Prepared { scheme, step, .. } = self.prepared;
        let Some(values) = &self.basis.eigenvalues else { return Ok(None) };
        Ok(Some(DiagonalStep::fuse(scheme, step, self.basis.vectors.as_ref(), values)?))
    }

    /// The chapter's representation and what is measured of it.
    fn canonical(
        &self,
        entry: &CanonicalEntry,
        runs: &Runs,
        watch: &mut Stopwatch<'_>,
    ) -> Result<(CanonicalMap, CanonicalCertificate), BuildError> {
        let Self { prepared, full, basis, .. } = *self;
        let listener = self.kept.listener;
        let setting = watch.stage("ranges of the axes", || {
            CanonicalSetting::new(entry, prepared, basis, full, runs, listener)
        })?;
        let map = watch.stage("canonical separation", || setting.separate(prepared, basis))?;
        let steps = self.problem.tolerance.steps;
        let certificate = watch.stage("certificate", || {
            certify_canonical(&[&map], prepared, full, basis, runs, steps, listener)
        })?;
        let certificate = certificate.into_iter().next().expect("one map, one certificate");
        if let Some((step, outside)) = &certificate.left {
            listener.note(&format!("step {step} of the certificate left its axes: {outside}"));
        }
        Ok((map, certificate))
    }

    fn separate(&self, asked: &SeparationOptions) -> Result<Parametric, BuildError> {
        let Prepared { body, symbolic, scheme, space, .. } = self.prepared;
        self.kept.separation(self.basis, asked, || {
            let (pencil, listener) = (body.model.pencil(), self.kept.listener);
            Ok(separate_responses(pencil, symbolic, self.basis, space, scheme, asked, listener)?)
        })
    }

    /// The block structure over the box, the diagonal structure (closed form in every parameter it allows) at the
    /// values of the problem file.
    fn certify_box(&self, parametric: &Parametric) -> Result<(Certificate, SeparationReport), BuildError> {
        let Prepared { body, .. } = self.prepared;
        let found = certify_box(self.prepared, parametric, self.basis, self.unseen, self.kept)?;
        let diagonal = match self.diagonal_step()? {
            Some(step) => {
                let matrices = ReducedMatrices::new(body.model.pencil(), self.basis.vectors.as_ref());
                let structures: [&dyn FusedStep; 1] = [&step];
                self.march("certificate-diagonal", &matrices, &structures)?[0]
            }
            None => StructureCertificate::default(),
        };
        let report = SeparationReport {
            terms: parametric.n_terms(),
            axis_points: parametric.axis_points(),
            history: parametric.enrichment.history.clone(),
            history_terms: parametric.enrichment.terms.clone(),
            stop: format!("{:?}", parametric.enrichment.stop),
            reduced_size: parametric.reduced_size,
            samples: parametric.samples,
            parameters: self.prepared.space.parameters.iter().map(|p| p.name.clone()).collect(),
            worst_trajectory_at: found.worst_trajectory_at,
            worst_radius_at: found.worst_radius_at,
            radius_samples: found.radius_samples,
            repairs: vec![],
        };
        Ok((Certificate { diagonal, block: found.worst }, report))
    }
}

/// Linear tetrahedra cannot keep their volume and bend: near ν = ½ they are many times too stiff.
fn note_locking(problem: &Problem, mesh: &Mesh, listener: &dyn Listener) {
    const NEARLY_INCOMPRESSIBLE: f64 = 0.45;
    let poisson = problem.materials.iter().map(|m| m.poisson).fold(0.0, f64::max);
    if mesh.order == Order::Linear && poisson >= NEARLY_INCOMPRESSIBLE {
        listener.note(&format!(
            "Poisson's ratio {poisson} with linear tetrahedra: they lock and are many times too stiff; mesh with quadratic ones"
        ));
    }
}

/// A dissipative scheme at few steps per period eats energy: say so while it can still be changed. What matters is the
/// loss over a second; over a period where that is longer.
fn warn_about_step(steps: f64, scheme: &SchemeTable, dt: f64, period: f64, listener: &dyn Listener) {
    let damping = numerical_damping(scheme, std::f64::consts::TAU * dt / period, 0.0);
    let (span, name) = if period < 1.0 { (1.0, "second") } else { (period, "period") };
    let kept = (-std::f64::consts::TAU * damping.ratio.unwrap_or(1.0) * span / period).exp();
    if kept < 0.95 {
        listener.note(&format!(
            "{steps:.1} steps per first period: the scheme itself takes {:.0} % of the first mode's amplitude each {name}; \
             a smaller `time.step`, Newmark or generalized-alpha keeps it",
            100.0 * (1.0 - kept)
        ));
    }
}

pub(crate) fn make_pod(
    problem: &Problem,
    body: &Body,
    full: &FullOrder<'_>,
    runs: &Runs,
    listener: &dyn Listener,
) -> Result<Option<Pod>, SnapshotError> {
    if problem.basis.kind == BasisKind::Modes {
        return Ok(None);
    }
    let pencil = body.model.pencil();
    let (mass, stiffness) = (apply(pencil.mass()), apply(pencil.stiffness()));
    let identity = |x: faer::MatRef<'_, f64>, mut y: faer::MatMut<'_, f64>| y.copy_from(x);
    let inner_product: Apply<'_> = match problem.basis.inner_product {
        InnerProduct::Mass => &mass,
        InnerProduct::Stiffness => &stiffness,
        InnerProduct::Identity => &identity,
    };
    let imported = problem.snapshots.npy.is_some() || problem.snapshots.vtu.is_some();
    let rank = max_rank(problem);
    let pod = if imported {
        snapshots::import(body, problem, inner_product, rank, listener)?
    } else {
        snapshots::compute(body, full, runs, inner_product, rank, listener)?
    };
    Ok(Some(pod))
}

/// POD vectors kept while streaming: twice what the basis takes, so that truncation stays far below what is used.
fn max_rank(problem: &Problem) -> usize {
    const BY_ENERGY: usize = 128;
    2 * problem.basis.modes.map_or(BY_ENERGY, |r| r * oversampling(problem)).max(16)
}

fn oversampling(problem: &Problem) -> usize {
    if problem.basis.kind == BasisKind::Ritz { problem.basis.oversampling } else { 1 }
}

const DEFAULT_MODES: usize = 8;

/// Snapshots and the basis of the kind asked for, with the number of snapshots.
fn make_basis(
    problem: &Problem,
    prepared: &Prepared,
    full: &FullOrder<'_>,
    runs: &Runs,
    kept: &Kept<'_>,
) -> Result<(Basis, usize), BuildError> {
    if prepared.space.has_region_parameters() && problem.basis.kind != BasisKind::Modes {
        let count = problem.basis.modes.unwrap_or(DEFAULT_MODES);
        let carrier = carrier_basis(problem, prepared, runs, count, kept)?;
        return Ok((carrier.basis, carrier.n_snapshots));
    }
    kept.basis(problem, runs, || nominal_basis(problem, prepared, full, runs, kept.listener))
}

/// The same at the values of the problem file.
fn nominal_basis(
    problem: &Problem,
    prepared: &Prepared,
    full: &FullOrder<'_>,
    runs: &Runs,
    listener: &dyn Listener,
) -> Result<(Basis, usize), BuildError> {
    let (body, pencil) = (&prepared.body, prepared.body.model.pencil());
    let Some(pod) = make_pod(problem, body, full, runs, listener)? else {
        let count = problem.basis.modes.unwrap_or(DEFAULT_MODES);
        let Modes { vectors, eigenvalues, .. } = lowest_modes(pencil, &prepared.symbolic, count)?;
        return Ok((modes_basis(vectors, eigenvalues), 0));
    };
    let found = pod.singular_values.len();
    let count = match (problem.basis.modes, problem.basis.energy) {
        (Some(count), _) => count,
        (None, Some(fraction)) => pod.count_for_energy(fraction),
        (None, None) => DEFAULT_MODES.min(found),
    };
    if count > found {
        return Err(BuildError::TooManyModes { path: problem.place("basis.modes"), asked: count, found });
    }
    Ok((basis_of_pod(problem, prepared, &pod, count)?, pod.n_snapshots))
}

/// The basis of the kind asked for, `pod` or `ritz`, from a decomposition of the snapshots.
pub(crate) fn basis_of_pod(
    problem: &Problem,
    prepared: &Prepared,
    pod: &Pod,
    count: usize,
) -> Result<Basis, FactorError> {
    let pencil = prepared.body.model.pencil();
    let (mass, stiffness) = (apply(pencil.mass()), apply(pencil.stiffness()));
    let basis = if problem.basis.kind == BasisKind::Pod {
        pod_basis(&mass, &stiffness, pod, count)
    } else {
        let factor = prepared.symbolic.factorize(pencil.stiffness().clone())?;
        let static_response = |x: faer::MatRef<'_, f64>, mut y: faer::MatMut<'_, f64>| {
            pencil.mass().mul_into(x, y.rb_mut());
            Solve::new(&prepared.symbolic, y.ncols(), true).solve_in_place(&factor, y);
        };
        ritz_basis(&mass, &stiffness, &static_response, pod, count, problem.basis.oversampling)
    };
    Ok(basis)
}

/// One response per stage; stages that share θ share the solve.
pub(crate) fn stage_responses(prepared: &Prepared, basis: &Basis) -> Result<Vec<StageResponse>, BuildError> {
    let Prepared { body, symbolic, scheme, step, .. } = prepared;
    let mut responses: Vec<StageResponse> = vec![];
    for i in 0..scheme.active().len() {
        let theta = vademecum_format::scheme::theta(scheme, step, i)?;
        let response = match responses.iter().find(|r| r.theta == theta) {
            Some(same) => same.clone(),
            None => StageResponse::solve(body.model.pencil(), symbolic, basis.vectors.as_ref(), theta)?,
        };
        responses.push(response);
    }
    Ok(responses)
}
