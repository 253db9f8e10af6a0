//! A cantilever of quadratic elements for the tests of this folder.

use crate::fem::test_cells::cells;
use crate::fem::test_mesh::{block, quadratic};
use crate::fem::{Material, Model, facet_matrix, surface_facets};
use crate::mesh::{ElementKind, Hexahedra, Mesh};

/// A cantilever of tetrahedra along x, held at x = 0; `plane` holds z everywhere.
pub(super) fn cantilever(divisions: [usize; 3], size: [f64; 3], material: Material, plane: bool) -> Model {
    held_at_wall(quadratic(&block(divisions, size)), material, plane)
}

/// The same of hexahedra.
pub(super) fn hexahedra(
    (kind, formulation): (ElementKind, Hexahedra),
    divisions: [usize; 3],
    size: [f64; 3],
    material: Material,
    plane: bool,
) -> Model {
    let place = |x: [f64; 3]| std::array::from_fn(|i| size[i] * (x[i] / divisions[i] as f64));
    let mut mesh = cells(divisions, place, |_| vec![(kind, (0..8).collect())]);
    mesh.regions[0].hexahedra = Some(formulation);
    held_at_wall(mesh, material, plane)
}

fn held_at_wall(mesh: Mesh, material: Material, plane: bool) -> Model {
    let held: Vec<bool> =
        mesh.nodes.iter().flat_map(|&[x, _, _]| [x == 0.0, x == 0.0, plane || x == 0.0]).collect();
    Model::assemble(mesh, &[material], &held).expect("a model")
}

/// The load over the free dofs of a traction `direction · factor(y)` on the end, `factor` linear in y.
pub(super) fn end_load(model: &Model, direction: [f64; 3], factor: impl Fn(f64) -> f64) -> Vec<f64> {
    let mesh = model.mesh();
    let end = mesh.nodes.iter().map(|x| x[0]).fold(0.0, f64::max);
    let mut corners: Vec<[u32; 3]> = vec![];
    for (kind, nodes) in mesh.each() {
        let faces = kind.faces().iter().map(|(_, places)| std::array::from_fn(|i| nodes[places[i]]));
        corners.extend(faces.filter(|face| face.iter().all(|&node| mesh.nodes[node as usize][0] == end)));
    }
    let mut load = vec![0.0; model.dofs().n_dof()];
    for facet in surface_facets(mesh, &corners).expect("faces at the end") {
        // A traction that is linear in the place is a sum of shape functions.
        let products = facet_matrix(mesh, &facet, 1.0, 1.0);
        for (a, &node) in facet.nodes().iter().enumerate() {
            for (b, &other) in facet.nodes().iter().enumerate() {
                let share = products[(3 * a, 3 * b)] * factor(mesh.nodes[other as usize][1]);
                (0..3).for_each(|i| load[3 * node as usize + i] += share * direction[i]);
            }
        }
    }
    model.free_part(&load)
}

/// The node nearest to a place.
pub(super) fn nearest(model: &Model, at: [f64; 3]) -> usize {
    let square = |x: &[f64; 3]| (0..3).map(|i| (x[i] - at[i]).powi(2)).sum::<f64>();
    let nodes = model.mesh().nodes.iter().enumerate();
    nodes.min_by(|a, b| square(a.1).total_cmp(&square(b.1))).expect("a node").0
}

/// The displacement of a node.
pub(super) fn moved(model: &Model, u: &[f64], node: usize) -> [f64; 3] {
    std::array::from_fn(|c| model.dofs().free(3 * node + c).map_or(0.0, |free| u[free as usize]))
}
