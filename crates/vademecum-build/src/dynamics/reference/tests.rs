//! The truth against all modes of small bodies, against closed forms, and against itself.

use faer::{Mat, mat};
use vademecum_format::exact::Propagator;

use super::{MotionPart, ReferenceOptions, ReferenceSolution};
use crate::dynamics::{History, Interval, Rayleigh, TimedLoad, lowest_modes};
use crate::fem::test_mesh::{block, hold};
use crate::fem::{Material, Model, Pencil, Symbolic};
use crate::linalg::symmetric_eigen;
use crate::progress::Silent;

const OPTIONS: ReferenceOptions =
    ReferenceOptions { tolerance: 1e-9, vectors_per_force: 400, bytes: u64::MAX };

/// A held block of some hundred free dofs.
fn small_block() -> Model {
    let mesh = block([6, 3, 3], [0.3, 0.1, 0.12]);
    let held = hold(&mesh, |p| p[0] == 0.0);
    Model::assemble(mesh, &[Material::isotropic(1e7, 0.3, 1000.0)], &held).unwrap()
}

/// All modes of a pencil, by the dense problem `L⁻¹KL⁻ᵀ` with `M = LLᵀ`.
struct AllModes {
    lambda: Vec<f64>,
    vectors: Mat<f64>,
}

impl AllModes {
    fn of(pencil: &Pencil) -> AllModes {
        let n = pencil.n_dof();
        let dense = |matrix: &crate::fem::SymmetricMatrix| {
            let mut out = Mat::zeros(n, n);
            matrix.mul_into(Mat::<f64>::identity(n, n).as_ref(), out.as_mut());
            out
        };
        let (mass, stiffness) = (dense(pencil.mass()), dense(pencil.stiffness()));
        let factor = mass.llt(faer::Side::Lower).unwrap();
        let mut inverse = Mat::<f64>::identity(n, n);
        faer::linalg::triangular_solve::solve_lower_triangular_in_place(
            factor.L(),
            inverse.as_mut(),
            faer::Par::Seq,
        );
        let reduced = &inverse * stiffness * inverse.transpose();
        let reduced = Mat::from_fn(n, n, |i, j| 0.5 * (reduced[(i, j)] + reduced[(j, i)]));
        let (lambda, vectors) = symmetric_eigen(reduced.as_ref()).unwrap();
        AllModes { lambda, vectors: inverse.transpose() * vectors }
    }

    /// Coordinates at the instants, by steps so short that every jump and kink of `loads` is an instant.
    fn coordinates(
        &self,
        damping: Rayleigh,
        loads: &[TimedLoad],
        (dt, steps): (f64, usize),
        parts: usize,
    ) -> Mat<f64> {
        let h = dt / parts as f64;
        let mut out = Mat::zeros(self.lambda.len(), steps + 1);
        for (k, &lambda) in self.lambda.iter().enumerate() {
            let sigma = 0.5 * (damping.alpha + damping.beta * lambda);
            let p = Propagator::new(lambda, sigma, h);
            let share = |load: &TimedLoad| -> f64 {
                load.force.iter().enumerate().map(|(i, f)| f * self.vectors[(i, k)]).sum()
            };
            let shares: Vec<f64> = loads.iter().map(share).collect();
            let (mut q, mut v) = (0.0, 0.0);
            for part in 0..steps * parts {
                // Inside the part, at a quarter and at three quarters, a load is linear.
                let (mut at_start, mut rise) = (0.0, 0.0);
                for (load, share) in loads.iter().zip(&shares) {
                    let [a, b] = [0.25, 0.75].map(|c| factor(&load.when, (part as f64 + c) * h));
                    at_start += share * (1.5 * a - 0.5 * b);
                    rise += share * 2.0 * (b - a);
                }
                let state = [
                    q + p.d[0] * q + p.d[1] * v + p.held[0] * at_start + p.rising[0] * rise,
                    v + p.d[2] * q + p.d[3] * v + p.held[1] * at_start + p.rising[1] * rise,
                ];
                [q, v] = state;
                if (part + 1) % parts == 0 {
                    out[(k, (part + 1) / parts)] = q;
                }
            }
        }
        out
    }
}

/// Factor on a load at a time that is no tie, to the last digit.
fn factor(when: &History, t: f64) -> f64 {
    let when = &when.during;
    let rise = if when.ramp > 0.0 { ((t - when.start) / when.ramp).min(1.0) } else { 1.0 };
    if t < when.start || t >= when.end { 0.0 } else { rise }
}

/// Damping of 2 % at the first mode, all of it from the stiffness.
fn two_percent(lambda: f64) -> Rayleigh {
    Rayleigh { alpha: 0.0, beta: 0.04 / lambda.sqrt() }
}

fn point_force(model: &Model, node: u32, force: [f64; 3]) -> Vec<f64> {
    let mut out = vec![0.0; model.pencil().n_dof()];
    model.add_point_force(&[node; 3], &[1.0, 0.0, 0.0], force, &mut out);
    out
}

/// Nodes at the far end.
fn far_nodes(model: &Model) -> Vec<u32> {
    let nodes = &model.mesh().nodes;
    (0..nodes.len() as u32).filter(|&i| (nodes[i as usize][0] - 0.3).abs() < 1e-9).collect()
}

/// The truth of some loads on the small block beside all modes: its estimate and its true error.
fn estimate_and_error(loads: impl Fn(&Model, f64) -> Vec<TimedLoad>, damped: bool, most: usize) -> [f64; 2] {
    let model = small_block();
    let pencil = model.pencil();
    let all = AllModes::of(pencil);
    let damping = if damped { two_percent(all.lambda[0]) } else { Rayleigh::default() };
    let dt = std::f64::consts::TAU / all.lambda[0].sqrt() / 40.0;
    let (steps, loads) = (120, loads(&model, dt));
    let options = ReferenceOptions { vectors_per_force: most, ..OPTIONS };
    let symbolic = Symbolic::analyze(pencil).unwrap();
    let decay = |lambda, _| damping.decay(lambda);
    let truth =
        ReferenceSolution::find(pencil, &symbolic, &decay, &loads, (dt, steps), &options, &Silent).unwrap();
    // Jumps and kinks of all loads here are multiples of a twentieth of a step.
    let coordinates = all.coordinates(damping, &loads, (dt, steps), 20);
    let exact = MotionPart { columns: all.vectors.as_ref(), amplitudes: coordinates.as_ref() };
    let found = truth.trajectory(0);
    [found.estimate(), found.distance(&[exact]).error]
}

fn held(model: &Model, _: f64) -> Vec<TimedLoad> {
    let when = Interval { start: 0.0, end: f64::INFINITY, ramp: 0.0 };
    vec![TimedLoad {
        column: 0,
        force: point_force(model, far_nodes(model)[0], [0.3, 1.0, -0.2]),
        when: when.into(),
    }]
}

/// A push that ends inside a step, one with a ramp that starts inside a step, and a ramp cut by its end.
fn pushes(model: &Model, dt: f64) -> Vec<TimedLoad> {
    let nodes = far_nodes(model);
    let load = |node: usize, force, start: f64, end: f64, ramp: f64| {
        let when = Interval { start: start * dt, end: end * dt, ramp: ramp * dt };
        TimedLoad { column: 0, force: point_force(model, nodes[node], force), when: when.into() }
    };
    vec![
        load(0, [0.3, 1.0, -0.2], 0.0, 20.35, 0.0),
        load(5, [0.0, -0.5, 1.0], 7.7, 33.0, 5.15),
        load(0, [0.6, 2.0, -0.4], 50.45, 52.2, 10.0),
    ]
}

#[test]
fn damped_answers_of_a_block_are_those_of_all_its_modes() {
    for [estimate, error] in [estimate_and_error(held, true, 400), estimate_and_error(pushes, true, 400)] {
        assert!(error <= 1e-8, "{error:e}");
        assert!(estimate >= 0.1 * error, "{estimate:e} for {error:e}");
    }
}

#[test]
fn the_estimate_is_not_below_a_tenth_of_the_error_however_small_the_space() {
    for damped in [true, false] {
        for most in [12, 18, 40, 80] {
            for [estimate, error] in
                [estimate_and_error(held, damped, most), estimate_and_error(pushes, damped, most)]
            {
                assert!(estimate >= 0.1 * error, "{most} vectors: {estimate:e} for {error:e}");
            }
        }
    }
}

/// One mass on one spring, and its truth under some loads.
fn oscillator(
    stiffness: f64,
    decay: f64,
    loads: &[(f64, Interval)],
    (dt, steps): (f64, usize),
) -> (Mat<f64>, f64) {
    let pencil = Pencil::from_matrices(mat![[1.0]].as_ref(), mat![[stiffness]].as_ref()).unwrap();
    let symbolic = Symbolic::analyze(&pencil).unwrap();
    let load =
        |&(force, when): &(f64, Interval)| TimedLoad { column: 0, force: vec![force], when: when.into() };
    let loads: Vec<_> = loads.iter().map(load).collect();
    let decay = |_, _| decay;
    let truth =
        ReferenceSolution::find(&pencil, &symbolic, &decay, &loads, (dt, steps), &OPTIONS, &Silent).unwrap();
    let found = truth.trajectory(0);
    (found.along(&[vec![(0, 1.0)]]), found.norm())
}

#[test]
fn one_mass_moves_as_by_hand() {
    // ω = 2; answers to a step and to a ramp of unit slope, without damping.
    let step = |t: f64| if t > 0.0 { 0.25 * (1.0 - (2.0 * t).cos()) } else { 0.0 };
    let ramp = |t: f64| if t > 0.0 { 0.25 * (t - 0.5 * (2.0 * t).sin()) } else { 0.0 };
    let loads = [
        (3.0, Interval { start: 0.0, end: 0.33, ramp: 0.0 }),
        (-2.0, Interval { start: 0.25, end: 1.3, ramp: 0.5 }),
        (5.0, Interval { start: 0.11, end: 0.17, ramp: 0.2 }),
    ];
    let exact = |t: f64| {
        let push = 3.0 * (step(t) - step(t - 0.33));
        let rise = -4.0 * (ramp(t - 0.25) - ramp(t - 0.75)) + 2.0 * step(t - 1.3);
        let cut = 25.0 * (ramp(t - 0.11) - ramp(t - 0.17)) - 5.0 * 0.3 * step(t - 0.17);
        push + rise + cut
    };
    let (found, norm) = oscillator(4.0, 0.0, &loads, (0.1, 40));
    let mut squares = 0.0;
    for n in 0..=40 {
        let u = exact(0.1 * n as f64);
        // Some forty steps of some five roundings of numbers below 2.
        assert!((found[(0, n)] - u).abs() < 1e-13, "{n}: {} for {u}", found[(0, n)]);
        squares += u * u;
    }
    assert!((norm / squares.sqrt() - 1.0).abs() < 1e-13);
    // Critical damping, ω = σ = 2: ¼ (1 − (1 + 2t) e^{−2t}).
    let held = [(1.0, Interval { start: 0.05, end: f64::INFINITY, ramp: 0.0 })];
    let (found, _) = oscillator(4.0, 2.0, &held, (0.1, 40));
    for n in 1..=40 {
        let t = 0.1 * n as f64 - 0.05;
        let exact = 0.25 * (1.0 - (1.0 + 2.0 * t) * (-2.0 * t).exp());
        assert!((found[(0, n)] - exact).abs() < 1e-14);
    }
}

#[test]
fn the_motion_does_not_depend_on_the_step_at_which_it_is_looked_at() {
    let model = small_block();
    let pencil = model.pencil();
    let symbolic = Symbolic::analyze(pencil).unwrap();
    let dt = 1e-3;
    let loads = pushes(&model, dt);
    let options = ReferenceOptions { tolerance: 0.0, vectors_per_force: 20, ..OPTIONS };
    let row = [vec![(3, 1.0), (200, -0.5)]];
    let find = |step: (f64, usize)| {
        let truth =
            ReferenceSolution::find(pencil, &symbolic, &|_, _| 0.0, &loads, step, &options, &Silent).unwrap();
        assert_eq!(truth.vectors(), 40);
        truth.trajectory(0).along(&row)
    };
    let (coarse, fine) = (find((dt, 100)), find((dt / 2.0, 200)));
    let size = coarse.norm_max();
    for n in 0..=100 {
        // A thousand roundings of the fastest modes at most.
        assert!((coarse[(0, n)] - fine[(0, 2 * n)]).abs() < 1e-12 * size, "instant {n}");
    }
}

#[test]
fn distances_keep_their_digits_and_split_into_floor_and_coordinates() {
    let model = small_block();
    let pencil = model.pencil();
    let symbolic = Symbolic::analyze(pencil).unwrap();
    let modes = lowest_modes(pencil, &symbolic, 6).unwrap();
    let dt = std::f64::consts::TAU / modes.eigenvalues[0].sqrt() / 40.0;
    let loads = pushes(&model, dt);
    let damping = two_percent(modes.eigenvalues[0]);
    let decay = |lambda, _| damping.decay(lambda);
    let truth =
        ReferenceSolution::find(pencil, &symbolic, &decay, &loads, (dt, 150), &OPTIONS, &Silent).unwrap();
    let found = truth.trajectory(0);
    let coordinates = found.coordinates();
    let part = |columns, amplitudes| MotionPart { columns, amplitudes };

    // The truth itself with a part in 1e10 of a rough field beside it.
    let n = pencil.n_dof();
    let rough = Mat::from_fn(n, 1, |i, _| ((i * i) as f64 * 0.7).sin());
    let weight = pencil.mass().inner(rough.col_as_slice(0), rough.col_as_slice(0)).sqrt();
    let small = 1e-10 * found.norm() / weight;
    let once = Mat::from_fn(1, 151, |_, n| if n == 77 { small } else { 0.0 });
    let beside =
        found.distance(&[part(truth.space(), coordinates.as_ref()), part(rough.as_ref(), once.as_ref())]);
    // The rounding of a vector of the space, a part in 1e16, is a part in 1e6 of this error.
    assert!((beside.error / 1e-10 - 1.0).abs() < 1e-5, "{}", beside.error);
    assert!(beside.floor < 1e-14);

    // On a basis that is not orthonormal: modes, each with some of the mode before it.
    let skew = Mat::from_fn(6, 6, |i, j| if i == j { 2.0 } else { f64::from(u8::from(i + 1 == j)) });
    let basis = &modes.vectors * &skew;
    let zeta = Mat::from_fn(6, 151, |k, n| 1e-5 * ((k + 1) * n) as f64);
    let apart = found.distance(&[part(basis.as_ref(), zeta.as_ref())]);
    let mut weighted = Mat::zeros(n, 6);
    pencil.mass().mul_into(modes.vectors.as_ref(), weighted.as_mut());
    let u = truth.space() * &coordinates;
    let best = weighted.transpose() * &u;
    let measured = |shown: &Mat<f64>| {
        let mut meter = found.marched_apart();
        (0..=150).for_each(|n| meter.add(shown.col_as_slice(n)));
        meter.error()
    };
    // The meter forms differences over the dofs: nothing is shared but the truth.
    let close = |a: f64, b: f64| (a / b - 1.0).abs() < 1e-9;
    assert!(close(apart.floor, measured(&(&modes.vectors * &best))), "{}", apart.floor);
    assert!(close(apart.error, measured(&(&basis * &zeta))), "{}", apart.error);
    let coordinates_apart = (best - &skew * &zeta).norm_l2() / found.norm();
    assert!(close(apart.error, apart.floor.hypot(coordinates_apart)));
    assert!(measured(&u) < 1e-14);
}

#[test]
fn trajectories_share_a_space_and_a_force_counts_once() {
    let model = small_block();
    let pencil = model.pencil();
    let symbolic = Symbolic::analyze(pencil).unwrap();
    let nodes = far_nodes(&model);
    let when = |start: f64| Interval { start, end: f64::INFINITY, ramp: 0.0 };
    let one = point_force(&model, nodes[0], [0.0, 1.0, 0.0]);
    let twice = point_force(&model, nodes[0], [0.0, 2.0, 0.0]);
    let other = point_force(&model, nodes[3], [1.0, 0.0, 1.0]);
    let load = |column, force: &Vec<f64>, start| TimedLoad {
        column,
        force: force.clone(),
        when: when(start).into(),
    };
    let options = ReferenceOptions { tolerance: 0.0, vectors_per_force: 30, ..OPTIONS };
    let find = |loads: &[TimedLoad]| {
        ReferenceSolution::find(pencil, &symbolic, &|_, _| 0.0, loads, (1e-3, 50), &options, &Silent).unwrap()
    };
    let truth = find(&[load(0, &one, 0.0), load(1, &other, 0.0), load(2, &twice, 0.01), load(2, &one, 0.0)]);
    // Two independent forces.
    assert_eq!(truth.vectors(), 60);
    let row = [vec![(100, 1.0)]];
    let [a, b, c] = [0, 1, 2].map(|column| truth.trajectory(column).along(&row));
    assert!(a != b && b.norm_max() > 0.0);
    for n in 0..=50 {
        let delayed = if n >= 10 { 2.0 * a[(0, n - 10)] } else { 0.0 };
        assert!((c[(0, n)] - a[(0, n)] - delayed).abs() < 1e-11 * a.norm_max());
    }
    // No force moves nothing.
    let rest = find(&[load(0, &vec![0.0; pencil.n_dof()], 0.0)]);
    assert_eq!((rest.vectors(), rest.trajectory(0).along(&row).norm_max()), (0, 0.0));
}

#[test]
fn the_modes_of_a_slender_beam_are_found_to_their_digits() {
    let mesh = block([80, 1, 1], [8.0, 0.1, 0.1]);
    let held = hold(&mesh, |p| p[0] == 0.0);
    let steel = Material::isotropic(2e11, 0.3, 7850.0);
    let model = Model::assemble(mesh, &[steel], &held).unwrap();
    let pencil = model.pencil();
    let symbolic = Symbolic::analyze(pencil).unwrap();
    let modes = lowest_modes(pencil, &symbolic, 3).unwrap();
    let node = (model.mesh().nodes.len() - 1) as u32;
    let load = TimedLoad {
        column: 0,
        force: point_force(&model, node, [0.0, 1.0, 0.3]),
        when: Interval { start: 0.0, end: f64::INFINITY, ramp: 0.0 }.into(),
    };
    let options = ReferenceOptions { tolerance: 0.0, vectors_per_force: 200, ..OPTIONS };
    let truth =
        ReferenceSolution::find(pencil, &symbolic, &|_, _| 0.0, &[load], (1e-3, 10), &options, &Silent)
            .unwrap();
    // The stiffest is 6e8 times as stiff as the first: where its rounding is a part in 1e16, the first keeps
    // half of its digits, and more than that because roundings average out.
    let lambda = truth.lambda();
    let first = (lambda[0] / modes.eigenvalues[0] - 1.0).abs();
    assert!(first < 1e-8, "{first:e}");
}

#[test]
fn a_space_serves_another_damping_and_many_motions_on_its_trajectories() {
    let model = small_block();
    let pencil = model.pencil();
    let symbolic = Symbolic::analyze(pencil).unwrap();
    let lowest = lowest_modes(pencil, &symbolic, 4).unwrap();
    let damping = two_percent(lowest.eigenvalues[0]);
    let dt = std::f64::consts::TAU / lowest.eigenvalues[0].sqrt() / 40.0;
    let loads = pushes(&model, dt);
    let find = |decay: &dyn Fn(f64, usize) -> f64, most: usize| {
        let options = ReferenceOptions { vectors_per_force: most, ..OPTIONS };
        ReferenceSolution::find(pencil, &symbolic, decay, &loads, (dt, 60), &options, &Silent).unwrap()
    };
    // A space that is not closed, so that the estimate is one.
    let free = find(&|_, _| 0.0, 20);
    let vectors = free.vectors();
    let free_estimate = free.trajectory(0).estimate();
    let damped = free.damped(&|lambda, _| damping.decay(lambda), &Silent).unwrap();
    let afresh = find(&|lambda, _| damping.decay(lambda), 20);
    assert_eq!([damped.vectors(), afresh.vectors()], [vectors; 2]);
    let [found, expected] = [&damped, &afresh].map(|truth| truth.trajectory(0).coordinates());
    assert!(found == expected, "the same space, the same modes, the same damping");
    let [found, expected] = [&damped, &afresh].map(|truth| truth.trajectory(0).estimate());
    assert!(found == expected && found != free_estimate, "{found} {expected} {free_estimate}");

    // What is compared instant by instant adds up to what is compared at once, also where only some of the
    // columns move.
    let trajectory = damped.trajectory(0);
    let coordinates = trajectory.coordinates();
    let complement = damped.complement(lowest.vectors.clone());
    let zeta = Mat::from_fn(4, 61, |k, n| if k < 2 { 1e-5 * ((k + 1) * n) as f64 } else { 0.0 });
    let squares = complement.squares_apart(coordinates.clone(), zeta.as_ref());
    let (columns, amplitudes) = (lowest.vectors.subcols(0, 2), zeta.subrows(0, 2));
    let expected = trajectory.distance(&[MotionPart { columns, amplitudes }]).error;
    let found = (squares.iter().sum::<f64>() / coordinates.squared_norm_l2()).sqrt();
    assert_eq!(squares.len(), 61);
    assert!((found / expected - 1.0).abs() < 1e-12, "{found} {expected}");
}

#[test]
fn modes_that_are_known_halve_the_space_and_leave_the_estimate_sound() {
    let model = small_block();
    let pencil = model.pencil();
    let all = AllModes::of(pencil);
    let damping = two_percent(all.lambda[0]);
    let decay = |lambda, _| damping.decay(lambda);
    let dt = std::f64::consts::TAU / all.lambda[0].sqrt() / 40.0;
    let (steps, loads) = (120, pushes(&model, dt));
    let symbolic = Symbolic::analyze(pencil).unwrap();
    let lowest = lowest_modes(pencil, &symbolic, 16).unwrap().vectors;
    let coordinates = all.coordinates(damping, &loads, (dt, steps), 20);
    let exact = MotionPart { columns: all.vectors.as_ref(), amplitudes: coordinates.as_ref() };
    let options = ReferenceOptions { tolerance: 1e-4, ..OPTIONS };
    let [without, with] = [0, 16].map(|known| {
        let model = (pencil, &symbolic, lowest.subcols(0, known));
        let never = |_: &ReferenceSolution<'_>| None::<()>;
        let (truth, _) =
            ReferenceSolution::find_until(model, &decay, &loads, (dt, steps), &options, &Silent, never)
                .unwrap();
        let found = truth.trajectory(0);
        let (estimate, error) = (found.estimate(), found.distance(&[exact]).error);
        assert!(estimate <= 1e-4 && error <= estimate, "{known} modes: {estimate:e} {error:e}");
        truth.vectors() - known
    });
    assert!(2 * with <= without + 4, "{with} vectors beside the modes, {without} without");
}

/// The small block without supports: 330 dofs, of which six move it as a whole.
fn free_block() -> Model {
    let mesh = block([6, 3, 3], [0.3, 0.1, 0.12]);
    let held = vec![false; 3 * mesh.nodes.len()];
    Model::assemble(mesh, &[Material::isotropic(1e7, 0.3, 1000.0)], &held).unwrap()
}

/// Force of a field of acceleration.
fn body_force(model: &Model, at: impl Fn(&[f64; 3]) -> [f64; 3]) -> Vec<f64> {
    let field: Vec<f64> = model.mesh().nodes.iter().flat_map(at).collect();
    let mut force = Mat::zeros(field.len(), 1);
    let field = Mat::from_fn(field.len(), 1, |i, _| field[i]);
    model.pencil().mass().mul_into(field.as_ref(), force.as_mut());
    force.col_as_slice(0).to_vec()
}

#[test]
fn a_free_body_moves_by_all_of_its_elastic_modes() {
    let model = free_block();
    let pencil = model.pencil();
    let mut all = AllModes::of(pencil);
    assert!(all.lambda[5].abs() < 1e-9 * all.lambda[6] && all.lambda[6] > 0.0);
    all.lambda.drain(..6);
    all.vectors = all.vectors.subcols(6, all.lambda.len()).to_owned();
    let dt = std::f64::consts::TAU / all.lambda[0].sqrt() / 40.0;
    let when = || History::from(Interval { start: 0.0, end: f64::INFINITY, ramp: 0.0 });
    let load = |force| TimedLoad { column: 0, force, when: when() };
    let weight = || load(body_force(&model, |_| [0.0, 0.0, -9.81]));
    let spin = || load(body_force(&model, |x| [x[0] - 0.15, 0.0, 0.0]));
    let contact = || held(&model, dt).remove(0);
    let cases = [vec![contact()], pushes(&model, dt), vec![spin()], vec![contact(), weight(), spin()]];
    let symbolic = Symbolic::analyze(pencil).unwrap();
    for damping in [Rayleigh::default(), two_percent(all.lambda[0])] {
        let decay = |lambda, _| damping.decay(lambda);
        for (case, loads) in cases.iter().enumerate() {
            let span = (dt, 120);
            let truth =
                ReferenceSolution::find(pencil, &symbolic, &decay, loads, span, &OPTIONS, &Silent).unwrap();
            let coordinates = all.coordinates(damping, loads, span, 20);
            let exact = MotionPart { columns: all.vectors.as_ref(), amplitudes: coordinates.as_ref() };
            let found = truth.trajectory(0);
            let (estimate, error) = (found.estimate(), found.distance(&[exact]).error);
            // No vector has an eigenvalue of rounding, and there are no more than elastic modes.
            assert!(truth.lambda()[0] > 0.99 * all.lambda[0], "case {case}: {}", truth.lambda()[0]);
            assert!(truth.vectors() <= pencil.n_elastic());
            assert!(error <= 1e-8 && estimate >= 0.1 * error, "case {case}: {estimate:e} for {error:e}");
        }
    }
    // A weight alone deforms nothing.
    let span = (dt, 10);
    let rest = ReferenceSolution::find(pencil, &symbolic, &|_, _| 0.0, &[weight()], span, &OPTIONS, &Silent)
        .unwrap();
    assert_eq!((rest.vectors(), rest.trajectory(0).norm()), (0, 0.0));
}

/// Displacements at the instants by the trapezoidal rule in `parts` parts of a step, of the whole matrices.
fn by_newmark(pencil: &Pencil, beta: f64, load: &TimedLoad, span: (f64, usize), parts: usize) -> Mat<f64> {
    let (n, (dt, steps)) = (pencil.n_dof(), span);
    let dense = |matrix: &crate::fem::SymmetricMatrix| {
        let mut out = Mat::zeros(n, n);
        matrix.mul_into(Mat::<f64>::identity(n, n).as_ref(), out.as_mut());
        out
    };
    let (mass, stiffness) = (dense(pencil.mass()), dense(pencil.stiffness()));
    let damping = beta * &stiffness + pencil.dampers().project(Mat::<f64>::identity(n, n).as_ref());
    let h = dt / parts as f64;
    let whole = &mass + 0.5 * h * &damping + 0.25 * h * h * &stiffness;
    let factor = whole.llt(faer::Side::Lower).unwrap();
    let force = |time: f64| load.when.factor(time) * Mat::from_fn(n, 1, |i, _| load.force[i]);
    let solve = |right: Mat<f64>| faer::linalg::solvers::Solve::solve(&factor, &right);
    let (mut u, mut v) = (Mat::<f64>::zeros(n, 1), Mat::<f64>::zeros(n, 1));
    let mut a = faer::linalg::solvers::Solve::solve(&mass.llt(faer::Side::Lower).unwrap(), &force(0.0));
    let mut out = Mat::zeros(n, steps + 1);
    for step in 1..=steps * parts {
        let (ahead, faster) = (&u + h * &v + 0.25 * h * h * &a, &v + 0.5 * h * &a);
        a = solve(force(step as f64 * h) - &damping * &faster - &stiffness * &ahead);
        u = ahead + 0.25 * h * h * &a;
        v = faster + 0.5 * h * &a;
        if step % parts == 0 {
            out.col_mut(step / parts).copy_from(u.col(0));
        }
    }
    out
}

#[test]
fn dashpots_move_a_block_as_their_whole_matrix_does() {
    let model = small_block();
    let all = AllModes::of(model.pencil());
    let omega = all.lambda[0].sqrt();
    let (dt, steps) = (std::f64::consts::TAU / omega / 40.0, 80);
    let nodes = far_nodes(&model);
    // Half of the body's mass times its first frequency: as strong as the body itself.
    let strength = (0.5 * 3.6 * omega).sqrt();
    let row = |node: usize, along: [f64; 3]| -> Vec<(u32, f64)> {
        let force = point_force(&model, nodes[node], along);
        let entries = force.iter().enumerate().filter(|(_, weight)| **weight != 0.0);
        entries.map(|(dof, weight)| (dof as u32, strength * weight)).collect()
    };
    let few = vec![row(2, [0.0, 1.0, 0.0]), row(3, [0.5, 0.0, 1.0])];
    // Of more dashpots than begin a direction each, those of the first motions do.
    let many = (0..nodes.len()).flat_map(|node| {
        [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|along| row(node, along.map(|x| 0.2 * x)))
    });
    let many: Vec<_> = many.collect();
    assert!(many.len() > crate::fem::FEW_DASHPOTS);
    let beta = 2.0 * 0.01 / omega;
    let when = Interval { start: 0.0, end: f64::INFINITY, ramp: 5.0 * dt };
    let force = point_force(&model, nodes[0], [0.3, 1.0, -0.2]);
    let load = TimedLoad { column: 0, force, when: when.into() };
    for (rows, allowed) in [(few, 1e-6), (many, 1e-4)] {
        let pencil = model.pencil().clone().with_dampers(crate::fem::Dampers::of_rows(rows));
        let [once, twice] = [20, 40].map(|parts| by_newmark(&pencil, beta, &load, (dt, steps), parts));
        // Richardson.
        let expected = (4.0 / 3.0) * twice - (1.0 / 3.0) * once;
        let symbolic = Symbolic::analyze(&pencil).unwrap();
        let decay = |lambda, _| 0.5 * beta * lambda;
        let options = ReferenceOptions { tolerance: 1e-7, vectors_per_force: 60, ..OPTIONS };
        let loads = std::slice::from_ref(&load);
        let span = (dt, steps);
        let truth =
            ReferenceSolution::find(&pencil, &symbolic, &decay, loads, span, &options, &Silent).unwrap();
        let identity = Mat::<f64>::identity(pencil.n_dof(), pencil.n_dof());
        let exact = MotionPart { columns: identity.as_ref(), amplitudes: expected.as_ref() };
        let found = truth.trajectory(0);
        let (error, estimate) = (found.distance(&[exact]).error, found.estimate());
        assert!(error < allowed, "{} vectors: {error:e}, estimated {estimate:e}", truth.vectors());
    }
}
