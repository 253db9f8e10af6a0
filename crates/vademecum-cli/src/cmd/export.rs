//! `vademecum export`: what other programs need to compute the same.

mod craig_bampton;
mod fmu;
mod state_space;
mod uff;

use std::fmt::Write as _;
use std::path::PathBuf;

use vademecum_build::field::{matrix_market_into, npy_into};
use vademecum_build::input::BasisKind;
use vademecum_build::progress::Listener;
use vademecum_build::store::Kind;
use vademecum_study::export::{ExportedModel, FreeDof};

use crate::arguments::{OutputArguments, problem_or_demo, scenario_or_demo};
use crate::console::Console;
use crate::failure::Failure;
use crate::files::{outputs, write_bytes};
use crate::print::{json, print_json};
use craig_bampton::CraigBampton;
use fmu::Fmu;
use state_space::StateSpaceArguments;
use uff::Uff;

/// Exports a model for other programs.
#[derive(clap::Args)]
pub(crate) struct Export {
    #[command(subcommand)]
    what: ExportCommand,
}

#[derive(clap::Subcommand)]
enum ExportCommand {
    Matrices(Matrices),
    CraigBampton(CraigBampton),
    Fmu(Fmu),
    StateSpace(StateSpaceArguments),
    Uff(Uff),
}

/// Writes mass and stiffness of a problem, the loads of a scenario, a reduced basis, and the data of its time
/// integration.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  vademecum export matrices -o matrices                         the demo's beam and scenario
  vademecum export matrices body.toml --scenario push.toml --basis ritz --modes 16 -o matrices
What the files hold: formats/matrices-1.md. They are read by docs/measurements/peers")]
struct Matrices {
    /// The problem file (TOML); the demo's beam if absent.
    problem: Option<PathBuf>,
    /// The scenario file (TOML); an oblique push on the middle loadable triangle if absent.
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
    /// Print JSON.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    outputs: OutputArguments,
}

/// Report of the export.
#[derive(serde::Serialize)]
struct MatricesOutput {
    folder: String,
    dofs: usize,
    modes: usize,
    loads: usize,
}

/// Files written.
const FILES: [(&str, Kind); 8] = [
    ("mass.mtx", Kind::Market),
    ("stiffness.mtx", Kind::Market),
    ("basis.npy", Kind::Npy),
    ("loads.npy", Kind::Npy),
    ("dofs.csv", Kind::Csv),
    ("nodes.csv", Kind::Csv),
    ("triangles.csv", Kind::Csv),
    ("model.json", Kind::Json),
];

fn kind(text: &str) -> Result<BasisKind, String> {
    match text {
        "pod" => Ok(BasisKind::Pod),
        "ritz" => Ok(BasisKind::Ritz),
        "modes" => Ok(BasisKind::Modes),
        other => Err(format!("`{other}` is not one of pod, ritz, modes")),
    }
}

impl Export {
    pub(crate) fn run(&self, console: &Console) -> Result<(), Failure> {
        match &self.what {
            ExportCommand::Matrices(matrices) => matrices.run(console),
            ExportCommand::CraigBampton(body) => body.run(console),
            ExportCommand::Fmu(fmu) => fmu.run(console),
            ExportCommand::StateSpace(model) => model.run(console),
            ExportCommand::Uff(uff) => uff.run(console),
        }
    }
}

impl Matrices {
    fn run(&self, console: &Console) -> Result<(), Failure> {
        let problem = problem_or_demo(self.problem.as_deref())?;
        let scenario = scenario_or_demo(self.scenario.as_deref(), self.problem.as_deref())?;
        let inputs = [self.problem.as_deref(), self.scenario.as_deref()];
        let outputs = outputs(&self.outputs, &inputs, Some(&problem));
        outputs.check_in(&self.output, &FILES)?;
        outputs.make_folder(&self.output)?;
        let modes = usize::from(self.modes);
        let export = ExportedModel::new(&problem, scenario.as_ref(), self.basis, modes, self.steps, console)?;
        console.stage("write");
        let at = |name: &str| self.output.join(name);
        outputs.write(&at("mass.mtx"), Kind::Market, |out| matrix_market_into(out, export.mass()))?;
        outputs
            .write(&at("stiffness.mtx"), Kind::Market, |out| matrix_market_into(out, export.stiffness()))?;
        outputs.write(&at("basis.npy"), Kind::Npy, |out| npy_into(out, &export.basis))?;
        outputs.write(&at("loads.npy"), Kind::Npy, |out| npy_into(out, &export.loads))?;
        let text = |name: &str, kind, text: &str| write_bytes(&outputs, &at(name), kind, text.as_bytes());
        text("dofs.csv", Kind::Csv, &dofs(export.free_dofs()))?;
        text("nodes.csv", Kind::Csv, &nodes(export.nodes()))?;
        let triangles = triangles(export.triangles());
        if !triangles.is_empty() {
            text("triangles.csv", Kind::Csv, &triangles)?;
        }
        text("model.json", Kind::Json, &json(&export.model))?;
        console.clear();
        let exported = MatricesOutput {
            folder: self.output.display().to_string(),
            dofs: export.model.dofs,
            modes: export.model.modes,
            loads: export.loads.columns,
        };
        if self.json {
            print_json(&exported);
        } else {
            let MatricesOutput { folder, dofs, modes, loads } = &exported;
            println!("{folder}: {dofs} dofs, {modes} modes, {loads} loads");
        }
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
