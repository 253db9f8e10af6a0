//! Error certificate: validation of a built file against full-order runs.
//!
//! Unseen loads, at positions and in directions no snapshot used, are marched full order and through the
//! evaluator, on the very bytes that ship; the error is put beside the floor of the basis. Then the step runs
//! free for long and its energy is watched, and its spectral radius is computed from the map the evaluator
//! steps with. Over live parameters the same is done at every corner of the box, and stability at random
//! points beside them.

pub mod endurance;
mod error;
mod evaluated;
mod figures;
mod growth;
mod large;
mod over_box;
mod unseen;
mod verdict;
mod witness;

pub use error::CertificateError;
pub use evaluated::{Candidate, Measured, measure, spectral_radius};
pub(crate) use evaluated::{certify, certify_beside, certify_exact};
pub(crate) use figures::FIGURES;
pub use figures::{Figures, FileFigures};
pub use large::{CONVERGED_SUBSTEPS, LargeReport, LargeRun};
pub(crate) use large::{certify_push, push_motion};
pub(crate) use over_box::certify_box;
pub(crate) use unseen::TRAJECTORIES;
pub use unseen::{TestLoad, UnseenLoad, UnseenLoads};
pub use verdict::{BOUNDED, StructureMeasured, StructureReport};
pub(crate) use witness::distance_at_full_order;

use crate::store::{Inputs, StageCache};

/// A march of the certificate, kept as one row of numbers per structure.
pub(crate) fn kept_certificate<E>(
    kept: &StageCache<'_>,
    name: &str,
    inputs: impl FnOnce(Inputs) -> Inputs,
    march: impl FnOnce() -> Result<Vec<StructureMeasured>, E>,
) -> Result<Vec<StructureMeasured>, E> {
    let rows: Vec<Vec<f64>> =
        kept.stage(name, inputs, || Ok(march()?.iter().map(StructureMeasured::row).collect()))?;
    Ok(rows.iter().map(|row| StructureMeasured::from_row(row)).collect())
}
