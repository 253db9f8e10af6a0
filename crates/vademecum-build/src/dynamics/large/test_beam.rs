//! A cantilever of quadratic tetrahedra for the tests of this folder.

use crate::fem::test_mesh::{block, quadratic};
use crate::fem::{Material, Model};
use crate::mesh::Mesh;

/// A cantilever along x, held at x = 0; `plane` holds z everywhere.
pub(super) fn cantilever(cells: [usize; 3], size: [f64; 3], material: Material, plane: bool) -> Model {
    let mesh = quadratic(&block(cells, size));
    let held = held(&mesh, plane);
    Model::assemble(mesh, &[material], &held).expect("a model")
}

fn held(mesh: &Mesh, plane: bool) -> Vec<bool> {
    mesh.nodes.iter().flat_map(|&[x, _, _]| [x == 0.0, x == 0.0, plane || x == 0.0]).collect()
}

/// The load over the free dofs of a traction `direction · factor(y)` on the end, `factor` linear in y.
pub(super) fn end_load(model: &Model, direction: [f64; 3], factor: impl Fn(f64) -> f64) -> Vec<f64> {
    let mesh = model.mesh();
    let end = mesh.nodes.iter().map(|x| x[0]).fold(0.0, f64::max);
    let at_end = |node: u32| mesh.nodes[node as usize][0] == end;
    let mut load = vec![0.0; model.dofs().n_dof()];
    // Corners of the faces, and the places of the nodes on their edges.
    let faces = [[0, 1, 2, 4, 5, 6], [0, 1, 3, 4, 8, 7], [1, 2, 3, 5, 9, 8], [0, 2, 3, 6, 9, 7]];
    for e in 0..mesh.element_count() {
        let nodes = mesh.element(e);
        for face in faces.map(|face| face.map(|k| nodes[k])) {
            if !face[..3].iter().all(|&node| at_end(node)) {
                continue;
            }
            let place = |k: usize| mesh.nodes[face[k] as usize];
            let [a, b, c] = [place(0), place(1), place(2)];
            let area = 0.5 * ((b[1] - a[1]) * (c[2] - a[2]) - (b[2] - a[2]) * (c[1] - a[1])).abs();
            let at = [a, b, c].map(|x| factor(x[1]));
            let mut add = |k: usize, weight: f64| {
                for i in 0..3 {
                    load[3 * face[k] as usize + i] += area * weight * direction[i];
                }
            };
            for k in 0..3 {
                // ∫ N_k L_j of the six shape functions of a triangle, over its area.
                let [next, last] = [at[(k + 1) % 3], at[(k + 2) % 3]];
                add(k, at[k] / 30.0 - (next + last) / 60.0);
                add(3 + k, 2.0 / 15.0 * (at[k] + next) + last / 15.0);
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
