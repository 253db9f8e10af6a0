//! The record of `docs/measurements/large-displacements.md`: files of large displacements beside the full
//! order.
//!
//! ```text
//! cargo run --release -p vademecum-tests --example large [-- --body NAME --coordinates R --pushes N --work FOLDER]
//! ```
//!
//! Each body is built as `vademecum build` does it, with a step of a fortieth of its first period, and its
//! certificate is printed: pushes that no choice has seen. With a work folder a run that was stopped goes on.

use std::path::{Path, PathBuf};
use std::time::Instant;

use vademecum_build::input::Problem;
use vademecum_build::pipeline::{BuildOptions, build};
use vademecum_build::progress::Silent;
use vademecum_build::store::Store;
use vademecum_eval::{Contact, Place, Scalar, SceneOptions};
use vademecum_format::File;
use vademecum_tests::bending::{BendingBody, bending_bodies, in_forty_steps};
use vademecum_tests::program::repository;
use vademecum_tests::stage::with_scene;

fn main() {
    let (mut names, mut coordinates, mut pushes, mut work) = (vec![], 32, 4, None);
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        let mut value = || arguments.next().unwrap_or_else(|| panic!("{argument} wants a value"));
        match argument.as_str() {
            "--body" => names.push(value()),
            "--coordinates" => coordinates = value().parse().expect("a number of coordinates"),
            "--work" => work = Some(PathBuf::from(value())),
            "--pushes" => pushes = value().parse().expect("a number of pushes"),
            _ => panic!(
                "`{argument}` is not known: usage: large [--body NAME ...] [--coordinates R] [--pushes N] \
                 [--work FOLDER]"
            ),
        }
    }
    let folder = tempfile::tempdir().expect("a folder");
    let bodies = bending_bodies(folder.path());
    for name in &names {
        let known: Vec<&str> = bodies.iter().map(|body| body.name).collect();
        assert!(known.contains(&name.as_str()), "no body `{name}`; there are {}", known.join(", "));
    }
    for body in bodies.iter().filter(|body| names.is_empty() || names.iter().any(|name| name == body.name)) {
        record(body, coordinates, pushes, work.as_deref());
    }
}

fn record(body: &BendingBody, coordinates: usize, pushes: usize, work: Option<&Path>) {
    let text = |more: &str| {
        let displacement = body.displacement;
        format!(
            "model = \"large-displacement\"\n{}[basis]\nmodes = {coordinates}\n[tolerance]\nerror = 10.0\n\
             [large]\ndisplacement = {displacement}\npushes = {pushes}\n{more}",
            body.text
        )
    };
    let problem = |more: &str| {
        Problem::parse(&text(more), &format!("{}.toml", body.name), repository())
            .unwrap_or_else(|error| panic!("{error}"))
    };
    let (problem, period, dofs) = in_forty_steps(problem);
    println!("## {}\n\n{}; {dofs} dofs, first period {period:.3} s.\n", body.name, body.what);

    let start = Instant::now();
    let store = work.map(|folder| Store::new(folder, false));
    let options = BuildOptions { long: true, store: store.as_ref(), ..BuildOptions::default() };
    let built = match build(&problem, &options, &Silent) {
        Ok(built) => built.either(),
        Err(error) => {
            let mut causes = vec![error.to_string()];
            let mut cause = std::error::Error::source(&error);
            while let Some(next) = cause {
                causes.push(next.to_string());
                cause = next.source();
            }
            println!("No file: {}.\n", causes.join(": "));
            return;
        }
    };
    let seconds = start.elapsed().as_secs_f64();
    let large = built.report.large.as_ref().expect("measured pushes");
    println!("Strain map: {}, {} rows, {} sub-steps.\n", large.strain_map, large.rows, large.substeps);
    println!(
        "| push | surface moves | least stretch | error | floor | strain map | sub-steps | reference | linear model \
         |\n{}|",
        "|---".repeat(9)
    );
    for run in &large.runs {
        println!(
            "| {} | {:.3} m | {:.2} | {:.1} % | {:.2} % | {:.1} % | {:.1} % | {:.2} % | {:.0} % |",
            if run.pulse { "pulse" } else { "held, then let go" },
            run.displacement,
            run.least_stretch,
            100.0 * run.error,
            100.0 * run.floor,
            100.0 * run.closure_error,
            100.0 * run.time_error,
            100.0 * run.reference_error,
            100.0 * run.linear_error
        );
    }
    println!("\n| strain map | mean of the choice |\n|---|---|");
    for (name, error) in &large.candidates {
        println!("| {name} | {:.1} % |", 100.0 * error);
    }
    let identity = large.runs.iter().map(|run| run.energy_identity).fold(0.0, f64::max);
    println!("\nEnergy's identity: {identity:.0e}. Build: {seconds:.0} s.");
    println!(
        "A step of the file: {:.1} µs in binary64, {:.1} µs in binary32; at full order {:.3} s.",
        1e6 * seconds_per_step::<f64>(&built.bytes),
        1e6 * seconds_per_step::<f32>(&built.bytes),
        large.full_order_seconds_per_step
    );
    println!();
}

/// Wall time of a step under a force on the first node, the best of a few runs \[s\].
fn seconds_per_step<T: Scalar>(bytes: &[u8]) -> f64 {
    const RUNS: usize = 5;
    const EACH: usize = 2000;
    assert!(File::parse(bytes).is_ok());
    with_scene::<T, _>(bytes, &SceneOptions::default(), |scene, state, loads| {
        let force = Contact::new(Place::triangle([0; 3], [1.0, 0.0, 0.0]), [0.0, 0.0, 1e-3]);
        loads.add_contact(scene, &force).expect("a force");
        let mut best = f64::INFINITY;
        for _ in 0..RUNS {
            let start = Instant::now();
            for _ in 0..EACH {
                scene.step(state, loads).expect("a step");
            }
            best = best.min(start.elapsed().as_secs_f64() / EACH as f64);
        }
        best
    })
}
