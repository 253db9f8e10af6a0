//! The section of the discretisation error.

use vademecum_format::SectionKind;

use super::Draft;
use crate::mesh_error::MeshEstimate;

/// Section 67, where there is an estimate.
pub(crate) fn mesh_error_section(estimate: &MeshEstimate) -> Option<Draft> {
    let MeshEstimate::Known(error) = estimate else { return None };
    let rows = error.frequencies.iter().flat_map(|value| [value.mesh, value.refined, value.bound]);
    Some(Draft::f64s(SectionKind::MeshError, [error.frequencies.len(), 3, 1], rows))
}
