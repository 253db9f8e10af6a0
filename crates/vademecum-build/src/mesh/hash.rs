//! The hash that binds a vademecum file to the mesh it was built on.

use xxhash_rust::xxh3::Xxh3;

use super::Mesh;

/// XXH3-128 (seed 0, big-endian digest, its canonical form) of: nodes per element, node count and element
/// count as little-endian u64; coordinates as little-endian f64, node after node; connectivity as
/// little-endian u32. Elements of several kinds have 0 nodes per element and one byte each, VTK's number of
/// the cell, after the connectivity; so have those of one kind other than tetrahedra, with their nodes.
///
/// Groups, regions and file numbers are left out: they may be renamed without changing the physics of the
/// mesh.
pub fn hash(mesh: &Mesh) -> [u8; 16] {
    let mut state = Xxh3::new();
    let per = mesh.kinds.uniform().map_or(0, |kind| kind.nodes());
    let counts = [per, mesh.nodes.len(), mesh.element_count()];
    for count in counts {
        state.update(&(count as u64).to_le_bytes());
    }
    for x in mesh.nodes.iter().flatten() {
        state.update(&x.to_le_bytes());
    }
    for node in &mesh.elements {
        state.update(&node.to_le_bytes());
    }
    if mesh.tetrahedra().is_none() {
        mesh.each().for_each(|(kind, _)| state.update(&[kind.vtk()]));
    }
    state.digest128().to_be_bytes()
}
