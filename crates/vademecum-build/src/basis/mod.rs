//! The basis of motion: snapshots under a plan of loads, their decomposition, and the vectors that are kept.

mod carrier;
mod error;
mod find;
mod local;
mod pod;
mod pooled;
mod ritz;
mod snapshots;

pub(crate) use carrier::sample_settings;
pub use error::BasisError;
pub(crate) use find::find_basis;
pub(crate) use find::most_vectors;
pub use find::{basis_of_pod, decompose};
pub(crate) use local::static_shapes;
pub use pod::{Pod, StreamingPod};
pub(crate) use pooled::{ModePool, basis_of_pool, modes_of_sample, pool_memory, pool_modes};
pub use ritz::{Basis, modes_basis, pod_basis, ritz_basis};
pub use snapshots::{CachedRuns, SnapshotError, SnapshotSchedule};
pub use snapshots::{run_loads, spread_nodes};

#[cfg(test)]
mod tests;
