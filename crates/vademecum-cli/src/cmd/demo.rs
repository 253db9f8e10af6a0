//! `vademecum demo`: the whole road, once, from nothing but the program itself.

mod large;

use std::path::{Path, PathBuf};

use serde::Serialize;
use vademecum_build::input::Problem;
use vademecum_build::pipeline::{BuildOptions, build};
use vademecum_build::prepared::prepare;
use vademecum_build::progress::{Listener, Silent, Stopwatch};
use vademecum_build::report::BuildReport;
use vademecum_build::store::{Kind, Outputs};
use vademecum_format::FormatError;
use vademecum_study::contents::Geometry;
use vademecum_study::player::{LongRun, PlayOptions, Track, long_run};
use vademecum_study::verify::{Verification, VerificationRecord, verify_linear};
use vademecum_study::{FileError, StudyError};

use crate::arguments::{OutputArguments, PROBLEM, SCENARIO, demo_problem, demo_scenario};
use crate::console::Console;
use crate::failure::Failure;
use crate::files::{check_own, open, outputs, write_bytes, write_own, write_picture};
use crate::outline::{Outline, outline};
use crate::pictures::{Chart, ComparedLines, Series, compared_chart, line_chart};
use crate::print::{json, print_json, print_report, print_summary, print_verification};
use crate::words::{duration, percent};

/// Steps of the long run.
const MANY: usize = 1_000_000;

/// Builds a cantilever, writes its file, steps it a million times and compares it with the full-order
/// solution.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  vademecum demo -o demo
  vademecum demo --large -o bent")]
pub(crate) struct Demo {
    /// Folder for the file, the pictures and demo.json; made if missing.
    #[arg(short, long, default_value = "demo")]
    output: PathBuf,
    /// A soft beam that bends by more than a right angle instead: large displacements.
    #[arg(long)]
    large: bool,
    /// Print what `demo.json` holds.
    #[arg(long)]
    json: bool,
    /// Print modes, certificate and verification, too.
    #[arg(long)]
    verbose: bool,
    #[command(flatten)]
    outputs: OutputArguments,
}

/// Files written, beside problem and scenario.
const FILES: [(&str, Kind); 6] = [
    ("demo.vdm", Kind::Vademecum),
    ("touch.vdm", Kind::Vademecum),
    ("demo.json", Kind::Json),
    ("mesh.svg", Kind::Svg),
    ("tip.svg", Kind::Svg),
    ("energy.svg", Kind::Svg),
];

#[derive(Serialize)]
struct DemoReport<'a> {
    #[serde(flatten)]
    verify: &'a Verification,
    long_run: &'a LongRun,
    build: &'a BuildReport,
}

impl Demo {
    pub(crate) fn run(&self, console: &Console) -> Result<(), Failure> {
        let outputs = outputs(&self.outputs, &[], None);
        if self.large {
            return large::run(&self.output, [self.json, self.verbose], &outputs, console);
        }
        outputs.check_in(&self.output, &FILES)?;
        outputs.make_folder(&self.output)?;
        let own = [("problem.toml", PROBLEM), ("scenario.toml", SCENARIO)];
        own.iter().try_for_each(|(name, text)| check_own(&outputs, &self.output.join(name), text))?;
        own.iter().try_for_each(|(name, text)| write_own(&outputs, &self.output.join(name), text))?;
        let (problem, scenario) = (demo_problem()?, demo_scenario()?);
        let path = self.output.join("demo.vdm");

        let built = build(&problem, &BuildOptions::default(), console)?.kept()?;
        write_bytes(&outputs, &path, Kind::Vademecum, &built.bytes)?;
        let mapped = open(&path)?;
        let about = |error: StudyError| Failure::from(error).about(&path);
        let file = mapped.file().map_err(|error: FormatError| Failure::file(&path, error))?;
        let options = PlayOptions::default();
        let prepared = prepare(&problem, &mut Stopwatch::new(&Silent), &Silent)?;
        let verified =
            verify_linear(&file, &options, &problem, &prepared, &scenario, console).map_err(about)?;
        let touch = build(&touchable()?, &BuildOptions::default(), console)?.kept()?;
        let touch_path = self.output.join("touch.vdm");
        write_bytes(&outputs, &touch_path, Kind::Vademecum, &touch.bytes)?;
        console.stage("a million steps");
        let track = Track::bind(&file, &scenario).map_err(about)?;
        let long = long_run(&file, &options, &track, MANY, console).map_err(about)?;
        console.clear();

        let unread = |error: FileError| Failure::file(&path, error);
        let geometry = Geometry::of(&file).map_err(unread)?;
        let held = geometry.held(&file).map_err(unread)?.into_iter().map(|place| (0, place));
        let marks: Vec<_> = held.collect();
        let pushed = track.contacts.iter().map(|placed| (placed.point.position, placed.contact.force));
        self.draw(&outputs, &verified, &geometry, &marks, &pushed.collect::<Vec<_>>())?;
        let report = DemoReport { verify: &verified.figures, long_run: &long, build: &built.report };
        write_bytes(&outputs, &self.output.join("demo.json"), Kind::Json, json(&report).as_bytes())?;
        if self.json {
            print_json(&report);
        } else {
            if self.verbose {
                print_report(&built.report);
                println!();
                print_verification(&verified.figures);
            }
            print_summary(&built.report, &file, &path).map_err(unread)?;
            print_comparison(&verified.figures, &long, &self.output);
            println!("next: vademecum view {} (1.5 % damping, loadable everywhere)", touch_path.display());
        }
        Ok(())
    }

    fn draw(
        &self,
        outputs: &Outputs,
        verified: &VerificationRecord<Verification>,
        geometry: &Geometry,
        marks: &[(usize, [f64; 3])],
        forces: &[([f64; 3], [f64; 3])],
    ) -> Result<(), Failure> {
        let write = |name: &str, drawn| write_picture(outputs, &self.output.join(name), drawn).map(|_| ());
        let title = "Mesh (blue: clamped nodes, red: pushes)";
        let Geometry { nodes, triangles } = geometry;
        write("mesh.svg", outline(&Outline { title, marks, unit: "m", forces }, nodes, triangles))?;

        let [full, file] = &verified.probe_series;
        let tip = Chart { title: "tip displacement", x: "time [s]", y: "displacement [m]", log_y: false };
        let probes = verified.probes.len();
        let shown = verified.shown_seconds();
        let lines = [
            over_time("exact motion", full, probes, verified),
            over_time("vademecum", file, probes, verified),
        ]
        .map(|line| until(line, shown));
        write("tip.svg", compared_chart(&tip, ComparedLines { lines, acting: &verified.acting }))?;

        let [full, file] = &verified.energy_series;
        let energy = Chart { title: "energy", x: "time [s]", y: "energy [J]", log_y: false };
        let lines =
            vec![over_time("exact motion", full, 1, verified), over_time("vademecum", file, 1, verified)];
        write("energy.svg", line_chart(&energy, lines))
    }
}

/// Prints what the comparison with the full order and the long run have found, and what else was written.
fn print_comparison(verified: &Verification, long: &LongRun, folder: &Path) {
    println!(
        "compared with the exact motion at full order: {} of it apart; a step takes {}, at full order {}",
        percent(verified.truth.total_error),
        duration(long.seconds_per_step),
        duration(verified.full_order_seconds_per_step)
    );
    println!("pictures in {}: mesh.svg, tip.svg, energy.svg; figures: demo.json", folder.display());
}

/// The demo's beam for the page: loadable everywhere, and damped so that one push can be told from the next.
fn touchable() -> Result<Problem, Failure> {
    let text = PROBLEM
        .replace("surface = { group = \"z_max\" }\n", "")
        .replace("[time]\n", "[damping]\nratio = 0.015\n\n[time]\n");
    Ok(Problem::parse(&text, "the demo's problem for the page", PathBuf::new())?)
}

/// The part of a line up to `end` \[s\].
fn until(line: Series<'_>, end: f64) -> Series<'_> {
    Series { points: line.points.into_iter().filter(|point| point.0 <= end).collect(), ..line }
}

/// The first of `width` interleaved series over time.
fn over_time<'a>(
    name: &'a str,
    values: &[f64],
    width: usize,
    verified: &VerificationRecord<Verification>,
) -> Series<'a> {
    let points = values.iter().step_by(width.max(1)).enumerate();
    Series { name, points: points.map(|(i, &v)| (i as f64 * verified.time_step, v)).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_beam_of_the_page_is_damped_and_loadable_everywhere() {
        let text =
            |problem: Result<Problem, Failure>| problem.map_or_else(|_| panic!("a problem"), |p| p.text);
        let [plain, touched] = [demo_problem(), touchable()].map(text);
        assert!(plain.contains("z_max") && !touched.contains("z_max"), "{touched}");
        assert!(!plain.contains("[damping]") && touched.contains("ratio = 0.015"), "{touched}");
    }
}
