//! `vademecum demo --large`: a beam that bends by more than a right angle.

use std::path::Path;

use serde::Serialize;
use vademecum_build::certificate::LargeRun;
use vademecum_build::input::Problem;
use vademecum_build::pipeline::{BuildOptions, build};
use vademecum_build::progress::Listener;
use vademecum_build::report::BuildReport;
use vademecum_build::store::{Kind, Outputs};
use vademecum_format::FormatError;
use vademecum_study::player::{LongRun, PlayOptions, Track, long_run};
use vademecum_study::scenario::Scenario;
use vademecum_study::{FileError, StudyError};

use crate::console::Console;
use crate::failure::Failure;
use crate::files::{check_own, open, write_bytes, write_own};
use crate::print::{json, print_json, print_report, print_summary};
use crate::words::{duration, percent};

const PROBLEM: &str = include_str!("../../../assets/bending-beam.toml");
const SCENARIO: &str = include_str!("../../../assets/bend.toml");

/// Steps of the long run.
const MANY: usize = 20_000;

/// Files written, beside problem and scenario.
const FILES: [(&str, Kind); 2] = [("demo.vdm", Kind::Vademecum), ("demo.json", Kind::Json)];

#[derive(Serialize)]
struct LargeDemo<'a> {
    #[serde(flatten)]
    figures: PushFigures,
    long_run: &'a LongRun,
    build: &'a BuildReport,
}

/// The worst of all pushes.
#[derive(Serialize)]
struct PushFigures {
    trajectory_error: f64,
    projection_floor: f64,
    linear_error: f64,
    energy_identity: f64,
    vademecum_seconds_per_step: f64,
    full_order_seconds_per_step: f64,
}

/// Builds the beam, writes its file and what was measured.
pub(crate) fn run(
    folder: &Path,
    [as_json, verbose]: [bool; 2],
    outputs: &Outputs,
    console: &Console,
) -> Result<(), Failure> {
    outputs.check_in(folder, &FILES)?;
    outputs.make_folder(folder)?;
    let own = [("problem.toml", PROBLEM), ("scenario.toml", SCENARIO)];
    own.iter().try_for_each(|(name, text)| check_own(outputs, &folder.join(name), text))?;
    own.iter().try_for_each(|(name, text)| write_own(outputs, &folder.join(name), text))?;
    let problem = Problem::parse(PROBLEM, "the demo's problem", Default::default())?;
    let scenario = Scenario::parse(SCENARIO, "the demo's scenario")?;
    let path = folder.join("demo.vdm");

    let built = build(&problem, &BuildOptions::default(), console)?.kept()?;
    write_bytes(outputs, &path, Kind::Vademecum, &built.bytes)?;
    let mapped = open(&path)?;
    let about = |error: StudyError| Failure::from(error).about(&path);
    let file = mapped.file().map_err(|error: FormatError| Failure::file(&path, error))?;
    let track = Track::bind(&file, &scenario).map_err(about)?;
    console.stage("a long run");
    let long = long_run(&file, &PlayOptions::default(), &track, MANY, console).map_err(about)?;
    console.clear();

    let measured = built.report.large.as_ref().expect("a build of large displacements measures them");
    let largest = |part: fn(&LargeRun) -> f64| measured.runs.iter().map(part).fold(0.0, f64::max);
    let figures = PushFigures {
        trajectory_error: largest(|run| run.error),
        projection_floor: largest(|run| run.floor),
        linear_error: largest(|run| run.linear_error),
        energy_identity: largest(|run| run.energy_identity),
        vademecum_seconds_per_step: long.seconds_per_step,
        full_order_seconds_per_step: measured.full_order_seconds_per_step,
    };
    let report = LargeDemo { figures, long_run: &long, build: &built.report };
    write_bytes(outputs, &folder.join("demo.json"), Kind::Json, json(&report).as_bytes())?;
    if as_json {
        print_json(&report);
    } else {
        if verbose {
            print_report(&built.report);
        }
        let unread = |error: FileError| Failure::file(&path, error);
        print_summary(&built.report, &file, &path).map_err(unread)?;
        print(&report.figures);
        println!("next: vademecum view {}", path.display());
    }
    Ok(())
}

fn print(figures: &PushFigures) {
    println!(
        "a step takes {}, at full order {}; the linear model is {} of the motion off",
        duration(figures.vademecum_seconds_per_step),
        duration(figures.full_order_seconds_per_step),
        percent(figures.linear_error)
    );
}
