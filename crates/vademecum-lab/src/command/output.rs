//! The record of a comparison: JSON, CSV and a Markdown table; the pictures are drawn from the same rows.

use std::fmt::Write as _;
use std::path::Path;

use vademecum_build::store::{Kind, Outputs};
use vademecum_lab::{BenchTable, COLUMNS, Column, EqualTime, SchemeDistance, Side};

use super::pareto;
use super::words::words;
use vademecum_cli::Failure;
use vademecum_cli::front::{json, write_bytes};

/// Writes bench.json, bench.csv, bench.md and the pictures.
pub fn write(outputs: &Outputs, folder: &Path, table: &BenchTable) -> Result<(), Failure> {
    let texts = [json(table), csv(&COLUMNS, &table.methods), markdown(table)];
    write_texts(outputs, folder, &texts)?;
    pareto::draw(outputs, folder, table)
}

/// Writes bench.json, bench.csv and bench.md.
pub fn write_texts(outputs: &Outputs, folder: &Path, texts: &[String; 3]) -> Result<(), Failure> {
    let files = FILES.iter().zip(texts);
    files
        .into_iter()
        .try_for_each(|(&(name, kind), text)| write_bytes(outputs, &folder.join(name), kind, text.as_bytes()))
}

/// Files written.
pub const FILES: [(&str, Kind); 5] = [
    ("bench.json", Kind::Json),
    ("bench.csv", Kind::Csv),
    ("bench.md", Kind::Text),
    ("pareto.svg", Kind::Svg),
    ("pareto-total.svg", Kind::Svg),
];

/// One line per method; names hold commas and are quoted.
pub fn csv<R>(columns: &[Column<R>], rows: &[R]) -> String {
    let line = |cells: Vec<String>| cells.join(",") + "\n";
    let of = |row: &R| {
        let mut cells = cells(columns, row);
        cells[0] = format!("\"{}\"", cells[0]);
        line(cells)
    };
    let head = columns.iter().map(|column| column.name.to_string()).collect();
    line(head) + &rows.iter().map(of).collect::<String>()
}

/// The same for people.
pub fn table_of<R>(columns: &[Column<R>], rows: &[R]) -> String {
    let line = |cells: Vec<String>| format!("| {} |\n", cells.join(" | "));
    let head = columns.iter().map(|column| column.name.replace('_', " ")).collect();
    let rule = columns.iter().map(|_| "---".to_string()).collect();
    line(head) + &line(rule) + &rows.iter().map(|row| line(cells(columns, row))).collect::<String>()
}

fn cells<R>(columns: &[Column<R>], row: &R) -> Vec<String> {
    columns.iter().map(|column| (column.cell)(row)).collect()
}

/// The conditions and the table.
pub fn markdown(table: &BenchTable) -> String {
    let mut text = conditions(table) + &table_of(&COLUMNS, &table.methods);
    let notes = table.methods.iter().filter_map(|row| Some((row, row.note.as_ref()?)));
    for (row, note) in notes {
        writeln!(text, "\n`{}` ({}) {note}.", row.name, words(row, table.time_step))
            .expect("writing to a string cannot fail");
    }
    text + &at_equal_time(&table.equal_time)
}

fn conditions(table: &BenchTable) -> String {
    let scheme = |s: &SchemeDistance| {
        let mean = s.error_mean_at_jumps.map_or(String::new(), |e| format!(" ({e:.2e})"));
        format!("{} at {:e} s {:.2e}{mean}", s.scheme, s.time_step, s.error)
    };
    let schemes = table.time_scheme_error.iter().map(scheme);
    format!(
        "{}: {} dofs, {} steps of {} s, {:.1} steps per first period.\n\
         error total is measured from a motion that is exact in time, found among {} vectors; its own error \
         is about {:.0e}.\n\
         Time scheme error against it (in brackets with loads at their mean where they jump): {}.\n\
         Reduced steps timed in bursts of {}, {} rounds by turns; clock and loop {:.2} ns per step, not \
         taken off; medians of the rounds {:.1} % apart.\n{}\n",
        table.title,
        table.dofs,
        table.steps,
        table.time_step,
        table.steps_per_first_period,
        table.truth_vectors,
        table.truth_error,
        schemes.collect::<Vec<_>>().join(", "),
        table.burst,
        table.rounds,
        table.clock_ns_per_step,
        100.0 * table.noise,
        unsteady(table.methods.iter().map(|row| (row.name.to_string(), row.step_spread)))
    )
}

/// Rounds further apart than this share say that something else ran beside them.
const STEADY: f64 = 0.5;

/// A warning that the times are not those of an idle machine; nothing if they are.
fn unsteady(spreads: impl Iterator<Item = (String, f64)>) -> String {
    let worst = spreads.filter(|(_, spread)| *spread > STEADY).max_by(|a, b| a.1.total_cmp(&b.1));
    worst.map_or(String::new(), |(name, spread)| {
        let share = 100.0 * spread;
        format!("warning: the machine was busy: the rounds of `{name}` are {share:.0} % apart, so times and ratios of times \
                 are no measurement. Errors are not affected.\n")
    })
}

/// The chapter's rows against ours in words, one line each; nothing where there is no canonical row.
fn at_equal_time(rows: &[EqualTime]) -> String {
    let mut text = String::new();
    if rows.is_empty() {
        return text;
    }
    text += "\nBlock against canonical at equal time (error of the reduction; a step of one march where the \
        chapter superposes some):\n\n";
    for EqualTime { chapter, marches, ours, ratio } in rows {
        let superposed = if *marches > 1 { format!(", {marches} marches") } else { String::new() };
        let ours = match (ours, ratio) {
            (Some(ours), Some(ratio)) => format!("{}, {ratio:.1} times closer", in_words(ours)),
            (Some(ours), None) => format!("{}; there is no canonical answer", in_words(ours)),
            (None, _) => "none of ours is as fast".into(),
        };
        writeln!(text, "- {}{superposed}. {ours}.", in_words(chapter))
            .expect("writing to a string cannot fail");
    }
    text
}

fn in_words(side: &Side) -> String {
    let terms = side.terms.map_or(String::new(), |t| format!(", {t} terms"));
    let modes = side.modes.map_or(String::new(), |r| format!(", {r} modes"));
    let error = if side.trajectory_error.is_nan() {
        "no answer".into()
    } else {
        format!("{:.2e}", side.trajectory_error)
    };
    format!("`{}`{modes}{terms}: {error} in {:.0} ns", side.name, side.step_ns)
}

#[cfg(test)]
mod tests {
    use super::*;
    use vademecum_build::input::BasisKind;
    use vademecum_lab::{Identity, Precision, Way};

    #[test]
    fn times_of_a_busy_machine_are_warned_of() {
        let rows = |spread| [("a".to_string(), 0.18), ("full order".into(), spread)].into_iter();
        assert_eq!(unsteady(rows(0.4)), "");
        let said = unsteady(rows(31.0));
        assert!(
            said.starts_with("warning: the machine was busy: the rounds of `full order` are 3100 % apart"),
            "{said}"
        );
    }

    #[test]
    fn every_row_of_the_chapter_has_its_line() {
        let side = |basis, way, trajectory_error| Side {
            name: Identity::Reduced { basis, way, precision: Precision::Double },
            modes: Some(8),
            terms: None,
            step_ns: 90.0,
            trajectory_error,
        };
        let chapter = |error| side(BasisKind::Pod, Way::Chapter, error);
        let ours = Some(side(BasisKind::Ritz, Way::Block, 1e-3));
        let rows = [
            EqualTime { chapter: chapter(0.5), marches: 1, ours: ours.clone(), ratio: Some(500.0) },
            EqualTime { chapter: chapter(f64::NAN), marches: 6, ours, ratio: None },
            EqualTime { chapter: chapter(0.5), marches: 1, ours: None, ratio: None },
        ];
        let text = at_equal_time(&rows);
        let lines: Vec<&str> = text.lines().filter(|line| line.starts_with('-')).collect();
        assert!(lines[0].contains("500.0 times closer") && lines[0].contains("`ritz block f64`"), "{text}");
        assert!(lines[1].contains("no answer") && lines[1].contains("6 marches"), "{text}");
        assert!(lines[2].ends_with("none of ours is as fast."), "{text}");
        assert!(at_equal_time(&[]).is_empty());
    }
}
