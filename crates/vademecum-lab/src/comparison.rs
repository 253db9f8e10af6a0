//! Every way to get the answer to one scenario: timed by turns, marched, and measured against one
//! motion that is exact in time.

use vademecum_build::Matrix;
use vademecum_build::dynamics::announce;
use vademecum_build::dynamics::{FullOrder, SchemeKind, TimedLoad};
use vademecum_build::input::{BasisKind, Problem};
use vademecum_build::measured::reference_measured;
use vademecum_build::prepared::Prepared;
use vademecum_build::progress::Listener;
use vademecum_study::parts::{ScenarioLoads, Study, Timed, find_truth};

use super::candidates::{Extent, groups};
use super::chapter;
use super::equal_time::equal_time;
use super::errors::Marches;
use super::march::March;
use super::measure::{self, Candidates, Samples};
use super::method::{Group, Identity, Method, Way};
use super::row::{At, Row};
use super::table::{BenchTable, SchemeDistance};
use super::trajectory::{Reference, distance, march, mean_at_jumps, thinned};
use vademecum_study::StudyError;
use vademecum_study::scenario::{STEPS_AT_FULL_ORDER, Scenario};

/// Options of a comparison.
#[derive(Clone, Debug)]
pub struct BenchOptions {
    /// Numbers of modes.
    pub modes: Vec<usize>,
    /// Steps of the scenario that count for the error; all if absent.
    pub steps: Option<usize>,
    /// Map tolerances of files with a live stiffness.
    pub tolerances: Vec<f64>,
    /// One time scheme, one other Δt, fewer rounds.
    pub quick: bool,
    /// Allow more than four hours of full-order marching.
    pub long: bool,
}

/// Lengths of a step beside the problem's own, as factors on it.
const TIME_STEPS: [TimeStep; 4] = [
    TimeStep { times: 8, parts: 1 },
    TimeStep { times: 4, parts: 1 },
    TimeStep { times: 2, parts: 1 },
    TimeStep { times: 1, parts: 2 },
];

/// The problem's own.
const SAME: TimeStep = TimeStep { times: 1, parts: 1 };

/// A length of a step: the problem's `times` over `parts`; one of the two is 1.
#[derive(Clone, Copy)]
struct TimeStep {
    times: usize,
    parts: usize,
}

/// Compares all methods on a scenario; without one, on [`Study::push`].
///
/// # Errors
/// [`StudyError::NoModes`]; otherwise as the builds, marches and files that it is made of.
pub fn compare_methods(
    problem: &Problem,
    scenario: Option<&Scenario>,
    options: &BenchOptions,
    listener: &dyn Listener,
) -> Result<BenchTable, StudyError> {
    let mut asked = options.modes.clone();
    asked.sort_unstable();
    asked.dedup();
    let study = Study::of(problem, asked.last().copied().unwrap_or(1), options.long, listener)?;
    let scenario = scenario.cloned().map_or_else(|| study.push(), Ok)?;
    let modes = spanned(&study, asked, listener)?;
    let extent = Extent { modes, tolerances: options.tolerances.clone() };
    let mut groups = groups(&study, &extent, listener)?;
    let bytes = groups.iter().flat_map(Group::files).next().expect("every group has a file");
    let bound = ScenarioLoads::new(bytes, &scenario, &study.prepared().body)?;
    chapter::add(&mut groups, &study, &bound, listener)?;
    let asked = options.steps.is_some();
    let all = scenario.steps_within(study.time_step(), STEPS_AT_FULL_ORDER, asked || options.long)?;
    let steps = options.steps.unwrap_or(all).clamp(1, all);
    let full = study.prepared().full_order()?;
    announce("full-order marches to compare", &full, 1, steps as f64, options.long, listener)?;
    let march =
        March { track: &bound.track, loads: &bound.loads, time_step: study.time_step(), steps, stride: 1 };
    let comparison = Comparison { study: &study, groups: &groups, march, quick: options.quick, listener };
    // The study's: what is compared moves by stages, also where the problem asks for exact steps.
    comparison.table(problem.title.clone(), study.problem().scheme())
}

/// The numbers of modes that the snapshots span.
fn spanned(study: &Study, asked: Vec<usize>, listener: &dyn Listener) -> Result<Vec<usize>, StudyError> {
    let span = study.max_modes();
    let (modes, refused): (Vec<usize>, Vec<usize>) = asked.into_iter().partition(|&r| r <= span);
    if !refused.is_empty() {
        listener.note(&format!("left out, the snapshots span {span} dimensions: {refused:?} modes"));
    }
    if modes.is_empty() { Err(StudyError::NoModes { span }) } else { Ok(modes) }
}

/// One comparison.
struct Comparison<'a> {
    study: &'a Study,
    groups: &'a [Group],
    /// At the problem's Δt.
    march: March<'a>,
    quick: bool,
    listener: &'a dyn Listener,
}

/// A full-order solver and what it is.
struct Solver<'a> {
    scheme: SchemeKind,
    full: Timed<FullOrder<'a>>,
}

/// References of the methods, and the times of their steps.
struct Measured {
    /// Of the full-order solvers, one per scheme.
    of_solvers: Vec<Samples>,
    /// Of the methods of all groups, in their order.
    of_methods: Vec<Samples>,
    /// Displacement of the motion that is exact in time, shape (n, steps + 1).
    truth: Matrix,
}

impl Comparison<'_> {
    fn table(&self, title: String, scheme: SchemeKind) -> Result<BenchTable, StudyError> {
        self.listener.stage("factorise");
        let schemes = self.schemes(scheme);
        let solvers = schemes.iter().map(|s| self.solver(s, self.dt())).collect::<Result<Vec<_>, _>>()?;
        self.listener.stage("time the steps");
        let rounds = if self.quick { 3 } else { 7 };
        let full: Vec<_> = solvers.iter().map(|s| &s.full.value).collect();
        let March { track, loads, .. } = self.march;
        let candidates = Candidates { full: &full, groups: self.groups, track, loads };
        let mut of_solvers = measure::all(&candidates, rounds, self.listener)?;
        let noise = measure::noise(&of_solvers);
        let of_methods = of_solvers.split_off(solvers.len());

        let March { loads, steps, .. } = self.march;
        let Prepared { body, symbolic, .. } = self.study.prepared();
        let damping = self.study.prepared().rayleigh();
        let along = (self.dt(), steps);
        let truth = find_truth(
            body.model.pencil(),
            symbolic,
            &|lambda, _| damping.decay(lambda),
            loads,
            along,
            self.listener,
        )?;
        reference_measured("truth_error", truth.trajectory(0).estimate()).map_err(StudyError::from)?;
        let displacement = truth.space() * truth.trajectory(0).coordinates();
        let measured = Measured { of_solvers, of_methods, truth: displacement };
        let (mut methods, mut time_scheme_error) = self.rows(&solvers, &measured)?;
        for length in if self.quick { &TIME_STEPS[2..3] } else { &TIME_STEPS[..] } {
            let (rows, error) = self.rows_at(*length, scheme, &measured)?;
            methods.extend(rows);
            time_scheme_error.push(error);
        }
        Ok(BenchTable {
            title,
            dofs: self.study.prepared().body.n_dof(),
            steps: self.march.steps,
            time_step: self.dt(),
            steps_per_first_period: self.study.first_period() / self.dt(),
            truth_error: truth.trajectory(0).estimate(),
            truth_vectors: truth.vectors(),
            burst: measure::BURST,
            rounds,
            clock_ns_per_step: measure::clock(),
            noise,
            time_scheme_error,
            equal_time: equal_time(&methods, self.dt()),
            methods,
        })
    }

    fn dt(&self) -> f64 {
        self.study.time_step()
    }

    /// The problem's scheme, then the others.
    fn schemes(&self, own: SchemeKind) -> Vec<SchemeKind> {
        let mut all = vec![own];
        if !self.quick {
            let others = [
                SchemeKind::Bathe {},
                SchemeKind::RhoBathe { rho_infinity: 0.5 },
                SchemeKind::Newmark { beta: 0.25, gamma: 0.5 },
                SchemeKind::HhtAlpha { alpha: -0.1 },
                SchemeKind::GeneralizedAlpha { rho_infinity: 0.8 },
            ];
            all.extend(others.into_iter().filter(|kind| *kind != own));
        }
        all
    }

    fn solver(&self, scheme: &SchemeKind, time_step: f64) -> Result<Solver<'_>, StudyError> {
        let table = scheme.table()?;
        Ok(Solver { scheme: *scheme, full: self.study.full_order(&table, time_step)? })
    }

    /// A solver's own march at the instants of the problem's steps, or at every `times`-th.
    fn march_full_order(
        &self,
        solver: &Solver<'_>,
        length: TimeStep,
        loads: &[TimedLoad],
    ) -> Result<Matrix, StudyError> {
        self.listener.stage(&format!("march full order, {}, {:e} s", solver.scheme, solver.full.value.dt()));
        let TimeStep { times, parts } = length;
        Ok(march(&solver.full.value, parts, loads, self.march.steps / times, self.listener)?)
    }

    /// Distance of a scheme from the exact motion, as files sample the loads (known) and, unless `quick`,
    /// with loads at their mean.
    fn scheme_distance(
        &self,
        solver: &Solver<'_>,
        length: TimeStep,
        truth: &Reference,
        error: f64,
    ) -> Result<SchemeDistance, StudyError> {
        let error_mean_at_jumps = if self.quick {
            None
        } else {
            let mean = self.march_full_order(solver, length, &solver.at_mean(self.march.loads))?;
            Some(distance(self.study.mass(), mean.as_ref(), truth.displacement.as_ref()) / truth.norm)
        };
        let (scheme, time_step) = (solver.scheme.to_string(), solver.full.value.dt());
        Ok(SchemeDistance { scheme, time_step, error, error_mean_at_jumps })
    }

    fn offline_seconds(&self, solver: &Solver<'_>) -> f64 {
        self.study.prepare_seconds() + solver.full.seconds
    }

    /// All methods at the problem's Δt: full order with each scheme, then reduced.
    fn rows(
        &self,
        solvers: &[Solver<'_>],
        measured: &Measured,
    ) -> Result<(Vec<Row>, Vec<SchemeDistance>), StudyError> {
        let Measured { of_solvers, of_methods, truth } = measured;
        let at = At { time_step: self.dt(), steps_per_step: 1.0, full_order: &of_solvers[0] };
        let loads = self.march.loads;
        let marches =
            Marches::new(self.study, truth.clone(), self.march_full_order(&solvers[0], SAME, loads)?);
        let (mut rows, mut distances) = (vec![], vec![]);
        for (index, (solver, samples)) in solvers.iter().zip(of_solvers).enumerate() {
            let errors = match index {
                0 => marches.of_full_order(),
                _ => marches.of_other_scheme(self.study, &self.march_full_order(solver, SAME, loads)?),
            };
            let offline = self.offline_seconds(solver);
            rows.push(Row::new(&at, Identity::FullOrder(solver.scheme), samples, errors, offline));
            distances.push(self.scheme_distance(solver, SAME, &marches.truth, errors.error_total)?);
        }
        rows.extend(self.reduced(&at, &marches, &self.march, of_methods, |_, _| true)?);
        Ok((rows, distances))
    }

    /// Full order, the diagonal files and those of exact steps at another Δt. A step costs what it costs at
    /// the problem's own.
    fn rows_at(
        &self,
        length: TimeStep,
        scheme: SchemeKind,
        measured: &Measured,
    ) -> Result<(Vec<Row>, SchemeDistance), StudyError> {
        let Measured { of_solvers, of_methods, truth } = measured;
        let TimeStep { times, parts } = length;
        let time_step = self.dt() * times as f64 / parts as f64;
        let solver = self.solver(&scheme, time_step)?;
        let own = self.march_full_order(&solver, length, self.march.loads)?;
        let marches = Marches::new(self.study, thinned(truth, times), own);
        let steps = parts * (self.march.steps / times);
        let march = March { time_step, steps, stride: parts, ..self.march };
        let samples = &of_solvers[0];
        let at = At { time_step, steps_per_step: parts as f64 / times as f64, full_order: samples };
        let (name, offline) = (Identity::FullOrder(scheme), self.offline_seconds(&solver));
        let mut rows = vec![Row::new(&at, name, samples, marches.of_full_order(), offline)];
        let wanted = |group: &Group, method: &Method| match method.way {
            Way::Diagonal => group.kind == BasisKind::Ritz,
            way => way == Way::Exact,
        };
        rows.extend(self.reduced(&at, &marches, &march, of_methods, wanted)?);
        let distance = self.scheme_distance(&solver, length, &marches.truth, marches.time)?;
        Ok((rows, distance))
    }

    /// Rows of the reduced methods that are wanted.
    fn reduced(
        &self,
        at: &At<'_>,
        marches: &Marches,
        march: &March<'_>,
        mut samples: &[Samples],
        wanted: impl Fn(&Group, &Method) -> bool,
    ) -> Result<Vec<Row>, StudyError> {
        self.listener.stage("march reduced");
        let mut rows = vec![];
        for group in self.groups {
            let wanted = |method: &Method| wanted(group, method);
            for (index, errors, why) in marches.of_group(self.study, group, march, wanted, self.listener)? {
                rows.push(Row::reduced(at, group, &group.methods[index], &samples[index], errors, why));
            }
            samples = &samples[group.methods.len()..];
        }
        Ok(rows)
    }
}

impl Solver<'_> {
    /// Loads at the mean of both sides where they jump on an instant of the solver.
    fn at_mean(&self, loads: &[TimedLoad]) -> Vec<TimedLoad> {
        mean_at_jumps(loads, 1e-3 * self.full.value.dt())
    }
}
