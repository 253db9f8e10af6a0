//! Long work beside Python: progress is reported, other threads run, and Ctrl-C ends it.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use vademecum_build::progress::Listener;

use crate::refusal::Refusal;
use crate::threads::{STACK, with_threads};

/// Longest wait of progress messages and Python's signals.
const PATIENCE: Duration = Duration::from_millis(50);

/// Messages of the work since the last call.
#[derive(Default)]
struct News {
    stages: Vec<String>,
    advanced: Option<(usize, usize)>,
    notes: Vec<String>,
}

/// Keeps what the work says until Python asks.
#[derive(Default)]
struct Ear {
    news: Mutex<News>,
    cancelled: AtomicBool,
}

impl Ear {
    fn hear(&self, change: impl FnOnce(&mut News)) {
        change(&mut self.news.lock().unwrap_or_else(PoisonError::into_inner));
    }

    fn take(&self) -> News {
        std::mem::take(&mut *self.news.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

impl Listener for Ear {
    fn stage(&self, name: &str) {
        self.hear(|news| {
            news.stages.push(name.to_string());
            news.advanced = None;
        });
    }

    fn advance(&self, done: usize, total: usize) {
        self.hear(|news| news.advanced = Some((done, total)));
    }

    fn note(&self, text: &str) {
        self.hear(|news| news.notes.push(text.to_string()));
    }

    fn cancelled(&self) -> bool {
        self.cancelled.load(Ordering::Relaxed)
    }
}

/// Receivers of progress messages in Python.
#[derive(Clone, Copy)]
pub struct Told<'a, 'py> {
    /// The caller's `progress(stage, done, total)`.
    pub progress: Option<&'a Bound<'py, PyAny>>,
    /// True if notes are warnings; they are logged in any case.
    pub warn: bool,
}

/// Tells Python what is new.
struct Teller<'a, 'py> {
    py: Python<'py>,
    told: Told<'a, 'py>,
    stage: String,
}

impl Teller<'_, '_> {
    fn tell(&mut self, news: News) -> PyResult<()> {
        for note in news.notes {
            self.py.import("vademecum._errors")?.getattr("note")?.call1((note, self.told.warn))?;
        }
        let Some(progress) = self.told.progress else { return Ok(()) };
        for stage in news.stages {
            self.stage = stage;
            progress.call1((&self.stage, 0, 0))?;
        }
        if let Some((done, total)) = news.advanced {
            progress.call1((&self.stage, done, total))?;
        }
        Ok(())
    }
}

/// Does `work` in a thread of its own. Progress is reported to the function of the caller in the caller's
/// thread. An exception of that function, and Ctrl-C, end the work.
pub fn watched<R: Send>(
    py: Python<'_>,
    told: Told<'_, '_>,
    work: impl FnOnce(&dyn Listener) -> Result<R, Refusal> + Send,
) -> PyResult<R> {
    let ear = Ear::default();
    let mut teller = Teller { py, told, stage: String::new() };
    std::thread::scope(|scope| {
        let (say, mut done) = channel();
        let heard = &ear;
        let task = move || {
            let result = with_threads(|| work(heard));
            // Whoever waits for it waits until it is here.
            let _ = say.send(());
            result
        };
        let worker = std::thread::Builder::new().name("vademecum".into()).stack_size(STACK);
        let worker = worker.spawn_scoped(scope, task)?;
        let mut interrupted = None;
        loop {
            // A receiver belongs to one thread at a time, which a unique reference says.
            let waited = py.detach(|| {
                let done = &mut done;
                done.recv_timeout(PATIENCE)
            });
            let over = waited != Err(RecvTimeoutError::Timeout);
            if interrupted.is_none() {
                let told = teller.tell(ear.take()).and_then(|()| py.check_signals());
                if let Err(error) = told {
                    ear.cancelled.store(true, Ordering::Relaxed);
                    interrupted = Some(error);
                }
            }
            if over {
                break;
            }
        }
        let result = py.detach(|| worker.join());
        match (interrupted, result) {
            (Some(error), _) => Err(error),
            (None, Ok(result)) => Ok(result?),
            (None, Err(_)) => Err(PyRuntimeError::new_err(
                "the work ended by a fault of the program; standard error says where",
            )),
        }
    })
}
