//! Result of a comparison: one row per method, number of modes and Δt.

use serde::Serialize;

use super::equal_time::EqualTime;
use super::row::Row;

/// Everything a comparison found.
#[derive(Serialize)]
pub struct BenchTable {
    /// Title of the problem.
    pub title: String,
    /// Free dofs.
    pub dofs: usize,
    /// Steps behind the errors.
    pub steps: usize,
    /// Δt \[s\].
    pub time_step: f64,
    /// Steps in the first natural period.
    pub steps_per_first_period: f64,
    /// Estimate of the relative error of the motion that is exact in time, from which all errors are
    /// measured.
    pub truth_error: f64,
    /// Vectors of the space in which it was found.
    pub truth_vectors: usize,
    /// Steps of one timed burst.
    pub burst: usize,
    /// Rounds in which the methods took turns.
    pub rounds: usize,
    /// Of the clock and the loop, in every reduced step's time \[ns\].
    pub clock_ns_per_step: f64,
    /// Relative distance of the medians of the rounds.
    pub noise: f64,
    /// Distance of each scheme at Δt from the exact motion.
    pub time_scheme_error: Vec<SchemeDistance>,
    /// The chapter's representation against ours, one per canonical row.
    pub equal_time: Vec<EqualTime>,
    /// One per method, number of modes and Δt.
    pub methods: Vec<Row>,
}

/// Error of a time scheme.
#[derive(Serialize)]
pub struct SchemeDistance {
    /// The scheme.
    pub scheme: String,
    /// Δt \[s\].
    pub time_step: f64,
    /// Relative L2 over all dofs and steps, mass norm, loads sampled as files sample them.
    pub error: f64,
    /// The same with loads that jump on an instant taken at the mean of both sides; absent in a quick
    /// comparison.
    pub error_mean_at_jumps: Option<f64>,
}

/// A column of the table for people, with its unit in its name.
pub struct Column<R = Row> {
    /// Its heading, the key of the same figure in JSON.
    pub name: &'static str,
    /// The text of a row in it; empty where it does not apply.
    pub cell: fn(&R) -> String,
}

pub(super) const fn column<R>(name: &'static str, cell: fn(&R) -> String) -> Column<R> {
    Column { name, cell }
}

/// All columns.
pub const COLUMNS: [Column; 20] = [
    column("name", |row: &Row| row.name.to_string()),
    column("modes", |row| whole(row.modes)),
    column("terms", |row| whole(row.terms)),
    column("time_step", |row| format!("{:e}", row.time_step)),
    column("offline_seconds", |row| figures(row.offline_seconds)),
    column("file_bytes", |row| whole(row.file_bytes)),
    column("bind_us", |row| real(row.bind_us)),
    column("step_ns_p50", |row| figures(row.step_ns_p50)),
    column("step_ns_p99", |row| figures(row.step_ns_p99)),
    column("step_ns_max", |row| figures(row.step_ns_max)),
    column("step_spread", |row| format!("{:.3}", row.step_spread)),
    column("times_full_order", |row| figures(row.times_full_order)),
    column("reconstruct_ms", |row| real(row.reconstruct_ms)),
    column("trajectory_error", |row| error(row.errors.trajectory_error)),
    column("projection_floor", |row| error(row.errors.projection_floor)),
    column("error_total", |row| error(row.errors.error_total)),
    column("error_time", |row| part(Some(row.errors.error_time))),
    column("error_space", |row| part(row.errors.error_space)),
    column("error_separation", |row| part(row.errors.error_separation)),
    column("error_rounding", |row| part(row.errors.error_rounding)),
];

pub(super) fn whole(value: Option<usize>) -> String {
    value.map_or(String::new(), |v| v.to_string())
}

fn real(value: Option<f64>) -> String {
    value.map_or(String::new(), figures)
}

pub(super) fn error(value: f64) -> String {
    if value.is_nan() { "-".into() } else { format!("{value:.3e}") }
}

pub(super) fn part(value: Option<f64>) -> String {
    value.map_or(String::new(), |v| format!("{v:.1e}"))
}

/// Three figures, never a power of ten.
pub(super) fn figures(value: f64) -> String {
    let decimals = (2.0 - value.abs().max(1e-9).log10().floor()).clamp(0.0, 9.0) as usize;
    format!("{value:.decimals$}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_figures() {
        assert_eq!([0.01234, 1.234, 123.4, 123_456.0].map(figures), ["0.0123", "1.23", "123", "123456"]);
    }
}
