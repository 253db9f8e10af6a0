//! Progress and cancellation of long work.

use std::time::Instant;

/// The build was asked to stop.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("stopped on request")]
pub struct Cancelled;

/// Hears how far long work is.
///
/// All methods may be called often and must return at once.
pub trait Listener: Sync {
    /// A stage starts.
    fn stage(&self, name: &str);
    /// `done` of `total` pieces of the stage are finished.
    fn advance(&self, done: usize, total: usize);
    /// Something the user should read.
    fn note(&self, text: &str);
    /// Asked between pieces of work; `true` ends the work with [`Cancelled`].
    fn cancelled(&self) -> bool {
        false
    }

    /// [`Listener::advance`], then an error if the listener wants to stop.
    fn checkpoint(&self, done: usize, total: usize) -> Result<(), Cancelled> {
        self.advance(done, total);
        if self.cancelled() { Err(Cancelled) } else { Ok(()) }
    }
}

/// True if an error goes back to the user's wish to stop.
pub fn is_cancelled(error: &(dyn std::error::Error + 'static)) -> bool {
    let mut next = Some(error);
    while let Some(error) = next {
        if error.is::<Cancelled>() {
            return true;
        }
        next = error.source();
    }
    false
}

/// A listener that ignores everything.
#[derive(Clone, Copy, Debug, Default)]
pub struct Silent;

impl Listener for Silent {
    fn stage(&self, _: &str) {}
    fn advance(&self, _: usize, _: usize) {}
    fn note(&self, _: &str) {}
}

/// Passes notes and cancellation on and keeps progress to itself: for work that runs side by side.
pub struct Quiet<'a>(pub &'a dyn Listener);

impl Listener for Quiet<'_> {
    fn stage(&self, _: &str) {}
    fn advance(&self, _: usize, _: usize) {}
    fn note(&self, text: &str) {
        self.0.note(text);
    }
    fn cancelled(&self) -> bool {
        self.0.cancelled()
    }
}

/// Wall time and memory of one finished stage.
#[derive(Clone, Debug, serde::Serialize)]
pub struct StageTiming {
    /// The stage.
    pub stage: String,
    /// Wall time \[s\].
    pub seconds: f64,
    /// Largest resident memory of the process so far \[bytes\]; absent where the system does not tell.
    pub peak_memory_bytes: Option<u64>,
}

/// Times the stages of a build, in order.
pub struct Stopwatch<'a> {
    listener: &'a dyn Listener,
    timings: Vec<StageTiming>,
}

impl<'a> Stopwatch<'a> {
    /// Nothing timed yet.
    pub fn new(listener: &'a dyn Listener) -> Self {
        Self { listener, timings: vec![] }
    }

    /// Runs and times one stage.
    pub fn stage<T>(&mut self, name: &str, work: impl FnOnce() -> T) -> T {
        self.listener.stage(name);
        let start = Instant::now();
        let result = work();
        let seconds = start.elapsed().as_secs_f64();
        self.timings.push(StageTiming { stage: name.into(), seconds, peak_memory_bytes: peak_memory() });
        result
    }

    /// The timings so far.
    pub(crate) fn timings(&self) -> Vec<StageTiming> {
        self.timings.clone()
    }
}

/// Largest resident memory of this process \[bytes\], where the system tells (Linux).
fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kilobytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kilobytes * 1024)
}
