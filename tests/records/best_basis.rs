//! The record of `docs/measurements/total-error.md` about other bases: what no basis of so many vectors is
//! below.
//!
//! ```text
//! cargo run --release -p vademecum-tests --example best_basis [-- --body NAME --modes N --pushes N]
//! ```
//!
//! The pushes are those of `total_error`, with ramps and 2 % damping. A body has many natural modes here,
//! each moved exactly. The static answer of every load is taken to be exact, whatever the basis. So a basis
//! has to hold the rest, each mode's swing around its static answer; what is not in its span is missing. The
//! best basis is that of the proper orthogonal decomposition of all these swings, each divided by the size of
//! its push: in the root of the mean square over pushes no basis is below it.

use faer::{Mat, MatRef, Side};
use vademecum_build::dynamics::lowest_modes;
use vademecum_build::linalg::project;
use vademecum_build::prepared::prepare;
use vademecum_build::progress::{Silent, Stopwatch};
use vademecum_format::exact::Propagator;
use vademecum_tests::total_error::{HISTORIES, Loading, Push, RealBody, STEPS, quantiles, real_bodies};

/// Natural modes that stand for all of a body: beyond them a swing is far below any row of the table.
const ALL: usize = 400;
/// Damping ratio of every mode.
const RATIO: f64 = 0.02;
/// Vectors that each push may bring along in the last rows.
const BROUGHT: [usize; 3] = [1, 2, 3];

fn main() {
    let (mut names, mut modes, mut pushes) = (vec![], 32, 200);
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        let mut value = || arguments.next().unwrap_or_else(|| panic!("{argument} wants a value"));
        match argument.as_str() {
            "--body" => names.push(value()),
            "--modes" => modes = value().parse().expect("a number of modes"),
            "--pushes" => pushes = value().parse().expect("a number of pushes"),
            _ => panic!(
                "`{argument}` is not known: usage: best_basis [--body NAME ...] [--modes N] [--pushes N]"
            ),
        }
    }
    assert!(modes < ALL, "`--modes` is at most {}", ALL - 1);
    println!("A cell has the root of the mean square of all pushes, then median / 95 % / largest.\n");
    let bodies = real_bodies();
    for name in &names {
        assert!(bodies.iter().any(|body| body.name == name), "no body `{name}`, or its mesh is absent");
    }
    for body in bodies.iter().filter(|body| names.is_empty() || names.iter().any(|name| name == body.name)) {
        record(body, modes, pushes);
    }
}

fn record(body: &RealBody, modes: usize, pushes: usize) {
    let problem = body.problem(1.0, modes, RATIO);
    let prepared = prepare(&problem, &mut Stopwatch::new(&Silent), &Silent);
    let prepared = prepared.unwrap_or_else(|error| panic!("{error}"));
    let all = lowest_modes(prepared.body.model.pencil(), &prepared.symbolic, ALL).expect("modes");
    let frequency = |mode: usize| all.eigenvalues[mode].sqrt();
    let step = std::f64::consts::TAU / frequency(0) / 40.0;
    println!(
        "## {}\n\nMode {modes} has {:.1} times the first frequency, mode {ALL} {:.1} times.\n",
        body.name,
        frequency(modes - 1) / frequency(0),
        frequency(ALL - 1) / frequency(0)
    );
    println!("| load | basis | error |\n|---|---|---|");
    let drawn = Push::draw(&prepared.body, pushes);
    let shares: Vec<Vec<f64>> =
        drawn.iter().map(|push| project(all.vectors.as_ref(), &push.over_dofs(&prepared.body))).collect();
    for loading in HISTORIES.iter().filter(|loading| loading.name.starts_with("ramp")) {
        let swings = swings(&shares, &all.eigenvalues, loading, step);
        let row = |basis: &str, errors: Vec<f64>| {
            let square = errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64;
            let [median, most, largest] = quantiles(errors);
            println!(
                "| {} | {basis} | {:.2e}, {median:.2e} / {most:.2e} / {largest:.2e} |",
                loading.name,
                square.sqrt()
            );
        };
        let beyond = |from: usize| {
            let size = |swing: &Mat<f64>| swing.as_ref().subrows(from, ALL - from).norm_l2();
            swings.iter().map(size).collect::<Vec<f64>>()
        };
        row(&format!("{modes} natural modes"), beyond(modes));
        let chosen = swinging_most(&swings, modes);
        let others = |swing: &Mat<f64>| {
            let other = |mode: &usize| !chosen.contains(mode);
            (0..ALL).filter(other).map(|mode| swing.row(mode).squared_norm_l2()).sum::<f64>().sqrt()
        };
        let last = chosen.iter().max().map_or(0, |last| last + 1);
        let name = format!("the {modes} natural modes that swing most, the last of them mode {last}");
        row(&name, swings.iter().map(others).collect());
        let best = best(&swings, modes);
        let outside = |swing: &Mat<f64>| (swing - &best * (best.transpose() * swing)).norm_l2();
        row(&format!("the best {modes} vectors of all"), swings.iter().map(outside).collect());
        for more in BROUGHT {
            let rest = |swing: &Mat<f64>| without_best(swing.as_ref().subrows(modes, ALL - modes), more);
            let name = format!("{modes} natural modes, and the best {more} for this push alone");
            row(&name, swings.iter().map(rest).collect());
        }
    }
    println!();
}

/// Each push's swing of every mode around its static answer after each step, shape (modes, steps), divided by
/// the root of the sum of squares of its whole motion: what is missing counts as a relative error.
fn swings(shares: &[Vec<f64>], eigenvalues: &[f64], loading: &Loading, step: f64) -> Vec<Mat<f64>> {
    let history = loading.history(step);
    let (mut whole, mut swing) = (Mat::zeros(ALL, STEPS), Mat::zeros(ALL, STEPS));
    for (mode, &lambda) in eigenvalues.iter().enumerate() {
        let p = Propagator::new(lambda, RATIO * lambda.sqrt(), step);
        let (mut q, mut v) = (0.0, 0.0);
        for n in 0..STEPS {
            let [before, after] = [n, n + 1].map(|n| history.factor(n as f64 * step));
            let rise = after - before;
            (q, v) = (
                q + (p.d[0] * q + p.d[1] * v + p.held[0] * before + p.rising[0] * rise),
                v + (p.d[2] * q + p.d[3] * v + p.held[1] * before + p.rising[1] * rise),
            );
            whole[(mode, n)] = q;
            swing[(mode, n)] = q - after / lambda;
        }
    }
    let of = |shares: &Vec<f64>| {
        let size = Mat::from_fn(ALL, STEPS, |mode, n| shares[mode] * whole[(mode, n)]).norm_l2();
        Mat::from_fn(ALL, STEPS, |mode, n| shares[mode] * swing[(mode, n)] / size)
    };
    shares.iter().map(of).collect()
}

/// The modes that hold most of all swings.
fn swinging_most(swings: &[Mat<f64>], count: usize) -> Vec<usize> {
    let size = |mode: usize| swings.iter().map(|swing| swing.row(mode).squared_norm_l2()).sum::<f64>();
    let mut modes: Vec<(f64, usize)> = (0..ALL).map(|mode| (size(mode), mode)).collect();
    modes.sort_by(|a, b| b.0.total_cmp(&a.0));
    modes[..count].iter().map(|&(_, mode)| mode).collect()
}

/// The orthonormal vectors that hold most of all swings.
fn best(swings: &[Mat<f64>], count: usize) -> Mat<f64> {
    let mut sum = Mat::zeros(ALL, ALL);
    for swing in swings {
        sum += swing * swing.transpose();
    }
    let eigen = sum.self_adjoint_eigen(Side::Lower).expect("finite swings");
    eigen.U().subcols(ALL - count, count).to_owned()
}

/// What is left of a swing without the few vectors that hold most of it.
fn without_best(swing: MatRef<'_, f64>, few: usize) -> f64 {
    let values = (swing.transpose() * swing).self_adjoint_eigenvalues(Side::Lower).expect("a finite swing");
    values[..values.len() - few].iter().map(|value| value.max(0.0)).sum::<f64>().sqrt()
}
