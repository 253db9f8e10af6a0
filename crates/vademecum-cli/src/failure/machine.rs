//! Errors that go back to the machine: memory for a factor, and ranks that work together.

use std::error::Error;

use vademecum_build::fem::{EngineError, FactorError, ModelError, Resource};

/// Remedy for lack of memory.
pub(crate) const MEMORY: &str =
    "close other programs, lift the limit on this one, or ask for fewer modes or cells";
/// Remedy for lack of memory on one of several ranks.
const MEMORY_OF_RANKS: &str = "more machines or fewer ranks on each, `--out-of-core DIR`, or a coarser mesh";
/// Remedy for a failing disk of one of several ranks.
const DISK_OF_RANKS: &str =
    "a folder for `--out-of-core` where every rank may write, on a disk with room for its factor";

/// Side that can act.
pub(crate) enum Blame {
    /// The machine ran short, and what to do.
    Machine(&'static str),
    /// A library failed, and says why.
    Library,
}

/// Cause of an error that goes back to the memory for a factor or to ranks, in any stage;
/// none if it goes back to neither.
pub(crate) fn blame(error: &(dyn Error + 'static)) -> Option<Blame> {
    let mut next = Some(error);
    while let Some(error) = next {
        // An error that is shown as the one within it does not have that one as its source.
        let within = match (error.downcast_ref(), error.downcast_ref()) {
            (Some(FactorError::OutOfMemory), _) | (_, Some(ModelError::OutOfMemory)) => {
                return Some(Blame::Machine(MEMORY));
            }
            (Some(FactorError::Engine(error)), _) | (_, Some(ModelError::Engine(error))) => Some(error),
            _ => error.downcast_ref(),
        };
        if let Some(EngineError { short, .. }) = within {
            return Some(match short {
                Some(Resource::Memory) => Blame::Machine(MEMORY_OF_RANKS),
                Some(Resource::Disk) => Blame::Machine(DISK_OF_RANKS),
                None => Blame::Library,
            });
        }
        next = error.source();
    }
    None
}
