//! `vademecum bench`: run time against error, method by method, in one process on one scenario.

mod candidates;
mod measure;
mod output;

use std::path::PathBuf;

use vademecum_build::bench::{Study, distance, reduced_errors};
use vademecum_build::dynamics::SchemeKind;
use vademecum_build::march::TimedLoad;
use vademecum_build::problem::Problem;
use vademecum_build::progress::Listener;
use vademecum_build::scenario::Scenario;
use vademecum_format::File;

use self::candidates::{Group, groups};
use self::measure::Samples;
pub use self::measure::percentiles;
use self::output::{Report, Row, SchemeError};
use super::demo::{PROBLEM, SCENARIO};
use super::verify::{file_nodes, full_order_loads};
use super::{make_folder, print_json};
use crate::console::Console;
use crate::failure::{Cause, Failure};
use crate::player::Track;

/// Compares every way to get the answer: seconds offline, time per step, and error, on the same scenario.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  vademecum bench -o bench --quick                  the demo's beam and scenario, a minute
  vademecum bench body.toml --scenario push.toml -o bench --modes 8,16,32
Writes bench.json, bench.csv, bench.md and pareto.svg. What the columns mean: docs/benchmarks/pareto.md")]
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
    /// Fewer modes and steps, one time scheme, fewer repetitions.
    #[arg(long)]
    quick: bool,
    /// Print JSON instead of a table.
    #[arg(long)]
    json: bool,
}

/// Steps with `--quick`.
const QUICK_STEPS: usize = 400;
/// Steps of the full-order march with the fine step in one of the problem's.
const SPLIT: usize = 4;

impl Bench {
    pub fn run(&self, console: &Console) -> Result<(), Failure> {
        make_folder(&self.output)?;
        let problem = match &self.problem {
            Some(path) => Problem::read(path)?,
            None => Problem::parse(PROBLEM, "the demo's problem", PathBuf::new())?,
        };
        let asked = self.asked_modes();
        let study = Study::new(&problem, asked.last().copied().unwrap_or(1), console)?;
        let scenario = self.scenario(&study)?;
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
        let groups = groups(&study, &modes, console)?;
        let bench =
            Run { study: &study, scenario: &scenario, groups: &groups, steps, quick: self.quick, console };
        let report = bench.report(problem.title.clone(), &problem.time.scheme)?;
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

    fn scenario(&self, study: &Study) -> Result<Scenario, Failure> {
        Ok(match (&self.scenario, &self.problem) {
            (Some(path), _) => Scenario::read(path)?,
            (None, None) => Scenario::parse(SCENARIO, "the demo's scenario")?,
            (None, Some(_)) => Scenario::parse(&push(study), "the bench's own scenario")?,
        })
    }
}

/// An oblique push on the middle one of the loadable triangles, 200 steps long, and 1 800 steps free.
fn push(study: &Study) -> String {
    let body = &study.prepared().body;
    let triangle = body.loadable[body.loadable.len() / 2];
    let corners = triangle.map(|node| body.model.mesh().nodes[node as usize]);
    let center: [f64; 3] = std::array::from_fn(|c| corners.iter().map(|p| p[c]).sum::<f64>() / 3.0);
    let dt = study.time_step();
    format!(
        "duration = {:e}\n[[contact]]\npoint = {center:?}\nforce = [0.3, -0.5, -0.8]\nend = {:e}\n",
        2000.0 * dt,
        200.0 * dt
    )
}

/// One comparison.
struct Run<'a> {
    study: &'a Study,
    scenario: &'a Scenario,
    groups: &'a [Group],
    steps: usize,
    quick: bool,
    console: &'a Console,
}

impl Run<'_> {
    fn report(&self, title: String, scheme: &SchemeKind) -> Result<Report, Failure> {
        let mut files = self.groups.iter().flat_map(Group::file);
        let bytes = files.next().expect("every group has a file");
        // What errors about a file in memory call it.
        let name = PathBuf::from("the bench's file");
        let file = File::parse(bytes).map_err(|error| Failure::file(&name, error))?;
        let track = Track::bind(&name, &file, self.scenario)?;
        let body = &self.study.prepared().body;
        let loads = full_order_loads(&track, body, &file_nodes(&name, &file, body)?, &name, &file)?;

        let (reference, mut methods, time_scheme_error) = self.full_order(scheme, &loads)?;
        self.console.stage("step reduced");
        let rounds = if self.quick { 3 } else { 7 };
        let samples = measure::all(&name, self.groups, &track, &loads, rounds)?;
        let noise = measure::noise(&samples);
        let mut samples = samples.iter();
        for group in self.groups {
            let coordinates = group.play(&name, &track, &loads, self.steps)?;
            let columns: Vec<_> = coordinates.iter().collect();
            let mass = body.model.pencil().mass();
            let errors = reduced_errors(mass, group.basis.vectors.as_ref(), reference.as_ref(), &columns);
            for (method, error) in group.methods.iter().zip(errors) {
                let samples: &Samples = samples.next().expect("one per method");
                methods.push(Row::reduced(group, method, samples, &error));
            }
        }
        Ok(Report {
            title,
            dofs: body.n_dof(),
            steps: self.steps,
            time_step: self.study.time_step(),
            steps_per_first_period: self.study.first_period() / self.study.time_step(),
            burst: measure::BURST,
            rounds,
            clock_ns_per_step: measure::clock(),
            noise,
            time_scheme_error,
            methods,
        })
    }

    /// Marches full order: the problem's scheme, whose trajectory is the reference, and others beside it.
    fn full_order(
        &self,
        scheme: &SchemeKind,
        loads: &[TimedLoad],
    ) -> Result<(vademecum_build::Matrix, Vec<Row>, Vec<SchemeError>), Failure> {
        let mass = self.study.prepared().body.model.pencil().mass();
        let march = |kind: &SchemeKind, split: usize| {
            self.console.stage(&format!("march full order, {kind}, Δt/{split}"));
            let table = kind.table().map_err(vademecum_build::pipeline::BuildError::from)?;
            self.study.march(&table, split, loads, self.steps, self.console).map_err(Failure::from)
        };
        let fine = march(scheme, SPLIT)?.value.displacement;
        let reference = march(scheme, 1)?;
        let mut others = vec![];
        if !self.quick {
            let all = [
                SchemeKind::Bathe {},
                SchemeKind::Newmark { beta: 0.25, gamma: 0.5 },
                SchemeKind::GeneralizedAlpha { rho_infinity: 0.8 },
            ];
            for kind in all.iter().filter(|kind| *kind != scheme) {
                others.push((*kind, march(kind, 1)?));
            }
        }
        let (mut rows, mut errors) = (vec![], vec![]);
        for (kind, found) in std::iter::once((*scheme, &reference)).chain(others.iter().map(|(k, t)| (*k, t)))
        {
            let u = found.value.displacement.as_ref();
            let apart = distance(mass, u, reference.value.displacement.as_ref());
            errors.push(SchemeError { scheme: kind.to_string(), error: distance(mass, u, fine.as_ref()) });
            let ns = percentiles(found.value.step_seconds.iter().map(|s| 1e9 * s).collect());
            rows.push(Row::full_order(&kind, self.study.prepare_seconds() + found.seconds, ns, apart));
        }
        Ok((reference.value.displacement, rows, errors))
    }
}
