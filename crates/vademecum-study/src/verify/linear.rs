//! A scenario through a file beside the linear motion.

use serde::Serialize;
use vademecum_build::Matrix;
use vademecum_build::dynamics::{
    FullOrder, INSTANTS, MotionPart, ReferenceSolution, TimedLoad, announce, seconds_per_step,
};
use vademecum_build::input::Problem;
use vademecum_build::measured::{NotMeasured, measured, reference_measured};
use vademecum_build::prepared::{Body, Prepared};
use vademecum_build::progress::Listener;
use vademecum_eval::{Field, SceneOptions, StructureChoice};
use vademecum_format::exact::ForceFilter;
use vademecum_format::scheme::StepParameters;
use vademecum_format::{File, SectionKind};

use super::bound_scenario::{BoundScenario, VerificationRecord, show};
use super::model::mesh_field;
use crate::compare::{Comparison, ReducedMotion, compare, coordinate_matrix};
use crate::contents::{Bound, bound, numbers};
use crate::error::{FileError, StudyError};
use crate::parameters::{ParameterValue, values};
use crate::player::chapter::step_radius;
use crate::player::{PlayOptions, Playable, Track, elastic_with_fields, long_run, with_body};
use crate::scenario::Scenario;
use crate::stress_error::StressCheck;
use crate::truth::{TruthErrors, find_truth, truth_errors};

/// Steps of the free run that times a step of the file.
const TIMED_STEPS: usize = 100_000;

/// Result of a verification.
#[derive(Clone, Debug, Serialize)]
pub struct Verification {
    /// Steps marched.
    pub steps: usize,
    /// Free dofs.
    pub dofs: usize,
    /// Modes.
    pub modes: usize,
    /// Structure of the step.
    pub structure: &'static str,
    /// Step \[s\].
    pub time_step: f64,
    /// Values of the file's live parameters; none if it has none.
    pub parameters: Vec<ParameterValue>,
    /// Relative L2 error over all dofs and steps, mass norm: against the march at full order by the file's
    /// scheme, or against the motion that is exact in time where the file moves its modes exactly.
    pub trajectory_error: f64,
    /// The same of the projection of the full-order trajectory on the basis.
    pub projection_floor: f64,
    /// Error ÷ floor.
    pub floor_ratio: f64,
    /// The file against a motion that is exact in time.
    #[serde(flatten)]
    pub truth: TruthErrors,
    /// Of the stress: the largest equivalent stress of the difference to the exact motion, over points and
    /// instants, as a share of its largest. None of a file without stress.
    pub stress_error: Option<f64>,
    /// Error bound of the file for any load; `None` if the file does not have one.
    pub bound: Option<Bound>,
    /// Of the step as the evaluator marches it.
    pub spectral_radius: f64,
    /// Energy at the end over energy at release, less 1, through the file.
    /// `None` where a load acts to the end.
    pub energy_drift: Option<f64>,
    /// The same at full order: what the scheme itself takes.
    pub energy_drift_full_order: Option<f64>,
    /// Largest energy after release over the energy at release, through the file.
    pub energy_ratio: Option<f64>,
    /// Wall time of one full-order step \[s\].
    pub full_order_seconds_per_step: f64,
    /// Wall time of one step through the file \[s\].
    pub vademecum_seconds_per_step: f64,
}

impl Verification {
    /// Checks that all figures were measured.
    fn measured(&self) -> Result<(), NotMeasured> {
        reference_measured("truth_error", self.truth.truth_error)?;
        let optional = [
            ("time_error", self.truth.time_error),
            ("contact_error", self.truth.contact_error),
            ("stress_error", self.stress_error),
            ("energy_drift", self.energy_drift),
            ("energy_drift_full_order", self.energy_drift_full_order),
            ("energy_ratio", self.energy_ratio),
        ];
        let known = [
            ("total_error", self.truth.total_error),
            ("basis_error", self.truth.basis_error),
            ("rest_error", self.truth.rest_error),
            ("trajectory_error", self.trajectory_error),
            ("projection_floor", self.projection_floor),
            ("floor_ratio", self.floor_ratio),
            ("spectral_radius", self.spectral_radius),
        ];
        let all = optional.into_iter().filter_map(|(name, value)| Some((name, value?))).chain(known);
        measured(&all.collect::<Vec<_>>())
    }
}

/// [`verify`](super::verify()) beside the linear motion.
///
/// # Errors
/// As [`verify`](super::verify()).
pub fn verify_linear(
    file: &File<'_>,
    options: &PlayOptions,
    problem: &Problem,
    prepared: &Prepared,
    scenario: &Scenario,
    listener: &dyn Listener,
) -> Result<VerificationRecord<Verification>, StudyError> {
    let bound_scenario = BoundScenario::new(file, options, problem, prepared, scenario, listener)?;
    let BoundScenario {
        ref file_nodes,
        ref setting,
        time_step,
        steps,
        ref track,
        ref loads,
        ref basis,
        body,
    } = bound_scenario;
    let metadata = file.metadata();
    if scenario.free.is_some() {
        listener.note(
            "`[free]` of the scenario is left out: what is compared is the elastic motion, under forces that turn with \
             the body",
        );
    }

    let Prepared { symbolic, scheme, .. } = prepared;
    let pencil = setting.pencil(body.model.pencil());
    let full = FullOrder::new(&pencil, symbolic, scheme, time_step, setting.rayleigh())?;
    let exact = moves_exactly(file, options);
    if !exact {
        announce("the full-order march beside the file", &full, 1, steps as f64, options.long, listener)?;
    }

    let eigenvalues = match prepared.ratios.is_empty() {
        true => vec![],
        false => eigenvalues(file, setting.step.stiffness / setting.step.density)?,
    };
    let decay = |lambda: f64, _| prepared.ratios.decay(&setting.rayleigh(), &eigenvalues, lambda);
    let truth = find_truth(&pencil, symbolic, &decay, loads, (time_step, steps), listener)?;

    listener.stage("step the file");
    let stress = StressCheck::new(file, body, file_nodes, setting)?;
    let shown = show(file, options, track, stress.as_ref(), (steps, time_step), listener)?;
    let timing = long_run(file, options, track, TIMED_STEPS, listener)?;
    let spectral_radius = step_radius(file, options)?;

    let coordinates = coordinate_matrix(metadata.n_modes as usize, &shown.coordinates);
    let rows: Vec<_> = body.probes.iter().map(|probe| body.probe_row(probe)).collect();
    let reduced = ReducedMotion { basis: basis.as_ref(), coordinates: coordinates.as_ref(), probes: &rows };
    let (full, same_scheme) = if exact {
        (motion_of(&truth, &full, &rows), None)
    } else {
        listener.stage("march full order");
        let mut marched = truth.trajectory(0).marched_apart();
        let compared = compare(&full, loads, &reduced, listener, |state| {
            marched.add(state.displacement.col_as_slice(0));
        })?;
        let Comparison { error, energy, probes, seconds_per_step } = compared;
        (FullMotion { energy, probes, seconds_per_step }, Some((error, marched.error())))
    };
    let entries = bound_scenario.entries();
    let contacts = (&loads[..entries.len()], &entries[..]);
    let statics = static_columns(file, options, track, body, file_nodes)?;
    let acting = filtered_factors(loads, &setting.step, steps);
    let mut motion = vec![MotionPart { columns: basis.as_ref(), amplitudes: coordinates.as_ref() }];
    motion.extend(
        statics.as_ref().map(|columns| MotionPart { columns: columns.as_ref(), amplitudes: acting.as_ref() }),
    );
    let under = coordinate_matrix(entries.len(), &shown.under_contacts);
    let stress_error = stress.and_then(|stress| stress.error(&truth.trajectory(0), &shown.stresses));
    let truth = truth_errors(&truth, &motion, (contacts, under.as_ref()), time_step, same_scheme);
    let [trajectory_error, projection_floor] = match same_scheme {
        Some((same, _)) => [same.error, same.floor],
        None => [truth.total_error, truth.basis_error],
    };
    // The static part of a file that moves its modes exactly goes with the load.
    let release = bound_scenario.release().saturating_add(usize::from(exact)).min(steps);
    let released = release < steps;
    let drift = |series: &[f64]| released.then(|| series[steps] / series[release] - 1.0);
    let largest = shown.energy[release..].iter().copied().fold(0.0, f64::max);
    let figures = Verification {
        steps,
        dofs: body.n_dof(),
        modes: metadata.n_modes as usize,
        structure: shown.structure,
        time_step,
        parameters: values(&options.scene, metadata),
        trajectory_error,
        projection_floor,
        floor_ratio: trajectory_error / projection_floor,
        truth,
        stress_error,
        bound: bound(file)?,
        spectral_radius,
        energy_drift: drift(&shown.energy),
        energy_drift_full_order: drift(&full.energy),
        energy_ratio: released.then(|| largest / shown.energy[release]),
        full_order_seconds_per_step: full.seconds_per_step,
        vademecum_seconds_per_step: timing.seconds_per_step,
    };
    figures.measured()?;
    let (probes, energies) = ([full.probes, shown.probes], [full.energy, shown.energy]);
    Ok(bound_scenario.verified(figures, (file, scenario), probes, energies)?)
}

/// Factor of each load through the filter of the residual at every instant, shape (loads, 1 + steps); without
/// stiffness-proportional damping the factor at the end of each step.
fn filtered_factors(loads: &[TimedLoad], step: &StepParameters, steps: usize) -> Matrix {
    // A load may bend within a step.
    let parts = if step.beta > 0.0 { 16 } else { 1 };
    let part = StepParameters { time_step: step.time_step / parts as f64, ..*step };
    let filter = ForceFilter::of(&part);
    let mut factors = Matrix::zeros(loads.len(), 1 + steps);
    for (j, load) in loads.iter().enumerate() {
        let mut shown = 0.0;
        for n in 0..steps {
            let time = |p: usize| (n as f64 + p as f64 / parts as f64) * step.time_step;
            for p in 0..parts {
                let ends = (load.when.just_after(time(p)), load.when.just_before(time(p + 1)));
                shown = filter.keep * shown + filter.drive(ends.0, ends.1);
            }
            factors[(j, n + 1)] = shown;
        }
    }
    factors
}

/// Static part of the fields of a file for each load of a track at factor 1, beside the modes; shape
/// (n, loads). Nothing where they show no more than the modes.
fn static_columns(
    file: &File<'_>,
    options: &PlayOptions,
    track: &Track,
    body: &Body,
    file_nodes: &[u32],
) -> Result<Option<Matrix>, StudyError> {
    if options.takes_chapter(file) || file.section(SectionKind::FactorValues).is_none() {
        return Ok(None);
    }
    // At once: the factors are filtered.
    let scene = SceneOptions { beta: Some(0.0), ..options.scene };
    with_body::<f64, _>(file, &elastic_with_fields(&scene), |played| {
        if !played.has_static_field() {
            return Ok(None);
        }
        let mut columns = Matrix::zeros(body.n_dof(), track.contacts.len() + track.patterns.len());
        let mut shown = vec![0.0; 3 * file_nodes.len()];
        for load in 0..columns.ncols() {
            track.apply_some(&[(load, [1.0; INSTANTS])], played)?;
            played.start()?;
            Playable::body_into(played, Field::Displacement, &mut shown)?;
            let field = mesh_field(body, file_nodes, |place, component| shown[3 * place + component]);
            body.model.dofs().restrict_into(&field, columns.col_as_slice_mut(load));
        }
        Ok(Some(columns))
    })
}

/// Eigenvalues of the natural modes of a file, so many times as large as it has them.
fn eigenvalues(file: &File<'_>, scale: f64) -> Result<Vec<f64>, FileError> {
    Ok(numbers(file, SectionKind::Eigenvalues)?.into_iter().map(|value| scale * value).collect())
}

/// The motion of the full order beside the file.
struct FullMotion {
    energy: Vec<f64>,
    /// Probe values, shape (instants, probes), row-major.
    probes: Vec<f64>,
    seconds_per_step: f64,
}

/// The motion that is exact in time; what a step at full order would take is measured on two of them.
fn motion_of(truth: &ReferenceSolution<'_>, full: &FullOrder<'_>, rows: &[Vec<(u32, f64)>]) -> FullMotion {
    let motion = truth.trajectory(0);
    let probes = motion.along(rows);
    // Column by column, an instant after the other.
    let probes = (0..probes.ncols()).flat_map(|t| probes.col_as_slice(t).to_vec()).collect();
    FullMotion { energy: motion.energy(), probes, seconds_per_step: seconds_per_step(full, 1) }
}

/// True if a scenario is played with exact time integration.
fn moves_exactly(file: &File<'_>, options: &PlayOptions) -> bool {
    let asked = options.scene.structure;
    let own = file.metadata().scheme.is_exact() && asked == StructureChoice::Auto;
    !options.takes_chapter(file) && (own || asked == StructureChoice::Exact)
}
