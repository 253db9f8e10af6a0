//! The chapter's representation against ours at equal time: the best of our rows that steps no slower.
//!
//! Ours are the files on the default basis, whatever their structure and number of modes; of some that are equally close the fastest. Where the chapter superposes marches, a
//! step of one of them is what ours may take: a comparison in its favour.

use std::fmt::Write as _;

use serde::Serialize;

use super::canonical::is_canonical;
use super::output::Row;
use super::pareto::BETTER;

/// One canonical row and the row of ours it is held against.
#[derive(Serialize)]
pub struct EqualTime {
    /// The canonical row.
    canonical: Side,
    /// Marches it superposes.
    marches: usize,
    /// The closest of our rows that step no slower; absent where none is as fast.
    block: Option<Side>,
    /// Its error in that of ours; absent where either has none.
    ratio: Option<f64>,
}

/// What is held against what.
#[derive(Clone, Serialize)]
struct Side {
    name: String,
    modes: Option<usize>,
    terms: Option<usize>,
    /// Of one march.
    step_ns: f64,
    trajectory_error: f64,
}

impl Side {
    fn new(row: &Row) -> Self {
        Self {
            name: row.name.clone(),
            modes: row.modes,
            terms: row.terms,
            step_ns: row.step_ns_p50 / row.marches as f64,
            trajectory_error: row.errors.trajectory_error,
        }
    }

    fn words(&self) -> String {
        let terms = self.terms.map_or(String::new(), |t| format!(", {t} terms"));
        let modes = self.modes.map_or(String::new(), |r| format!(", {r} modes"));
        let error = if self.trajectory_error.is_nan() {
            "no answer".into()
        } else {
            format!("{:.2e}", self.trajectory_error)
        };
        format!("`{}`{modes}{terms}: {error} in {:.0} ns", self.name, self.step_ns)
    }
}

/// All canonical rows at this Δt, each against ours.
pub fn equal_time(rows: &[Row], time_step: f64) -> Vec<EqualTime> {
    let at_this_step = || rows.iter().filter(|row| row.time_step == time_step);
    let (canonical, others): (Vec<&Row>, Vec<&Row>) = at_this_step().partition(|row| is_canonical(&row.name));
    let ours: Vec<Side> = others
        .into_iter()
        .filter(|row| row.name.starts_with("ritz ") && row.file_bytes.is_some())
        .map(Side::new)
        .collect();
    canonical.into_iter().map(|row| against(Side::new(row), row.marches, &ours)).collect()
}

fn against(canonical: Side, marches: usize, ours: &[Side]) -> EqualTime {
    let not_slower = || ours.iter().filter(|side| side.step_ns <= canonical.step_ns);
    let least = not_slower().map(|side| side.trajectory_error).fold(f64::INFINITY, f64::min);
    let closest = not_slower().filter(|side| BETTER * side.trajectory_error <= least);
    let block = closest.min_by(|a, b| a.step_ns.total_cmp(&b.step_ns)).cloned();
    let ratio = block.as_ref().map(|block| canonical.trajectory_error / block.trajectory_error);
    EqualTime { canonical, marches, block, ratio: ratio.filter(|ratio| ratio.is_finite()) }
}

/// The comparison in words, one line each; nothing where there is no canonical row.
pub fn markdown(rows: &[EqualTime]) -> String {
    let mut text = String::new();
    if rows.is_empty() {
        return text;
    }
    text += "\nBlock against canonical at equal time (error of the reduction; a step of one march where the chapter superposes some):\n\n";
    for EqualTime { canonical, marches, block, ratio } in rows {
        let superposed = if *marches > 1 { format!(", {marches} marches") } else { String::new() };
        let ours = match (block, ratio) {
            (Some(block), Some(ratio)) => format!("{}, {ratio:.1} times closer", block.words()),
            (Some(block), None) => format!("{}; there is no canonical answer", block.words()),
            (None, _) => "none of ours is as fast".into(),
        };
        writeln!(text, "- {}{superposed}. {ours}.", canonical.words())
            .expect("writing to a string cannot fail");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    fn side(step_ns: f64, trajectory_error: f64) -> Side {
        Side { name: "a row".into(), modes: Some(8), terms: None, step_ns, trajectory_error }
    }

    #[test]
    fn the_closest_row_that_is_not_slower_counts() {
        let ours = [side(10.0, 1e-2), side(95.0, 0.9999e-3), side(90.0, 1e-3), side(101.0, 1e-6)];
        let found = against(side(100.0, 0.5), 1, &ours);
        assert_eq!(
            found.block.map(|block| block.step_ns),
            Some(90.0),
            "as close as the one of 95, and faster"
        );
        assert_eq!(found.ratio, Some(500.0));
    }

    #[test]
    fn a_march_that_ended_has_no_ratio_and_a_fast_one_no_rival() {
        let ours = [side(10.0, 1e-2)];
        let ended = against(side(100.0, f64::NAN), 6, &ours);
        assert!(ended.block.is_some() && ended.ratio.is_none());
        let fast = against(side(9.0, 0.5), 1, &ours);
        assert!(fast.block.is_none() && fast.ratio.is_none());
        assert_eq!(markdown(&[ended, fast]).lines().filter(|line| line.starts_with('-')).count(), 2);
    }
}
