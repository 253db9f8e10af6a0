//! The exact step of a mode against 60-digit arithmetic, and over many steps.

use vademecum_eval::{Batch, Loads, Scalar, Scene, SceneOptions, State, StepError, StructureChoice};
use vademecum_format::exact::{Propagator, product_error};
use vademecum_format::{File, SectionKind};
use vademecum_tests::stage::with_work;

/// What `tests/scripts/propagator.py` made.
const REFERENCE: &str =
    include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/../fixtures/reference/propagator.csv"));

/// Two parts of a row: `D`, and the answers to loads.
fn parts(p: &Propagator) -> [Vec<f64>; 3] {
    [p.d.to_vec(), p.held.to_vec(), p.rising.to_vec()]
}

#[test]
fn the_error_of_a_product_is_that_of_a_fused_one() {
    let mut state = 0x9e37_79b9_7f4a_7c15u64;
    let mut number = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        // Any digits, from 2^-100 to 2^100, of both signs.
        let exponent = 923 + (state >> 40) % 200;
        f64::from_bits((state & (1 << 63)) | (exponent << 52) | (state >> 7 & ((1 << 52) - 1)))
    };
    for _ in 0..100_000 {
        let (a, b) = (number(), number());
        assert_eq!(product_error(a, b), a.mul_add(b, -(a * b)), "{a:e} {b:e}");
    }
}

#[test]
fn a_step_is_exact_to_rounding() {
    let mut worst = [0.0f64; 3];
    let mut rows = 0;
    for line in REFERENCE.lines().skip(1) {
        let numbers: Vec<f64> = line.split(',').map(|number| number.parse().unwrap()).collect();
        let [lambda, sigma, ..] = numbers[..] else { panic!("{line}") };
        let found = parts(&Propagator::new(lambda, sigma, 1.0));
        let expected = [&numbers[2..6], &numbers[6..8], &numbers[8..10]];
        for ((found, expected), worst) in found.iter().zip(expected).zip(&mut worst) {
            let norm = expected.iter().map(|x| x * x).sum::<f64>().sqrt();
            let by = found.iter().zip(expected).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt();
            assert!(by <= 1e-14 * norm, "lambda {lambda:e} sigma {sigma:e}: {found:?} {expected:?}");
            *worst = worst.max(by / norm);
        }
        rows += 1;
    }
    assert_eq!(rows, 450);
    println!(
        "worst relative to the norm: D {:.1e}, held {:.1e}, rising {:.1e}",
        worst[0], worst[1], worst[2]
    );
}

#[test]
fn a_step_in_other_units_is_the_same_step() {
    // λ, σ and Δt reach the step through λΔt² and σΔt; loads are scaled by Δt².
    let (lambda, sigma, dt) = (7.0, 0.3, 0.25);
    let [ours, unit] =
        [Propagator::new(lambda, sigma, dt), Propagator::new(lambda * dt * dt, sigma * dt, 1.0)];
    assert_eq!(ours.d, unit.d);
    assert_eq!(ours.held, unit.held.map(|x| dt * dt * x));
    assert_eq!(ours.rising, unit.rising.map(|x| dt * dt * x));
}

const BODY: &[u8] = include_bytes!(concat!(env!("CARGO_MANIFEST_DIR"), "/../fixtures/golden/fixed-f64.vdm"));

/// A scene of the golden body that is moved exactly, without damping unless `options` say otherwise.
fn with_exact<T: Scalar, R>(
    options: SceneOptions,
    work: impl FnOnce(&mut Scene<'_, T>, &mut State<'_, T>, &mut Loads<'_, T>, &mut [f64]) -> R,
) -> R {
    let options = SceneOptions { structure: StructureChoice::Exact, ..options };
    with_work(BODY, &options, work)
}

fn undamped() -> SceneOptions {
    SceneOptions { alpha: Some(0.0), beta: Some(0.0), ..SceneOptions::default() }
}

fn lambdas() -> Vec<f64> {
    let file = File::parse(BODY).unwrap();
    file.section(SectionKind::Eigenvalues).unwrap().numbers().unwrap().iter().collect()
}

/// Velocities of which every mode has the same energy.
fn start<T: Scalar>(scene: &Scene<'_, T>, state: &mut State<'_, T>, loads: &Loads<'_, T>) {
    scene.set(state, &[0.0; 3], &[1.0; 3], loads).unwrap();
}

#[test]
fn a_free_mode_goes_where_the_closed_form_says() {
    with_exact::<f64, _>(undamped(), |scene, state, loads, _| {
        start(scene, state, loads);
        let dt = scene.parameters().time_step;
        for step in 1..=1000 {
            scene.step(state, loads).unwrap();
            for (zeta, lambda) in state.zeta().iter().zip(lambdas()) {
                let omega = lambda.sqrt();
                let expected = (omega * dt * f64::from(step)).sin() / omega;
                // A thousand steps of rounding.
                assert!((zeta - expected).abs() * omega < 1e-11, "step {step}: {zeta} {expected}");
            }
        }
    });
}

#[test]
fn a_held_load_and_a_ramp_are_exact() {
    let alpha = 2.0;
    let options = SceneOptions { alpha: Some(alpha), beta: Some(0.0), ..SceneOptions::default() };
    with_exact::<f64, _>(options, |scene, state, loads, _| {
        let dt = scene.parameters().time_step;
        assert_eq!(scene.instants()[..2], [0.0, 1.0]);
        // A ramp over twenty steps in pieces; BᵀF of the pattern from the closed form at rest.
        for step in 0..20 {
            let [from, to] = [step, step + 1].map(|n| f64::from(n) / 20.0);
            loads.clear();
            loads.add_pattern_staged(scene, 0, &[from, to, 0.0, 0.0]).unwrap();
            scene.step(state, loads).unwrap();
        }
        let file = File::parse(BODY).unwrap();
        let pattern: Vec<f64> =
            file.section(SectionKind::PatternBasis).unwrap().numbers().unwrap().iter().collect();
        for ((zeta, lambda), force) in state.zeta().iter().zip(lambdas()).zip(pattern) {
            let whole = Propagator::new(lambda, 0.5 * alpha, 20.0 * dt);
            let expected = force * whole.rising[0];
            assert!((zeta / expected - 1.0).abs() < 1e-12, "{zeta} {expected}");
        }
    });
}

#[test]
fn energy_is_kept_over_a_hundred_million_steps() {
    let energy_after = |steps: usize| {
        with_exact::<f64, _>(undamped(), |scene, state, loads, _| {
            start(scene, state, loads);
            let before = scene.energy(state).unwrap();
            let mut largest = before;
            for step in 0..steps {
                scene.step(state, loads).unwrap();
                if step % 1_000_000 == 0 {
                    largest = f64::max(largest, scene.energy(state).unwrap());
                }
            }
            [scene.energy(state).unwrap() / before - 1.0, largest / before - 1.0]
        })
    };
    let [drift, largest] = energy_after(100_000_000);
    println!("f64, 1e8 steps: energy at the end 1 {drift:+.1e}, largest 1 {largest:+.1e}");
    assert!(drift.abs() < 1e-9 && largest < 1e-9);
}

#[test]
fn single_precision_stays_bounded_and_beside_double() {
    let run = |steps: usize| {
        with_exact::<f32, _>(undamped(), |scene, state, loads, _| {
            start(scene, state, loads);
            let before = scene.energy(state).unwrap();
            let mut largest = 0.0f64;
            for step in 0..steps {
                scene.step(state, loads).unwrap();
                if step % 100_000 == 0 {
                    largest = largest.max(scene.energy(state).unwrap() / before);
                }
            }
            largest
        })
    };
    let largest = run(100_000_000);
    println!("f32, 1e8 steps: largest energy {largest}");
    assert!(largest < 1.0 + 1e-3);
    let single = with_exact::<f32, _>(undamped(), |scene, state, loads, _| march(scene, state, loads));
    let double = with_exact::<f64, _>(undamped(), |scene, state, loads, _| march(scene, state, loads));
    let norm = double.iter().map(|x| x * x).sum::<f64>().sqrt();
    let by = single.iter().zip(&double).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt();
    println!("f32 beside f64 after 2e5 steps: {:.1e}", by / norm);
    assert!(by <= 1e-3 * norm);
}

/// `ζ` after two hundred thousand free steps: a displacement whose length is that of the mass norm.
fn march<T: Scalar>(scene: &Scene<'_, T>, state: &mut State<'_, T>, loads: &Loads<'_, T>) -> Vec<f64> {
    start(scene, state, loads);
    for _ in 0..200_000 {
        scene.step(state, loads).unwrap();
    }
    state.zeta().iter().map(|z| z.to_f64()).collect()
}

#[test]
fn instances_of_a_batch_have_the_bits_of_a_single_body() {
    with_exact::<f32, _>(SceneOptions::default(), |scene, state, loads, _| {
        let mut memory = vec![0.0; Batch::len_for(scene, 20)];
        let mut batch = Batch::new(scene, 20, &mut memory).unwrap();
        loads.add_pattern(scene, 0, 1.0).unwrap();
        batch.load(scene, 17, loads).unwrap();
        for _ in 0..50 {
            let status = batch.step(scene).unwrap();
            assert_eq!((status.moving, status.at_rest), (1, 19));
            scene.step(state, loads).unwrap();
        }
        let (zeta, rates) = (state.zeta().to_vec(), state.scaled_velocity().to_vec());
        batch.get(17, state).unwrap();
        assert_eq!((state.zeta(), state.scaled_velocity()), (&zeta[..], &rates[..]));
        assert!(state.scaled_acceleration().is_empty());
    });
}

#[test]
fn stiffness_density_and_step_stay_live() {
    with_exact::<f64, _>(undamped(), |scene, state, loads, work| {
        let options =
            SceneOptions { stiffness: 4.0, density: 2.0, time_step: Some(2e-3), ..*scene.options() };
        scene.rebind(&options, work).unwrap();
        state.carry(scene).unwrap();
        start(scene, state, loads);
        for _ in 0..10 {
            scene.step(state, loads).unwrap();
        }
        for (zeta, lambda) in state.zeta().iter().zip(lambdas()) {
            let omega = (2.0 * lambda).sqrt();
            assert!((zeta - (omega * 0.02).sin() / omega).abs() * omega < 1e-13);
        }
        // A static answer is F/(s_K λ), whatever the density.
        scene.rebind(&SceneOptions { alpha: Some(1e4), ..options }, work).unwrap();
        state.rest();
        loads.add_pattern(scene, 0, 1.0).unwrap();
        (0..200_000).for_each(|_| {
            scene.step(state, loads).unwrap();
        });
        let file = File::parse(BODY).unwrap();
        let pattern = file.section(SectionKind::PatternBasis).unwrap().numbers().unwrap();
        for ((zeta, lambda), force) in state.zeta().iter().zip(lambdas()).zip(pattern.iter()) {
            assert!((zeta * 4.0 * lambda / force - 1.0).abs() < 1e-9, "{zeta} {lambda} {force}");
        }
    });
}

#[test]
fn a_state_is_saved_and_restored_with_every_bit() {
    with_exact::<f64, _>(SceneOptions::default(), |scene, state, loads, _| {
        loads.add_pattern(scene, 0, 1.0).unwrap();
        scene.step(state, loads).unwrap();
        let mut saved = vec![0.0; 2 * scene.n_modes()];
        state.save_into(&mut saved).unwrap();
        scene.step(state, loads).unwrap();
        let once = state.zeta().to_vec();
        state.restore(&saved).unwrap();
        scene.step(state, loads).unwrap();
        assert_eq!(state.zeta(), once);
        assert_eq!(state.save_into(&mut [0.0; 9]), Err(StepError::Mismatch));
    });
}
