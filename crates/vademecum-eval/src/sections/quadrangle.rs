//! Points of quadrangular facets: found by one of the facet's triangles, shared over its own nodes.
//!
//! A facet of four, eight or nine nodes has the shape functions `N_a(ξ, η)` on `[−1, 1]²` that its element
//! has there: bilinear, serendipity, biquadratic (Zienkiewicz and Taylor, *The Finite Element Method*,
//! vol. 1, §5). A force at a point falls to node `a` with the share `N_a`, which is its consistent load, and
//! the point moves by `Σ N_a u_a`. A triangle of the facet has nodes of it as corners, so `(ξ, η)` is linear
//! over the triangle and follows from the barycentric weights alone. On a flat facet whose nodes lie as those
//! of a parallelogram do, `Σ N_a x_a` is the point that was found; on others it lies beside it, as far as
//! facet and triangles differ.

use crate::sections::place::Place;
use vademecum_format::Quadrangle;

/// `(ξ, η)` of the nodes of a facet.
const NODES: [[f64; 2]; 9] = [
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

/// The point with these barycentric weights in a triangle of a facet, shared over the nodes of the facet;
/// `None` if the triangle has a corner that is no node of the facet.
pub(crate) fn place_in(facet: &Quadrangle, triangle: [u32; 3], weights: [f64; 3]) -> Option<Place> {
    let (mut x, mut y) = (0.0, 0.0);
    for (node, weight) in triangle.into_iter().zip(weights) {
        let index = facet.nodes().iter().position(|&other| other == node)?;
        let &[a, b] = NODES.get(index)?;
        x += weight * a;
        y += weight * b;
    }
    let n = facet.nodes().len();
    let shares = NODES.map(|node| share(n, node, [x, y]));
    Place::new(facet.nodes(), shares.get(..n)?).ok()
}

/// The shape function at `(x, y)` of the node at `(a, b)`, in a facet of `n` nodes.
fn share(n: usize, [a, b]: [f64; 2], [x, y]: [f64; 2]) -> f64 {
    let (along, across) = (1.0 + a * x, 1.0 + b * y);
    match n {
        9 => quadratic(a, x) * quadratic(b, y),
        8 if a == 0.0 => 0.5 * (1.0 - x * x) * across,
        8 if b == 0.0 => 0.5 * along * (1.0 - y * y),
        8 => 0.25 * along * across * (a * x + b * y - 1.0),
        _ => 0.25 * along * across,
    }
}

/// The quadratic function at `x` that is one at `a` and zero at the other two of −1, 0 and 1.
fn quadratic(a: f64, x: f64) -> f64 {
    if a == 0.0 { 1.0 - x * x } else { 0.5 * x * (x + a) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn functions_are_one_at_their_node_and_zero_at_others() {
        for n in [4, 8, 9] {
            for (a, &at) in NODES.iter().take(n).enumerate() {
                for (b, &node) in NODES.iter().take(n).enumerate() {
                    let expected = if a == b { 1.0 } else { 0.0 };
                    assert!((share(n, node, at) - expected).abs() < 1e-15, "{n}: {b} at {a}");
                }
            }
        }
    }

    #[test]
    fn functions_sum_to_one_and_keep_lines() {
        for n in [4, 8, 9] {
            for [x, y] in [[0.3, -0.7], [-1.0, 0.25], [0.0, 0.0], [0.99, 1.0]] {
                let nodes = || NODES.iter().take(n);
                let sum = |of: fn(&[f64; 2]) -> f64| -> f64 {
                    nodes().map(|node| of(node) * share(n, *node, [x, y])).sum()
                };
                assert!((sum(|_| 1.0) - 1.0).abs() < 1e-15);
                assert!((sum(|node| node[0]) - x).abs() < 1e-15 && (sum(|node| node[1]) - y).abs() < 1e-15);
            }
        }
    }
}
