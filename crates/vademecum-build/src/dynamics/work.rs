//! Estimate of full-order work, reported before it starts and refused where it would
//! never end.

use std::time::Instant;

use super::full_order::{FullOrder, State};
use crate::progress::Listener;

/// Steps above which work has to be asked for by name: at a tenth of a millisecond each, what a small body
/// takes, more than half an hour.
const MANY_STEPS: f64 = 2e7;
/// Seconds above which it has to be asked for by name: four hours.
const LONG: f64 = 4.0 * 3600.0;
/// Steps no machine marches, asked for or not: at a microsecond each, thirty years.
const ENDLESS: f64 = 1e15;

/// Full-order work ahead.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct Work {
    /// Full-order steps, counted once for each trajectory.
    pub steps: f64,
    /// Estimated wall time of all of them \[s\].
    pub seconds: f64,
}

/// More full-order work than was asked for by name.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{what}: {} full-order steps, about {}{advice}", count_in_words(*.steps), time_in_words(*.seconds))]
pub struct TooMuchWork {
    /// The march that exceeds the limit.
    pub what: String,
    /// Steps.
    pub steps: f64,
    /// Estimated time \[s\].
    pub(crate) seconds: f64,
    /// The remedy.
    pub(crate) advice: &'static str,
}

impl Work {
    /// Both kinds of work, one after the other.
    pub fn and(self, other: Self) -> Self {
        Self { steps: self.steps + other.steps, seconds: self.seconds + other.seconds }
    }

    /// The same work `times` times.
    pub fn times(self, count: f64) -> Self {
        Self { steps: count * self.steps, seconds: count * self.seconds }
    }

    /// In words, for an announcement.
    pub fn in_words(&self) -> String {
        format!("{} full-order steps, about {}", count_in_words(self.steps), time_in_words(self.seconds))
    }

    /// Refuses work that is too long unless it is asked for by name.
    ///
    /// # Errors
    /// [`TooMuchWork`].
    pub fn check(&self, long: bool, what: impl FnOnce() -> String) -> Result<(), TooMuchWork> {
        let refused = |advice| TooMuchWork { what: what(), steps: self.steps, seconds: self.seconds, advice };
        if self.steps.is_nan() || self.steps > ENDLESS {
            return Err(refused(
                ", which no machine does in a lifetime; make `time.step` longer, or `snapshots.duration`, \
                 `tolerance.steps` or the scenario shorter",
            ));
        }
        if long || (self.steps <= MANY_STEPS && self.seconds <= LONG) {
            return Ok(());
        }
        Err(refused(
            "; above 2e7 steps or four hours it has to be asked for with `--long`. Otherwise make `time.step` \
             longer, or `snapshots.duration`, `snapshots.positions`, `tolerance.steps` or the scenario shorter",
        ))
    }
}

/// Wall time of one full-order step of `columns` trajectories marched together \[s\], measured: the second of
/// two steps.
pub fn seconds_per_step(full: &FullOrder<'_>, columns: usize) -> f64 {
    let mut state = State::rest(full.n_dof(), columns);
    let mut work = full.workspace(columns, false);
    let none = Default::default();
    full.step(&mut state, &none, &mut work);
    let start = Instant::now();
    full.step(&mut state, &none, &mut work);
    start.elapsed().as_secs_f64()
}

/// Announces the work of a command that marches `columns` trajectories over `steps` steps, or refuses it.
///
/// # Errors
/// [`TooMuchWork`].
pub fn announce(
    what: &str,
    full: &FullOrder<'_>,
    columns: usize,
    steps: f64,
    long: bool,
    listener: &dyn Listener,
) -> Result<Work, TooMuchWork> {
    let seconds = steps * seconds_per_step(full, columns);
    let work = Work { steps: steps * columns as f64, seconds };
    work.check(long, || what.into())?;
    listener.note(&format!("{what}: {}", work.in_words()));
    Ok(work)
}

fn count_in_words(count: f64) -> String {
    if count < 1e7 { format!("{count:.0}") } else { format!("{count:.1e}") }
}

/// A time as one says it.
pub fn time_in_words(seconds: f64) -> String {
    match seconds {
        s if s < 1.0 => "a second".into(),
        s if s < 120.0 => format!("{s:.0} s"),
        s if s < 2.0 * 3600.0 => format!("{:.0} min", s / 60.0),
        s if s < 48.0 * 3600.0 => format!("{:.1} h", s / 3600.0),
        s if s < 3e9 => format!("{:.0} days", s / 86400.0),
        s => format!("{:.0e} years", s / 3.156e7),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_work_has_to_be_asked_for_and_endless_work_is_refused_either_way() {
        let refused = |work: Work, long| work.check(long, || "it".into()).map_err(|e| e.to_string());
        let short = Work { steps: 1e6, seconds: 60.0 };
        assert_eq!(refused(short, false), Ok(()));
        for long in [Work { steps: 3e7, ..short }, Work { seconds: 20_000.0, ..short }] {
            assert!(refused(long, false).unwrap_err().contains("`--long`"));
            assert_eq!(refused(long, true), Ok(()));
        }
        for endless in [1e16, f64::INFINITY, f64::NAN] {
            let error = refused(Work { steps: endless, ..short }, true).unwrap_err();
            assert!(error.contains("`time.step`"), "{error}");
        }
    }
}
