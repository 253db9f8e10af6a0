//! Check of the time step: how many steps its first natural period has.
//!
//! Fewer than about ten, and the scheme distorts the motion that matters most; more than a thousand, and the
//! march costs what it does not give back. Both are said with a number to write instead. Where nothing useful
//! can come of it, the step is refused.

use vademecum_format::scheme::SchemeTable;

use super::Prepared;
use super::proposed::STEPS_PER_PERIOD;
use crate::dynamics::numerical_damping;
use crate::progress::Listener;

/// Steps per first period between which nothing is said.
const USEFUL: (f64, f64) = (10.0, 1000.0);
/// Steps per first period between which a build is worth trying: two points a period are the least that show
/// a swing, and in a millionth of a period a state moves by so little that a hundredth of its digits are
/// left.
const HOPEFUL: (f64, f64) = (2.0, 1e6);

/// A time step that does not fit the body.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TimeStepError {
    /// So long that the first mode does not swing.
    #[error(
        "`time.step` is {step:e} s and the first natural period {period:.3e} s: with {steps:.2} steps a period the body \
         cannot swing; write a shorter step, for instance {suggested:e}, or check units and materials"
    )]
    TooLong {
        /// Δt \[s\].
        step: f64,
        /// First natural period \[s\].
        period: f64,
        /// Steps per period.
        steps: f64,
        /// The suggested value \[s\].
        suggested: f64,
    },
    /// So short that a step changes nothing.
    #[error(
        "`time.step` is {step:e} s and the first natural period {period:.3e} s: {steps:.1e} steps a period lose the motion \
         in rounding and take for ever; write a longer step, for instance {suggested:e}, or check units and materials"
    )]
    TooShort {
        /// Δt \[s\].
        step: f64,
        /// First natural period \[s\].
        period: f64,
        /// Steps per period.
        steps: f64,
        /// The suggested value \[s\].
        suggested: f64,
    },
}

/// `period / 40`, two digits.
fn suggestion(period: f64) -> f64 {
    let step = period / STEPS_PER_PERIOD;
    format!("{step:.1e}").parse().unwrap_or(step)
}

impl Prepared {
    /// Holds the step against the first natural period \[s\]: refuses it where it is hopeless, and otherwise
    /// says what it costs or distorts while that can still be changed.
    ///
    /// # Errors
    /// [`TimeStepError`].
    pub fn check_time_step(&self, period: f64, listener: &dyn Listener) -> Result<(), TimeStepError> {
        let step = self.step.time_step;
        let (steps, suggested) = (period / step, suggestion(period));
        if steps.is_nan() || steps < HOPEFUL.0 {
            return Err(TimeStepError::TooLong { step, period, steps, suggested });
        }
        if steps > HOPEFUL.1 {
            return Err(TimeStepError::TooShort { step, period, steps, suggested });
        }
        // Exact steps distort nothing; they only show the motion at few instants.
        if steps < USEFUL.0 && !self.exact {
            listener.note(&format!(
                "only {steps:.1} steps per first period: the scheme distorts even the first mode; a shorter `time.step`, \
                 for instance {suggested:e}, follows it"
            ));
        }
        if steps > USEFUL.1 {
            listener.note(&format!(
                "{steps:.0} steps per first period, more than a motion of that period needs: a longer `time.step`, for \
                 instance {suggested:e}, is built and marched in a fraction of the time"
            ));
        }
        self.note_numerical_damping(period, suggested, listener);
        Ok(())
    }

    /// A dissipative scheme at few steps per period eats energy. What matters is the loss over a second; over
    /// a period where that is longer.
    fn note_numerical_damping(&self, period: f64, suggested: f64, listener: &dyn Listener) {
        let dt = self.step.time_step;
        let (span, name) = if period < 1.0 { (1.0, "second") } else { (period, "period") };
        let lost = loss(self.file_scheme(), std::f64::consts::TAU * dt / period, span / dt);
        if lost > 0.05 {
            let shorter = match dt > suggested {
                true => format!("a shorter `time.step`, for instance {suggested:e}, "),
                false => "a shorter `time.step`, ".into(),
            };
            listener.note(&format!(
                "{:.1} steps per first period: the scheme itself takes {:.0} % of the first mode's amplitude each {name}; \
                 {shorter}Newmark or generalized-alpha keeps it",
                period / dt,
                100.0 * lost
            ));
        }
    }
}

/// Share of an oscillator's amplitude that a scheme takes in a number of steps at `Ω = ωΔt`; zero where it
/// cannot be distinguished from rounding, one where the oscillator does not swing any more.
///
/// The eigenvalues of a step are `1 ± iΩ + O(Ω²)`: a pair so close to each other is known to `ε/Ω` and no
/// better, so a decay per step below that is rounding, and over many steps it would look like anything.
fn loss(scheme: &SchemeTable, omega_dt: f64, steps: f64) -> f64 {
    const ROUNDING: f64 = 64.0 * f64::EPSILON;
    // So close together the pair shows as two real eigenvalues, which is rounding too.
    if omega_dt * omega_dt < ROUNDING {
        return 0.0;
    }
    let Some(ratio) = numerical_damping(scheme, omega_dt, 0.0).ratio else { return 1.0 };
    let decay = ratio * omega_dt;
    if decay <= ROUNDING / omega_dt { 0.0 } else { -(-decay * steps).exp_m1() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dynamics::schemes::{bathe, newmark};

    #[test]
    fn the_loss_of_a_tiny_step_is_nothing_and_not_everything() {
        let trapezoidal = newmark(0.25, 0.5).unwrap();
        for exponent in 2..13 {
            let omega_dt = 10f64.powi(-exponent);
            let second = 1.0 / omega_dt;
            assert_eq!(loss(&trapezoidal, omega_dt, second), 0.0, "conserves energy, {omega_dt}");
            // Bathe loses ever less the shorter the step; its ratio is of third order in Ω.
            assert!(loss(&bathe(), omega_dt, second) < omega_dt.powi(2), "{omega_dt}");
        }
        // With two steps a period little is left after ten of them.
        assert!(loss(&bathe(), std::f64::consts::PI, 20.0) > 0.9);
        assert_eq!(loss(&bathe(), 1e300, 1.0), 1.0);
    }

    #[test]
    fn a_suggestion_has_two_digits() {
        assert_eq!(suggestion(1.0), 0.025);
        assert_eq!(suggestion(0.123), 0.0031);
    }
}
