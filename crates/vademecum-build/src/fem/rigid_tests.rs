//! Bodies without supports: their rigid motions, and static answers by inertia relief.

use std::f64::consts::TAU;

use faer::linalg::triangular_solve::solve_lower_triangular_in_place;
use faer::{Mat, Par};

use super::test_mesh::{block, hold};
use super::{Material, Model, ModelError, Pencil, RigidBody, Solve, Symbolic};
use crate::dynamics::lowest_modes;
use crate::mesh::{self, Order};
use crate::progress::Silent;

const RUBBER: Material = Material::isotropic(1e7, 0.3, 1000.0);

fn brick(order: Order) -> Model {
    let mesh = mesh::block([0.4, 0.2, 0.1], [4, 2, 1], order);
    let free = vec![false; 3 * mesh.nodes.len()];
    Model::assemble(mesh, &[RUBBER], &free).expect("a free body")
}

fn rigid(model: &Model) -> &RigidBody {
    model.pencil().rigid().expect("a free body")
}

/// `K⁺F` of every unit force on the first dofs.
fn answers(pencil: &Pencil, count: usize) -> Mat<f64> {
    let symbolic = Symbolic::analyze(pencil).unwrap();
    let factor = symbolic.factor_of(pencil.stiffness()).unwrap();
    let mut forces = Mat::from_fn(pencil.n_dof(), count, |i, j| if i == j { 1.0 } else { 0.0 });
    Solve::new(&symbolic, count, false).solve_in_place(&factor, forces.as_mut());
    forces
}

#[test]
fn mass_and_moments_are_those_of_the_block_however_it_is_placed() {
    for order in [Order::Linear, Order::Quadratic] {
        let model = brick(order);
        let (mass, sizes) = (8.0, [0.4_f64, 0.2, 0.1]);
        let rigid = rigid(&model);
        assert!((rigid.mass - mass).abs() < 1e-12 * mass);
        for (found, expected) in rigid.centre.iter().zip([0.2, 0.1, 0.05]) {
            assert!((found - expected).abs() < 1e-13, "{found} {expected}");
        }
        let square = sizes.map(|l| l * l);
        let moment = |i: usize, j: usize| mass / 12.0 * (square[i] + square[j]);
        let expected = [moment(1, 2), 0.0, 0.0, moment(2, 0), 0.0, moment(0, 1)];
        for (found, expected) in rigid.inertia.iter().zip(expected) {
            assert!((found - expected).abs() < 1e-13, "{found} {expected}");
        }
    }
}

#[test]
fn rigid_motions_are_orthonormal_in_the_mass_and_cost_no_energy() {
    let model = brick(Order::Quadratic);
    let (pencil, rigid) = (model.pencil(), rigid(&model));
    let product = rigid.motions().transpose() * rigid.momenta();
    let mut forces = Mat::zeros(pencil.n_dof(), 6);
    pencil.stiffness().mul_into(rigid.motions(), forces.as_mut());
    let scale = forces.norm_max() / (pencil.stiffness().diagonal(0) * rigid.motions().norm_max());
    assert!(scale < 1e-13, "{scale}");
    for i in 0..6 {
        for j in 0..6 {
            let expected = if i == j { 1.0 } else { 0.0 };
            assert!((product[(i, j)] - expected).abs() < 1e-13, "{i} {j}: {}", product[(i, j)]);
        }
    }
}

#[test]
fn the_answer_solves_what_inertia_leaves_of_a_force_and_does_not_depend_on_the_springs() {
    let model = brick(Order::Quadratic);
    let (pencil, rigid) = (model.pencil(), rigid(&model));
    let count = 12;
    let found = answers(pencil, count);
    let mut left = Mat::zeros(pencil.n_dof(), count);
    pencil.stiffness().mul_into(found.as_ref(), left.as_mut());
    let mut relieved = Mat::from_fn(pencil.n_dof(), count, |i, j| if i == j { 1.0 } else { 0.0 });
    rigid.relieve(relieved.as_mut());
    // Forces of one newton; the stiffness itself is of the order of 1e7 N/m.
    assert!((&left - &relieved).norm_max() < 1e-10, "{:e}", (&left - &relieved).norm_max());
    let drift = rigid.momenta().transpose() * &found;
    assert!(drift.norm_max() < 1e-12 * found.norm_max(), "{drift:?}");

    // Three nodes far from each other, held as one holds a stool: 3, 2 and 1 components.
    let nodes = &model.mesh().nodes;
    let at = |p: [f64; 3]| nodes.iter().position(|x| (0..3).all(|c| (x[c] - p[c]).abs() < 1e-9)).unwrap();
    let [a, b, c] = [[0.0; 3], [0.4, 0.0, 0.0], [0.0, 0.2, 0.1]].map(at);
    let other = [3 * a, 3 * a + 1, 3 * a + 2, 3 * b + 1, 3 * b + 2, 3 * c + 2];
    let moved = pencil.clone().with_rigid(rigid.clone().with_pins(other));
    let again = answers(&moved, count);
    let off = (&again - &found).norm_max() / found.norm_max();
    assert!(off < 1e-11, "{off:e}");
    assert!(again != found, "the springs stand elsewhere");
}

#[test]
fn selected_entries_are_those_of_the_solves() {
    let model = brick(Order::Quadratic);
    let pencil = model.pencil();
    let symbolic = Symbolic::analyze(pencil).unwrap();
    let n = pencil.n_dof();
    let factor = symbolic.take_factor_of(pencil.stiffness()).unwrap();
    let selected = factor.select(pencil.mass(), 0..n, &Silent).unwrap();
    let inverse = answers(pencil, n);
    let mut weighed = Mat::zeros(n, n);
    pencil.mass().mul_into(inverse.as_ref(), weighed.as_mut());
    let weighted = inverse.transpose() * weighed;
    let mut compared = 0;
    for j in 0..n {
        for &i in pencil.mass().pattern().rows_of(j) {
            let i = i as usize;
            let off = (selected.inverse(i, j).unwrap() - inverse[(i, j)]).abs() / inverse.norm_max();
            assert!(off < 1e-10, "{off:e}");
            let off = (selected.weighted(i, j).unwrap() - weighted[(i, j)]).abs() / weighted.norm_max();
            assert!(off < 1e-9, "{off:e}");
            compared += 1;
        }
    }
    assert!(compared > 1000);
}

#[test]
fn modes_are_those_of_the_whole_pencil_less_six_of_no_frequency() {
    let model = brick(Order::Linear);
    let pencil = model.pencil();
    let n = pencil.n_dof();
    let dense = |a: &super::SymmetricMatrix| {
        let mut image = Mat::zeros(n, n);
        a.mul_into(Mat::<f64>::identity(n, n).as_ref(), image.as_mut());
        image
    };
    let (mass, stiffness) = (dense(pencil.mass()), dense(pencil.stiffness()));
    let lower = mass.llt(faer::Side::Lower).unwrap();
    let mut reduced = stiffness;
    solve_lower_triangular_in_place(lower.L(), reduced.as_mut(), Par::Seq);
    solve_lower_triangular_in_place(lower.L(), reduced.as_mut().transpose_mut(), Par::Seq);
    let all = reduced.self_adjoint_eigenvalues(faer::Side::Lower).unwrap();
    let symbolic = Symbolic::analyze(pencil).unwrap();
    // All of them, so that the search runs to its end.
    for count in [8, n - 6] {
        let modes = lowest_modes(pencil, &symbolic, count).unwrap();
        for (k, (found, expected)) in modes.eigenvalues.iter().zip(&all[6..]).enumerate() {
            assert!((found / expected - 1.0).abs() < 1e-8, "{count} {k}: {found} {expected}");
        }
        let drift = rigid(&model).momenta().transpose() * &modes.vectors;
        assert!(drift.norm_max() < 1e-9, "{:e}", drift.norm_max());
    }
    assert!(all[5].abs() < 1e-6 * all[6], "{:?}", &all[..7]);
    assert!(lowest_modes(pencil, &symbolic, n - 5).is_err());
}

/// Timoshenko's beam of a rectangle, free at both ends: roots of its closed form by bisection.
///
/// With `w = Σ c_i e^{α_i x}`, `θ' = w'' + (ω²ρ/κG) w` (Timoshenko 1921), the ends have no moment `θ'` and no
/// shear `w' − θ`; the determinant of these conditions is zero. `κ = 5(1 + ν)/(6 + 5ν)`, which fits the
/// vibrations of solid rectangles best (Kaneko, J. Phys. D 8, 1975, 1927–1936).
fn timoshenko(length: f64, thickness: f64, count: usize) -> Vec<f64> {
    let (young, poisson, density) = (1e7, 0.3, 1000.0);
    let shear = young / (2.0 * (1.0 + poisson));
    let kappa = 5.0 * (1.0 + poisson) / (6.0 + 5.0 * poisson);
    let gyration = thickness * thickness / 12.0;
    // Symmetric and antisymmetric motions about the middle apart: two conditions each, at x = L/2.
    let determinant = |omega: f64, even: bool| {
        let b = omega * omega * density / young;
        let s = omega * omega * density / (kappa * shear);
        // α⁴ + (s + b) α² + (s b − b/gyration) = 0 for w = e^{αx}.
        let half = 0.5 * (s + b);
        let root = (half * half - s * b + b / gyration).sqrt();
        let (p, q) = ((root - half).sqrt(), (root + half).sqrt());
        let x = 0.5 * length;
        // w: cosh px or sinh px, and cos qx or sin qx; θ' = w'' + s w.
        let (w1, d1) = if even { ((p * x).cosh(), (p * x).sinh()) } else { ((p * x).sinh(), (p * x).cosh()) };
        let (w2, d2) = if even { ((q * x).cos(), -(q * x).sin()) } else { ((q * x).sin(), (q * x).cos()) };
        let (m1, m2) = ((p * p + s) * w1, (s - q * q) * w2);
        // w' − θ, with θ the integral of θ': of the factor (p² + s)/p of w1's integral.
        let (v1, v2) = ((p - (p * p + s) / p) * d1, (q + (s - q * q) / q) * d2);
        (m1 * v2 - m2 * v1) / (w1.abs() + d1.abs())
    };
    let mut found = vec![];
    let euler = (young * gyration / density).sqrt() * (4.73 / length).powi(2);
    for even in [true, false] {
        let mut previous = (0.2 * euler, determinant(0.2 * euler, even));
        for k in 1..4000 {
            let omega = 0.2 * euler + k as f64 * 0.005 * euler;
            let value = determinant(omega, even);
            if value * previous.1 < 0.0 {
                let (mut low, mut high) = (previous.0, omega);
                for _ in 0..60 {
                    let middle = 0.5 * (low + high);
                    if determinant(middle, even) * previous.1 < 0.0 { high = middle } else { low = middle }
                }
                found.push(0.5 * (low + high) / TAU);
            }
            previous = (omega, value);
        }
    }
    found.sort_by(f64::total_cmp);
    found.truncate(count);
    found
}

#[test]
fn a_free_beam_swings_as_the_theory_of_beams_says() {
    // A square section, so that each frequency occurs in two planes.
    let (length, thickness) = (1.0, 0.04);
    let mesh = mesh::block([length, thickness, thickness], [50, 2, 2], Order::Quadratic);
    let free = vec![false; 3 * mesh.nodes.len()];
    let model = Model::assemble(mesh, &[RUBBER], &free).unwrap();
    let symbolic = Symbolic::analyze(model.pencil()).unwrap();
    let found = lowest_modes(model.pencil(), &symbolic, 8).unwrap().frequencies_hz();
    let theory = timoshenko(length, thickness, 3);
    // Bernoulli's beam is too high by more than is allowed here already for the first of them.
    let euler = (RUBBER.elasticity.modulus() / RUBBER.density / 12.0).sqrt()
        * thickness
        * (4.730_040_744_862_704_f64).powi(2);
    assert!((1.0 - theory[0] / (euler / TAU)).abs() > 2e-3);
    for (k, expected) in theory.iter().enumerate() {
        for plane in 0..2 {
            let off = found[2 * k + plane] / expected - 1.0;
            println!("bending {k}: {:.4} Hz, theory {expected:.4} Hz: {off:+.2e}", found[2 * k + plane]);
            assert!(off.abs() < 1e-3, "{k}: {off:e}");
        }
    }
}

#[test]
fn a_body_that_is_held_a_little_stays_refused_and_parts_are_named() {
    let mesh = block([2; 3], [1.0; 3]);
    let hinge = hold(&mesh, |p| p[0] == 0.0 && p[1] == 0.0);
    let refused = Model::assemble(mesh.clone(), &[RUBBER], &hinge).unwrap_err();
    assert!(matches!(refused, ModelError::Unsupported { n_modes: 1, .. }), "{refused}");

    let mut two = mesh.clone();
    let count = two.nodes.len() as u32;
    two.nodes.extend(mesh.nodes.iter().map(|x| [x[0] + 3.0, x[1], x[2]]));
    two.node_ids.extend(mesh.node_ids.iter().map(|id| id + 1000));
    two.elements.extend(mesh.elements.iter().map(|node| node + count));
    two.element_region.extend(mesh.element_region.clone());
    let free = vec![false; 3 * two.nodes.len()];
    let refused = Model::assemble(two, &[RUBBER], &free).unwrap_err();
    assert!(matches!(refused, ModelError::FreeParts { parts: 2, n_nodes: 27, .. }), "{refused}");
}
