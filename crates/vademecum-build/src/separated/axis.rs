//! One parameter with its unit, its range and the functions that live on it.
//!
//! A factor on an axis is a vector of values at the axis' points; its basis turns the vector into a function.
//! Hat functions are the chapter's choice; Chebyshev points (second kind, barycentric interpolation,
//! Clenshaw–Curtis weights) converge exponentially for the smooth functions that parameters cause; an index
//! axis has no "between". A logarithmic axis does all this in `x = ln μ`. Points outside the range are
//! refused, never clamped.

use super::error::SeparatedError;
use super::operator::AxisOperator;

/// What functions live on an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub enum AxisKind {
    /// Piecewise linear finite elements on equidistant points.
    Hat {
        /// Number of points, at least 2.
        points: usize,
    },
    /// Polynomials through Chebyshev points of the second kind, the ends included.
    Chebyshev {
        /// Number of points, at least 2.
        points: usize,
    },
    /// Whole-numbered positions `lower, lower + 1, …, upper`, such as loadable dofs.
    Index,
}

/// Upper over lower end of a logarithmic axis: over twelve decades a response changes by as many, and what is
/// left of it at the small end is rounding.
const WIDEST: f64 = 1e12;

/// One parameter axis. Made whole by [`Axis::new`] and never changed.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Axis {
    name: String,
    unit: String,
    lower: f64,
    upper: f64,
    kind: AxisKind,
    log: bool,
    nodes: Vec<f64>,
}

impl Axis {
    /// An axis over `[lower, upper]` in `unit`; `log` puts the functions on `ln μ`.
    ///
    /// # Errors
    /// [`SeparatedError::BadRange`], [`SeparatedError::LogOfNonPositive`], [`SeparatedError::TooFewPoints`];
    /// an index axis whose ends are not whole numbers is a [`SeparatedError::NotAPosition`]; it may have a
    /// single position.
    pub fn new(
        name: &str,
        unit: &str,
        lower: f64,
        upper: f64,
        kind: AxisKind,
        log: bool,
    ) -> Result<Axis, SeparatedError> {
        let axis = name.to_owned();
        let single = kind == AxisKind::Index && lower == upper;
        if !(lower.is_finite() && upper.is_finite() && (lower < upper || single)) {
            return Err(SeparatedError::BadRange { axis, lower, upper });
        }
        if log && lower <= 0.0 {
            return Err(SeparatedError::LogOfNonPositive { axis, lower });
        }
        if log && upper / lower > WIDEST {
            return Err(SeparatedError::TooWide { axis, lower, upper });
        }
        if let AxisKind::Hat { points } | AxisKind::Chebyshev { points } = kind
            && points < 2
        {
            return Err(SeparatedError::TooFewPoints { axis, points });
        }
        if let Some(value) = [lower, upper].into_iter().find(|v| kind == AxisKind::Index && v.fract() != 0.0)
        {
            return Err(SeparatedError::NotAPosition { axis, value });
        }
        let mut made = Axis { name: axis, unit: unit.to_owned(), lower, upper, kind, log, nodes: Vec::new() };
        made.nodes = made.place_nodes();
        Ok(made)
    }

    /// Name, as the user wrote it.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Unit of the values.
    pub fn unit(&self) -> &str {
        &self.unit
    }

    /// Lower and upper end, in the unit of the axis.
    pub fn range(&self) -> (f64, f64) {
        (self.lower, self.upper)
    }

    /// The functions on this axis.
    pub fn kind(&self) -> AxisKind {
        self.kind
    }

    /// Whether the functions are functions of `ln μ`.
    pub(crate) fn is_log(&self) -> bool {
        self.log
    }

    /// Values of the parameter at the points, ascending, in the unit of the axis.
    pub fn nodes(&self) -> &[f64] {
        &self.nodes
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.nodes.len()
    }

    /// Never true: an axis has points.
    pub fn is_empty(&self) -> bool {
        false
    }

    /// The point a fraction `t ∈ [0, 1]` along the axis (in `ln μ` on a logarithmic one; rounded down to a
    /// position on an index axis).
    pub fn at_fraction(&self, t: f64) -> f64 {
        match self.kind {
            AxisKind::Index => self.nodes[((t * self.len() as f64) as usize).min(self.len() - 1)],
            _ => self.value_at(self.coordinate(self.lower) * (1.0 - t) + self.coordinate(self.upper) * t),
        }
    }

    /// Values of all basis functions at `point`, into `values` of length [`Axis::len`]; a factor `g` then has
    /// the value `Σ_j values_j g_j`. Costs O(points), allocates nothing.
    ///
    /// # Errors
    /// [`SeparatedError::OutsideAxis`] (NaN included), [`SeparatedError::NotAPosition`]; `values` is then
    /// untouched.
    pub(crate) fn basis_into(&self, point: f64, values: &mut [f64]) -> Result<(), SeparatedError> {
        super::error::check_len("basis values", self.len(), values.len())?;
        if !(self.lower <= point && point <= self.upper) {
            let (lower, upper) = (self.lower, self.upper);
            return Err(SeparatedError::OutsideAxis { axis: self.name.clone(), value: point, lower, upper });
        }
        match self.kind {
            AxisKind::Index if point.fract() != 0.0 => {
                return Err(SeparatedError::NotAPosition { axis: self.name.clone(), value: point });
            }
            AxisKind::Index => {
                values.fill(0.0);
                values[(point - self.lower) as usize] = 1.0;
            }
            AxisKind::Hat { points } => hat_basis(self.fraction(point), points, values),
            AxisKind::Chebyshev { points } => chebyshev_basis(self.fraction(point), points, values),
        }
        Ok(())
    }

    /// Value at `point` of the factor whose values at the axis' points are `factor`.
    ///
    /// # Errors
    /// As `Axis::basis_into`.
    pub fn evaluate(&self, factor: &[f64], point: f64) -> Result<f64, SeparatedError> {
        super::error::check_len("factor", self.len(), factor.len())?;
        let mut basis = vec![0.0; self.len()];
        self.basis_into(point, &mut basis)?;
        Ok(basis.iter().zip(factor).map(|(b, g)| b * g).sum())
    }

    /// Gram matrix of the basis, `∫ N_i N_j dx` over `x = μ` or `ln μ`: the finite element mass matrix for
    /// hats, the Clenshaw–Curtis weights at the points for Chebyshev, one per position for an index axis.
    pub fn gram(&self) -> AxisOperator {
        match self.kind {
            AxisKind::Index => AxisOperator::diagonal(vec![1.0; self.len()]),
            AxisKind::Hat { points } => {
                let h = self.width() / (points - 1) as f64;
                let mut diagonal = vec![2.0 * h / 3.0; points];
                diagonal[0] = h / 3.0;
                diagonal[points - 1] = h / 3.0;
                AxisOperator::tridiagonal(vec![h / 6.0; points - 1], diagonal, vec![h / 6.0; points - 1])
            }
            AxisKind::Chebyshev { points } => {
                let weights = clenshaw_curtis(points).into_iter();
                AxisOperator::diagonal(weights.map(|w| w * self.width() / 2.0).collect())
            }
        }
    }

    /// `ln μ` on a logarithmic axis, else `μ`.
    fn coordinate(&self, value: f64) -> f64 {
        if self.log { value.ln() } else { value }
    }

    /// Inverse of [`Axis::coordinate`], kept within the range against rounding of `exp`.
    fn value_at(&self, x: f64) -> f64 {
        (if self.log { x.exp() } else { x }).clamp(self.lower, self.upper)
    }

    /// Length of the axis in its coordinate.
    fn width(&self) -> f64 {
        self.coordinate(self.upper) - self.coordinate(self.lower)
    }

    /// Position along the axis in `[−1, 1]`; outside of it for a point that lies outside.
    pub(super) fn position(&self, point: f64) -> f64 {
        2.0 * (self.coordinate(point) - self.coordinate(self.lower)) / self.width() - 1.0
    }

    /// Position of an admissible point between the ends, in `[0, 1]`.
    fn fraction(&self, point: f64) -> f64 {
        ((self.coordinate(point) - self.coordinate(self.lower)) / self.width()).clamp(0.0, 1.0)
    }

    fn place_nodes(&self) -> Vec<f64> {
        let placed = |points: usize, fraction: &dyn Fn(usize) -> f64| -> Vec<f64> {
            let mut nodes: Vec<f64> = (0..points).map(|j| self.at_fraction(fraction(j))).collect();
            nodes[0] = self.lower;
            nodes[points - 1] = self.upper;
            nodes
        };
        match self.kind {
            AxisKind::Index => {
                (0..=(self.upper - self.lower) as usize).map(|j| self.lower + j as f64).collect()
            }
            AxisKind::Hat { points } => placed(points, &|j| j as f64 / (points - 1) as f64),
            AxisKind::Chebyshev { points } => placed(points, &|j| 0.5 - 0.5 * chebyshev_cosine(j, points)),
        }
    }
}

/// Chebyshev points that interpolate the solution of a parametric pencil over `μ ∈ [1, ratio]`, in `ln μ`, to
/// a relative `tolerance` wherever it is small.
///
/// `1/(1 + μλ)` has its poles at `ln μ = −ln λ ± iπ`; with `ρ` the Bernstein ellipse through them, the error
/// of `n` points is at most `4 ρ^{1−n}/(ρ − 1)` (Trefethen, Approximation Theory, thm. 8.2), and an increment
/// may be `ratio` times smaller at one end than at the other. `strip` is the distance of the poles from the
/// real axis: π, or π/2 for a contrast, which enters as `c` and `1/c` at once.
pub(crate) fn chebyshev_points(ratio: f64, strip: f64, tolerance: f64) -> usize {
    // A wider axis is refused when it is made; it still needs some number of points to be refused with.
    let ratio = ratio.min(WIDEST);
    let x = 2.0 * strip / ratio.ln();
    let rho = x + (1.0 + x * x).sqrt();
    let points = 1.0 + (4.0 * ratio / (tolerance * (rho - 1.0))).ln() / rho.ln();
    (points.ceil() as usize).max(2)
}

/// `cos(π j / (points − 1))`, from 1 down to −1, written as a sine so that it is exactly antisymmetric.
pub(super) fn chebyshev_cosine(j: usize, points: usize) -> f64 {
    let n = (points - 1) as f64;
    (std::f64::consts::FRAC_PI_2 * (n - 2.0 * j as f64) / n).sin()
}

/// Hat functions of `points` equidistant points on [0, 1].
fn hat_basis(t: f64, points: usize, values: &mut [f64]) {
    values.fill(0.0);
    let x = t * (points - 1) as f64;
    let left = (x as usize).min(points - 2);
    values[left] = 1.0 - (x - left as f64);
    values[left + 1] = x - left as f64;
}

/// Lagrange polynomials of the Chebyshev points of the second kind on [0, 1], by the barycentric formula
/// (weights `(−1)^j`, halved at the ends).
fn chebyshev_basis(t: f64, points: usize, values: &mut [f64]) {
    let mut sum = 0.0;
    for j in 0..points {
        let gap = t - (0.5 - 0.5 * chebyshev_cosine(j, points));
        if gap == 0.0 {
            values.fill(0.0);
            values[j] = 1.0;
            return;
        }
        let end = if j == 0 || j == points - 1 { 0.5 } else { 1.0 };
        values[j] = if j % 2 == 0 { end } else { -end } / gap;
        sum += values[j];
    }
    values.iter_mut().for_each(|v| *v /= sum);
}

/// Clenshaw–Curtis weights on [−1, 1]: exact for polynomials of degree below `points`.
fn clenshaw_curtis(points: usize) -> Vec<f64> {
    let n = points - 1;
    let weight = |j: usize| {
        let mut w = 1.0;
        for k in 1..=n / 2 {
            let half = if 2 * k == n { 0.5 } else { 1.0 };
            let angle = 2.0 * std::f64::consts::PI * (k * j) as f64 / n as f64;
            w -= 2.0 * half * angle.cos() / (4.0 * (k * k) as f64 - 1.0);
        }
        let end = if j == 0 || j == n { 1.0 } else { 2.0 };
        w * end / n as f64
    };
    (0..points).map(weight).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn axis(kind: AxisKind, lower: f64, upper: f64, log: bool) -> Axis {
        Axis::new("theta", "1", lower, upper, kind, log).unwrap()
    }

    #[test]
    fn refuses_points_outside_and_between_positions() {
        for kind in [AxisKind::Hat { points: 5 }, AxisKind::Chebyshev { points: 5 }] {
            for log in [false, true] {
                let axis = axis(kind, 0.5, 2.0, log);
                let mut values = vec![7.0; 5];
                for bad in [0.5 - 1e-15, 2.0 + 1e-15, f64::NAN, f64::INFINITY, -1.0] {
                    assert!(matches!(
                        axis.basis_into(bad, &mut values),
                        Err(SeparatedError::OutsideAxis { .. })
                    ));
                    assert_eq!(values, [7.0; 5]);
                }
                for node in axis.nodes().to_vec() {
                    axis.basis_into(node, &mut values).unwrap();
                    // 64 roundings of a quotient of logarithms, divided by the gap to the next node
                    assert!((values.iter().sum::<f64>() - 1.0).abs() < 64.0 * f64::EPSILON);
                }
            }
        }
        let index = axis(AxisKind::Index, 3.0, 6.0, false);
        assert_eq!(index.evaluate(&[1.0, 2.0, 3.0, 4.0], 5.0), Ok(3.0));
        assert!(matches!(index.evaluate(&[0.0; 4], 4.5), Err(SeparatedError::NotAPosition { .. })));
        assert!(matches!(index.evaluate(&[0.0; 4], 7.0), Err(SeparatedError::OutsideAxis { .. })));
    }

    #[test]
    fn refuses_bad_ranges_by_name() {
        let make = |l, u, kind, log| Axis::new("E", "Pa", l, u, kind, log).unwrap_err();
        let hat = AxisKind::Hat { points: 3 };
        assert!(matches!(make(2.0, 1.0, hat, false), SeparatedError::BadRange { .. }));
        assert!(matches!(make(1.0, 1.0, hat, false), SeparatedError::BadRange { .. }));
        assert!(matches!(make(f64::NAN, 1.0, hat, false), SeparatedError::BadRange { .. }));
        assert!(matches!(make(0.0, 1.0, hat, true), SeparatedError::LogOfNonPositive { .. }));
        assert!(matches!(
            make(0.0, 1.0, AxisKind::Hat { points: 1 }, false),
            SeparatedError::TooFewPoints { .. }
        ));
        assert!(matches!(make(0.5, 3.0, AxisKind::Index, false), SeparatedError::NotAPosition { .. }));
    }

    #[test]
    fn chebyshev_interpolates_and_integrates_polynomials_exactly() {
        let axis = axis(AxisKind::Chebyshev { points: 7 }, -1.0, 3.0, false);
        let p = |x: f64| 1.0 - x + 0.5 * x.powi(3) - 0.1 * x.powi(6);
        let values: Vec<f64> = axis.nodes().iter().map(|&x| p(x)).collect();
        let largest = values.iter().fold(0.0f64, |m, v| m.max(v.abs()));
        for k in 0..50 {
            let x = axis.at_fraction(k as f64 / 49.0);
            // seven products of rounded numbers; the Lebesgue constant of 7 points is below 3
            assert!((axis.evaluate(&values, x).unwrap() - p(x)).abs() < 100.0 * f64::EPSILON * largest);
        }
        let integral: f64 = axis.gram().apply(&values).iter().sum();
        let exact = 4.0 - 4.0 + 0.125 * (81.0 - 1.0) - 0.1 / 7.0 * (2187.0 + 1.0);
        assert!((integral - exact).abs() < 100.0 * f64::EPSILON * largest * 4.0);
    }

    #[test]
    fn the_number_of_points_keeps_its_tolerance_and_is_not_wasteful() {
        for ratio in [4.0, 10.0, 100.0, 1e4] {
            for tolerance in [1e-4, 1e-6, 1e-8] {
                let points = chebyshev_points(ratio, std::f64::consts::PI, tolerance);
                let worst = |points: usize| {
                    let axis = axis(AxisKind::Chebyshev { points }, 1.0, ratio, true);
                    let mut worst = 0.0f64;
                    for lambda in (-40..=20).map(|k| 10f64.powf(0.1 * f64::from(k))) {
                        let x = |t: f64| t * lambda / (1.0 + t * lambda);
                        let values: Vec<f64> = axis.nodes().iter().map(|t| x(*t)).collect();
                        for k in 0..=100 {
                            let t = axis.at_fraction(f64::from(k) / 100.0);
                            worst = worst.max((axis.evaluate(&values, t).unwrap() / x(t) - 1.0).abs());
                        }
                    }
                    worst
                };
                assert!(worst(points) <= tolerance, "{ratio} {tolerance} {points}: {}", worst(points));
                assert!(
                    worst(points / 2) > tolerance,
                    "half of the points are not enough: the bound is not wasteful"
                );
            }
        }
    }

    #[test]
    fn the_gram_matrix_of_hats_is_exact_for_linear_functions() {
        let axis = axis(AxisKind::Hat { points: 6 }, 1.0, 3.0, false);
        let x = axis.nodes();
        let square: f64 = x.iter().zip(axis.gram().apply(x)).map(|(p, q)| p * q).sum();
        assert!((square - 26.0 / 3.0).abs() < 1e-14, "∫x² over [1,3]; 6 terms of size 1, rounded");
    }
}
