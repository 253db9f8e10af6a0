//! Quadrangular facets that may be loaded: a point is found by their triangles, and shared over all their
//! nodes.

use crate::mesh::FacetKind;
use crate::mesh::shapes::quadrangle_shapes;

/// A quadrangular facet of the loadable surface.
#[derive(Clone, Debug)]
pub(crate) struct Quadrangle {
    /// Shape and number of nodes.
    pub(crate) kind: FacetKind,
    /// The first of its triangles among the loadable ones, which follow one another.
    pub(crate) first: usize,
    /// Its nodes, as [`FacetKind`] orders them.
    pub(crate) nodes: Vec<u32>,
}

impl Quadrangle {
    /// Its triangles among the loadable ones.
    pub(crate) fn triangles(&self) -> std::ops::Range<usize> {
        self.first..self.first + self.kind.triangles().len()
    }

    /// Shape functions of its nodes at the point with barycentric `weights` in one of its triangles.
    pub(super) fn shares(&self, triangle: [u32; 3], weights: [f64; 3]) -> Vec<f64> {
        let [x, y] = in_quadrangle(&self.nodes, triangle, weights);
        quadrangle_shapes(self.kind, x, y).0
    }
}

/// Coordinates in a quadrangle of a place in one of its triangles.
pub(super) fn in_quadrangle(facet: &[u32], triangle: [u32; 3], weights: [f64; 3]) -> [f64; 2] {
    const PLACES: [[f64; 2]; 9] = [
        [-1.0, -1.0],
        [1.0, -1.0],
        [1.0, 1.0],
        [-1.0, 1.0],
        [0.0, -1.0],
        [1.0, 0.0],
        [0.0, 1.0],
        [-1.0, 0.0],
        [0.0, 0.0],
    ];
    let mut sum = [0.0; 2];
    for (node, weight) in triangle.iter().zip(weights) {
        let place = facet.iter().position(|other| other == node).expect("a node of its facet");
        sum.iter_mut().zip(PLACES[place]).for_each(|(sum, x)| *sum += weight * x);
    }
    sum
}
