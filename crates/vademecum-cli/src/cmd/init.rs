//! `vademecum init`: from a mesh to a problem file, and on to the moving body.

use std::path::{Path, PathBuf};

use vademecum_build::store::Kind;
use vademecum_build::suggest::did_you_mean;
use vademecum_study::starter::{MATERIALS, NamedMaterial, StarterError, StarterOptions, starter};

use crate::arguments::{OutputArguments, positive};
use crate::console::Console;
use crate::failure::Failure;
use crate::files::{check_output, outputs, write_bytes};
use crate::print::print_json;
use crate::words::{duration, hertz, quantity};

/// Writes a problem file for a mesh: unit, support, material, time step and modes are proposed and explained.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  vademecum init liver.vtu --material liver -o liver.toml
  vademecum init fork.msh --view                    build it and push it in the browser
  vademecum init part.inp --scale 0.001             the mesh is in millimetres
Materials: steel, stainless, aluminium, titanium, brass, concrete, glass, wood, pla, abs, nylon, rubber,
silicone, foam, bone, liver. Keys of the problem file: `vademecum help problem`")]
pub(crate) struct Init {
    /// The mesh file.
    mesh: PathBuf,
    /// The problem file to write [default: the mesh's name with `.toml`].
    #[arg(short, long)]
    output: Option<PathBuf>,
    /// Material of the body.
    #[arg(long, default_value = "steel", value_parser = named)]
    material: NamedMaterial,
    /// Metres in a unit of the mesh [default: 0.001 for a body of more than 20 units, else 1].
    #[arg(long, value_parser = positive, allow_negative_numbers = true)]
    scale: Option<f64>,
    /// Build the body and open it in the browser.
    #[arg(long)]
    view: bool,
    /// Print what was proposed as JSON.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    outputs: OutputArguments,
}

/// A material by its name.
fn named(name: &str) -> Result<NamedMaterial, String> {
    let known = || MATERIALS.map(|material| material.name).join(", ");
    let found = MATERIALS.into_iter().find(|material| material.name == name);
    let nearest = || did_you_mean(name, MATERIALS.iter().map(|material| material.name));
    found.ok_or_else(|| format!("unknown material `{name}`; known: {}{}", known(), nearest()))
}

impl Init {
    /// The command lines that follow.
    pub(crate) fn run(&self, console: &Console) -> Result<Vec<Vec<PathBuf>>, Failure> {
        let problem = self.output.clone().unwrap_or_else(|| self.mesh.with_extension("toml"));
        let outputs = outputs(&self.outputs, &[Some(&self.mesh)], None);
        check_output(&outputs, &problem, Kind::Own)?;
        let mesh_name = seen_from(&self.mesh, &problem).display().to_string();
        let options = StarterOptions { material: self.material, scale: self.scale, mesh_name };
        let proposed = starter(&self.mesh, &options, console)?;
        console.clear();
        write_bytes(&outputs, &problem, Kind::Own, proposed.text.as_bytes())?;
        if self.json {
            print_json(&proposed);
        } else {
            println!(
                "body: {} free dofs, longest side {}",
                proposed.dofs,
                quantity(proposed.longest_side, "m")
            );
            println!("support: {}", proposed.support);
            println!(
                "first natural frequency {}; time step {}, {} modes",
                hertz(proposed.frequency),
                duration(proposed.time_step),
                proposed.modes
            );
            println!("wrote {}", problem.display());
        }
        let file = problem.with_extension("vdm");
        if !self.view {
            if !self.json {
                println!("next: vademecum build {} -o {}", problem.display(), file.display());
            }
            return Ok(vec![]);
        }
        let build = vec!["vademecum".into(), "build".into(), problem, "-o".into(), file.clone()];
        Ok(vec![build, vec!["vademecum".into(), "view".into(), file]])
    }
}

/// A path as a file at `from` names it: relative where both lie in one folder, whole otherwise.
fn seen_from(path: &Path, from: &Path) -> PathBuf {
    let folder = |path: &Path| {
        let parent = path.parent().filter(|parent| !parent.as_os_str().is_empty());
        std::fs::canonicalize(parent.unwrap_or(Path::new(".")))
    };
    match (folder(path), folder(from), path.file_name()) {
        (Ok(a), Ok(b), Some(name)) if a == b => name.into(),
        (Ok(a), _, Some(name)) => a.join(name),
        _ => path.to_path_buf(),
    }
}

impl From<StarterError> for Failure {
    fn from(error: StarterError) -> Self {
        match error {
            StarterError::Mesh(error) => error.into(),
            StarterError::Draft(error) => error.into(),
            StarterError::Study(error) => error.into(),
        }
    }
}
