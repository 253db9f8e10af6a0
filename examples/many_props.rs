//! Hundreds of instances of one body, each with its own load and state, stepped together.
//!
//! What you learn: the file and the bound scene exist once; an instance costs its state only. `Batch` steps
//! sixteen instances at once with the vectors of the processor, and puts those to rest that have come to
//! rest.

use std::error::Error;
use std::path::PathBuf;
use std::time::Instant;

use vademecum_build::input::Problem;
use vademecum_build::pipeline::{BuildOptions, build};
use vademecum_build::progress::Silent;
use vademecum_eval::format::File;
use vademecum_eval::{Batch, Contact, Field, Loads, Scene, SceneOptions, State, Surface};

/// A multiple of `Batch::LANES`, so that no group is half empty.
const PROPS: usize = 512;
const STEPS: usize = 250;

fn main() -> Result<(), Box<dyn Error>> {
    let problem = Problem::parse(include_str!("beam.toml"), "beam.toml", PathBuf::new())?;
    let bytes = build(&problem, &BuildOptions::default(), &Silent)?.kept()?.bytes;
    let file = File::parse(&bytes)?;

    // A body whose state sums up to less than `rest_below` is put to rest, and costs nothing until it is
    // loaded again.
    let options = SceneOptions { rest_below: 1e-6, ..SceneOptions::default() };
    let sizes = Scene::<f32>::sizes(&file, &options)?;
    let (mut memory, mut work) = (vec![0.0; sizes.scene], vec![0.0; sizes.work]);
    let scene = Scene::<f32>::bind(&file, &options, &mut memory, &mut work)?;

    // One state and one load are enough to talk to the batch: they are copied in and out.
    let (mut state_memory, mut load_memory) = (vec![0.0; sizes.state], vec![0.0; sizes.loads]);
    let mut state = State::new(&scene, &mut state_memory)?;
    let mut loads = Loads::new(&scene, &mut load_memory)?;
    let mut batch_memory = vec![0.0; Batch::len_for(&scene, PROPS)];
    let mut batch = Batch::new(&scene, PROPS, &mut batch_memory)?;

    // Every fourth prop is left alone; prop i of the others is pushed at its tip with i newtons.
    let tip = Surface::new(&file)?.locate([1.0, 0.05, 0.1]).ok_or("no loadable surface")?;
    for prop in (0..PROPS).filter(|prop| prop % 4 != 0) {
        loads.clear();
        let force = [0.0, 0.0, -(prop as f64)];
        loads.add_contact(&scene, &Contact::new(tip.place, force))?;
        batch.load(&scene, prop, &loads)?;
    }

    let start = Instant::now();
    let mut status = batch.step(&scene)?;
    for _ in 1..STEPS {
        status = batch.step(&scene)?;
    }
    let seconds = start.elapsed().as_secs_f64();
    println!("{PROPS} props: {} move, {} rest, {} refused", status.moving, status.at_rest, status.refused);

    let mut tip_of = |prop: usize| -> Result<f64, Box<dyn Error>> {
        batch.get(prop, &mut state)?;
        Ok(scene.probe(&state, 0, Field::Displacement)?)
    };
    // The body is linear: three hundred times the force moves it three hundred times as far, up to rounding.
    let (one, many) = (tip_of(1)?, tip_of(301)?);
    println!("prop 301 moved {:.4} times as far as prop 1; prop 4 moved {} m", many / one, tip_of(4)?);
    println!("one step of one prop: {:.1} ns", 1e9 * seconds / (STEPS * PROPS) as f64);
    Ok(())
}
