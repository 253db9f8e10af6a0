//! The model, its full-order march and the loads of its certificate: all that is settled before there is a
//! basis.

use std::f64::consts::TAU;
use std::sync::OnceLock;

use faer::MatRef;

use super::plan;
use super::{BuildError, BuildOptions};
use crate::basis::SnapshotSchedule;
use crate::certificate::UnseenLoads;
use crate::dynamics::{FirstMode, FullOrder, lowest_modes};
use crate::export::NodeOrder;
use crate::input::{BasisKind, Problem};
use crate::mesh_error::{DiscRequest, FREQUENCIES, MeshEstimate, estimate};
use crate::prepared::{Means, Prepared, prepare_within};
use crate::progress::{Listener, Stopwatch};
use crate::report::BuildPlan;
use crate::store::StageCache;

/// First periods that a certificate covers.
const PERIODS: f64 = 3.0;
/// Steps that it marches at least.
const MIN_STEPS: f64 = 500.0;

/// All that is settled before there is a basis; every road reads it.
pub struct BuildContext<'a> {
    /// The model.
    pub prepared: &'a Prepared,
    /// The full-order march; absent where nothing is marched.
    pub(super) full: Option<&'a FullOrder<'a>>,
    /// First natural period \[s\].
    pub(crate) first_period: f64,
    /// The runs that snapshots are taken of.
    pub runs: &'a SnapshotSchedule,
    /// The loads of the certificate.
    pub unseen: &'a UnseenLoads,
    /// The nodes in the order of the file.
    pub order: &'a NodeOrder,
    /// Finished stages, and the listener.
    pub kept: &'a StageCache<'a>,
    /// The options of the build.
    pub options: &'a BuildOptions<'a>,
    /// The discretisation error, once it is estimated.
    pub(super) mesh_error: &'a OnceLock<MeshEstimate>,
}

/// Reads and assembles the model of a problem and hands it to `work` with all that goes before a basis.
///
/// # Errors
/// [`BuildError`]: a problem that cannot be computed with, a model that does not fit; those of `work`.
pub fn with_context<R, E: From<BuildError>>(
    problem: &Problem,
    options: &BuildOptions<'_>,
    listener: &dyn Listener,
    work: impl FnOnce(&BuildContext<'_>, &mut Stopwatch<'_>) -> Result<R, E>,
) -> Result<R, E> {
    let options = &options.at_the_start();
    let mut watch = Stopwatch::new(listener);
    let (prepared, first_period) = &model(problem, options, &mut watch, listener)?;
    let (body, time_step, first_period) = (&prepared.body, prepared.step.time_step, *first_period);
    let full = || prepared.full_order().map_err(BuildError::from);
    let full = marches(problem, prepared).then(|| watch.stage("factorise stages", full)).transpose()?;
    let runs = &SnapshotSchedule::plan(&problem.snapshots, body, time_step, first_period);
    let steps = certificate_steps(problem, first_period / time_step);
    note_short_certificate(steps, first_period / time_step, listener);
    let open = problem.tolerance.steps.is_none();
    let unseen = &UnseenLoads { open, ..UnseenLoads::draw(body, runs, steps) };
    let (order, kept) = (&NodeOrder::new(body), &StageCache::new(options.store, prepared, listener));
    let full = full.as_ref();
    let mesh_error = &OnceLock::new();
    let context =
        BuildContext { prepared, full, first_period, runs, unseen, order, kept, options, mesh_error };
    work(&context, &mut watch)
}

impl<'a> BuildContext<'a> {
    /// The full-order march.
    ///
    /// # Panics
    /// If modes are moved exactly: nothing is marched then.
    pub fn full(&self) -> &'a FullOrder<'a> {
        self.full.expect("stages are marched at full order")
    }

    /// The announced cost of one size of the basis.
    ///
    /// # Errors
    /// [`BuildError::Work`], [`BuildError::Memory`]: more than the options allow.
    pub fn plan(&self, problem: &Problem) -> Result<BuildPlan, BuildError> {
        let allowed = (self.options.long, self.options.memory());
        plan::checked(problem, allowed, (self.prepared, self.full, self.runs), self.unseen.steps)
    }

    /// Estimates the discretisation error of the lowest frequencies, once, from natural modes where they are
    /// at hand.
    ///
    /// # Errors
    /// [`BuildError::MeshError`].
    pub(super) fn estimate_mesh_error(
        &self,
        known: Option<(&[f64], MatRef<'_, f64>)>,
        watch: &mut Stopwatch<'_>,
    ) -> Result<(), BuildError> {
        if self.mesh_error.get().is_none() {
            self.note_own_frequencies(known)?;
            let find = || estimate(self.prepared, known, DiscRequest::None, self.kept.listener);
            let found = watch.stage("mesh error", find)?;
            let _ = self.mesh_error.set(found);
        }
        Ok(())
    }

    /// Notes the lowest frequencies of matrices of another program: a wrong unit or format shows there.
    fn note_own_frequencies(&self, known: Option<(&[f64], MatRef<'_, f64>)>) -> Result<(), BuildError> {
        let (model, symbolic) = (&self.prepared.body.model, &self.prepared.symbolic);
        if !model.mesh().elements.is_empty() || symbolic.is_spread() {
            return Ok(());
        }
        let count = FREQUENCIES.min(model.pencil().n_elastic());
        let eigenvalues = match known {
            Some((values, _)) if values.len() >= count => values.to_vec(),
            _ => lowest_modes(model.pencil(), symbolic, count)?.eigenvalues,
        };
        let hertz = eigenvalues.iter().take(count).map(|value| format!("{:.6e}", value.sqrt() / TAU));
        self.kept.listener.note(&format!(
            "the lowest natural frequencies of these matrices: {} Hz; where they are far from those of the \
             program that wrote them, a unit or the format is another one",
            hertz.collect::<Vec<_>>().join(", ")
        ));
        Ok(())
    }

    /// Refuses solves that an engine did not finish, and notes matrices that were assembled a second time.
    ///
    /// # Errors
    /// [`BuildError::Factor`].
    pub fn check_engine(&self) -> Result<(), BuildError> {
        self.prepared.symbolic.check_solves()?;
        if self.prepared.body.model.pencil().was_assembled_here() {
            let note = "something needed entries of the matrices: the first rank assembled them whole";
            self.kept.listener.note(note);
        }
        Ok(())
    }
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

/// True where a build marches at full order: snapshots, or the certificate of a scheme with stages.
fn marches(problem: &Problem, prepared: &Prepared) -> bool {
    !prepared.exact || problem.basis_kind() != BasisKind::Modes
}

/// Steps of the certificate's runs: whole first periods, unless the problem says otherwise.
fn certificate_steps(problem: &Problem, steps_per_period: f64) -> usize {
    problem.tolerance.steps.unwrap_or((PERIODS * steps_per_period).ceil().max(MIN_STEPS) as usize)
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
