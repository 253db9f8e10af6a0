//! `vademecum build`: from a problem to a file.

use std::path::PathBuf;
use std::sync::Arc;

use vademecum_build::fem::Engine;
use vademecum_build::input::Problem;
use vademecum_build::pipeline::{BuildOptions, Built};
use vademecum_build::prepared::FactorPrecision;
use vademecum_build::progress::Listener;
use vademecum_build::store::{Kind, OutputError, Outputs, Store, goes_through, is_same_place, read_regular};
use vademecum_chapter::build;
use vademecum_format::File;
use vademecum_study::FileError;
use vademecum_study::sweep::{Meshes, State, look};

use crate::arguments::{OutputArguments, size};
use crate::console::Console;
use crate::failure::{Cause, Failure};
use crate::files::{check_output, outputs, write_bytes};
use crate::print::{print_json, print_report, print_summary};

/// Computes a vademecum from a problem file.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  vademecum build beam.toml -o beam.vdm
  vademecum build beam.toml -o beam.vdm --json > beam.json
  vademecum build beam.toml -o beam.vdm --work beam.work   then change beam.toml: only what depends is rebuilt
A build that was stopped goes on where it was when it is started again: finished stages lie in OUTPUT.work
until the file is written.
  vademecum build regions.toml -o regions.vdm --repair
  mpirun -n 8 vademecum build large.toml -o large.vdm --engine petsc   on several processes or machines
Keys of the problem file: `vademecum help problem`")]
pub(crate) struct Build {
    /// The problem file (TOML).
    problem: PathBuf,
    /// The file to write; an older vademecum file is replaced in one step.
    #[arg(short, long, default_value = "body.vdm")]
    output: PathBuf,
    /// Print the report as JSON.
    #[arg(long)]
    json: bool,
    /// Print modes, certificate and stages, too.
    #[arg(long)]
    verbose: bool,
    /// Write the file even if no structure keeps the tolerance; its certificate says so.
    #[arg(long)]
    keep_missed: bool,
    /// Folder for finished stages, kept after the build too [default: OUTPUT.work, removed once the file is
    /// written].
    #[arg(long, value_name = "DIR")]
    work: Option<PathBuf>,
    /// Recompute every stage, even if its result is kept.
    #[arg(long)]
    fresh: bool,
    /// Do nothing where the output is whole and was built from this very problem file and mesh: for jobs that
    /// may be run more than once.
    #[arg(long, conflicts_with_all = ["fresh", "json"])]
    once: bool,
    /// Add terms until an unstable step over live parameters is stable; report and file list the repairs.
    #[arg(long)]
    repair: bool,
    /// Allow builds estimated at more than four hours or 2e7 full-order steps.
    #[arg(long)]
    long: bool,
    /// Memory the build may use on a machine, such as 8G or 500M [default: what the machine, control groups
    /// and `ulimit -v` leave].
    #[arg(long, value_name = "SIZE", value_parser = size)]
    memory: Option<u64>,
    /// Engine that factorises the stiffness and computes the modes: this process, or PETSc on all ranks that
    /// `mpirun` starts (in a program that was built with it).
    #[arg(long, value_enum, default_value_t, value_name = "ENGINE")]
    engine: EngineName,
    /// Folder for factors that are kept on disk, with `--engine petsc`; what a killed job leaves there can be
    /// deleted.
    #[arg(long, value_name = "DIR")]
    out_of_core: Option<PathBuf>,
    /// Linear solver [default: direct; single where a factor in double precision would not fit].
    #[arg(long, value_enum, value_name = "SOLVER", conflicts_with = "out_of_core")]
    solver: Option<SolverName>,
    #[command(flatten)]
    outputs: OutputArguments,
}

/// The engines.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
enum EngineName {
    /// This process.
    #[default]
    Local,
    /// All ranks, by MPI, PETSc and MUMPS.
    Petsc,
}

/// The solvers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum SolverName {
    /// A factor in double precision.
    Direct,
    /// Conjugate gradients with a factor in single precision, with `--engine local`: half the memory of a
    /// factor, and longer.
    Single,
    /// Conjugate gradients with algebraic multigrid (GAMG), with `--engine petsc`: little memory, and much
    /// longer.
    Iterative,
}

impl Build {
    pub(crate) fn run(&self, console: &Console) -> Result<(), Failure> {
        match self.engine {
            EngineName::Local if self.out_of_core.is_some() => {
                Err(Failure::new(Cause::Usage, "`--out-of-core` is for `--engine petsc`"))
            }
            EngineName::Local if self.solver == Some(SolverName::Iterative) => {
                Err(Failure::new(Cause::Usage, "`--solver iterative` is for `--engine petsc`"))
            }
            EngineName::Petsc if self.solver == Some(SolverName::Single) => {
                Err(Failure::new(Cause::Usage, "`--solver single` is for `--engine local`"))
            }
            EngineName::Local => self.run_on(None, console),
            EngineName::Petsc => self.run_on_ranks(console),
        }
    }

    /// On all ranks; those that are not the first say and write nothing.
    #[cfg(feature = "petsc")]
    fn run_on_ranks(&self, console: &Console) -> Result<(), Failure> {
        let iterative = self.solver == Some(SolverName::Iterative);
        let (out_of_core, memory) = (self.out_of_core.clone(), self.memory);
        let options = vademecum_petsc::Options { out_of_core, iterative, memory };
        // Where the ranks do not end together, this one tells why and ends them all.
        let tell = |done: &Result<(), Failure>| {
            console.clear();
            done.as_ref().map_or_else(Failure::tell, |()| 0)
        };
        let done = vademecum_petsc::run(&options, |engine| self.run_on(Some(engine), console), tell);
        done.map_err(|error| Failure::new(Cause::Machine, error))?.unwrap_or(Ok(()))
    }

    #[cfg(not(feature = "petsc"))]
    fn run_on_ranks(&self, _: &Console) -> Result<(), Failure> {
        let error = "this program was built without PETSc: `--engine petsc` is not in it";
        let remedy = "`cargo install --locked --path crates/vademecum-cli --features petsc`, with PETSc and MPI installed";
        Err(Failure::new(Cause::Usage, error).remedy(remedy))
    }

    /// The build with an engine, or in this process alone.
    fn run_on(&self, engine: Option<&Arc<dyn Engine>>, console: &Console) -> Result<(), Failure> {
        let problem = Problem::read(&self.problem)?;
        let outputs = outputs(&self.outputs, &[Some(&self.problem)], Some(&problem));
        check_output(&outputs, &self.output, Kind::Vademecum)?;
        if self.once && self.is_built(&problem) {
            console.note(&format!("{} is built already", self.output.display()));
            return Ok(());
        }
        let store = self.work_folder()?.map(|folder| Store::new(&folder, self.fresh));
        let built = self.build(&problem, store.as_ref(), &outputs, engine, console).inspect_err(|_| {
            if let Some(store) = store.as_ref().filter(|store| store.holds_stages()) {
                let kept = store.folder().display();
                console
                    .note(&format!("finished stages are kept in {kept}: the next build goes on from there"));
            }
        })?;
        if self.work.is_none()
            && let Some(store) = &store
            && let Err(error) = store.remove()
        {
            console.note(&format!("{} cannot be removed: {error}", store.folder().display()));
        }
        console.clear();
        if self.json {
            print_json(&built.report);
        } else {
            if self.verbose {
                print_report(&built.report);
            }
            let unread = |error: FileError| Failure::file(&self.output, error);
            let file = File::parse(&built.bytes).map_err(FileError::from).map_err(unread)?;
            print_summary(&built.report, &file, &self.output).map_err(unread)?;
            println!("next: vademecum view {}", self.output.display());
        }
        Ok(())
    }
}

impl Build {
    fn build(
        &self,
        problem: &Problem,
        store: Option<&Store>,
        outputs: &Outputs,
        engine: Option<&Arc<dyn Engine>>,
        console: &Console,
    ) -> Result<Built, Failure> {
        let (long, memory) = (self.long, self.memory);
        let precision = match self.solver {
            None | Some(SolverName::Iterative) => FactorPrecision::Fitting,
            Some(SolverName::Direct) => FactorPrecision::Double,
            Some(SolverName::Single) => FactorPrecision::Single,
        };
        let options = BuildOptions { repair: self.repair, store, long, memory, engine, precision };
        let outcome = build(problem, &options, console)?;
        let built = if self.keep_missed { outcome.either() } else { outcome.kept()? };
        built.report.certificate.measured().map_err(|error| Failure::new(Cause::Numerics, error))?;
        if console.cancelled() {
            return Err(Failure::new(Cause::Stopped, "stopped on request; nothing was written"));
        }
        write_bytes(outputs, &self.output, Kind::Vademecum, &built.bytes)?;
        Ok(built)
    }

    /// True if the output is complete and holds the text of the problem and the hash of its mesh.
    fn is_built(&self, problem: &Problem) -> bool {
        let bytes = read_regular(&self.output).ok();
        look(bytes.as_deref(), &problem.text, &self.problem, &mut Meshes::default()).0 == State::Done
    }

    /// Beside the file, under its name: found again without being told, by the build it belongs to alone.
    /// None beside a pipe or a device.
    fn work_folder(&self) -> Result<Option<PathBuf>, Failure> {
        let Some(work) = &self.work else {
            let mut name = self.output.clone().into_os_string();
            name.push(".work");
            return Ok((!goes_through(&self.output)).then_some(name.into()));
        };
        if is_same_place(work, &self.output) {
            return Err(OutputError::Twice { file: self.output.clone(), other: work.clone() }.into());
        }
        match std::fs::metadata(work) {
            Ok(found) if !found.is_dir() => Err(OutputError::NotAFolder { folder: work.clone() }.into()),
            _ => Ok(Some(work.clone())),
        }
    }
}
