//! Axes for regions with live stiffness, chosen by what they do and not by name.
//!
//! Regions share the time step, damping and scheme, so their `θ_q = θ κ_q` move together, and one axis is the
//! common `θ`. One region folds its scale into `θ`. Two regions take the geometric mean of both `θ_q` and
//! their contrast, `θ_{1,2} = m c^{±1}`: two axes, none redundant. Any other case takes `θ` and one `κ_q` per
//! live region: one axis more than there are freedoms when all are live, and still fewer terms than contrasts
//! of contrasts or ratios to one region, because each `κ_q` acts on one matrix only (four regions of a beam,
//! error at 100 terms: 1e-4, against 3e-4 and 2.5e-4).

use super::axis::{Axis, AxisKind, chebyshev_points};
use super::error::{SeparatedError, check_len};
use std::f64::consts::{FRAC_PI_2, PI};

/// The map between the common `θ` and region scales, and a point on the axes.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub(crate) struct RegionAxes {
    axes: Vec<Axis>,
    /// `[q][a]`: exponent of axis `a` in `θ_q`.
    powers: Vec<Vec<f64>>,
    /// Whether the scale of a region is live.
    live: Vec<bool>,
}

impl RegionAxes {
    /// Axes for a common `theta` range and the range of each region's stiffness scale (`None`: fixed at 1),
    /// with as many Chebyshev points in `ln μ` as interpolate solutions to a relative `tolerance`.
    ///
    /// # Errors
    /// As [`Axis::new`]; [`SeparatedError::Shape`] without regions.
    pub(crate) fn new(
        theta: (f64, f64),
        scales: &[Option<(f64, f64)>],
        tolerance: f64,
    ) -> Result<RegionAxes, SeparatedError> {
        let with_strip = |name: &str, (lower, upper): (f64, f64), strip: f64| {
            // a range that Axis::new will refuse still needs some number of points to be refused with
            let valid = lower > 0.0 && lower < upper && upper.is_finite();
            let points = if valid { chebyshev_points(upper / lower, strip, tolerance) } else { 2 };
            let unit = if name == "theta" { "s²" } else { "1" };
            Axis::new(name, unit, lower, upper, AxisKind::Chebyshev { points }, true)
        };
        let axis = |name: &str, range: (f64, f64)| with_strip(name, range, PI);
        let live: Vec<bool> = scales.iter().map(Option::is_some).collect();
        let (axes, powers) = match scales {
            [] => {
                return Err(SeparatedError::Shape { what: "regions", expected: 1, found: 0 });
            }
            [only] => {
                let (low, high) = only.unwrap_or((1.0, 1.0));
                (vec![axis("theta", (theta.0 * low, theta.1 * high))?], vec![vec![1.0]])
            }
            [Some(p), Some(q)] => {
                let mean = (theta.0 * (p.0 * q.0).sqrt(), theta.1 * (p.1 * q.1).sqrt());
                let contrast = ((p.0 / q.1).sqrt(), (p.1 / q.0).sqrt());
                let axes = vec![axis("theta", mean)?, with_strip("contrast", contrast, FRAC_PI_2)?];
                (axes, vec![vec![1.0, 1.0], vec![1.0, -1.0]])
            }
            _ => {
                let mut axes = vec![axis("theta", theta)?];
                let mut own = vec![0; scales.len()];
                for (q, range) in scales.iter().enumerate().filter_map(|(q, s)| s.map(|range| (q, range))) {
                    own[q] = axes.len();
                    axes.push(axis(&format!("kappa{}", q + 1), range)?);
                }
                let power = |own: usize| (0..axes.len()).map(|a| f64::from(a == 0 || a == own)).collect();
                let powers = own.into_iter().map(power).collect();
                (axes, powers)
            }
        };
        Ok(RegionAxes { axes, powers, live })
    }

    /// The axes, the common one first.
    pub(crate) fn axes(&self) -> &[Axis] {
        &self.axes
    }

    /// Exponents of the axes in `θ_q`, one list per region: `θ_q = Π_a μ_a^{powers[q][a]}`.
    pub(crate) fn powers(&self) -> &[Vec<f64>] {
        &self.powers
    }

    /// The point on the axes for this common `theta` and these scales, one per region (1 where not live).
    ///
    /// # Errors
    /// [`SeparatedError::Shape`]. Whether the point is on the axes is for the axes to say.
    pub(crate) fn point(&self, theta: f64, scales: &[f64]) -> Result<Vec<f64>, SeparatedError> {
        check_len("stiffness scales, one per region", self.live.len(), scales.len())?;
        let mut point = match (scales, self.axes.len()) {
            ([only], _) => vec![theta * only],
            ([p, q], 2) if self.live == [true, true] => {
                vec![theta * (p * q).sqrt(), (p / q).sqrt()]
            }
            _ => {
                let live = scales.iter().zip(&self.live).filter(|(_, live)| **live);
                std::iter::once(theta).chain(live.map(|(s, _)| *s)).collect()
            }
        };
        // The very end of a range may be left by a rounding of the products above; only that is undone.
        for (x, axis) in point.iter_mut().zip(&self.axes) {
            let (lower, upper) = axis.range();
            let end = if *x < lower { lower } else { upper };
            let outside = *x < lower || *x > upper;
            if outside && (*x / end - 1.0).abs() <= 16.0 * f64::EPSILON {
                *x = end;
            }
        }
        Ok(point)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::Random;

    #[test]
    fn points_and_powers_are_inverse_to_each_other() {
        let mut random = Random::new(1);
        let common = (1e-4, 1e-2);
        for regions in 1..=5usize {
            // every choice of live regions with its corners and a random point
            for which in 0..1u32 << regions {
                let range = |q: usize| (0.5 / (1.0 + q as f64), 2.0);
                let scales: Vec<_> = (0..regions).map(|q| (which >> q & 1 == 1).then(|| range(q))).collect();
                let map = RegionAxes::new(common, &scales, 1e-3).unwrap();
                for corner in 0..=1u32 << (regions + 1) {
                    let mut at = |bit: usize, (low, high): (f64, f64)| match corner {
                        c if c == 1 << (regions + 1) => low * (high / low).powf(random.uniform()),
                        c if c >> bit & 1 == 1 => high,
                        _ => low,
                    };
                    let theta = at(regions, common);
                    let kappa: Vec<f64> = (0..regions).map(|q| scales[q].map_or(1.0, |s| at(q, s))).collect();
                    let point = map.point(theta, &kappa).unwrap();
                    for (x, axis) in point.iter().zip(map.axes()) {
                        assert!(axis.evaluate(&vec![1.0; axis.len()], *x).is_ok(), "{x} on {axis:?}");
                    }
                    for (power, k) in map.powers().iter().zip(&kappa) {
                        let back: f64 = power.iter().zip(&point).map(|(p, x)| x.powf(*p)).product();
                        assert!((back / (theta * k) - 1.0).abs() < 16.0 * f64::EPSILON, "a few roundings");
                    }
                }
            }
        }
    }

    #[test]
    fn what_is_outside_stays_outside() {
        assert!(matches!(RegionAxes::new((1.0, 2.0), &[], 1e-3), Err(SeparatedError::Shape { .. })));
        let map = RegionAxes::new((1e-4, 1e-2), &[Some((0.5, 2.0)); 2], 1e-3).unwrap();
        for (theta, scales) in [(3e-2, [2.0, 2.0]), (1e-2 * (1.0 + 1e-12), [2.0, 2.0])] {
            let point = map.point(theta, &scales).unwrap();
            assert!(matches!(
                map.axes()[0].evaluate(&vec![0.0; map.axes()[0].len()], point[0]),
                Err(SeparatedError::OutsideAxis { .. })
            ));
        }
    }
}
