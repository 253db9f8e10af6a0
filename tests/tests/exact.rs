//! The exact step of a mode against 60-digit arithmetic, and over many steps.

use vademecum_format::exact::Propagator;

/// What `tests/scripts/propagator.py` made.
const REFERENCE: &str =
    include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/../fixtures/reference/propagator.csv"));

/// Two parts of a row: `D`, and the answers to loads.
fn parts(p: &Propagator) -> [Vec<f64>; 3] {
    [p.d.to_vec(), p.held.to_vec(), p.rising.to_vec()]
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
