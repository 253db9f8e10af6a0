//! Where supports have an area, and where they end inside a smooth face.

use std::collections::HashMap;

use crate::fem::Model;
use crate::linalg::vec3::{cross, dot, norm, sub};
use crate::mesh::FACES;
use crate::mesh::surface::Surface;

/// Largest angle between two facets of one smooth face: its cosine (30°).
const SMOOTH: f64 = 0.866_025_403_784_438_6;

/// The shape of the supports of a body.
pub(super) struct SupportShape {
    /// Corner nodes with a held component.
    pub(super) held_nodes: usize,
    /// Those that lie in no face all of whose corners are held in that component.
    pub(super) without_area: usize,
    /// True if some face is held.
    pub(super) has_area: bool,
    /// Share of the rim of the supports inside smooth faces.
    pub(super) rim: Rim,
}

/// Share of the rim of the supports that lies inside smooth faces of the surface. There the displacement is
/// least smooth, and the raised degree sees least of the error.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Rim {
    /// Nothing: supports end where the surface has an edge.
    Sharp,
    /// At most half of its edges.
    PartlySmooth,
    /// More than half of them, as of a patch in the middle of a face.
    Smooth,
}

/// Looks at every component by itself: a face that rolls along a plane is held in one of them.
pub(super) fn support_shape(model: &Model) -> SupportShape {
    let (mesh, dofs) = (model.mesh(), model.dofs());
    let n_nodes = mesh.nodes.len();
    let held = |node: u32, c: usize| dofs.free(3 * node as usize + c).is_none();
    let (mut any, mut lonely) = (vec![false; n_nodes], vec![false; n_nodes]);
    let mut shape = SupportShape { held_nodes: 0, without_area: 0, has_area: false, rim: Rim::Sharp };
    let [mut smooth, mut sharp] = [0; 2];
    let surface = Surface::of(mesh);
    for c in 0..3 {
        let mut covered = vec![false; n_nodes];
        let elements = || mesh.elements.chunks_exact(mesh.order().nodes_per_element());
        for element in elements() {
            for face in FACES.map(|face| face.map(|i| element[i])) {
                if face.iter().all(|&node| held(node, c)) {
                    face.iter().for_each(|&node| covered[node as usize] = true);
                    shape.has_area = true;
                }
            }
        }
        for &node in elements().flat_map(|element| &element[..4]).filter(|&&node| held(node, c)) {
            any[node as usize] = true;
            lonely[node as usize] |= !covered[node as usize];
        }
        let rim = rim_edges(model, &surface, c);
        (smooth, sharp) = (smooth + rim[0], sharp + rim[1]);
    }
    let count = |flags: &[bool]| flags.iter().filter(|&&flag| flag).count();
    (shape.held_nodes, shape.without_area) = (count(&any), count(&lonely));
    shape.rim = match smooth {
        0 => Rim::Sharp,
        _ if smooth <= sharp => Rim::PartlySmooth,
        _ => Rim::Smooth,
    };
    shape
}

/// Edges of the surface with a facet that is held in a component on one side and one that is free in it on
/// the other: those whose facets are within 30° of one plane, and the others. A facet of an element that is
/// held as a whole is inside the support, whose rim is the face behind it.
fn rim_edges(model: &Model, surface: &Surface, c: usize) -> [usize; 2] {
    let mut edges = [0; 2];
    let (mesh, dofs) = (model.mesh(), model.dofs());
    let held = |nodes: &[u32]| nodes.iter().all(|&node| dofs.free(3 * node as usize + c).is_none());
    let mut seen: HashMap<[u32; 2], ([f64; 3], bool)> = HashMap::new();
    for index in 0..surface.facet_count() {
        let corners: [u32; 3] = std::array::from_fn(|i| surface.facet(index)[i]);
        let inside = held(&mesh.element(surface.facet_element[index] as usize)[..4]);
        if inside {
            continue;
        }
        let [p, q, r] = corners.map(|node| mesh.nodes[node as usize]);
        let normal = cross(sub(q, p), sub(r, p));
        let length = norm(normal);
        let (normal, is_held) = (normal.map(|x| x / length), held(&corners));
        for i in 0..3 {
            let mut edge = [corners[i], corners[(i + 1) % 3]];
            edge.sort_unstable();
            let Some((other, other_held)) = seen.insert(edge, (normal, is_held)) else { continue };
            if is_held != other_held {
                edges[usize::from(dot(normal, other) <= SMOOTH)] += 1;
            }
        }
    }
    edges
}
