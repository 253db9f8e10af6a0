//! Figures of some samples.

/// Median, 99th percentile, largest.
///
/// # Panics
/// If there are no samples.
pub fn percentiles(mut samples: Vec<f64>) -> [f64; 3] {
    samples.sort_by(f64::total_cmp);
    let at = |fraction: f64| samples[(fraction * (samples.len() - 1) as f64).round() as usize];
    [at(0.5), at(0.99), at(1.0)]
}

/// The middle of some samples.
///
/// # Panics
/// If there are no samples.
pub fn median(samples: Vec<f64>) -> f64 {
    percentiles(samples)[0]
}
