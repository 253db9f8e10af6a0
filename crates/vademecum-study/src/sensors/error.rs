//! Errors of places of sensors.

/// Reasons why there are no places.
#[derive(Clone, Debug, thiserror::Error)]
pub enum SensorError {
    /// More modes than the file has.
    #[error("{asked} modes are to be told apart; expected 1 to {known}, the modes of the file")]
    Modes {
        /// Number asked for.
        asked: usize,
        /// Modes of the file.
        known: usize,
    },
    /// Too few or too many sensors.
    #[error(
        "{count} sensors for {modes} modes and {candidates} candidates; expected at least as many as modes, and no more \
         than candidates"
    )]
    Count {
        /// Sensors.
        count: usize,
        /// Modes.
        modes: usize,
        /// Candidates.
        candidates: usize,
    },
    /// Modes that look alike along the axes.
    #[error(
        "the modes are not independent along the axes that are measured (ratio of the singular values {condition:.1e}): \
         measure further axes, or tell fewer modes apart"
    )]
    Dependent {
        /// Ratio of the largest and the smallest singular value.
        condition: f64,
    },
}
