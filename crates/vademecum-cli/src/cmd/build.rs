//! `vademecum build`: from a problem to a file.

use std::path::PathBuf;

use vademecum_build::certificate::StructureReport;
use vademecum_build::chapter::ChapterReport;
use vademecum_build::input::Problem;
use vademecum_build::pipeline::{BuildOptions, Built, build};
use vademecum_build::progress::Listener;
use vademecum_build::report::BuildReport;
use vademecum_build::store::{Store, check_writable, write_atomic};

use super::print_json;
use crate::console::{Console, cancelled};
use crate::failure::{Cause, Failure};

/// Computes a vademecum from a problem file.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  vademecum build beam.toml -o beam.vdm
  vademecum build beam.toml -o beam.vdm --json > beam.json
  vademecum build beam.toml -o beam.vdm --work beam.work   change beam.toml, build again: only what depends on it
A build that was stopped goes on where it was when it is started again: finished stages lie in OUTPUT.work until the
file is written.
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
    /// Folder for finished stages, kept after the build too [default: OUTPUT.work, removed once the file is written].
    #[arg(long, value_name = "DIR")]
    work: Option<PathBuf>,
    /// Compute every stage anew, whatever is kept.
    #[arg(long)]
    fresh: bool,
    /// Where the step over live parameters is unstable, add terms until it is stable; report and file say what was done.
    #[arg(long)]
    repair: bool,
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
        let options = BuildOptions { repair: self.repair, store: Some(store) };
        let outcome = build(problem, &options, console)?;
        let built = if self.keep_missed { outcome.either() } else { outcome.kept()? };
        if cancelled() {
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

/// A length for people.
pub fn bytes(length: usize) -> String {
    match length {
        0..10_000 => format!("{length} bytes"),
        10_000..10_000_000 => format!("{:.1} kB", length as f64 / 1e3),
        _ => format!("{:.1} MB", length as f64 / 1e6),
    }
}

/// Prints a build's report.
pub fn print_report(report: &BuildReport) {
    println!(
        "{} nodes, {} elements, {} free dofs; {} snapshots; {} modes; {:.1} steps per first period",
        report.nodes,
        report.elements,
        report.dofs,
        report.snapshots,
        report.modes,
        report.steps_per_first_period
    );
    println!("\nmode  frequency [Hz]  energy     damping: material  scheme     period");
    for (k, row) in report.mode_table.iter().enumerate() {
        println!(
            "{:>4}  {:>14.6}  {:>9.2e}  {:>17.3e}  {:>9.2e}  {:>+9.2e}",
            k + 1,
            row.frequency_hz,
            row.energy,
            row.physical_damping,
            row.numerical_damping,
            row.period_elongation
        );
    }
    println!("\nstructure  trajectory error  floor      error/floor  spectral radius  energy ratio");
    let certificate = &report.certificate;
    for (name, structure) in [("diagonal", &certificate.diagonal), ("block", &certificate.block)] {
        if let Some(s) = structure {
            print_structure(name, s);
        }
    }
    if let Some(c) = &certificate.chapter {
        print_chapter(c);
    }
    if let Some(s) = &report.separation {
        println!(
            "\nseparated: {} terms on axes of {:?} points, from {} full-order solves ({} vectors); stopped by {}",
            s.terms, s.axis_points, s.samples, s.reduced_size, s.stop
        );
        let block = report.certificate.block.as_ref();
        if let Some(c) = block {
            println!(
                "map error over fresh points {:.2e} rms, {:.2e} worst",
                c.map_error_rms, c.map_error_max
            );
        }
        println!(
            "worst trajectory at {}; largest spectral radius at {}",
            s.place(&s.worst_trajectory_at),
            s.place(&s.worst_radius_at)
        );
        s.repairs.iter().for_each(|done| println!("repaired: {done}"));
    }
    println!("\nstage                     seconds  peak memory");
    for timing in &report.timings {
        let memory = timing.peak_memory_bytes.map_or("?".into(), |b| bytes(b as usize));
        println!("{:<24}  {:>7.2}  {:>11}", timing.stage, timing.seconds, memory);
    }
}

/// Prints the certificate of the chapter's structure.
pub fn print_chapter(c: &ChapterReport) {
    print_structure("chapter", &c.structure);
    if let Some(step) = c.left_at {
        println!("a trajectory left its axes at step {step}; the errors are of the steps before");
    }
    for (i, s) in c.stages.iter().enumerate() {
        println!(
            "stage {}: {} terms, map error {:.2e} (state {:.2e}, load {:.2e})",
            i + 1,
            s.terms,
            s.error,
            s.state_error,
            s.load_error
        );
    }
}

fn print_structure(name: &str, s: &StructureReport) {
    println!(
        "{name:<9}  {:>16.3e}  {:>9.3e}  {:>11.3}  1 {:>+13.1e}  {:>12.9}",
        s.trajectory_error,
        s.projection_floor,
        s.floor_ratio,
        s.spectral_radius - 1.0,
        s.energy_ratio
    );
}
