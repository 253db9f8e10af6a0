//! Places on a logarithmic scale, for colours.

/// From the least value above zero to the largest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LogScale {
    /// The least value above zero; half of the largest where all are the same.
    pub low: f64,
    /// The largest value.
    pub high: f64,
}

impl LogScale {
    /// The scale of some values; `None` if none is above zero.
    pub fn of(values: &[f64]) -> Option<Self> {
        let above = values.iter().copied().filter(|&value| value > 0.0);
        let (low, high) = above.fold((f64::MAX, 0.0), |(low, high): (f64, f64), x| (low.min(x), high.max(x)));
        let low = if high < 1.01 * low { 0.5 * high } else { low };
        (high > 0.0).then_some(Self { low, high })
    }

    /// Position of a value, 0 at the low end (and below) to 1 at the high one.
    pub fn place(&self, value: f64) -> f64 {
        ((value.max(self.low) / self.low).ln() / (self.high / self.low).ln()).clamp(0.0, 1.0)
    }

    /// The value in the middle, the geometric mean of the ends.
    pub fn middle(&self) -> f64 {
        (self.low * self.high).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_follow_the_logarithm_from_the_least_to_the_largest() {
        let scale = LogScale::of(&[0.0, 1e-3, 1e-1, 1e-2]).expect("some above zero");
        let places = [0.0, 1e-3, 1e-2, 1e-1].map(|value| scale.place(value));
        for (found, expected) in places.into_iter().zip([0.0, 0.0, 0.5, 1.0]) {
            assert!((found - expected).abs() < 1e-12, "{places:?}");
        }
        assert!((scale.middle() - 1e-2).abs() < 1e-15);
        assert_eq!(LogScale::of(&[0.3, 0.3]).map(|scale| scale.place(0.3)), Some(1.0));
        assert_eq!(LogScale::of(&[0.0]), None);
    }
}
