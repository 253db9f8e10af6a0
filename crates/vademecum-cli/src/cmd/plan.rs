//! `vademecum plan`: many builds as a list of jobs.

use std::path::PathBuf;

use serde::Serialize;
use vademecum_build::input::Problem;
use vademecum_study::sweep::{Jobs, Sweep, SweepError};

use crate::arguments::OutputArguments;
use crate::failure::{Cause, Failure};
use crate::files::{check_own, outputs, write_own};
use crate::print::{json, print_json};

/// Writes many builds as a list of jobs, which any scheduler can run.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  vademecum plan sweep.toml -o sweep             a problem file for each job, and sweep/jobs.txt
  parallel --jobs 4 < sweep/jobs.txt             run them with GNU parallel
  sed -n \"${SLURM_ARRAY_TASK_ID}p\" sweep/jobs.txt | sh      the same in a job array of Slurm
  vademecum collect sweep                        what is done, and what is left
A line that was killed is run again as it stands: its build goes on from its finished stages, and a build that
is done does nothing. Keys of the sweep file: `vademecum help sweep`")]
pub(crate) struct Plan {
    /// The sweep file (TOML).
    sweep: PathBuf,
    /// The folder for problem files, the list of jobs, and what they build; it has to stay where it is.
    #[arg(short, long, default_value = "sweep")]
    output: PathBuf,
    /// Print JSON.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    outputs: OutputArguments,
}

/// Report of a plan.
#[derive(Serialize)]
struct PlanOutput {
    /// Number of jobs.
    jobs: usize,
    /// Their list.
    list: PathBuf,
}

/// Remedy for a folder that has other jobs.
const ANOTHER: &str = "plan another sweep into a folder of its own; what a folder has built stays";

impl Plan {
    pub(crate) fn run(&self) -> Result<(), Failure> {
        let Jobs { jobs, arguments } = Sweep::read(&self.sweep)
            .map_err(SweepError::File)
            .and_then(|sweep| sweep.jobs(&self.sweep))
            .map_err(|error| Failure::new(Cause::Input, error))?;
        let planned = Jobs { jobs, arguments };
        let machine = |error: std::io::Error| Failure::new(Cause::Machine, error);
        let plan = planned.plan(&self.output).map_err(machine)?;
        let list: String = plan.jobs.iter().map(|job| format!("{}\n", job.line)).collect();
        let mut files = vec![];
        for job in planned.jobs {
            files.push((self.output.join(format!("{}.toml", job.name)), job.text));
        }
        let jobs = files.len();
        let list_file = self.output.join("jobs.txt");
        files.push((list_file.clone(), list));
        files.push((self.output.join("plan.json"), json(&plan) + "\n"));

        let outputs = outputs(&self.outputs, &[Some(&self.sweep)], None::<&Problem>);
        outputs.make_folder(&self.output)?;
        for (path, text) in &files {
            check_own(&outputs, path, text).map_err(|failure| failure.remedy(ANOTHER))?;
        }
        for (path, text) in &files {
            write_own(&outputs, path, text)?;
        }
        let planned = PlanOutput { jobs, list: list_file };
        if self.json {
            print_json(&planned);
        } else {
            println!(
                "{jobs} jobs in {}; run each line of it, then `vademecum collect`",
                planned.list.display()
            );
        }
        Ok(())
    }
}
