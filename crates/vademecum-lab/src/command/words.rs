//! A row of the table in words.

use vademecum_lab::Row;

/// Modes, terms, and Δt where it is another than the problem's.
pub fn words(row: &Row, time_step: f64) -> String {
    let dt = (row.time_step != time_step).then(|| format!("{} Δt", row.time_step / time_step));
    let words = [row.modes.map(|r| r.to_string()), row.terms.map(|t| format!("{t} terms")), dt];
    words.into_iter().flatten().collect::<Vec<_>>().join(", ")
}
