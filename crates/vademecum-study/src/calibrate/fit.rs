//! Least squares in the box: Gauss and Newton's steps, damped as by Levenberg and Marquardt.

use faer::linalg::solvers::Solve as _;
use faer::{Mat, Side};
use vademecum_build::progress::Listener;
use vademecum_format::File;

use super::error::CalibrateError;
use super::experiment::{Experiment, Measurement, Noise, Reading};
use super::model::Model;
use super::problem::{Point, Problem};
use super::report::{Calibration, report, spread};
use crate::error::StudyError;
use crate::parameters::ParameterValue;

/// Settings of a calibration.
#[derive(Clone, Debug)]
pub struct CalibrateOptions {
    /// Names of the parameters that are fitted; all but the time step if empty.
    pub fit: Vec<String>,
    /// Values of the others, and of those that are fitted at the start.
    pub settings: Vec<ParameterValue>,
    /// Noise of the measured numbers.
    pub noise: Noise,
    /// Time step of histories \[s\]; that of the file if absent.
    pub time_step: Option<f64>,
}

/// Shares of histories that are fitted one after the other: early motion depends on the parameters in fewer
/// turns, and leads to the valley of the whole.
const SHARES: [f64; 3] = [0.25, 0.5, 1.0];
/// Most iterations of each share.
const ITERATIONS: usize = 40;
/// Smallest step, as a share of the range.
const SETTLED: f64 = 1e-6;
/// Largest step.
const LARGEST: f64 = 0.3;
/// Points over the box that are looked at where the first minimum is not explained, and those of them that
/// are started from.
const TRIED: usize = 64;
const STARTS: usize = 4;
/// Times that the error of the model is weighed anew.
const WEIGHED: usize = 3;

impl Problem<'_> {
    fn point(&self, u: Vec<f64>, share: f64) -> Result<Point, CalibrateError> {
        let differences = self.differences(&u, share)?;
        Ok(Point { u, differences })
    }

    /// The minimum of the whole from a start, by way of the first parts of histories.
    fn descend(&self, start: Vec<f64>) -> Result<(Point, usize, bool), CalibrateError> {
        let shares = if self.experiments.iter().any(Experiment::is_history) { &SHARES[..] } else { &[1.0] };
        let (mut u, mut iterations) = (start, 0);
        let mut last = None;
        for &share in shares {
            if share < 1.0 {
                self.listener.stage(&format!("fit the first {:.0} % of the histories", 100.0 * share));
            } else {
                self.listener.stage("fit");
            }
            let (point, own, settled) = self.minimise(u, share)?;
            u = point.u.clone();
            iterations += own;
            last = Some((point, settled));
        }
        let (point, settled) = last.ok_or_else(|| self.not_finite(&u))?;
        Ok((point, iterations, settled))
    }

    /// True of differences that noise and model do not explain: a minimum that may be local.
    fn is_unexplained(&self, point: &Point) -> bool {
        let free = (point.differences.len() - point.u.len()) as f64;
        point.chi() / free > 1.0 + spread(free)
    }

    /// The best of points spread over the box.
    fn other_starts(&self) -> Result<Vec<Vec<f64>>, CalibrateError> {
        let share = if self.experiments.iter().any(Experiment::is_history) { SHARES[0] } else { 1.0 };
        let points = spread_over_box(self.model.axes.len(), TRIED);
        let tried = points.into_iter().map(|u| self.point(u, share)).collect::<Result<Vec<_>, _>>();
        let mut tried = tried?;
        tried.sort_by(|a, b| a.chi().total_cmp(&b.chi()));
        Ok(tried.into_iter().take(STARTS).map(|point| point.u).collect())
    }

    /// The minimum from a start.
    fn minimise(&self, start: Vec<f64>, share: f64) -> Result<(Point, usize, bool), CalibrateError> {
        let mut point = self.point(start, share)?;
        let mut damping = 1e-3;
        for iteration in 0..ITERATIONS {
            let slopes = self.slopes(&point.u, share)?;
            let mut moved = None;
            while damping < 1e12 {
                let Some(next) = step(&slopes, &point, damping) else {
                    return Err(self.not_finite(&point.u));
                };
                let length = next.iter().zip(&point.u).fold(0.0, |m: f64, (a, b)| m.max((a - b).abs()));
                if length < SETTLED {
                    break;
                }
                let next = self.point(next, share)?;
                if next.chi() < point.chi() {
                    moved = Some((next, length));
                    break;
                }
                damping *= 8.0;
            }
            let Some((next, length)) = moved else { return Ok((point, iteration, true)) };
            let gained = 1.0 - next.chi() / point.chi();
            point = next;
            damping = (0.1 * damping).max(1e-9);
            if gained < 1e-9 && length < 100.0 * SETTLED {
                return Ok((point, iteration + 1, true));
            }
        }
        Ok((point, ITERATIONS, false))
    }
}

impl Problem<'_> {
    /// Error of the model that explains what noise leaves of the differences, at most `most`.
    fn needed_error(&self, point: &Point, most: f64) -> f64 {
        let free = (point.differences.len() - point.u.len()) as f64;
        let chi = |error: f64| {
            let mut rest = &point.differences[..];
            let own = self.experiments.iter().map(|experiment| {
                let (own, others) = rest.split_at(experiment.len());
                rest = others;
                experiment.chi_with(own, error)
            });
            own.sum::<f64>() / free
        };
        if chi(most) >= 1.0 {
            return most;
        }
        if chi(0.0) <= 1.0 {
            return 0.0;
        }
        let (mut below, mut above) = (0.0, most);
        for _ in 0..40 {
            let middle = 0.5 * (below + above);
            if chi(middle) > 1.0 { below = middle } else { above = middle }
        }
        above
    }
}

/// Points of a sequence of low discrepancy (Roberts 2018): multiples of the powers of `1/φ`, where
/// `φ^(p+1) = φ + 1`.
fn spread_over_box(p: usize, count: usize) -> Vec<Vec<f64>> {
    let phi = (0..64).fold(2.0_f64, |phi, _| (1.0 + phi).powf(1.0 / (p as f64 + 1.0)));
    let coordinate = |n: usize, k: usize| (0.5 + n as f64 * phi.powi(-(k as i32 + 1))).fract();
    (1..=count).map(|n| (0..p).map(|k| coordinate(n, k)).collect()).collect()
}

/// The next coordinates: a damped step of those that are not held at a bound, into the box.
fn step(slopes: &Mat<f64>, point: &Point, damping: f64) -> Option<Vec<f64>> {
    let p = point.u.len();
    let r = Mat::from_fn(point.differences.len(), 1, |i, _| point.differences[i]);
    let gradient = slopes.transpose() * &r;
    let held = |k: usize| {
        (point.u[k] <= 0.0 && gradient[(k, 0)] > 0.0) || (point.u[k] >= 1.0 && gradient[(k, 0)] < 0.0)
    };
    let free: Vec<usize> = (0..p).filter(|&k| !held(k)).collect();
    let square = slopes.transpose() * slopes;
    let largest = (0..p).fold(0.0, |m: f64, k| m.max(square[(k, k)]));
    if !largest.is_finite() || !gradient.is_all_finite() {
        return None;
    }
    let mut next = point.u.clone();
    if free.is_empty() || largest == 0.0 {
        return Some(next);
    }
    let matrix = Mat::from_fn(free.len(), free.len(), |i, j| {
        let own = square[(free[i], free[j])];
        if i == j { own * (1.0 + damping) + 1e-9 * damping.max(1e-6) * largest } else { own }
    });
    let right = Mat::from_fn(free.len(), 1, |i, _| -gradient[(free[i], 0)]);
    let change = matrix.llt(Side::Lower).ok()?.solve(&right);
    for (place, &k) in free.iter().enumerate() {
        next[k] = (next[k] + change[(place, 0)].clamp(-LARGEST, LARGEST)).clamp(0.0, 1.0);
    }
    Some(next)
}

/// Fits live parameters of a parametric model to measured numbers.
///
/// # Errors
/// [`CalibrateError`]: a table, a parameter or a file that cannot be used.
pub fn calibrate(
    file: &File<'_>,
    measurements: &[Measurement],
    options: &CalibrateOptions,
    listener: &dyn Listener,
) -> Result<Calibration, CalibrateError> {
    let model = Model::new(file, &options.fit, &options.settings)?;
    let start: Vec<f64> = model.axes.iter().map(|axis| axis.coordinate(axis.start)).collect();
    let bytes = model.bytes(&start)?;
    let at_start = File::parse(&bytes).map_err(StudyError::from)?;
    let model_error = options.noise.model.map_or_else(|| model.error(), Ok)?;
    let (noise, time_step) = (options.noise, options.time_step);
    let reading = Reading { file: &at_start, noise, model_error, time_step, listener };
    let experiments = measurements.iter().map(|own| reading.read(own)).collect::<Result<Vec<_>, _>>()?;
    let numbers: usize = experiments.iter().map(Experiment::len).sum();
    if numbers <= start.len() {
        return Err(CalibrateError::TooFew { numbers, parameters: start.len() });
    }
    let mut problem = Problem { model, experiments, listener };
    let (mut point, mut iterations, mut settled) = problem.descend(start)?;
    if problem.is_unexplained(&point) {
        listener.stage("fit from other starts");
        for start in problem.other_starts()? {
            let found = problem.descend(start)?;
            iterations += found.1;
            if found.0.chi() < point.chi() {
                (point, settled) = (found.0, found.2);
            }
        }
    }
    // The certificate has the worst load of each of its points: as much of it is weighed as is needed.
    let mut weighed = model_error;
    for _ in 0..if options.noise.model.is_none() { WEIGHED } else { 0 } {
        let needed = problem.needed_error(&point, model_error);
        if (needed - weighed).abs() <= SETTLED * model_error {
            break;
        }
        weighed = needed;
        problem.experiments.iter_mut().for_each(|experiment| experiment.model_error = needed);
        let found = problem.minimise(point.u, 1.0)?;
        iterations += found.1;
        (point, settled) = (found.0, found.2);
    }
    report(&problem, &point, weighed, iterations, settled)
}
