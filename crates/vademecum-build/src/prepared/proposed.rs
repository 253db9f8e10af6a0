//! Which time step a body should have, by its first natural period.

/// Steps per first period that are suggested: the schemes' period errors are below a percent there.
pub const STEPS_PER_PERIOD: f64 = 40.0;

/// A step for a body of this first natural period \[s\]: the largest of 1, 2 and 5 times a power of ten that
/// takes at least 40 steps to the period.
pub fn proposed_time_step(first_period: f64) -> f64 {
    let step = first_period / STEPS_PER_PERIOD;
    let power = step.log10().floor();
    let round = [5, 2, 1].map(|digit| format!("{digit}e{power}"));
    let mut parsed = round.iter().filter_map(|text| text.parse::<f64>().ok());
    parsed.find(|&round| round <= step).unwrap_or(step)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_proposed_step_is_round_and_takes_forty_steps_or_more() {
        assert_eq!(proposed_time_step(1.0), 0.02);
        assert_eq!(proposed_time_step(0.0399), 5e-4);
        for period in [1e-9, 3.7e-5, 0.04, 0.0401, 8.0, 1e6] {
            let steps = period / proposed_time_step(period);
            assert!((40.0 * (1.0 - 1e-15)..100.1).contains(&steps), "{period}: {steps}");
        }
    }
}
