//! A body at rest: the energy its rest takes away, what wakes it, and that quiet bodies do rest and meet no
//! denormal number before.

use vademecum_eval::{Contact, Loads, Place, Scalar, Scene, SceneOptions, State, Status, StructureChoice};
use vademecum_format::scheme::StepParameters;
use vademecum_format::{Element, File};
use vademecum_tests::denormals::{Denormals, watch};
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

/// Decays from random states under random damping to random thresholds: the twin that never rests shows what
/// was dropped.
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
                // ½ s_K λ_min |ζ|² ≤ E, and the energy of a free run stays within 1 + 1e-6 of its start (the
                // certificate's limit).
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
    let contact = Contact::new(Place::triangle([1, 4, 3], [0.2, 0.5, 0.3]), [1.0, -2.0, 0.7]);
    loads.add_contact(&scene, &contact).expect("contact");
    assert_eq!(scene.step(&mut state, &loads), Ok(Status::Moving));
    loads.clear();
    while scene.step(&mut state, &loads) == Ok(Status::Moving) {}
    // Zero is the rest of an unloaded body at every stiffness and density: nothing to wake for. A held load
    // would have kept it awake.
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

/// Whether all numbers of a state are zero or normal.
fn normal<T: Scalar>(state: &State<'_, T>) -> bool {
    let mut numbers = [T::ZERO; 3 * R];
    state.save_into(&mut numbers).expect("length");
    let smallest = if size_of::<T>() == 4 { f64::from(f32::MIN_POSITIVE) } else { f64::MIN_POSITIVE };
    numbers.iter().all(|x| x.to_f64() == 0.0 || x.to_f64().abs() >= smallest)
}

/// Steps from a state where all numbers are `start` until the body rests, and tells after how many steps it
/// does.
///
/// # Panics
/// If a step takes or gives a denormal number, or the body does not rest within `n` steps.
fn ring_down<T: Scalar>(structure: StructureChoice, alpha: f64, start: f64, n: usize) -> usize {
    let options = SceneOptions { structure, ..SceneOptions::default() };
    with_scene::<T, _>(&file(1e-3, alpha).1, &options, |scene, state, loads| {
        state.restore(&[T::from_f64(start); 3 * R]).expect("start");
        let (mut steps, mut status) = (0, Status::Moving);
        let seen = watch(|| {
            while status == Status::Moving && steps < n {
                status = scene.step(state, loads).expect("step");
                steps += 1;
                assert!(normal(state), "{structure:?}, alpha {alpha}: step {steps} leaves a denormal state");
            }
        });
        assert_ne!(seen, Denormals::Met, "{structure:?}, alpha {alpha}: a step met denormal numbers");
        assert_eq!(status, Status::AtRest, "{structure:?}, alpha {alpha}: does not rest in {n} steps");
        steps
    })
}

/// A body that rings down never meets denormal numbers, and comes to rest however lightly it is damped: there
/// is a floor under the numbers and a threshold above the floor. A step that meets no denormal number costs
/// what every step costs.
#[test]
fn a_body_that_rings_down_meets_no_denormals_and_does_not_go_on_for_ever() {
    // From an ordinary amplitude, and from just above the threshold, where a step leaves accelerations at the
    // floor.
    for (alpha, start, n) in [(5.0, 1e-3, 100_000), (5.0, 2e-18, 100_000), (0.1, 2e-18, 400_000)] {
        for structure in STRUCTURES {
            let steps = ring_down::<f32>(structure, alpha, start, n);
            println!("{structure:?}, alpha {alpha}, from {start:e}: rests after {steps} steps");
        }
    }
}

/// Loads of 1e±12 and denormal ones: the answer is the load's size, and no denormal number reaches a state.
#[test]
fn the_size_of_a_load_changes_nothing_but_the_size_of_the_answer() {
    let (_, bytes) = file(1e-3, 1.0);
    for structure in STRUCTURES {
        let options = SceneOptions { structure, ..SceneOptions::default() };
        let run = |force: f64, each: &mut dyn FnMut(&State<'_, f64>)| {
            with_scene::<f64, _>(&bytes, &options, |scene, state, loads| {
                let contact = Contact::new(Place::triangle([1, 4, 3], [0.2, 0.5, 0.3]), [force, 0.0, 0.0]);
                loads.add_contact(scene, &contact).expect("contact");
                let seen = watch(|| {
                    for _ in 0..20_000 {
                        scene.step(state, loads).expect("step");
                        each(state);
                    }
                });
                assert!(normal(state), "{structure:?}: {force:e} gives a denormal state");
                (seen, state.zeta().to_vec())
            })
        };
        let (_, one) = run(1.0, &mut |_| ());
        for power in [-40, 40] {
            // Powers of two: the bits must be the same.
            let size = 2f64.powi(power);
            let (seen, found) = run(size, &mut |_| ());
            assert_ne!(seen, Denormals::Met, "{structure:?} 2^{power}");
            assert!(found.iter().zip(&one).all(|(a, b)| *a == size * b), "{structure:?} 2^{power}");
        }
        // Denormal itself, or through the load map. Such a load is an addend of the step's sums and nothing
        // else: what comes out is zero at every step, so that no product of the next one has a denormal
        // operand.
        for force in [5e-324, 1e-306, 1e-303] {
            run(force, &mut |state| {
                let mut numbers = [1.0; 3 * R];
                state.save_into(&mut numbers).expect("length");
                assert!(numbers.iter().all(|&x| x == 0.0), "{structure:?}: {force:e} is not below the floor");
            });
        }
    }
}
