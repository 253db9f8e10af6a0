//! `vademecum-lab bench`: run time against error, method by method, in one process on one scenario.

mod large;
mod output;
mod pareto;
mod scatter;
mod words;

use std::path::PathBuf;

use serde::Serialize;
use vademecum_build::input::Problem;
use vademecum_build::store::Outputs;
use vademecum_cli::front::{
    Console, OutputArguments, outputs, positive, print_json, problem_or_demo, scenario_or_demo,
};
use vademecum_cli::{Cause, Failure};
use vademecum_lab::{BenchOptions, LargeBenchOptions, compare_large_methods, compare_methods};
use vademecum_study::scenario::Scenario;

/// Benchmark of all methods on one scenario: offline time, time per step, error.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  vademecum-lab bench -o bench --quick                  the demo's beam and scenario, under two minutes
  vademecum-lab bench body.toml --scenario push.toml -o bench --modes 8,16,32
With 6 to 8 modes the chapter's representation (canonical) plays the scenario too; what ours has over it at
equal time stands below the table.
Every row has two errors: trajectory_error against the march at full order with the same scheme and time
step, which shares the error of the scheme; error_total against a motion that is exact in time (truth_error
estimates its own error). error_time, error_space, error_separation and error_rounding make up the total.
Writes bench.json, bench.csv, bench.md, pareto.svg and pareto-total.svg. What the columns mean:
docs/measurements/pareto.md
A problem with `model = \"large-displacement\"` is built once. Its file with 1, 2, 4 and 8 sub-steps in a step
(--quick: 1 and 4), its linear model, a Galerkin model that visits all elements, and the full order with 1, 2
and 4 steps (--quick: 1 and 4) are measured against a fine march at full order: error_basis, error_closure,
error_time and error_rounding make up the total. There is no pareto-total.svg, and --modes and --tolerance are
refused: the problem file says how many coordinates there are. See docs/how-to/large-displacements.md")]
pub struct Bench {
    /// The problem file (TOML); the demo's beam if absent.
    problem: Option<PathBuf>,
    /// The scenario file (TOML); for the demo's beam the demo's, for a problem a push held for 200 of 2 000
    /// steps, or at large displacements a pulse of the first of five periods.
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
    /// Without effect since 0.2: the reference is exact in time and has no steps.
    #[arg(long, hide = true)]
    split: Option<u16>,
    /// Map tolerances of files with a live stiffness, 8 to 16 modes each [default: 1e-3,1e-5,1e-7; with
    /// --quick none].
    #[arg(long, value_delimiter = ',', value_parser = positive)]
    tolerance: Vec<f64>,
    /// Fewer modes and steps, one time scheme, no live stiffness, fewer repetitions.
    #[arg(long)]
    quick: bool,
    /// March at full order for more than four hours or 2e7 steps, too.
    #[arg(long)]
    long: bool,
    /// Print JSON instead of a table.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    outputs: OutputArguments,
}

/// Steps with `--quick`.
const QUICK_STEPS: usize = 400;

impl Bench {
    pub fn run(&self, console: &Console) -> Result<(), Failure> {
        let problem = problem_or_demo(self.problem.as_deref())?;
        let scenario = scenario_or_demo(self.scenario.as_deref(), self.problem.as_deref())?;
        let inputs = [self.problem.as_deref(), self.scenario.as_deref()];
        let outputs = outputs(&self.outputs, &inputs, Some(&problem));
        if problem.is_large() {
            return self.large(&problem, scenario.as_ref(), &outputs, console);
        }
        outputs.check_in(&self.output, &output::FILES)?;
        outputs.make_folder(&self.output)?;
        let table = compare_methods(&problem, scenario.as_ref(), &self.options(), console)?;
        self.end(&table, &output::markdown(&table), console, || output::write(&outputs, &self.output, &table))
    }

    /// The comparison of a body of large displacements.
    fn large(
        &self,
        problem: &Problem,
        scenario: Option<&Scenario>,
        outputs: &Outputs,
        console: &Console,
    ) -> Result<(), Failure> {
        self.refuse_linear_options()?;
        outputs.check_in(&self.output, &large::FILES)?;
        outputs.make_folder(&self.output)?;
        let options = LargeBenchOptions { steps: self.steps(), quick: self.quick, long: self.long };
        let table = compare_large_methods(problem, scenario, &options, console)?;
        self.end(&table, &large::markdown(&table), console, || large::write(outputs, &self.output, &table))
    }

    /// Writes a table, and prints it.
    fn end(
        &self,
        table: &impl Serialize,
        markdown: &str,
        console: &Console,
        write: impl FnOnce() -> Result<(), Failure>,
    ) -> Result<(), Failure> {
        console.clear();
        if self.split.is_some() {
            eprintln!(
                "  note: `--split` has no effect: nothing is marched by parts of a step of one's choice"
            );
        }
        write()?;
        if self.json {
            print_json(table);
        } else {
            println!("{}", markdown.trim_end());
        }
        Ok(())
    }

    /// Options that a comparison at large displacements has no meaning for.
    fn refuse_linear_options(&self) -> Result<(), Failure> {
        for (name, given, remedy) in [
            (
                "modes",
                !self.modes.is_empty(),
                "leave it out; `basis.modes` in the problem file says how many coordinates there are",
            ),
            (
                "tolerance",
                !self.tolerance.is_empty(),
                "leave it out; it is for files with a live stiffness of a region, which is of linear motion",
            ),
        ] {
            if given {
                let text = format!("`--{name}` has no meaning with `model = \"large-displacement\"`");
                return Err(Failure::new(Cause::Usage, text).remedy(remedy));
            }
        }
        Ok(())
    }

    /// Steps that count for the error.
    fn steps(&self) -> Option<usize> {
        self.steps.or(self.quick.then_some(QUICK_STEPS))
    }

    fn options(&self) -> BenchOptions {
        BenchOptions {
            modes: match (&self.modes[..], self.quick) {
                ([], true) => vec![8, 16],
                ([], false) => vec![2, 4, 8, 16, 32, 64],
                (asked, _) => asked.iter().map(|&r| usize::from(r)).collect(),
            },
            steps: self.steps(),
            tolerances: match (&self.tolerance[..], self.quick) {
                ([], true) => vec![],
                ([], false) => vec![1e-3, 1e-5, 1e-7],
                (asked, _) => asked.to_vec(),
            },
            quick: self.quick,
            long: self.long,
        }
    }
}
