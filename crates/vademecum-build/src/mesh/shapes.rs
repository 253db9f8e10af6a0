//! Shape functions of every kind of element, with their derivatives.
//!
//! Reference elements: hexahedra on `[−1, 1]³`; wedges on the triangle `ξ, η ≥ 0, ξ + η ≤ 1` times `[−1, 1]`;
//! pyramids on the base `[−1, 1]²` at `ζ = 0` with the apex at `ζ = 1`; tetrahedra by three of their
//! barycentric coordinates. Sources: Zienkiewicz and Taylor, *The Finite Element Method*, vol. 1, §5
//! (serendipity and Lagrangian families); Bedrosian (1992) for pyramids, whose functions are rational.

use std::ops::{Add, Div, Mul, Sub};

use super::kind::{EDGES, ElementKind, FacetKind};
use super::order::Order;

/// Most nodes of an element.
pub(crate) const MAX_NODES: usize = 27;

/// Most nodes of a tetrahedron.
pub(crate) const TET_NODES: usize = 10;

/// Shape functions at one quadrature point.
#[derive(Clone)]
pub(crate) struct Point {
    pub(crate) weight: f64,
    pub(crate) values: [f64; MAX_NODES],
    /// Derivatives along the reference axes `ξ = L_1, η = L_2, ζ = L_3`.
    pub(crate) gradients: [[f64; 3]; MAX_NODES],
}

impl Point {
    /// Its place in an element.
    pub(crate) fn place(&self, nodes: &[[f64; 3]]) -> [f64; 3] {
        let mut place = [0.0; 3];
        for (value, node) in self.values.iter().zip(nodes) {
            (0..3).for_each(|c| place[c] += value * node[c]);
        }
        place
    }
}

/// Corners of the reference hexahedron; the first four are those of the base of a pyramid.
pub(crate) const CORNERS: [[f64; 3]; 8] = [
    [-1.0, -1.0, -1.0],
    [1.0, -1.0, -1.0],
    [1.0, 1.0, -1.0],
    [-1.0, 1.0, -1.0],
    [-1.0, -1.0, 1.0],
    [1.0, -1.0, 1.0],
    [1.0, 1.0, 1.0],
    [-1.0, 1.0, 1.0],
];

/// Outward axis of the faces whose middles are the nodes 20 to 25 of a 27-node hexahedron.
const FACE_MIDDLES: [[f64; 3]; 6] =
    [[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0], [0.0, 0.0, 1.0]];

/// Distance from the apex of a pyramid at which its own gradients are taken: they have no value at it.
const BELOW_APEX: f64 = 1e-6;

/// A number with its derivatives along three reference axes.
#[derive(Clone, Copy)]
struct Dual {
    value: f64,
    slope: [f64; 3],
}

impl Dual {
    fn constant(value: f64) -> Self {
        Self { value, slope: [0.0; 3] }
    }

    fn zip(self, other: Self, value: f64, slope: impl Fn(f64, f64) -> f64) -> Self {
        Self { value, slope: std::array::from_fn(|i| slope(self.slope[i], other.slope[i])) }
    }
}

impl Dual {
    fn times(self, b: Self) -> Self {
        self.zip(b, self.value * b.value, |x, y| x * b.value + self.value * y)
    }

    fn over(self, b: Self) -> Self {
        let value = self.value / b.value;
        self.zip(b, value, |x, y| (x - value * y) / b.value)
    }
}

impl Add for Dual {
    type Output = Self;
    fn add(self, b: Self) -> Self {
        self.zip(b, self.value + b.value, |x, y| x + y)
    }
}

impl Sub for Dual {
    type Output = Self;
    fn sub(self, b: Self) -> Self {
        self.zip(b, self.value - b.value, |x, y| x - y)
    }
}

impl Mul for Dual {
    type Output = Self;
    fn mul(self, b: Self) -> Self {
        self.times(b)
    }
}

impl Div for Dual {
    type Output = Self;
    fn div(self, b: Self) -> Self {
        self.over(b)
    }
}

impl Mul<Dual> for f64 {
    type Output = Dual;
    fn mul(self, b: Dual) -> Dual {
        Dual::constant(self) * b
    }
}

/// The reference coordinates of the nodes of an element.
pub(crate) fn reference_nodes(kind: ElementKind) -> Vec<[f64; 3]> {
    let corners: Vec<[f64; 3]> = match kind {
        ElementKind::Tet4 | ElementKind::Tet10 => {
            vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
        }
        ElementKind::Pyramid5 | ElementKind::Pyramid13 => {
            let base = CORNERS[..4].iter().map(|&[x, y, _]| [x, y, 0.0]);
            base.chain([[0.0, 0.0, 1.0]]).collect()
        }
        ElementKind::Wedge6 | ElementKind::Wedge15 => [-1.0, 1.0]
            .into_iter()
            .flat_map(|z| [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]].map(|[x, y]| [x, y, z]))
            .collect(),
        ElementKind::Hex8 | ElementKind::Hex20 | ElementKind::Hex27 => CORNERS.to_vec(),
    };
    let middle = |&[a, b]: &[usize; 2]| std::array::from_fn(|i| 0.5 * (corners[a][i] + corners[b][i]));
    let middles: Vec<[f64; 3]> = match kind.order() {
        Order::Linear => vec![],
        Order::Quadratic => kind.edges().iter().map(middle).collect(),
    };
    let mut nodes = corners;
    nodes.extend(middles);
    if kind == ElementKind::Hex27 {
        nodes.extend(FACE_MIDDLES);
        nodes.push([0.0; 3]);
    }
    nodes
}

/// Shape functions and their derivatives at a place of the reference element.
pub(crate) fn tabulate(kind: ElementKind, at: [f64; 3], weight: f64) -> Point {
    if kind.is_tetrahedron() {
        let [x, y, z] = at;
        return tabulate_point(kind.order(), [1.0 - x - y - z, x, y, z], weight);
    }
    let mut at = at;
    if matches!(kind, ElementKind::Pyramid5 | ElementKind::Pyramid13) {
        at[2] = at[2].min(1.0 - BELOW_APEX);
    }
    let axis = |i: usize| Dual { value: at[i], slope: std::array::from_fn(|k| f64::from(u8::from(k == i))) };
    let functions = functions(kind, [axis(0), axis(1), axis(2)]);
    let mut point = Point { weight, values: [0.0; MAX_NODES], gradients: [[0.0; 3]; MAX_NODES] };
    for (a, function) in functions.into_iter().enumerate() {
        (point.values[a], point.gradients[a]) = (function.value, function.slope);
    }
    point
}

fn functions(kind: ElementKind, at: [Dual; 3]) -> Vec<Dual> {
    let nodes = reference_nodes(kind);
    let one = Dual::constant(1.0);
    let [x, y, z] = at;
    match kind {
        ElementKind::Tet4 | ElementKind::Tet10 => vec![],
        ElementKind::Hex8 => nodes.iter().map(|node| 0.125 * product(node, at)).collect(),
        ElementKind::Hex20 => nodes
            .iter()
            .map(|node| match (0..3).find(|&i| node[i] == 0.0) {
                None => {
                    let sum = node[0] * x + node[1] * y + node[2] * z;
                    0.125 * product(node, at) * (sum - Dual::constant(2.0))
                }
                Some(i) => 0.25 * product(node, at) * (one - at[i] * at[i]),
            })
            .collect(),
        ElementKind::Hex27 => nodes
            .iter()
            .map(|node| {
                let along = |i: usize| {
                    if node[i] == 0.0 {
                        one - at[i] * at[i]
                    } else {
                        0.5 * at[i] * (at[i] + Dual::constant(node[i]))
                    }
                };
                along(0) * along(1) * along(2)
            })
            .collect(),
        ElementKind::Wedge6 | ElementKind::Wedge15 => wedge(kind, [one - x - y, x, y], z),
        ElementKind::Pyramid5 | ElementKind::Pyramid13 => pyramid(kind, &nodes, at),
    }
}

/// `(1 + ξ_a ξ)(1 + η_a η)(1 + ζ_a ζ)`.
fn product(node: &[f64; 3], at: [Dual; 3]) -> Dual {
    let along = |i: usize| Dual::constant(1.0) + node[i] * at[i];
    along(0) * along(1) * along(2)
}

fn wedge(kind: ElementKind, l: [Dual; 3], z: Dual) -> Vec<Dual> {
    let one = Dual::constant(1.0);
    let half = |side: f64| 0.5 * (one + side * z);
    let bubble = one - z * z;
    let sides = [-1.0, 1.0];
    if kind == ElementKind::Wedge6 {
        return sides.into_iter().flat_map(|side| l.map(|l| l * half(side))).collect();
    }
    let corner = |l: Dual, side: f64| l * (2.0 * l - one) * half(side) - 0.5 * l * bubble;
    let edge = |i: usize, side: f64| 4.0 * l[i] * l[(i + 1) % 3] * half(side);
    let corners = sides.into_iter().flat_map(|side| l.map(|l| corner(l, side)));
    let edges = sides.into_iter().flat_map(|side| [0, 1, 2].map(|i| edge(i, side)));
    corners.chain(edges).chain(l.map(|l| l * bubble)).collect()
}

fn pyramid(kind: ElementKind, nodes: &[[f64; 3]], [x, y, z]: [Dual; 3]) -> Vec<Dual> {
    let one = Dual::constant(1.0);
    let down = one - z;
    let corner = |node: &[f64; 3]| {
        let [a, b, _] = *node;
        (one + a * x) * (one + b * y) - z + (a * b) * x * y * z / down
    };
    if kind == ElementKind::Pyramid5 {
        return nodes[..4].iter().map(|node| 0.25 * corner(node)).chain([z]).collect();
    }
    let corners = nodes[..4].iter().map(|node| 0.25 * (node[0] * x + node[1] * y - one) * corner(node));
    let apex = z * (2.0 * z - one);
    let base = nodes[5..9].iter().map(|node| {
        // Along the edge, and across it.
        let (along, across, side) = if node[0] == 0.0 { (x, y, node[1]) } else { (y, x, node[0]) };
        0.5 * (down + along) * (down - along) * (down + side * across) / down
    });
    let rising = nodes[..4].iter().map(|node| z * (down + node[0] * x) * (down + node[1] * y) / down);
    corners.chain([apex]).chain(base).chain(rising).collect()
}

/// Shape functions and their reference derivatives at barycentric coordinates `l`.
pub(crate) fn tabulate_point(order: Order, l: [f64; 4], weight: f64) -> Point {
    // ∇L_0 … ∇L_3 along (ξ, η, ζ).
    const D: [[f64; 3]; 4] = [[-1.0, -1.0, -1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let mut point = Point { weight, values: [0.0; MAX_NODES], gradients: [[0.0; 3]; MAX_NODES] };
    for a in 0..4 {
        let (value, slope) = match order {
            Order::Linear => (l[a], 1.0),
            Order::Quadratic => (l[a] * (2.0 * l[a] - 1.0), 4.0 * l[a] - 1.0),
        };
        point.values[a] = value;
        point.gradients[a] = D[a].map(|d| slope * d);
    }
    if order == Order::Quadratic {
        for (e, &[a, b]) in EDGES.iter().enumerate() {
            point.values[4 + e] = 4.0 * l[a] * l[b];
            point.gradients[4 + e] = std::array::from_fn(|r| 4.0 * (l[b] * D[a][r] + l[a] * D[b][r]));
        }
    }
    point
}

/// Values of the shape functions of a quadrangular facet at `(ξ, η)` of `[−1, 1]²`, and their derivatives.
pub(crate) fn quadrangle_shapes(kind: FacetKind, x: f64, y: f64) -> (Vec<f64>, Vec<[f64; 2]>) {
    // The functions of a hexahedron's face are those of the face alone.
    let (solid, face) = match kind {
        FacetKind::Quad8 => (ElementKind::Hex20, 1),
        FacetKind::Quad9 => (ElementKind::Hex27, 1),
        _ => (ElementKind::Hex8, 1),
    };
    let point = tabulate(solid, [x, y, 1.0], 1.0);
    let nodes = solid.faces()[face].1;
    let slopes = nodes.iter().map(|&a| [point.gradients[a][0], point.gradients[a][1]]).collect();
    (nodes.iter().map(|&a| point.values[a]).collect(), slopes)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A place inside of every reference element.
    const INSIDE: [f64; 3] = [0.21, 0.13, 0.37];

    #[test]
    fn functions_are_one_at_their_node_and_zero_at_others() {
        for kind in ElementKind::all() {
            let nodes = reference_nodes(kind);
            assert_eq!(nodes.len(), kind.nodes());
            for (a, &node) in nodes.iter().enumerate() {
                let point = tabulate(kind, node, 1.0);
                for b in 0..nodes.len() {
                    let expected = f64::from(u8::from(a == b));
                    // A pyramid's values are taken a millionth below its apex.
                    assert!((point.values[b] - expected).abs() < 1e-5, "{kind:?} {a} {b}");
                }
            }
        }
    }

    #[test]
    fn functions_reproduce_polynomials_of_their_order_and_derivatives_are_those_of_differences() {
        for kind in ElementKind::all() {
            let nodes = reference_nodes(kind);
            let point = tabulate(kind, INSIDE, 1.0);
            let [x, y, z] = INSIDE;
            let monomials: &[&dyn Fn([f64; 3]) -> f64] =
                &[&|_| 1.0, &|p| p[0], &|p| p[1], &|p| p[2], &|p| p[0] * p[1], &|p| p[2] * p[2], &|p| {
                    p[0] * p[2]
                }];
            let exact = if kind.order() == Order::Quadratic { monomials.len() } else { 4 };
            for monomial in &monomials[..exact] {
                let found: f64 = nodes.iter().zip(&point.values).map(|(&node, n)| n * monomial(node)).sum();
                assert!((found - monomial([x, y, z])).abs() < 1e-14, "{kind:?}");
            }
            let step = 1e-6;
            for i in 0..3 {
                let moved = |side: f64| {
                    let mut at = INSIDE;
                    at[i] += side * step;
                    tabulate(kind, at, 1.0).values
                };
                let (up, down) = (moved(1.0), moved(-1.0));
                for a in 0..nodes.len() {
                    let difference = (up[a] - down[a]) / (2.0 * step);
                    assert!((point.gradients[a][i] - difference).abs() < 1e-8, "{kind:?} {a} {i}");
                }
            }
        }
    }
}
