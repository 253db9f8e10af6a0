//! Threads of a process that was forked.
//!
//! A forked child has one thread, the one that forked, and waits for ever for those of its parent. So such a
//! process computes with threads of its own.

use std::process::id;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::refusal::Refusal;

/// Stack of a thread \[bytes\]: as much as the program has on most systems.
pub const STACK: usize = 8 << 20;

/// The process that loaded the module. It uses the threads that all of Rust's libraries share.
static LOADED_BY: OnceLock<u32> = OnceLock::new();

/// Threads of a forked process, and its number.
static OWN: Mutex<Option<(u32, Arc<ThreadPool>)>> = Mutex::new(None);

/// Notes which process loads the module.
pub fn note_process() {
    LOADED_BY.get_or_init(id);
}

/// Does `work` where there are threads to share it with.
pub fn with_threads<R: Send>(work: impl FnOnce() -> Result<R, Refusal> + Send) -> Result<R, Refusal> {
    if LOADED_BY.get() == Some(&id()) { work() } else { own_threads()?.install(work) }
}

/// The threads of this process.
fn own_threads() -> Result<Arc<ThreadPool>, Refusal> {
    let mut own = OWN.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some((_, pool)) = own.as_ref().filter(|(process, _)| *process == id()) {
        return Ok(Arc::clone(pool));
    }
    let made = ThreadPoolBuilder::new().stack_size(STACK).build();
    let made = Arc::new(made.map_err(|error| Refusal::machine(error.to_string()))?);
    // Those of a parent that was forked itself are not there to be ended.
    std::mem::forget(own.replace((id(), Arc::clone(&made))));
    Ok(made)
}
