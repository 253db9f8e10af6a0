//! The two precisions of a factor.

use faer::traits::RealField;

/// A scalar of a factor: double precision, or single precision to save memory.
pub(super) trait FactorScalar: RealField + Copy + Send + Sync {
    /// The nearest one.
    fn nearest(value: f64) -> Self;

    /// `self · factor + term`, rounded once.
    fn fused(self, factor: Self, term: Self) -> Self;
}

impl FactorScalar for f64 {
    #[inline(always)]
    fn fused(self, factor: f64, term: f64) -> f64 {
        self.mul_add(factor, term)
    }

    fn nearest(value: f64) -> f64 {
        value
    }
}

impl FactorScalar for f32 {
    #[inline(always)]
    fn fused(self, factor: f32, term: f32) -> f32 {
        self.mul_add(factor, term)
    }

    fn nearest(value: f64) -> f32 {
        value as f32
    }
}
