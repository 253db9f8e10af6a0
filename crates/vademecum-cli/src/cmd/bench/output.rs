//! The record of a comparison: JSON, CSV and a Markdown table; the pictures are drawn from the same rows.

use std::fmt::Write as _;
use std::path::Path;

use serde::Serialize;

use super::candidates::{Group, Method};
use super::equal_time::{self, EqualTime};
use super::errors::Errors;
use super::measure::{Samples, median, percentiles};
use super::pareto;
use crate::cmd::write_text;
use crate::failure::Failure;

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
    /// Steps of the fine march in one step.
    pub split: usize,
    /// Steps of one timed burst.
    pub burst: usize,
    /// Rounds in which the methods took turns.
    pub rounds: usize,
    /// Of the clock and the loop, in every reduced step's time \[ns\].
    pub clock_ns_per_step: f64,
    /// Relative distance of the medians of the rounds.
    pub noise: f64,
    /// Distance of each scheme at Δt from the fine march.
    pub time_scheme_error: Vec<SchemeError>,
    /// The chapter's representation against ours, one per canonical row.
    pub equal_time: Vec<EqualTime>,
    /// One per method, number of modes and Δt.
    pub methods: Vec<Row>,
}

/// What a time scheme costs in accuracy.
#[derive(Serialize)]
pub struct SchemeError {
    /// The scheme.
    pub scheme: String,
    /// Δt \[s\].
    pub time_step: f64,
    /// Relative L2 over all dofs and steps, mass norm, loads sampled as files sample them.
    pub error: f64,
    /// The same with loads that jump on an instant taken at the mean of both sides; absent with `--quick`.
    pub error_mean_at_jumps: Option<f64>,
}

/// One method with one number of modes at one Δt.
#[derive(Serialize)]
pub struct Row {
    pub name: String,
    pub modes: Option<usize>,
    pub terms: Option<usize>,
    pub time_step: f64,
    offline_seconds: f64,
    pub file_bytes: Option<usize>,
    bind_us: Option<f64>,
    pub step_ns_p50: f64,
    step_ns_p99: f64,
    step_ns_max: f64,
    step_spread: f64,
    times_full_order: f64,
    reconstruct_ms: Option<f64>,
    #[serde(flatten)]
    pub errors: Errors,
    /// Marches from rest whose sum is the answer; a step is one of each.
    pub marches: usize,
    /// Why there is no answer.
    note: Option<String>,
    /// Steps of its own in one of the problem's.
    #[serde(skip)]
    pub steps_per_step: f64,
}

/// What the rows of one Δt share.
pub struct At<'a> {
    /// Δt \[s\].
    pub time_step: f64,
    /// Steps in one of the problem's.
    pub steps_per_step: f64,
    /// Of the full-order solver with the problem's scheme and Δt.
    pub full_order: &'a Samples,
}

impl Row {
    fn new(at: &At<'_>, name: String, samples: &Samples, errors: Errors, offline_seconds: f64) -> Self {
        let [step_ns_p50, step_ns_p99, step_ns_max] = percentiles(samples.step_ns.concat());
        Self {
            name,
            modes: None,
            terms: None,
            time_step: at.time_step,
            offline_seconds,
            file_bytes: None,
            bind_us: None,
            step_ns_p50,
            step_ns_p99,
            step_ns_max,
            step_spread: samples.spread(),
            times_full_order: samples.times_faster_than(at.full_order),
            reconstruct_ms: None,
            errors,
            marches: 1,
            note: None,
            steps_per_step: at.steps_per_step,
        }
    }

    /// A full-order march.
    pub fn full_order(
        at: &At<'_>,
        scheme: &str,
        offline_seconds: f64,
        samples: &Samples,
        errors: Errors,
    ) -> Self {
        Self::new(at, format!("full order, {scheme}"), samples, errors, offline_seconds)
    }

    /// A reduced method; `note` says why it has no answer.
    pub fn reduced(
        at: &At<'_>,
        group: &Group,
        method: &Method,
        samples: &Samples,
        errors: Errors,
        note: Option<String>,
    ) -> Self {
        Self {
            marches: method.n_marches(),
            note,
            modes: Some(group.basis.n_modes()),
            terms: method.terms,
            file_bytes: method.file_bytes(),
            bind_us: (!samples.bind_us.is_empty()).then(|| median(samples.bind_us.clone())),
            reconstruct_ms: Some(median(samples.reconstruct_ms.clone())),
            ..Self::new(at, method.name.into(), samples, errors, method.offline_seconds)
        }
    }

    /// All columns as text, in the order of [`COLUMNS`]; what does not apply is empty.
    fn cells(&self) -> [String; COLUMNS.len()] {
        let whole = |value: Option<usize>| value.map_or(String::new(), |v| v.to_string());
        let real = |value: Option<f64>| value.map_or(String::new(), figures);
        let error = |value: f64| if value.is_nan() { "-".into() } else { format!("{value:.3e}") };
        let part = |value: Option<f64>| value.map_or(String::new(), |v| format!("{v:.1e}"));
        let e = &self.errors;
        [
            self.name.clone(),
            whole(self.modes),
            whole(self.terms),
            format!("{:e}", self.time_step),
            figures(self.offline_seconds),
            whole(self.file_bytes),
            real(self.bind_us),
            figures(self.step_ns_p50),
            figures(self.step_ns_p99),
            figures(self.step_ns_max),
            format!("{:.3}", self.step_spread),
            figures(self.times_full_order),
            real(self.reconstruct_ms),
            error(e.trajectory_error),
            error(e.projection_floor),
            error(e.error_total),
            part(Some(e.error_time)),
            part(e.error_space),
            part(e.error_separation),
            part(e.error_rounding),
        ]
    }
}

/// Headings, with units in the names.
const COLUMNS: [&str; 20] = [
    "name",
    "modes",
    "terms",
    "time_step",
    "offline_seconds",
    "file_bytes",
    "bind_us",
    "step_ns_p50",
    "step_ns_p99",
    "step_ns_max",
    "step_spread",
    "times_full_order",
    "reconstruct_ms",
    "trajectory_error",
    "projection_floor",
    "error_total",
    "error_time",
    "error_space",
    "error_separation",
    "error_rounding",
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
        pareto::draw(folder, self)
    }

    /// Distance of the fine march from the most natural modes, each moved exactly: what is left of its own time error, and the
    /// modes not taken.
    fn exact_motion(&self) -> Option<f64> {
        let exact = |row: &&Row| row.name == EXACT;
        self.methods.iter().filter(exact).max_by_key(|row| row.modes).map(|row| row.errors.error_total)
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
        let scheme = |s: &SchemeError| {
            let mean = s.error_mean_at_jumps.map_or(String::new(), |e| format!(" ({e:.2e})"));
            format!("{} at {:e} s {:.2e}{mean}", s.scheme, s.time_step, s.error)
        };
        let schemes = self.time_scheme_error.iter().map(scheme);
        let mut text = format!(
            "{}: {} dofs, {} steps of {} s, {:.1} steps per first period.\n\
             Time scheme error against Δt/{} (in brackets with loads at their mean where they jump): {}.\n\
             The fine march itself is {} from the exact motion of the most natural modes.\n\
             Reduced steps timed in bursts of {}, {} rounds by turns; clock and loop {:.2} ns per step, not taken off; \
             medians of the rounds {:.1} % apart.\n\n",
            self.title,
            self.dofs,
            self.steps,
            self.time_step,
            self.steps_per_first_period,
            self.split,
            schemes.collect::<Vec<_>>().join(", "),
            self.exact_motion().map_or("-".into(), |e| format!("{e:.1e}")),
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
        let notes = self.methods.iter().filter_map(|row| Some((row, row.note.as_ref()?)));
        for (row, note) in notes {
            writeln!(text, "\n`{}` ({}) {note}.", row.name, row.words(self.time_step))
                .expect("writing to a string cannot fail");
        }
        text + &equal_time::markdown(&self.equal_time)
    }
}

/// Modal truncation without a time scheme.
pub const EXACT: &str = "natural modes, exact f64";

impl Row {
    /// Modes, terms, and Δt where it is another than the problem's.
    pub fn words(&self, time_step: f64) -> String {
        let dt = (self.time_step != time_step).then(|| format!("{} Δt", self.time_step / time_step));
        let words = [self.modes.map(|r| r.to_string()), self.terms.map(|t| format!("{t} terms")), dt];
        words.into_iter().flatten().collect::<Vec<_>>().join(", ")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_figures() {
        assert_eq!([0.01234, 1.234, 123.4, 123_456.0].map(figures), ["0.0123", "1.23", "123", "123456"]);
    }
}
