//! A loop at 1 kHz in which a finger presses on a body and feels it.
//!
//! What you learn: what belongs before the loop (opening, binding, lending memory), what belongs into it
//! (locate, load, step, read), and how a second thread that draws gets its numbers without ever making the
//! loop wait.

use std::error::Error;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use vademecum_build::input::Problem;
use vademecum_build::pipeline::{BuildOptions, build};
use vademecum_build::progress::Silent;
use vademecum_eval::{Contact, Field, Loads, Mapped, Scene, SceneOptions, State, Surface};

const TICK: Duration = Duration::from_millis(1);
const TICKS: usize = 1000;
/// How hard the finger resists, N/m: its force is this times how deep the body's surface lies above it.
const FINGER: f64 = 5e3;

fn main() -> Result<(), Box<dyn Error>> {
    // A real program ships the file. Here it is built first, so that the example needs nothing else.
    let problem = Problem::parse(include_str!("beam.toml"), "beam.toml", PathBuf::new())?;
    let folder = tempfile::tempdir()?;
    let path = folder.path().join("beam.vdm");
    std::fs::write(&path, build(&problem, &BuildOptions::default(), &Silent)?.kept()?.bytes)?;

    // The numbers that the loop shares. Atomics never block: the loop writes, the drawing thread reads.
    let (tip, done) = (AtomicU64::new(0), AtomicBool::new(false));
    thread::scope(|threads| {
        threads.spawn(|| draw(&tip, &done));
        let felt = touch(&path, &tip);
        done.store(true, Ordering::Release);
        // The error of a thread cannot be sent as it is; its text can.
        felt.map_err(|error| error.to_string())
    })?;
    Ok(())
}

/// Opens the file and runs the loop.
fn touch(path: &std::path::Path, tip: &AtomicU64) -> Result<(), Box<dyn Error>> {
    // All memory of the loop is lent here, before it starts.
    let mapped = Mapped::copy(path)?;
    let file = mapped.file()?;
    let options = SceneOptions::default();
    let sizes = Scene::<f32>::sizes(&file, &options)?;
    let (mut memory, mut work) = (vec![0.0; sizes.scene], vec![0.0; sizes.work]);
    let (mut state_memory, mut load_memory) = (vec![0.0; sizes.state], vec![0.0; sizes.loads]);
    let scene = Scene::bind(&file, &options, &mut memory, &mut work)?;
    let mut state = State::new(&scene, &mut state_memory)?;
    let mut loads = Loads::new(&scene, &mut load_memory)?;
    let surface = Surface::new(&file)?;
    let (mut late, mut spent) = (Vec::with_capacity(TICKS), Vec::with_capacity(TICKS));
    let (mut hardest, mut deepest) = (0.0_f64, 0.0_f64);

    let start = Instant::now();
    for tick in 0..TICKS {
        // Sleep until the tick, not for a tick: then delays do not add up.
        let due = start + TICK * tick as u32;
        thread::sleep(due.saturating_duration_since(Instant::now()));
        let woken = Instant::now();

        // The device says where the finger is. Here it wanders along the beam and dips up to 4 mm below its
        // rest.
        let time = tick as f64 * 1e-3;
        let finger = [0.7 + 0.2 * time, 0.05, 0.1 - 0.002 * (1.0 - (std::f64::consts::TAU * time).cos())];
        let touched = surface.locate([finger[0], finger[1], 0.1]).ok_or("no loadable surface")?;
        let [.., moved] = scene.point(&state, &touched, Field::Displacement)?;

        // A penalty force: the deeper the finger is in the body, the harder both push.
        let depth = (touched.position[2] + moved - finger[2]).max(0.0);
        let push = FINGER * depth;
        loads.clear();
        let force = [0.0, 0.0, -push];
        loads.add_contact(&scene, &Contact::new(touched.place, force))?;
        scene.step(&mut state, &loads)?;

        // What the device shows is `push`; what the other thread draws is the tip.
        tip.store(scene.probe(&state, 0, Field::Displacement)?.to_bits(), Ordering::Release);
        (hardest, deepest) = (hardest.max(push), deepest.max(-moved));
        spent.push(woken.elapsed());
        late.push(woken.saturating_duration_since(due));
    }
    println!("{TICKS} ticks of 1 ms; hardest push {hardest:.2} N, deepest point {:.3} mm", 1e3 * deepest);
    print("woke up late by", &mut late);
    print("locate, load, step, read in", &mut spent);
    Ok(())
}

/// Draws at 10 Hz what the loop has computed last.
fn draw(tip: &AtomicU64, done: &AtomicBool) {
    while !done.load(Ordering::Acquire) {
        thread::sleep(Duration::from_millis(100));
        println!("    tip at {:+.3} mm", 1e3 * f64::from_bits(tip.load(Ordering::Acquire)));
    }
}

/// Jitter shows in the late ones: the median says little about a loop that must never miss.
fn print(what: &str, times: &mut [Duration]) {
    times.sort_unstable();
    let at = |share: f64| times[((times.len() - 1) as f64 * share) as usize];
    println!("{what}: median {:?}, 99 % {:?}, worst {:?}", at(0.5), at(0.99), at(1.0));
}
