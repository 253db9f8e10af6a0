//! The checkpoints of a search for modes: what its solves gave, each found again by what was solved for.

use std::cell::{Cell, RefCell};
use std::time::Duration;

use faer::{Mat, MatRef};
use serde::{Deserialize, Serialize};

use super::folder::{CachedStage, Store};
use super::inputs::Inputs;
use crate::progress::Listener;

/// Solves that took less than this are not worth a file.
const WORTH: Duration = Duration::from_secs(1);

/// The name of a kept solve among the stages.
const NAME: &str = "solve";

/// Kept solves of one search. A search is deterministic, so one that begins anew asks for the same solves as
/// before it was stopped, and goes on behind the last one that is here.
pub struct CachedSolves<'a> {
    store: Option<(&'a Store, Inputs)>,
    listener: &'a dyn Listener,
    worth: Duration,
    /// Addresses of those that were found or written.
    own: RefCell<Vec<u128>>,
    /// Number of solves found that an earlier run wrote.
    found: Cell<usize>,
    /// True after the note that one cannot be written.
    told: Cell<bool>,
}

#[derive(Serialize, Deserialize)]
struct CachedSolution(#[serde(with = "crate::linalg::stored")] Mat<f64>);

impl<'a> CachedSolves<'a> {
    /// Of a model, whose address is begun; without a store nothing is kept.
    pub(crate) fn new(store: Option<(&'a Store, Inputs)>, listener: &'a dyn Listener) -> Self {
        let (own, found, told) = Default::default();
        Self { store, listener, worth: WORTH, own, found, told }
    }

    /// The address of a solve, by the rows of the right-hand sides that this process has.
    pub(crate) fn address(&self, forces: MatRef<'_, f64>) -> u128 {
        self.store.as_ref().map_or(0, |(_, model)| model.clone().matrix(forces).address())
    }

    /// Cached solution, all rows; none if it is missing or damaged.
    pub(crate) fn find(&self, address: u128) -> Option<Mat<f64>> {
        let (store, _) = self.store.as_ref()?;
        let CachedStage::Whole(CachedSolution(answers)) = store.read(NAME, address) else { return None };
        if !self.own.borrow().contains(&address) {
            if self.found.replace(self.found.get() + 1) == 0 {
                self.listener.note("the search for natural modes goes on where it was stopped");
            }
            self.own.borrow_mut().push(address);
        }
        Some(answers)
    }

    /// True if a solve that took so long is to be kept.
    pub(crate) fn keeps(&self, took: Duration) -> bool {
        self.store.is_some() && took >= self.worth
    }

    /// Keeps what a solve gave, all rows. What cannot be written is solved for again, with one note.
    pub(crate) fn keep(&self, address: u128, answers: Mat<f64>) {
        let Some((store, _)) = &self.store else { return };
        match store.write(NAME, address, &CachedSolution(answers)) {
            Ok(()) => self.own.borrow_mut().push(address),
            Err(error) if !self.told.replace(true) => self.listener.note(&format!(
                "a solve of the search for natural modes cannot be kept in {}: {error}; where the build is stopped, \
                 the search does this solve again",
                store.folder().display()
            )),
            Err(_) => {}
        }
    }

    /// True if the user wants the search to stop.
    pub(crate) fn cancelled(&self) -> bool {
        self.listener.cancelled()
    }

    /// Removes them all, once what was searched for is kept itself.
    pub(crate) fn forget(&self) {
        if let Some((store, _)) = &self.store {
            self.own.take().into_iter().for_each(|address| store.forget(NAME, address));
        }
    }
}

#[cfg(test)]
impl<'a> CachedSolves<'a> {
    /// Of all solves, however short, in a folder.
    pub(crate) fn of_all(store: &'a Store, listener: &'a dyn Listener) -> Self {
        Self { worth: Duration::ZERO, ..Self::new(Some((store, Inputs::none())), listener) }
    }

    /// Number of solves found that an earlier run wrote.
    pub(crate) fn found(&self) -> usize {
        self.found.get()
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Mutex;

    use super::*;

    /// Keeps what is said.
    #[derive(Default)]
    struct Notes(Mutex<Vec<String>>);

    impl Listener for Notes {
        fn stage(&self, _: &str) {}
        fn advance(&self, _: usize, _: usize) {}
        fn note(&self, text: &str) {
            self.0.lock().unwrap().push(text.into());
        }
    }

    #[test]
    fn that_solves_cannot_be_kept_is_told_once() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("a file");
        std::fs::write(&file, b"").unwrap();
        let (store, said) = (Store::new(&file.join("work"), false), Notes::default());
        let solves = CachedSolves::of_all(&store, &said);
        (0..3).for_each(|address| solves.keep(address, Mat::zeros(2, 1)));
        assert!(solves.find(0).is_none());
        let said = said.0.into_inner().unwrap();
        assert!(said.len() == 1 && said[0].contains("cannot be kept in"), "{said:?}");
    }
}
