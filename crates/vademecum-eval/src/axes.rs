//! Factors of a separated solution at given parameters: `g_t = Π_a g_ta(μ_a)`.

use crate::error::BindError;
use vademecum_format::{Axis, AxisKind, AxisRole, Metadata};

/// Points and factors of all axes as the file stores them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Factors<'m> {
    pub points: &'m [[u8; 8]],
    pub factors: &'m [[u8; 8]],
}

/// Where a stage stands on the axes.
pub(crate) struct StagePlace {
    pub stage: usize,
    pub theta: f64,
}

impl StagePlace {
    /// The value of an axis; regions have no scale of their own here and stand at their nominal 1.
    fn value(&self, role: AxisRole) -> Option<f64> {
        Some(match role {
            AxisRole::Stage => self.stage as f64,
            AxisRole::Monomial { theta, .. } => libm::pow(self.theta, theta),
            _ => return None,
        })
    }
}

impl Factors<'_> {
    /// Weight of `term` at `place`: the product of its factors.
    pub fn weight(
        &self,
        metadata: &Metadata<'_>,
        term: usize,
        place: &StagePlace,
    ) -> Result<f64, BindError> {
        let n_terms = metadata.n_terms as usize;
        let (mut first, mut weight) = (0, 1.0);
        for (index, axis) in metadata.active_axes().iter().enumerate() {
            let n = axis.n_points as usize;
            let value = place
                .value(axis.role)
                .ok_or(BindError::UnknownAxis { axis: index })?;
            let outside = BindError::OutsideAxis { axis: index, value };
            if !(axis.lower..=axis.upper).contains(&value) {
                return Err(outside);
            }
            let points = self.points.get(first..first + n).unwrap_or_default();
            let row = first * n_terms + term * n;
            let factors = self.factors.get(row..row + n).unwrap_or_default();
            weight *= evaluate(axis, points, factors, value).ok_or(outside)?;
            first += n;
        }
        Ok(weight)
    }
}

/// The factor at `value`; `None` between the points of an index axis or past the points of the others.
fn evaluate(axis: &Axis<'_>, points: &[[u8; 8]], factors: &[[u8; 8]], value: f64) -> Option<f64> {
    let place = |value: f64| if axis.log { libm::log(value) } else { value };
    let x = place(value);
    let point = |bytes: &[u8; 8]| place(f64::from_le_bytes(*bytes));
    match axis.kind {
        AxisKind::Index => {
            let exact = (value as usize as f64 == value).then_some(value as usize)?;
            factors.get(exact).map(|&bytes| f64::from_le_bytes(bytes))
        }
        AxisKind::Hat => {
            let mut pairs = points.windows(2).zip(factors.windows(2));
            let (ends, values) = pairs.find_map(|(p, f)| {
                let ends = [point(p.first()?), point(p.get(1)?)];
                (ends[0] <= x && x <= ends[1] && ends[0] < ends[1]).then_some((ends, f))
            })?;
            let [left, right] =
                [values.first()?, values.get(1)?].map(|&bytes| f64::from_le_bytes(bytes));
            let share = (x - ends[0]) / (ends[1] - ends[0]);
            Some(left * (1.0 - share) + right * share)
        }
        AxisKind::Chebyshev => barycentric(points, factors, x, point),
        _ => None,
    }
}

/// The polynomial through the points at `x`: `Σ w_j f_j/(x − x_j) / Σ w_j/(x − x_j)` with `w_j = 1/Π_k (x_j − x_k)`, each
/// difference measured in quarters of the range so that the products neither grow nor vanish.
fn barycentric(
    points: &[[u8; 8]],
    factors: &[[u8; 8]],
    x: f64,
    point: impl Fn(&[u8; 8]) -> f64,
) -> Option<f64> {
    let (mut low, mut high) = (f64::MAX, f64::MIN);
    for at in points.iter().map(&point) {
        low = if at < low { at } else { low };
        high = if at > high { at } else { high };
    }
    let quarter = (high - low) / 4.0;
    let (mut above, mut below) = (0.0, 0.0);
    for (j, (bytes, factor)) in points.iter().zip(factors).enumerate() {
        let (at, factor) = (point(bytes), f64::from_le_bytes(*factor));
        if x == at {
            return Some(factor);
        }
        let others = points.iter().enumerate().filter(|&(k, _)| k != j);
        let product = others.fold(1.0, |product, (_, other)| {
            product * ((at - point(other)) / quarter)
        });
        let weight = 1.0 / (product * (x - at));
        above += weight * factor;
        below += weight;
    }
    let value = above / below;
    value.is_finite().then_some(value)
}
