//! When a load acts.

/// When a load acts: from `start` (inclusive) to `end` (exclusive), rising linearly over the first `ramp`
/// seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// First instant \[s\].
    pub start: f64,
    /// First instant without the load \[s\].
    pub end: f64,
    /// Time to full force \[s\].
    pub ramp: f64,
}

impl Interval {
    /// Factor on the load at time `t`.
    ///
    /// Instants come from `n Δt + c Δt` and carry rounding; one part in 1e9 of the time decides ties, so that
    /// a load that ends at `100 Δt` acts in step 99 and not in step 100 whatever the rounding.
    pub fn factor(&self, t: f64) -> f64 {
        let t = t * (1.0 + 1e-9);
        if t < self.start || t >= self.end {
            return 0.0;
        }
        if self.ramp > 0.0 { ((t - self.start) / self.ramp).min(1.0) } else { 1.0 }
    }

    /// The factor at `t`, on the side of jumps and kinks where `side` lies.
    pub(super) fn beside(&self, t: f64, side: f64) -> f64 {
        if side < self.start || side >= self.end {
            return 0.0;
        }
        if side >= self.start + self.ramp { 1.0 } else { ((t - self.start) / self.ramp).clamp(0.0, 1.0) }
    }

    /// Instants at which the factor jumps or has a kink; between them it is linear in time.
    pub(super) fn breaks(&self) -> [f64; 3] {
        [self.start, self.start + self.ramp, self.end]
    }

    /// True if `t` is inside of a piece of time and not at one of its ends.
    pub(super) fn is_inside(t: f64, [start, end]: [f64; 2]) -> bool {
        start * (1.0 + TIE) < t && t < end * (1.0 - TIE)
    }
}

/// Instants come from products and carry rounding: this part of a time decides ties.
pub(super) const TIE: f64 = 1e-9;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_load_acts_from_start_to_just_before_its_end() {
        let when = Interval { start: 0.1, end: 0.3, ramp: 0.0 };
        assert_eq!(when.factor(0.1), 1.0);
        assert_eq!(when.factor(100.0 * 0.001), 1.0);
        assert_eq!(when.factor(0.3), 0.0);
        assert_eq!(when.factor(3.0 * 0.1 - 1e-16), 0.0);
        assert_eq!(when.factor(0.0999), 0.0);
    }

    #[test]
    fn a_ramp_rises_linearly_and_stays() {
        let when = Interval { start: 0.0, end: 10.0, ramp: 2.0 };
        assert!((when.factor(1.0) - 0.5).abs() < 1e-8);
        assert_eq!(when.factor(5.0), 1.0);
    }
}
