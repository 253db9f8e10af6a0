//! Errors of a file with live regions at random points and corners of its box, which no build has seen.
//!
//! ```text
//! cargo run --release -p vademecum-tests --example live_points -- PROBLEM FILE
//!     [--random N] [--corners N] [--seed N] [--modes N]
//! ```
//!
//! Each point has one push at a random loadable node in a random direction, over one period of the first
//! natural frequency there, and 200 steps of a fortieth of that period. Errors are relative to the motion of
//! the full model that is exact in time: over all unknowns and steps, of the projection of that motion on the
//! stepped modes, and of the displacement under the push.

use std::fmt::Write as _;
use std::path::PathBuf;

use vademecum_build::input::Problem;
use vademecum_build::prepared::prepare;
use vademecum_build::progress::{Silent, Stopwatch};
use vademecum_format::{File, ParameterRole, SectionKind};
use vademecum_study::live::{at_values, prepared_at};
use vademecum_study::modes::natural_modes;
use vademecum_study::parameters::ParameterValue;
use vademecum_study::player::PlayOptions;
use vademecum_study::scenario::Scenario;
use vademecum_study::verify::{Figures, verify};
use vademecum_tests::synthetic::Random;

/// Steps of a period, and of a run.
const STEPS: [f64; 2] = [40.0, 200.0];

fn main() {
    let (mut paths, mut random, mut corners, mut seed, mut modes) = (vec![], 64, 16, 1, 32);
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        let mut value = || arguments.next().and_then(|text| text.parse().ok()).expect("a number");
        match argument.as_str() {
            "--random" => random = value(),
            "--corners" => corners = value(),
            "--seed" => seed = value(),
            "--modes" => modes = value() as usize,
            _ => paths.push(PathBuf::from(argument)),
        }
    }
    let [problem, bytes] = &paths[..] else { panic!("expected PROBLEM FILE") };
    let problem = Problem::read(problem).expect("a problem");
    let bytes = std::fs::read(bytes).expect("a file");
    let file = File::parse(&bytes).expect("a file");
    let mut dice = Random::new(seed);
    for (kind, count) in [("interior", random), ("corner", corners)] {
        let mut errors = [vec![], vec![], vec![]];
        for point in 0..count {
            let found = measured(&problem, (&file, modes), kind == "corner", &mut dice);
            let [all, projection, push] = found;
            eprintln!(
                "{kind} {}: {all:.2e}, projection {projection:.2e}, under the push {push:.2e}",
                point + 1
            );
            errors.iter_mut().zip(found).for_each(|(all, own)| all.push(own));
        }
        for (what, mut errors) in
            ["all unknowns", "projection on the basis", "under the push"].into_iter().zip(errors)
        {
            errors.sort_by(f64::total_cmp);
            if let [.., worst] = errors[..] {
                let median = errors[errors.len() / 2];
                println!("{count} points, {kind}, {what}: median {median:.2e}, worst {worst:.2e}");
            }
        }
    }
}

/// Errors at a point of the box: of the motion, of its projection on the basis, under the push.
fn measured(
    problem: &Problem,
    (file, modes): (&File<'_>, usize),
    corner: bool,
    dice: &mut Random,
) -> [f64; 3] {
    let mut values: Vec<ParameterValue> = vec![];
    let mut step = None;
    for parameter in file.parameters() {
        let share = 0.5 * (1.0 + dice.number());
        let share = if corner { share.round() } else { share };
        let (lower, upper) = (parameter.lower, parameter.upper);
        let value = match parameter.log {
            true => lower * (upper / lower).powf(share),
            false => lower + share * (upper - lower),
        };
        if parameter.role == ParameterRole::TimeStep {
            step = Some(parameter);
        } else {
            values.push(ParameterValue { name: parameter.name.into(), value: value.clamp(lower, upper) });
        }
    }
    let (first, _) = natural_modes(problem, Some(1), None, &values, &Silent).expect("a first mode");
    let time_step = 1.0 / (STEPS[0] * first.frequencies_hz[0]);
    let mut options = PlayOptions::default();
    match step {
        Some(step) => {
            let value = time_step.clamp(step.lower, step.upper);
            values.push(ParameterValue { name: step.name.into(), value });
        }
        None => options.scene.time_step = Some(time_step),
    }
    let body = at_values(file, &values, Some(modes)).expect("set").expect("a parametric model");
    let at = File::parse(&body.bytes).expect("a file");
    let scenario = push(file, time_step, dice);
    let mut prepared = prepare(problem, &mut Stopwatch::new(&Silent), &Silent).expect("prepared");
    prepared_at(&mut prepared, &body.values).expect("values of the problem");
    let found = verify(&at, &options, problem, &prepared, &scenario, &Silent).expect("verified");
    let Figures::Linear(figures) = found.figures else { panic!("a linear body") };
    let truth = figures.truth;
    [truth.total_error, truth.basis_error, truth.contact_error.unwrap_or(f64::NAN)]
}

/// A push at a random loadable node.
fn push(file: &File<'_>, time_step: f64, dice: &mut Random) -> Scenario {
    let nodes = file.section(SectionKind::NodeCoordinates).expect("nodes").numbers().expect("numbers");
    let count = f64::from(file.metadata().n_load_nodes);
    let basis = file.section(SectionKind::SurfaceBasis).expect("a basis").numbers().expect("numbers");
    let width = 3 * file.metadata().n_modes as usize;
    // A held node carries no push.
    let moves = |node: usize| (0..width).any(|k| basis.get(width * node + k) != Some(0.0));
    let node = loop {
        let node = ((0.5 * (1.0 + dice.number()) * count) as usize).min(count as usize - 1);
        if moves(node) {
            break node;
        }
    };
    let point: Vec<f64> = (0..3).map(|c| nodes.get(3 * node + c).expect("a coordinate")).collect();
    let direction = loop {
        let vector = [dice.number(), dice.number(), dice.number()];
        let length = vector.iter().map(|x| x * x).sum::<f64>().sqrt();
        if (0.1..=1.0).contains(&length) {
            break vector.map(|x| x / length);
        }
    };
    let mut text = String::new();
    let (end, duration) = (STEPS[0] * time_step, STEPS[1] * time_step);
    write!(
        text,
        "duration = {duration:e}\n[[contact]]\npoint = {point:?}\nforce = {direction:?}\nend = {end:e}\n"
    )
    .expect("text");
    Scenario::parse(&text, "push.toml").expect("a scenario")
}
