//! The model of a problem behind the nodes of a file: its basis over free dofs, and its loads.

use std::collections::HashMap;

use vademecum_build::Matrix;
use vademecum_build::dynamics::TimedLoad;
use vademecum_build::prepared::Body;
use vademecum_format::{File, SectionKind};

use crate::contents::{lines, section};
use crate::error::{FileError, StudyError};
use crate::player::{PlacedContact, Track};

/// Mesh node of each file node, by the ids in the file.
///
/// # Errors
/// [`FileError`]: a file without ids, or with one that the mesh does not have.
pub fn file_nodes(file: &File<'_>, body: &Body) -> Result<Vec<u32>, FileError> {
    let mesh = body.model.mesh();
    let by_id: HashMap<u64, u32> = mesh.node_ids.iter().enumerate().map(|(i, &id)| (id, i as u32)).collect();
    let node = |id: &[u8; 8]| {
        let id = u64::from_le_bytes(*id);
        by_id.get(&id).copied().ok_or(FileError::ForeignNode { id })
    };
    section(file, SectionKind::NodeIds)?.u64s()?.iter().map(node).collect()
}

/// Rows of `B` over the free dofs of the model, from the file; shape (n, r).
///
/// # Errors
/// [`FileError`]: a file without all of its basis.
pub fn free_basis(file: &File<'_>, body: &Body, file_nodes: &[u32]) -> Result<Matrix, FileError> {
    let r = file.metadata().n_modes as usize;
    let mut rows = vec![];
    for kind in [SectionKind::SurfaceBasis, SectionKind::InteriorBasis] {
        if rows.len() < 3 * r * file_nodes.len() {
            rows.extend(section(file, kind)?.numbers()?.iter());
        }
    }
    let mut basis = Matrix::zeros(body.n_dof(), r);
    for k in 0..r {
        let field = mesh_field(body, file_nodes, |place, component| rows[(3 * place + component) * r + k]);
        body.model.dofs().restrict_into(&field, basis.col_as_slice_mut(k));
    }
    Ok(basis)
}

/// A field over all dofs of the mesh, from that of the nodes of a file.
pub(super) fn mesh_field(body: &Body, file_nodes: &[u32], of: impl Fn(usize, usize) -> f64) -> Vec<f64> {
    let mut field = vec![0.0; body.model.dofs().n_dof()];
    for (place, &node) in file_nodes.iter().enumerate() {
        (0..3).for_each(|component| field[3 * node as usize + component] = of(place, component));
    }
    field
}

/// The loads of a track as forces over the free dofs.
///
/// # Errors
/// [`StudyError::ForeignPattern`]; [`StudyError::File`]: names that cannot be read.
pub(crate) fn full_order_loads(
    file: &File<'_>,
    track: &Track,
    body: &Body,
    file_nodes: &[u32],
) -> Result<Vec<TimedLoad>, StudyError> {
    let contact = |PlacedContact { contact, when, .. }: &PlacedContact| {
        let mut force = vec![0.0; body.n_dof()];
        let nodes: Vec<u32> = contact.place.nodes().iter().map(|&node| file_nodes[node as usize]).collect();
        body.model.add_point_force(&nodes, contact.place.weights(), contact.force, &mut force);
        TimedLoad { column: 0, force, when: when.clone() }
    };
    let mut loads: Vec<TimedLoad> = track.contacts.iter().map(contact).collect();
    let known = lines(file, SectionKind::PatternNames)?;
    for placed in &track.patterns {
        let name = &known[placed.index];
        let pattern = body.patterns.iter().find(|(pattern, _)| pattern == name);
        let (_, force) = pattern.ok_or_else(|| StudyError::ForeignPattern { name: name.clone() })?;
        let force = force.iter().map(|f| placed.amplitude * f).collect();
        loads.push(TimedLoad { column: 0, force, when: placed.when.clone() });
    }
    Ok(loads)
}
