//! The boundary of a mesh: the faces that belong to one element only.

use std::collections::HashSet;

use super::{FacetKind, Mesh, corner_triples, face_key};
use crate::linalg::vec3::{cross, norm, sub};

/// Boundary facets, their linear triangles and the nodes on them.
///
/// Facets are in order of their elements, so the same mesh gives the same surface on any machine.
#[derive(Clone, Debug)]
pub struct Surface {
    /// Kind of each facet.
    facet_kinds: Vec<FacetKind>,
    /// Node indices of the mesh, as [`FacetKind`] orders them, facet after facet.
    facets: Vec<u32>,
    /// Place of the first node of each facet; one more at the end.
    facet_starts: Vec<u32>,
    /// The element each facet belongs to.
    pub(crate) facet_element: Vec<u32>,
    /// Linear triangles on node indices of the mesh, outward: 3-node facets themselves, the parts of others.
    pub triangles: Vec<[u32; 3]>,
    /// The facet each triangle belongs to.
    pub(crate) triangle_facet: Vec<u32>,
    /// Nodes on the surface, ascending.
    pub nodes: Vec<u32>,
    /// Outward unit normal at each of `nodes`: that of the triangles round it, weighted by area.
    pub normals: Vec<[f64; 3]>,
}

impl Surface {
    /// Finds the boundary of a mesh. Sorts its faces: O(n log n) time, 32 bytes per face.
    pub fn of(mesh: &Mesh) -> Surface {
        let (facet_kinds, facets, facet_element) = boundary(mesh);
        let mut facet_starts = vec![0];
        let (mut triangles, mut triangle_facet) = (Vec::new(), Vec::new());
        for (index, kind) in facet_kinds.iter().enumerate() {
            let start = facet_starts[index];
            let facet = &facets[start as usize..][..kind.nodes()];
            facet_starts.push(start + kind.nodes() as u32);
            triangles.extend(kind.triangles().iter().map(|part| part.map(|i| facet[i])));
            triangle_facet.extend(kind.triangles().iter().map(|_| index as u32));
        }
        let mut nodes = facets.clone();
        nodes.sort_unstable();
        nodes.dedup();
        let normals = normals(mesh, &triangles, &nodes);
        Surface {
            facet_kinds,
            facets,
            facet_starts,
            facet_element,
            triangles,
            triangle_facet,
            nodes,
            normals,
        }
    }

    /// Linear triangles as a surface, of a body without elements; it has no normals.
    pub(crate) fn of_triangles(triangles: Vec<[u32; 3]>) -> Surface {
        let mut nodes = triangles.as_flattened().to_vec();
        nodes.sort_unstable();
        nodes.dedup();
        Surface {
            facet_kinds: vec![FacetKind::Tri3; triangles.len()],
            facets: triangles.as_flattened().to_vec(),
            facet_starts: (0..=triangles.len() as u32).map(|i| 3 * i).collect(),
            facet_element: vec![],
            triangle_facet: (0..triangles.len() as u32).collect(),
            triangles,
            nodes,
            normals: vec![],
        }
    }

    /// Number of facets.
    pub fn facet_count(&self) -> usize {
        self.facet_kinds.len()
    }

    /// Kind of one facet.
    ///
    /// # Panics
    /// If there is no such facet.
    pub fn facet_kind(&self, index: usize) -> FacetKind {
        self.facet_kinds[index]
    }

    /// Nodes of one facet.
    ///
    /// # Panics
    /// If there is no such facet.
    pub fn facet(&self, index: usize) -> &[u32] {
        &self.facets[self.facet_starts[index] as usize..self.facet_starts[index + 1] as usize]
    }

    /// Nodes of each facet.
    pub(crate) fn each_facet(&self) -> impl Iterator<Item = &[u32]> {
        (0..self.facet_count()).map(|index| self.facet(index))
    }

    /// Area of the triangles of the facets that are named by three of their corners each.
    pub fn area_of(&self, mesh: &Mesh, facets: &[[u32; 3]]) -> f64 {
        let sorted = |mut corners: [u32; 3]| {
            corners.sort_unstable();
            corners
        };
        let named: HashSet<[u32; 3]> = facets.iter().copied().map(sorted).collect();
        let is_named = |index: usize| {
            let corners = &self.facet(index)[..self.facet_kinds[index].corners()];
            let mut key = [u32::MAX; 4];
            key[..corners.len()].copy_from_slice(corners);
            key.sort_unstable();
            corner_triples(key).iter().any(|triple| named.contains(triple))
        };
        let chosen: Vec<bool> = (0..self.facet_count()).map(is_named).collect();
        let area = |triangle: &[u32; 3]| {
            let [a, b, c] = triangle.map(|node| mesh.nodes[node as usize]);
            0.5 * norm(cross(sub(b, a), sub(c, a)))
        };
        let triangles = self.triangles.iter().zip(&self.triangle_facet);
        triangles.filter(|(_, facet)| chosen[**facet as usize]).map(|(triangle, _)| area(triangle)).sum()
    }

    /// Position of a mesh node in `nodes`.
    pub fn position(&self, node: u32) -> Option<usize> {
        self.nodes.binary_search(&node).ok()
    }

    /// Indices of the facets all of whose nodes are among `nodes` (ascending): the patch a selection of nodes
    /// means.
    pub fn facets_within(&self, nodes: &[u32]) -> Vec<u32> {
        let facets = self.each_facet().zip(0..);
        let inside = |f: &[u32]| f.iter().all(|n| nodes.binary_search(n).is_ok());
        facets.filter(|(f, _)| inside(f)).map(|(_, index)| index).collect()
    }
}

/// Kinds, nodes and elements of the faces that belong to one element.
fn boundary(mesh: &Mesh) -> (Vec<FacetKind>, Vec<u32>, Vec<u32>) {
    // A face by its corners, with its element and its place there.
    let mut faces: Vec<([u32; 4], u32, u8)> = Vec::with_capacity(mesh.element_count() * 4);
    for (e, (kind, element)) in mesh.each().enumerate() {
        for (f, face) in kind.faces().iter().enumerate() {
            faces.push((face_key(face, element).0, e as u32, f as u8));
        }
    }
    faces.sort_unstable();
    let single = |run: &[([u32; 4], u32, u8)]| (run.len() == 1).then(|| (run[0].1, run[0].2));
    let mut open: Vec<(u32, u8)> = faces.chunk_by(|a, b| a.0 == b.0).filter_map(single).collect();
    open.sort_unstable();
    let (mut kinds, mut facets) = (Vec::with_capacity(open.len()), Vec::new());
    for &(e, f) in &open {
        let (kind, nodes) = mesh.kinds.kind(e as usize).faces()[f as usize];
        let element = mesh.element(e as usize);
        kinds.push(kind);
        facets.extend(nodes.iter().map(|&i| element[i]));
    }
    (kinds, facets, open.iter().map(|open| open.0).collect())
}

fn normals(mesh: &Mesh, triangles: &[[u32; 3]], nodes: &[u32]) -> Vec<[f64; 3]> {
    let mut sums = vec![[0.0; 3]; mesh.nodes.len()];
    for triangle in triangles {
        let [a, b, c] = triangle.map(|n| mesh.nodes[n as usize]);
        let area = cross(sub(b, a), sub(c, a));
        for &n in triangle {
            for k in 0..3 {
                sums[n as usize][k] += area[k];
            }
        }
    }
    let unit = |v: [f64; 3]| {
        let length = norm(v);
        // A node where opposite sides meet (an edge of a crack) has no normal of its own.
        if length > 0.0 { v.map(|x| x / length) } else { [0.0; 3] }
    };
    nodes.iter().map(|&n| unit(sums[n as usize])).collect()
}
