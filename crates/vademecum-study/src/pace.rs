//! Estimated duration of a march, from its first steps.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use vademecum_build::dynamics::time_in_words;
use vademecum_build::progress::Listener;

/// A march that takes longer than this is announced \[s\].
const LONG: f64 = 60.0;
/// Duration of the measurement.
const MEASURED: Duration = Duration::from_millis(500);

/// Passes everything on, and announces a long march once its pace is known.
pub(crate) struct Pace<'a> {
    listener: &'a dyn Listener,
    time_step: f64,
    start: Instant,
    known: AtomicBool,
}

impl<'a> Pace<'a> {
    /// A march by steps of `time_step` starts now.
    pub(crate) fn new(time_step: f64, listener: &'a dyn Listener) -> Self {
        Self { listener, time_step, start: Instant::now(), known: AtomicBool::new(false) }
    }
}

impl Listener for Pace<'_> {
    fn stage(&self, name: &str) {
        self.listener.stage(name);
    }

    fn advance(&self, done: usize, total: usize) {
        self.listener.advance(done, total);
        if self.known.load(Ordering::Relaxed) {
            return;
        }
        let elapsed = self.start.elapsed();
        if done == 0 || elapsed < MEASURED {
            return;
        }
        self.known.store(true, Ordering::Relaxed);
        let seconds = elapsed.as_secs_f64() * total as f64 / done as f64;
        if seconds > LONG {
            self.listener.note(&announcement(total, self.time_step, seconds));
        }
    }

    fn note(&self, text: &str) {
        self.listener.note(text);
    }

    fn cancelled(&self) -> bool {
        self.listener.cancelled()
    }
}

/// Note on a long march.
fn announcement(steps: usize, time_step: f64, seconds: f64) -> String {
    let about = time_in_words(seconds);
    format!("{steps} steps of {time_step} s take about {about} at the pace of the first ones")
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Mutex;

    #[derive(Default)]
    struct Notes(Mutex<Vec<String>>);

    impl Listener for Notes {
        fn stage(&self, _: &str) {}
        fn advance(&self, _: usize, _: usize) {}
        fn note(&self, text: &str) {
            self.0.lock().expect("one thread").push(text.into());
        }
    }

    #[test]
    fn a_long_march_is_announced_once_and_a_short_one_never() {
        let notes = Notes::default();
        let started = Instant::now().checked_sub(Duration::from_secs(1)).expect("a clock");
        let mut pace = Pace::new(1e-3, &notes);
        pace.start = started;
        pace.advance(1000, 36_000_000);
        pace.advance(2000, 36_000_000);
        let said = notes.0.lock().expect("one thread").clone();
        assert_eq!(said, ["36000000 steps of 0.001 s take about 10.0 h at the pace of the first ones"]);
        let mut pace = Pace::new(1e-3, &notes);
        pace.start = started;
        pace.advance(1000, 2000);
        assert_eq!(notes.0.lock().expect("one thread").len(), 1);
    }
}
