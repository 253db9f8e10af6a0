//! A body at rest: the energy its rest takes away, what wakes it, and that quiet bodies do rest and cost nothing extra before.

use std::time::Instant;
use vademecum_eval::{Contact, Loads, Modal, Scalar, Scene, SceneOptions, State, Status, StructureChoice};
use vademecum_format::scheme::StepParameters;
use vademecum_format::{Element, File};
use vademecum_tests::stage::with_scene;
use vademecum_tests::synthetic::{Body, Layout, Random, bathe};

const R: usize = 8;
const LAYOUT: Layout = Layout { rows: 3, load_rows: 2, columns: 3, n_interior: 3, r: R };
const STRUCTURES: [StructureChoice; 2] = [StructureChoice::Diagonal, StructureChoice::Block];

fn file(time_step: f64, alpha: f64) -> (Body, Vec<u8>) {
    let step = StepParameters { time_step, alpha, beta: 0.0, density: 1.0, stiffness: 1.0 };
    let body = Body::open(LAYOUT, 1);
    let bytes = body.file(&bathe(), &step, Element::F64);
    (body, bytes)
}

/// Decays from random states under random damping to random thresholds: the twin that never rests shows what was dropped.
#[test]
fn rest_takes_no_more_than_the_stated_energy() {
    let mut random = Random::new(7);
    let mut closest = 0.0f64;
    for n in 0..60 {
        let structure = STRUCTURES[n % 2];
        let alpha = 10.0f64.powf(1.0 + random.number());
        let (body, bytes) = file(10f64.powf(-3.0 + 0.7 * random.number()), alpha);
        let rest_below = 10f64.powf(-5.0 + 2.0 * random.number());
        let options = SceneOptions { structure, rest_below, ..SceneOptions::default() };
        let never = SceneOptions { structure, ..SceneOptions::default() };
        with_scene::<f64, ()>(&bytes, &options, |scene, state, loads| {
            with_scene::<f64, ()>(&bytes, &never, |free, twin, _| {
                let rates: Vec<f64> = random.numbers(R).iter().map(|v| 10.0 * v).collect();
                scene.set(state, &random.numbers(R), &rates, loads).expect("set");
                let mut start = [0.0; 3 * R];
                state.save_into(&mut start).expect("length");
                twin.restore(&start).expect("start");
                while scene.step(state, loads).expect("step") == Status::Moving {
                    free.step(twin, loads).expect("step");
                }
                free.step(twin, loads).expect("step");
                let stated = scene.energy_at_rest();
                let dropped = free.energy(twin).expect("energy");
                assert!(dropped > 0.0 && dropped <= stated, "{structure:?}: {dropped:e} of {stated:e}");
                closest = closest.max(dropped / stated);
                // ½ s_K λ_min |ζ|² ≤ E, and the energy of a free run stays within 1 + 1e-6 of its start (the certificate's limit).
                let softest = body.lambda.iter().fold(f64::MAX, |a, &b| a.min(b));
                for _ in 0..2000 {
                    free.step(twin, loads).expect("step");
                    let square: f64 = twin.zeta().iter().map(|z| z * z).sum();
                    assert!(0.5 * softest * square <= (1.0 + 1e-6) * stated);
                }
            });
        });
    }
    println!("largest dropped energy over the stated one: {closest:.2}");
}

#[test]
fn a_load_wakes_and_a_change_of_parameters_does_not() {
    let (_, bytes) = file(1e-3, 300.0);
    let parsed = File::parse(&bytes).expect("a file");
    let options =
        SceneOptions { structure: StructureChoice::Diagonal, rest_below: 1e-9, ..SceneOptions::default() };
    let sizes = Scene::<f64>::sizes(&parsed, &options).expect("sizes");
    let (mut memory, mut work) = (vec![0.0; sizes.scene], vec![0.0; sizes.work]);
    let (mut state, mut loads) = (vec![0.0; sizes.state], vec![0.0; sizes.loads]);
    let mut scene = Scene::bind(&parsed, &options, &mut memory, &mut work).expect("bound");
    let mut state = State::new(&scene, &mut state).expect("memory");
    let mut loads = Loads::new(&scene, &mut loads).expect("memory");
    let contact = Contact { nodes: [1, 4, 3], weights: [0.2, 0.5, 0.3], force: [1.0, -2.0, 0.7] };
    loads.add_contact(&scene, &contact).expect("contact");
    assert_eq!(scene.step(&mut state, &loads), Ok(Status::Moving));
    loads.clear();
    while scene.step(&mut state, &loads) == Ok(Status::Moving) {}
    // Zero is the rest of an unloaded body at every stiffness and density: nothing to wake for. A held load would have kept it awake.
    let other = SceneOptions { stiffness: 3.0, time_step: Some(2e-3), ..options };
    scene.rebind(&other, &mut work).expect("rebound");
    state.carry(&scene).expect("carried");
    assert_eq!(scene.step(&mut state, &loads), Ok(Status::AtRest));
    loads.add_contact(&scene, &Contact { force: [1e-30, 0.0, 0.0], ..contact }).expect("contact");
    assert_eq!(scene.step(&mut state, &loads), Ok(Status::Moving), "any load wakes, however small");
    // The smallest load leaves a motion below the threshold: with it gone the body rests at once.
    loads.clear();
    assert_eq!(scene.step(&mut state, &loads), Ok(Status::AtRest));
    scene.set(&mut state, &[1e-3; R], &[0.0; R], &loads).expect("set");
    assert_eq!(scene.step(&mut state, &loads), Ok(Status::Moving), "and so does a state");
}

/// Time of a thousand steps (fastest of ten) and whether the body rests at the end of `n`.
fn ring_down<T: Scalar>(structure: StructureChoice, alpha: f64, start: f64, n: usize) -> (f64, bool) {
    let options = SceneOptions { structure, ..SceneOptions::default() };
    with_scene::<T, _>(&file(1e-3, alpha).1, &options, |scene, state, loads| {
        let mut fastest = f64::MAX;
        for _ in 0..10 {
            state.restore(&[T::from_f64(start); 3 * R]).expect("start");
            let clock = Instant::now();
            for _ in 0..1000 {
                scene.step(state, loads).expect("step");
            }
            fastest = fastest.min(clock.elapsed().as_secs_f64());
        }
        let rests = (0..n).any(|_| scene.step(state, loads) == Ok(Status::AtRest));
        (fastest, rests)
    })
}

/// A body that rings down never meets denormal numbers, and comes to rest however lightly it is damped: there is a floor under the
/// numbers and a threshold above the floor.
#[test]
fn a_body_that_rings_down_neither_slows_down_nor_goes_on_for_ever() {
    for structure in STRUCTURES {
        for (alpha, n) in [(0.1, 400_000), (5.0, 100_000)] {
            let (normal, _) = ring_down::<f32>(structure, alpha, 1e-3, 0);
            // Above the threshold, and what a step leaves of it in the accelerations is at the floor.
            let (quiet, rests) = ring_down::<f32>(structure, alpha, 2e-18, n);
            println!("{structure:?}, alpha {alpha}: {:.1} times the time near the floor", quiet / normal);
            assert!(rests, "{structure:?}, alpha {alpha}: never rests");
            // Denormals cost ten times and more where they cost; three leaves room for a busy machine.
            assert!(quiet < 3.0 * normal, "{structure:?}: {quiet:e} s against {normal:e} s");
        }
    }
}

/// Loads of 1e±12 and denormal ones: the answer is the load's size, and the time is the same.
#[test]
fn the_size_of_a_load_changes_nothing_but_the_size_of_the_answer() {
    let (_, bytes) = file(1e-3, 1.0);
    for structure in STRUCTURES {
        let options = SceneOptions { structure, ..SceneOptions::default() };
        let run = |force: f64| {
            with_scene::<f64, _>(&bytes, &options, |scene, state, loads| {
                let contact =
                    Contact { nodes: [1, 4, 3], weights: [0.2, 0.5, 0.3], force: [force, 0.0, 0.0] };
                loads.add_contact(scene, &contact).expect("contact");
                let clock = Instant::now();
                for _ in 0..20_000 {
                    scene.step(state, loads).expect("step");
                }
                (clock.elapsed().as_secs_f64(), state.zeta().to_vec())
            })
        };
        let (_, one) = run(1.0);
        let normal = run(1.0).0.min(run(1.0).0);
        for power in [-40, 40] {
            // Powers of two: the bits must be the same.
            let size = 2f64.powi(power);
            assert!(run(size).1.iter().zip(&one).all(|(a, b)| *a == size * b), "{structure:?} 2^{power}");
        }
        // Denormal itself, or through the load map.
        for force in [5e-324, 1e-306, 1e-303] {
            let tiny = (0..3).fold(f64::MAX, |fastest, _| run(force).0.min(fastest));
            println!("{structure:?}: a load of {force:e} takes {:.1} times as long", tiny / normal);
            assert!(run(force).1.iter().all(|&z| z == 0.0), "below the floor");
            assert!(tiny < 3.0 * normal, "{structure:?}: {tiny:e} s against {normal:e} s");
        }
    }
}

#[test]
fn a_modal_march_rests_by_the_same_rule() {
    let (_, bytes) = file(1e-3, 30.0);
    let options =
        SceneOptions { structure: StructureChoice::Block, rest_below: 1e-6, ..SceneOptions::default() };
    with_scene::<f64, ()>(&bytes, &options, |scene, state, loads| {
        let sizes = Modal::sizes(scene);
        let (mut memory, mut work) = (vec![0.0; sizes.memory], vec![0.0; sizes.work]);
        let mut modal =
            Modal::bind(scene, 1.0, &mut memory, &mut work).expect("an open basis, taken all the same");
        scene.set(state, &[1e-3; R], &[0.0; R], loads).expect("set");
        let calls = (1..10_000).find(|_| modal.march(scene, state, loads, 10) == Ok(Status::AtRest));
        assert!(calls.is_some() && state.zeta().iter().all(|&z| z == 0.0));
    });
}
