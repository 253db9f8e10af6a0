//! Options of a build that do not change its file.

use std::sync::Arc;

use crate::fem::Engine;
use crate::limits::Memory;
use crate::prepared::FactorPrecision;
use crate::store::Store;

/// Options of a build that do not change its file.
#[derive(Clone, Copy, Debug, Default)]
pub struct BuildOptions<'a> {
    /// The folder of finished stages; the file is the same with and without.
    pub store: Option<&'a Store>,
    /// Add terms where the fused step is unstable over live parameters; report and file say what was done.
    pub repair: bool,
    /// Do what takes more than four hours, or more than 2e7 full-order steps, too.
    pub long: bool,
    /// Memory that may be used \[bytes\]; absent: what the machine and the limits of the process leave.
    pub memory: Option<u64>,
    /// The engine that solves with the stiffness and computes natural modes; absent: this process.
    pub engine: Option<&'a Arc<dyn Engine>>,
    /// The precision of the factor of the stiffness in this process.
    pub precision: FactorPrecision,
}

impl BuildOptions<'_> {
    pub(super) fn memory(&self) -> Memory {
        Memory::asked_or_available(self.memory)
    }

    /// The same with the memory that is free now, before the build itself takes of it.
    pub(super) fn at_the_start(&self) -> Self {
        Self { memory: Some(self.memory().limit()), ..*self }
    }
}
