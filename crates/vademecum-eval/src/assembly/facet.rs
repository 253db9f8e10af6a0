//! Facets of three to nine nodes: shape functions, and the place nearest to a point.

use crate::base::vec3::{add, dot, minus};
use vademecum_format::PORT_FACET_NODES;

/// Steps of a search for a place.
const STEPS: usize = 50;

/// Corners of a quadrangle.
const CORNERS: [[f64; 2]; 4] = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];

/// Nodes of a facet at their places: corners first, then the middles of its edges, then its own.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Facet {
    places: [[f64; 3]; PORT_FACET_NODES],
    count: usize,
}

/// A place on a facet.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Nearest {
    /// Values of the shape functions, 0 beyond the nodes of the facet.
    pub weights: [f64; PORT_FACET_NODES],
    /// Distance from the point \[m\].
    pub distance: f64,
}

/// Values and slopes of the shape functions.
type Shapes = [(f64, [f64; 2]); PORT_FACET_NODES];

impl Facet {
    /// A facet of 3, 4, 6, 8 or 9 nodes; `None` for another number.
    pub fn new(places: &[[f64; 3]]) -> Option<Self> {
        let mut own = [[0.0; 3]; PORT_FACET_NODES];
        own.iter_mut().zip(places).for_each(|(to, from)| *to = *from);
        matches!(places.len(), 3 | 4 | 6 | 8 | 9).then_some(Self { places: own, count: places.len() })
    }

    fn nodes(&self) -> &[[f64; 3]] {
        self.places.get(..self.count).unwrap_or_default()
    }

    fn is_triangle(&self) -> bool {
        matches!(self.count, 3 | 6)
    }

    /// Smallest distance that any of its places may have from a point: a curved facet leaves the hull of its
    /// nodes by less than its size.
    pub fn least_distance(&self, point: [f64; 3]) -> f64 {
        let share = 1.0 / self.count as f64;
        let middle = self.nodes().iter().fold([0.0; 3], |sum, x| add(sum, share, *x));
        let far = self.nodes().iter().map(|x| length(minus(*x, middle))).fold(0.0, f64::max);
        length(minus(point, middle)) - 1.5 * far
    }

    /// Triangles take `(L_2, L_3)`, quadrangles `(ξ, η)` of `[−1, 1]²`.
    fn shapes(&self, [r, s]: [f64; 2]) -> Shapes {
        let mut found = [(0.0, [0.0; 2]); PORT_FACET_NODES];
        let of_node: &dyn Fn(usize) -> (f64, [f64; 2]) = match self.count {
            3 => &|node| linear(node, r, s),
            6 => &|node| quadratic(node, r, s),
            4 => &|node| bilinear(corner(node), r, s),
            8 => &|node| serendipity(node, r, s),
            _ => &|node| lagrange(place(node), r, s),
        };
        found.iter_mut().take(self.count).enumerate().for_each(|(node, to)| *to = of_node(node));
        found
    }

    /// The nearest place: the inner one where the distance is stationary, else one on an edge.
    pub fn nearest(&self, point: [f64; 3]) -> Nearest {
        let triangle = self.is_triangle();
        let middle = if triangle { [1.0 / 3.0; 2] } else { [0.0; 2] };
        let inside = |[r, s]: &[f64; 2]| match triangle {
            true => *r >= 0.0 && *s >= 0.0 && r + s <= 1.0,
            false => r.abs() <= 1.0 && s.abs() <= 1.0,
        };
        if let Some(found) = self.stationary(point, middle).filter(inside) {
            return self.at(point, found);
        }
        let [o, x, y] = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
        let [a, b, c, d] = CORNERS;
        let edges =
            if triangle { [[o, x], [x, y], [y, o], [o, x]] } else { [[a, b], [b, c], [c, d], [d, a]] };
        let mut best = self.at(point, middle);
        let mut found = false;
        for [from, to] in edges {
            let next = self.at(point, self.on_edge(point, from, to));
            if !found || next.distance < best.distance {
                (best, found) = (next, true);
            }
        }
        best
    }

    /// The point minus a place, and the tangents there.
    fn gap(&self, point: [f64; 3], shapes: &Shapes) -> ([f64; 3], [[f64; 3]; 2]) {
        let (mut gap, mut a, mut b) = (point, [0.0; 3], [0.0; 3]);
        for ((value, [r, s]), x) in shapes.iter().zip(self.nodes()) {
            gap = add(gap, -value, *x);
            a = add(a, *r, *x);
            b = add(b, *s, *x);
        }
        (gap, [a, b])
    }

    /// A place where the gap is normal to the facet, by Gauss and Newton's steps from the middle.
    fn stationary(&self, point: [f64; 3], mut at: [f64; 2]) -> Option<[f64; 2]> {
        for _ in 0..STEPS {
            let (gap, [a, b]) = self.gap(point, &self.shapes(at));
            let (aa, ab, bb) = (dot(a, a), dot(a, b), dot(b, b));
            let (ra, rb, determinant) = (dot(a, gap), dot(b, gap), aa * bb - ab * ab);
            let step = [(bb * ra - ab * rb) / determinant, (aa * rb - ab * ra) / determinant];
            if !step.iter().all(|x| x.is_finite()) {
                return None;
            }
            // Far outside of the facet its functions mean nothing.
            at = [(at[0] + step[0]).clamp(-3.0, 3.0), (at[1] + step[1]).clamp(-3.0, 3.0)];
            if step.iter().all(|x| x.abs() < 1e-14) {
                break;
            }
        }
        Some(at)
    }

    /// The nearest place of an edge of the reference facet.
    fn on_edge(&self, point: [f64; 3], from: [f64; 2], to: [f64; 2]) -> [f64; 2] {
        let along = [to[0] - from[0], to[1] - from[1]];
        let place = |t: f64| [from[0] + t * along[0], from[1] + t * along[1]];
        let mut t = 0.5;
        for _ in 0..STEPS {
            let (gap, [a, b]) = self.gap(point, &self.shapes(place(t)));
            let tangent = add(a.map(|a| along[0] * a), along[1], b);
            let next = t + dot(tangent, gap) / dot(tangent, tangent);
            if !next.is_finite() {
                break;
            }
            let next = next.clamp(0.0, 1.0);
            if (next - t).abs() < 1e-15 {
                break;
            }
            t = next;
        }
        place(t)
    }

    fn at(&self, point: [f64; 3], at: [f64; 2]) -> Nearest {
        let shapes = self.shapes(at);
        let (gap, _) = self.gap(point, &shapes);
        Nearest { weights: shapes.map(|(value, _)| value), distance: length(gap) }
    }
}

fn length(x: [f64; 3]) -> f64 {
    libm::sqrt(dot(x, x))
}

/// `L_node` and its slopes.
fn linear(node: usize, r: f64, s: f64) -> (f64, [f64; 2]) {
    match node {
        0 => (1.0 - r - s, [-1.0, -1.0]),
        1 => (r, [1.0, 0.0]),
        _ => (s, [0.0, 1.0]),
    }
}

fn quadratic(node: usize, r: f64, s: f64) -> (f64, [f64; 2]) {
    let (l, d) = linear(node % 3, r, s);
    if node < 3 {
        return (l * (2.0 * l - 1.0), d.map(|d| (4.0 * l - 1.0) * d));
    }
    let (m, e) = linear((node + 1) % 3, r, s);
    (4.0 * l * m, [4.0 * (m * d[0] + l * e[0]), 4.0 * (m * d[1] + l * e[1])])
}

fn corner(node: usize) -> [f64; 2] {
    CORNERS.get(node).copied().unwrap_or_default()
}

/// Place of a node of a quadrangle on the reference.
fn place(node: usize) -> [f64; 2] {
    match node {
        0..4 => corner(node),
        4 => [0.0, -1.0],
        5 => [1.0, 0.0],
        6 => [0.0, 1.0],
        7 => [-1.0, 0.0],
        _ => [0.0, 0.0],
    }
}

fn bilinear([x, y]: [f64; 2], r: f64, s: f64) -> (f64, [f64; 2]) {
    let (a, b) = (1.0 + x * r, 1.0 + y * s);
    (0.25 * a * b, [0.25 * x * b, 0.25 * y * a])
}

fn serendipity(node: usize, r: f64, s: f64) -> (f64, [f64; 2]) {
    let [x, y] = place(node);
    if node < 4 {
        let (value, [dr, ds]) = bilinear([x, y], r, s);
        let rest = x * r + y * s - 1.0;
        return (value * rest, [dr * rest + value * x, ds * rest + value * y]);
    }
    if x == 0.0 {
        let (bubble, along) = (1.0 - r * r, 1.0 + y * s);
        return (0.5 * bubble * along, [-r * along, 0.5 * bubble * y]);
    }
    let (bubble, along) = (1.0 - s * s, 1.0 + x * r);
    (0.5 * bubble * along, [0.5 * bubble * x, -s * along])
}

fn lagrange([x, y]: [f64; 2], r: f64, s: f64) -> (f64, [f64; 2]) {
    let line = |at: f64, t: f64| match at == 0.0 {
        true => (1.0 - t * t, -2.0 * t),
        false => (0.5 * t * (t + at), t + 0.5 * at),
    };
    let ((a, da), (b, db)) = (line(x, r), line(y, s));
    (a * b, [da * b, a * db])
}

#[cfg(test)]
mod tests {
    extern crate std;

    use super::*;
    use std::vec::Vec;

    /// A bent facet of each kind.
    fn facets() -> Vec<Facet> {
        let bend = |[r, s]: [f64; 2]| [2.0 * r + 0.1 * s, s - 0.2 * r, 0.1 * r * r + 0.05 * s];
        let triangle = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [0.5, 0.0], [0.5, 0.5], [0.0, 0.5]].map(bend);
        let square: Vec<[f64; 3]> = (0..9).map(|node| bend(place(node))).collect();
        let of = |places: &[[f64; 3]]| Facet::new(places).expect("a facet");
        [&triangle[..3], &triangle, &square[..4], &square[..8], &square].map(of).into()
    }

    #[test]
    fn functions_are_one_at_their_node_sum_to_one_and_have_the_slopes_of_differences() {
        for facet in facets() {
            let reference = |node: usize| match (facet.is_triangle(), node) {
                (true, _) => [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [0.5, 0.0], [0.5, 0.5], [0.0, 0.5]][node],
                (false, _) => place(node),
            };
            for node in 0..facet.count {
                for (other, (value, _)) in facet.shapes(reference(node)).iter().enumerate() {
                    let expected = f64::from(u8::from(other == node));
                    assert!((value - expected).abs() < 1e-15, "{} nodes: {node} {other}", facet.count);
                }
            }
            let (at, h) = ([0.21, 0.13], 1e-6);
            let shapes = facet.shapes(at);
            assert!((shapes.iter().map(|shape| shape.0).sum::<f64>() - 1.0).abs() < 1e-15);
            for k in 0..2 {
                let moved = |sign: f64| {
                    let mut at = at;
                    at[k] += sign * h;
                    facet.shapes(at)
                };
                let (up, down) = (moved(1.0), moved(-1.0));
                for node in 0..9 {
                    let slope = (up[node].0 - down[node].0) / (2.0 * h);
                    assert!((shapes[node].1[k] - slope).abs() < 1e-9, "{} nodes: {node}", facet.count);
                }
            }
        }
    }

    #[test]
    fn the_nearest_place_of_a_point_above_a_facet_is_below_it() {
        for facet in facets() {
            let shapes = facet.shapes([0.2, 0.3]);
            let (place, [a, b]) = facet.gap([0.0; 3], &shapes);
            let place = place.map(|x| -x);
            let normal = crate::base::vec3::cross(a, b);
            let point = add(place, 0.01 / length(normal), normal);
            let found = facet.nearest(point);
            assert!((found.distance - 0.01).abs() < 1e-12, "{} nodes: {found:?}", facet.count);
            let off = found.weights.iter().zip(shapes).map(|(a, (b, _))| (a - b).abs()).fold(0.0, f64::max);
            assert!(off < 1e-10, "{} nodes: {off:e}", facet.count);
            assert!(facet.least_distance(point) <= found.distance);
        }
    }

    #[test]
    fn beside_a_facet_a_corner_or_an_edge_is_nearest() {
        let places = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
        let facet = Facet::new(&places).expect("a facet");
        let found = facet.nearest([2.0, 2.0, 0.0]);
        assert!((found.distance - 2f64.sqrt()).abs() < 1e-14 && found.weights[2] == 1.0);
        let found = facet.nearest([0.25, -3.0, 4.0]);
        assert!((found.distance - 5.0).abs() < 1e-14 && (found.weights[0] - 0.75).abs() < 1e-14);
        assert!(Facet::new(&places[..2]).is_none());
        // A facet without area, and a point that is none, give some place and no panic.
        let line = Facet::new(&[[0.0; 3]; 4]).expect("a facet");
        assert_eq!(line.nearest([3.0, 0.0, 0.0]).distance, 3.0);
        assert!(line.nearest([f64::NAN; 3]).distance.is_nan());
    }
}
