//! `vademecum export`: what other programs need to compute the same.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use serde::Serialize;
use vademecum_build::Matrix;
use vademecum_build::dynamics::Interval;
use vademecum_build::dynamics::TimedLoad;
use vademecum_build::field::{self, write_matrix_market, write_npy};
use vademecum_build::input::BasisKind;
use vademecum_build::prepared::Body;
use vademecum_build::progress::Listener;
use vademecum_format::File;
use vademecum_study::bench::Study;
use vademecum_study::scenario::Scenario;

use super::bench::{problem_or_demo, scenario_or_push};
use super::verify::{file_nodes, full_order_loads};
use super::{make_folder, write_text};
use crate::console::Console;
use crate::failure::{Cause, Failure};
use crate::player::Track;

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

/// Writes mass and stiffness of a problem, the loads of a scenario, a reduced basis, and what the march needs to know.
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

/// What the march needs to know: `model.json`.
#[derive(Serialize)]
struct Model<'a> {
    version: u32,
    title: &'a str,
    units: &'a str,
    dofs: usize,
    scheme: vademecum_build::dynamics::SchemeKind,
    time_step: f64,
    steps: usize,
    alpha: f64,
    beta: f64,
    basis: BasisKind,
    modes: usize,
    loads: Vec<When>,
}

/// When a column of `loads.npy` acts.
#[derive(Serialize)]
struct When {
    start: f64,
    /// Absent: to the end.
    end: Option<f64>,
    ramp: f64,
}

impl From<Interval> for When {
    fn from(when: Interval) -> Self {
        Self { start: when.start, end: (when.end < f64::MAX).then_some(when.end), ramp: when.ramp }
    }
}

impl Matrices {
    fn run(&self, console: &Console) -> Result<(), Failure> {
        make_folder(&self.output)?;
        let problem = problem_or_demo(self.problem.as_deref())?;
        let study = Study::new(&problem, usize::from(self.modes), console)?;
        let scenario = scenario_or_push(self.scenario.as_deref(), self.problem.as_deref(), &study)?;
        console.stage("basis");
        let basis = study.basis(self.basis, usize::from(self.modes))?.value;
        let loads = loads(&study, &scenario)?;
        let all = scenario.steps(study.time_step());
        let prepared = study.prepared();
        let model = Model {
            version: 1,
            title: &problem.title,
            units: &problem.units,
            dofs: prepared.body.n_dof(),
            scheme: problem.time.scheme,
            time_step: study.time_step(),
            steps: self.steps.unwrap_or(all).clamp(1, all),
            alpha: prepared.rayleigh().alpha,
            beta: prepared.rayleigh().beta,
            basis: self.basis,
            modes: basis.n_modes(),
            loads: loads.iter().map(|load| load.when.into()).collect(),
        };
        console.stage("write");
        let at = |name: &str| self.output.join(name);
        let failed = |error: field::FieldError| Failure::new(Cause::Machine, error);
        let pencil = prepared.body.model.pencil();
        write_matrix_market(&at("mass.mtx"), pencil.mass()).map_err(failed)?;
        write_matrix_market(&at("stiffness.mtx"), pencil.stiffness()).map_err(failed)?;
        write_npy(&at("basis.npy"), &columns_of(&basis.vectors)).map_err(failed)?;
        let forces = loads.iter().flat_map(|load| load.force.iter().copied()).collect();
        let forces = field::Matrix { rows: model.dofs, columns: loads.len(), data: forces };
        write_npy(&at("loads.npy"), &forces).map_err(failed)?;
        write_text(&at("dofs.csv"), &dofs(&prepared.body))?;
        write_text(&at("nodes.csv"), &nodes(&prepared.body))?;
        if !prepared.body.surface.is_empty() {
            write_text(&at("triangles.csv"), &triangles(&prepared.body))?;
        }
        let json = serde_json::to_string_pretty(&model).expect("a model has string keys and finite nesting");
        write_text(&at("model.json"), &json)?;
        console.clear();
        println!(
            "{}: {} dofs, {} modes, {} loads",
            self.output.display(),
            model.dofs,
            model.modes,
            loads.len()
        );
        Ok(())
    }
}

/// The scenario as forces over the free dofs. Contacts find their triangle through a file, as they do when it is stepped.
fn loads(study: &Study, scenario: &Scenario) -> Result<Vec<TimedLoad>, Failure> {
    let name = Path::new("the export's file");
    let basis = study.basis(BasisKind::Modes, 1)?.value;
    let bytes = study.file(&basis, None)?.value;
    let file = File::parse(&bytes).map_err(|error| Failure::file(name, error))?;
    let track = Track::bind(name, &file, scenario)?;
    let body = &study.prepared().body;
    full_order_loads(&track, body, &file_nodes(name, &file, body)?, name, &file)
}

fn columns_of(matrix: &Matrix) -> field::Matrix {
    let data = (0..matrix.ncols()).flat_map(|j| matrix.col_as_slice(j).iter().copied()).collect();
    field::Matrix { rows: matrix.nrows(), columns: matrix.ncols(), data }
}

/// Node, component and place of each free dof.
fn dofs(body: &Body) -> String {
    let mesh = body.model.mesh();
    let mut text = String::from("row,node,component,x,y,z\n");
    for (row, &dof) in body.model.dofs().dof_of_free().iter().enumerate() {
        let (node, component) = (dof as usize / 3, ["x", "y", "z"][dof as usize % 3]);
        let [x, y, z] = mesh.nodes[node];
        let id = node_id(body, node);
        writeln!(text, "{row},{id},{component},{x:e},{y:e},{z:e}").expect("writing to a string cannot fail");
    }
    text
}

/// All nodes in the order of the mesh, those without a free dof among them.
fn nodes(body: &Body) -> String {
    let mut text = String::from("node,x,y,z\n");
    for (node, [x, y, z]) in body.model.mesh().nodes.iter().enumerate() {
        let id = node_id(body, node);
        writeln!(text, "{id},{x:e},{y:e},{z:e}").expect("writing to a string cannot fail");
    }
    text
}

/// Triangles of the whole surface by node number, outward.
fn triangles(body: &Body) -> String {
    let mut text = String::from("a,b,c\n");
    for triangle in &body.surface {
        let [a, b, c] = triangle.map(|node| node_id(body, node as usize));
        writeln!(text, "{a},{b},{c}").expect("writing to a string cannot fail");
    }
    text
}

/// The number a node has in the mesh file.
fn node_id(body: &Body, node: usize) -> u64 {
    body.model.mesh().node_ids.get(node).copied().unwrap_or(node as u64)
}
