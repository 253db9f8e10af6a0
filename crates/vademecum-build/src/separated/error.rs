//! What can go wrong when a separated solution is made or looked up.

use thiserror::Error;

/// Errors of axes, separated solutions and their solvers. Not converging is not one of them: see
/// [`StopReason`](super::StopReason).
#[derive(Clone, Debug, PartialEq, Error)]
pub enum SeparatedError {
    /// A value is not within `[lower, upper]` of its axis; nothing is clamped or extrapolated.
    #[error("axis `{axis}`: {value} lies outside [{lower}, {upper}]")]
    OutsideAxis {
        /// Name of the axis.
        axis: String,
        /// The value asked for, in the unit of the axis.
        value: f64,
        /// Lower end of the axis.
        lower: f64,
        /// Upper end of the axis.
        upper: f64,
    },
    /// An index axis was asked for a position between two of its points.
    #[error("axis `{axis}`: {value} is not one of its whole-numbered positions")]
    NotAPosition {
        /// Name of the axis.
        axis: String,
        /// The value asked for.
        value: f64,
    },
    /// The range of an axis is empty, reversed or not finite.
    #[error("axis `{axis}`: the range [{lower}, {upper}] must be finite with lower < upper")]
    BadRange {
        /// Name of the axis.
        axis: String,
        /// Lower end as given.
        lower: f64,
        /// Upper end as given.
        upper: f64,
    },
    /// A logarithmic axis starts at zero or below.
    #[error("axis `{axis}`: a logarithmic axis must start above zero, not at {lower}")]
    LogOfNonPositive {
        /// Name of the axis.
        axis: String,
        /// Lower end as given.
        lower: f64,
    },
    /// A range over more decades than a solution can be told from rounding.
    #[error(
        "axis `{axis}`: the range [{lower:e}, {upper:e}] spans more than twelve decades; narrow the ranges of the live \
         parameters that move it (θ moves with the square of the time step)"
    )]
    TooWide {
        /// The axis.
        axis: String,
        /// Lower end.
        lower: f64,
        /// Upper end.
        upper: f64,
    },
    /// An expansion in polynomials needs Chebyshev points.
    #[error("axis `{axis}` has no Chebyshev points to interpolate at")]
    NotPolynomial {
        /// Name of the axis.
        axis: String,
    },
    /// Fewer than two points on an axis.
    #[error("axis `{axis}`: {points} points are too few, at least 2 are needed")]
    TooFewPoints {
        /// Name of the axis.
        axis: String,
        /// Number of points as given.
        points: usize,
    },
    /// An array has the wrong length or a list the wrong number of entries.
    #[error("{what}: expected {expected}, found {found}")]
    Shape {
        /// Which array or list.
        what: &'static str,
        /// Length it should have.
        expected: usize,
        /// Length it has.
        found: usize,
    },
    /// A space operator that must be positive definite is not.
    #[error("{what} is not positive definite")]
    NotPositiveDefinite {
        /// Which operator.
        what: &'static str,
    },
    /// A decomposition did not converge: the input holds infinities or NaN.
    #[error("{what} did not converge: is every entry finite?")]
    NoConvergence {
        /// Which decomposition.
        what: &'static str,
    },
}

/// Compares a length with the one required.
pub fn check_len(what: &'static str, expected: usize, found: usize) -> Result<(), SeparatedError> {
    if expected == found { Ok(()) } else { Err(SeparatedError::Shape { what, expected, found }) }
}
