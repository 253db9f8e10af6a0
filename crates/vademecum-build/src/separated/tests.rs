//! The engine alone: functions of known rank, and problems whose solution is known.

use super::*;
use crate::linalg::Random;
use faer::Mat;

/// A function on one axis.
type Function = fn(f64) -> f64;

fn hat(name: &str, lower: f64, upper: f64, points: usize) -> Axis {
    Axis::new(name, "1", lower, upper, AxisKind::Hat { points }, false).unwrap()
}

/// Fits `Σ_s Π_a f_sa` (rows of `functions`) as a Galerkin problem whose operators are the Gram matrices.
fn gram_problem(axes: &[Axis], functions: &[Vec<Function>], blocks: &[Mat<f64>]) -> Problem<DenseSpace> {
    let n = blocks[0].nrows();
    let source = |(fs, block): (&Vec<Function>, &Mat<f64>)| Source {
        vectors: axes
            .iter()
            .zip(fs)
            .map(|(a, f)| a.gram().apply(&a.nodes().iter().map(|&x| f(x)).collect::<Vec<_>>()))
            .collect(),
        block: block.clone(),
    };
    let sources = functions.iter().zip(blocks).map(source).collect();
    let operators = vec![axes.iter().map(Axis::gram).collect()];
    let space = DenseSpace::new(vec![Mat::identity(n, n)]).unwrap();
    Problem::new(axes.to_vec(), operators, space, sources).unwrap()
}

fn one(_: f64) -> f64 {
    1.0
}

fn unit_block() -> Mat<f64> {
    Mat::from_fn(1, 1, |_, _| 1.0)
}

#[test]
fn a_rank_one_function_takes_one_term() {
    let axes = [hat("x", 0.0, 1.0, 11), hat("y", -1.0, 2.0, 17), hat("z", 1.0, 3.0, 9)];
    let functions: Vec<Vec<Function>> = vec![vec![f64::exp, f64::cos, f64::ln]];
    let block = Mat::from_fn(3, 2, |i, j| 1.0 + i as f64 - 2.0 * j as f64);
    let problem = gram_problem(&axes, &functions, std::slice::from_ref(&block));
    let options = EnrichmentOptions { tolerance: 1e-13, ..Default::default() };
    let (u, report) = enrich(&problem, &options, None, None).unwrap();
    assert_eq!((u.n_terms(), report.stop), (1, StopReason::Tolerance));
    let (x, y, z) = (axes[0].nodes()[3], axes[1].nodes()[5], axes[2].nodes()[7]);
    let value = u.evaluate(&[x, y, z]).unwrap();
    let exact = x.exp() * y.cos() * z.ln();
    for i in 0..3 {
        for j in 0..2 {
            assert!(
                (value[(i, j)] - exact * block[(i, j)]).abs() < 1e-11 * exact,
                "tolerance 1e-13, mass condition ~ 10"
            );
        }
    }
}

#[test]
fn the_sine_of_a_sum_takes_two_terms_and_of_three_takes_its_known_rank() {
    let axes = [hat("x", 0.0, 3.0, 31), hat("y", 0.0, 3.0, 31)];
    let functions: Vec<Vec<Function>> = vec![vec![f64::sin, f64::cos], vec![f64::cos, f64::sin]];
    let problem = gram_problem(&axes, &functions, &[unit_block(), unit_block()]);
    // Rounding of a Galerkin fit: Gram matrices of two nearly orthogonal terms, a few ε times the mass condition.
    let options =
        EnrichmentOptions { tolerance: 1e-10, max_terms: 3, update_sweeps: 10, ..Default::default() };
    let (u, report) = enrich(&problem, &options, None, None).unwrap();
    assert_eq!((u.n_terms(), report.stop), (2, StopReason::Tolerance), "{report:?}");

    // sin(x+y+z) expands into 2² products; its rank over the reals is 3. Updated greedy must not need more than the 4.
    let axes = [hat("x", 0.0, 3.0, 16), hat("y", 0.0, 3.0, 16), hat("z", 0.0, 3.0, 16)];
    let (s, c): (Function, Function) = (f64::sin, f64::cos);
    let minus_sin: Function = |x| -x.sin();
    let functions = vec![vec![s, c, c], vec![c, s, c], vec![c, c, s], vec![minus_sin, s, s]];
    let blocks = vec![unit_block(); 4];
    let problem = gram_problem(&axes, &functions, &blocks);
    let options =
        EnrichmentOptions { tolerance: 1e-8, max_terms: 6, update_sweeps: 60, ..Default::default() };
    let (u, report) = enrich(&problem, &options, None, None).unwrap();
    assert!(u.n_terms() <= 4 && report.stop == StopReason::Tolerance, "{report:?}");
}

#[test]
fn updates_recover_a_sum_of_one_axis_terms_that_plain_greedy_does_not() {
    // x + y + z on [0, 1]³ with blocks in general position: rank 3, the shape of the canonical problem.
    let axes = [hat("x", -1.0, 1.0, 5), hat("y", -1.0, 1.0, 5), hat("z", -1.0, 1.0, 5)];
    let x: Function = |x| x;
    let functions = vec![vec![x, one as Function, one], vec![one, x, one], vec![one, one, x]];
    let mut random = Random::new(3);
    let blocks: Vec<_> = (0..3).map(|_| Mat::from_fn(6, 1, |_, _| random.uniform() - 0.5)).collect();
    let problem = gram_problem(&axes, &functions, &blocks);
    let options = EnrichmentOptions { tolerance: 1e-12, max_terms: 3, ..Default::default() };
    let plain = EnrichmentOptions { update_sweeps: 0, ..options.clone() };
    let (_, greedy) = enrich(&problem, &plain, None, None).unwrap();
    let started = EnrichmentOptions { start_at_sources: true, ..plain };
    let (_, exact) = enrich(&problem, &started, None, None).unwrap();
    assert!(greedy.error > 1e-6, "greedy alone wanders: {greedy:?}");
    assert_eq!(exact.stop, StopReason::Tolerance, "{exact:?}");
}

/// −Δu = f on the unit square with f of known solution sin πx sin πy: hat functions on y, finite elements on x.
fn poisson(points: usize) -> Problem<SparseSpace> {
    use faer::sparse::{SparseColMat, Triplet};
    let y = hat("y", 0.0, 1.0, points);
    let (mass, stiffness) = (y.gram(), y.stiffness().unwrap());
    let inside = points - 2;
    let sparse = |o: &AxisOperator| {
        let (l, d, _) = o.parts();
        let mut entries: Vec<_> = (0..inside).map(|j| Triplet::new(j, j, d[j + 1])).collect();
        (1..inside)
            .for_each(|j| entries.extend([Triplet::new(j, j - 1, l[j]), Triplet::new(j - 1, j, l[j])]));
        SparseColMat::try_new_from_triplets(inside, inside, &entries).unwrap()
    };
    // Supports on the y axis: a stiff spring at both ends, the way the engine's axes know it.
    let spring = 1e8;
    let (l, d, u) = stiffness.parts();
    let mut held = d.to_vec();
    held[0] += spring;
    held[points - 1] += spring;
    let held = AxisOperator::tridiagonal(l.to_vec(), held, u.to_vec());
    let shape: Vec<f64> = y.nodes().iter().map(|t| (std::f64::consts::PI * t).sin()).collect();
    let load = mass.apply(&shape);
    let block = Mat::from_fn(inside, 1, |j, _| 2.0 * std::f64::consts::PI.powi(2) * load[j + 1]);
    let space = SparseSpace::new(vec![sparse(&stiffness), sparse(&mass)]).unwrap();
    Problem::new(vec![y], vec![vec![mass], vec![held]], space, vec![Source { vectors: vec![load], block }])
        .unwrap()
}

#[test]
fn the_poisson_problem_with_sources_converges_at_second_order() {
    let error = |points: usize| {
        let problem = poisson(points);
        let options =
            EnrichmentOptions { tolerance: 1e-10, max_terms: 8, update_sweeps: 2, ..Default::default() };
        let (u, report) = enrich(&problem, &options, None, None).unwrap();
        assert_eq!(report.stop, StopReason::Tolerance, "{report:?}");
        let middle = u.evaluate(&[0.5]).unwrap()[((points - 3) / 2, 0)];
        (middle - 1.0).abs()
    };
    let (coarse, fine) = (error(17), error(33));
    // u = sin πx sin πy is 1 in the middle; bilinear elements are of order 2 (the spring adds 2π²/1e8 ≪ h²).
    let rate = (coarse / fine).log2();
    assert!((rate - 2.0).abs() < 0.1, "rate {rate}: {coarse} {fine}");
}

#[test]
fn two_runs_give_the_same_bits_whatever_the_threads() {
    let axes = [hat("x", 0.0, 3.0, 12), hat("y", 0.5, 3.0, 13), hat("z", 0.0, 1.0, 8)];
    let functions: Vec<Vec<Function>> =
        vec![vec![f64::sin, f64::ln, f64::exp], vec![f64::cos, f64::sin, one], vec![one, f64::exp, f64::sin]];
    let blocks: Vec<_> =
        (0..3).map(|k| Mat::from_fn(4, 2, |i, j| ((i + 2 * j + 3 * k) as f64).sin())).collect();
    let problem = gram_problem(&axes, &functions, &blocks);
    let run = || {
        enrich(
            &problem,
            &EnrichmentOptions { max_terms: 5, tolerance: 1e-12, ..Default::default() },
            None,
            None,
        )
    };
    let (u, report) = run().unwrap();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let (v, again) = pool.install(run).unwrap();
    assert_eq!(report, again);
    assert_eq!(u.blocks(), v.blocks());
    (0..3).for_each(|a| assert_eq!(u.factors(a), v.factors(a)));
}

#[test]
fn recompression_keeps_its_tolerance() {
    let axes = [hat("x", 0.0, 3.0, 20), hat("y", 0.0, 3.0, 20)];
    // sin(x + y) written with twice the terms it needs
    let f = |k: usize, a: usize, x: f64| match (k % 2, a) {
        (0, 0) | (1, 1) => x.sin(),
        _ => x.cos(),
    };
    let factors: Vec<Mat<f64>> =
        (0..2).map(|a| Mat::from_fn(20, 4, |j, k| f(k, a, axes[a].nodes()[j]))).collect();
    let blocks = Mat::from_fn(6, 4, |i, k| (i as f64 + 1.0) * if k < 2 { 0.25 } else { 0.75 });
    let u = Separated::new(axes.to_vec(), factors, blocks, 3).unwrap();
    let v = recompress(&u, 1e-9).unwrap();
    assert_eq!(v.n_terms(), 2);
    let (mut gap, mut size) = (0.0, 0.0);
    for i in 0..20 {
        for j in 0..20 {
            let (a, b) = (u.combine(&u.weights_at(&[i, j])), v.combine(&v.weights_at(&[i, j])));
            gap += (&a - &b).norm_l2().powi(2);
            size += a.norm_l2().powi(2);
        }
    }
    assert!(gap.sqrt() <= 1e-9 * size.sqrt(), "the tolerance asked for, over all 400 grid points");
}

#[test]
fn recompression_on_one_axis_is_the_truncated_decomposition() {
    let kind = AxisKind::Chebyshev { points: 25 };
    let axis = Axis::new("theta", "1", 1e-2, 1.0, kind, true).unwrap();
    // 1/(1 + θ λ_k) for 40 λ: all 25 grid columns as terms, of which few are needed.
    let lambda = |k: usize| 10f64.powf(-2.0 + 0.1 * k as f64);
    let blocks = Mat::from_fn(40, 25, |k, j| 1.0 / (1.0 + axis.nodes()[j] * lambda(k)));
    let u = Separated::new(vec![axis.clone()], vec![Mat::identity(25, 25)], blocks, 40).unwrap();
    let mut fewest = 25;
    for tolerance in [1e-4, 1e-6, 1e-8] {
        let v = recompress(&u, tolerance).unwrap();
        let difference =
            u.concatenate(&v.expand((Mat::<f64>::identity(40, 40) * faer::Scale(-1.0)).as_ref()).unwrap());
        let weights = axis.weights();
        let norm = |w: &Separated| {
            let at = |j: usize| weights[j] * w.combine(&w.weights_at(&[j])).norm_l2().powi(2);
            (0..25).map(at).sum::<f64>().sqrt()
        };
        assert!(
            norm(&difference.unwrap()) <= 1.0001 * tolerance * norm(&u),
            "the discarded tail, plus 1e-2 of it in space"
        );
        fewest = fewest.min(v.n_terms());
    }
    assert!(
        (4..=12).contains(&fewest)
            && recompress(&u, 1e-4).unwrap().n_terms() < recompress(&u, 1e-8).unwrap().n_terms()
    );
}
