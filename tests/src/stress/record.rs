//! Cells as lines of a table.

use std::fmt::Write as _;

use super::{Cell, Expected, Measured, Outcome, Verdict};

/// The table's head.
const HEAD: &str = "| stressed | cell | structure | radius − 1 | energy | error | floor | f32 − f64 | \
    verdict |\n\
                    |---|---|---|---|---|---|---|---|---|\n";

/// One Markdown table of all cells.
#[must_use]
pub fn markdown(ran: &[(Cell, Outcome)]) -> String {
    ran.iter().fold(HEAD.into(), |mut table, (cell, outcome)| {
        let _ = write!(table, "{}", row(cell, outcome));
        table
    })
}

/// The lines of one cell, one per structure.
#[must_use]
pub fn row(cell: &Cell, outcome: &Outcome) -> String {
    let verdict = match (outcome.verdict(), cell.expected) {
        (Verdict::Green, _) => "green".to_owned(),
        (Verdict::Refused(name), _) => format!("refused: {name}"),
        (Verdict::Inaccurate | Verdict::Single, Expected::Limit(name)) => format!("limit: {name}"),
        (Verdict::Single, Expected::Late(name)) => format!("limit: {name}"),
        (Verdict::Inaccurate, _) => "**inaccurate**".to_owned(),
        (Verdict::Single, _) => "**single precision**".to_owned(),
        (Verdict::Red(words), _) => format!("**{words}**"),
    };
    let head = format!("| {} | {} |", cell.group, cell.name);
    match outcome {
        Outcome::Ran(measured) | Outcome::Refused(_, measured) if !measured.is_empty() => {
            measured.iter().map(|m| format!("{head} {} {verdict} |\n", numbers(m))).collect()
        }
        _ => format!("{head} | | | | | | {verdict} |\n"),
    }
}

fn numbers(m: &Measured) -> String {
    let or_blank = |x: f64, text: String| if x.is_nan() { String::new() } else { text };
    let columns = [
        or_blank(m.spectral_radius, format!("{:+.0e}", m.spectral_radius - 1.0)),
        or_blank(m.energy, format!("{:.6}", m.energy)),
        or_blank(m.error, format!("{:.2e}", m.error)),
        or_blank(m.floor, format!("{:.2e}", m.floor)),
        or_blank(m.single, format!("{:.0e}", m.single)),
    ];
    format!("{} | {} |", m.structure, columns.join(" | "))
}
