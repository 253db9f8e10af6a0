//! The chapter's representation against ours at equal time: the best of our rows that steps no slower.
//!
//! Ours are the files on the default basis, whatever their structure and number of modes; of some that are
//! equally close the fastest. Where the chapter superposes marches, a step of one of them is what ours may
//! take: a comparison in its favour.

use serde::Serialize;
use vademecum_build::input::BasisKind;

use super::front::BETTER;
use super::method::{Identity, Way};
use super::row::Row;

/// One canonical row and the row of ours it is held against.
#[derive(Serialize)]
pub struct EqualTime {
    /// The canonical row.
    #[serde(rename = "canonical")]
    pub chapter: Side,
    /// Marches it superposes.
    pub marches: usize,
    /// The closest of our rows that step no slower; absent where none is as fast.
    #[serde(rename = "block")]
    pub ours: Option<Side>,
    /// Its error in that of ours; absent where either has none.
    pub ratio: Option<f64>,
}

/// A row of a comparison at equal time.
#[derive(Clone, Serialize)]
pub struct Side {
    /// The row.
    pub name: Identity,
    /// Number of modes.
    pub modes: Option<usize>,
    /// Number of terms.
    pub terms: Option<usize>,
    /// Time of a step of one march \[ns\].
    pub step_ns: f64,
    /// Error of the reduction; NaN where there is no answer.
    pub trajectory_error: f64,
}

impl Side {
    fn new(row: &Row) -> Self {
        Self {
            name: row.name,
            modes: row.modes,
            terms: row.terms,
            step_ns: row.step_ns_p50 / row.marches as f64,
            trajectory_error: row.errors.trajectory_error,
        }
    }
}

/// All canonical rows at this Δt, each against ours.
pub(super) fn equal_time(rows: &[Row], time_step: f64) -> Vec<EqualTime> {
    let at_this_step = rows.iter().filter(|row| row.time_step == time_step);
    let (chapter, others): (Vec<&Row>, Vec<&Row>) =
        at_this_step.partition(|row| row.name.way().is_some_and(Way::is_chapter));
    let through_a_file = |row: &&Row| row.name.is_on(BasisKind::Ritz) && row.file_bytes.is_some();
    let ours: Vec<Side> = others.into_iter().filter(through_a_file).map(Side::new).collect();
    chapter.into_iter().map(|row| against(Side::new(row), row.marches, &ours)).collect()
}

fn against(chapter: Side, marches: usize, ours: &[Side]) -> EqualTime {
    let not_slower = || ours.iter().filter(|side| side.step_ns <= chapter.step_ns);
    let least = not_slower().map(|side| side.trajectory_error).fold(f64::INFINITY, f64::min);
    let closest = not_slower().filter(|side| BETTER * side.trajectory_error <= least);
    let ours = closest.min_by(|a, b| a.step_ns.total_cmp(&b.step_ns)).cloned();
    let ratio = ours.as_ref().map(|ours| chapter.trajectory_error / ours.trajectory_error);
    EqualTime { chapter, marches, ours, ratio: ratio.filter(|ratio| ratio.is_finite()) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use vademecum_build::dynamics::SchemeKind;

    fn side(step_ns: f64, trajectory_error: f64) -> Side {
        let name = Identity::FullOrder(SchemeKind::Bathe {});
        Side { name, modes: Some(8), terms: None, step_ns, trajectory_error }
    }

    #[test]
    fn the_closest_row_that_is_not_slower_counts() {
        let ours = [side(10.0, 1e-2), side(95.0, 0.9999e-3), side(90.0, 1e-3), side(101.0, 1e-6)];
        let found = against(side(100.0, 0.5), 1, &ours);
        assert_eq!(found.ours.map(|ours| ours.step_ns), Some(90.0), "as close as the one of 95, and faster");
        assert_eq!(found.ratio, Some(500.0));
    }

    #[test]
    fn a_march_that_ended_has_no_ratio_and_a_fast_one_no_rival() {
        let ours = [side(10.0, 1e-2)];
        let ended = against(side(100.0, f64::NAN), 6, &ours);
        assert!(ended.ours.is_some() && ended.ratio.is_none());
        let fast = against(side(9.0, 0.5), 1, &ours);
        assert!(fast.ours.is_none() && fast.ratio.is_none());
    }
}
