//! The long marches of the strain structure: random strain maps and built bodies, loads times 1, 4, 16 and
//! 256, steps times 1, 4 and 10, in both precisions.
//!
//! ```text
//! cargo run --release -p vademecum-tests --example strain_stability [-- STEPS [NAME ...]]
//! ```
//!
//! A march has 10⁶ steps unless another number is given; the whole record takes an hour on one core, and
//! prints a row as soon as it is known. A row is one map, load and step: the largest change of the energy
//! after the load has gone, over the energy then, without damping, and how near the energy came to its bound
//! while the load acted; `inf` if a step was refused. A load times 1 brings a body to about the largest
//! energy of its training.

use vademecum_build::input::Problem;
use vademecum_build::pipeline::{BuildOptions, build};
use vademecum_build::progress::Silent;
use vademecum_eval::{Scalar, SceneOptions};
use vademecum_format::scheme::StepParameters;
use vademecum_format::{File, SectionKind};
use vademecum_tests::bending::in_forty_steps;
use vademecum_tests::stage::with_scene;
use vademecum_tests::strained::Strained;
use vademecum_tests::stress::bodies::Cube;
use vademecum_tests::synthetic::Random;

/// Of a march whose next state would not be finite: that step is refused, and the state stays as it was.
const REFUSED: (f64, f64) = (f64::INFINITY, 0.0);

/// Steps under load.
const LOADED: usize = 200;

/// `n, n1, r, m` of the random maps.
const SIZES: [[usize; 4]; 5] =
    [[8, 0, 8, 24], [16, 0, 16, 48], [24, 0, 24, 72], [32, 0, 32, 96], [16, 8, 32, 64]];

/// Coordinates of the built bodies.
const COORDINATES: usize = 16;

/// A file, by how much its step is lengthened, and its load.
#[derive(Clone, Copy)]
struct Case<'a> {
    bytes: &'a [u8],
    longer: f64,
    times: f64,
    steps: usize,
}

/// What makes a file when its turn comes.
type Maker = Box<dyn Fn() -> Vec<u8>>;

/// Drift of the energy of a free body, and how near the energy came to its bound.
fn march<T: Scalar>(case: Case<'_>, viscosity: f64) -> (f64, f64) {
    let file = File::parse(case.bytes).expect("a file");
    let numbers = |kind| file.section(kind).expect("a section").numbers().expect("raw");
    let pattern = numbers(SectionKind::PatternBasis);
    let unit = pattern.iter().map(|x| x * x).sum::<f64>().sqrt();
    let energy = numbers(SectionKind::StrainLimits).iter().nth(1).expect("an energy");
    let step = file.metadata().time_step;
    // Random forces add up like the root of their number.
    let amplitude = case.times * (energy / LOADED as f64).sqrt() / (step * unit);
    let time_step = Some(case.longer * step);
    let options = SceneOptions { viscosity, substeps: Some(1), time_step, ..SceneOptions::default() };
    with_scene::<T, _>(case.bytes, &options, |scene, state, loads| {
        let mut random = Random::new(5);
        let (mut root, mut share) = (0.0f64, 0.0f64);
        for _ in 0..LOADED {
            let amplitude = amplitude * random.number();
            loads.clear();
            loads.add_pattern(scene, 0, amplitude).expect("a pattern");
            if scene.step(state, loads).is_err() {
                return REFUSED;
            }
            let next = scene.energy(state).expect("an energy").sqrt();
            let allowed = scene.parameters().time_step * amplitude.abs() * unit / 2f64.sqrt();
            share = share.max((next - root) / allowed);
            root = next;
        }
        loads.clear();
        let (start, mut off) = (scene.energy(state).expect("an energy"), 0.0f64);
        for step in 0..case.steps {
            if scene.step(state, loads).is_err() {
                return REFUSED;
            }
            if step % 1000 == 999 {
                let change = scene.energy(state).expect("an energy") / start - 1.0;
                assert!(change.is_finite());
                off = off.max(if viscosity == 0.0 { change.abs() } else { change });
            }
        }
        (off, share)
    })
}

/// A file of large displacements.
fn built(displacement: f64, parse: impl Fn(&str) -> Problem) -> Vec<u8> {
    let end = format!(
        "[load]\n[[load.pattern]]\nname = \"pull\"\ntraction = [30.0, -20.0, 100.0]\n\
         on = {{ group = \"x_max\" }}\n[basis]\nmodes = {COORDINATES}\n[tolerance]\nerror = 1e3\n\
         [large]\ndisplacement = {displacement}\n"
    );
    let (problem, ..) = in_forty_steps(|more| parse(&format!("{end}{more}")));
    let built = build(&problem, &BuildOptions::default(), &Silent).unwrap_or_else(|error| panic!("{error}"));
    built.either().bytes
}

/// What is held and of what, with a model of large displacements.
fn body(young: f64) -> String {
    format!(
        "[[material]]\nyoung = {young:e}\npoisson = 0.3\ndensity = 1000.0\n\
         [[support]]\non = {{ group = \"x_min\" }}\n"
    )
}

/// A beam whose outer half has another stiffness.
fn contrast(factor: f64) -> Vec<u8> {
    let young = 1e6;
    let mesh = "[mesh]\nblock = { lengths = [1.0, 0.1, 0.1], divisions = [8, 1, 1], order = \"quadratic\" }\n\
        [[mesh.region]]\nname = \"tip\"\non = { fraction = { axis = \"x\", side = \"max\", fraction = 0.5 } }\n";
    let tip = format!(
        "[[material]]\nregion = \"tip\"\nyoung = {:e}\npoisson = 0.3\ndensity = 1000.0\n",
        young * factor
    );
    built(0.3, |more| {
        let text = format!("model = \"large-displacement\"\n{mesh}{tip}{}{more}", body(young));
        Problem::parse(&text, "contrast.toml", ".".into()).unwrap_or_else(|error| panic!("{error}\n{text}"))
    })
}

/// A cube whose middle node is moved nearly into a face of its elements.
fn slivers() -> Vec<u8> {
    let cube = Cube::warped(|p| if p == [0.5; 3] { [0.25025, 0.5, 0.5] } else { p });
    built(0.1, |more| cube.parse(&format!("model = \"large-displacement\"\n{}{more}", body(1e6))))
}

fn main() {
    let mut arguments = std::env::args().skip(1);
    let steps = arguments.next().map_or(1_000_000, |n| n.parse().expect("a number of steps"));
    let names: Vec<String> = arguments.collect();
    let step = StepParameters { time_step: 5e-3, alpha: 0.0, beta: 0.0, density: 1.0, stiffness: 1.0 };
    let mut files: Vec<(String, Maker)> = vec![];
    for sizes in SIZES {
        let file = move || Strained::random(sizes, 1).file(&step);
        files.push((format!("random {}", sizes.map(|n| n.to_string()).join("/")), Box::new(file)));
    }
    files.push(("tip x 1e4".into(), Box::new(|| contrast(1e4))));
    files.push(("tip x 1e-4".into(), Box::new(|| contrast(1e-4))));
    files.push(("slivers of 1e-3".into(), Box::new(slivers)));
    println!(
        "| map | load | step | drift, f64 | share of bound | drift, f32 | growth, f32, c = 1/18 |\n{}|",
        "|---".repeat(7)
    );
    for (name, file) in files.iter().filter(|(name, _)| names.is_empty() || names.contains(name)) {
        let bytes = file();
        for longer in [1.0, 4.0, 10.0] {
            for times in [1.0, 4.0, 16.0, 256.0] {
                let case = Case { bytes: &bytes, longer, times, steps };
                let (double, share) = march::<f64>(case, 0.0);
                let (single, _) = march::<f32>(case, 0.0);
                let (damped, _) = march::<f32>(case, 1.0 / 18.0);
                println!(
                    "| {name} | x{times} | x{longer} | {double:.1e} | {share:.3} | {single:.1e} | {damped:.1e} |"
                );
            }
        }
    }
}
