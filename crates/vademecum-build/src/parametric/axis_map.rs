//! From the user's values to a point on the axes of the solution, and from there to the weights of the
//! operators.

use vademecum_format::{AxisRole, MAX_REGIONS};

use crate::prepared::{ParameterSpace, Setting};
use crate::separated::{Axis, AxisKind, RegionAxes, SeparatedError, chebyshev_points};

/// From θ and region factors to a point on the axes.
#[derive(Clone, serde::Serialize, serde::Deserialize)]
pub(super) struct AxisMap {
    regions: RegionAxes,
    /// Axes of the solution.
    pub(super) axes: Vec<Axis>,
    /// Region of each density axis.
    density_axes: Vec<usize>,
    /// Regions with live stiffness: the others stand at 1.
    pub(super) n_regions: usize,
}

/// Chebyshev points on a density axis: the singularities of the response lie as for a stiffness factor, π
/// away in the complex logarithm.
fn density_points((lower, upper): (f64, f64), tolerance: f64) -> usize {
    chebyshev_points(upper / lower, std::f64::consts::PI, tolerance)
}

impl AxisMap {
    /// Axes with as many points as keep a tenth of `tolerance`.
    pub(super) fn new(
        space: &ParameterSpace,
        theta: (f64, f64),
        tolerance: f64,
    ) -> Result<Self, SeparatedError> {
        // A scheme whose stages share θ, and no parameter that moves it, still need an axis of some width.
        let theta = if theta.1 > 1.001 * theta.0 { theta } else { (theta.0 / 1.01, theta.1 * 1.01) };
        let scales: Vec<_> = (0..space.n_regions).map(|q| space.region_range(q, false)).collect();
        let regions = RegionAxes::new(theta, &scales, 0.1 * tolerance)?;
        let mut axes = regions.axes().to_vec();
        let mut density_axes = vec![];
        for q in 0..space.n_regions {
            if let Some((lower, upper)) = space.region_range(q, true) {
                let points = density_points((lower, upper), 0.1 * tolerance);
                let name = format!("rho{}", q + 1);
                axes.push(Axis::new(&name, "1", lower, upper, AxisKind::Chebyshev { points }, true)?);
                density_axes.push(q);
            }
        }
        Ok(Self { regions, axes, density_axes, n_regions: space.n_regions })
    }

    /// The point of a setting whose stage has this θ.
    pub(super) fn point(&self, theta: f64, setting: &Setting) -> Result<Vec<f64>, SeparatedError> {
        let mut point = self.regions.point(theta, &setting.stiffness)?;
        point.extend(self.density_axes.iter().map(|&q| setting.density[q]));
        Ok(point)
    }

    /// Exponents of θ, the stiffness and the density factors in each axis: logarithms of the point of one
    /// variable at e.
    pub(super) fn roles(&self) -> Result<Vec<AxisRole>, SeparatedError> {
        let point = |theta: f64, scaled: Option<usize>| {
            let mut scales = vec![1.0; self.n_regions];
            if let Some(q) = scaled {
                scales[q] = std::f64::consts::E;
            }
            self.regions.point(theta, &scales)
        };
        // Exponents are halves; rounding to quarters makes them exact.
        let exponent = |value: f64| (4.0 * value.ln()).round() / 4.0;
        let by_theta = point(std::f64::consts::E, None)?;
        let by_region = (0..self.n_regions).map(|q| point(1.0, Some(q))).collect::<Result<Vec<_>, _>>()?;
        let regional = self.regions.axes().len();
        let role = |a: usize| {
            let (mut stiffness, mut density) = ([0.0; MAX_REGIONS], [0.0; MAX_REGIONS]);
            if a < regional {
                (0..self.n_regions).for_each(|q| stiffness[q] = exponent(by_region[q][a]));
                return AxisRole::Monomial { theta: exponent(by_theta[a]), stiffness, density };
            }
            density[self.density_axes[a - regional]] = 1.0;
            AxisRole::Monomial { theta: 0.0, stiffness, density }
        };
        Ok((0..self.axes.len()).map(role).collect())
    }

    /// Exponents of the axes in θ_q, density axes included.
    fn stiffness_powers(&self) -> Vec<Vec<f64>> {
        let pad = |p: &Vec<f64>| p.iter().copied().chain(self.density_axes.iter().map(|_| 0.0)).collect();
        self.regions.powers().iter().map(pad).collect()
    }

    /// Exponents of the axes in ρ_q.
    fn density_powers(&self, region: usize) -> Vec<f64> {
        let first = self.regions.axes().len();
        let own = |a: usize| a >= first && self.density_axes[a - first] == region;
        (0..self.axes.len()).map(|a| if own(a) { 1.0 } else { 0.0 }).collect()
    }
}

/// Weights of the operators `[M_0, …, K_0, …]` at a point on the axes.
pub(super) fn weights(map: &AxisMap, point: &[f64]) -> Vec<f64> {
    let monomial = |powers: Vec<f64>| powers.iter().zip(point).map(|(p, x)| x.powf(*p)).product::<f64>();
    let masses = (0..map.n_regions).map(|q| monomial(map.density_powers(q)));
    masses.chain(map.stiffness_powers().into_iter().map(monomial)).collect()
}
