//! Points on facets: the place on a surface that is nearest to a point, as shape functions of its nodes.

use super::coupling::mean_rows;
use super::loads::{Facet, facet_shapes};
use crate::linalg::vec3::{cross, dot, norm, sub};
use crate::mesh::shapes::quadrangle_shapes;
use crate::mesh::{FacetKind, Mesh, Order};
use crate::parallel;

/// A place on a surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Anchor {
    /// Nodes of its facet and the values of their shape functions, which sum to one.
    pub weights: Vec<(u32, f64)>,
    /// Distance from the point.
    pub distance: f64,
    /// True of a place on the rim of its facet, from where the point is not straight above the facet.
    pub on_rim: bool,
}

/// The place nearest to each point on any of the facets; none where there is no facet.
///
/// Points in parallel. Facets are passed over whose bounding sphere is farther than what was found.
pub fn anchors(mesh: &Mesh, facets: &[Facet], points: &[[f64; 3]]) -> Vec<Option<Anchor>> {
    let spheres: Vec<([f64; 3], f64)> = facets.iter().map(|facet| sphere(mesh, facet)).collect();
    let nearest = |at: usize| {
        let point = points[at];
        let mut order: Vec<(f64, usize)> =
            spheres.iter().map(|(at, radius)| norm(sub(point, *at)) - radius).zip(0..).collect();
        order.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        let mut best: Option<Anchor> = None;
        for (least, facet) in order {
            if best.as_ref().is_some_and(|best| best.distance <= least) {
                break;
            }
            let found = nearest_on(mesh, &facets[facet], point);
            if best.as_ref().is_none_or(|best| found.distance < best.distance) {
                best = Some(found);
            }
        }
        best
    };
    parallel::map(points.len(), &nearest)
}

/// A gap below this share of the size of the facet is rounding.
const CLOSED: f64 = 1e-13;

/// Motion of a point against its anchor by the rotation of the facet, `θ × g` over the gap `g`: dofs
/// `3 · node + component` of the facet, and their weights in the three components. With it a tie over a gap
/// leaves a body that turns as a whole unstrained. `at` gives the places of nodes.
pub fn over_gap(at: impl Fn(u32) -> [f64; 3], point: [f64; 3], anchor: &Anchor) -> Vec<(u32, [f64; 3])> {
    let cloud: Vec<([f64; 3], f64)> = anchor.weights.iter().map(|term| (at(term.0), 1.0)).collect();
    let place: [f64; 3] =
        std::array::from_fn(|c| cloud.iter().zip(&anchor.weights).map(|(x, term)| term.1 * x.0[c]).sum());
    let (gap, size) = (sub(point, place), norm(sub(cloud[0].0, cloud[1].0)));
    if norm(gap) <= CLOSED * size {
        return vec![];
    }
    let rows = mean_rows(place, &cloud);
    let of_node = |(term, row): (&(u32, f64), &[[f64; 3]; 6])| {
        let (node, row) = (term.0, *row);
        (0..3).map(move |k| {
            let turn: [f64; 3] = std::array::from_fn(|a| row[3 + a][k as usize]);
            (3 * node + k, cross(turn, gap))
        })
    };
    anchor.weights.iter().zip(&rows).flat_map(of_node).collect()
}

/// Middle of the nodes of a facet, and a radius that holds all of it: a curved facet leaves the hull of its
/// nodes by less than its size.
fn sphere(mesh: &Mesh, facet: &Facet) -> ([f64; 3], f64) {
    let nodes = facet.nodes();
    let at = |node: &u32| mesh.nodes[*node as usize];
    let middle =
        std::array::from_fn(|c| nodes.iter().map(|node| at(node)[c]).sum::<f64>() / nodes.len() as f64);
    let radius = nodes.iter().map(|node| norm(sub(at(node), middle))).fold(0.0, f64::max);
    (middle, 1.5 * radius)
}

/// Values of the shape functions of a facet and their slopes. Triangles take `(L_2, L_3)`, quadrangles
/// `(ξ, η)` of `[−1, 1]²`.
fn shapes(kind: FacetKind, [r, s]: [f64; 2]) -> (Vec<f64>, Vec<[f64; 2]>) {
    let order = match kind {
        FacetKind::Tri3 => Order::Linear,
        FacetKind::Tri6 => Order::Quadratic,
        FacetKind::Quad4 | FacetKind::Quad8 | FacetKind::Quad9 => return quadrangle_shapes(kind, r, s),
    };
    let (values, slopes) = facet_shapes(order, [1.0 - r - s, r, s]);
    (values[..kind.nodes()].to_vec(), slopes[..kind.nodes()].to_vec())
}

/// A facet being searched.
struct Search<'a> {
    mesh: &'a Mesh,
    facet: &'a Facet,
    point: [f64; 3],
}

/// The nearest place on one facet: the inner one where the distance is stationary, else one on an edge.
fn nearest_on(mesh: &Mesh, facet: &Facet, point: [f64; 3]) -> Anchor {
    let search = Search { mesh, facet, point };
    let triangle = facet.kind().corners() == 3;
    let (middle, corners): ([f64; 2], &[[f64; 2]]) = match triangle {
        true => ([1.0 / 3.0; 2], &[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]),
        false => ([0.0; 2], &[[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]),
    };
    let inside = |[r, s]: [f64; 2]| match triangle {
        true => r >= 0.0 && s >= 0.0 && r + s <= 1.0,
        false => r.abs() <= 1.0 && s.abs() <= 1.0,
    };
    if let Some(found) = search.stationary(middle).filter(|found| inside(*found)) {
        return search.anchor(found, false);
    }
    let edges = (0..corners.len()).map(|k| {
        let (from, to) = (corners[k], corners[(k + 1) % corners.len()]);
        search.anchor(search.on_edge(from, to), true)
    });
    let nearest = edges.min_by(|a, b| a.distance.total_cmp(&b.distance));
    nearest.unwrap_or_else(|| search.anchor(middle, true))
}

impl Search<'_> {
    /// The point minus a place, and the tangents there.
    fn gap(&self, at: [f64; 2]) -> ([f64; 3], [[f64; 3]; 2], Vec<f64>) {
        let (values, slopes) = shapes(self.facet.kind(), at);
        let (mut gap, mut tangents) = (self.point, [[0.0; 3]; 2]);
        for ((&node, value), slope) in self.facet.nodes().iter().zip(&values).zip(&slopes) {
            let x = self.mesh.nodes[node as usize];
            for c in 0..3 {
                gap[c] -= value * x[c];
                tangents[0][c] += slope[0] * x[c];
                tangents[1][c] += slope[1] * x[c];
            }
        }
        (gap, tangents, values)
    }

    /// Where the gap stands normal to the facet, by Gauss and Newton's steps from the middle.
    fn stationary(&self, mut at: [f64; 2]) -> Option<[f64; 2]> {
        for _ in 0..50 {
            let (gap, [a, b], _) = self.gap(at);
            let (aa, ab, bb) = (dot(a, a), dot(a, b), dot(b, b));
            let (ra, rb, determinant) = (dot(a, gap), dot(b, gap), aa * bb - ab * ab);
            let step = [(bb * ra - ab * rb) / determinant, (aa * rb - ab * ra) / determinant];
            if !step.iter().all(|x| x.is_finite()) {
                return None;
            }
            // Far outside of the facet its functions mean nothing.
            at = [0, 1].map(|k| (at[k] + step[k]).clamp(-3.0, 3.0));
            if step.iter().all(|x| x.abs() < 1e-14) {
                return Some(at);
            }
        }
        Some(at)
    }

    /// The nearest place of an edge of the reference facet.
    fn on_edge(&self, from: [f64; 2], to: [f64; 2]) -> [f64; 2] {
        let along = [to[0] - from[0], to[1] - from[1]];
        let place = |t: f64| [from[0] + t * along[0], from[1] + t * along[1]];
        let mut t = 0.5;
        for _ in 0..50 {
            let (gap, [a, b], _) = self.gap(place(t));
            let tangent: [f64; 3] = std::array::from_fn(|c| along[0] * a[c] + along[1] * b[c]);
            let step = dot(tangent, gap) / dot(tangent, tangent);
            let next = (t + step).clamp(0.0, 1.0);
            if !next.is_finite() || (next - t).abs() < 1e-15 {
                break;
            }
            t = next;
        }
        place(t)
    }

    fn anchor(&self, at: [f64; 2], on_rim: bool) -> Anchor {
        let (gap, _, values) = self.gap(at);
        let weights = self.facet.nodes().iter().copied().zip(values).collect();
        Anchor { weights, distance: norm(gap), on_rim }
    }
}

#[cfg(test)]
mod tests {
    use super::super::loads::surface_facets;
    use super::super::test_mesh::{block, moved, quadratic};
    use super::*;
    use crate::mesh::surface::Surface;

    fn facets(mesh: &Mesh) -> Vec<Facet> {
        surface_facets(mesh, &Surface::of(mesh).triangles[..]).unwrap_or_default()
    }

    fn place(mesh: &Mesh, anchor: &Anchor) -> [f64; 3] {
        std::array::from_fn(|c| anchor.weights.iter().map(|(n, w)| w * mesh.nodes[*n as usize][c]).sum())
    }

    #[test]
    fn the_nearest_place_of_a_box_is_found_outside_of_faces_edges_and_corners() {
        let mesh = block([3, 2, 2], [3.0, 2.0, 1.0]);
        let facets = facets(&mesh);
        assert!(!facets.is_empty());
        let points = [[1.3, 0.7, 1.2], [1.3, 2.5, 1.5], [4.0, 3.0, 2.0], [1.3, 0.7, 1.0]];
        let expected = [[1.3, 0.7, 1.0], [1.3, 2.0, 1.0], [3.0, 2.0, 1.0], [1.3, 0.7, 1.0]];
        for (found, expected) in anchors(&mesh, &facets, &points).iter().zip(expected) {
            let found = found.as_ref().unwrap();
            assert!(norm(sub(place(&mesh, found), expected)) < 1e-12, "{found:?}");
            assert!((found.weights.iter().map(|w| w.1).sum::<f64>() - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn a_node_of_a_curved_surface_is_its_own_anchor() {
        let bend = |[x, y, z]: [f64; 3]| [x, y, z + 0.1 * x * x];
        let mesh = moved(quadratic(&block([2, 1, 1], [1.0, 0.5, 0.3])), bend);
        let corners: Vec<[u32; 3]> = mesh
            .each()
            .flat_map(|(kind, e)| {
                kind.faces().iter().map(|f| [0, 1, 2].map(|k| e[f.1[k]])).collect::<Vec<_>>()
            })
            .filter(|c| surface_facets(&mesh, &[*c]).is_ok())
            .collect();
        let facets = surface_facets(&mesh, &corners).unwrap();
        let nodes: Vec<u32> = facets.iter().flat_map(|facet| facet.nodes().iter().copied()).collect();
        let points: Vec<[f64; 3]> = nodes.iter().map(|&node| mesh.nodes[node as usize]).collect();
        for (found, point) in anchors(&mesh, &facets, &points).iter().zip(&points) {
            let found = found.as_ref().unwrap();
            assert!(found.distance < 1e-12 && norm(sub(place(&mesh, found), *point)) < 1e-12, "{found:?}");
        }
    }

    #[test]
    fn without_facets_there_is_no_place() {
        let mesh = block([1, 1, 1], [1.0; 3]);
        assert_eq!(anchors(&mesh, &[], &[[0.0; 3]]), [None]);
    }
}
