//! The solvers without a file against the fused step, and the exact motion of a mode against closed forms.

use faer::{Mat, MatRef};
use vademecum_format::scheme::{SchemeTable, StepParameters, fuse_into, fuse_work_len, theta};

use super::staged::{ReducedSolver, play};
use super::{DenseGalerkin, ExactModes, TwoStage};
use vademecum_build::basis::{Basis, modes_basis};
use vademecum_build::dynamics::Interval;
use vademecum_build::dynamics::Rayleigh;
use vademecum_build::dynamics::schemes::{bathe, generalized_alpha};
use vademecum_build::dynamics::{TimedLoad, factors, stage_amplitudes};
use vademecum_build::linalg::project;
use vademecum_build::response::StageResponse;

/// The stages one after the other, with dense solves and with responses, and fused are one march; damped,
/// loaded, released within a step.
#[test]
fn stages_one_after_the_other_agree_with_the_fused_step() {
    let stiffness = faer::mat![[5.0, -2.0, 0.3], [-2.0, 4.0, 0.1], [0.3, 0.1, 30.0]];
    let vectors = Mat::identity(3, 3);
    let basis = Basis { vectors, stiffness, eigenvalues: None, energy: vec![], singular_values: vec![] };
    let (dt, damping) = (0.1, Rayleigh { alpha: 0.3, beta: 0.02 });
    let parameters = StepParameters {
        time_step: dt,
        alpha: damping.alpha,
        beta: damping.beta,
        density: 1.0,
        stiffness: 1.0,
    };
    let when = Interval { start: 0.0, end: 1.05, ramp: 0.2 };
    let loads = [TimedLoad { column: 0, force: vec![1.0, -2.0, 0.5], when: when.into() }];
    for table in [bathe(), generalized_alpha(0.8).expect("sound")] {
        let responses = responses(&basis, &table, &parameters);
        let fused = play_fused(&basis, &responses, &table, &parameters, &loads[0], 100);
        let scale = fused.norm_max();
        assert!(scale > 0.1);
        let staged = TwoStage::new(basis.vectors.as_ref(), &responses, &table, &parameters).expect("sound");
        let solvers: [&dyn ReducedSolver; 2] = [&DenseGalerkin::new(&basis, &table, dt, damping), &staged];
        for solver in solvers {
            // 100 steps of some hundred roundings each, in random order.
            assert!((&play(solver, &loads, 100) - &fused).norm_max() <= 1e4 * f64::EPSILON * scale);
        }
    }
}

fn responses(basis: &Basis, table: &SchemeTable, parameters: &StepParameters) -> Vec<StageResponse> {
    let response = |i| {
        let theta = theta(table, parameters, i).expect("sound");
        StageResponse::galerkin(basis.vectors.as_ref(), basis.stiffness.as_ref(), theta)
    };
    (0..table.active().len()).map(response).collect()
}

fn play_fused(
    basis: &Basis,
    responses: &[StageResponse],
    table: &SchemeTable,
    parameters: &StepParameters,
    load: &TimedLoad,
    steps: usize,
) -> Mat<f64> {
    let (dt, stages) = (parameters.time_step, responses.len());
    let states: Vec<f64> =
        responses.iter().flat_map(|s| (0..9).map(|k| s.state[(k / 3, k % 3)]).collect::<Vec<_>>()).collect();
    let (mut increment, mut load_maps) = (vec![0.0; 81], vec![0.0; 27 * stages]);
    let mut work = vec![0.0; fuse_work_len(3)];
    fuse_into(table, parameters, 3, &states, &mut increment, &mut load_maps, &mut work).expect("fused");
    let base = project(basis.vectors.as_ref(), &load.force);
    let mut y = Mat::<f64>::zeros(9, 1);
    let start = load.when.factor(0.0) * dt * dt;
    (0..3).for_each(|k| y[(6 + k, 0)] = start * load.force[k]);
    Mat::from_fn(3, steps + 1, |k, instant| {
        if k == 0 && instant > 0 {
            let amplitudes = stage_amplitudes(table, &factors(table, dt, instant - 1, &load.when));
            let mut new = &y + MatRef::from_column_major_slice(&increment, 9, 9) * &y;
            for (i, stage) in responses.iter().enumerate() {
                let own = project(stage.increment.as_ref(), &load.force);
                let g = Mat::from_fn(3, 1, |k, _| amplitudes[i] * (base[k] + own[k]));
                new += MatRef::from_column_major_slice(&load_maps[27 * i..27 * (i + 1)], 9, 3) * g;
            }
            y = new;
        }
        y[(k, 0)]
    })
}

fn one_mode(eigenvalue: f64, dt: f64, damping: Rayleigh) -> ExactModes {
    ExactModes::new(&modes_basis(Mat::identity(1, 1), vec![eigenvalue]), dt, damping)
}

fn load(when: Interval) -> [TimedLoad; 1] {
    [TimedLoad { column: 0, force: vec![2.0], when: when.into() }]
}

/// `q = f/λ (1 − cos ωt)`, and after the release at `T` minus the same from there on.
#[test]
fn a_mode_under_a_held_and_released_force_is_the_closed_form() {
    let (eigenvalue, dt, steps) = (9.0, 0.4, 50);
    let end = 20.0 * dt;
    let found = play(
        &one_mode(eigenvalue, dt, Rayleigh { alpha: 0.0, beta: 0.0 }),
        &load(Interval { start: 0.0, end, ramp: 0.0 }),
        steps,
    );
    let held = |t: f64| if t > 0.0 { 2.0 / eigenvalue * (1.0 - (3.0 * t).cos()) } else { 0.0 };
    for step in 0..=steps {
        let t = step as f64 * dt;
        // Some roundings of numbers of size 1 per step.
        let bound = 20.0 * (steps as f64) * f64::EPSILON;
        assert!((found[(0, step)] - (held(t) - held(t - end))).abs() <= bound, "step {step}");
    }
}

/// A ramp met by steps of any length is one motion, whatever the damping: less than, at, and above critical.
#[test]
fn the_length_of_the_step_does_not_matter() {
    for alpha in [0.0, 0.5, 6.0, 60.0] {
        let damping = Rayleigh { alpha, beta: 0.0 };
        let when = Interval { start: 0.0, end: 4.0, ramp: 2.0 };
        let [coarse, fine] = [1, 8]
            .map(|split: usize| play(&one_mode(9.0, 0.5 / split as f64, damping), &load(when), 16 * split));
        for step in 0..=16 {
            let (a, b) = (coarse[(0, step)], fine[(0, 8 * step)]);
            // The load's instants are read with one part in 1e9 of the time.
            assert!((a - b).abs() <= 1e-8, "alpha {alpha}, step {step}: {a} {b}");
        }
    }
}
