//! The whole build on one page, one call per stage: mesh → model → snapshots → basis → vademecum →
//! certificate → bytes.

mod error;
mod large;
mod plan;
#[cfg(test)]
mod ranks_tests;
mod vademecum;

pub use error::BuildError;
pub use large::SHAPES;

use std::sync::Arc;

use crate::basis::{BasisError, SnapshotSchedule, find_basis};
use crate::certificate::UnseenLoads;
use crate::dynamics::{FirstMode, FullOrder};
use crate::export::{Draft, NodeOrder};
use crate::fem::Engine;
use crate::input::{BasisKind, Problem};
use crate::limits::Memory;
use crate::prepared::{FactorPrecision, Means, ParameterSpace, Prepared, prepare_within};
use crate::progress::{Listener, Stopwatch};
use crate::report::{BuildPlan, BuildReport, ToleranceMissed};
use crate::residual::ResidualFlexibility;
use crate::store::{StageCache, Store};

/// What the user may change without changing the problem.
#[derive(Clone, Copy, Debug, Default)]
pub struct BuildOptions<'a> {
    /// Where finished stages are kept and found again; the file is the same with and without.
    pub store: Option<&'a Store>,
    /// Add terms where the fused step is unstable over live parameters; report and file say what was done.
    pub repair: bool,
    /// Do what takes more than four hours, or more than 2e7 full-order steps, too.
    pub long: bool,
    /// Memory that may be used \[bytes\]; absent: what the machine and the limits of the process leave.
    pub memory: Option<u64>,
    /// What factorises and solves with the stiffness, and searches for natural modes; absent: this process.
    pub engine: Option<&'a Arc<dyn Engine>>,
    /// The precision of the factor of the stiffness in this process.
    pub precision: FactorPrecision,
}

impl BuildOptions<'_> {
    fn memory(&self) -> Memory {
        Memory::asked_or_available(self.memory)
    }

    /// The same with the memory that is free now, before the build itself takes of it.
    fn at_the_start(&self) -> Self {
        Self { memory: Some(self.memory().limit()), ..*self }
    }
}

/// A finished build.
pub struct Built {
    /// The file.
    pub bytes: Vec<u8>,
    /// What was done and measured.
    pub report: BuildReport,
}

/// How a build ends.
pub enum Outcome {
    /// A structure of the file keeps the tolerance.
    Kept(Built),
    /// No structure does. The file is whole, and its certificate says by how much it misses.
    Missed(Built),
}

impl Outcome {
    /// The file, if it keeps its tolerance.
    ///
    /// # Errors
    /// [`ToleranceMissed`], with the report of what was built.
    pub fn kept(self) -> Result<Built, ToleranceMissed> {
        match self {
            Self::Kept(built) => Ok(built),
            Self::Missed(built) => Err(ToleranceMissed(Box::new(built.report))),
        }
    }

    /// The file, whether it keeps its tolerance or not.
    pub fn either(self) -> Built {
        match self {
            Self::Kept(built) | Self::Missed(built) => built,
        }
    }
}

/// Largest factor of the stiffness that a file takes without being asked to \[bytes\].
const FACTOR_UNASKED: usize = 256_000_000;

/// First periods that a certificate covers.
const PERIODS: f64 = 3.0;
/// Steps that it marches at least.
const LEAST_STEPS: f64 = 500.0;

/// What every stage of one build reads.
struct Stages<'a> {
    prepared: &'a Prepared,
    /// What marches at full order; absent where nothing does.
    full: Option<&'a FullOrder<'a>>,
    first_period: f64,
    runs: &'a SnapshotSchedule,
    unseen: &'a UnseenLoads,
    order: &'a NodeOrder,
    kept: &'a StageCache<'a>,
    options: &'a BuildOptions<'a>,
    /// Of the basis at hand.
    residual: Option<&'a ResidualFlexibility>,
    /// The factor of the stiffness as the file keeps it; empty where it does not.
    factor: &'a [Draft],
    /// Sections of the stress; empty where the problem asks for none.
    stress: &'a [Draft],
    /// The reactions of the supports as the file keeps them; empty where it does not.
    reactions: &'a [Draft],
    /// The strain map of large displacements; empty where the file is linear.
    strain: &'a [Draft],
}

/// Runs the whole build. Nothing is written here; the caller has the bytes.
///
/// # Errors
/// [`BuildError`], by stage.
pub fn build(
    problem: &Problem,
    options: &BuildOptions<'_>,
    listener: &dyn Listener,
) -> Result<Outcome, BuildError> {
    let options = &options.at_the_start();
    let mut watch = Stopwatch::new(listener);
    let (prepared, first_period) = &model(problem, options, &mut watch, listener)?;
    let (body, time_step, first_period) = (&prepared.body, prepared.step.time_step, *first_period);
    let marches = marches(problem, prepared);
    let full = marches.then(|| watch.stage("factorise stages", || prepared.full_order())).transpose()?;
    let full = full.as_ref();
    let runs = &SnapshotSchedule::plan(&problem.snapshots, body, time_step, first_period);
    let steps = certificate_steps(problem, first_period / time_step);
    note_short_certificate(steps, first_period / time_step, listener);
    let open = problem.tolerance.steps.is_none();
    let unseen = &UnseenLoads { open, ..UnseenLoads::draw(body, runs, steps) };
    let (order, kept) = (&NodeOrder::new(body), &StageCache::new(options.store, prepared, listener));
    let stages = Stages {
        prepared,
        full,
        first_period,
        runs,
        unseen,
        order,
        kept,
        options,
        residual: None,
        factor: &[],
        stress: &[],
        reactions: &[],
        strain: &[],
    };

    let mut missed = None;
    for modes in basis_sizes(problem, &prepared.space) {
        let mut sized = problem.clone();
        sized.basis.modes = modes;
        let built = stages.build(&sized, &mut watch);
        prepared.symbolic.check_solves()?;
        if body.model.pencil().was_assembled_here() {
            listener.note("something needed entries of the matrices: the first rank assembled them whole");
        }
        match built {
            Ok(built) if built.report.certificate.holds() => return Ok(Outcome::Kept(built)),
            Ok(built) => {
                listener.note(&format!("{} modes do not keep the tolerance", built.report.modes));
                // More modes mend neither maps nor instability.
                let grow = built.report.certificate.misses_trajectories_only();
                missed = Some(built);
                if !grow {
                    break;
                }
            }
            Err(BuildError::Basis(BasisError::TooManyModes { found, .. })) if missed.is_some() => {
                listener.note(&format!("the snapshots span {found} dimensions: no larger basis"));
                break;
            }
            Err(error) => return Err(error),
        }
    }
    Ok(Outcome::Missed(missed.expect("every size ends in a file or in an error")))
}

/// The model and its first natural period \[s\], once both fit the machine and the time step fits them.
fn model(
    problem: &Problem,
    options: &BuildOptions<'_>,
    watch: &mut Stopwatch<'_>,
    listener: &dyn Listener,
) -> Result<(Prepared, f64), BuildError> {
    let memory = options.memory();
    let means = Means { memory, engine: options.engine, precision: options.precision };
    let mut prepared = prepare_within(problem, &means, watch, listener)?;
    plan::check_model(problem, &prepared, memory)?;
    let first = match prepared.first_mode.take() {
        Some(known) => known,
        None => {
            let find = || FirstMode::find(prepared.body.model.pencil(), &prepared.symbolic);
            watch.stage("first natural mode", find)?
        }
    };
    // Nothing else goes on from that search.
    if problem.basis_kind() != BasisKind::Modes {
        first.forget();
    }
    let first_period = first.period();
    prepared.first_mode = Some(first);
    prepared.check_time_step(first_period, listener)?;
    Ok((prepared, first_period))
}

/// What a build would take, without doing it: reads and assembles the model, measures two steps.
///
/// # Errors
/// [`BuildError`], as [`build`] before it marches.
pub fn plan_build(
    problem: &Problem,
    options: &BuildOptions<'_>,
    listener: &dyn Listener,
) -> Result<BuildPlan, BuildError> {
    let options = &options.at_the_start();
    let (prepared, first_period) = &model(problem, options, &mut Stopwatch::new(listener), listener)?;
    let full = marches(problem, prepared).then(|| prepared.full_order()).transpose()?;
    let runs =
        SnapshotSchedule::plan(&problem.snapshots, &prepared.body, prepared.step.time_step, *first_period);
    let steps = certificate_steps(problem, *first_period / prepared.step.time_step);
    plan::checked(problem, (options.long, options.memory()), (prepared, full.as_ref(), &runs), steps)
}

/// Whether a build marches anything at full order: snapshots, or the certificate of a scheme with stages.
fn marches(problem: &Problem, prepared: &Prepared) -> bool {
    !prepared.exact || problem.basis_kind() != BasisKind::Modes
}

impl<'a> Stages<'a> {
    /// What marches, where something does.
    fn full(&self) -> &'a FullOrder<'a> {
        self.full.expect("stages are marched at full order")
    }

    /// One file, at one size of the basis.
    fn build(&self, problem: &Problem, watch: &mut Stopwatch<'_>) -> Result<Built, BuildError> {
        let Self { prepared, full, runs, kept, .. } = *self;
        let allowed = (self.options.long, self.options.memory());
        let plan = plan::checked(problem, allowed, (prepared, full, runs), self.unseen.steps)?;
        if problem.is_large() {
            return self.large(problem, plan, watch);
        }
        kept.listener.note(&format!("ahead: {}", plan::in_words(&plan)));
        let find = || find_basis(problem, prepared, full, runs, kept);
        let (basis, n_snapshots) = watch.stage("snapshots and basis", find)?;
        let residual = self.static_residual(problem, &basis, watch)?;
        let stress = self.stress(problem, &basis, residual.is_some(), watch)?;
        let reactions = self.reactions(problem, &basis, watch)?;
        let residual_of = residual.as_ref();
        let mut sized = Stages { residual: residual_of, stress: &stress, reactions: &reactions, ..*self };
        let mut factor = vec![];
        // Without loadable nodes there is no residual, and nothing for the factor to add to.
        let asked = problem.output.static_fields == Some(true) && residual.is_some();
        let certified = if asked { None } else { Some(sized.certified(problem, &basis, watch)?) };
        let vademecum = match certified.filter(|certified| !sized.wants_factor(problem, certified)) {
            Some(certified) => certified,
            None => {
                factor = sized.factor(problem, watch)?;
                sized.factor = &factor;
                sized.certified(problem, &basis, watch)?
            }
        };
        let bytes = watch.stage("encode", || sized.file(problem, &basis, &vademecum))?;
        let mut report = sized.report(problem, &basis, &vademecum, n_snapshots, watch.timings(), bytes.len());
        report.plan = plan;
        Ok(Built { bytes, report })
    }
}

/// Sizes of the basis to try, smallest first: the one asked for, unless live regions turn the eigenvectors
/// and the problem leaves the number open.
fn basis_sizes(problem: &Problem, space: &ParameterSpace) -> Vec<Option<usize>> {
    let asked = problem.basis.modes.is_some() || problem.basis_kind() == BasisKind::Modes;
    let fixed = asked || !space.has_region_parameters();
    if fixed { vec![problem.basis.modes] } else { [8, 16, 32, 64].map(Some).to_vec() }
}

/// Steps of the certificate's runs: whole first periods, unless the problem says otherwise.
fn certificate_steps(problem: &Problem, steps_per_period: f64) -> usize {
    problem.tolerance.steps.unwrap_or((PERIODS * steps_per_period).ceil().max(LEAST_STEPS) as usize)
}

/// Tells of a certificate that does not see a whole first period.
fn note_short_certificate(steps: usize, steps_per_period: f64, listener: &dyn Listener) {
    let share = 100.0 * steps as f64 / steps_per_period;
    if share < 100.0 {
        listener.note(&format!(
            "`tolerance.steps` = {steps} covers {share:.1} % of the first period ({steps_per_period:.0} steps): \
             the certificate says nothing of the rest; leave the key out to cover {PERIODS} periods"
        ));
    }
}
