//! Check that a mesh and its matrices fit the memory, before they are allocated.
//!
//! Everything is counted from below, so that nothing is refused that would have fitted: a mesh
//! has at least so many pairs of neighbouring nodes per element, and each pair takes so many numbers.

use crate::fem::{pair_bytes, pairs};
use crate::input::{BlockSource, OrderEntry};
use crate::limits::{Memory, TooMuchMemory};
use crate::mesh::{ElementKind, Mesh, Order};

/// Tetrahedra of one cell of a block.
const PER_CELL: f64 = 6.0;
/// Bytes of one tetrahedron in a mesh and its tables, from below.
const MESH: f64 = 100.0;

/// Bytes of a model while it is assembled: a place for each pair, and its matrices. Of several ranks each has
/// its share of these.
fn model_bytes(elements: f64, kind: ElementKind, regions: usize, ranks: usize) -> f64 {
    let pair = 4.0 + pair_bytes(regions) / ranks as f64;
    elements * (MESH + pairs(kind) * pair)
}

/// Refuses a block whose mesh and matrices do not fit.
///
/// # Errors
/// [`TooMuchMemory`].
pub(super) fn check_block(block: &BlockSource, ranks: usize, memory: Memory) -> Result<(), TooMuchMemory> {
    let cells: f64 = block.divisions.iter().map(|&d| d as f64).product();
    let kind = Order::from(block.order).into();
    let instead = match block.order {
        OrderEntry::Quadratic => ": smaller `mesh.block.divisions`, or `order = \"linear\"`",
        OrderEntry::Linear => ": smaller `mesh.block.divisions`",
    };
    memory.check(model_bytes(PER_CELL * cells, kind, 1, ranks), instead, || {
        format!("the {cells} cells of `mesh.block.divisions`")
    })
}

/// Refuses a mesh whose matrices do not fit.
///
/// # Errors
/// [`TooMuchMemory`].
pub(super) fn check_mesh(mesh: &Mesh, ranks: usize, memory: Memory) -> Result<(), TooMuchMemory> {
    let (elements, regions) = (mesh.element_count(), mesh.regions.len().max(1));
    let of_kind = |&kind: &ElementKind| {
        let count = mesh.each().filter(|element| element.0 == kind).count();
        model_bytes(count as f64, kind, regions, ranks)
    };
    let needed = mesh.kinds.distinct().iter().map(of_kind).sum();
    memory.check(needed, ": a coarser mesh, fewer regions", || {
        format!("the matrices of {elements} elements in {regions} region(s)")
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fem::Material;
    use crate::fem::Model;
    use crate::mesh::block;

    #[test]
    fn the_count_is_from_below() {
        for (order, divisions) in [(Order::Linear, [8, 8, 8]), (Order::Quadratic, [4, 4, 4])] {
            let mesh = block([1.0; 3], divisions, order);
            let elements = mesh.element_count() as f64;
            let held =
                (0..mesh.nodes.len()).flat_map(|n| [mesh.nodes[n][0] == 0.0; 3]).collect::<Vec<bool>>();
            let material = Material::isotropic(1.0, 0.3, 1.0);
            let model = Model::assemble(mesh, &[material], &held).unwrap();
            // 9 entries a pair; the held ones are left out of the pattern.
            let found = model.pencil().mass().pattern().n_stored() as f64 / 9.0 / elements;
            assert!(
                pairs(order.into()) <= found && found <= 1.5 * pairs(order.into()),
                "{found} pairs per element"
            );
        }
    }
}
