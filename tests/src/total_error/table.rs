//! The record of a body as Markdown.

use std::fmt::Write;

use super::bodies::RealBody;
use super::measure::{Conditions, Row, Sample};
use super::push::HISTORIES;

/// Median, 95th percentile and largest, each one of the values (nearest rank).
///
/// # Panics
/// If there are none.
#[must_use]
pub fn quantiles(mut values: Vec<f64>) -> [f64; 3] {
    values.sort_by(f64::total_cmp);
    [0.5, 0.95, 1.0].map(|share| values[(share * values.len() as f64).ceil().max(1.0) as usize - 1])
}

/// Title, conditions and the two tables of a body.
#[must_use]
pub fn markdown(body: &RealBody, conditions: &Conditions, rows: &[Row]) -> String {
    let Conditions { dofs, period, pushes } = conditions;
    let mut out = format!(
        "## {}\n\n{}.\n\n{dofs} dofs, T1 = {period:.4e} s, {pushes} pushes; the reference has at most {} vectors \
         for a push.\n\n",
        body.name, body.what, body.vectors
    );
    out += "| damping | modes | load | error: modes alone | residual at the contact | whole static fields | \
            reference | under the force: modes alone | with the static part |\n|---|---|---|---|---|---|---|---|---|\n";
    for row in rows {
        let of = |value: &dyn Fn(&Sample) -> f64| three(row.samples.iter().map(value).collect());
        let [alone, local, whole] = [0, 1, 2].map(|k| of(&|s| s.error[k]));
        let reference = quantiles(row.samples.iter().map(|s| s.reference).collect())[2];
        let [under, with] = [0, 1].map(|k| of(&|s| s.contact[k]));
        let _ = writeln!(
            out,
            "| {} | {alone} | {local} | {whole} | {reference:.0e} | {under} | {with} |",
            name(row)
        );
    }
    out += "\n| damping | modes | load | bound ÷ error, least of all instants: least | median | largest | bound ÷ \
            total error: median | instants above |\n|---|---|---|---|---|---|---|---|\n";
    for row in rows {
        let tight: Vec<f64> = row.samples.iter().map(|s| s.bound).collect();
        let least = tight.iter().copied().fold(f64::INFINITY, f64::min);
        let [median, _, largest] = quantiles(tight);
        let of_total = quantiles(row.samples.iter().map(|s| s.bound_of_total).collect())[0];
        let above: usize = row.samples.iter().map(|s| s.above).sum();
        let _ = writeln!(
            out,
            "| {} | {least:.3} | {median:.2} | {largest:.2} | {of_total:.2} | {above} |",
            name(row)
        );
    }
    out + "\n"
}

fn name(row: &Row) -> String {
    let damping = if row.ratio > 0.0 { format!("{} %", 100.0 * row.ratio) } else { "none".into() };
    format!("{damping} | {} | {}", row.modes, HISTORIES[row.history].name)
}

fn three(values: Vec<f64>) -> String {
    quantiles(values).map(|value| format!("{value:.1e}")).join(" / ")
}
