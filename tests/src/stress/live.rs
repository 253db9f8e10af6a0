//! Live parameters set before every step, beside a full-order march whose matrices change as often.

use std::f64::consts::TAU;

use vademecum_build::dynamics::INSTANTS;
use vademecum_build::input::Problem;
use vademecum_build::prepared::{LiveParameter, ParameterSpace};

use super::drive::compare;
use super::reference::Story;
use super::{Form, Outcome};

/// Every parameter swings over its whole range in 7, 12, 17, … steps, while the pattern is held.
pub fn fast(problem: &Problem, form: Form) -> Outcome {
    swept(problem, form, 7.0)
}

/// The same in 400, 685, 971, … steps.
pub fn slow(problem: &Problem, form: Form) -> Outcome {
    swept(problem, form, 400.0)
}

fn swept(problem: &Problem, form: Form, steps: f64) -> Outcome {
    compare(problem, form.pick(400, 4000), |prepared| Sweep { space: prepared.space.clone(), steps })
}

struct Sweep {
    space: ParameterSpace,
    /// Steps in which the first parameter swings there and back.
    steps: f64,
}

impl Story for Sweep {
    fn amplitude(&self, _: usize, _: [f64; INSTANTS]) -> [f64; INSTANTS] {
        [1.0; INSTANTS]
    }

    fn parameters(&self, n: usize) -> Vec<f64> {
        let value = |(i, p): (usize, &LiveParameter)| {
            // No two alike.
            let period = self.steps * (1.0 + 5.0 / 7.0 * i as f64);
            let share = 0.5 - 0.5 * (TAU * n as f64 / period).cos();
            let value = if p.log {
                p.lower * (p.upper / p.lower).powf(share)
            } else {
                p.lower + share * (p.upper - p.lower)
            };
            value.clamp(p.lower, p.upper)
        };
        self.space.parameters.iter().enumerate().map(value).collect()
    }
}
