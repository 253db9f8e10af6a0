//! For how many steps a tolerance is good, from the one march of a certificate.
//!
//! Over `m` steps the certificate sums squares: `S` of the displacement, `F` of what no coordinates could
//! mend, `Z` of the error of the coordinates, so that floor² = F/S and error² = (F + Z)/S. A drift of phase
//! in a motion that keeps its amplitude makes the error of the coordinates grow with the steps, so `Z` with
//! their cube. `F` may stand still, since a scheme damps the high modes, of which the floor is made, while
//! `S` goes on with the steps. With both at their worst, `s` times as many steps have the floor `f/√s` and
//! beyond it `b s`.
//!
//! Note: the motion drifts freely only after its release, so `Z` grows a little faster than the
//! cube; a tenth of the steps is taken off for that, which is enough where the release lies in the first
//! tenth of the march (docs/measurements/parameters.md).

/// Share of the estimate that is given.
const AFTER_RELEASE: f64 = 0.9;

/// A march that was measured, and what is allowed: error ≤ `floor_ratio` × floor + `absolute`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Measured {
    pub(crate) steps: f64,
    pub(crate) error: f64,
    pub(crate) floor: f64,
    pub(crate) floor_ratio: f64,
    pub(crate) absolute: f64,
}

impl Measured {
    /// Steps for which the trajectory keeps the tolerance by that estimate: 0 where it missed it already,
    /// infinite where nothing was seen beyond the floor, else at least the steps marched.
    pub(crate) fn good_for_steps(&self) -> f64 {
        if self.error.is_nan() || self.floor.is_nan() {
            return f64::NAN;
        }
        if self.error > self.floor_ratio * self.floor + self.absolute {
            return 0.0;
        }
        if self.drift_squared() == 0.0 {
            return f64::INFINITY;
        }
        let (mut keeps, mut misses) = (1.0, 2.0);
        while self.keeps(misses) {
            (keeps, misses) = (misses, 2.0 * misses);
        }
        // Halving a factor of two as often as a number has bits.
        for _ in 0..f64::MANTISSA_DIGITS {
            let middle = f64::midpoint(keeps, misses);
            *(if self.keeps(middle) { &mut keeps } else { &mut misses }) = middle;
        }
        (AFTER_RELEASE * self.steps * keeps).max(self.steps)
    }

    /// `b²`: the two parts of the error are orthogonal.
    fn drift_squared(&self) -> f64 {
        (self.error * self.error - self.floor * self.floor).max(0.0)
    }

    /// Whether `s` times the steps keep the tolerance. In `√s` the difference of the sides times `s` changes
    /// the sign of its coefficients once, so it has one positive root (Descartes): kept before, missed after.
    fn keeps(&self, s: f64) -> bool {
        let floor = self.floor / s.sqrt();
        let allowed = self.floor_ratio * floor + self.absolute;
        floor * floor + self.drift_squared() * s * s <= allowed * allowed
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MARCH: Measured =
        Measured { steps: 100.0, error: 5.0, floor: 4.0, floor_ratio: 2.0, absolute: 0.0 };

    #[test]
    fn the_steps_follow_from_the_error_beyond_the_floor() {
        // 3-4-5: beyond the floor of 4 the error of 5 is 3; √(2² − 1) × 4/√s is reached by 3 s at s³ = 48/9.
        let expected = 0.9 * 100.0 * (48.0_f64 / 9.0).cbrt();
        assert!((MARCH.good_for_steps() / expected - 1.0).abs() < 1e-12);
        // Without a floor only the drift counts: 5 s reaches 20 at s = 4.
        let drift = Measured { floor: 0.0, absolute: 20.0, ..MARCH };
        assert!((drift.good_for_steps() / 360.0 - 1.0).abs() < 1e-12);
    }

    #[test]
    fn nothing_is_promised_below_the_march_nor_where_nothing_is_known() {
        assert_eq!(Measured { floor_ratio: 1.25, ..MARCH }.good_for_steps(), 100.0, "just kept");
        assert_eq!(Measured { floor_ratio: 1.2, ..MARCH }.good_for_steps(), 0.0, "missed already");
        assert_eq!(Measured { error: 4.0, ..MARCH }.good_for_steps(), f64::INFINITY);
        assert!(Measured { error: f64::NAN, ..MARCH }.good_for_steps().is_nan());
    }
}
