//! A mattress of a thousand springs: somebody lies down, and every spring is a vademecum that rings by
//! itself.
//!
//! What you learn: `Batch` steps a thousand bodies of one file together, each under its own load that changes
//! while it moves, and one instance costs a few nanoseconds.

use std::error::Error;
use std::path::PathBuf;
use std::time::Instant;

use vademecum_build::input::Problem;
use vademecum_build::pipeline::{BuildOptions, build};
use vademecum_build::progress::Silent;
use vademecum_eval::format::File;
use vademecum_eval::{Batch, Contact, Field, Loads, Scene, SceneOptions, State, Surface};

/// Springs along and across; rows of the picture are every other row of springs.
const SPRINGS: [usize; 2] = [50, 20];
/// Steps of 2 ms: one second.
const STEPS: usize = 500;

/// A spring: a column of foam that stands on the floor.
const SPRING: &str = r#"
title = "a spring of a mattress"
[mesh]
block = { lengths = [0.04, 0.04, 0.2], divisions = [2, 2, 8], order = "quadratic" }
[[material]]
young = 5e4
poisson = 0.3
density = 60.0
[damping]
ratio = 0.1
[[support]]
on = { group = "z_min" }
[load]
surface = { group = "z_max" }
[time]
step = 2e-3
[basis]
kind = "modes"
modes = 8
[tolerance]
error = 0.2
"#;

/// Weight on the spring at a place of the mattress \[N\]: a head, a trunk and legs.
fn weight(x: f64, y: f64) -> f64 {
    let lies = |from: f64, to: f64, half: f64| x >= from && x < to && (y - 0.5).abs() < half;
    if lies(0.05, 0.2, 0.12) {
        3.0
    } else if lies(0.22, 0.6, 0.25) {
        4.0
    } else if lies(0.6, 0.95, 0.16) {
        2.0
    } else {
        0.0
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let problem = Problem::parse(SPRING, "spring.toml", PathBuf::new())?;
    let bytes = build(&problem, &BuildOptions::default(), &Silent)?.kept()?.bytes;
    let file = File::parse(&bytes)?;
    let options = SceneOptions { rest_below: 1e-7, ..SceneOptions::default() };
    let sizes = Scene::<f32>::sizes(&file, &options)?;
    let (mut memory, mut work) = (vec![0.0; sizes.scene], vec![0.0; sizes.work]);
    let scene = Scene::<f32>::bind(&file, &options, &mut memory, &mut work)?;
    let (mut state_memory, mut load_memory) = (vec![0.0; sizes.state], vec![0.0; sizes.loads]);
    let mut state = State::new(&scene, &mut state_memory)?;
    let mut loads = Loads::new(&scene, &mut load_memory)?;

    let [along, across] = SPRINGS;
    let count = along * across;
    let mut batch_memory = vec![0.0; Batch::len_for(&scene, count)];
    let mut batch = Batch::new(&scene, count, &mut batch_memory)?;
    let top = Surface::new(&file)?.locate([0.02, 0.02, 0.2]).ok_or("no loadable surface")?;
    for spring in 0..count {
        let (x, y) = ((spring / across) as f64 / along as f64, (spring % across) as f64 / across as f64);
        let force = [0.0, 0.0, -weight(x, y)];
        if force[2] != 0.0 {
            loads.clear();
            loads.add_contact(&scene, &Contact::new(top.place, force))?;
            batch.load(&scene, spring, &loads)?;
        }
    }
    let start = Instant::now();
    let mut status = batch.step(&scene)?;
    for _ in 1..STEPS {
        status = batch.step(&scene)?;
    }
    let seconds = start.elapsed().as_secs_f64();

    // How deep each spring is pressed, a digit for each five millimetres.
    let mut deepest = 0.0_f64;
    for row in (0..across).step_by(2) {
        let mut line = String::new();
        for column in 0..along {
            batch.get(column * across + row, &mut state)?;
            let depth = -scene.point(&state, &top, Field::Displacement)?[2];
            deepest = deepest.max(depth);
            line.push(match (200.0 * depth).round() as u32 {
                0 => '.',
                steps => char::from_digit(steps.min(9), 10).unwrap_or('9'),
            });
        }
        println!("{line}");
    }
    println!(
        "{count} springs: {} move, {} rest; the deepest by {:.1} mm",
        status.moving,
        status.at_rest,
        1e3 * deepest
    );
    println!("one step of one spring: {:.1} ns", 1e9 * seconds / (STEPS * count) as f64);
    Ok(())
}
