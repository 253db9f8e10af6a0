//! A matrix whose rows lie on several ranks, seen from the first.

use std::fmt::Debug;
use std::sync::Arc;

use faer::{MatMut, MatRef};

/// Why ranks that work together had to stop.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{call} failed: {reason}")]
pub struct EngineError {
    /// Name of the call in the library.
    pub call: String,
    /// Message of the library.
    pub reason: String,
    /// The exhausted resource, where that is the cause.
    pub short: Option<Resource>,
}

/// A limited resource of a machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Resource {
    /// Memory.
    Memory,
    /// Disk.
    Disk,
}

/// A symmetric matrix whose rows lie on several ranks.
pub trait SpreadMatrix: Debug + Send + Sync {
    /// By which the ranks know it.
    fn number(&self) -> u64;

    /// Its diagonal.
    fn diagonal(&self) -> &[f64];

    /// `y ← A x` of whole columns. A failure of the ranks ends the program with its cause.
    fn mul_into(&self, x: MatRef<'_, f64>, y: MatMut<'_, f64>);

    /// The same matrix times a number. A failure of the ranks ends the program with its cause.
    fn scaled(&self, weight: f64) -> Arc<dyn SpreadMatrix>;
}
