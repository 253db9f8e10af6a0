//! A long build that was stopped goes on where it was: its finished stages are kept and found again by what
//! they were computed from.
//!
//! Each stage has an address, a hash of everything it reads: numbers of the model, the basis before it, the
//! keys of the problem file that it looks at. A result is used again only under the very same address, so a
//! changed input rebuilds the stages that depend on it and no others, and a build gives the same bytes with
//! and without what is kept. Note: addresses go by content and not by history, so a change that
//! leaves a basis as it was leaves all that follows from it too.
//!
//! Here too is the one place where files are opened for writing ([`Outputs`]), for stages and for results.
//!
//! The store knows no stage: each value says itself what it contributes to an address ([`StageInput`]). Cheap
//! stages (mesh, matrices, factorisations, stage responses) are not kept.

mod disk;
mod folder;
mod growing;
mod inputs;
mod kind;
mod part;
mod read;
mod solves;

pub use disk::{OutputError, Outputs, goes_through, is_same_place, write_atomic};
pub use folder::Store;
pub use growing::GrowingFile;
pub use inputs::{Inputs, StageInput};
pub use kind::Kind;
pub(crate) use read::read_text_within;
pub use read::{open_regular, read_regular, read_text};
pub use solves::CachedSolves;

use std::collections::HashSet;
use std::fmt::Debug;
use std::sync::{Mutex, MutexGuard, PoisonError};

use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::progress::Listener;
use folder::CachedStage;

/// The finished stages of one build.
pub struct StageCache<'a> {
    store: Option<(&'a Store, Inputs)>,
    /// Stages that this build has kept: another size of the basis does them again.
    own: Mutex<HashSet<String>>,
    /// Hears what was used again and what was not.
    pub listener: &'a dyn Listener,
}

impl<'a> StageCache<'a> {
    /// Of the build of one model; without a store every stage is computed.
    pub fn new(store: Option<&'a Store>, model: &impl StageInput, listener: &'a dyn Listener) -> Self {
        let store = store.map(|store| (store, Inputs::none().with(model)));
        Self { store, own: Mutex::default(), listener }
    }

    /// The result of a stage: the kept one for the same model and `inputs`, or that of `work`, which is then
    /// kept.
    ///
    /// # Errors
    /// Of `work`. A store that cannot be written costs a note, not the build.
    pub(crate) fn stage<T: Serialize + DeserializeOwned, E>(
        &self,
        name: &str,
        inputs: impl FnOnce(Inputs) -> Inputs,
        work: impl FnOnce() -> Result<T, E>,
    ) -> Result<T, E> {
        let Some((store, model)) = &self.store else { return work() };
        let address = inputs(model.clone().value(&name)).address();
        match store.read(name, address) {
            CachedStage::Whole(result) => {
                self.listener.note(&format!("{name}: reused"));
                return Ok(result);
            }
            CachedStage::Damaged(path) => {
                self.listener.note(&format!("{name}: {} is damaged, computed again", path.display()));
            }
            CachedStage::Other if !self.own().contains(name) => {
                self.listener.note(&format!("{name}: rebuilt, what it depends on has changed"))
            }
            CachedStage::Other | CachedStage::Nothing => {}
        }
        let result = work()?;
        self.own().insert(name.to_string());
        if let Err(error) = store.write(name, address, &result) {
            self.listener.note(&format!("{name}: not kept in {}: {error}", store.folder().display()));
        }
        Ok(result)
    }

    fn own(&self) -> MutexGuard<'_, HashSet<String>> {
        self.own.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The solves of a search, as far as they are kept; `solver` is how they are done.
    pub(crate) fn solves(&self, solver: &impl Debug) -> CachedSolves<'a> {
        let store = self.store.as_ref();
        CachedSolves::new(store.map(|(store, model)| (*store, model.clone().value(solver))), self.listener)
    }

    /// Removes the result of a stage, where another one that is kept has taken its place.
    pub(crate) fn forget(&self, name: &str, inputs: impl FnOnce(Inputs) -> Inputs) {
        if let Some((store, model)) = &self.store {
            store.forget(name, inputs(model.clone().value(&name)).address());
        }
    }
}
