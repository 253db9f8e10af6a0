//! The two precisions of a factor.

use faer::traits::RealField;

/// A number of a factor: double precision, or single precision where memory asks for it.
pub(super) trait Number: RealField + Copy + Send + Sync {
    /// The nearest one.
    fn nearest(value: f64) -> Self;
}

impl Number for f64 {
    fn nearest(value: f64) -> f64 {
        value
    }
}

impl Number for f32 {
    fn nearest(value: f64) -> f32 {
        value as f32
    }
}
