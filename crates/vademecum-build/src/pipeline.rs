//! The whole build on one page, one call per stage: mesh → model → snapshots → basis → vademecum → bytes.

use faer::Mat;
use faer::prelude::ReborrowMut;
use vademecum_format::FormatError;
use vademecum_format::scheme::SchemeTable;
use vademecum_format::scheme::{SchemeError, StepParameters};
use vademecum_format::{Certificate, StructureCertificate};

use crate::body::{Body, BodyError, read_mesh};
use crate::certificate::{ReducedMatrices, UnseenLoads, certify};
use crate::dynamics::{
    DampingError, FullOrder, FullOrderError, Modes, ModesError, Rayleigh, lowest_modes, numerical_damping,
};
use crate::export::{BlockTerms, Parts, encode};
use crate::fem::{FactorError, Solve, Symbolic};
use crate::march::MarchError;
use crate::parametric::{
    ParameterSpace, Parametric, ParametricError, SeparationOptions, carrier_basis, certify_box,
    separate_responses,
};
use crate::pod::{Apply, Basis, Pod, apply, modes_basis, pod_basis, ritz_basis};
use crate::problem::{BasisKind, InnerProduct, Problem};
use crate::progress::{Cancelled, Listener, StageTiming, Stopwatch};
use crate::reduced::{BlockStep, DiagonalStep, FusedStep};
use crate::response::StageResponse;
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
    Table(#[from] SchemeError),
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
        "`basis.modes` is {asked}; the snapshots span {found} dimensions: add positions, directions or time to `[snapshots]`"
    )]
    TooManyModes {
        /// Modes asked for.
        asked: usize,
        /// Dimension of the snapshots.
        found: usize,
    },
    /// The file cannot hold what was built.
    #[error("the file cannot hold what was built")]
    Format(#[from] FormatError),
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

/// What a build did and measured.
#[derive(Clone, Debug, serde::Serialize)]
pub struct Report {
    /// Title of the problem.
    pub title: String,
    /// Nodes of the mesh.
    pub nodes: usize,
    /// Elements of the mesh.
    pub elements: usize,
    /// Free dofs n.
    pub dofs: usize,
    /// Modes r.
    pub modes: usize,
    /// Steps in the first natural period.
    pub steps_per_first_period: f64,
    /// One entry per mode.
    pub mode_table: Vec<ModeRow>,
    /// Singular values of the snapshots.
    pub singular_values: Vec<f64>,
    /// Snapshots taken.
    pub snapshots: usize,
    /// What was measured, per structure.
    pub certificate: CertificateReport,
    /// What the separation over the parameters did; absent without parameters.
    pub separation: Option<SeparationReport>,
    /// Wall time and memory per stage.
    pub timings: Vec<StageTiming>,
    /// Length of the file \[bytes\].
    pub file_bytes: usize,
}

/// What the separation over the parameters did.
#[derive(Clone, Debug, serde::Serialize)]
pub struct SeparationReport {
    /// Terms.
    pub terms: usize,
    /// Points of each axis.
    pub axis_points: Vec<usize>,
    /// Relative error after each enrichment, at fresh points of the reduced problem.
    pub history: Vec<f64>,
    /// Why the enrichment ended.
    pub stop: String,
    /// Vectors of the compressed space.
    pub reduced_size: usize,
    /// Full-order solves behind it.
    pub samples: usize,
    /// Parameter values at the corner of the worst trajectory.
    pub worst_trajectory_at: Vec<f64>,
    /// Parameter values at the largest spectral radius.
    pub worst_radius_at: Vec<f64>,
}

/// A mode as engineers ask for it.
#[derive(Clone, Copy, Debug, serde::Serialize)]
pub struct ModeRow {
    /// √(Rayleigh quotient)/2π \[Hz\].
    pub frequency_hz: f64,
    /// φᵀKφ ÷ φᵀMφ \[rad²/s²\].
    pub rayleigh_quotient: f64,
    /// Fraction of the snapshot energy; NaN for natural modes without snapshots.
    pub energy: f64,
    /// Damping ratio the material gives it.
    pub physical_damping: f64,
    /// Damping ratio the scheme adds at this step.
    pub numerical_damping: f64,
    /// Relative lengthening of its period by the scheme.
    pub period_elongation: f64,
}

/// The certificate as a report shows it.
#[derive(Clone, Copy, Debug, serde::Serialize)]
pub struct CertificateReport {
    /// Of the diagonal structure, if the file has it.
    pub diagonal: Option<StructureReport>,
    /// Of the block structure, if the file has it.
    pub block: Option<StructureReport>,
    /// Allowed: floor_ratio × floor + absolute.
    pub floor_ratio: f64,
    /// See `floor_ratio`.
    pub absolute: f64,
    /// Allowed error of the stage maps over live parameters, root mean square; ten times that at the worst point.
    pub map: f64,
}

/// A structure's certificate as a report shows it.
#[derive(Clone, Copy, Debug, serde::Serialize)]
pub struct StructureReport {
    /// Relative L2 error over all dofs and steps, mass norm.
    pub trajectory_error: f64,
    /// The same of the projection of the full-order trajectory.
    pub projection_floor: f64,
    /// Error ÷ floor.
    pub floor_ratio: f64,
    /// Of the fused step.
    pub spectral_radius: f64,
    /// Largest energy of a free run over the energy at its start.
    pub energy_ratio: f64,
    /// Relative error of the stage maps at fresh points, root mean square (of the solve alone at fixed parameters).
    pub map_error_rms: f64,
    /// The same at the worst point.
    pub map_error_max: f64,
    /// Steps of the march behind the errors.
    pub steps: f64,
}

impl StructureReport {
    /// From what the file holds.
    pub fn new(c: &StructureCertificate) -> Self {
        Self {
            trajectory_error: c.trajectory_error,
            projection_floor: c.projection_floor,
            floor_ratio: c.trajectory_error / c.projection_floor,
            spectral_radius: c.spectral_radius,
            energy_ratio: c.energy_ratio,
            map_error_rms: c.map_error_rms,
            map_error_max: c.map_error_max,
            steps: c.steps,
        }
    }

    /// Whether the stage maps keep a tolerance, where their error was measured.
    fn maps_keep(&self, tolerance: f64) -> bool {
        let within = |error: f64, limit: f64| error.is_nan() || error <= limit;
        within(self.map_error_rms, tolerance) && within(self.map_error_max, 10.0 * tolerance)
    }

    /// Whether the trajectories keep a tolerance and the step is stable.
    fn keeps(&self, floor_ratio: f64, absolute: f64) -> bool {
        let accurate = self.trajectory_error <= floor_ratio * self.projection_floor + absolute;
        accurate && self.spectral_radius <= STABLE && self.energy_ratio <= BOUNDED
    }
}

/// Largest spectral radius of a step that may be written: rounding of eigenvalues at 1 (docs/theory/5-vademecum.md).
const STABLE: f64 = 1.0 + 1e-12;
/// Largest energy of a free run over the energy at its start. A stable step decays; between, the energy of `Bζ` may swing a
/// little where the full-order field is not quite `Bζ` (live regions).
const BOUNDED: f64 = 1.05;

impl CertificateReport {
    /// Whether one of the structures keeps the tolerance.
    pub fn holds(&self) -> bool {
        let keeps = |s: &StructureReport| s.keeps(self.floor_ratio, self.absolute) && s.maps_keep(self.map);
        self.diagonal.iter().chain(&self.block).any(keeps)
    }
}

impl Report {
    fn missed(&self) -> String {
        let line = |name: &str, s: &StructureReport| {
            format!(
                "\n  {name}: error {:.3e}, floor {:.3e} (ratio {:.2}), spectral radius 1{:+.1e}, energy ratio {:.6}, map error {:.1e} rms, {:.1e} worst",
                s.trajectory_error,
                s.projection_floor,
                s.floor_ratio,
                s.spectral_radius - 1.0,
                s.energy_ratio,
                s.map_error_rms,
                s.map_error_max
            )
        };
        let c = &self.certificate;
        let diagonal = c.diagonal.as_ref().map_or(String::new(), |s| line("diagonal", s));
        let block = c.block.as_ref().map_or(String::new(), |s| line("block", s));
        format!(
            "no structure keeps the tolerance (error ≤ {} × floor + {:e}, spectral radius ≤ 1 + 1e-12, map error ≤ {:e}):{diagonal}{block}",
            c.floor_ratio, c.absolute, c.map
        )
    }
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
pub struct BuildOptions {
    /// Write the file even if no structure keeps the tolerance; the certificate in it says so.
    pub keep_missed: bool,
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
    options: &BuildOptions,
    listener: &dyn Listener,
) -> Result<Built, BuildError> {
    let mut watch = Stopwatch::new(listener);
    let prepared = prepare(problem, &mut watch, listener)?;
    let Prepared { body, symbolic, scheme, space, step } = &prepared;
    let (pencil, rayleigh) = (body.model.pencil(), prepared.rayleigh());

    let first = watch.stage("first natural mode", || lowest_modes(pencil, symbolic, 1))?;
    let first_period = 1.0 / first.frequencies_hz()[0];
    warn_about_step(first_period / step.time_step, scheme, step.time_step, first_period, listener);
    let full = watch
        .stage("factorise stages", || FullOrder::new(pencil, symbolic, scheme, step.time_step, rayleigh))?;
    let runs = Runs::plan(&problem.snapshots, body, step.time_step, first_period);
    let (basis, n_snapshots) =
        watch.stage("snapshots and basis", || make_basis(problem, &prepared, &full, &runs, listener))?;
    let unseen = UnseenLoads::draw(body, &runs, problem.tolerance.steps);
    let context =
        Context { problem, prepared: &prepared, full: &full, basis: &basis, unseen: &unseen, listener };
    let fixed;
    let parametric;
    let (block, certificate, separation) = if space.parameters.is_empty() {
        fixed = watch.stage("stage responses", || stage_responses(&prepared, &basis))?;
        let certificate = watch.stage("certificate", || context.certify_fixed(&fixed))?;
        (BlockTerms::fixed(&fixed), certificate, None)
    } else {
        parametric = watch.stage("separate over the parameters", || context.separate())?;
        let (certificate, report) = watch.stage("certificate", || context.certify_box(&parametric))?;
        (parametric.terms()?, certificate, Some(report))
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
        block: Some(block),
        parameters: Some(space),
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
        certificate: certificate_report(problem, &certificate, basis.eigenvalues.is_some()),
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
    listener: &'a dyn Listener,
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
        let measured =
            certify(body, self.full, self.basis, &matrices, &structures, self.unseen, self.listener)?;
        let residual = responses.iter().map(|r| r.residual).fold(0.0, f64::max);
        Ok(Certificate {
            block: StructureCertificate { map_error_rms: residual, map_error_max: residual, ..measured[0] },
            diagonal: measured.get(1).copied().unwrap_or_default(),
        })
    }

    fn diagonal_step(&self) -> Result<Option<DiagonalStep<'_>>, BuildError> {
        let Prepared { scheme, step, .. } = self.prepared;
        let Some(values) = &self.basis.eigenvalues else { return Ok(None) };
        Ok(Some(DiagonalStep::fuse(scheme, step, self.basis.vectors.as_ref(), values)?))
    }

    fn separate(&self) -> Result<Parametric, BuildError> {
        let Prepared { body, symbolic, scheme, space, .. } = self.prepared;
        let tolerance = &self.problem.tolerance;
        let asked = SeparationOptions { tolerance: tolerance.map, max_terms: tolerance.max_terms };
        Ok(separate_responses(
            body.model.pencil(),
            symbolic,
            self.basis,
            space,
            scheme,
            &asked,
            self.listener,
        )?)
    }

    /// The block structure over the box, the diagonal structure (closed form in every parameter it allows) at the
    /// values of the problem file.
    fn certify_box(&self, parametric: &Parametric) -> Result<(Certificate, SeparationReport), BuildError> {
        let Prepared { body, .. } = self.prepared;
        let found = certify_box(self.prepared, parametric, self.basis, self.unseen, self.listener)?;
        let diagonal = match self.diagonal_step()? {
            Some(step) => {
                let matrices = ReducedMatrices::new(body.model.pencil(), self.basis.vectors.as_ref());
                let structures: [&dyn FusedStep; 1] = [&step];
                certify(body, self.full, self.basis, &matrices, &structures, self.unseen, self.listener)?[0]
            }
            None => StructureCertificate::default(),
        };
        let report = SeparationReport {
            terms: parametric.n_terms(),
            axis_points: parametric.axis_points(),
            history: parametric.enrichment.history.clone(),
            stop: format!("{:?}", parametric.enrichment.stop),
            reduced_size: parametric.reduced_size,
            samples: parametric.samples,
            worst_trajectory_at: found.worst_trajectory_at,
            worst_radius_at: found.worst_radius_at,
        };
        Ok((Certificate { diagonal, block: found.worst }, report))
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

/// Snapshots and the basis of the kind asked for, with the number of snapshots.
fn make_basis(
    problem: &Problem,
    prepared: &Prepared,
    full: &FullOrder<'_>,
    runs: &Runs,
    listener: &dyn Listener,
) -> Result<(Basis, usize), BuildError> {
    const DEFAULT_MODES: usize = 8;
    let (body, pencil) = (&prepared.body, prepared.body.model.pencil());
    if prepared.space.has_region_parameters() && problem.basis.kind != BasisKind::Modes {
        let count = problem.basis.modes.unwrap_or(DEFAULT_MODES);
        let carrier = carrier_basis(problem, prepared, runs, count, listener)?;
        return Ok((carrier.basis, carrier.n_snapshots));
    }
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
        return Err(BuildError::TooManyModes { asked: count, found });
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

fn certificate_report(problem: &Problem, certificate: &Certificate, diagonal: bool) -> CertificateReport {
    CertificateReport {
        diagonal: diagonal.then(|| StructureReport::new(&certificate.diagonal)),
        block: Some(StructureReport::new(&certificate.block)),
        floor_ratio: problem.tolerance.floor_ratio,
        absolute: problem.tolerance.absolute,
        map: problem.tolerance.map,
    }
}

pub(crate) fn mode_table(basis: &Basis, scheme: &SchemeTable, rayleigh: &Rayleigh, dt: f64) -> Vec<ModeRow> {
    let row = |k: usize| {
        let quotient = basis.stiffness[(k, k)];
        let frequency_hz = quotient.sqrt() / std::f64::consts::TAU;
        let physical_damping = rayleigh.ratio(frequency_hz);
        let numerical = numerical_damping(scheme, quotient.sqrt() * dt, physical_damping);
        ModeRow {
            frequency_hz,
            rayleigh_quotient: quotient,
            energy: basis.energy.get(k).copied().unwrap_or(f64::NAN),
            physical_damping,
            numerical_damping: numerical.ratio.map_or(f64::NAN, |ratio| ratio - physical_damping),
            period_elongation: numerical.period_elongation.unwrap_or(f64::NAN),
        }
    };
    (0..basis.n_modes()).map(row).collect()
}

pub(crate) fn table_matrix(rows: &[ModeRow]) -> Mat<f64> {
    Mat::from_fn(rows.len(), 6, |i, j| {
        let row = &rows[i];
        [
            row.frequency_hz,
            row.rayleigh_quotient,
            row.energy,
            row.physical_damping,
            row.numerical_damping,
            row.period_elongation,
        ][j]
    })
}
