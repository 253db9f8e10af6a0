//! A parameter that is moved while the body rings.
//!
//! What you learn: what a problem file says so that a parameter stays free, how a program finds it and sets
//! it, that the motion goes on from where it is, and why loads are added again after a change.

use std::error::Error;
use std::path::PathBuf;

use vademecum_build::input::Problem;
use vademecum_build::pipeline::{BuildOptions, build};
use vademecum_build::progress::Silent;
use vademecum_eval::format::File;
use vademecum_eval::{Contact, Field, LoadError, Loads, Scene, SceneOptions, State, Surface};

/// What the problem file says of the slider: a factor on the stiffness of the whole body, and its range.
const SLIDER: &str = "
[[parameter]]
name = \"stiffness\"
kind = \"stiffness\"
range = [0.5, 2.0]
scale = \"log\"
";

fn main() -> Result<(), Box<dyn Error>> {
    let text = format!("{}{SLIDER}", include_str!("beam.toml"));
    let problem = Problem::parse(&text, "beam.toml", PathBuf::new())?;
    let bytes = build(&problem, &BuildOptions::default(), &Silent)?.kept()?.bytes;
    let file = File::parse(&bytes)?;

    // The file knows its parameters by name, with unit and range: all that a slider on a screen needs.
    let slider = SceneOptions::find(file.metadata(), "stiffness").ok_or("no such parameter")?;
    let known = file.metadata().active_parameters()[slider];
    println!("slider `{}`: {} to {}, at first {}", known.name, known.lower, known.upper, known.nominal);

    let options = SceneOptions::default();
    let sizes = Scene::<f64>::sizes(&file, &options)?;
    let (mut memory, mut work) = (vec![0.0; sizes.scene], vec![0.0; sizes.work]);
    let (mut state_memory, mut load_memory) = (vec![0.0; sizes.state], vec![0.0; sizes.loads]);
    let mut scene = Scene::bind(&file, &options, &mut memory, &mut work)?;
    let mut state = State::new(&scene, &mut state_memory)?;
    let mut loads = Loads::new(&scene, &mut load_memory)?;

    // Bend the beam slowly enough that little more than its first mode moves, and let go.
    let tip = Surface::new(&file)?.locate([1.0, 0.05, 0.1]).ok_or("no loadable surface")?;
    let push = Contact::new(tip.place, [0.0, 0.0, -50.0]);
    loads.add_contact(&scene, &push)?;
    for _ in 0..25 {
        scene.step(&mut state, &loads)?;
    }
    loads.clear();
    let soft = ring(&scene, &mut state, &loads)?;

    // Move the slider. The state is carried over: at this instant nothing jumps, neither place nor velocity.
    let read = |scene: &Scene<'_, f64>, state: &State<'_, f64>| -> Result<[f64; 2], Box<dyn Error>> {
        Ok([scene.probe(state, 0, Field::Displacement)?, scene.probe(state, 0, Field::Velocity)?])
    };
    loads.add_contact(&scene, &push)?;
    let before = read(&scene, &state)?;
    scene.set_parameters(&[(slider, 2.0)], &mut state, &mut work)?;
    assert_eq!(read(&scene, &state)?, before, "the motion goes on from where it is");

    // What a load does in a step depends on the stiffness, so a load from before the change is refused.
    let stale = loads.add_contact(&scene, &push);
    assert_eq!(stale, Err(LoadError::Stale));
    loads.clear();

    // A value outside the range that was certified is an error and changes nothing; it is never clamped.
    assert!(scene.set_parameters(&[(slider, 2.1)], &mut state, &mut work).is_err());

    // Twice the stiffness rings √2 times as fast.
    let stiff = ring(&scene, &mut state, &loads)?;
    println!("rings at {soft:.2} Hz, then at {stiff:.2} Hz: {:.3} times as fast", stiff / soft);
    Ok(())
}

/// Lets the body ring for half a second; the frequency of its tip, from the first and the last crossing of
/// zero, Hz.
fn ring(
    scene: &Scene<'_, f64>,
    state: &mut State<'_, f64>,
    loads: &Loads<'_, f64>,
) -> Result<f64, Box<dyn Error>> {
    let step = scene.parameters().time_step;
    let mut last = scene.probe(state, 0, Field::Displacement)?;
    let mut crossings = vec![];
    for n in 0..500 {
        scene.step(state, loads)?;
        let now = scene.probe(state, 0, Field::Displacement)?;
        if (last < 0.0) != (now < 0.0) {
            // Between two steps the tip moves along a straight line, nearly.
            crossings.push(step * (n as f64 + last / (last - now)));
        }
        last = now;
    }
    let (Some(first), Some(end)) = (crossings.first(), crossings.last()) else { return Ok(0.0) };
    Ok(0.5 * (crossings.len() - 1) as f64 / (end - first))
}
