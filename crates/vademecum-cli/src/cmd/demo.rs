//! `vademecum demo`: the whole road, once, from nothing but the program itself.

use std::path::{Path, PathBuf};

use serde::Serialize;
use vademecum_build::input::Problem;
use vademecum_build::pipeline::{BuildOptions, build};
use vademecum_build::prepared::prepare;
use vademecum_build::progress::{Listener, Silent, Stopwatch};
use vademecum_build::report::BuildReport;
use vademecum_build::store::write_atomic;
use vademecum_eval::Mapped;
use vademecum_study::scenario::Scenario;

use super::build::print_report;
use super::run::geometry;
use super::verify::{self, Verified, verify};
use super::{make_folder, write_text};
use crate::console::Console;
use crate::failure::{Cause, Failure};
use crate::pictures::{Chart, Outline, Series, line_chart, outline};
use crate::player::{LongRun, PlayOptions, Track, long_run};

/// The problem and scenario of the demo, inside the program.
pub const PROBLEM: &str = include_str!("../../../../fixtures/problems/cantilever.toml");
pub const SCENARIO: &str = include_str!("../../../../fixtures/scenarios/push.toml");
/// Steps of the long run.
const MANY: usize = 1_000_000;

/// Builds a cantilever, writes its file, steps it a million times and compares it with the full-order solution.
#[derive(clap::Args)]
#[command(after_help = "Example:
  vademecum demo -o demo")]
pub struct Demo {
    /// Folder for the file, the pictures and demo.json; made if missing.
    #[arg(short, long, default_value = "demo")]
    output: PathBuf,
}

#[derive(Serialize)]
struct DemoReport<'a> {
    #[serde(flatten)]
    verify: &'a verify::Report,
    long_run: &'a LongRun,
    build: &'a BuildReport,
}

impl Demo {
    pub fn run(&self, console: &Console) -> Result<(), Failure> {
        make_folder(&self.output)?;
        let problem = Problem::parse(PROBLEM, "the demo's problem", PathBuf::new())?;
        let scenario = Scenario::parse(SCENARIO, "the demo's scenario")?;
        write_text(&self.output.join("problem.toml"), PROBLEM)?;
        write_text(&self.output.join("scenario.toml"), SCENARIO)?;
        let path = self.output.join("demo.vdm");

        let built = build(&problem, &BuildOptions::default(), console)?.kept()?;
        write_atomic(&path, &built.bytes).map_err(|error| Failure::io(&path, error))?;
        let mapped = Mapped::open(&path).map_err(|error| Failure::file(&path, error))?;
        let file = mapped.file().map_err(|error| Failure::file(&path, error))?;
        let options = PlayOptions::default();
        let prepared = prepare(&problem, &mut Stopwatch::new(&Silent), &Silent)?;
        let verified = verify(&path, &file, &options, &problem, &prepared, &scenario, console)?;
        console.stage("a million steps");
        let track = Track::bind(&path, &file, &scenario)?;
        let long = long_run(&path, &file, &options, &track, MANY)?;
        console.clear();

        let (nodes, triangles) = geometry(&path, &file)?;
        let marks = marks(&prepared, &track);
        self.draw(&built.report, &verified, &nodes, &triangles, &marks)?;
        let report = DemoReport { verify: &verified.report, long_run: &long, build: &built.report };
        let json =
            serde_json::to_string_pretty(&report).expect("a report has string keys and finite nesting");
        write_text(&self.output.join("demo.json"), &json)?;
        self.print(&built.report, &verified, &long);
        Ok(())
    }

    fn draw(
        &self,
        report: &BuildReport,
        verified: &Verified,
        nodes: &[[f64; 3]],
        triangles: &[[u32; 3]],
        marks: &[(usize, [f64; 3])],
    ) -> Result<(), Failure> {
        let failed = |error: Box<dyn std::error::Error>| Failure::new(Cause::Machine, error.to_string());
        let title = "mesh (blue: held nodes, red: contacts)";
        outline(&self.output.join("mesh.svg"), &Outline { title, marks }, nodes, triangles)
            .map_err(failed)?;

        let values = report.singular_values.iter().enumerate();
        let first = report.singular_values.first().copied().unwrap_or(1.0);
        let singular =
            Series { name: "", points: values.map(|(i, s)| ((i + 1) as f64, s / first)).collect() };
        let chart =
            Chart { title: "singular values of the snapshots", x: "number", y: "σ / σ₁", log_y: true };
        line_chart(&self.output.join("singular-values.svg"), &chart, &[singular]).map_err(failed)?;

        let [full, file] = &verified.probe_series;
        let tip = Chart { title: "tip displacement", x: "time [s]", y: "displacement [m]", log_y: false };
        let probes = verified.probes.len();
        let lines =
            [over_time("full order", full, probes, verified), over_time("vademecum", file, probes, verified)];
        line_chart(&self.output.join("tip.svg"), &tip, &lines).map_err(failed)?;

        let [full, file] = &verified.energy_series;
        let energy = Chart { title: "energy", x: "time [s]", y: "energy [J]", log_y: false };
        let lines = [over_time("full order", full, 1, verified), over_time("vademecum", file, 1, verified)];
        line_chart(&self.output.join("energy.svg"), &energy, &lines).map_err(failed)
    }

    fn print(&self, report: &BuildReport, verified: &Verified, long: &LongRun) {
        print_report(report);
        println!();
        verified.report.print();
        println!(
            "a million steps        {:.3e} s each; energy left {:.3e}, never above {:.9} of that at release",
            long.seconds_per_step, long.energy_left, long.energy_ratio
        );
        let folder = Path::new(&self.output);
        println!("\nwrote to {}:", folder.display());
        println!("  demo.vdm, demo.json, problem.toml, scenario.toml");
        println!("  mesh.svg, singular-values.svg, tip.svg, energy.svg");
    }
}

/// The first of `width` interleaved series over time.
fn over_time<'a>(name: &'a str, values: &[f64], width: usize, verified: &Verified) -> Series<'a> {
    let points = values.iter().step_by(width.max(1)).enumerate();
    Series { name, points: points.map(|(i, &v)| (i as f64 * verified.time_step, v)).collect() }
}

/// Held nodes and contact points.
fn marks(prepared: &vademecum_build::prepared::Prepared, track: &Track) -> Vec<(usize, [f64; 3])> {
    let (mesh, dofs) = (prepared.body.model.mesh(), prepared.body.model.dofs());
    let held = |node: &usize| (0..3).all(|c| dofs.free(3 * node + c).is_none());
    let nodes = (0..mesh.nodes.len()).filter(held).map(|node| (0, mesh.nodes[node]));
    let contacts = track.contacts.iter().map(|(_, point, _)| (1, point.position));
    nodes.chain(contacts).collect()
}
