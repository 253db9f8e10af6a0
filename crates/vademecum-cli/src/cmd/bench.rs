//! `vademecum bench`: run time against error, method by method, in one process on one scenario.

mod candidates;
mod canonical;
mod equal_time;
mod errors;
mod inputs;
mod measure;
mod output;
mod pareto;

use std::path::{Path, PathBuf};

use vademecum_build::Matrix;
use vademecum_build::dynamics::TimedLoad;
use vademecum_build::dynamics::{FullOrder, SchemeKind};
use vademecum_build::progress::Listener;
use vademecum_study::StudyError;
use vademecum_study::bench::{Reference, Study, Timed, distance, mean_at_jumps};

use self::candidates::{Extent, Group, March, groups};
use self::equal_time::equal_time;
use self::errors::{Marches, mass, thinned};
use self::inputs::Bound;
pub use self::inputs::{problem_or_demo, scenario_or_push};
pub use self::measure::percentiles;
use self::measure::{Candidates, Samples};
use self::output::{At, Report, Row, SchemeError};
use super::{make_folder, print_json};
use crate::console::Console;
use crate::failure::{Cause, Failure};

/// Compares every way to get the answer: seconds offline, time per step, and error, on the same scenario.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  vademecum bench -o bench --quick                  the demo's beam and scenario, under two minutes
  vademecum bench body.toml --scenario push.toml -o bench --modes 8,16,32
With 6 to 8 modes the chapter's representation (canonical) plays the scenario too; what ours has over it at equal time stands below the table.
Writes bench.json, bench.csv, bench.md, pareto.svg and pareto-total.svg. What the columns mean: docs/benchmarks/pareto.md")]
pub struct Bench {
    /// The problem file (TOML); the demo's beam if absent.
    problem: Option<PathBuf>,
    /// The scenario file (TOML); for the demo's beam the demo's, for a problem a push held for 200 of 2 000 steps.
    #[arg(long)]
    scenario: Option<PathBuf>,
    /// Folder for the results; made if missing.
    #[arg(short, long, default_value = "bench")]
    output: PathBuf,
    /// Numbers of modes [default: 2,4,8,16,32,64; with --quick 8,16].
    #[arg(long, value_delimiter = ',', value_parser = clap::value_parser!(u16).range(1..=256))]
    modes: Vec<u16>,
    /// Steps of the scenario that count for the error [default: all; with --quick 400].
    #[arg(long)]
    steps: Option<usize>,
    /// Steps of the reference march in one of the problem's [default: 8; with --quick 4].
    #[arg(long, value_parser = clap::value_parser!(u16).range(2..=256))]
    split: Option<u16>,
    /// Map tolerances of files with a live stiffness, 8 to 16 modes each [default: 1e-3,1e-5,1e-7; with --quick none].
    #[arg(long, value_delimiter = ',')]
    tolerance: Vec<f64>,
    /// Fewer modes and steps, one time scheme, no live stiffness, fewer repetitions.
    #[arg(long)]
    quick: bool,
    /// Print JSON instead of a table.
    #[arg(long)]
    json: bool,
}

/// Steps with `--quick`.
const QUICK_STEPS: usize = 400;
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

impl Bench {
    pub fn run(&self, console: &Console) -> Result<(), Failure> {
        make_folder(&self.output)?;
        let problem = problem_or_demo(self.problem.as_deref())?;
        let asked = self.asked_modes();
        let study = Study::new(&problem, asked.last().copied().unwrap_or(1), console)?;
        let scenario = scenario_or_push(self.scenario.as_deref(), self.problem.as_deref(), &study)?;
        let steps = self.steps.unwrap_or(if self.quick { QUICK_STEPS } else { usize::MAX });
        let steps = steps.clamp(1, scenario.steps(study.time_step()));
        let (modes, refused): (Vec<usize>, Vec<usize>) =
            asked.into_iter().partition(|&r| r <= study.max_modes());
        if !refused.is_empty() {
            console.note(&format!(
                "left out, the snapshots span {} dimensions: {refused:?} modes",
                study.max_modes()
            ));
        }
        if modes.is_empty() {
            let text = format!(
                "no number of modes is left to compare: the snapshots span {} dimensions",
                study.max_modes()
            );
            return Err(
                Failure::new(Cause::Input, text).remedy("ask for fewer `--modes`, or add to `[snapshots]`")
            );
        }
        let extent = self.extent(modes);
        let mut groups = groups(&study, &extent, console)?;
        // What errors about a file in memory call it.
        let name = Path::new("the bench's file");
        let bytes = groups.iter().flat_map(Group::file).next().expect("every group has a file");
        let bound = Bound::new(name, bytes, &scenario, &study)?;
        canonical::add(&mut groups, &extent.canonical, &study, &bound, console)?;
        let Bound { track, loads, .. } = &bound;
        let split = usize::from(self.split.unwrap_or(if self.quick { 4 } else { 8 }));
        let quick = self.quick;
        let scheme = problem.time.scheme;
        let march = March { name, track, loads, time_step: study.time_step(), steps, stride: 1 };
        let run = Run { study: &study, groups: &groups, march, scheme, steps, split, quick, console };
        let report = run.report(problem.title.clone())?;
        console.clear();
        report.write(&self.output)?;
        if self.json {
            print_json(&report);
        } else {
            print!("{}", report.markdown());
        }
        Ok(())
    }

    /// Ascending, each once.
    fn asked_modes(&self) -> Vec<usize> {
        let mut modes: Vec<usize> = self.modes.iter().map(|&r| usize::from(r)).collect();
        if modes.is_empty() {
            modes = if self.quick { vec![8, 16] } else { vec![2, 4, 8, 16, 32, 64] };
        }
        modes.sort_unstable();
        modes.dedup();
        modes
    }

    /// Files with a live parameter take long to make, those of the chapter's representation with many modes too: a few of them.
    fn extent(&self, modes: Vec<usize>) -> Extent {
        let separated = modes.iter().copied().filter(|r| (8..=16).contains(r)).collect();
        let canonical = modes.iter().copied().filter(|r| (6..=8).contains(r)).collect();
        let tolerances = match (&self.tolerance[..], self.quick) {
            ([], true) => vec![],
            ([], false) => vec![1e-3, 1e-5, 1e-7],
            (asked, _) => asked.to_vec(),
        };
        Extent { modes, separated, tolerances, canonical }
    }
}

/// One comparison.
struct Run<'a> {
    study: &'a Study,
    groups: &'a [Group],
    march: March<'a>,
    scheme: SchemeKind,
    steps: usize,
    split: usize,
    quick: bool,
    console: &'a Console,
}

/// A full-order solver and what it is.
struct Solver<'a> {
    scheme: SchemeKind,
    full: Timed<FullOrder<'a>>,
}

impl Run<'_> {
    fn report(&self, title: String) -> Result<Report, Failure> {
        let March { name, track, loads, .. } = self.march;
        self.console.stage("factorise");
        let solvers =
            self.schemes().iter().map(|s| self.solver(s, self.dt())).collect::<Result<Vec<_>, _>>()?;
        self.console.stage("time the steps");
        let rounds = if self.quick { 3 } else { 7 };
        let full: Vec<_> = solvers.iter().map(|s| &s.full.value).collect();
        let candidates = Candidates { full: &full, groups: self.groups, track, loads };
        let samples = measure::all(name, &candidates, rounds)?;

        let fine = self.fine_march(loads)?;
        let comparison = Comparison { run: self, samples: &samples, fine, march: self.march };
        let (mut methods, mut time_scheme_error) = comparison.rows(&solvers)?;
        for length in if self.quick { &TIME_STEPS[2..3] } else { &TIME_STEPS[..] } {
            let (rows, error) = comparison.rows_at(*length, &samples[solvers.len()..])?;
            methods.extend(rows);
            time_scheme_error.push(error);
        }
        Ok(Report {
            title,
            dofs: self.study.prepared().body.n_dof(),
            steps: self.steps,
            time_step: self.dt(),
            steps_per_first_period: self.study.first_period() / self.dt(),
            split: self.split,
            burst: measure::BURST,
            rounds,
            clock_ns_per_step: measure::clock(),
            noise: measure::noise(&samples),
            time_scheme_error,
            equal_time: equal_time(&methods, self.dt()),
            methods,
        })
    }

    fn dt(&self) -> f64 {
        self.study.time_step()
    }

    /// The problem's scheme, then the others.
    fn schemes(&self) -> Vec<SchemeKind> {
        let mut all = vec![self.scheme];
        if !self.quick {
            let others = [
                SchemeKind::Bathe {},
                SchemeKind::RhoBathe { rho_infinity: 0.5 },
                SchemeKind::Newmark { beta: 0.25, gamma: 0.5 },
                SchemeKind::HhtAlpha { alpha: -0.1 },
                SchemeKind::GeneralizedAlpha { rho_infinity: 0.8 },
            ];
            all.extend(others.into_iter().filter(|kind| *kind != self.scheme));
        }
        all
    }

    fn solver(&self, scheme: &SchemeKind, time_step: f64) -> Result<Solver<'_>, Failure> {
        let table = scheme.table().map_err(StudyError::from)?;
        Ok(Solver { scheme: *scheme, full: self.study.full_order(&table, time_step)? })
    }

    /// What all errors are measured from: the problem's scheme with a fine step, loads at their mean where they jump.
    fn fine_march(&self, loads: &[TimedLoad]) -> Result<Matrix, Failure> {
        self.console.stage(&format!("march full order, {}, Δt/{}", self.scheme, self.split));
        let solver = self.solver(&self.scheme, self.dt() / self.split as f64)?;
        let loads = at_mean(&solver, loads);
        Ok(self.study.march(&solver.full.value, self.split, &loads, self.steps, self.console)?)
    }

    /// A solver's own march at the instants of the problem's steps, or at every `times`-th.
    fn march_full_order(
        &self,
        solver: &Solver<'_>,
        length: TimeStep,
        loads: &[TimedLoad],
    ) -> Result<Matrix, Failure> {
        self.console.stage(&format!("march full order, {}, {:e} s", solver.scheme, solver.full.value.dt()));
        let TimeStep { times, parts } = length;
        Ok(self.study.march(&solver.full.value, parts, loads, self.steps / times, self.console)?)
    }

    /// How far a scheme is from the fine march, as files sample the loads (known) and, unless `quick`, with loads at their
    /// mean.
    fn scheme_error(
        &self,
        solver: &Solver<'_>,
        length: TimeStep,
        loads: &[TimedLoad],
        fine: &Reference,
        error: f64,
    ) -> Result<SchemeError, Failure> {
        let error_mean_at_jumps = if self.quick {
            None
        } else {
            let mean = self.march_full_order(solver, length, &at_mean(solver, loads))?;
            Some(distance(mass(self.study), mean.as_ref(), fine.displacement.as_ref()) / fine.norm)
        };
        let (scheme, time_step) = (solver.scheme.to_string(), solver.full.value.dt());
        Ok(SchemeError { scheme, time_step, error, error_mean_at_jumps })
    }

    fn offline_seconds(&self, solver: &Solver<'_>) -> f64 {
        self.study.prepare_seconds() + solver.full.seconds
    }
}

/// Loads at the mean of both sides where they jump on an instant of the solver.
fn at_mean(solver: &Solver<'_>, loads: &[TimedLoad]) -> Vec<TimedLoad> {
    mean_at_jumps(loads, 1e-3 * solver.full.value.dt())
}

/// Methods played and measured against one fine march.
struct Comparison<'a> {
    run: &'a Run<'a>,
    samples: &'a [Samples],
    fine: Matrix,
    march: March<'a>,
}

impl Comparison<'_> {
    /// All methods at the problem's Δt: full order with each scheme, then reduced.
    fn rows(&self, solvers: &[Solver<'_>]) -> Result<(Vec<Row>, Vec<SchemeError>), Failure> {
        let Self { run, samples, fine, march } = self;
        let at = At { time_step: run.dt(), steps_per_step: 1.0, full_order: &samples[0] };
        let own = run.march_full_order(&solvers[0], SAME, march.loads)?;
        let marches = Marches::new(run.study, fine.clone(), own);
        let (mut rows, mut scheme_errors) = (vec![], vec![]);
        for (index, (solver, samples)) in solvers.iter().zip(*samples).enumerate() {
            let errors = match index {
                0 => marches.of_full_order(),
                _ => marches.of_other_scheme(run.study, &run.march_full_order(solver, SAME, march.loads)?),
            };
            let (name, offline) = (solver.scheme.to_string(), run.offline_seconds(solver));
            rows.push(Row::full_order(&at, &name, offline, samples, errors));
            let error = errors.error_total;
            scheme_errors.push(run.scheme_error(solver, SAME, march.loads, &marches.fine, error)?);
        }
        rows.extend(self.reduced(&at, &marches, march, &samples[solvers.len()..], |_| true)?);
        Ok((rows, scheme_errors))
    }

    /// Full order and the diagonal files at another Δt. A step costs what it costs at the problem's own.
    fn rows_at(&self, length: TimeStep, reduced: &[Samples]) -> Result<(Vec<Row>, SchemeError), Failure> {
        let Self { run, samples, fine, march } = self;
        let TimeStep { times, parts } = length;
        let time_step = run.dt() * times as f64 / parts as f64;
        let solver = run.solver(&run.scheme, time_step)?;
        let own = run.march_full_order(&solver, length, march.loads)?;
        let marches = Marches::new(run.study, thinned(fine, times), own);
        let steps = parts * (run.steps / times);
        let march = March { time_step, steps, stride: parts, ..*march };
        let at = At { time_step, steps_per_step: parts as f64 / times as f64, full_order: &samples[0] };
        let name = solver.scheme.to_string();
        let errors = marches.of_full_order();
        let mut rows = vec![Row::full_order(&at, &name, run.offline_seconds(&solver), &samples[0], errors)];
        rows.extend(self.reduced(&at, &marches, &march, reduced, |name| name.starts_with("ritz diagonal"))?);
        let error = run.scheme_error(&solver, length, march.loads, &marches.fine, marches.time)?;
        Ok((rows, error))
    }

    /// Rows of the reduced methods that `wanted` names.
    fn reduced(
        &self,
        at: &At<'_>,
        marches: &Marches,
        march: &March<'_>,
        mut samples: &[Samples],
        wanted: impl Fn(&str) -> bool,
    ) -> Result<Vec<Row>, Failure> {
        self.run.console.stage("march reduced");
        let mut rows = vec![];
        for group in self.run.groups {
            for (index, errors, why) in marches.of_group(self.run.study, group, march, &wanted)? {
                rows.push(Row::reduced(at, group, &group.methods[index], &samples[index], errors, why));
            }
            samples = &samples[group.methods.len()..];
        }
        Ok(rows)
    }
}
