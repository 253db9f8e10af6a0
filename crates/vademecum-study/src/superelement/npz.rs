//! The arrays of a superelement in one archive, as NumPy reads them.

use super::body::{ReducedBody, columns_of};
use crate::error::StudyError;
use crate::npz::NpzArchive;

/// The bytes of `superelement.npz`; `full` with the matrices of the full order, where there are. Entries bear
/// no time: the same input gives the same bytes.
///
/// # Errors
/// [`StudyError::Archive`].
pub fn npz(body: &ReducedBody, full: bool) -> Result<Vec<u8>, StudyError> {
    let found = &body.superelement;
    let mut archive = NpzArchive::default();
    archive.matrix("mass", &columns_of(&found.mass))?;
    archive.matrix("stiffness", &columns_of(&found.stiffness))?;
    archive.matrix("damping", &columns_of(&found.damping))?;
    archive.matrix("transformation", &columns_of(&found.transformation))?;
    if let Some(motions) = &found.rigid_motions {
        archive.matrix("rigid_motions", &columns_of(motions))?;
    }
    archive.rows("frequencies_hz", &[found.frequencies_hz.len()], &found.frequencies_hz)?;
    archive.rows("nodes", &[body.nodes.len(), 3], body.nodes.as_flattened())?;
    let ids: Vec<i64> = body.node_ids.iter().map(|&id| id as i64).collect();
    archive.integers("node_ids", &[ids.len()], &ids)?;
    let corners: Vec<i64> = body.triangles.iter().flatten().map(|&node| i64::from(node)).collect();
    archive.integers("triangles", &[body.triangles.len(), 3], &corners)?;
    let coordinates: Vec<i64> = (0..)
        .zip(&found.interfaces)
        .flat_map(|(place, interface)| {
            interface
                .coordinates
                .iter()
                .flat_map(move |own| [place, own.node.map_or(-1, i64::from), own.motion as i64])
        })
        .collect();
    archive.integers("coordinates", &[found.coordinates, 3], &coordinates)?;
    let frames: Vec<f64> = found
        .interfaces
        .iter()
        .flat_map(|interface| interface.origin.into_iter().chain(interface.axes.into_iter().flatten()))
        .collect();
    archive.rows("frames", &[found.interfaces.len(), 12], &frames)?;
    let nodes: Vec<i64> =
        found.interfaces.iter().flat_map(|one| &one.nodes).map(|&node| i64::from(node)).collect();
    let weights: Vec<f64> = found.interfaces.iter().flat_map(|one| &one.weights).copied().collect();
    let mut starts = vec![0];
    for interface in &found.interfaces {
        starts.push(starts[starts.len() - 1] + interface.nodes.len() as i64);
    }
    archive.integers("interface_nodes", &[nodes.len()], &nodes)?;
    archive.rows("interface_weights", &[weights.len()], &weights)?;
    archive.integers("interface_starts", &[starts.len()], &starts)?;
    if let Some(model) = body.model.as_ref().filter(|_| full) {
        let pencil = model.pencil();
        archive.sparse("full_mass", pencil.mass())?;
        archive.sparse("full_stiffness", pencil.stiffness())?;
        let dofs = model.dofs().dof_of_free();
        let dofs: Vec<i64> = dofs.iter().map(|&dof| i64::from(dof)).collect();
        archive.integers("full_dofs", &[dofs.len()], &dofs)?;
    }
    Ok(archive.finish()?)
}
