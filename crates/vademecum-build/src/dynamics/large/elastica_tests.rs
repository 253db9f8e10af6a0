//! Rest at large displacements against the elastica, the linear solution and Newton's own theory.

use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_2, TAU};

use super::test_beam::{cantilever, end_load, hexahedra, moved, nearest};
use super::vectors::{add, dot, times};
use super::{LargeError, Newton, RestOptions, rest};
use crate::fem::{GreenStrain, Material, Model, Solve, Symbolic};
use crate::mesh::{ElementKind, Hexahedra};

const LONG: f64 = 1.0;

fn slender(height: f64, cells: usize) -> Model {
    let material = Material::isotropic(1e9, 0.0, 1000.0);
    cantilever([cells, 1, 1], [LONG, height, height], material, true)
}

/// `EI` of the beam.
fn bending(height: f64) -> f64 {
    1e9 * height.powi(4) / 12.0
}

/// `∫ f` from `a` to `b` by Simpson's rule.
fn integral(f: impl Fn(f64) -> f64, [a, b]: [f64; 2]) -> f64 {
    let n = 2000;
    let h = (b - a) / f64::from(n);
    let inner = (1..n).map(|i| if i % 2 == 1 { 4.0 } else { 2.0 } * f(a + h * f64::from(i)));
    h / 3.0 * (f(a) + f(b) + inner.sum::<f64>())
}

/// Angle, deflection and shortening of the tip of an inextensible cantilever of length 1 under a dead end
/// load `α = P L²/EI` (Bisshopp and Drucker 1945).
fn elastica(alpha: f64) -> [f64; 3] {
    // √α = K(p) − F(φ₁), p² = (1 + sin θ)/2, sin φ₁ = 1/(p√2).
    let load = |angle: f64| {
        let p2 = 0.5 * (1.0 + angle.sin());
        let first = (FRAC_1_SQRT_2 / p2.sqrt()).asin();
        let whole = integral(|phi| 1.0 / (1.0 - p2 * phi.sin().powi(2)).sqrt(), [first, FRAC_PI_2]);
        let height = integral(|phi| (1.0 - p2 * phi.sin().powi(2)).sqrt(), [first, FRAC_PI_2]);
        (whole * whole, height)
    };
    let (mut low, mut high) = (0.0, FRAC_PI_2 - 1e-9);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if load(middle).0 < alpha { low = middle } else { high = middle }
    }
    let angle = 0.5 * (low + high);
    let root = alpha.sqrt();
    [angle, 1.0 - 2.0 / root * load(angle).1, 1.0 - (2.0 * angle.sin() / alpha).sqrt()]
}

#[test]
fn the_elastica_of_this_test_is_the_printed_one() {
    // Mattiasson 1981, table 1.
    for (alpha, printed) in [(1.0, [0.46135, 0.30172, 0.05643]), (10.0, [1.43029, 0.81061, 0.55500])] {
        let found = elastica(alpha);
        assert!((0..3).all(|k| (found[k] - printed[k]).abs() < 0.51e-5), "{alpha} {found:?}");
    }
}

/// Displacement of the tip of a beam of square section, aside and back, under a dead end load.
fn tip(model: &Model, alpha: f64, height: f64) -> [f64; 2] {
    let strain = GreenStrain::new(model).expect("a strain field");
    let symbolic = Symbolic::analyze(model.pencil()).expect("a structure");
    let traction = alpha * bending(height) / (height * height);
    let load = end_load(model, [0.0, traction, 0.0], |_| 1.0);
    let options = RestOptions { parts: 4, ..RestOptions::default() };
    let zero = vec![0.0; strain.n_dof()];
    let found = rest(&strain, &symbolic, &zero, &mut |s, f| add(f, s, &load), &options).expect("a rest");
    let tip = moved(model, &found.displacement, nearest(model, [LONG, height / 2.0, height / 2.0]));
    println!("{} steps, {} iterations", found.load_steps, found.iterations);
    [tip[1], -tip[0]]
}

#[test]
fn a_slender_cantilever_bends_as_the_elastica_does() {
    for (alpha, height) in [(1.0, 0.02), (10.0, 0.02), (10.0, 0.01)] {
        let found = tip(&slender(height, 40), alpha, height);
        let [_, up, back] = elastica(alpha);
        println!("alpha {alpha} h {height}: {found:.5?}, {up:.5} {back:.5}");
        assert!((found[0] - up).abs() < 1e-3 && (found[1] - back).abs() < 1e-3);
    }
}

#[test]
fn a_slender_cantilever_of_hexahedra_bends_as_the_elastica_does() {
    let (alpha, height) = (10.0, 0.02);
    let [_, up, back] = elastica(alpha);
    for kind in [
        (ElementKind::Hex20, Hexahedra::Full),
        (ElementKind::Hex20, Hexahedra::Reduced),
        (ElementKind::Hex27, Hexahedra::Full),
    ] {
        let material = Material::isotropic(1e9, 0.0, 1000.0);
        let model = hexahedra(kind, [40, 1, 1], [LONG, height, height], material, true);
        let found = tip(&model, alpha, height);
        println!("{kind:?}: {found:.5?}, {up:.5} {back:.5}");
        assert!((found[0] - up).abs() < 1e-3 && (found[1] - back).abs() < 1e-3, "{kind:?}");
    }
}

/// Displacement of the end of a thick cantilever across it, under a traction there.
fn bent(kind: (ElementKind, Hexahedra), poisson: f64) -> f64 {
    let material = Material::isotropic(1e6, poisson, 1000.0);
    let model = hexahedra(kind, [8, 2, 2], [1.0, 0.25, 0.25], material, false);
    let strain = GreenStrain::new(&model).expect("a strain field");
    let symbolic = Symbolic::analyze(model.pencil()).expect("a structure");
    let load = end_load(&model, [0.0, 8e3, 0.0], |_| 1.0);
    let zero = vec![0.0; strain.n_dof()];
    let options = RestOptions::default();
    let found = rest(&strain, &symbolic, &zero, &mut |s, f| add(f, s, &load), &options).expect("a rest");
    moved(&model, &found.displacement, nearest(&model, [1.0, 0.125, 0.125]))[1]
}

#[test]
fn mean_dilatation_keeps_the_volume_without_locking() {
    let [quadratic, reduced, mean, full] = [
        (ElementKind::Hex20, Hexahedra::Full),
        (ElementKind::Hex20, Hexahedra::Reduced),
        (ElementKind::Hex8, Hexahedra::MeanDilatation),
        (ElementKind::Hex8, Hexahedra::Full),
    ]
    .map(|kind| [0.3, 0.4999].map(|poisson| bent(kind, poisson)));
    println!("{quadratic:.4?} {reduced:.4?} {mean:.4?} {full:.4?}");
    // Full integration of twenty nodes locks a little there itself.
    assert!((reduced[1] / quadratic[1] - 1.0).abs() < 0.05);
    assert!(mean[1] / quadratic[1] > 0.95 * mean[0] / quadratic[0]);
    assert!(full[1] < 0.5 * mean[1]);
}

#[test]
fn an_end_moment_rolls_a_beam_up_to_a_ring() {
    let height = 0.01;
    let model = slender(height, 120);
    let strain = GreenStrain::new(&model).expect("a strain field");
    let symbolic = Symbolic::analyze(model.pencil()).expect("a structure");
    // A couple that turns with the angle the end is to have: a dead load for each load step.
    let lever = |y: f64| -12.0 * (y - 0.5 * height) / height.powi(4);
    let couple = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]].map(|along| end_load(&model, along, lever));
    let mut load = |s: f64, f: &mut [f64]| {
        let (sine, cosine) = (TAU * s).sin_cos();
        let moment = bending(height) * TAU * s / LONG;
        add(f, moment * cosine, &couple[0]);
        add(f, moment * sine, &couple[1]);
    };
    let options = RestOptions { parts: 24, ..RestOptions::default() };
    let zero = vec![0.0; strain.n_dof()];
    let found = rest(&strain, &symbolic, &zero, &mut load, &options).expect("a ring");
    let tip = moved(&model, &found.displacement, nearest(&model, [LONG, height / 2.0, height / 2.0]));
    // By hand, to the next order in κh: with F = 1 + e, e = ε − κy, the axial force per area of St. Venant
    // and Kirchhoff is E(e + 3e²/2 + e³/2). No axial force means ε = −(κh)²/8, which takes 3/10 (κh)² of the
    // moment. Its fibres press on each other by Eκ²(h²/4 − y²)/2, which flattens the section and takes a
    // further 1/5: M = EIκ(1 − (κh)²/2).
    let slack = (TAU * height).powi(2);
    let angle = TAU * (1.0 + 0.5 * slack);
    let length = 1.0 - slack / 8.0;
    let expected = [length / angle * angle.sin() - 1.0, length / angle * (1.0 - angle.cos())];
    println!(
        "ring h {height}: {:.5} {:.5}, expected {expected:.5?}; {} steps, {} iterations",
        tip[0], tip[1], found.load_steps, found.iterations
    );
    // Half the cells are 1.4e-3 off, which falls with their square or faster.
    assert!((tip[0] - expected[0]).abs() < 5e-4 && (tip[1] - expected[1]).abs() < 5e-4);
}

#[test]
fn newton_converges_quadratically() {
    let model = slender(0.05, 12);
    let strain = GreenStrain::new(&model).expect("a strain field");
    let symbolic = Symbolic::analyze(model.pencil()).expect("a structure");
    let traction = 2.0 * bending(0.05) / (0.05 * 0.05);
    let load = end_load(&model, [0.0, traction, 0.0], |_| 1.0);
    let newton = Newton { tolerance: 1e-12, keep: 0.0, ..Newton::default() };
    let options = RestOptions { newton, ..RestOptions::default() };
    let zero = vec![0.0; strain.n_dof()];
    let found = rest(&strain, &symbolic, &zero, &mut |s, f| add(f, s, &load), &options).expect("a rest");
    println!("{:?}", found.corrections);
    assert_eq!(found.load_steps, 1);
    // Below one part in a hundred each correction is the square of the one before, times some constant.
    let near: Vec<f64> = found.corrections.iter().copied().filter(|&c| c < 1e-2 && c > 1e-11).collect();
    let pairs: Vec<f64> = near.windows(2).map(|pair| pair[1].ln() / pair[0].ln()).collect();
    assert!(!pairs.is_empty() && pairs.iter().all(|order| *order > 1.7), "{:?}", found.corrections);
}

#[test]
fn a_small_load_bends_as_the_linear_solver_says() {
    let material = Material::isotropic(1e7, 0.3, 1000.0);
    let model = cantilever([6, 2, 2], [1.0, 0.2, 0.2], material, false);
    let strain = GreenStrain::new(&model).expect("a strain field");
    let symbolic = Symbolic::analyze(model.pencil()).expect("a structure");
    let load = end_load(&model, [0.3, 1.0, -0.5], |_| 1.0);
    let factor = symbolic.factor_of(model.pencil().stiffness()).expect("a held body");
    let n = load.len();
    let mut linear = load.clone();
    let column = faer::MatMut::from_column_major_slice_mut(&mut linear, n, 1);
    Solve::new(&symbolic, 1, true).solve_in_place(&factor, column);
    let difference = |scale: f64| {
        let zero = vec![0.0; n];
        let options = RestOptions::default();
        let found = rest(&strain, &symbolic, &zero, &mut |s, f| add(f, s * scale, &load), &options);
        let found = found.expect("a rest").displacement;
        let off: Vec<f64> = found.iter().zip(&linear).map(|(u, l)| u / scale - l).collect();
        (dot(&off, &off) / dot(&linear, &linear)).sqrt()
    };
    // The difference is of the first order in the load.
    let [large, small] = [1.0, 0.01].map(difference);
    println!("{large:.2e} {small:.2e}");
    assert!((0.5..2.0).contains(&(large / small / 100.0)) && small < 1e-4);
    // And the force balances the load to rounding.
    let mut force = vec![0.0; n];
    strain.force(&linear.iter().map(|u| 1e-9 * u).collect::<Vec<_>>(), &mut force);
    let product = times(model.pencil().stiffness(), &linear);
    assert!(force.iter().zip(&product).all(|(f, k)| (f * 1e9 - k).abs() < 1e-5));
}

#[test]
fn what_has_no_rest_is_named() {
    let material = Material::isotropic(1e7, 0.3, 1000.0);
    let model = cantilever([2, 1, 1], [0.4, 0.2, 0.2], material, false);
    let strain = GreenStrain::new(&model).expect("a strain field");
    let symbolic = Symbolic::analyze(model.pencil()).expect("a structure");
    let zero = vec![0.0; strain.n_dof()];
    // Nominal stress under compression is at most E/√27 for this law; this is twice as much.
    let load = end_load(&model, [-4e6, 0.0, 0.0], |_| 1.0);
    let options = RestOptions { halvings: 4, ..RestOptions::default() };
    let refused = rest(&strain, &symbolic, &zero, &mut |s, f| add(f, s, &load), &options);
    let Err(LargeError::NoRest { reached, .. }) = refused else { panic!("{refused:?}") };
    assert!(reached > 0.0 && reached < 0.6, "{reached}");
    let no_number = rest(&strain, &symbolic, &zero, &mut |_, f| f[0] = f64::NAN, &options);
    assert_eq!(no_number.err(), Some(LargeError::Load { at: 1.0 }));
    let short = rest(&strain, &symbolic, &[0.0], &mut |_, _| {}, &options);
    assert!(matches!(short, Err(LargeError::Length { found: 1, .. })));
    let mesh = model.mesh().clone();
    let free = vec![false; 3 * mesh.nodes.len()];
    let body = Model::assemble(mesh, &[material], &free).expect("a model");
    let strain = GreenStrain::new(&body).expect("a strain field");
    let symbolic = Symbolic::analyze(body.pencil()).expect("a structure");
    let zero = vec![0.0; strain.n_dof()];
    let floating = rest(&strain, &symbolic, &zero, &mut |_, _| {}, &options);
    assert_eq!(floating.err(), Some(LargeError::FreeBody));
}
