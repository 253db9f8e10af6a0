//! The check of measured figures before they are printed or stored.
//!
//! A relative error is a quotient. Where nothing moves it is 0/0, and where a number leaves double precision
//! it is infinite or no number. Neither is a measurement, and JSON would show both as `null`.

/// A figure that was to be measured and was not.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "`{figure}` was not measured: it is {value}; either nothing moves, or a number left the range of double precision"
)]
pub struct NotMeasured {
    /// Name of the figure.
    pub figure: &'static str,
    /// Its value.
    pub value: f64,
}

/// Checks that all figures are finite.
///
/// # Errors
/// [`NotMeasured`]: the first that is not.
pub fn measured(figures: &[(&'static str, f64)]) -> Result<(), NotMeasured> {
    let missing = figures.iter().find(|(_, value)| !value.is_finite());
    missing.map_or(Ok(()), |&(figure, value)| Err(NotMeasured { figure, value }))
}

/// Checks that the error of a reference is finite and above 0. No reference is known without error: one of
/// 0 was not measured.
///
/// # Errors
/// [`NotMeasured`].
pub fn reference_measured(figure: &'static str, error: f64) -> Result<(), NotMeasured> {
    let value = error;
    if error.is_finite() && error > 0.0 { Ok(()) } else { Err(NotMeasured { figure, value }) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_without_a_value_are_named() {
        assert_eq!(measured(&[("a", 0.0), ("b", 1e-300)]), Ok(()));
        for value in [f64::INFINITY, f64::NEG_INFINITY] {
            let error = NotMeasured { figure: "b", value };
            assert_eq!(measured(&[("a", 1.0), ("b", value), ("c", f64::NAN)]), Err(error));
        }
        assert!(measured(&[("a", f64::NAN)]).is_err_and(|error| error.figure == "a"));
        assert_eq!(reference_measured("a", 1e-11), Ok(()));
        for value in [0.0, f64::NAN, f64::INFINITY, -1.0] {
            assert!(reference_measured("a", value).is_err());
        }
    }
}
