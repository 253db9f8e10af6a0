//! `vademecum bench`: run time against error, method by method, in one process on one scenario.

mod output;
mod pareto;
mod words;

use std::path::PathBuf;

use vademecum_study::bench::{BenchOptions, compare_methods};

use crate::arguments::{OutputArguments, positive, problem_or_demo, scenario_or_demo};
use crate::console::Console;
use crate::failure::Failure;
use crate::files::outputs;
use crate::print::print_json;

/// Compares every way to get the answer: seconds offline, time per step, and error, on the same scenario.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  vademecum bench -o bench --quick                  the demo's beam and scenario, under two minutes
  vademecum bench body.toml --scenario push.toml -o bench --modes 8,16,32
With 6 to 8 modes the chapter's representation (canonical) plays the scenario too; what ours has over it at
equal time stands below the table.
Every row has two errors: trajectory_error against the march at full order with the same scheme and time
step, which shares the error of the scheme; error_total against a motion that is exact in time (truth_error
estimates its own error). error_time, error_space, error_separation and error_rounding make up the total.
Writes bench.json, bench.csv, bench.md, pareto.svg and pareto-total.svg. What the columns mean: docs/benchmarks/pareto.md")]
pub struct Bench {
    /// The problem file (TOML); the demo's beam if absent.
    problem: Option<PathBuf>,
    /// The scenario file (TOML); for the demo's beam the demo's, for a problem a push held for 200 of 2 000
    /// steps.
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
        outputs.check_in(&self.output, &output::FILES)?;
        outputs.make_folder(&self.output)?;
        let table = compare_methods(&problem, scenario.as_ref(), &self.options(), console)?;
        console.clear();
        if self.split.is_some() {
            eprintln!("  note: `--split` has no effect: the reference is exact in time and marches nothing");
        }
        output::write(&outputs, &self.output, &table)?;
        if self.json {
            print_json(&table);
        } else {
            println!("{}", output::markdown(&table).trim_end());
        }
        Ok(())
    }

    fn options(&self) -> BenchOptions {
        BenchOptions {
            modes: match (&self.modes[..], self.quick) {
                ([], true) => vec![8, 16],
                ([], false) => vec![2, 4, 8, 16, 32, 64],
                (asked, _) => asked.iter().map(|&r| usize::from(r)).collect(),
            },
            steps: self.steps.or(self.quick.then_some(QUICK_STEPS)),
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
