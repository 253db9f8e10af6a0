//! Every way to step a body of large displacements on one scenario: timed, marched, and measured against one
//! reference.

use faer::MatRef;
use vademecum_build::Matrix;
use vademecum_build::fem::GreenStrain;
use vademecum_build::input::Problem;
use vademecum_build::limits::Memory;
use vademecum_build::measured::reference_measured;
use vademecum_build::pipeline::{BuildError, BuildOptions, Built, Outcome, SHAPES, build};
use vademecum_build::prepared::{Prepared, prepare};
use vademecum_build::progress::{Listener, Stopwatch};
use vademecum_format::File;
use vademecum_study::parts::{BoundScenario, Extent, LargeMotion, MarchDistance, Timed, orthonormal};

use super::push::push;
use super::rows::{FullOrderRows, Through};
use super::table::{LargeBenchTable, LargeErrors, LargeMethod, LargeRow};
use crate::measure;
use crate::trajectory::{Projection, Reference};
use vademecum_study::player::PlayOptions;
use vademecum_study::scenario::{STEPS_AT_FULL_ORDER, Scenario};
use vademecum_study::{FileError, StudyError};

/// Options of a comparison.
#[derive(Clone, Copy, Debug, Default)]
pub struct LargeBenchOptions {
    /// Steps of the scenario that count for the error; all if absent.
    pub steps: Option<usize>,
    /// Fewer rows and rounds.
    pub quick: bool,
    /// Allow more than four hours of full-order marching.
    pub long: bool,
}

impl LargeBenchOptions {
    /// Sub-steps of the file.
    fn substeps(self) -> &'static [usize] {
        if self.quick { &[1, 4] } else { &[1, 2, 4, 8] }
    }

    /// Steps in a step of the file, with Newton's method on the coordinates of the file.
    fn galerkin(self) -> &'static [usize] {
        if self.quick { &[1] } else { &[1, 2] }
    }

    /// The same at full order.
    fn full_order(self) -> &'static [usize] {
        if self.quick { &[1, COMPARED] } else { &[1, 2, COMPARED] }
    }

    /// Allow scenarios of any length.
    fn any_length(self) -> bool {
        self.long || self.steps.is_some()
    }

    fn extent(self, steps: usize) -> Extent {
        let beside = self.galerkin().iter().chain(self.full_order()).sum();
        Extent { steps, beside, long: self.long, what: WHAT }
    }
}

/// Steps of the reference in a step of the file, at first: twice as many as the finest row has.
const PARTS: usize = 2 * COMPARED;

/// Steps at full order that the step of a row is compared with, as in a certificate.
const COMPARED: usize = 4;

/// Trajectories that are held at once: the reference, its product with the mass, and one beside it.
const HELD: f64 = 3.0;

/// Description for messages.
const WHAT: &str =
    "the reference at full order and large displacements, one with twice its step, and the rows that march";

/// Compares all methods on a scenario; without one, on a push by which the body moves about as far as
/// `large.displacement` asks for: where it gives way most, as a pulse of one first period.
///
/// # Errors
/// [`FileError::NotFree`]: a scenario that throws the body; [`StudyError::NothingToPush`];
/// [`StudyError::LargeMarch`]: Newton's method finds no next step; [`StudyError::Build`]: a build that fails,
/// more memory than there is, more work than was asked for; otherwise as
/// [`verify`](vademecum_study::verify::verify()).
pub fn compare_large_methods(
    problem: &Problem,
    scenario: Option<&Scenario>,
    options: &LargeBenchOptions,
    listener: &dyn Listener,
) -> Result<LargeBenchTable, StudyError> {
    let prepared = Timed::of(|| prepare(problem, &mut Stopwatch::new(listener), listener))?;
    let scenario = scenario.cloned().map_or_else(|| push(problem, &prepared.value), Ok)?;
    let steps = steps(&scenario, options, &prepared.value)?;
    let built = Timed::of(|| {
        let build_options = BuildOptions { long: options.long, ..BuildOptions::default() };
        build(problem, &build_options, listener)
    })?;
    if matches!(built.value, Outcome::Missed(_)) {
        listener.note("the file misses its tolerance; it is compared all the same");
    }
    let built = Timed { value: built.value.either(), seconds: built.seconds };
    let comparison =
        LargeComparison { problem, prepared: &prepared, built: &built, options, steps, listener };
    comparison.table(&scenario)
}

/// Steps that are compared, once scenario and machine allow them.
fn steps(scenario: &Scenario, options: &LargeBenchOptions, prepared: &Prepared) -> Result<usize, StudyError> {
    if scenario.free.is_some() {
        return Err(FileError::NotFree.into());
    }
    let all = scenario.steps_within(prepared.step.time_step, STEPS_AT_FULL_ORDER, options.any_length())?;
    let steps = options.steps.unwrap_or(all).clamp(1, all);
    let bytes = HELD * 8.0 * prepared.body.n_dof() as f64 * (1 + steps) as f64;
    let instead = ": fewer steps (`--steps`), or a coarser mesh";
    let memory = Memory::asked_or_available(None);
    memory.check(bytes, instead, || "motions at full order".into()).map_err(BuildError::Memory)?;
    Ok(steps)
}

/// One comparison.
struct LargeComparison<'a> {
    problem: &'a Problem,
    prepared: &'a Timed<Prepared>,
    built: &'a Timed<Built>,
    options: &'a LargeBenchOptions,
    steps: usize,
    listener: &'a dyn Listener,
}

/// The reference, and what was seen of it.
struct Truth {
    motion: Reference,
    /// On the basis of the file.
    seen: Projection,
    /// Distance from the march with twice its step.
    apart: f64,
    parts: usize,
    displacement: f64,
    least_stretch: f64,
}

impl LargeComparison<'_> {
    fn table(&self, scenario: &Scenario) -> Result<LargeBenchTable, StudyError> {
        let Self { problem, prepared, built, options, steps, listener } = *self;
        let prepared = &prepared.value;
        let file = File::parse(&built.value.bytes)?;
        let play = PlayOptions { long: options.any_length(), ..PlayOptions::default() };
        let bound = BoundScenario::new(&file, &play, problem, prepared, scenario, listener)?;
        let body = bound.body;
        let mass = body.model.pencil().mass();
        let strain = GreenStrain::new(&body.model)?;
        let motion = LargeMotion::new(&strain, prepared, &bound.setting, &bound.loads);
        let modes = bound.basis.ncols();
        let identity = Matrix::identity(modes, modes);
        let (basis, turn) = orthonormal(mass, bound.basis.as_ref(), identity.as_ref())?;

        // Refused, if it is too long, before anything is stepped.
        let extent = options.extent(steps);
        let reference = motion.reference(PARTS, &extent, listener)?;
        let bytes = &built.value.bytes;
        let through = Through { bytes, track: &bound.track, steps, turn: turn.as_ref(), listener };
        let rounds = if options.quick { 3 } else { 7 };
        let played = through.all(options.substeps(), rounds)?;
        let (truth, _) = motion.known(reference, &extent, listener, |reference| {
            let mut moved = Matrix::zeros(mass.n(), 1 + steps);
            let (mut apart, mut displacement, mut least_stretch) =
                (MarchDistance::default(), 0.0_f64, f64::INFINITY);
            reference.march(steps, listener, |step, [fine, coarse], _| {
                moved.col_as_slice_mut(step).copy_from_slice(fine);
                apart.add(mass, [fine, coarse]);
                displacement = displacement.max(body.largest_displacement(fine));
                least_stretch = least_stretch.min(strain.least_stretch(fine));
            })?;
            let moved = Reference::new(mass, moved);
            let seen = moved.project(mass, basis.as_ref());
            let shown = [apart.share(), played.least_error(&seen)];
            let (apart, parts) = (apart.share(), reference.parts);
            Ok((Truth { motion: moved, seen, apart, parts, displacement, least_stretch }, shown))
        })?;
        let marched = FullOrderRows { motion: &motion, mass, truth: &truth.motion, steps, listener };
        let mut methods = self.marched(&marched, basis.as_ref(), truth.seen.floor())?;
        let offline = (built.seconds, bytes.len());
        methods.extend(played.rows(&truth.seen, truth.motion.norm, offline));
        compare_times(&mut methods);
        reference_measured("truth_error", truth.apart).map_err(StudyError::from)?;
        let report = &built.value.report;
        Ok(LargeBenchTable {
            title: problem.title.clone(),
            dofs: body.n_dof(),
            coordinates: basis.ncols(),
            strain_rows: report.large.as_ref().map_or(0, |large| large.rows),
            steps,
            time_step: bound.time_step,
            steps_per_first_period: report.steps_per_first_period,
            displacement: truth.displacement,
            least_stretch: truth.least_stretch,
            truth_error: truth.apart,
            truth_parts: truth.parts,
            burst: measure::BURST,
            rounds,
            clock_ns_per_step: measure::clock(),
            noise: played.noise(),
            methods,
        })
    }

    /// Full order, and Newton's method on the basis of the file.
    fn marched(
        &self,
        marched: &FullOrderRows<'_>,
        basis: MatRef<'_, f64>,
        floor: f64,
    ) -> Result<Vec<LargeRow>, StudyError> {
        let (motion, prepare_seconds) = (marched.motion, self.prepared.seconds);
        let mut rows = vec![];
        for &parts in self.options.full_order() {
            let row = marched.row(LargeMethod::FullOrder, &motion.march(parts)?, parts, prepare_seconds)?;
            let error_time = Some(row.errors.error_total);
            rows.push(LargeRow { errors: LargeErrors { error_time, ..row.errors }, ..row });
        }
        let offline_seconds = prepare_seconds + seconds_to_basis(&self.built.value);
        for &parts in self.options.galerkin() {
            let march = motion.march(parts)?.within(basis)?;
            let row = marched.row(LargeMethod::Galerkin, &march, parts, offline_seconds)?;
            let errors = LargeErrors { error_basis: Some(floor), ..row.errors };
            rows.push(LargeRow { modes: Some(basis.ncols()), errors, ..row });
        }
        Ok(rows)
    }
}

/// Wall time of a build up to its basis \[s\].
fn seconds_to_basis(built: &Built) -> f64 {
    let timings = &built.report.timings;
    let last = timings.iter().position(|timing| timing.stage == SHAPES).unwrap_or(0);
    timings[..=last].iter().map(|timing| timing.seconds).sum()
}

/// Ratio of the times of [`COMPARED`] steps at full order take as a step of each row.
fn compare_times(rows: &mut [LargeRow]) {
    let is_compared = |row: &&LargeRow| row.name == LargeMethod::FullOrder && row.substeps == COMPARED;
    let full_order = rows.iter().find(is_compared).map_or(f64::NAN, |row| row.step_ns_p50);
    rows.iter_mut().for_each(|row| row.times_full_order = full_order / row.step_ns_p50);
}
