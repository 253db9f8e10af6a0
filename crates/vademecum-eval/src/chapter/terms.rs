//! Sums of products of one-dimensional functions.

use crate::base::lend::{Lender, Short};
use crate::base::scalar::Scalar;
use vademecum_format::{Chapter, ChapterAxis, ChapterPart, ChapterRole};

/// A part with its factors and terms in the scene's precision.
pub(super) struct Piece<'s, T> {
    pub part: ChapterPart<'s>,
    /// Factors of its axes, one axis after the other, each `(n_points, n_terms)`.
    factors: &'s [T],
    /// `(n_terms, r)`.
    terms: &'s [T],
}

/// Why a sum could not be evaluated.
pub(super) enum Unknown {
    /// This value is not on its axis.
    Outside(ChapterAxis, f64),
    /// The piece has fewer numbers than its part says.
    Short(Short),
}

impl From<Short> for Unknown {
    fn from(short: Short) -> Self {
        Self::Short(short)
    }
}

/// The parts in order, with the factors and terms of all parts in the scene's precision.
pub(super) fn pieces<'s, T>(
    chapter: &Chapter<'s>,
    factors: &'s [T],
    terms: &'s [T],
) -> impl Iterator<Item = Result<Piece<'s, T>, Short>> + use<'s, T> {
    let (mut factors, mut terms) = (Lender::new(factors), Lender::new(terms));
    chapter.parts().map(move |part| {
        let (factors, terms) = (factors.take(part.factors.len())?, terms.take(part.terms.len())?);
        Ok(Piece { part, factors, terms })
    })
}

impl<T: Scalar> Piece<'_, T> {
    /// Adds `Σ_t (Π_a g_ta(x_a)) f_t` to `out`, length r. `value` tells the coordinate of an axis, `weights`
    /// has room for a number per term.
    pub fn add(
        &self,
        value: impl Fn(ChapterRole) -> Result<f64, Short>,
        weights: &mut [T],
        out: &mut [T],
    ) -> Result<(), Unknown> {
        let n = self.part.n_terms;
        let weights = Lender::new(weights).take(n)?;
        weights.fill(T::from_f64(1.0));
        let mut factors = Lender::new(self.factors);
        for axis in self.part.axes() {
            let own = factors.take(axis.points.saturating_mul(n))?;
            let (left, share) = place(&axis, value(axis.role)?)?;
            let mut rows = Lender::new(own);
            rows.take(left.saturating_mul(n))?;
            let left = rows.take(n)?;
            // At the last position there is nothing to the right, and its share is 0.
            let right = rows.take(n).unwrap_or(left);
            let (a, b) = (T::from_f64(1.0 - share), T::from_f64(share));
            for ((weight, &left), &right) in weights.iter_mut().zip(left).zip(right) {
                *weight = *weight * (a * left + b * right);
            }
        }
        for (&weight, term) in weights.iter().zip(self.terms.chunks_exact(out.len().max(1))) {
            out.iter_mut().zip(term).for_each(|(out, &f)| *out += weight * f);
        }
        Ok(())
    }
}

/// The point at or before a value of the history, and how far it is to the next.
pub(super) fn place(axis: &ChapterAxis, value: f64) -> Result<(usize, f64), Unknown> {
    let x = axis.factor * value;
    if !(axis.lower <= x && x <= axis.upper) {
        return Err(Unknown::Outside(*axis, x));
    }
    if axis.role == ChapterRole::Position {
        return Ok((x as usize, 0.0));
    }
    let t = (x - axis.lower) / (axis.upper - axis.lower) * axis.points.saturating_sub(1) as f64;
    let left = (t as usize).min(axis.points.saturating_sub(2));
    Ok((left, t - left as f64))
}
