//! A matrix whose rows lie on several ranks, seen from the first.

use std::fmt::Debug;
use std::sync::Arc;

use faer::{MatMut, MatRef};

/// Why ranks that work together had to stop.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{call} failed: {reason}")]
pub struct EngineError {
    /// What was called, as the library names it.
    pub call: String,
    /// What the library says of it.
    pub reason: String,
    /// What ran short, where that is the cause.
    pub short: Option<Resource>,
}

/// What a machine may run short of.
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
