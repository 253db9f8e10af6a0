//! The place of a scene on the axes of a separated solution, and the weights of its terms there:
//! `g_t = Π_a g_ta(c_a)`.
//!
//! A factor between its points is a sum `Σ_j φ_j(c) f_j` whose basis functions `φ_j` (units, hats or Lagrange
//! cardinals) do not depend on the term. So they are evaluated once per axis and stage, and a term costs one
//! dot product per axis.

use crate::base::error::BindError;
use crate::base::lend::{Lender, Short};
use vademecum_format::{Axis, AxisKind, AxisRole, Metadata};

/// A coordinate may pass the end of its axis by this much of itself: it is a product of up to 17 powers, the
/// range was computed from another order of them, and each rounds once or twice.
const ROUNDING: f64 = 16.0 * f64::EPSILON;

/// The coordinates of a stage.
#[derive(Clone, Copy)]
pub(crate) struct StagePlace<'p> {
    pub stage: usize,
    /// The stage's `θ` \[s²\].
    pub theta: f64,
    /// `κ_q`.
    pub stiffness: &'p [f64],
    /// `ρ_q`.
    pub density: &'p [f64],
}

impl StagePlace<'_> {
    /// The coordinate of an axis; `None` for a role this evaluator does not know.
    fn coordinate(&self, role: &AxisRole) -> Option<f64> {
        match role {
            AxisRole::Stage => Some(self.stage as f64),
            AxisRole::Monomial { theta, stiffness, density } => {
                let scales = self.stiffness.iter().zip(stiffness).chain(self.density.iter().zip(density));
                let start = power(self.theta, *theta);
                Some(scales.fold(start, |product, (&scale, &exponent)| product * power(scale, exponent)))
            }
            _ => None,
        }
    }

    /// The coordinate, held to the axis' range: past an end by rounding it is the end.
    fn on_axis(&self, index: usize, axis: &Axis<'_>) -> Result<f64, BindError> {
        let value = self.coordinate(&axis.role).ok_or(BindError::UnknownAxis { axis: index })?;
        let slack = ROUNDING * if value < 0.0 { -value } else { value };
        if !(axis.lower..=axis.upper).contains(&value) {
            if value < axis.lower && axis.lower <= value + slack {
                return Ok(axis.lower);
            }
            if value > axis.upper && value - slack <= axis.upper {
                return Ok(axis.upper);
            }
            return Err(BindError::OutsideAxis { axis: index, value });
        }
        Ok(value)
    }
}

/// `x^exponent`, without a call for the exponents that occur most.
fn power(x: f64, exponent: f64) -> f64 {
    if exponent == 0.0 {
        1.0
    } else if exponent == 1.0 {
        x
    } else if exponent == -1.0 {
        1.0 / x
    } else {
        libm::pow(x, exponent)
    }
}

/// The axes of a file, prepared in lent memory; every slice has one number per point of all axes, one axis
/// after the other.
pub(crate) struct Axes<'w> {
    /// The points, in logarithms where the axis says so.
    nodes: &'w mut [f64],
    /// Barycentric weights of the Chebyshev axes.
    weights: &'w mut [f64],
    /// `φ_j` at the current place.
    basis: &'w mut [f64],
}

impl<'w> Axes<'w> {
    /// Numbers of work memory per point.
    pub const WORK: usize = 3;

    /// Reads the points and computes what does not depend on the place. `work` has [`Axes::WORK`] numbers per
    /// point.
    pub fn new(metadata: &Metadata<'_>, points: &[[u8; 8]], work: &'w mut [f64]) -> Result<Self, Short> {
        let (n_points, mut work) = (points.len(), Lender::new(work));
        let (nodes, weights, basis) = (work.take(n_points)?, work.take(n_points)?, work.take(n_points)?);
        let mut points = Lender::new(points);
        let (mut all_nodes, mut all_weights) = (Lender::new(&mut *nodes), Lender::new(&mut *weights));
        for axis in metadata.active_axes() {
            let n = axis.n_points as usize;
            let (nodes, weights) = (all_nodes.take(n)?, all_weights.take(n)?);
            for (node, bytes) in nodes.iter_mut().zip(points.take(n)?) {
                *node = place(axis, f64::from_le_bytes(*bytes));
            }
            if axis.kind == AxisKind::Chebyshev {
                barycentric_weights(nodes, weights);
            }
        }
        Ok(Self { nodes, weights, basis })
    }

    /// Evaluates the basis functions of all axes at `stage`.
    pub fn stand(&mut self, metadata: &Metadata<'_>, stage: &StagePlace<'_>) -> Result<(), BindError> {
        let (mut nodes, mut weights) = (Lender::new(&*self.nodes), Lender::new(&*self.weights));
        let mut basis = Lender::new(&mut *self.basis);
        for (index, axis) in metadata.active_axes().iter().enumerate() {
            let value = stage.on_axis(index, axis)?;
            let n = axis.n_points as usize;
            let (nodes, weights, basis) = (nodes.take(n)?, weights.take(n)?, basis.take(n)?);
            basis.fill(0.0);
            let known = match axis.kind {
                AxisKind::Index => index_basis(value, basis),
                AxisKind::Hat => hat_basis(place(axis, value), nodes, basis),
                AxisKind::Chebyshev => lagrange_basis(place(axis, value), nodes, weights, basis),
                _ => return Err(BindError::UnknownAxis { axis: index }),
            };
            known.ok_or(BindError::OutsideAxis { axis: index, value })?;
        }
        Ok(())
    }

    /// The weights of the first terms where the axes stand, into `out`; `factors` as the file stores them.
    pub fn term_weights(
        &self,
        metadata: &Metadata<'_>,
        factors: &[[u8; 8]],
        out: &mut [f64],
    ) -> Result<(), Short> {
        out.fill(1.0);
        let n_terms = metadata.n_terms as usize;
        let short = Short { found: n_terms, needed: out.len() };
        let (mut basis, mut factors) = (Lender::new(&*self.basis), Lender::new(factors));
        for axis in metadata.active_axes() {
            let n = axis.n_points as usize;
            let (basis, factors) = (basis.take(n)?, factors.take(n.saturating_mul(n_terms))?);
            // `next`, not `zip`: see `fuse_modes`.
            let mut rows = factors.chunks_exact(n.max(1));
            for weight in &mut *out {
                *weight *= dot(basis, rows.next().ok_or(short)?);
            }
        }
        Ok(())
    }
}

/// Interval and share of a value of an axis' unit among its nodes.
fn place(axis: &Axis<'_>, value: f64) -> f64 {
    if axis.log { libm::log(value) } else { value }
}

/// Four sums side by side: one alone waits for itself.
fn dot(basis: &[f64], row: &[[u8; 8]]) -> f64 {
    let (basis, basis_rest) = basis.as_chunks::<4>();
    let (row, row_rest) = row.as_chunks::<4>();
    let mut sums = [0.0; 4];
    for (basis, row) in basis.iter().zip(row) {
        for k in 0..4 {
            sums[k] += basis[k] * f64::from_le_bytes(row[k]);
        }
    }
    let rest: f64 = basis_rest.iter().zip(row_rest).map(|(b, &bytes)| b * f64::from_le_bytes(bytes)).sum();
    (sums[0] + sums[1]) + (sums[2] + sums[3]) + rest
}

fn index_basis(value: f64, basis: &mut [f64]) -> Option<()> {
    let exact = (value as usize as f64 == value).then_some(value as usize)?;
    *basis.get_mut(exact)? = 1.0;
    Some(())
}

fn hat_basis(x: f64, nodes: &[f64], basis: &mut [f64]) -> Option<()> {
    if let ([node], [one]) = (nodes, &mut *basis) {
        *one = 1.0;
        return (*node == x).then_some(());
    }
    let holds = |pair: &[f64]| matches!(pair, [left, right] if *left <= x && x <= *right && left < right);
    let at = nodes.windows(2).position(holds)?;
    let (left, right) = (*nodes.get(at)?, *nodes.get(at + 1)?);
    let share = (x - left) / (right - left);
    *basis.get_mut(at)? = 1.0 - share;
    *basis.get_mut(at + 1)? = share;
    Some(())
}

/// `w_j = 1/Π_k (x_j − x_k)`, each difference in quarters of the range so that the products neither grow nor
/// vanish.
fn barycentric_weights(nodes: &[f64], weights: &mut [f64]) {
    let (mut low, mut high) = (f64::MAX, f64::MIN);
    for &at in nodes {
        low = if at < low { at } else { low };
        high = if at > high { at } else { high };
    }
    let scale = 4.0 / (high - low);
    for (j, (weight, &at)) in weights.iter_mut().zip(nodes).enumerate() {
        let others = nodes.iter().enumerate().filter(|&(k, _)| k != j);
        *weight = 1.0 / others.fold(1.0, |product, (_, other)| product * ((at - other) * scale));
    }
}

/// Lagrange's cardinal functions at `x`: `(w_j/(x − x_j)) / Σ_k w_k/(x − x_k)`.
fn lagrange_basis(x: f64, nodes: &[f64], weights: &[f64], basis: &mut [f64]) -> Option<()> {
    if let Some(exact) = nodes.iter().position(|&node| node == x) {
        *basis.get_mut(exact)? = 1.0;
        return Some(());
    }
    let mut sum = 0.0;
    for ((out, node), weight) in basis.iter_mut().zip(nodes).zip(weights) {
        *out = weight / (x - node);
        sum += *out;
    }
    let scale = 1.0 / sum;
    basis.iter_mut().for_each(|out| *out *= scale);
    scale.is_finite().then_some(())
}
