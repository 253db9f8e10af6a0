//! The record of a comparison: JSON, CSV, a Markdown table, and the picture of time against error.

use std::fmt::Write as _;
use std::path::Path;

use serde::Serialize;
use vademecum_build::dynamics::SchemeKind;
use vademecum_build::march::TrajectoryError;

use super::candidates::{Group, Method};
use super::measure::{Samples, median, percentiles};
use crate::cmd::write_text;
use crate::failure::{Cause, Failure};
use crate::pictures::{Chart, Cloud, scatter};

/// Everything a comparison found.
#[derive(Serialize)]
pub struct Report {
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
    /// Steps of one timed burst.
    pub burst: usize,
    /// Rounds in which the methods took turns.
    pub rounds: usize,
    /// Of the clock and the loop, in every reduced step's time \[ns\].
    pub clock_ns_per_step: f64,
    /// Relative distance of the medians of the rounds.
    pub noise: f64,
    /// Distance of each scheme at Δt from the problem's scheme at a quarter of it.
    pub time_scheme_error: Vec<SchemeError>,
    /// One per method and number of modes.
    pub methods: Vec<Row>,
}

/// What a time scheme costs in accuracy.
#[derive(Serialize)]
pub struct SchemeError {
    /// The scheme.
    pub scheme: String,
    /// Relative L2 over all dofs and steps, mass norm.
    pub error: f64,
}

/// One method with one number of modes.
#[derive(Serialize)]
pub struct Row {
    name: String,
    modes: Option<usize>,
    offline_seconds: f64,
    file_bytes: Option<usize>,
    bind_us: Option<f64>,
    step_ns_p50: f64,
    step_ns_p99: f64,
    step_ns_max: f64,
    reconstruct_ms: Option<f64>,
    trajectory_error: f64,
    projection_floor: f64,
}

impl Row {
    /// A full-order march: its space holds everything, so its floor is 0.
    pub fn full_order(scheme: &SchemeKind, offline_seconds: f64, step_ns: [f64; 3], error: f64) -> Self {
        Self {
            name: format!("full order, {scheme}"),
            modes: None,
            offline_seconds,
            file_bytes: None,
            bind_us: None,
            step_ns_p50: step_ns[0],
            step_ns_p99: step_ns[1],
            step_ns_max: step_ns[2],
            reconstruct_ms: None,
            trajectory_error: error,
            projection_floor: 0.0,
        }
    }

    /// A reduced method.
    pub fn reduced(group: &Group, method: &Method, samples: &Samples, error: &TrajectoryError) -> Self {
        let step_ns = percentiles(samples.step_ns.concat());
        Self {
            name: method.name.into(),
            modes: Some(group.basis.n_modes()),
            offline_seconds: method.offline_seconds,
            file_bytes: method.bytes().map(<[u8]>::len),
            bind_us: (!samples.bind_us.is_empty()).then(|| median(samples.bind_us.clone())),
            step_ns_p50: step_ns[0],
            step_ns_p99: step_ns[1],
            step_ns_max: step_ns[2],
            reconstruct_ms: Some(median(samples.reconstruct_ms.clone())),
            trajectory_error: error.error,
            projection_floor: error.floor,
        }
    }

    /// All columns as text, in the order of [`COLUMNS`]; what does not apply is empty.
    fn cells(&self) -> [String; 11] {
        let whole = |value: Option<usize>| value.map_or(String::new(), |v| v.to_string());
        let real = |value: Option<f64>| value.map_or(String::new(), figures);
        [
            self.name.clone(),
            whole(self.modes),
            figures(self.offline_seconds),
            whole(self.file_bytes),
            real(self.bind_us),
            figures(self.step_ns_p50),
            figures(self.step_ns_p99),
            figures(self.step_ns_max),
            real(self.reconstruct_ms),
            format!("{:.3e}", self.trajectory_error),
            format!("{:.3e}", self.projection_floor),
        ]
    }
}

/// Headings, with units in the names.
const COLUMNS: [&str; 11] = [
    "name",
    "modes",
    "offline_seconds",
    "file_bytes",
    "bind_us",
    "step_ns_p50",
    "step_ns_p99",
    "step_ns_max",
    "reconstruct_ms",
    "trajectory_error",
    "projection_floor",
];

/// Three figures, never a power of ten.
fn figures(value: f64) -> String {
    let decimals = (2.0 - value.abs().max(1e-9).log10().floor()).clamp(0.0, 9.0) as usize;
    format!("{value:.decimals$}")
}

impl Report {
    /// Writes bench.json, bench.csv, bench.md and pareto.svg.
    pub fn write(&self, folder: &Path) -> Result<(), Failure> {
        let json = serde_json::to_string_pretty(self).expect("a report has string keys and finite nesting");
        write_text(&folder.join("bench.json"), &json)?;
        write_text(&folder.join("bench.csv"), &self.csv())?;
        write_text(&folder.join("bench.md"), &self.markdown())?;
        self.draw(&folder.join("pareto.svg"))
    }

    /// One line per method; names hold commas and are quoted.
    fn csv(&self) -> String {
        let mut text = COLUMNS.join(",") + "\n";
        for row in &self.methods {
            let [name, rest @ ..] = row.cells();
            writeln!(text, "\"{name}\",{}", rest.join(",")).expect("writing to a string cannot fail");
        }
        text
    }

    /// The conditions and the table.
    pub fn markdown(&self) -> String {
        let schemes = self.time_scheme_error.iter().map(|s| format!("{} {:.2e}", s.scheme, s.error));
        let mut text = format!(
            "{}: {} dofs, {} steps of {} s, {:.1} steps per first period.\n\
             Time scheme error (against Δt/4): {}.\n\
             Reduced steps timed in bursts of {}, {} rounds by turns; clock and loop {:.2} ns per step, not taken off; \
             medians of the rounds {:.1} % apart.\n\n",
            self.title,
            self.dofs,
            self.steps,
            self.time_step,
            self.steps_per_first_period,
            schemes.collect::<Vec<_>>().join(", "),
            self.burst,
            self.rounds,
            self.clock_ns_per_step,
            100.0 * self.noise
        );
        let mut line = |cells: &[String]| {
            writeln!(text, "| {} |", cells.join(" | ")).expect("writing to a string cannot fail");
        };
        line(&COLUMNS.map(|c| c.replace('_', " ")));
        line(&COLUMNS.map(|_| "---".to_string()));
        self.methods.iter().for_each(|row| line(&row.cells()));
        text
    }

    /// Median time of a step against error. The reference march has no error and stands in the title.
    fn draw(&self, path: &Path) -> Result<(), Failure> {
        let mut clouds: Vec<Cloud<'_>> = vec![];
        for row in self.methods.iter().filter(|row| row.trajectory_error > 0.0) {
            let word = row.modes.map_or(String::new(), |r| r.to_string());
            let point = (row.step_ns_p50, row.trajectory_error, word);
            match clouds.iter_mut().find(|cloud| cloud.name == row.name) {
                Some(cloud) => cloud.points.push(point),
                None => clouds.push(Cloud { name: &row.name, points: vec![point] }),
            }
        }
        let reference = self.methods.first().map_or(f64::NAN, |row| row.step_ns_p50 / 1e6);
        let title =
            format!("time against error, numbers of modes beside the points (full order: {reference:.2} ms)");
        let chart = Chart {
            title: &title,
            x: "median time of a step [ns]",
            y: "relative trajectory error",
            log_y: true,
        };
        let failed = |error: Box<dyn std::error::Error>| Failure::new(Cause::Machine, error.to_string());
        scatter(path, &chart, &clouds, &front(&clouds)).map_err(failed)
    }
}

/// Points are on the front if no faster one comes within this factor of their error: digits that differ behind the second
/// figure are no reason to step slower.
const BETTER: f64 = 0.99;

/// The points no other point beats in both time and error, fastest first.
fn front(clouds: &[Cloud<'_>]) -> Vec<(f64, f64)> {
    let mut points: Vec<(f64, f64)> =
        clouds.iter().flat_map(|c| c.points.iter().map(|p| (p.0, p.1))).collect();
    points.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let mut least = f64::INFINITY;
    points.retain(|p| {
        let better = p.1 < BETTER * least;
        least = least.min(p.1);
        better
    });
    points
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_front_falls() {
        let points = [(3.0, 0.5), (1.0, 0.9), (2.0, 1.0), (4.0, 0.6), (5.0, 0.1), (6.0, 0.0999)];
        let cloud = |p: &[(f64, f64)]| p.iter().map(|&(x, y)| (x, y, String::new())).collect();
        let clouds = [
            Cloud { name: "a", points: cloud(&points[..2]) },
            Cloud { name: "b", points: cloud(&points[2..]) },
        ];
        assert_eq!(front(&clouds), [(1.0, 0.9), (3.0, 0.5), (5.0, 0.1)]);
    }

    #[test]
    fn three_figures() {
        assert_eq!([0.01234, 1.234, 123.4, 123_456.0].map(figures), ["0.0123", "1.23", "123", "123456"]);
    }
}
