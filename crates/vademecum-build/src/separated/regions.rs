//! Axes for several stiffness regions: one common `θ` and contrasts between halves.
//!
//! Regions share the time step, damping and scheme, so their `θ_q = θ κ_q` move together. Choosing axes by what they do
//! (method.md §4): the geometric mean of all `θ_q` is one axis, and every further axis is the contrast between two halves
//! of the regions, then between the halves of each half. With `G₁, G₂` the halves of a split, its coordinate is
//! `ln c = ½ (mean_{G₁} ln θ − mean_{G₂} ln θ)`. That is one axis per region, none redundant, and a contrast of scales in
//! [½, 2] is again in [½, 2] (ratios to a reference region would be in [¼, 4]).

use super::axis::{Axis, AxisKind};
use super::error::{SeparatedError, check_len};

/// The map between the `θ_q` of the regions and a point on the axes.
#[derive(Clone, Debug)]
pub struct RegionAxes {
    axes: Vec<Axis>,
    /// `[q][a]`: exponent of axis `a` in `θ_q`.
    powers: Vec<Vec<f64>>,
    /// The two ranges of regions of every contrast: `(start, middle, end)`.
    splits: Vec<(usize, usize, usize)>,
}

impl RegionAxes {
    /// Axes for a common `theta` range times one range `scales[q]` per region, with this many Chebyshev points for the
    /// mean and for each contrast. A single region takes the mean only.
    ///
    /// # Errors
    /// As [`Axis::new`]; [`SeparatedError::Shape`] without regions.
    pub fn new(
        theta: (f64, f64),
        scales: &[(f64, f64)],
        mean_points: usize,
        contrast_points: usize,
    ) -> Result<RegionAxes, SeparatedError> {
        if scales.is_empty() {
            return Err(SeparatedError::Shape { what: "regions", expected: 1, found: 0 });
        }
        let mean = |range: &[(f64, f64)]| {
            let n = range.len() as f64;
            (range.iter().map(|r| r.0.ln()).sum::<f64>() / n, range.iter().map(|r| r.1.ln()).sum::<f64>() / n)
        };
        let axis = |name: &str, lower: f64, upper: f64, points: usize| {
            Axis::new(name, "1", lower, upper, AxisKind::Chebyshev { points }, true)
        };
        let all = mean(scales);
        let mut axes = vec![axis("theta", theta.0 * all.0.exp(), theta.1 * all.1.exp(), mean_points)?];
        let mut powers = vec![vec![1.0]; scales.len()];
        let mut splits = Vec::new();
        split(0, scales.len(), &mut splits);
        for &(start, middle, end) in &splits {
            let (low, high) = (mean(&scales[start..middle]), mean(&scales[middle..end]));
            let (lower, upper) = (0.5 * (low.0 - high.1), 0.5 * (low.1 - high.0));
            axes.push(axis(&format!("contrast {start}..{middle} : {middle}..{end}"), lower.exp(), upper.exp(), contrast_points)?);
            // Weights that leave the mean of all regions alone and add up to 2, whatever the sizes of the halves.
            let (p, q) = ((middle - start) as f64, (end - middle) as f64);
            for (region, power) in powers.iter_mut().enumerate() {
                power.push(match region {
                    r if (start..middle).contains(&r) => 2.0 * q / (p + q),
                    r if (middle..end).contains(&r) => -2.0 * p / (p + q),
                    _ => 0.0,
                });
            }
        }
        Ok(RegionAxes { axes, powers, splits })
    }

    /// The axes: the mean `θ`, then the contrasts.
    pub fn axes(&self) -> &[Axis] {
        &self.axes
    }

    /// Exponents of the axes in every `θ_q`, for [`BlockProblem::increment`](super::BlockProblem::increment).
    pub fn powers(&self) -> &[Vec<f64>] {
        &self.powers
    }

    /// The point on the axes at which the regions have these `θ_q`.
    ///
    /// # Errors
    /// [`SeparatedError::Shape`]. Whether the point is on the axes is for the axes to say.
    pub fn point(&self, theta: &[f64]) -> Result<Vec<f64>, SeparatedError> {
        check_len("θ, one per region", self.powers.len(), theta.len())?;
        let mean = |range: &[f64]| range.iter().map(|t| t.ln()).sum::<f64>() / range.len() as f64;
        let contrast = |&(s, m, e): &(usize, usize, usize)| (0.5 * (mean(&theta[s..m]) - mean(&theta[m..e]))).exp();
        let mut point = vec![mean(theta).exp()];
        point.extend(self.splits.iter().map(contrast));
        // A scale at the very end of its range may leave the axis by a rounding of ln and exp; only that is undone.
        for (x, axis) in point.iter_mut().zip(&self.axes) {
            let (lower, upper) = axis.range();
            let near = |end: f64, x: f64| (x / end - 1.0).abs() <= 64.0 * f64::EPSILON;
            if near(lower, *x) {
                *x = lower;
            } else if near(upper, *x) {
                *x = upper;
            }
        }
        Ok(point)
    }
}

/// Halves, then halves of the halves.
fn split(start: usize, end: usize, splits: &mut Vec<(usize, usize, usize)>) {
    if end - start < 2 {
        return;
    }
    let middle = start + (end - start).div_ceil(2);
    splits.push((start, middle, end));
    split(start, middle, splits);
    split(middle, end, splits);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::separated::{Random, SeparatedError};

    #[test]
    fn points_and_powers_are_inverse_to_each_other() {
        let mut random = Random::new(1);
        for regions in 1..=6 {
            let scales: Vec<(f64, f64)> = (0..regions).map(|q| (0.5 / (1.0 + q as f64), 2.0)).collect();
            let map = RegionAxes::new((1e-4, 1e-2), &scales, 5, 4).unwrap();
            assert_eq!(map.axes().len(), regions);
            for corner in 0..1 << (regions + 1) {
                // corners first, then a random point: all must lie on the axes
                for t in [None, Some(())] {
                    let mut at = |bit: usize, (low, high): (f64, f64)| match t {
                        None => if corner >> bit & 1 == 1 { high } else { low },
                        Some(()) => low * (high / low).powf(random.uniform()),
                    };
                    let common = at(regions, (1e-4, 1e-2));
                    let theta: Vec<f64> = (0..regions).map(|q| common * at(q, scales[q])).collect();
                    let point = map.point(&theta).unwrap();
                    for (x, axis) in point.iter().zip(map.axes()) {
                        assert!(axis.evaluate(&vec![1.0; axis.len()], *x).is_ok(), "{x} on {axis:?}");
                    }
                    for (power, theta) in map.powers().iter().zip(&theta) {
                        let back: f64 = power.iter().zip(&point).map(|(p, x)| x.powf(*p)).product();
                        assert!((back / theta - 1.0).abs() < 1e-13, "a dozen roundings of ln, exp and powf");
                    }
                }
            }
        }
        assert!(matches!(RegionAxes::new((1.0, 2.0), &[], 3, 3), Err(SeparatedError::Shape { .. })));
        let map = RegionAxes::new((1e-4, 1e-2), &[(0.5, 2.0); 2], 5, 4).unwrap();
        let outside = map.point(&[3e-2, 3e-2]).unwrap();
        assert!(matches!(map.axes()[0].evaluate(&[0.0; 5], outside[0]), Err(SeparatedError::OutsideAxis { .. })));
    }
}
