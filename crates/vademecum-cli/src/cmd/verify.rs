//! `vademecum verify`: the same scenario full order and through the file.

use std::path::{Path, PathBuf};

use vademecum_build::input::Problem;
use vademecum_build::mesh_error::{DiscRequest, MeshEstimate, estimate};
use vademecum_build::prepared::prepare;
use vademecum_build::progress::Stopwatch;
use vademecum_study::StudyError;
use vademecum_study::live::prepared_at;
use vademecum_study::parameters::{self, ParameterValue};
use vademecum_study::scenario::Scenario;
use vademecum_study::soundness::check_file;
use vademecum_study::verify::{Figures, verify};

use crate::arguments::{Limit, StructureArgument, positive, setting};
use crate::console::Console;
use crate::failure::Failure;
use crate::files::{at_values, is_stepped, open, read_file, to_step, usable_file};
use crate::mesh_error;
use crate::print::{print_json, print_large_verification, print_verification};

/// Marches a scenario full order and through the file, and prints how far apart they are, and how far from a
/// motion that is exact in time; or checks the file alone. A file of large displacements is compared with a
/// march at large displacements.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  vademecum verify body.vdm --problem body.toml --scenario push.toml --json
  vademecum verify body.vdm --problem body.toml --scenario push.toml --set \"tip stiffness=1.5\"
  vademecum verify body.vdm --problem body.toml --scenario push.toml --mesh    and the error of the mesh
  vademecum verify body.vdm --file-only")]
pub(crate) struct Verify {
    /// The vademecum file.
    file: PathBuf,
    /// The problem it was built from.
    #[arg(long, required_unless_present = "file_only")]
    problem: Option<PathBuf>,
    /// The scenario file (TOML).
    #[arg(long, required_unless_present = "file_only")]
    scenario: Option<PathBuf>,
    /// Check the file alone: checksums, finite numbers, names, nodes and triangles, independent modes,
    /// symmetric matrices, sections that agree with each other, a step as stable as its certificate says.
    /// formats/vademecum-1.md lists the checks.
    #[arg(long, conflicts_with_all = ["problem", "scenario", "structure"])]
    file_only: bool,
    /// Structure of the step.
    #[arg(long, value_enum, default_value_t = StructureArgument::Auto)]
    structure: StructureArgument,
    /// Set a live parameter of the file, by its name, on both sides; may be given several times. `info` shows
    /// names, ranges and units.
    #[arg(long, value_name = "NAME=VALUE", value_parser = setting, conflicts_with = "file_only")]
    set: Vec<ParameterValue>,
    /// Modes that are stepped of a file with live regions [default: all].
    #[arg(long, value_name = "N", conflicts_with = "file_only")]
    modes: Option<usize>,
    /// Estimate the discretisation error of the mesh too: of the lowest six frequencies, and of the
    /// displacement under a traction on a disc.
    #[arg(long, conflicts_with = "file_only")]
    mesh: bool,
    /// Radius of that disc in m; three mean edges if absent. It lies at the loadable node of largest
    /// compliance.
    #[arg(long, value_name = "R", requires = "mesh", value_parser = positive, allow_negative_numbers = true)]
    disc: Option<f64>,
    /// March more than a million steps, or for more than four hours, too.
    #[arg(long, conflicts_with = "file_only")]
    long: bool,
    /// Print JSON.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    limit: Limit,
}

/// JSON output.
#[derive(serde::Serialize)]
struct VerifyOutput<'a> {
    #[serde(flatten)]
    figures: &'a Figures,
    /// Discretisation error; none without `--mesh`.
    mesh_error: Option<MeshEstimate>,
}

impl Verify {
    pub(crate) fn run(&self, console: &Console) -> Result<(), Failure> {
        match (&self.problem, &self.scenario) {
            (Some(problem), Some(scenario)) => self.march(problem, scenario, console),
            _ => self.check_file(),
        }
    }

    /// `--file-only`.
    fn check_file(&self) -> Result<(), Failure> {
        let bytes = read_file(&self.file)?;
        let sound = check_file(&bytes, self.limit.of(bytes.len()));
        let sound = sound.map_err(|error| Failure::from(error).about(&self.file))?;
        if self.json {
            print_json(&sound);
            return Ok(());
        }
        let checked = &sound.checked;
        println!(
            "{}: sound; {} bytes, {} sections, {} numbers, all finite",
            self.file.display(),
            checked.bytes,
            checked.sections,
            checked.numbers
        );
        match sound.spectral_radius {
            Some(radius) => {
                println!(
                    "spectral radius of its steps at most 1 {:+.1e}, at {} setting(s)",
                    radius - 1.0,
                    sound.settings
                )
            }
            None => println!("the spectral radius of its step was not looked for"),
        }
        if let Some(patch) = &sound.patch {
            println!(
                "the flexibility between contacts (h = {} m) is positive semidefinite: tried with {} of them, one at \
                 each loadable node, in {} group(s)",
                patch.distance, patch.contacts, patch.groups
            );
        }
        if sound.corners_left_out > 0 {
            println!("{} corner(s) of the parameters' box were left out", sound.corners_left_out);
        }
        if checked.unknown_sections > 0 {
            println!(
                "{} section(s) of a kind this program does not know were skipped",
                checked.unknown_sections
            );
        }
        Ok(())
    }

    fn march(&self, problem: &Path, scenario_file: &Path, console: &Console) -> Result<(), Failure> {
        let problem = Problem::read(problem)?;
        let scenario = Scenario::read(scenario_file)?;
        let mapped = open(&self.file)?;
        let mut memory = vec![];
        let file = usable_file(&self.file, &mapped, is_stepped, self.limit, &mut memory)?;
        let about = |error: StudyError| Failure::of_study(error, &self.file, scenario_file);
        let set_body = at_values(&file, &self.set, self.modes).map_err(about)?;
        let (file, settings) = to_step(file, &self.set, set_body.as_ref()).map_err(about)?;
        let mut options = self.structure.options();
        options.long = self.long;
        parameters::set(&mut options.scene, file.metadata(), settings).map_err(about)?;
        let mut watch = Stopwatch::new(console);
        let mut prepared = prepare(&problem, &mut watch, console)?;
        if let Some(body) = &set_body {
            prepared_at(&mut prepared, &body.values).map_err(about)?;
        }
        let verified = verify(&file, &options, &problem, &prepared, &scenario, console).map_err(about)?;
        let disc = self.mesh.then_some(DiscRequest::Radius(self.disc));
        let estimated = disc.map(|disc| estimate(&prepared, None, disc, console)).transpose();
        let mesh_error = estimated.map_err(|error| about(error.into()))?;
        console.clear();
        if self.json {
            print_json(&VerifyOutput { figures: &verified.figures, mesh_error });
            return Ok(());
        }
        let reduction = match &verified.figures {
            Figures::Linear(figures) => {
                print_verification(figures);
                figures.truth.total_error
            }
            Figures::Large(figures) => {
                print_large_verification(figures);
                figures.trajectory_error
            }
        };
        if let Some(estimate) = &mesh_error {
            mesh_error::lines(estimate).iter().for_each(|line| println!("{line}"));
            mesh_error::beside(reduction, estimate).iter().for_each(|line| println!("errors: {line}"));
        }
        Ok(())
    }
}
