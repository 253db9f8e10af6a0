//! `vademecum export`: what other programs need to compute the same.

use std::fmt::Write as _;
use std::path::PathBuf;

use vademecum_build::field::{FieldError, write_matrix_market, write_npy};
use vademecum_build::input::BasisKind;
use vademecum_build::progress::Listener;
use vademecum_study::export::{ExportedModel, FreeDof};

use crate::arguments::{problem_or_demo, scenario_or_demo};
use crate::console::Console;
use crate::failure::{Cause, Failure};
use crate::files::{make_folder, write_text};
use crate::print::json;

/// Hands a model to other programs.
#[derive(clap::Args)]
pub struct Export {
    #[command(subcommand)]
    what: What,
}

#[derive(clap::Subcommand)]
enum What {
    Matrices(Matrices),
}

/// Writes mass and stiffness of a problem, the loads of a scenario, a reduced basis, and what the march needs
/// to know.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  vademecum export matrices -o matrices                         the demo's beam and scenario
  vademecum export matrices body.toml --scenario push.toml --basis ritz --modes 16 -o matrices
What the files hold: formats/matrices-1.md. They are read by docs/benchmarks/peers")]
struct Matrices {
    /// The problem file (TOML); the demo's beam if absent.
    problem: Option<PathBuf>,
    /// The scenario file (TOML); as `vademecum bench` if absent.
    #[arg(long)]
    scenario: Option<PathBuf>,
    /// Folder for the files; made if missing.
    #[arg(short, long)]
    output: PathBuf,
    /// Basis: `pod`, `ritz` or `modes`.
    #[arg(long, default_value = "pod", value_parser = kind)]
    basis: BasisKind,
    /// Number of modes.
    #[arg(long, default_value_t = 16)]
    modes: u16,
    /// Steps of the scenario [default: all].
    #[arg(long)]
    steps: Option<usize>,
}

fn kind(text: &str) -> Result<BasisKind, String> {
    match text {
        "pod" => Ok(BasisKind::Pod),
        "ritz" => Ok(BasisKind::Ritz),
        "modes" => Ok(BasisKind::Modes),
        other => Err(format!("`{other}` is not one of pod, ritz, modes")),
    }
}

impl Export {
    pub fn run(&self, console: &Console) -> Result<(), Failure> {
        let What::Matrices(matrices) = &self.what;
        matrices.run(console)
    }
}

impl Matrices {
    fn run(&self, console: &Console) -> Result<(), Failure> {
        make_folder(&self.output)?;
        let problem = problem_or_demo(self.problem.as_deref())?;
        let scenario = scenario_or_demo(self.scenario.as_deref(), self.problem.as_deref())?;
        let modes = usize::from(self.modes);
        let export = ExportedModel::new(&problem, scenario.as_ref(), self.basis, modes, self.steps, console)?;
        console.stage("write");
        let at = |name: &str| self.output.join(name);
        let failed = |error: FieldError| Failure::new(Cause::Machine, error);
        write_matrix_market(&at("mass.mtx"), export.mass()).map_err(failed)?;
        write_matrix_market(&at("stiffness.mtx"), export.stiffness()).map_err(failed)?;
        write_npy(&at("basis.npy"), &export.basis).map_err(failed)?;
        write_npy(&at("loads.npy"), &export.loads).map_err(failed)?;
        write_text(&at("dofs.csv"), &dofs(export.free_dofs()))?;
        write_text(&at("nodes.csv"), &nodes(export.nodes()))?;
        let triangles = triangles(export.triangles());
        if !triangles.is_empty() {
            write_text(&at("triangles.csv"), &triangles)?;
        }
        write_text(&at("model.json"), &json(&export.model))?;
        console.clear();
        println!(
            "{}: {} dofs, {} modes, {} loads",
            self.output.display(),
            export.model.dofs,
            export.model.modes,
            export.loads.columns
        );
        Ok(())
    }
}

/// Node, component and place of each free dof.
fn dofs(all: impl Iterator<Item = FreeDof>) -> String {
    let mut text = String::from("row,node,component,x,y,z\n");
    for (row, FreeDof { node, component, place: [x, y, z] }) in all.enumerate() {
        let component = ["x", "y", "z"][component];
        writeln!(text, "{row},{node},{component},{x:e},{y:e},{z:e}")
            .expect("writing to a string cannot fail");
    }
    text
}

fn nodes(all: impl Iterator<Item = (u64, [f64; 3])>) -> String {
    let line = |(id, [x, y, z]): (u64, [f64; 3])| format!("{id},{x:e},{y:e},{z:e}\n");
    std::iter::once("node,x,y,z\n".to_string()).chain(all.map(line)).collect()
}

/// Nothing where there are none.
fn triangles(all: impl Iterator<Item = [u64; 3]>) -> String {
    let lines: String = all.map(|[a, b, c]| format!("{a},{b},{c}\n")).collect();
    if lines.is_empty() { lines } else { format!("a,b,c\n{lines}") }
}
