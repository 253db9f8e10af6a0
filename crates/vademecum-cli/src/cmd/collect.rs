//! `vademecum collect`: what became of the jobs of a folder.

use std::path::{Path, PathBuf};

use serde::Serialize;
use vademecum_build::store::{Kind, read_regular, read_text};
use vademecum_study::sweep::{Meshes, Outcome, Plan, PlannedJob, State, VERSION, look};

use crate::arguments::OutputArguments;
use crate::failure::{Cause, Failure, UNREAD};
use crate::files::{check_output, outputs, write_bytes};
use crate::print::print_json;
use crate::words::bytes;

/// Checks the files that the jobs of `plan` have built and collects their figures in one table.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  vademecum collect sweep                        what is done, and the figures of it
  vademecum collect sweep -o sweep.csv           the same as a table
  vademecum collect sweep --left left.txt        the lines that are still to run
Every file is compared with its checksums, and with the problem file and the mesh of its job. The exit code is
7 while a job is left.")]
pub(crate) struct Collect {
    /// The folder of `vademecum plan`.
    folder: PathBuf,
    /// A table (CSV) of all jobs, their values and figures.
    #[arg(short, long)]
    output: Option<PathBuf>,
    /// A list of the jobs that are still to run; empty where none is left.
    #[arg(long, value_name = "FILE")]
    left: Option<PathBuf>,
    /// Print JSON.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    outputs: OutputArguments,
}

/// A job and what became of it.
#[derive(Serialize)]
struct CollectedJob {
    name: String,
    problem: String,
    values: toml::Table,
    state: State,
    /// Fault of its file; empty if the state is enough.
    reason: String,
    #[serde(flatten)]
    outcome: Option<Outcome>,
}

/// All jobs.
#[derive(Serialize)]
struct Collection {
    jobs: Vec<CollectedJob>,
    done: usize,
    left: usize,
}

impl Collect {
    pub(crate) fn run(&self) -> Result<(), Failure> {
        let outputs = outputs(&self.outputs, &[], None);
        for (path, kind) in [(&self.output, Kind::Csv), (&self.left, Kind::Text)] {
            path.iter().try_for_each(|path| check_output(&outputs, path, kind))?;
        }
        let plan = self.plan()?;
        let mut jobs = vec![];
        let mut left = String::new();
        let mut meshes = Meshes::default();
        for planned in plan.jobs {
            let line = planned.line.clone();
            let collected = self.collected(planned, &mut meshes)?;
            if collected.state != State::Done {
                left.push_str(&line);
                left.push('\n');
            }
            jobs.push(collected);
        }
        let undone = left.lines().count();
        let collection = Collection { done: jobs.len() - undone, left: undone, jobs };
        if let Some(path) = &self.output {
            write_bytes(&outputs, path, Kind::Csv, collection.table().as_bytes())?;
        }
        if let Some(path) = &self.left {
            write_bytes(&outputs, path, Kind::Text, left.as_bytes())?;
        }
        if self.json {
            print_json(&collection);
        } else {
            collection.print();
        }
        if undone == 0 {
            return Ok(());
        }
        let error = format!("{undone} of {} jobs are left", collection.jobs.len());
        let remedy = "run their lines again (`--left FILE` writes them): what is finished of a build is kept";
        Err(Failure::new(Cause::File, error).remedy(remedy))
    }

    /// The plan of the folder.
    fn plan(&self) -> Result<Plan, Failure> {
        let path = self.folder.join("plan.json");
        let failed = |reason: String| Failure::new(Cause::Input, format!("{}: {reason}", path.display()));
        let text = read_text(&path).map_err(|error| {
            failed(error.to_string()).remedy("`vademecum plan SWEEP -o FOLDER` makes the folder")
        })?;
        let plan: Plan = serde_json::from_str(&text)
            .map_err(|error| failed(format!("is no plan: {error}")).remedy(UNREAD))?;
        match plan.version {
            VERSION => Ok(plan),
            other => Err(failed(format!("has version {other}; this program reads {VERSION}"))),
        }
    }

    fn collected(&self, planned: PlannedJob, meshes: &mut Meshes) -> Result<CollectedJob, Failure> {
        let PlannedJob { name, problem, values, .. } = planned;
        // The name of a plan that was edited may be a path to anywhere.
        if !name.bytes().all(|byte| byte.is_ascii_digit()) {
            return Err(Failure::new(
                Cause::Input,
                format!("the plan has a job `{name}`; names are numbers"),
            ));
        }
        let path = self.folder.join(format!("{name}.toml"));
        let text = read_text(&path).map_err(|error| {
            Failure::new(Cause::Input, format!("{}: {error}", path.display())).remedy(UNREAD)
        })?;
        let found = found(&self.folder.join(format!("{name}.vdm")))?;
        let (state, reason, outcome) = look(found.as_deref(), &text, &path, meshes);
        Ok(CollectedJob { name, problem, values, state, reason, outcome })
    }
}

/// The bytes of a file; nothing where there is none.
fn found(path: &Path) -> Result<Option<Vec<u8>>, Failure> {
    match read_regular(path) {
        Ok(bytes) => Ok(Some(bytes)),
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(None),
        Err(error) => {
            Err(Failure::new(Cause::Machine, format!("{}: {error}", path.display())).remedy(UNREAD))
        }
    }
}

impl Collection {
    /// The keys that change from job to job.
    fn keys(&self) -> Vec<&String> {
        self.jobs.first().map(|job| job.values.keys().collect()).unwrap_or_default()
    }

    fn table(&self) -> String {
        let keys = self.keys();
        let mut names = vec!["job", "state", "problem"];
        names.extend(keys.iter().map(|key| key.as_str()));
        names.extend([
            "first_frequency_hz",
            "trajectory_error",
            "projection_floor",
            "modes",
            "time_step",
            "file_bytes",
        ]);
        let mut rows = vec![names.into_iter().map(cell).collect::<Vec<_>>().join(",")];
        for job in &self.jobs {
            let mut cells = vec![cell(&job.name), cell(job.state.name()), cell(&job.problem)];
            cells.extend(keys.iter().map(|key| cell(&value_of(job, key))));
            let figures = job.outcome.map_or([const { String::new() }; 6], |o| {
                let first = o.first_frequency_hz.map_or(String::new(), |hz| format!("{hz:e}"));
                [
                    first,
                    format!("{:e}", o.trajectory_error),
                    format!("{:e}", o.projection_floor),
                    o.modes.to_string(),
                    format!("{:e}", o.time_step),
                    o.file_bytes.to_string(),
                ]
            });
            cells.extend(figures);
            rows.push(cells.join(","));
        }
        rows.join("\n") + "\n"
    }

    fn print(&self) {
        let width = self.jobs.iter().map(|job| job.name.len()).max().unwrap_or(0).max(3);
        println!("{:<width$}  state    first mode [Hz]  error     floor     file      values", "job");
        for job in &self.jobs {
            let values: Vec<_> =
                self.keys().iter().map(|key| format!("{key} = {}", value_of(job, key))).collect();
            let values = if values.is_empty() { job.problem.clone() } else { values.join(", ") };
            let figures = match &job.outcome {
                Some(o) => format!(
                    "{:>15.6}  {:.2e}  {:.2e}  {:>8}",
                    o.first_frequency_hz.unwrap_or(f64::NAN),
                    o.trajectory_error,
                    o.projection_floor,
                    bytes(o.file_bytes)
                ),
                None => format!("{:>45}", ""),
            };
            println!("{:<width$}  {:<7}  {figures}  {values}", job.name, job.state.name());
            if !job.reason.is_empty() {
                println!("{:<width$}  {}", "", job.reason);
            }
        }
        println!("\n{} of {} jobs are done", self.done, self.jobs.len());
    }
}

fn value_of(job: &CollectedJob, key: &str) -> String {
    match job.values.get(key) {
        Some(toml::Value::String(text)) => text.clone(),
        Some(value) => value.to_string(),
        None => String::new(),
    }
}

/// A cell of a table, between quotes where it holds what would end it.
fn cell(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text.into()
    }
}
