//! The block representation on the beam: the numbers of the issue, at fresh points.

use super::surrogate::Beam;
use super::*;
use faer::MatRef;
use std::time::Instant;

/// How region stiffness maps to axes.
enum Axes {
    /// Common `θ` and one stiffness scale per region: `θ_q = θ κ_q`.
    CommonAndScales,
    /// `θ` of the first region, and the ratio to it of every other region: `θ_q = θ c_q`.
    CommonAndRatios,
    /// Geometric mean and contrast of two regions: `θ_{1,2} = θ c^{±½}`.
    MeanAndContrast,
}

fn chebyshev(name: &str, lower: f64, upper: f64, points: usize) -> Axis {
    Axis::new(name, "1", lower, upper, AxisKind::Chebyshev { points }, true).unwrap()
}

/// Increment problem of a beam with region scales in [½, 2] and `θ` over a factor `span`, ending where θλ_1 of the
/// nominal beam is that of 12 steps per period (Bathe, stage 2).
fn increment(beam: &Beam, span: f64, points: (usize, usize), choice: Axes) -> BlockProblem<SparseSpace> {
    let regions = beam.stiffness.len();
    let top = (2.0 * std::f64::consts::PI / 12.0f64).powi(2) / 9.0 / beam.eigenvalues[0];
    let (low, high) = if regions > 1 { (0.5, 2.0) } else { (1.0, 1.0) };
    let (axes, powers) = match choice {
        Axes::CommonAndScales => {
            let mut axes = vec![chebyshev("theta", top / span, top, points.0)];
            axes.extend((0..regions).filter(|_| regions > 1).map(|_| chebyshev("kappa", low, high, points.1)));
            let powers = (0..regions).map(|q| (0..axes.len()).map(|a| f64::from(a == 0 || a == q + 1)).collect());
            let powers: Vec<Vec<f64>> = powers.collect();
            (axes, powers)
        }
        Axes::CommonAndRatios => {
            let mut axes = vec![chebyshev("theta", low * top / span, high * top, points.0)];
            axes.extend((1..regions).map(|_| chebyshev("ratio", low / high, high / low, points.1)));
            let powers = (0..regions).map(|q| (0..regions).map(|a| f64::from(a == 0 || a == q)).collect());
            let powers: Vec<Vec<f64>> = powers.collect();
            (axes, powers)
        }
        Axes::MeanAndContrast => {
            let axes = vec![
                chebyshev("theta", low * top / span, high * top, points.0),
                chebyshev("contrast", low / high, high / low, points.1),
            ];
            (axes, vec![vec![1.0, 0.5], vec![1.0, -0.5]])
        }
    };
    let mut matrices = vec![beam.mass.clone()];
    matrices.extend(beam.stiffness.iter().cloned());
    BlockProblem::increment(axes, &powers, SparseSpace::new(matrices).unwrap(), &beam.modes).unwrap()
}

fn reduced(beam: &Beam, problem: &BlockProblem<SparseSpace>, tolerance: f64) -> Reduction {
    let energy = |x: MatRef<'_, f64>| problem.space().apply(0, x);
    let weights: Vec<f64> = (0..beam.mass.nrows()).map(|i| 1.0 / beam.mass.as_ref().get(i, i).unwrap()).collect();
    let options = ReductionOptions { tolerance, ..Default::default() };
    reduce(problem, &energy, &weights, &options).unwrap()
}

fn sci(values: &[f64]) -> String {
    values.iter().map(|v| format!("{v:.1e} ")).collect()
}

#[test]
#[ignore = "measurement"]
fn measure_variants() {
    let beam = Beam::new(150, 2, 8);
    for (name, choice, points) in [
        ("scales", Axes::CommonAndScales, (15, 9)),
        ("ratio", Axes::CommonAndRatios, (17, 13)),
        ("contrast", Axes::MeanAndContrast, (17, 13)),
    ] {
        let clock = Instant::now();
        let problem = increment(&beam, 30.0, points, choice);
        let reduction = reduced(&beam, &problem, 1e-8);
        println!(
            "{name}: k = {}, {} samples, errors {}, {:.2} s",
            reduction.basis.ncols(), reduction.points.len(), sci(&reduction.history), clock.elapsed().as_secs_f64()
        );
        let fresh = FreshPoints::random(&reduction.problem, 200, 77).unwrap();
        for updates in [0, 2, 5, 10] {
            let clock = Instant::now();
            let measure = |u: &Separated| fresh.error(u).unwrap().0;
            let options = EnrichmentOptions { tolerance: 1e-7, max_terms: 60, update_sweeps: updates, ..Default::default() };
            let (u, report) = reduction.problem.separate(4000, &options, Some(&measure)).unwrap();
            let at = |n: usize| report.history.get(n - 1).copied().unwrap_or(f64::NAN);
            println!(
                "  updates {updates}: 10 {:.1e} 20 {:.1e} 30 {:.1e} 40 {:.1e} 60 {:.1e}; {} terms {:?} {}, {:.2} s",
                at(10), at(20), at(30), at(40), at(60), u.n_terms(), report.stop, sci(&<[f64; 2]>::from(fresh.error(&u).unwrap())),
                clock.elapsed().as_secs_f64()
            );
        }
    }
}
