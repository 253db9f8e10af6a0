//! An earthquake shakes a tower: a base that moves, the shear at the foot, and the response spectrum of the
//! record.
//!
//! What you learn: `Loads::add_base` drives the supports, `Scene::reaction` says what the ground has to hold,
//! and the exact steps of the format are at hand for an oscillator of your own.

use std::error::Error;
use std::f64::consts::TAU;
use std::path::PathBuf;

use vademecum_build::input::Problem;
use vademecum_build::pipeline::{BuildOptions, build};
use vademecum_build::progress::Silent;
use vademecum_eval::format::exact::Propagator;
use vademecum_eval::format::{File, SectionKind};
use vademecum_eval::{BaseMotion, Field, Loads, Scene, SceneOptions, State};

const TOWER: &str = r#"
title = "a tower on the ground"
[mesh]
block = { lengths = [0.5, 0.4, 4.0], divisions = [1, 1, 8] }
[[material]]
young = 2e9
poisson = 0.2
density = 2000.0
[damping]
ratio = 0.05
[[support]]
name = "foot"
on = { group = "z_min" }
[base]
moves = true
[time]
step = 2e-3
[output]
reactions = true
[[output.probe]]
name = "top"
point = [0.25, 0.2, 4.0]
direction = [1.0, 0.0, 0.0]
"#;

const GRAVITY: f64 = 9.81;
const STEP: f64 = 2e-3;
const STEPS: usize = 6000;

/// Ground acceleration \[m/s²\] at each step: sixty waves from 0.5 to 20 Hz with phases out of a small
/// generator, which rise and fade, up to about 0.3 g.
fn record() -> Vec<f64> {
    let mut state: u32 = 2026;
    let waves: Vec<[f64; 2]> = (0..60)
        .map(|i| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let frequency = 0.5 * 40f64.powf(f64::from(i) / 59.0);
            [frequency, f64::from(state >> 8) / f64::from(1 << 24)]
        })
        .collect();
    let at = |n: usize| {
        let t = n as f64 * STEP;
        let envelope = if t < 2.0 { (t / 2.0).powi(2) } else { (-0.5 * (t - 5.0).max(0.0)).exp() };
        let sum: f64 = waves.iter().map(|[f, phase]| (TAU * (f * t + phase)).sin()).sum();
        0.018 * GRAVITY * envelope * sum
    };
    (0..=STEPS).map(at).collect()
}

/// The largest acceleration that an oscillator of this period, with 5 % damping, takes from the record: of its
/// displacement, times `ω²`.
fn spectral(record: &[f64], period: f64) -> f64 {
    let omega = TAU / period;
    let Propagator { d: [a, b, c, d], held, rising, .. } = Propagator::new(omega * omega, 0.05 * omega, STEP);
    let (mut place, mut speed, mut largest) = (0.0f64, 0.0f64, 0.0f64);
    for pair in record.windows(2) {
        let [start, change] = [-pair[0], pair[0] - pair[1]];
        let more = [
            a * place + b * speed + held[0] * start + rising[0] * change,
            c * place + d * speed + held[1] * start + rising[1] * change,
        ];
        (place, speed) = (place + more[0], speed + more[1]);
        largest = largest.max(place.abs());
    }
    omega * omega * largest
}

fn main() -> Result<(), Box<dyn Error>> {
    let problem = Problem::parse(TOWER, "tower.toml", PathBuf::new())?;
    let bytes = build(&problem, &BuildOptions::default(), &Silent)?.kept()?.bytes;
    let file = File::parse(&bytes)?;
    let options = SceneOptions::default();
    let sizes = Scene::<f64>::sizes(&file, &options)?;
    let (mut memory, mut work) = (vec![0.0; sizes.scene], vec![0.0; sizes.work]);
    let scene = Scene::<f64>::bind(&file, &options, &mut memory, &mut work)?;
    let (mut state_memory, mut load_memory) = (vec![0.0; sizes.state], vec![0.0; sizes.loads]);
    let mut state = State::new(&scene, &mut state_memory)?;
    let mut loads = Loads::new(&scene, &mut load_memory)?;

    let record = record();
    let peak = record.iter().fold(0.0, |m: f64, a| m.max(a.abs()));
    let (mut shear, mut moment, mut top) = (0.0f64, 0.0f64, 0.0f64);
    for pair in record.windows(2) {
        // The mean of the step is held over it.
        let acceleration = [0.5 * (pair[0] + pair[1]), 0.0, 0.0];
        loads.clear();
        loads.add_base(&scene, &BaseMotion { acceleration, ..BaseMotion::default() })?;
        scene.step(&mut state, &loads)?;
        let [fx, .., my, _] = scene.reaction(&state, 0)?.total();
        shear = shear.max(fx.abs());
        moment = moment.max(my.abs());
        top = top.max(scene.probe(&state, 0, Field::Displacement)?.abs());
    }
    println!("ground: {:.2} g at most over {} s", peak / GRAVITY, STEPS as f64 * STEP);
    println!("top: {:.1} mm at most", 1e3 * top);
    println!("foot: shear {:.2} kN, moment {:.2} kN m at most", 1e-3 * shear, 1e-3 * moment);

    println!("period [s]  spectral acceleration [g]");
    for period in [0.05, 0.1, 0.15, 0.2, 0.3, 0.5, 1.0, 2.0] {
        println!("{period:<10}  {:.2}", spectral(&record, period) / GRAVITY);
    }
    // What the first mode takes from the spectrum: the mass that moves with it, times the ordinate.
    let numbers = |kind| Ok::<_, Box<dyn Error>>(file.section(kind).ok_or("missing")?.numbers()?);
    let eigenvalues = numbers(SectionKind::Eigenvalues)?;
    let shares = numbers(SectionKind::PatternBasis)?;
    let sway = (0..scene.n_modes())
        .max_by(|&i, &j| {
            let share = |k| shares.get(k).map_or(0.0, f64::abs);
            share(i).total_cmp(&share(j))
        })
        .ok_or("no mode")?;
    let [lambda, share] = [&eigenvalues, &shares].map(|n| n.get(sway).unwrap_or(0.0));
    let period = TAU / lambda.sqrt();
    let of_mode = share * share * spectral(&record, period);
    println!("first mode along x: {period:.3} s, shear {:.2} kN by the spectrum", 1e-3 * of_mode);
    Ok(())
}
