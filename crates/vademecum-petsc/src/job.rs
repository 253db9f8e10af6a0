//! Options of a job, and its early end.

use std::path::PathBuf;

use vademecum_build::fem::EngineError;

use crate::ranks::Ranks;

/// The exit code of a job that a rank ended: that of numerics, or of the machine where something ran short.
fn exit_code(error: &EngineError) -> u8 {
    if error.short.is_some() { 1 } else { 5 }
}

/// Options of the user.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// Folder of factors on disk; absent: in memory. Every rank makes a folder of its own in it.
    pub out_of_core: Option<PathBuf>,
    /// Conjugate gradients with algebraic multigrid, and no factor, to [`TOLERANCE`].
    pub iterative: bool,
    /// Memory that the ranks of one machine may use together \[bytes\]; absent: what the machine has free.
    pub memory: Option<u64>,
}

/// Relative error of conjugate gradients in the energy norm.
pub const TOLERANCE: f64 = 1e-10;

/// Names an error and ends the job.
pub fn end(ranks: &Ranks, error: &EngineError) -> ! {
    eprintln!("error: rank {} of {}: {error}", ranks.calls.rank, ranks.calls.size);
    ranks.calls.abort(exit_code(error))
}
