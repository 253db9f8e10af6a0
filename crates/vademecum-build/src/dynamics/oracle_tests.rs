//! The published problems of `docs/explanation`: numbers printed elsewhere, reproduced to their digits.

use faer::{Mat, MatRef, mat};
use vademecum_format::scheme::{MAX_STAGES, SchemeTable};

use super::damping::{Damping, DampingError, Rayleigh, numerical_damping, step_matrix};
use super::full_order::{FullOrder, FullOrderError, State};
use super::modes::lowest_modes;
use super::natural::Modes;
use super::schemes::{bathe, generalized_alpha, hht_alpha, newmark, rho_bathe};
use crate::fem::test_mesh::{block, hold};
use crate::fem::{Material, Model, Pencil, Symbolic};

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
    march(&two_dof(), table, dt, Rayleigh::default(), [&rest[0], &rest[1]], |_| vec![0.0, 10.0], steps)
}

/// Equal to a number printed with six decimals.
fn assert_printed(state: &State, expected: [f64; 2], digit: f64) {
    for (i, value) in expected.into_iter().enumerate() {
        let found = state.displacement[(i, 0)];
        assert!((found - value).abs() <= 0.5 * digit * (1.0 + 1e-9), "{found} is not the printed {value}");
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
    march(&pencil, table, 0.2618, Rayleigh::default(), [&rest[0], &rest[1]], force, 40)
}

#[test]
fn bathe_damps_the_stiff_spring_at_once() {
    let states = stiff_and_soft(&bathe());
    let acceleration = |s: &State| s.dt2_acceleration[(0, 0)] / 0.2618_f64.powi(2);
    assert!((states[40].displacement[(1, 0)] + 2.269068).abs() < 0.5e-6);
    assert!((acceleration(&states[1]) + 23.3).abs() < 0.05);
    // u2 follows u1, whose acceleration is at most 1.44; the method's own transient is over after a few
    // steps.
    assert!(states[5..].iter().all(|s| acceleration(s).abs() < 2.0 * 1.44));
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
    // `tests/scripts/bathe-sdof` made it, from the two sub-steps as printed.
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/reference/bathe-sdof.csv");
    let text = std::fs::read_to_string(path).unwrap();
    assert_eq!(text.lines().count(), 1 + 8);
    for line in text.lines().skip(1) {
        let printed: Vec<f64> = line.split(',').map(|x| x.parse().unwrap()).collect();
        let omega_dt = std::f64::consts::TAU * printed[0];
        let found = numerical_damping(&bathe(), omega_dt, 0.0);
        let (ratio, elongation) = (found.ratio.unwrap(), found.period_elongation.unwrap());
        assert!((found.spectral_radius - printed[1]).abs() < 0.51e-8, "{line}");
        assert!((100.0 * elongation - printed[2]).abs() < 0.51e-6, "{line}");
        // Amplitude lost per computed period: 1 − exp(−2π ζ/√(1−ζ²)).
        let decay = 1.0 - (-std::f64::consts::TAU * ratio / (1.0 - ratio * ratio).sqrt()).exp();
        assert!((100.0 * decay - printed[3]).abs() < 0.51e-6, "{line}");
        let rule = numerical_damping(&newmark(0.25, 0.5).unwrap(), omega_dt, 0.0);
        assert!((100.0 * rule.period_elongation.unwrap() - printed[4]).abs() < 0.51e-6, "{line}");
    }
}

/// Largest errors of displacement and velocity up to `t = 2` on the damped two-dof problem whose exact motion
/// is `u = (sin t, cos 2t)`.
fn errors_in_dt(table: &SchemeTable, dt: f64) -> [f64; 2] {
    let damping = Rayleigh { alpha: 0.1, beta: 0.02 };
    let motion = |t: f64| {
        let u = [t.sin(), (2.0 * t).cos()];
        let v = [t.cos(), -2.0 * (2.0 * t).sin()];
        (u, v, [-u[0], -4.0 * u[1]])
    };
    let force = |t: f64| {
        let (u, v, a) = motion(t);
        let mass = [2.0, 1.0];
        let k = |x: [f64; 2]| [6.0 * x[0] - 2.0 * x[1], -2.0 * x[0] + 4.0 * x[1]];
        (0..2).map(|i| mass[i] * (a[i] + 0.1 * v[i]) + 0.02 * k(v)[i] + k(u)[i]).collect()
    };
    let (u, v, _) = motion(0.0);
    let steps = (2.0 / dt).round() as usize;
    let states = march(&two_dof(), table, dt, damping, [&u, &v], force, steps);
    let mut worst = [0.0_f64; 2];
    for (step, state) in states.iter().enumerate() {
        let (u, v, _) = motion(step as f64 * dt);
        for i in 0..2 {
            worst[0] = worst[0].max((state.displacement[(i, 0)] - u[i]).abs());
            worst[1] = worst[1].max((state.dt_velocity[(i, 0)] / dt - v[i]).abs());
        }
    }
    worst
}

#[test]
fn every_scheme_is_of_second_order() {
    let schemes = [
        ("Bathe", bathe()),
        ("rho-Bathe 0", rho_bathe(0.0).unwrap()),
        ("rho-Bathe 0.5", rho_bathe(0.5).unwrap()),
        ("rho-Bathe 1", rho_bathe(1.0).unwrap()),
        ("trapezoidal", newmark(0.25, 0.5).unwrap()),
        ("HHT -0.1", hht_alpha(-0.1).unwrap()),
        ("generalized 0", generalized_alpha(0.0).unwrap()),
        ("generalized 0.5", generalized_alpha(0.5).unwrap()),
        ("generalized 1", generalized_alpha(1.0).unwrap()),
    ];
    for (name, table) in schemes {
        let [coarse, fine] = [0.01, 0.005].map(|dt| errors_in_dt(&table, dt));
        let slopes: Vec<f64> = coarse.iter().zip(fine).map(|(c, f)| (c / f).log2()).collect();
        println!(
            "{name}: u {:.2e}, v {:.2e} at 0.005 s; orders {:.3}, {:.3}",
            fine[0], fine[1], slopes[0], slopes[1]
        );
        assert!(slopes.iter().all(|s| (s - 2.0).abs() < 0.1), "{name} {slopes:?}");
    }
    // Newmark with γ > ½ pays for its damping with the order.
    let [coarse, fine] = [0.01, 0.005].map(|dt| errors_in_dt(&newmark(0.3025, 0.6).unwrap(), dt)[0]);
    assert!(((coarse / fine).log2() - 1.0).abs() < 0.1);
}

#[test]
fn bathe_damps_low_modes_by_its_asymptotic_formula() {
    // Period elongation Ω²/24, ratio Ω³/288, 1 − ρ = Ω⁴/288, each up to a relative O(Ω²).
    for omega in [0.05, 0.1, 0.2] {
        let found = numerical_damping(&bathe(), omega, 0.0);
        let near = |x: f64, y: f64| (x / y - 1.0).abs() < omega * omega;
        assert!(near(found.period_elongation.unwrap(), omega.powi(2) / 24.0));
        assert!(near(found.ratio.unwrap(), omega.powi(3) / 288.0));
        assert!(near(1.0 - found.spectral_radius, omega.powi(4) / 288.0));
    }
}

#[test]
fn high_frequencies_are_damped_as_asked() {
    // At Ω = 1e6 the remainder is O(1/Ω); a double root (ρ∞-Bathe, generalized-α) splits by its square root.
    let at_infinity = |table: SchemeTable| numerical_damping(&table, 1e6, 0.0).spectral_radius;
    for rho in [0.0, 0.25, 0.5, 0.9, 1.0] {
        for table in [rho_bathe(rho).unwrap(), generalized_alpha(rho).unwrap()] {
            assert!((at_infinity(table) - rho).abs() < 1e-2, "{rho} {}", at_infinity(table));
        }
    }
    assert!(at_infinity(bathe()) < 1e-2);
    assert!((at_infinity(newmark(0.25, 0.5).unwrap()) - 1.0).abs() < 1e-12);
    // HHT tends to (1 + α)/(1 − α).
    assert!((at_infinity(hht_alpha(-0.1).unwrap()) - 0.9 / 1.1).abs() < 1e-2);
}

#[test]
fn no_scheme_amplifies_any_oscillator() {
    for table in [
        bathe(),
        rho_bathe(0.5).unwrap(),
        newmark(0.25, 0.5).unwrap(),
        newmark(0.5, 0.6).unwrap(),
        hht_alpha(-0.3).unwrap(),
        generalized_alpha(0.8).unwrap(),
    ] {
        for exponent in -30..=40 {
            for ratio in [0.0, 0.05, 0.9] {
                let radius =
                    numerical_damping(&table, 10f64.powf(0.1 * f64::from(exponent)), ratio).spectral_radius;
                assert!(radius <= 1.0 + 1e-12, "{radius}");
            }
        }
    }
}

#[test]
fn the_march_follows_the_step_matrix_of_one_oscillator() {
    let (omega, ratio, dt) = (7.0_f64, 0.03, 0.05);
    let pencil = Pencil::from_matrices(mat![[2.0]].as_ref(), mat![[2.0 * omega * omega]].as_ref()).unwrap();
    // ζ = βω/2 from the stiffness alone.
    let damping = Rayleigh { alpha: 0.0, beta: 2.0 * ratio / omega };
    for table in [bathe(), rho_bathe(0.4).unwrap(), hht_alpha(-0.2).unwrap(), generalized_alpha(0.3).unwrap()]
    {
        let states = march(&pencil, &table, dt, damping, [&[1.0], &[2.0]], |_| vec![0.0], 20);
        let t = step_matrix(&table, omega * dt, ratio);
        let read = |s: &State| [s.displacement[(0, 0)], s.dt_velocity[(0, 0)], s.dt2_acceleration[(0, 0)]];
        let mut y = read(&states[0]);
        for state in &states[1..] {
            y = t.map(|row| row[0] * y[0] + row[1] * y[1] + row[2] * y[2]);
            let found = read(state);
            // Two orders of summing the same few terms, 20 steps long.
            assert!((0..3).all(|i| (found[i] - y[i]).abs() < 1e-14 * 20.0));
        }
    }
}

#[test]
fn initial_acceleration_balances_the_forces() {
    let pencil = two_dof();
    let symbolic = Symbolic::analyze(&pencil).unwrap();
    let damping = Rayleigh { alpha: 0.5, beta: 0.25 };
    let full = FullOrder::new(&pencil, &symbolic, &bathe(), 0.1, damping).unwrap();
    let (u, v, f) = (mat![[1.0], [2.0]], mat![[4.0], [-8.0]], mat![[3.0], [10.0]]);
    let state = full.initial_state(u.as_ref(), v.as_ref(), Some(f.as_ref())).unwrap();
    // K u = (2, 6); C v = 0.5 (8, −8) + 0.25 (40, −40) = (14, −14); M a = (−13, 18).
    assert!((state.dt2_acceleration[(0, 0)] / 0.01 + 6.5).abs() < 1e-13);
    assert!((state.dt2_acceleration[(1, 0)] / 0.01 - 18.0).abs() < 1e-13);
    assert!((full.energy(&state, 0) - 0.5 * (2.0 * 16.0 + 64.0 + 2.0 + 12.0)).abs() < 1e-12);
}

#[test]
fn what_cannot_march_is_refused_by_name() {
    let pencil = two_dof();
    let symbolic = Symbolic::analyze(&pencil).unwrap();
    let none = Rayleigh::default();
    let refused = |table: &SchemeTable, dt: f64, damping: Rayleigh| {
        FullOrder::new(&pencil, &symbolic, table, dt, damping).err().unwrap()
    };
    assert_eq!(refused(&bathe(), 0.0, none), FullOrderError::TimeStep(0.0));
    let negative = Rayleigh { alpha: -1.0, beta: 0.0 };
    assert_eq!(refused(&bathe(), 0.1, negative), FullOrderError::Damping(negative));
    let mut misprint = bathe();
    misprint.stages[1].mass = 16.0;
    assert!(matches!(refused(&misprint, 0.1, none), FullOrderError::InconsistentScheme(_)));
    let massless = Pencil::from_triplets(1, &[], &[(0, 0, 1.0)]).unwrap();
    let analysis = Symbolic::analyze(&massless).unwrap();
    let full = FullOrder::new(&massless, &analysis, &bathe(), 0.1, none).unwrap();
    let start = Mat::zeros(1, 1);
    let found = full.initial_state(start.as_ref(), start.as_ref(), Some(mat![[1.0]].as_ref()));
    assert_eq!(found.unwrap_err(), FullOrderError::SingularMass);
}

#[test]
fn two_ratios_give_back_themselves() {
    let pairs = [(0.02, 5.0), (0.05, 80.0)];
    let rayleigh = Damping::Ratios(pairs).rayleigh().unwrap();
    for (ratio, frequency) in pairs {
        assert!((rayleigh.ratio(frequency) - ratio).abs() < 1e-15);
    }
    let steep = Damping::Ratios([(0.5, 5.0), (0.001, 80.0)]).rayleigh();
    assert!(matches!(steep, Err(DampingError::GainsEnergy(_))));
    let same = [(0.02, 5.0), (0.05, 5.0)];
    assert_eq!(Damping::Ratios(same).rayleigh(), Err(DampingError::Pairs(same)));
    assert_eq!(Damping::None.rayleigh(), Ok(Rayleigh::default()));
}

/// Three steps of ten loads on a small cantilever, with its modes.
fn cantilever_run(columns: std::ops::Range<usize>) -> (Modes, State) {
    let mesh = block([24, 6, 6], [4.0, 1.0, 1.0]); // 3 528 dofs: several row chunks, two groups of columns
    let held = hold(&mesh, |p| p[0] == 0.0);
    let rubber = Material::isotropic(1e7, 0.3, 1000.0);
    let model = Model::assemble(mesh, &[rubber], &held).unwrap();
    let pencil = model.pencil();
    let symbolic = Symbolic::analyze(pencil).unwrap();
    let modes = lowest_modes(pencil, &symbolic, 6).unwrap();
    let damping = Rayleigh { alpha: 0.1, beta: 1e-5 };
    let full = FullOrder::new(pencil, &symbolic, &bathe(), 1e-3, damping).unwrap();
    let n = full.n_dof();
    let force = Mat::from_fn(n, columns.len(), |i, j| f64::from(i == n - 1 - columns.start - j));
    let still = Mat::zeros(n, columns.len());
    let mut state = full.initial_state(still.as_ref(), still.as_ref(), Some(force.as_ref())).unwrap();
    let mut work = full.workspace(columns.len(), true);
    for _ in 0..3 {
        full.step(&mut state, &[None, Some(force.as_ref()), Some(force.as_ref()), None], &mut work);
    }
    (modes, state)
}

#[test]
fn modes_and_march_are_the_same_bits_for_one_and_two_threads() {
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| cantilever_run(0..10))
    };
    let ((modes, state), (other_modes, other_state)) = (run(1), run(2));
    assert!(modes.eigenvalues == other_modes.eigenvalues && modes.vectors == other_modes.vectors);
    assert!(state == other_state);
}

#[test]
fn trajectories_side_by_side_do_not_mix() {
    let (_, together) = cantilever_run(0..10);
    let (_, alone) = cantilever_run(9..10);
    let size = alone.displacement.norm_max();
    for i in 0..alone.displacement.nrows() {
        // Kernels of other widths round differently, amplified by the condition of M + Δt² K, here below 1e3.
        assert!((together.displacement[(i, 9)] - alone.displacement[(i, 0)]).abs() < 1e-12 * size);
    }
}
