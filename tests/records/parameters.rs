//! Cost against the number of live parameters: the table of `docs/measurements/parameters.md`.
//!
//! `cargo run --release -p vademecum-tests --example parameters [-- COUNT ...]` builds the body of
//! `fixtures/problems/four-materials.toml` with each COUNT (1 to 6) of parameters: the time step, the
//! stiffness of one region after the other, the density of the last.

use std::time::Instant;

use vademecum_build::input::Problem;
use vademecum_build::pipeline::{BuildOptions, Built, build};
use vademecum_build::progress::Silent;
use vademecum_eval::{Scene, SceneOptions, State, StructureChoice};
use vademecum_format::File;
use vademecum_tests::program::repository;

/// Repetitions of a change of parameter; the median counts.
const CHANGES: usize = 501;

fn main() {
    let mut counts: Vec<usize> =
        std::env::args().skip(1).map(|n| n.parse().expect("a number of parameters")).collect();
    if counts.is_empty() {
        counts = (1..=6).collect();
    }
    println!(
        "| parameters | points of the axes | stopped by | terms | map error, rms | worst | separate \\[s\\] \
         | file \\[bytes\\] | set \\[µs\\] |"
    );
    println!("|---|---|---|---|---|---|---|---|---|");
    for count in counts {
        row(count);
    }
}

fn row(count: usize) {
    let path = repository().join("fixtures/problems/four-materials.toml");
    let mut problem = Problem::read(&path).expect("the fixture");
    let step = problem.parameters.pop().expect("the time step stands last");
    let mut density = problem.parameters.last().expect("a region").clone();
    density.name = "tip density".into();
    density.kind = vademecum_build::input::ParameterKind::Density;
    problem.parameters.insert(0, step);
    problem.parameters.push(density);
    problem.parameters.truncate(count);
    // The maps are what is compared; few steps keep the marches at up to 64 corners short.
    problem.tolerance.steps = Some(20);
    let built = build(&problem, &BuildOptions::default(), &Silent).expect("a build").either();
    let report = &built.report;
    let separation = report.separation.as_ref().expect("parameters");
    let block = report.certificate.block.as_ref().expect("a block structure");
    let seconds: f64 =
        report.timings.iter().filter(|t| t.stage.starts_with("separate")).map(|t| t.seconds).sum();
    println!(
        "| {count} | {:?} | {} | {} | {:.1e} | {:.1e} | {seconds:.1} | {} | {:.1} |",
        separation.axis_points,
        separation.stop,
        separation.terms,
        block.map_error_rms,
        block.map_error_max,
        built.bytes.len(),
        1e6 * seconds_to_set(&built)
    );
}

/// Median seconds of setting the first parameter, in f32.
fn seconds_to_set(built: &Built) -> f64 {
    let file = File::parse(&built.bytes).expect("a file");
    let options = SceneOptions { structure: StructureChoice::Block, ..SceneOptions::default() };
    let sizes = Scene::<f32>::sizes(&file, &options).expect("sizes");
    let (mut memory, mut work) = (vec![0.0f32; sizes.scene], vec![0.0f64; sizes.work]);
    let mut lent = vec![0.0f32; sizes.state];
    let mut scene = Scene::bind(&file, &options, &mut memory, &mut work).expect("a scene");
    let mut state = State::new(&scene, &mut lent).expect("a state");
    let (lower, upper) =
        (file.metadata().active_parameters()[0].lower, file.metadata().active_parameters()[0].upper);
    let mut times: Vec<f64> = (0..CHANGES)
        .map(|i| {
            let value = lower + (upper - lower) * ((i % 10) as f64 + 0.5) / 10.0;
            let start = Instant::now();
            scene.set_parameters(&[(0, value)], &mut state, &mut work).expect("set");
            start.elapsed().as_secs_f64()
        })
        .collect();
    times.sort_by(f64::total_cmp);
    times[CHANGES / 2]
}
