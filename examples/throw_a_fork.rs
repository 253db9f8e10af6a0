//! A tuning fork is tapped and thrown: it tumbles, and it rings while it does.
//!
//! What you learn: a body without supports has a rigid motion ([`FreeBody`]) beside its scene; forces are
//! those of space, and the two go together in one step. Nothing here knows of rotations.

use std::error::Error;
use std::fmt::Write as _;

use vademecum_build::input::Problem;
use vademecum_build::mesh::{Order, block};
use vademecum_build::pipeline::{BuildOptions, build};
use vademecum_build::progress::Silent;
use vademecum_eval::format::{File, SectionKind};
use vademecum_eval::{Field, FreeBody, Loads, RigidMotion, Scene, SceneOptions, State, Surface};

const GRAVITY: f64 = 9.81;
const SECONDS: f64 = 0.6;

/// No `[[support]]`: the body is free.
const FORK: &str = r#"
title = "a tuning fork in flight"
[mesh]
tables = { coordinates = "nodes.csv", connectivity = "elements.csv" }
[[material]]
young = 2.1e11
poisson = 0.29
density = 7850.0
[damping]
ratio = 2e-4
[time]
step = 2e-5
[basis]
modes = 16
[tolerance]
error = 1.0
"#;

fn main() -> Result<(), Box<dyn Error>> {
    // A real program ships the file. Here it is built first, so that the example needs nothing else.
    let bytes = fork()?;
    let file = File::parse(&bytes)?;
    let options = SceneOptions::default();
    let sizes = Scene::<f64>::sizes(&file, &options)?;
    let (mut memory, mut work) = (vec![0.0; sizes.scene], vec![0.0; sizes.work]);
    let (mut state_memory, mut load_memory) = (vec![0.0; sizes.state], vec![0.0; sizes.loads]);
    let scene = Scene::bind(&file, &options, &mut memory, &mut work)?;
    let mut state = State::new(&scene, &mut state_memory)?;
    let mut loads = Loads::new(&scene, &mut load_memory)?;
    let surface = Surface::new(&file)?;
    let tip = surface.locate([0.12, 0.0, 0.002]).ok_or("no surface")?;

    // Thrown upwards, turning about the axis of middle moment, a little off it.
    let (velocity, spin) = ([0.5, 0.0, 3.0], [0.3, 0.1, 25.0]);
    let mut free = FreeBody::new(&scene, |body| {
        let [x, y, z] = spin;
        // The fork lies along x: its moments ascend about x, y, z.
        RigidMotion::thrown(body, velocity, [x, z, y])
    })
    .ok_or("the fork is held")?;
    let (mass, thrown) = (free.body().mass, *free.motion());

    let steps = (SECONDS / scene.parameters().time_step).round() as usize;
    let (mut crossings, mut last, mut ringing) = (vec![], 0.0, 0.0f64);
    let (mut turned_over, mut facing) = (0, 1.0);
    let mut tapped = None;
    for step in 0..steps {
        let time = step as f64 * scene.parameters().time_step;
        free.pull([0.0, 0.0, -GRAVITY * mass]);
        if time < 2e-4 {
            // The tap squeezes one prong; it is a force of space, and gives the fork a little momentum.
            free.push(&scene, &mut loads, &tip, [0.0, 20.0, 0.0])?;
        }
        free.step(&scene, &mut state, &mut loads)?;
        if tapped.is_none() && time >= 2e-4 {
            tapped = Some((time + scene.parameters().time_step, momenta(free.motion())));
        }

        // The ring is seen in the frame of the fork; its place in space is `free.point`.
        let [_, across, _] = scene.point(&state, &tip, Field::Displacement)?;
        ringing = ringing.max(across.abs());
        if last < 0.0 && across >= 0.0 {
            crossings.push(time);
        }
        last = across;
        let [_, middle, _] = free.motion().spin(free.body());
        turned_over += i32::from(middle * facing < 0.0);
        facing = middle;
    }

    let (since, tapped) = tapped.ok_or("a flight of some milliseconds")?;
    let flown = SECONDS - since;
    let now = momenta(free.motion());
    let moved = |k: usize| now[k] - tapped[k] + if k == 2 { GRAVITY * mass * flown } else { 0.0 };
    let size = |m: &[f64]| m.iter().map(|x| x * x).sum::<f64>().sqrt();
    let pitch = (crossings.len() - 1) as f64 / (crossings[crossings.len() - 1] - crossings[0]);
    let first = eigenvalue(&file)?.sqrt() / std::f64::consts::TAU;
    let place = free.point(&scene, &state, &tip)?;
    println!("fork of {:.4} kg with {} modes, thrown and tapped; {steps} steps", mass, scene.n_modes());
    println!("rings at {pitch:.2} Hz, its first mode is at {first:.2} Hz; up to {:.4} mm", 1e3 * ringing);
    println!("turned over {turned_over} times about its middle axis");
    println!(
        "momentum kept to {:.1e}, angular momentum to {:.1e}",
        size(&[moved(0), moved(1), moved(2)]) / size(&thrown.momentum),
        size(&[moved(3), moved(4), moved(5)]) / size(&thrown.angular_momentum)
    );
    println!("prong in space: {:.4} {:.4} {:.4}", place[0], place[1], place[2]);
    Ok(())
}

fn momenta(motion: &RigidMotion) -> [f64; 6] {
    let ([a, b, c], [d, e, f]) = (motion.momentum, motion.angular_momentum);
    [a, b, c, d, e, f]
}

/// The first eigenvalue \[rad²/s²\].
fn eigenvalue(file: &File<'_>) -> Result<f64, Box<dyn Error>> {
    let section = file.section(SectionKind::Eigenvalues).ok_or("no modes")?;
    Ok(section.numbers()?.get(0).ok_or("no modes")?)
}

/// The bytes of a steel fork: a stem, a bridge and two prongs, cut out of a block. All lengths in m.
fn fork() -> Result<Vec<u8>, Box<dyn Error>> {
    let mesh = block([0.12, 0.015, 0.004], [24, 3, 1], Order::Quadratic);
    let steel = |element: &[u32]| {
        let middle = |c: usize| element[..4].iter().map(|&n| mesh.nodes[n as usize][c]).sum::<f64>() / 4.0;
        let (x, inner) = (middle(0), (0.005..0.010).contains(&middle(1)));
        if x < 0.03 { inner } else { x < 0.04 || !inner }
    };
    let mut number = vec![None; mesh.nodes.len()];
    let (mut nodes, mut elements, mut count) = (String::new(), String::new(), 0);
    for element in mesh.elements.chunks_exact(10).filter(|element| steel(element)) {
        for &node in element {
            let own = *number[node as usize].get_or_insert_with(|| {
                let [x, y, z] = mesh.nodes[node as usize];
                count += 1;
                // Writing to a string cannot fail.
                let _ = writeln!(nodes, "{x},{y},{z}");
                count
            });
            let _ = write!(elements, "{own} ");
        }
        elements.push('\n');
    }
    let folder = tempfile::tempdir()?;
    std::fs::write(folder.path().join("nodes.csv"), nodes)?;
    std::fs::write(folder.path().join("elements.csv"), elements)?;
    let problem = Problem::parse(FORK, "fork.toml", folder.path().to_path_buf())?;
    Ok(build(&problem, &BuildOptions::default(), &Silent)?.kept()?.bytes)
}
