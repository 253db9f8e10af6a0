//! A block over the box as a polynomial in its parameters: sampled at the points of a lower set, its
//! coefficients dense in space and sparse in the degrees. It is what the terms are fitted to.

use faer::{Mat, MatRef};

use super::axis::{Axis, AxisKind};
use super::error::SeparatedError;
use super::linalg::{norm, product, solve_semidefinite, transposed_product};
use super::lower_set::{LowerSet, leja_order, orthonormal_chebyshev};
use crate::parallel;

/// Blocks at the points of a lower set.
#[derive(Clone, Debug)]
pub struct SampledBlocks {
    axes: Vec<Axis>,
    set: LowerSet,
    /// `(n_rows · n_columns, n_samples)`, each column one block in column-major order.
    values: Mat<f64>,
    n_rows: usize,
}

impl SampledBlocks {
    /// Calls `solve` at the points of the whole grid if there are at most `most`, else at those of the
    /// largest simplex of degrees; points that `known` has are taken from there. In parallel, collected in
    /// order.
    ///
    /// # Errors
    /// Of `solve`; [`SeparatedError::NotPolynomial`] for an axis without Chebyshev points.
    pub fn collect(
        axes: &[Axis],
        most: usize,
        known: Option<&SampledBlocks>,
        solve: impl Fn(&[f64]) -> Result<Mat<f64>, SeparatedError> + Sync,
    ) -> Result<SampledBlocks, SeparatedError> {
        if let Some(axis) = axes.iter().find(|a| !matches!(a.kind(), AxisKind::Chebyshev { .. })) {
            return Err(SeparatedError::NotPolynomial { axis: axis.name().into() });
        }
        let lengths: Vec<usize> = axes.iter().map(Axis::len).collect();
        let orders: Vec<Vec<usize>> = lengths.iter().map(|n| leja_order(*n)).collect();
        let set = LowerSet::new(&lengths, most);
        let at = |place: usize| -> Result<Mat<f64>, SeparatedError> {
            let nu = &set.index()[place];
            if let Some(known) = known
                && let Ok(p) = known.set.index().binary_search(nu)
            {
                return Ok(known.block(p).to_owned());
            }
            let on_axis = |(a, k): (usize, &usize)| axes[a].nodes()[orders[a][*k]];
            solve(&nu.iter().enumerate().map(on_axis).collect::<Vec<f64>>())
        };
        let blocks = parallel::try_map(set.index().len(), &at)?;
        let (rows, columns) = blocks.first().map_or((1, 0), |b| (b.nrows(), b.ncols()));
        let values = Mat::from_fn(rows * columns, blocks.len(), |j, p| blocks[p][(j % rows, j / rows)]);
        Ok(SampledBlocks { axes: axes.to_vec(), set, values, n_rows: rows })
    }

    /// Whether every grid point is a sample: more cannot be had.
    pub fn is_whole_grid(&self) -> bool {
        self.set.is_whole()
    }

    fn block(&self, p: usize) -> MatRef<'_, f64> {
        MatRef::from_column_major_slice(
            self.values.col_as_slice(p),
            self.n_rows,
            self.values.nrows() / self.n_rows,
        )
    }
}

/// `f(μ) ω(μ) = Σ_ν c_ν Π_a T_{ν_a}(x_a)` with orthonormal Chebyshev polynomials, `x_a ∈ [−1, 1]` along each
/// axis and a weight `ω = Π_a ω_a` near one over the size of `f`: least squares then sees relative errors.
#[derive(Clone, Debug)]
pub struct Expansion {
    pub(super) axes: Vec<Axis>,
    pub(super) index: Vec<Vec<usize>>,
    /// `c`, `(n_rows · n_columns, n_degrees)`.
    pub(super) coefficients: Mat<f64>,
    pub(super) n_rows: usize,
    /// `[a] = (b, q)`: `ω_a = exp(−b x − q x²)`.
    weight: Vec<(f64, f64)>,
}

impl Expansion {
    /// Interpolates the samples.
    pub fn new(samples: &SampledBlocks) -> Expansion {
        let orders: Vec<Vec<usize>> = samples.axes.iter().map(|a| leja_order(a.len())).collect();
        let point = |nu: &Vec<usize>| -> Vec<f64> {
            let place =
                |(a, k): (usize, &usize)| samples.axes[a].position(samples.axes[a].nodes()[orders[a][*k]]);
            nu.iter().enumerate().map(place).collect()
        };
        let points: Vec<Vec<f64>> = samples.set.index().iter().map(point).collect();
        let weight = separable_size(&points, &samples.values);
        let omega: Vec<f64> = points.iter().map(|x| value(&weight, x)).collect();
        let mut coefficients =
            Mat::from_fn(samples.values.nrows(), omega.len(), |j, p| omega[p] * samples.values[(j, p)]);
        samples.set.transform_in_place(&mut coefficients);
        Expansion {
            axes: samples.axes.clone(),
            index: samples.set.index().to_vec(),
            coefficients,
            n_rows: samples.n_rows,
            weight,
        }
    }

    /// Blocks at points of the box.
    ///
    /// # Errors
    /// [`SeparatedError::OutsideAxis`].
    pub fn at(&self, points: &[Vec<f64>]) -> Result<Vec<Mat<f64>>, SeparatedError> {
        let mut basis = Mat::zeros(self.index.len(), points.len());
        for (p, point) in points.iter().enumerate() {
            let x: Vec<f64> = self.axes.iter().zip(point).map(|(a, v)| a.position(*v)).collect();
            for ((axis, v), x) in self.axes.iter().zip(point).zip(&x) {
                if !(-1.0..=1.0).contains(x) {
                    let (lower, upper) = axis.range();
                    return Err(SeparatedError::OutsideAxis {
                        axis: axis.name().into(),
                        value: *v,
                        lower,
                        upper,
                    });
                }
            }
            let tables: Vec<Vec<f64>> =
                self.axes.iter().zip(&x).map(|(a, x)| orthonormal_chebyshev(a.len(), *x)).collect();
            let inverse = value(&self.weight, &x).recip();
            for (k, nu) in self.index.iter().enumerate() {
                basis[(k, p)] = inverse * nu.iter().zip(&tables).map(|(d, t)| t[*d]).product::<f64>();
            }
        }
        let values = product(self.coefficients.as_ref(), basis.as_ref());
        let rows = self.n_rows;
        let columns = values.nrows() / rows;
        Ok((0..points.len()).map(|p| Mat::from_fn(rows, columns, |i, j| values[(i + j * rows, p)])).collect())
    }

    /// Coefficients of a weighted factor on axis `a` to values of the factor at the points of the axis,
    /// `(n, n)`.
    pub(super) fn nodal(&self, a: usize) -> Mat<f64> {
        let n = self.axes[a].len();
        let x: Vec<f64> = self.axes[a].nodes().iter().map(|v| self.axes[a].position(*v)).collect();
        let tables: Vec<Vec<f64>> = x.iter().map(|x| orthonormal_chebyshev(n, *x)).collect();
        let inverse = |j: usize| value(&self.weight[a..=a], &x[j..=j]).recip();
        Mat::from_fn(n, n, |j, k| inverse(j) * tables[j][k])
    }
}

/// `Π_a exp(−b_a x_a − q_a x_a²)`.
fn value(weight: &[(f64, f64)], x: &[f64]) -> f64 {
    (-weight.iter().zip(x).map(|((b, q), x)| b * x + q * x * x).sum::<f64>()).exp()
}

/// Least squares of `ln ‖f‖ = c + Σ_a (b_a x_a + q_a x_a²)`: smooth, so that `f ω` needs no higher degrees
/// than `f`.
fn separable_size(points: &[Vec<f64>], values: &Mat<f64>) -> Vec<(f64, f64)> {
    let axes = points.first().map_or(0, Vec::len);
    let sizes: Vec<f64> = (0..points.len()).map(|p| norm(values.as_ref().subcols(p, 1))).collect();
    let seen: Vec<usize> = (0..points.len()).filter(|&p| sizes[p] > 0.0 && sizes[p].is_finite()).collect();
    let monomial = |x: &[f64], k: usize| match k {
        0 => 1.0,
        k if k % 2 == 1 => x[k / 2],
        k => x[k / 2 - 1] * x[k / 2 - 1],
    };
    let design = Mat::from_fn(seen.len(), 1 + 2 * axes, |p, k| monomial(&points[seen[p]], k));
    let logarithm = Mat::from_fn(seen.len(), 1, |p, _| sizes[seen[p]].ln());
    let gram = transposed_product(design.as_ref(), design.as_ref());
    let c = solve_semidefinite(gram.as_ref(), transposed_product(design.as_ref(), logarithm.as_ref()));
    (0..axes).map(|a| (c[(1 + 2 * a, 0)], c[(2 + 2 * a, 0)])).collect()
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicUsize, Ordering};

    use super::*;
    use crate::linalg::Random;
    use crate::separated::chebyshev_points;

    /// Axes of `θ` and `κ` whose points interpolate `1/(1 + θκ)` to 1e-6 each.
    fn axes() -> Vec<Axis> {
        let axis = |name: &str, lower: f64, upper: f64| {
            let points = chebyshev_points(upper / lower, std::f64::consts::PI, 1e-6);
            Axis::new(name, "1", lower, upper, AxisKind::Chebyshev { points }, true).unwrap()
        };
        vec![axis("theta", 0.1, 10.0), axis("kappa", 0.5, 2.0)]
    }

    /// `−θκ/(1 + θκ)` and a product, as a block of 1 × 2.
    fn block(point: &[f64]) -> Mat<f64> {
        let x = point[0] * point[1];
        Mat::from_fn(1, 2, |_, j| if j == 0 { -x / (1.0 + x) } else { point[0].sqrt() })
    }

    #[test]
    fn an_expansion_keeps_the_tolerance_of_its_axes() {
        let axes = axes();
        let samples = SampledBlocks::collect(&axes, 10_000, None, |point| Ok(block(point))).unwrap();
        assert!(samples.is_whole_grid());
        let mut random = Random::new(4);
        let points: Vec<Vec<f64>> =
            (0..100).map(|_| axes.iter().map(|a| a.at_fraction(random.uniform())).collect()).collect();
        for (point, found) in points.iter().zip(Expansion::new(&samples).at(&points).unwrap()) {
            let exact = block(point);
            // the second axis interpolates what the first has made of the values: a Lebesgue constant below 5
            assert!((&found - &exact).norm_l2() < 5e-6 * exact.norm_l2(), "{point:?}");
        }
    }

    #[test]
    fn known_samples_are_not_solved_again() {
        let (axes, calls) = (axes(), AtomicUsize::new(0));
        let solve = |point: &[f64]| {
            calls.fetch_add(1, Ordering::Relaxed);
            Ok(block(point))
        };
        let few = SampledBlocks::collect(&axes, 40, None, solve).unwrap();
        let first = calls.swap(0, Ordering::Relaxed);
        assert!(first <= 40 && !few.is_whole_grid());
        let more = SampledBlocks::collect(&axes, 80, Some(&few), solve).unwrap();
        let second = calls.swap(0, Ordering::Relaxed);
        let afresh = SampledBlocks::collect(&axes, 80, None, solve).unwrap();
        assert_eq!(first + second, calls.load(Ordering::Relaxed));
        assert_eq!(more.values, afresh.values);
    }

    #[test]
    fn refuses_other_axes_and_points_outside() {
        let hat = Axis::new("theta", "1", 0.1, 1.0, AxisKind::Hat { points: 5 }, false).unwrap();
        let refused = SampledBlocks::collect(&[hat], 10, None, |_| Ok(Mat::zeros(1, 1)));
        assert!(matches!(refused, Err(SeparatedError::NotPolynomial { axis }) if axis == "theta"));
        let failed = SeparatedError::NotPositiveDefinite { what: "a sample" };
        let refused = SampledBlocks::collect(&axes(), 10, None, |_| Err(failed.clone()));
        assert_eq!(refused.unwrap_err(), failed, "what a solve fails with is the error");
        let samples = SampledBlocks::collect(&axes(), 10, None, |point| Ok(block(point))).unwrap();
        for outside in [[0.09, 1.0], [1.0, 2.1], [1.0, f64::NAN]] {
            let found = Expansion::new(&samples).at(&[outside.to_vec()]);
            assert!(matches!(found, Err(SeparatedError::OutsideAxis { .. })), "{outside:?}");
        }
    }
}
