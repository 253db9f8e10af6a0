//! `vademecum build`: from a problem to a file.

use std::path::PathBuf;

use vademecum_build::input::Problem;
use vademecum_build::pipeline::{BuildOptions, Built, build};
use vademecum_build::progress::Listener;
use vademecum_build::store::{Store, check_writable, write_atomic};

use crate::arguments::size;
use crate::console::Console;
use crate::failure::{Cause, Failure};
use crate::print::{bytes, print_json, print_report};

/// Computes a vademecum from a problem file.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  vademecum build beam.toml -o beam.vdm
  vademecum build beam.toml -o beam.vdm --json > beam.json
  vademecum build beam.toml -o beam.vdm --work beam.work   then change beam.toml: only what depends is rebuilt
A build that was stopped goes on where it was when it is started again: finished stages lie in OUTPUT.work
until the file is written.
  vademecum build regions.toml -o regions.vdm --repair
Keys of the problem file: formats/problem-1.md")]
pub struct Build {
    /// The problem file (TOML).
    problem: PathBuf,
    /// The file to write; an existing one is replaced in one step.
    #[arg(short, long, default_value = "body.vdm")]
    output: PathBuf,
    /// Print the report as JSON.
    #[arg(long)]
    json: bool,
    /// Write the file even if no structure keeps the tolerance; its certificate says so.
    #[arg(long)]
    keep_missed: bool,
    /// Folder for finished stages, kept after the build too [default: OUTPUT.work, removed once the file is
    /// written].
    #[arg(long, value_name = "DIR")]
    work: Option<PathBuf>,
    /// Compute every stage anew, whatever is kept.
    #[arg(long)]
    fresh: bool,
    /// Where the step over live parameters is unstable, add terms until it is stable; report and file say
    /// what was done.
    #[arg(long)]
    repair: bool,
    /// Do what is estimated to take more than four hours or 2e7 full-order steps, too.
    #[arg(long)]
    long: bool,
    /// Memory the build may use, such as 8G or 500M [default: what the machine and `ulimit -v` leave].
    #[arg(long, value_name = "SIZE", value_parser = size)]
    memory: Option<u64>,
}

impl Build {
    pub fn run(&self, console: &Console) -> Result<(), Failure> {
        let problem = Problem::read(&self.problem)?;
        check_writable(&self.output).map_err(|error| Failure::io(&self.output, error))?;
        let store = Store::new(&self.work_folder(), self.fresh);
        let built = self.build(&problem, &store, console).inspect_err(|_| {
            if store.holds_stages() {
                let kept = store.folder().display();
                console
                    .note(&format!("finished stages are kept in {kept}: the next build goes on from there"));
            }
        })?;
        if self.work.is_none()
            && let Err(error) = store.remove()
        {
            console.note(&format!("{} cannot be removed: {error}", store.folder().display()));
        }
        console.clear();
        if self.json {
            print_json(&built.report);
        } else {
            print_report(&built.report);
            println!("wrote {} ({})", self.output.display(), bytes(built.report.file_bytes));
        }
        Ok(())
    }
}

impl Build {
    fn build(&self, problem: &Problem, store: &Store, console: &Console) -> Result<Built, Failure> {
        let options =
            BuildOptions { repair: self.repair, store: Some(store), long: self.long, memory: self.memory };
        let outcome = build(problem, &options, console)?;
        let built = if self.keep_missed { outcome.either() } else { outcome.kept()? };
        if console.cancelled() {
            return Err(Failure::new(Cause::Stopped, "stopped on request; nothing was written"));
        }
        write_atomic(&self.output, &built.bytes).map_err(|error| Failure::io(&self.output, error))?;
        Ok(built)
    }

    /// Beside the file, under its name: found again without being told, by the build it belongs to alone.
    fn work_folder(&self) -> PathBuf {
        let beside = || {
            let mut name = self.output.clone().into_os_string();
            name.push(".work");
            name.into()
        };
        self.work.clone().unwrap_or_else(beside)
    }
}
