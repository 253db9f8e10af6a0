//! Report of a fit: estimates with intervals, their correlation, and what the data do not determine.

use serde::Serialize;

use super::error::CalibrateError;
use super::experiment::ColumnFit;
use super::problem::{Point, Problem};
use crate::parameters::ParameterValue;

/// A fitted parameter.
#[derive(Clone, Debug, Serialize)]
pub struct Estimate {
    /// Its name.
    pub name: String,
    /// Its unit; empty of a factor.
    pub unit: &'static str,
    /// The estimate.
    pub value: f64,
    /// 95 % confidence interval, within the range; none of a value at its bound.
    pub interval: Option<[f64; 2]>,
    /// Standard deviation over the value.
    pub relative_deviation: Option<f64>,
    /// Range of the file.
    pub range: [f64; 2],
    /// True if the estimate is at a bound of its range.
    pub at_bound: bool,
}

/// A table and its fit.
#[derive(Clone, Debug, Serialize)]
pub struct Fit {
    /// The table.
    pub table: String,
    /// Measured numbers.
    pub numbers: usize,
    /// Mean square of the differences over their deviations.
    pub chi_squared: f64,
    /// The same of each column.
    pub columns: Vec<ColumnFit>,
}

/// A direction in the space of the parameters, in coordinates in which each range has length 1.
#[derive(Clone, Debug, Serialize)]
pub struct Direction {
    /// Singular value of the derivatives: the larger, the better it is determined.
    pub singular_value: f64,
    /// Standard deviation along it, as a share of the range.
    pub deviation: f64,
    /// Parameters and their shares, those of little left out.
    pub parameters: Vec<Share>,
}

/// Share of a parameter in a direction.
#[derive(Clone, Debug, Serialize)]
pub struct Share {
    /// The parameter.
    pub name: String,
    /// From −1 to 1.
    pub share: f64,
}

/// Result of a calibration.
#[derive(Clone, Debug, Serialize)]
pub struct Calibration {
    /// The fitted parameters.
    pub estimates: Vec<Estimate>,
    /// Correlation of the estimates, row by row.
    pub correlation: Vec<Vec<f64>>,
    /// `χ²/N`, N the measured numbers less the parameters.
    pub chi_squared: f64,
    /// Meaning of it, in a sentence.
    pub meaning: String,
    /// Factor by which the intervals were widened, for a `χ²/N` above what noise explains.
    pub widened: f64,
    /// Relative error of the model that was added to the noise: that of the certificate, or as much of it as
    /// the differences need.
    pub model_error: f64,
    /// The tables.
    pub fits: Vec<Fit>,
    /// Singular values of the derivatives, descending.
    pub singular_values: Vec<f64>,
    /// Directions that the data do not determine.
    pub undetermined: Vec<Direction>,
    /// Iterations.
    pub iterations: usize,
    /// True if the iterations ended at a minimum.
    pub converged: bool,
    /// Values of all parameters, the fixed ones too.
    #[serde(skip)]
    pub values: Vec<ParameterValue>,
}

/// 95 % of a normal distribution lie within so many deviations.
const NORMAL_95: f64 = 1.959_963_984_540_054;
/// Deviation of a direction, as a share of the range, beyond which the data do not determine it: at random
/// over the range it would be 1/√12 = 0.29.
const UNDETERMINED: f64 = 0.25;
/// Largest deviation, as a share of the range.
const FAR: f64 = 1e6;
/// Shares in a direction below this are left out.
const LITTLE: f64 = 0.1;

/// Distance of `χ²/N` from 1 that chance explains: of N squares of normal numbers the mean has the deviation
/// `√(2/N)`.
pub(super) fn spread(free: f64) -> f64 {
    3.0 * (2.0 / free).sqrt()
}

pub(super) fn report(
    problem: &Problem<'_>,
    point: &Point,
    model_error: f64,
    iterations: usize,
    converged: bool,
) -> Result<Calibration, CalibrateError> {
    let axes = &problem.model.axes;
    let p = axes.len();
    let slopes = problem.slopes(&point.u, 1.0)?;
    let svd = slopes.thin_svd().map_err(|_| problem.not_finite(&point.u))?;
    let singular: Vec<f64> = svd.S().column_vector().iter().copied().collect();
    let free = point.differences.len() - p;
    let chi = point.differences.iter().map(|x| x * x).sum::<f64>() / free as f64;
    let spread = spread(free as f64);
    let widened = if chi > 1.0 + spread { chi.sqrt() } else { 1.0 };
    let turned = |k: usize, i: usize| svd.V()[(i, k)];
    // Directions without any slope have no deviation; this is far beyond any range.
    let deviation = |k: usize| (widened / singular[k]).min(FAR);
    let covariance = |i: usize, j: usize| -> f64 {
        (0..p).map(|k| turned(k, i) * turned(k, j) * deviation(k) * deviation(k)).sum()
    };
    let deviations: Vec<f64> = (0..p).map(|i| covariance(i, i).sqrt()).collect();
    let correlation = (0..p)
        .map(|i| (0..p).map(|j| covariance(i, j) / (deviations[i] * deviations[j])).collect())
        .collect();
    let estimates = axes.iter().enumerate().map(|(i, axis)| {
        let (u, sigma) = (point.u[i], deviations[i]);
        let at_bound = u <= 0.0 || u >= 1.0;
        let value = axis.value(u);
        let ends = [u - NORMAL_95 * sigma, u + NORMAL_95 * sigma].map(|u| axis.value(u.clamp(0.0, 1.0)));
        let relative = if axis.log {
            sigma * (axis.upper / axis.lower).ln()
        } else {
            sigma * (axis.upper - axis.lower) / value.abs().max(f64::MIN_POSITIVE)
        };
        Estimate {
            name: axis.name.clone(),
            unit: axis.unit,
            value,
            interval: (!at_bound).then_some(ends),
            relative_deviation: (!at_bound).then_some(relative),
            range: [axis.lower, axis.upper],
            at_bound,
        }
    });
    let direction = |k: usize| Direction {
        singular_value: singular[k],
        deviation: deviation(k),
        parameters: (0..p)
            .filter(|&i| turned(k, i).abs() >= LITTLE)
            .map(|i| Share { name: axes[i].name.clone(), share: turned(k, i) })
            .collect(),
    };
    let undetermined = (0..p).filter(|&k| deviation(k) > UNDETERMINED).map(direction).collect();
    let mut rest = &point.differences[..];
    let fits = problem.experiments.iter().map(|experiment| {
        let (own, others) = rest.split_at(experiment.len());
        rest = others;
        let chi_squared = own.iter().map(|x| x * x).sum::<f64>() / own.len() as f64;
        let columns = experiment.by_column(own);
        Fit { table: experiment.name.clone(), numbers: own.len(), chi_squared, columns }
    });
    Ok(Calibration {
        estimates: estimates.collect(),
        correlation,
        chi_squared: chi,
        meaning: meaning(chi, spread),
        widened,
        model_error,
        fits: fits.collect(),
        undetermined,
        singular_values: singular,
        iterations,
        converged,
        values: problem.model.values(&point.u),
    })
}

/// Meaning of `χ²/N` in words.
fn meaning(chi: f64, spread: f64) -> String {
    if chi > 1.0 + spread {
        "more than noise and certificate explain: the model (its basis, mesh, supports or loads) or too small a \
         `--noise` limits; the intervals are widened by its root, and do not cover an error of the model"
            .into()
    } else if chi < 1.0 - spread {
        "less than 1: noise or model error is smaller than stated, and the intervals are wider than they need be; \
         `--noise` and `--model-error` state others"
            .into()
    } else {
        "near 1: noise and certificate explain the differences, and the intervals hold".into()
    }
}
