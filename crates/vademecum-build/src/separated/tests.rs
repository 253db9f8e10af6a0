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
fn gram_problem(
    axes: &[Axis],
    functions: &[Vec<Function>],
    blocks: &[Mat<f64>],
) -> KroneckerProblem<DenseSpace> {
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
    KroneckerProblem::new(axes.to_vec(), operators, space, sources).unwrap()
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
    // Rounding of a Galerkin fit: Gram matrices of two nearly orthogonal terms, a few ε times the mass
    // condition.
    let options =
        EnrichmentOptions { tolerance: 1e-10, max_terms: 3, update_sweeps: 10, ..Default::default() };
    let (u, report) = enrich(&problem, &options, None, None).unwrap();
    assert_eq!((u.n_terms(), report.stop), (2, StopReason::Tolerance), "{report:?}");

    // sin(x+y+z) expands into 2² products; its rank over the reals is 3. Updated greedy must not need more
    // than the 4.
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
    // x + y + z on [−1, 1]³ with blocks in general position: rank 3, the shape of the chapter's problem.
    let axes = [hat("x", -1.0, 1.0, 5), hat("y", -1.0, 1.0, 5), hat("z", -1.0, 1.0, 5)];
    let x: Function = |x| x;
    let functions = vec![vec![x, one as Function, one], vec![one, x, one], vec![one, one, x]];
    let mut random = Random::new(3);
    let blocks: Vec<_> = (0..3).map(|_| Mat::from_fn(6, 1, |_, _| random.uniform() - 0.5)).collect();
    let problem = gram_problem(&axes, &functions, &blocks);
    let options =
        EnrichmentOptions { tolerance: 1e-12, max_terms: 3, update_sweeps: 0, ..Default::default() };
    let (_, greedy) = enrich(&problem, &options, None, None).unwrap();
    assert!(greedy.error > 1e-6, "greedy alone wanders: {greedy:?}");
    let updated = EnrichmentOptions { update_sweeps: 5, ..options.clone() };
    let (_, updated) = enrich(&problem, &updated, None, None).unwrap();
    assert_eq!(updated.stop, StopReason::Tolerance, "{updated:?}");
    let on_axis = |a: usize| Mat::from_fn(5, 3, |j, s| functions[s][a](axes[a].nodes()[j]));
    let known = Mat::from_fn(6, 3, |i, s| blocks[s][(i, 0)]);
    let start = Separated::new(axes.to_vec(), (0..3).map(on_axis).collect(), known, 6).unwrap();
    let (_, exact) = enrich(&problem, &options, Some(&start), None).unwrap();
    assert_eq!(
        (exact.stop, exact.history.len()),
        (StopReason::Tolerance, 0),
        "a start that is exact is kept: {exact:?}"
    );
}

/// −Δu = f on the unit square with f of known solution sin πx sin πy: hat functions on y, finite elements on
/// x.
fn poisson(points: usize) -> KroneckerProblem<DenseSpace> {
    let y = hat("y", 0.0, 1.0, points);
    let h = 1.0 / (points - 1) as f64;
    // ∫ N_i' N_j' of hat functions, the two ends held by a stiff spring, the way the engine's axes know
    // supports
    let spring = 1e8;
    let mut own = vec![2.0 / h; points];
    own[0] = 1.0 / h + spring;
    own[points - 1] = 1.0 / h + spring;
    let stiffness = AxisOperator::tridiagonal(vec![-1.0 / h; points - 1], own, vec![-1.0 / h; points - 1]);
    let mass = y.gram();
    // the same matrices over the inner points of x
    let inside = points - 2;
    let dense = |o: &AxisOperator| {
        let (l, d, u) = o.parts();
        Mat::from_fn(inside, inside, |i, j| match (i + 1, j + 1) {
            (i, j) if i == j => d[i],
            (i, j) if i == j + 1 => l[j],
            (i, j) if j == i + 1 => u[i],
            _ => 0.0,
        })
    };
    let shape: Vec<f64> = y.nodes().iter().map(|t| (std::f64::consts::PI * t).sin()).collect();
    let load = mass.apply(&shape);
    let block = Mat::from_fn(inside, 1, |j, _| 2.0 * std::f64::consts::PI.powi(2) * load[j + 1]);
    let space = DenseSpace::new(vec![dense(&stiffness), dense(&mass)]).unwrap();
    let source = Source { vectors: vec![load], block };
    KroneckerProblem::new(vec![y], vec![vec![mass], vec![stiffness]], space, vec![source]).unwrap()
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

/// `(1 + tκ) x = −tκ` at two positions of each axis: the oscillator of
/// docs/explanation/5a-separation-by-hand.md.
fn oscillator() -> KroneckerProblem<DenseSpace> {
    let position = |name| Axis::new(name, "1", 1.0, 2.0, AxisKind::Index, false).unwrap();
    let diagonal = |values: [f64; 2]| AxisOperator::diagonal(values.to_vec());
    let operators = vec![vec![diagonal([1.0, 1.0]); 2], vec![diagonal([1.0, 2.0]); 2]];
    let space = DenseSpace::new(vec![unit_block(), unit_block()]).unwrap();
    let source = Source { vectors: vec![vec![1.0, 2.0]; 2], block: unit_block() * faer::Scale(-1.0) };
    KroneckerProblem::new(vec![position("t"), position("kappa")], operators, space, vec![source]).unwrap()
}

#[test]
fn terms_of_one_round_from_the_load_are_those_worked_by_hand() {
    let problem = oscillator();
    let all = [[0, 0], [0, 1], [1, 0], [1, 1]].map(|point| point.to_vec());
    let mut found = Separated::zero(&problem.axes, 1, 1);
    let mut residuals = Vec::new();
    for _ in 0..6 {
        let load = vec![vec![1.0, 2.0]; 2];
        let term = enrich::next_term(&problem, &found, load, 1).unwrap().unwrap();
        found = found.concatenate(&term).unwrap();
        residuals.push(problem.residual(&found, &all));
    }
    let first = found.truncated(1);
    let ratio = |a: usize, term: usize| found.factors(a)[(1, term)] / found.factors(a)[(0, term)];
    // a dozen products and quotients of whole numbers below 100
    let near = |found: f64, by_hand: f64| assert!((found - by_hand).abs() < 1e-14, "{found} {by_hand}");
    near(ratio(0, 0), 28.0 / 23.0);
    near(ratio(1, 0), 6820.0 / 5507.0);
    near(first.evaluate(&[1.0, 1.0]).unwrap()[(0, 0)], -1817.0 / 3410.0);
    // the digits printed on the page
    for (found, by_hand) in residuals.iter().zip([1.780e-2, 7.640e-4, 2.901e-5, 1.302e-6, 4.950e-8, 2.221e-9])
    {
        assert!((found / by_hand - 1.0).abs() < 1e-3, "{found} {by_hand}");
    }
    // the odd terms share one function of t, the even ones another; each is found from a residual 30 times
    // smaller
    for (term, by_hand) in [28.0 / 23.0, -0.5, 28.0 / 23.0, -0.5].into_iter().enumerate() {
        assert!((ratio(0, term) - by_hand).abs() < 1e-9, "{term}: {}", ratio(0, term));
    }
}
