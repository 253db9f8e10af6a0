//! The block representation on the beam: the numbers of the issue, at fresh points.

use super::surrogate::Pencil;
use super::*;
use faer::MatRef;
use std::time::Instant;

/// Increment problem of a beam with region scales in [½, 2] and `θ` over a factor `span`, ending where θλ_1 of the
/// nominal beam is that of 12 steps per period (Bathe, stage 2).
fn increment(beam: &Pencil, span: f64, points: (usize, usize)) -> (RegionAxes, BlockProblem<SparseSpace>) {
    let regions = beam.stiffness.len();
    let top = theta_top(beam);
    let scale = (regions > 1).then_some((0.5, 2.0));
    let map = RegionAxes::new((top / span, top), &vec![scale; regions], points.0, points.1).unwrap();
    let mut matrices = vec![beam.mass.clone()];
    matrices.extend(beam.stiffness.iter().cloned());
    let space = SparseSpace::new(matrices).unwrap();
    let problem = BlockProblem::increment(map.axes().to_vec(), map.powers(), space, &beam.modes).unwrap();
    (map, problem)
}

fn theta_top(beam: &Pencil) -> f64 {
    (2.0 * std::f64::consts::PI / 12.0f64).powi(2) / 9.0 / beam.eigenvalues[0]
}

/// 200 points of the box the user asked for: θ times region scales, not the box of the axes, which is wider.
fn fresh_points(beam: &Pencil, span: f64, map: &RegionAxes, problem: &BlockProblem<DenseSpace>) -> FreshPoints {
    let mut random = Random::new(77);
    let regions = beam.stiffness.len();
    let mut point = || {
        let common = theta_top(beam) * span.powf(-random.uniform());
        let scale = |t: f64| if regions > 1 { 4f64.powf(t - 0.5) } else { 1.0 };
        let scales: Vec<f64> = (0..regions).map(|_| scale(random.uniform())).collect();
        map.point(common, &scales).unwrap()
    };
    FreshPoints::at(problem, (0..200).map(|_| point()).collect()).unwrap()
}

fn reduced(beam: &Pencil, problem: &BlockProblem<SparseSpace>, tolerance: f64) -> Reduction {
    let energy = |x: MatRef<'_, f64>| problem.space().apply(0, x);
    let weights: Vec<f64> = (0..beam.mass.nrows()).map(|i| 1.0 / beam.mass.as_ref().get(i, i).unwrap()).collect();
    let options = ReductionOptions { tolerance, ..Default::default() };
    reduce(problem, &energy, &weights, &options).unwrap()
}

fn sci(values: &[f64]) -> String {
    values.iter().map(|v| format!("{v:.1e} ")).collect()
}

fn report(name: &str, reduction: &Reduction, fresh: &FreshPoints, most: usize, options: &EnrichmentOptions) {
    let clock = Instant::now();
    let problem = &reduction.problem;
    let measure = |u: &Separated| fresh.error(u).unwrap().0;
    let (u, report) = if most > 0 {
        problem.separate(most, options, Some(&measure)).unwrap()
    } else {
        enrich(&problem.galerkin().unwrap(), options, None, Some(&measure)).unwrap()
    };
    println!(
        "{name}, updates {}: {} terms {:?} {}, {:.2} s; {}",
        options.update_sweeps, u.n_terms(), report.stop,
        sci(&<[f64; 2]>::from(fresh.error(&u).unwrap())), clock.elapsed().as_secs_f64(),
        sci(&report.history.iter().copied().enumerate().filter(|(i, _)| i % 10 == 9).map(|x| x.1).collect::<Vec<_>>())
    );
}

#[test]
#[ignore = "measurement"]
fn measure_block() {
    for (regions, points, tolerance, max_terms) in
        [(1, (29, 2), 1e-8, 20), (2, (17, 11), 1e-7, 60), (4, (13, 7), 1e-5, 260)]
    {
        let beam = Pencil::beam(160, regions, 8);
        let span = if regions == 1 { 100.0 } else { 30.0 };
        let clock = Instant::now();
        let (map, problem) = increment(&beam, span, points);
        let reduction = reduced(&beam, &problem, 0.1 * tolerance);
        println!(
            "{regions} regions: k = {}, {} samples, errors {}, {:.2} s",
            reduction.basis.ncols(), reduction.points.len(), sci(&reduction.history), clock.elapsed().as_secs_f64()
        );
        let fresh = fresh_points(&beam, span, &map, &reduction.problem);
        let options = EnrichmentOptions { tolerance, max_terms, ..Default::default() };
        for updates in [0, 1, 2, 5] {
            if regions == 4 && updates != 1 { continue; }
            let options = EnrichmentOptions { update_sweeps: updates, ..options.clone() };
            report("  samples", &reduction, &fresh, 5000, &options);
            if regions < 4 { report("  galerkin", &reduction, &fresh, 0, &options); }
        }
    }
}
#[test]
#[ignore = "measurement"]
fn measure_lattice() {
    for (regions, points, tolerance, max_terms) in
        [(1, (29, 2), 1e-8, 20), (2, (17, 11), 1e-7, 60), (4, (13, 7), 1e-5, 240)]
    {
        let beam = Pencil::lattice(6, 6, 40, regions, 8);
        let span = if regions == 1 { 100.0 } else { 30.0 };
        let clock = Instant::now();
        let (map, problem) = increment(&beam, span, points);
        let reduction = reduced(&beam, &problem, 0.1 * tolerance);
        println!(
            "{regions} regions: k = {}, {} samples, errors {}, {:.2} s",
            reduction.basis.ncols(), reduction.points.len(), sci(&reduction.history), clock.elapsed().as_secs_f64()
        );
        let fresh = fresh_points(&beam, span, &map, &reduction.problem);
        let options = EnrichmentOptions { tolerance, max_terms, ..Default::default() };
        for updates in [0, 1, 3] {
            if regions == 4 && updates != 1 { continue; }
            let options = EnrichmentOptions { update_sweeps: updates, ..options.clone() };
            report("  samples", &reduction, &fresh, 5000, &options);
            if regions < 4 { report("  galerkin", &reduction, &fresh, 0, &options); }
        }
    }
}
