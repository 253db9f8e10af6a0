//! `vademecum verify`: the same scenario full order and through the file.

use std::path::{Path, PathBuf};

use vademecum_build::input::Problem;
use vademecum_build::prepared::prepare;
use vademecum_build::progress::Stopwatch;
use vademecum_rewrite::check;
use vademecum_study::scenario::Scenario;
use vademecum_study::verify::{announce, verify};

use crate::arguments::StructureArgument;
use crate::console::Console;
use crate::failure::Failure;
use crate::files::{open, read_file, whole_file};
use crate::print::{print_json, print_verification};

/// Marches a scenario full order and through the file, and prints how far apart they are; or checks the file
/// alone.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  vademecum verify body.vdm --problem body.toml --scenario push.toml --json
  vademecum verify body.vdm --file-only")]
pub struct Verify {
    /// The vademecum file.
    file: PathBuf,
    /// The problem it was built from.
    #[arg(long, required_unless_present = "file_only")]
    problem: Option<PathBuf>,
    /// The scenario file (TOML).
    #[arg(long, required_unless_present = "file_only")]
    scenario: Option<PathBuf>,
    /// Check the file alone: checksums, finite numbers, names and indices.
    #[arg(long, conflicts_with_all = ["problem", "scenario", "structure"])]
    file_only: bool,
    /// Structure of the step.
    #[arg(long, value_enum, default_value_t = StructureArgument::Auto)]
    structure: StructureArgument,
    /// March at full order for more than four hours or 2e7 steps, too.
    #[arg(long)]
    long: bool,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

impl Verify {
    pub fn run(&self, console: &Console) -> Result<(), Failure> {
        match (&self.problem, &self.scenario) {
            (Some(problem), Some(scenario)) => self.march(problem, scenario, console),
            _ => self.check_file(),
        }
    }

    /// `--file-only`.
    fn check_file(&self) -> Result<(), Failure> {
        let checked = check(&read_file(&self.file)?).map_err(|error| Failure::file(&self.file, error))?;
        if self.json {
            print_json(&checked);
            return Ok(());
        }
        println!(
            "{}: sound; {} bytes, {} sections, {} numbers, all finite",
            self.file.display(),
            checked.bytes,
            checked.sections,
            checked.numbers
        );
        if checked.unknown_sections > 0 {
            println!(
                "{} section(s) of a kind this program does not know were skipped",
                checked.unknown_sections
            );
        }
        Ok(())
    }

    fn march(&self, problem: &Path, scenario: &Path, console: &Console) -> Result<(), Failure> {
        let problem = Problem::read(problem)?;
        let scenario = Scenario::read(scenario)?;
        let mapped = open(&self.file, false)?;
        let mut memory = vec![];
        let file = whole_file(&self.file, &mapped, &mut memory)?;
        let mut watch = Stopwatch::new(console);
        let prepared = prepare(&problem, &mut watch, console)?;
        announce(&file, &prepared, &scenario, self.long, console)?;
        let verified = verify(&file, &self.structure.options(), &problem, &prepared, &scenario, console)
            .map_err(|error| Failure::from(error).about(&self.file))?;
        console.clear();
        if self.json {
            print_json(&verified.figures);
        } else {
            print_verification(&verified.figures);
        }
        Ok(())
    }
}
