//! The published problems of `docs/theory`: numbers printed elsewhere, reproduced to their digits.

use faer::{Mat, MatRef, mat};
use vademecum_format::scheme::{MAX_STAGES, SchemeTable};

use super::damping::{Rayleigh, numerical_damping};
use super::full_order::{FullOrder, State};
use super::schemes::{bathe, newmark};
use crate::fem::{Pencil, Symbolic};

/// Marches one trajectory from rest; `force(t)` is evaluated at the start and at each stage's instant.
pub(super) fn march(
    pencil: &Pencil,
    table: &SchemeTable,
    dt: f64,
    damping: Rayleigh,
    start: [&[f64]; 2],
    force: impl Fn(f64) -> Vec<f64>,
    steps: usize,
) -> Vec<State> {
    let n = pencil.n_dof();
    let symbolic = Symbolic::analyze(pencil).unwrap();
    let full = FullOrder::new(pencil, &symbolic, table, dt, damping).unwrap();
    let column = |x: &[f64]| Mat::from_fn(n, 1, |i, _| x[i]);
    let mut state = full
        .initial_state(
            column(start[0]).as_ref(),
            column(start[1]).as_ref(),
            Some(column(&force(0.0)).as_ref()),
        )
        .unwrap();
    let mut work = full.workspace(1, false);
    let mut states = vec![state.clone()];
    for step in 0..steps {
        let mut instants = [0.0; 1 + MAX_STAGES];
        for (instant, stage) in instants[1..].iter_mut().zip(&table.stages) {
            *instant = stage.time;
        }
        let forces = instants.map(|c| column(&force((step as f64 + c) * dt)));
        let loads: [Option<MatRef<'_, f64>>; 1 + MAX_STAGES] =
            std::array::from_fn(|i| Some(forces[i].as_ref()));
        full.step(&mut state, &loads, &mut work);
        states.push(state.clone());
    }
    states
}

fn two_dof() -> Pencil {
    let mass = mat![[2.0, 0.0], [0.0, 1.0]];
    let stiffness = mat![[6.0, -2.0], [-2.0, 4.0]];
    Pencil::from_matrices(mass.as_ref(), stiffness.as_ref()).unwrap()
}

fn two_dof_march(table: &SchemeTable, dt: f64, steps: usize) -> Vec<State> {
    let rest = [[0.0; 2]; 2];
    march(
        &two_dof(),
        table,
        dt,
        Rayleigh::default(),
        [&rest[0], &rest[1]],
        |_| vec![0.0, 10.0],
        steps,
    )
}

/// Equal to a number printed with six decimals.
fn assert_printed(state: &State, expected: [f64; 2], digit: f64) {
    for (i, value) in expected.into_iter().enumerate() {
        let found = state.displacement[(i, 0)];
        assert!(
            (found - value).abs() <= 0.5 * digit * (1.0 + 1e-9),
            "{found} is not the printed {value}"
        );
    }
}

#[test]
fn two_dof_problem_by_bathe_matches_the_printed_digits() {
    let states = two_dof_march(&bathe(), 0.28, 12);
    assert_printed(&states[1], [0.004576, 0.373228], 1e-6);
    assert_printed(&states[6], [1.618358, 5.312445], 1e-6);
    assert_printed(&states[12], [1.279425, 2.397547], 1e-6);
}

#[test]
fn two_dof_problem_by_the_trapezoidal_rule_matches_the_published_step() {
    let states = two_dof_march(&newmark(0.25, 0.5).unwrap(), 0.28, 12);
    assert_printed(&states[12], [1.40, 2.31], 1e-2);
}

#[test]
fn two_dof_problem_with_a_huge_step_goes_to_the_static_answer() {
    let states = two_dof_march(&bathe(), 28.0, 30);
    assert_printed(&states[1], [1.041138, 3.064947], 1e-6);
    // Each step leaves about 2 % of the distance; 30 steps leave nothing above rounding.
    assert_printed(&states[30], [1.0, 3.0], 1e-9);
}

/// Bathe and Noh (2012): a spring of 1e7 drives one of 1; the first mass moves with `sin 1.2 t`.
fn stiff_and_soft(table: &SchemeTable) -> Vec<State> {
    let (k1, k2) = (1e7, 1.0);
    let mass = mat![[1.0, 0.0], [0.0, 1.0]];
    let stiffness = mat![[k1 + k2, -k2], [-k2, k2]];
    let pencil = Pencil::from_matrices(mass.as_ref(), stiffness.as_ref()).unwrap();
    let rest = [[0.0; 2]; 2];
    let force = |t: f64| vec![k1 * (1.2 * t).sin(), 0.0];
    march(
        &pencil,
        table,
        0.2618,
        Rayleigh::default(),
        [&rest[0], &rest[1]],
        force,
        40,
    )
}

#[test]
fn bathe_damps_the_stiff_spring_at_once() {
    let states = stiff_and_soft(&bathe());
    let acceleration = |s: &State| s.dt2_acceleration[(0, 0)] / 0.2618_f64.powi(2);
    assert!((states[40].displacement[(1, 0)] + 2.269068).abs() < 0.5e-6);
    assert!((acceleration(&states[1]) + 23.3).abs() < 0.05);
    // u2 follows u1, whose acceleration is at most 1.44; the method's own transient is over after a few steps.
    assert!(
        states[5..]
            .iter()
            .all(|s| acceleration(s).abs() < 2.0 * 1.44)
    );
}

#[test]
fn the_trapezoidal_rule_lets_the_stiff_spring_ring() {
    let states = stiff_and_soft(&newmark(0.25, 0.5).unwrap());
    let largest = states
        .iter()
        .map(|s| s.dt2_acceleration[(0, 0)] / 0.2618_f64.powi(2))
        .fold(0.0, |w: f64, a| if a.abs() > w.abs() { a } else { w });
    println!("trapezoidal rule, stiff and soft springs: largest a2 = {largest:.1}");
    assert!((largest + 735.0).abs() < 0.5);
}

#[test]
fn one_oscillator_by_bathe_matches_the_reference_table() {
    let path = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../../shared/reference/bathe-sdof.csv"
    );
    let Ok(text) = std::fs::read_to_string(path) else {
        println!("skipped: no {path}");
        return;
    };
    for line in text.lines().skip(1) {
        let printed: Vec<f64> = line.split(',').map(|x| x.parse().unwrap()).collect();
        let omega_dt = std::f64::consts::TAU * printed[0];
        let found = numerical_damping(&bathe(), omega_dt, 0.0);
        let (ratio, elongation) = (found.ratio.unwrap(), found.period_elongation.unwrap());
        assert!(
            (found.spectral_radius - printed[1]).abs() < 0.51e-8,
            "{line}"
        );
        assert!((100.0 * elongation - printed[2]).abs() < 0.51e-6, "{line}");
        // Amplitude lost per computed period: 1 − exp(−2π ζ/√(1−ζ²)).
        let decay = 1.0 - (-std::f64::consts::TAU * ratio / (1.0 - ratio * ratio).sqrt()).exp();
        assert!((100.0 * decay - printed[3]).abs() < 0.51e-6, "{line}");
        let rule = numerical_damping(&newmark(0.25, 0.5).unwrap(), omega_dt, 0.0);
        assert!(
            (100.0 * rule.period_elongation.unwrap() - printed[4]).abs() < 0.51e-6,
            "{line}"
        );
    }
}
