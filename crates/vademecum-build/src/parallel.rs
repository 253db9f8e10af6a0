//! Loops that threads share. Results are in the order of the indices, for any number of threads.
//!
//! Each parallel iterator of rayon compiles the splitting of its range anew, some 20 kB of code. Here all
//! loops share one. It calls tasks through a pointer, and an item or a result lies behind a lock: loops over
//! cheap rows hand over chunks of them.

use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;

/// Calls `task` with each index below `count`. Not generic: one instantiation of rayon's splitting instead of
/// one per loop.
pub fn for_each(count: usize, task: &(dyn Fn(usize) + Sync)) {
    (0..count).into_par_iter().for_each(task);
}

/// Calls `task` with each item and its index. Generic in the items alone, around [`for_each`].
pub fn for_each_of<T: Send>(items: impl IntoIterator<Item = T>, task: &(dyn Fn(usize, T) + Sync)) {
    let items = Slots::of(items);
    for_each(items.0.len(), &|at| task(at, items.take(at)));
}

/// Results of `task` for each index below `count`. Generic in the results alone, around [`for_each`].
pub fn map<T: Send>(count: usize, task: &(dyn Fn(usize) -> T + Sync)) -> Vec<T> {
    let found = Slots((0..count).map(|_| Mutex::new(None)).collect());
    for_each(count, &|at| found.put(at, task(at)));
    found.all()
}

/// Results of `task` for each item and its index.
pub fn map_of<T: Send, U: Send>(
    items: impl IntoIterator<Item = T>,
    task: &(dyn Fn(usize, T) -> U + Sync),
) -> Vec<U> {
    let items = Slots::of(items);
    map(items.0.len(), &|at| task(at, items.take(at)))
}

/// The same as [`map`] for tasks that may fail. No task starts behind one that failed.
///
/// # Errors
/// That of the first index that has one.
pub fn try_map<T: Send, E: Send>(
    count: usize,
    task: &(dyn Fn(usize) -> Result<T, E> + Sync),
) -> Result<Vec<T>, E> {
    let first_failed = AtomicUsize::new(usize::MAX);
    let one = |at: usize| {
        let wanted = at < first_failed.load(Ordering::Relaxed);
        wanted.then(|| task(at).inspect_err(|_| _ = first_failed.fetch_min(at, Ordering::Relaxed)))
    };
    map(count, &one).into_iter().flatten().collect()
}

/// A place for each index, filled and emptied by one task at most.
struct Slots<T>(Vec<Mutex<Option<T>>>);

impl<T> Slots<T> {
    fn of(items: impl IntoIterator<Item = T>) -> Self {
        Self(items.into_iter().map(|item| Mutex::new(Some(item))).collect())
    }

    fn take(&self, at: usize) -> T {
        self.0[at].lock().ok().and_then(|mut slot| slot.take()).expect("each index once")
    }

    fn put(&self, at: usize, found: T) {
        *self.0[at].lock().expect("nothing panics under the lock") = Some(found);
    }

    fn all(self) -> Vec<T> {
        self.0.into_iter().map(|slot| slot.into_inner().ok().flatten().expect("each index once")).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_are_in_the_order_of_the_indices() {
        let squares: Vec<usize> = (0..1000).map(|at| at * at).collect();
        assert_eq!(map(1000, &|at| at * at), squares);
        assert_eq!(map_of(0..1000, &|at, item: usize| at * item), squares);
        let mut written = vec![0; 1000];
        for_each_of(&mut written, &|at, place| *place = at * at);
        assert_eq!(written, squares);
    }

    #[test]
    fn the_first_error_is_returned() {
        let odd = |at: usize| if at < 500 || at.is_multiple_of(2) { Ok(at) } else { Err(at) };
        for _ in 0..100 {
            assert_eq!(try_map(1000, &odd), Err(501));
        }
        assert_eq!(try_map(500, &odd), Ok((0..500).collect()));
    }
}
