//! The step against modes, contacts and outputs, on files made without a build.

use std::hint::black_box;
use std::time::Instant;

use vademecum_eval::{Contact, Field, Place, Scalar, SceneOptions, StructureChoice};
use vademecum_format::Element;
use vademecum_format::scheme::StepParameters;
use vademecum_tests::stage::with_scene;
use vademecum_tests::synthetic::{Body, Layout, bathe};

use crate::fit::{Column, print};

/// Rounds in which all sizes take turns; the median counts.
const ROUNDS: usize = 5;

fn file(side: usize, r: usize) -> Vec<u8> {
    let layout = Layout { rows: side, load_rows: 2, columns: side, n_interior: 4, r };
    let parameters = StepParameters { time_step: 1e-3, alpha: 0.0, beta: 0.0, density: 1.0, stiffness: 1.0 };
    Body::closed(layout, 1).file(&bathe(), &parameters, Element::F32)
}

fn options(structure: StructureChoice) -> SceneOptions {
    SceneOptions { structure, ..SceneOptions::default() }
}

const CONTACT: Contact = Contact::new(Place::triangle([0, 1, 5], [0.2, 0.3, 0.5]), [1.0, 0.0, 0.0]);

/// Nanoseconds of one call: the fastest of some bursts, each long enough for the clock and short enough to be
/// left alone by whatever else runs.
fn timed(mut work: impl FnMut()) -> f64 {
    const BURST_NS: f64 = 20_000.0;
    let mut burst = |calls: usize| {
        let start = Instant::now();
        (0..calls).for_each(|_| work());
        1e9 * start.elapsed().as_secs_f64() / calls as f64
    };
    let first = burst(1).min(burst(1)).max(1.0);
    let calls = (BURST_NS / first).ceil() as usize;
    (0..50).map(|_| burst(calls)).fold(f64::MAX, f64::min)
}

/// A column of medians: `measure(size)` once per size in each round.
fn column(name: &str, sizes: &[f64], measure: impl Fn(usize) -> f64) -> Column {
    let mut samples = vec![vec![]; sizes.len()];
    for _ in 0..ROUNDS {
        samples.iter_mut().zip(sizes).for_each(|(s, &size)| s.push(measure(size as usize)));
    }
    let median = |mut s: Vec<f64>| {
        s.sort_by(f64::total_cmp);
        s[s.len() / 2]
    };
    Column { name: name.into(), values: samples.into_iter().map(median).collect() }
}

fn step<T: Scalar>(structure: StructureChoice, r: usize) -> f64 {
    with_scene::<T, f64>(&file(6, r), &options(structure), |scene, state, loads| {
        loads.add_contact(scene, &CONTACT).expect("contact");
        timed(|| {
            black_box(scene.step(state, loads)).expect("a step");
        })
    })
}

/// Clearing the loads and adding some contacts, without the step.
fn contacts<T: Scalar>(structure: StructureChoice, r: usize, count: usize) -> f64 {
    with_scene::<T, f64>(&file(6, r), &options(structure), |scene, _, loads| {
        timed(|| {
            loads.clear();
            (0..count).for_each(|_| loads.add_contact(scene, black_box(&CONTACT)).expect("contact"));
        })
    })
}

/// Reading the displacement of some nodes, and of the whole surface in one call.
fn outputs(side: usize, whole: bool) -> f64 {
    with_scene::<f32, f64>(&file(side, 16), &options(StructureChoice::Diagonal), |scene, state, loads| {
        loads.add_contact(scene, &CONTACT).expect("contact");
        scene.step(state, loads).expect("a step");
        let nodes = side * side;
        let mut field = vec![0.0; 3 * nodes];
        timed(|| {
            if whole {
                scene.surface_into(state, Field::Displacement, &mut field).expect("a field");
                black_box(&mut field);
            } else {
                for node in 0..nodes {
                    black_box(scene.node(state, node, Field::Displacement)).expect("a node");
                }
            }
        })
    })
}

/// Prints all tables.
pub fn run() {
    use StructureChoice::{Block, Diagonal};
    let modes = [4.0, 8.0, 16.0, 32.0, 64.0, 96.0];
    let columns = [
        column("diagonal f32, ns", &modes, |r| step::<f32>(Diagonal, r)),
        column("diagonal f64, ns", &modes, |r| step::<f64>(Diagonal, r)),
        column("block f32, ns", &modes, |r| step::<f32>(Block, r)),
        column("block f64, ns", &modes, |r| step::<f64>(Block, r)),
    ];
    print("A step against modes, one contact held", "modes", &modes, &columns);

    let counts = [1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0];
    let columns = [
        column("diagonal f32, 16 modes, ns", &counts, |c| contacts::<f32>(Diagonal, 16, c)),
        column("block f32, 16 modes, ns", &counts, |c| contacts::<f32>(Block, 16, c)),
        column("block f32, 64 modes, ns", &counts, |c| contacts::<f32>(Block, 64, c)),
    ];
    print("Setting contacts anew, without the step", "contacts", &counts, &columns);

    let sides = [4.0, 8.0, 16.0, 32.0, 64.0];
    let nodes = sides.map(|s| s * s);
    let columns = [
        column("node by node, ns", &sides, |side| outputs(side, false)),
        column("the surface at once, ns", &sides, |side| outputs(side, true)),
    ];
    print("Reading displacements, f32, 16 modes", "nodes", &nodes, &columns);
}
