//! Strain maps of a small beam.

use faer::linalg::solvers::Solve as _;
use faer::{Mat, Side};

use super::map::{ReducedStrain, StrainGram};
use super::prediction::Prediction;
use super::shapes::relaxed;
use super::states::TrainingStates;
use super::{LargeModel, LargeOptions, Pairs, Prior, StrainColumns, StrainLearner, columns, draw};
use crate::dynamics::large::{Newton, Relaxation};
use crate::dynamics::lowest_modes;
use crate::fem::GreenStrain;
use crate::input::Problem;
use crate::linalg::Random;
use crate::prepared::{Prepared, prepare};
use crate::progress::{Silent, Stopwatch};
use crate::store::StageCache;

fn beam() -> Prepared {
    let text = "[mesh]\nblock = { lengths = [1.0, 0.1, 0.12], divisions = [6, 1, 1] }\n\
                [[material]]\nyoung = 1e6\npoisson = 0.3\ndensity = 1000.0\n\
                [[support]]\non = { group = \"x_min\" }\n[time]\nstep = 1e-2\n";
    let problem = Problem::parse(text, "beam.toml", Default::default()).expect("a problem");
    prepare(&problem, &mut Stopwatch::new(&Silent), &Silent).expect("a model")
}

/// `½ |z(q)|²`.
fn energy(map: &ReducedStrain, q: &[f64]) -> f64 {
    let products = map.pairs.products(q);
    let row = |k: usize| -> f64 {
        let quadratic: f64 = products.iter().enumerate().map(|(j, m)| map.quadratic[(k, j)] * m).sum();
        quadratic + if k < q.len() { map.frequencies[k] * q[k] } else { 0.0 }
    };
    0.5 * (0..map.quadratic.nrows()).map(|k| row(k) * row(k)).sum::<f64>()
}

const OPTIONS: LargeOptions = LargeOptions { displacement: 0.3, coordinates: 12, rows: 12, states: 40 };

fn learnt(prepared: &Prepared, options: &LargeOptions) -> Vec<LargeModel> {
    let kept = StageCache::new(None, prepared, &Silent);
    let learner = StrainLearner::new(&prepared.body, &prepared.symbolic, options, &kept).expect("modes");
    let mut maps = learner.priors().expect("strain maps");
    maps.extend(learner.fitted(&maps[0]).expect("regressions"));
    maps
}

#[test]
fn all_rows_of_galerkin_have_the_energy_of_the_body() {
    let prepared = beam();
    let maps = learnt(&prepared, &LargeOptions { rows: 4096, ..OPTIONS });
    let strain = GreenStrain::new(&prepared.body.model).expect("a strain");
    let mut random = Random::new(3);
    let galerkin: Vec<_> = maps.iter().filter(|map| map.name.ends_with("Galerkin")).collect();
    assert_eq!(galerkin.len(), 3);
    for map in galerkin {
        let r = map.basis.eigenvalues.len();
        let q: Vec<f64> = map.basis.eigenvalues.iter().map(|l| (random.uniform() - 0.5) / l.sqrt()).collect();
        let u: Vec<f64> = (0..map.basis.vectors.nrows())
            .map(|i| (0..r).map(|k| map.basis.vectors[(i, k)] * q[k]).sum())
            .collect();
        let (found, exact) = (energy(&map.map, &q), strain.energy(&u));
        // The rows come from Gram matrices, which halve the digits.
        assert!((found - exact).abs() < 1e-7 * exact, "{found:e} {exact:e}");
    }
}

#[test]
fn a_basis_is_orthonormal_in_the_mass_and_its_stiffness_is_diagonal() {
    let prepared = beam();
    let pencil = prepared.body.model.pencil();
    for map in learnt(&prepared, &OPTIONS) {
        let v = &map.basis.vectors;
        let mut image = Mat::zeros(v.nrows(), v.ncols());
        let r = map.basis.eigenvalues.len();
        assert_eq!(r, OPTIONS.coordinates);
        pencil.mass().mul_into(v.as_ref(), image.as_mut());
        let mass = v.transpose() * &image;
        pencil.stiffness().mul_into(v.as_ref(), image.as_mut());
        let stiffness = v.transpose() * &image;
        for i in 0..r {
            for j in 0..r {
                let unit = f64::from(u8::from(i == j));
                assert!((mass[(i, j)] - unit).abs() < 1e-9, "{} {i} {j}", map.name);
                let size = (map.basis.eigenvalues[i] * map.basis.eigenvalues[j]).sqrt();
                assert!((stiffness[(i, j)] / size - unit).abs() < 1e-8, "{} {i} {j}", map.name);
            }
        }
        assert!(map.basis.eigenvalues.is_sorted());
    }
}

#[test]
fn relaxing_what_the_basis_cannot_show_leaves_its_own_rows_and_lowers_the_energy() {
    let prepared = beam();
    let pencil = prepared.body.model.pencil();
    let strain = GreenStrain::new(&prepared.body.model).expect("a strain");
    let modes = lowest_modes(pencil, &prepared.symbolic, 6).expect("modes");
    let factor = prepared.symbolic.factor_of(pencil.stiffness()).expect("a factor");
    let pairs = Pairs { interacting: 6 };
    let q = Mat::from_fn(6, 9, |i, s| 1e-3 * ((1 + i * 5 + s * 3) % 7) as f64);
    let [plain, relaxed] = [Prior::Galerkin, Prior::Relaxed].map(|prior| {
        let basis = (modes.vectors.as_ref(), modes.eigenvalues.as_slice());
        let found = columns(&strain, basis, pairs, prior, (&prepared.symbolic, &factor));
        found.gram().rows(q.as_ref(), pairs.count()).expect("rows")
    });
    let size = plain.quadratic.subrows(0, 6).norm_max();
    for k in 0..6 {
        for j in 0..pairs.count() {
            let off = (plain.quadratic[(k, j)] - relaxed.quadratic[(k, j)]).abs();
            assert!(off < 1e-7 * size, "{k} {j} {off:e} {size:e}");
        }
    }
    for s in 0..9 {
        let q: Vec<f64> = (0..6).map(|i| 100.0 * q[(i, s)]).collect();
        assert!(energy(&relaxed, &q) < energy(&plain, &q));
        // And never below what the body has when it is let go: nothing is.
        assert!(energy(&relaxed, &q) > 0.0);
    }
}

#[test]
fn regressions_teach_the_energy_of_states_that_nobody_saw() {
    let prepared = beam();
    let pencil = prepared.body.model.pencil();
    let strain = GreenStrain::new(&prepared.body.model).expect("a strain");
    let coordinates = OPTIONS.coordinates;
    let options = LargeOptions { states: LargeOptions::states_of(coordinates), ..OPTIONS };
    let maps = learnt(&prepared, &options);
    // The shares of natural modes: 2, 3 and 6 of 12.
    let modes = lowest_modes(pencil, &prepared.symbolic, 2).expect("modes");
    let moving = super::learn::at_load_nodes(&prepared.body, modes.vectors.as_ref());
    let drawn = draw(moving.as_ref(), &modes.eigenvalues, options.displacement, 20, 77);
    let factor = prepared.symbolic.factor_of(pencil.stiffness()).expect("a factor");
    let own = (modes.vectors.as_ref(), modes.eigenvalues.as_slice());
    let prediction = Prediction::new(&strain, own, (&prepared.symbolic, &factor));
    let shapes = relaxed(&prediction, &prepared.symbolic, drawn.as_ref(), &Silent);
    let shapes = shapes.expect("shapes");
    let off = |map: &LargeModel| {
        let mut momenta = Mat::zeros(map.basis.vectors.nrows(), map.basis.vectors.ncols());
        pencil.mass().mul_into(map.basis.vectors.as_ref(), momenta.as_mut());
        let states = TrainingStates::new(&strain, momenta.as_ref(), &shapes);
        let each = states.energies.iter().enumerate();
        let square =
            |(s, e): (usize, &f64)| (energy(&map.map, states.coordinates.col_as_slice(s)) / e - 1.0).powi(2);
        (each.map(square).sum::<f64>() / shapes.len() as f64).sqrt()
    };
    let fitted = |map: &&LargeModel| map.name.contains("fitted");
    let before = off(&maps[0]);
    assert_eq!(maps.iter().filter(fitted).count(), 3);
    for map in maps.iter().filter(fitted) {
        let after = off(map);
        assert!(after < 0.5 * before, "{}: {before:e} {after:e}", map.name);
    }
}

#[test]
fn half_of_the_states_of_a_regression_move_in_the_fewest_modes() {
    let prepared = beam();
    let kept = StageCache::new(None, &prepared, &Silent);
    let learner = StrainLearner::new(&prepared.body, &prepared.symbolic, &OPTIONS, &kept).expect("modes");
    let priors = learner.priors().expect("strain maps");
    let energies = |map: &LargeModel| learner.fitted(map).expect("regressions").swap_remove(0).energies;
    let [few, more] = [&priors[0], &priors[4]];
    assert_eq!([few.modes, more.modes], [2, 6]);
    let (few, more) = (energies(few), energies(more));
    assert_eq!([few.len(), more.len()], [OPTIONS.states; 2]);
    let apart = |s: usize| (few[s] / more[s] - 1.0).abs();
    let half = OPTIONS.states / 2;
    assert!((0..half).all(|s| apart(s) < 1e-9));
    assert!((half..OPTIONS.states).all(|s| apart(s) > 1e-6));
}

#[test]
fn a_prediction_leads_to_the_shape_that_is_found_from_rest_and_sooner() {
    let prepared = beam();
    let pencil = prepared.body.model.pencil();
    let strain = GreenStrain::new(&prepared.body.model).expect("a strain");
    let modes = lowest_modes(pencil, &prepared.symbolic, 6).expect("modes");
    let factor = prepared.symbolic.factor_of(pencil.stiffness()).expect("a factor");
    let own = (modes.vectors.as_ref(), modes.eigenvalues.as_slice());
    let prediction = Prediction::new(&strain, own, (&prepared.symbolic, &factor));
    let moving = super::learn::at_load_nodes(&prepared.body, modes.vectors.as_ref());
    let drawn = draw(moving.as_ref(), &modes.eigenvalues, OPTIONS.displacement, 12, 5);
    let distance =
        |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt() };
    let mut factorisations = [0, 0];
    for q in drawn.col_iter() {
        let q: Vec<f64> = q.iter().copied().collect();
        let search = |newton| Relaxation::new(&strain, &prepared.symbolic, own.0, newton).expect("a search");
        let newton = Newton { keep: 0.0, ..Newton::default() };
        let from_rest = search(newton).relax(None, &q).expect("a shape");
        let guess = prediction.at(&q);
        let found = search(Newton::default()).relax(Some(guess.clone()), &q).expect("a shape");
        let (whole, apart) = (
            distance(&from_rest.displacement, &vec![0.0; strain.n_dof()]),
            distance(&from_rest.displacement, &found.displacement),
        );
        assert!(apart < 1e-7 * whole, "{apart:e} {whole:e}");
        // It is a better guess than the modes alone are.
        let linear = own.0 * faer::ColRef::from_slice(&q);
        let linear: Vec<f64> = linear.iter().copied().collect();
        let off = |u: &[f64]| distance(u, &from_rest.displacement);
        assert!(off(&guess.displacement) < 0.7 * off(&linear), "{:e}", off(&guess.displacement));
        factorisations[0] += from_rest.factorisations;
        factorisations[1] += found.factorisations;
    }
    println!("{factorisations:?} factorisations");
    assert!(2 * factorisations[1] < factorisations[0], "{factorisations:?}");
}

#[test]
fn a_regression_meets_the_states_better_than_what_it_began_with() {
    let prepared = beam();
    let maps = learnt(&prepared, &OPTIONS);
    let strain = GreenStrain::new(&prepared.body.model).expect("a strain");
    let pencil = prepared.body.model.pencil();
    let factor = prepared.symbolic.factor_of(pencil.stiffness()).expect("a factor");
    let map = &maps[0];
    let mut momenta = Mat::zeros(map.basis.vectors.nrows(), map.basis.vectors.ncols());
    pencil.mass().mul_into(map.basis.vectors.as_ref(), momenta.as_mut());
    let shapes: Vec<Vec<f64>> = (0..map.states.ncols())
        .map(|s| {
            let of = |i: usize| (0..12).map(|k| map.basis.vectors[(i, k)] * map.states[(k, s)]).sum();
            (0..map.basis.vectors.nrows()).map(of).collect()
        })
        .collect();
    let states = TrainingStates::new(&strain, momenta.as_ref(), &shapes);
    let pairs = Pairs { interacting: 12 };
    let basis = (map.basis.vectors.as_ref(), map.basis.eigenvalues.as_slice());
    let found = columns(&strain, basis, pairs, Prior::Relaxed, (&prepared.symbolic, &factor));
    let off = |gram: &StrainGram| -> f64 {
        let map = gram.rows(states.coordinates.as_ref(), pairs.count()).expect("rows");
        let each = states.energies.iter().enumerate();
        each.map(|(s, e)| (energy(&map, states.coordinates.col_as_slice(s)) / e - 1.0).powi(2)).sum()
    };
    let before = off(&found.gram());
    let after = off(&found.fitted(&states, &[1.0]).expect("a regression")[0]);
    assert!(after < 0.5 * before, "{before:e} {after:e}");
}

/// Each regression by its equations, on the full strains and one after the other.
#[test]
fn a_sequence_of_regressions_is_what_its_equations_say() {
    let mut random = Random::new(11);
    let pairs = Pairs { interacting: 5 };
    let (rows, p, count, frequencies) = (5000, pairs.count(), 40, vec![1.0, 2.0, 3.0, 4.0, 5.0]);
    let mut matrix = |n, m| Mat::from_fn(n, m, |_, _| random.uniform() - 0.5);
    // Two of the coordinates hardly move, so that some products are nearly not seen.
    let sizes = [1.0, 1.0, 1.0, 1e-3, 1e-3];
    let coordinates = Mat::from_fn(5, 5, |i, j| if i == j { sizes[i] } else { 0.0 }) * matrix(5, count);
    let columns = StrainColumns { frequencies, pairs, linear: matrix(rows, 5), quadratic: matrix(rows, p) };
    let energies: Vec<f64> = (0..count).map(|s| 0.5 + s as f64).collect();
    let states = TrainingStates { coordinates, strains: matrix(rows, count), energies };
    let ridges = [1.0, 1e-2, 1e-4];
    let found = columns.fitted(&states, &ridges).expect("regressions");

    let products = pairs.products_of(states.coordinates.as_ref());
    let weighted = Mat::from_fn(count, p, |s, j| products[(j, s)] / states.energies[s]);
    let gram = &products * &weighted;
    let mean = (0..p).map(|j| gram[(j, j)]).sum::<f64>() / p as f64;
    let mut quadratic = columns.quadratic.clone();
    for (ridge, found) in ridges.iter().zip(found) {
        let missing = &states.strains - &columns.linear * &states.coordinates - &quadratic * &products;
        let ridged = &gram + Mat::from_fn(p, p, |i, j| if i == j { ridge * mean } else { 0.0 });
        let factor = ridged.llt(Side::Lower).expect("a factor");
        quadratic += factor.solve((missing * &weighted).transpose()).transpose();
        let exact = StrainColumns { quadratic: quadratic.clone(), ..columns.clone() }.gram();
        let direct = quadratic.transpose() * &quadratic;
        let off = (&found.gram - &direct).norm_l2() / direct.norm_l2();
        assert!(off < 1e-9, "ridge {ridge}: {off:e}");
        assert!((&exact.gram - &direct).norm_l2() < 1e-12 * direct.norm_l2());
        let off = (&found.top - &exact.top).norm_l2() / exact.top.norm_l2();
        assert!(off < 1e-9, "ridge {ridge}: {off:e}");
    }
}

/// The rows hold as much of the rest on the states as any could, and never more than there is.
#[test]
fn rows_are_the_principal_directions_of_the_rest_on_states() {
    let mut random = Random::new(5);
    let pairs = Pairs { interacting: 7 };
    let p = pairs.count();
    // A rest with a spectrum of six decades beside rows of coordinates that do not matter here.
    let root = Mat::from_fn(p, p, |i, _| (random.uniform() - 0.5) * 10_f64.powf(-6.0 * i as f64 / p as f64));
    let gram = StrainGram {
        frequencies: vec![1.0; 7],
        pairs,
        top: Mat::zeros(7, p),
        gram: root.transpose() * &root,
    };
    let states = Mat::from_fn(7, 60, |_, _| random.uniform() - 0.5);
    let seen = &root * pairs.products_of(states.as_ref());
    let squares: Vec<f64> = seen.singular_values().expect("singular values").iter().map(|s| s * s).collect();
    for extra in [3, 8, 14, 20, p] {
        let rows = gram.rows(states.as_ref(), extra).expect("rows").quadratic;
        let rows = rows.subrows(7, extra);
        let held = (rows * pairs.products_of(states.as_ref())).squared_norm_l2();
        let most: f64 = squares[..extra].iter().sum();
        assert!(held < most * (1.0 + 1e-9), "{extra}: {held:e} {most:e}");
        if extra <= 14 || extra == p {
            assert!(held > most * (1.0 - 1e-6), "{extra}: {held:e} {most:e}");
        }
        let left = &gram.gram - rows.transpose() * rows;
        let least = left.self_adjoint_eigenvalues(Side::Lower).expect("eigenvalues")[0];
        assert!(least > -1e-9 * gram.gram.norm_max(), "{extra}: {least:e}");
    }
}
