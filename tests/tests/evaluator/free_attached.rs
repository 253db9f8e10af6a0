//! Free bodies with masses, couplings and springs, from the problem to the motion in space, against closed
//! forms and against all modes of the whole matrices.

use faer::linalg::triangular_solve::{solve_lower_triangular_in_place, solve_upper_triangular_in_place};
use faer::{Par, Side};
use vademecum_build::prepared::{Prepared, prepare};
use vademecum_build::progress::{Silent, Stopwatch};
use vademecum_eval::{RigidMotion, SceneOptions};
use vademecum_format::{File, SectionKind};

use super::free::{Flight, built, dense, nothing, problem};

/// A brick whose end follows a motor outside of it, with a mass that hangs on the mean of the other end and a
/// spring between the two.
const BRICK: &str = r#"
[mesh]
block = { lengths = [0.3, 0.2, 0.1], divisions = [3, 1, 1], order = "linear" }
[[material]]
young = 1e6
poisson = 0.3
density = 1000.0
[[reference_point]]
name = "motor"
at = [0.4, 0.12, -0.03]
[[coupling]]
reference = "motor"
on = { group = "x_max" }
kind = "rigid"
[[point_mass]]
reference = "motor"
mass = 2.0
inertia = [0.01, 0.02, 0.015, 0.002, -0.001, 0.003]
[[reference_point]]
name = "hung"
at = [-0.1, 0.05, 0.2]
[[coupling]]
reference = "hung"
on = { group = "x_min" }
kind = "average"
[[point_mass]]
reference = "hung"
mass = 0.5
[[spring]]
from = "motor"
to = "hung"
stiffness = [2e3, 1e3, 5e2, 3.0, 2.0, 1.0]
[[load.pattern]]
name = "gravity"
acceleration = [0.0, 0.0, -9.81]
[[output.probe]]
name = "motor"
point = [0.4, 0.12, -0.03]
direction = [0.0, 0.0, 1.0]
[time]
step = 1e-4
[basis]
modes = MODES
[tolerance]
error = 1.0
steps = 50
"#;

/// Elastic modes of the brick: four of eight nodes follow the motor.
const ALL: usize = 3 * 12 + 6 - 6;

fn brick() -> String {
    BRICK.replace("MODES", &ALL.to_string())
}

/// Pins of the section of a free body: mass, centre, moments, first pattern, and the wrenches of patterns.
fn rigid_numbers(bytes: &[u8]) -> Vec<f64> {
    let file = File::parse(bytes).expect("a file");
    file.section(SectionKind::RigidBody).expect("free").numbers().expect("numbers").iter().collect()
}

#[test]
fn a_pushed_brick_with_masses_moves_as_all_modes_of_the_whole_matrices_say() {
    let text = brick();
    let problem = problem(&text);
    let Prepared { body, .. } =
        prepare(&problem, &mut Stopwatch::new(&Silent), &Silent).expect("a free body");
    let (pencil, dofs) = (body.model.pencil(), body.model.dofs());
    let n = pencil.n_dof();
    assert_eq!(n - 6, ALL, "all elastic modes are in the file");
    let lower = dense(pencil.mass()).llt(Side::Lower).expect("every free dof has mass");
    let mut reduced = dense(pencil.stiffness());
    solve_lower_triangular_in_place(lower.L(), reduced.as_mut(), Par::Seq);
    solve_lower_triangular_in_place(lower.L(), reduced.as_mut().transpose_mut(), Par::Seq);
    let modes = reduced.self_adjoint_eigen(Side::Lower).expect("modes");
    let mut vectors = modes.U().to_owned();
    solve_upper_triangular_in_place(lower.L().transpose(), vectors.as_mut(), Par::Seq);
    let squares: Vec<f64> = (0..n).map(|k| modes.S()[k]).collect();
    let still = 1e-9 * squares[n - 1];
    assert_eq!(squares.iter().filter(|&&square| square.abs() < still).count(), 6);
    // The file has the same frequencies.
    let bytes = built(&text);
    let file = File::parse(&bytes).expect("a file");
    let found = file.section(SectionKind::Eigenvalues).expect("modes").numbers().expect("numbers");
    for (found, expected) in found.iter().zip(&squares[6..]) {
        assert!((found / expected - 1.0).abs() < 1e-9, "{found} {expected}");
    }

    // So light a push that turning stays linear; its end follows the motor.
    let (at, force) = ([0.3, 0.2, 0.1], [1e-4, 2e-4, -3e-4]);
    let nodes = &body.model.mesh().nodes;
    let find = |p: [f64; 3]| nodes.iter().position(|x| (0..3).all(|c| (x[c] - p[c]).abs() < 1e-12));
    let node = find(at).expect("a corner");
    let mut flight = Flight::new(&bytes, &SceneOptions::default(), RigidMotion::at_rest);
    let steps = 400;
    let pushed = flight.simulation.locate(at).expect("a corner");
    for _ in 0..steps {
        flight.step(|free, scene, loads| free.push(scene, loads, &pushed, force).expect("a push"));
    }
    let time = steps as f64 * 1e-4;
    let answer = |square: f64| match square.abs() < still {
        true => 0.5 * time * time,
        false => (1.0 - (square.sqrt() * time).cos()) / square,
    };
    let value = |node: usize, c: usize, k: usize| dofs.value(3 * node + c, |free| vectors[(free, k)]);
    let share = |k: usize| (0..3).map(|f| value(node, f, k) * force[f]).sum::<f64>();
    let amplitudes: Vec<f64> = (0..n).map(|k| share(k) * answer(squares[k])).collect();
    let (mut largest, mut compared) = (0.0f64, 0);
    for (other, place) in nodes.iter().enumerate() {
        let found = flight.point(*place);
        for c in 0..3 {
            let expected: f64 = (0..n).map(|k| value(other, c, k) * amplitudes[k]).sum();
            largest = largest.max((found[c] - place[c] - expected).abs());
            compared += usize::from(expected.abs() > 1e-9);
        }
    }
    assert!(compared > 30 && largest < 1e-11, "{compared} {largest:e}");
    let impulse = force.map(|f| f * time);
    let momentum = flight.free.motion().momentum;
    assert!((0..3).all(|c| (momentum[c] - impulse[c]).abs() < 1e-12 * impulse[c].abs()));
}

#[test]
fn patterns_push_the_body_with_its_masses_as_a_whole() {
    let numbers = rigid_numbers(&built(&brick()));
    let (mass, centre) = (numbers[0], [numbers[1], numbers[2], numbers[3]]);
    assert!((mass - 8.5).abs() < 1e-12, "{mass}");
    let arm = (0..3).map(|c| {
        let moments = 6.0 * [0.15, 0.1, 0.05][c] + 2.0 * [0.4, 0.12, -0.03][c] + 0.5 * [-0.1, 0.05, 0.2][c];
        (moments / 8.5 - centre[c]).abs()
    });
    assert!(arm.fold(0.0, f64::max) < 1e-12, "{centre:?}");
    let [xx, xy, xz, yy, yz, zz] = numbers[4..10] else { panic!("six moments") };
    let inertia = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]];
    let wrench = |pattern: usize| &numbers[11 + 6 * pattern..][..6];
    // Gravity pulls at the centre.
    let weight = wrench(0);
    assert!((weight[2] + 9.81 * mass).abs() < 1e-11, "{weight:?}");
    assert!([0, 1, 3, 4, 5].iter().all(|&k| weight[k].abs() < 1e-12), "{weight:?}");
    // Centrifugal forces are in balance, and their moment is −ω × Iω.
    let first = numbers[10] as usize;
    let cross = |a: [f64; 3], b: [f64; 3]| -> [f64; 3] {
        std::array::from_fn(|c| a[(c + 1) % 3] * b[(c + 2) % 3] - a[(c + 2) % 3] * b[(c + 1) % 3])
    };
    for spin in [[1.0, 0.0, 0.0], [0.3, -0.8, 0.5]] {
        let [x, y, z] = spin;
        let products = [x * x, y * y, z * z, x * y, y * z, z * x];
        let sum = |k: usize| (0..6).map(|p| products[p] * wrench(first + p)[k]).sum::<f64>();
        let momentum: [f64; 3] = std::array::from_fn(|i| (0..3).map(|j| inertia[i][j] * spin[j]).sum());
        let expected = cross(momentum, spin);
        for c in 0..3 {
            assert!(sum(c).abs() < 1e-12, "a force of {}", sum(c));
            assert!((sum(3 + c) - expected[c]).abs() < 1e-12, "{} for {}", sum(3 + c), expected[c]);
        }
        assert!(expected.iter().any(|m| m.abs() > 1e-3), "{expected:?}");
    }
}

#[test]
fn a_spinning_rod_with_masses_at_its_ends_grows_as_the_closed_form_says() {
    let end = |name: &str, at: f64, group: &str| {
        format!(
            "[[reference_point]]\nname = \"{name}\"\nat = [{at:?}, 0.0125, 0.01]\n\
             [[coupling]]\nreference = \"{name}\"\non = {{ group = \"{group}\" }}\nkind = \"rigid\"\n\
             [[point_mass]]\nreference = \"{name}\"\nmass = 0.2\n"
        )
    };
    let text = format!(
        "[mesh]\nblock = {{ lengths = [1.0, 0.025, 0.02], divisions = [10, 1, 1] }}\n\
         [[material]]\nyoung = 1e7\npoisson = 0.0\ndensity = 1000.0\n{}{}\
         [damping]\nratio = 1.0\n[time]\nstep = 1e-3\n[basis]\nmodes = 12\n[tolerance]\nerror = 1.0\n",
        end("left", 0.0, "x_min"),
        end("right", 1.0, "x_max")
    );
    let bytes = built(&text);
    let spin = 4.0;
    let mut flight = Flight::new(&bytes, &SceneOptions::default(), |body| {
        RigidMotion::thrown(body, [0.0; 3], [0.0, 0.0, spin])
    });
    let before = *flight.free.motion();
    for _ in 0..4000 {
        flight.step(nothing);
    }
    // Each half by its own mass, ρ ω² L³ / (24 E), and by the mass at its end, m ω² (L/2)² / (E A).
    let section = 0.025 * 0.02;
    let expected = spin * spin * (1000.0 / (24.0 * 1e7) + 0.2 * 0.25 / (1e7 * section));
    for (end, sign) in [([1.0, 0.0125, 0.01], 1.0), ([0.0, 0.0125, 0.01], -1.0)] {
        let [grown, across, up] = flight.displacement(end);
        assert!((sign * grown / expected - 1.0).abs() < 2e-3, "{grown:e} for {expected:e}");
        assert!(across.abs().max(up.abs()) < 1e-3 * expected, "{across:e} {up:e}");
    }
    let after = flight.free.motion();
    assert_eq!((before.momentum, before.angular_momentum), (after.momentum, after.angular_momentum));
    let spun = after.spin(flight.free.body());
    assert!((spun[2] - spin).abs() < 1e-9, "{spun:?}");
}
