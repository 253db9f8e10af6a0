//! Volume, shape quality and Jacobians of tetrahedra.

use super::Order;
use crate::linalg::vec3::{cross, dot, norm, sub};

/// Edges of a tetrahedron, in the order of the mid-side nodes of [`Order::Quadratic`].
pub(crate) const EDGES: [[usize; 2]; 6] = [[0, 1], [1, 2], [2, 0], [0, 3], [1, 3], [2, 3]];

/// Faces of a positively oriented tetrahedron, seen from outside counter-clockwise.
pub(crate) const FACES: [[usize; 3]; 4] = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]];

/// Mid-side nodes of `FACES`, on its edges (0,1), (1,2), (2,0).
pub(crate) const FACE_MIDS: [[usize; 3]; 4] = [[6, 5, 4], [4, 8, 7], [5, 9, 8], [7, 9, 6]];

/// Signed volume of the tetrahedron on four corners, positive if the fourth lies where the right hand points.
pub(crate) fn corner_volume(p: [[f64; 3]; 4]) -> f64 {
    dot(sub(p[1], p[0]), cross(sub(p[2], p[0]), sub(p[3], p[0]))) / 6.0
}

/// Longest edge between four corners.
pub(crate) fn longest_edge(p: [[f64; 3]; 4]) -> f64 {
    EDGES.iter().map(|&[a, b]| norm(sub(p[a], p[b]))).fold(0.0, f64::max)
}

/// Shape quality q = 6√2 V / L³ with the longest edge L: 1 for the regular tetrahedron, 0 for a flat one,
/// negative for an inverted one.
pub(crate) fn quality(p: [[f64; 3]; 4]) -> f64 {
    let edge = longest_edge(p);
    if edge == 0.0 { 0.0 } else { 6.0 * std::f64::consts::SQRT_2 * corner_volume(p) / (edge * edge * edge) }
}

/// The |q| below which the sign of a volume is rounding.
///
/// Each coordinate of size `X` is rounded to `ε X`, an edge vector to `2√3 ε X`, so the determinant of three
/// edges to `3·2√3 ε X L²` and `q = √2 det/L³` to `15 ε X/L`; the arithmetic itself adds about as many `ε`.
pub(crate) fn flatness(p: [[f64; 3]; 4]) -> f64 {
    let size = p.iter().flatten().fold(0.0, |m: f64, x| m.max(x.abs()));
    16.0 * f64::EPSILON * (1.0 + size / longest_edge(p))
}

/// Points of the 11-point rule of degree 4 on the unit tetrahedron, with weights that sum to 1/6
/// (Keast 1986).
pub(crate) fn degree_4_rule() -> [([f64; 3], f64); 11] {
    let (a, b) = (1.0 / 14.0, 11.0 / 14.0);
    let root = (5.0_f64 / 14.0).sqrt();
    let (c, d) = ((1.0 + root) / 4.0, (1.0 - root) / 4.0);
    let (w0, w1, w2) = (-74.0 / 5625.0, 343.0 / 45000.0, 56.0 / 2250.0);
    [
        ([0.25, 0.25, 0.25], w0),
        ([a, a, a], w1),
        ([b, a, a], w1),
        ([a, b, a], w1),
        ([a, a, b], w1),
        ([c, c, d], w2),
        ([c, d, c], w2),
        ([d, c, c], w2),
        ([c, d, d], w2),
        ([d, c, d], w2),
        ([d, d, c], w2),
    ]
}

/// The 4-point rule of degree 2, which quadratic elements integrate their stiffness with.
pub(crate) fn degree_2_points() -> [[f64; 3]; 4] {
    let root = 5.0_f64.sqrt();
    let (a, b) = ((5.0 - root) / 20.0, (5.0 + 3.0 * root) / 20.0);
    [[a, a, a], [b, a, a], [a, b, a], [a, a, b]]
}

/// Determinant of the Jacobian of a 10-node tetrahedron at reference coordinates `x`.
pub fn jacobian_10(p: &[[f64; 3]; 10], x: [f64; 3]) -> f64 {
    let barycentric = [1.0 - x[0] - x[1] - x[2], x[0], x[1], x[2]];
    let slope = [[-1.0, -1.0, -1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let mut columns = [[0.0; 3]; 3];
    for (direction, column) in columns.iter_mut().enumerate() {
        let mut add = |node: usize, factor: f64| {
            for k in 0..3 {
                column[k] += factor * p[node][k];
            }
        };
        for corner in 0..4 {
            add(corner, (4.0 * barycentric[corner] - 1.0) * slope[corner][direction]);
        }
        for (edge, &[i, j]) in EDGES.iter().enumerate() {
            let factor = slope[i][direction] * barycentric[j] + barycentric[i] * slope[j][direction];
            add(4 + edge, 4.0 * factor);
        }
    }
    dot(columns[0], cross(columns[1], columns[2]))
}

/// Volume of an element, exact for both orders (the Jacobian of a quadratic one is cubic).
pub(crate) fn element_volume(order: Order, nodes: &[[f64; 3]], element: &[u32]) -> f64 {
    match order {
        Order::Linear => corner_volume(corners(nodes, element)),
        Order::Quadratic => {
            let p = ten(nodes, element);
            degree_4_rule().iter().map(|&(x, w)| w * jacobian_10(&p, x)).sum()
        }
    }
}

/// Corner positions of an element.
pub(crate) fn corners(nodes: &[[f64; 3]], element: &[u32]) -> [[f64; 3]; 4] {
    std::array::from_fn(|i| nodes[element[i] as usize])
}

/// Positions of the ten nodes of a quadratic element.
pub(crate) fn ten(nodes: &[[f64; 3]], element: &[u32]) -> [[f64; 3]; 10] {
    std::array::from_fn(|i| nodes[element[i] as usize])
}

#[cfg(test)]
mod tests {
    use super::*;

    const UNIT: [[f64; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

    #[test]
    fn the_regular_tetrahedron_has_quality_one() {
        let regular = [[1.0, 1.0, 1.0], [-1.0, 1.0, -1.0], [1.0, -1.0, -1.0], [-1.0, -1.0, 1.0]];
        // A dozen operations on numbers of size one.
        assert!((quality(regular).abs() - 1.0).abs() < 16.0 * f64::EPSILON);
    }

    #[test]
    fn faces_point_outwards_and_mids_lie_on_them() {
        for (face, mids) in FACES.iter().zip(FACE_MIDS) {
            let [a, b, c] = face.map(|i| UNIT[i]);
            let normal = cross(sub(b, a), sub(c, a));
            let centre = [0.25; 3];
            assert!(dot(normal, sub(a, centre)) > 0.0);
            for k in 0..3 {
                let mut edge = EDGES[mids[k] - 4];
                edge.sort_unstable();
                let mut wanted = [face[k], face[(k + 1) % 3]];
                wanted.sort_unstable();
                assert_eq!(edge, wanted);
            }
        }
    }

    #[test]
    fn a_straight_quadratic_element_has_the_jacobian_of_its_corners() {
        let mut p = [[0.0; 3]; 10];
        p[..4].copy_from_slice(&UNIT);
        for (edge, [i, j]) in EDGES.into_iter().enumerate() {
            p[4 + edge] = std::array::from_fn(|k| 0.5 * (UNIT[i][k] + UNIT[j][k]));
        }
        for (x, _) in degree_4_rule() {
            // Thirty products of numbers of size one to four.
            assert!((jacobian_10(&p, x) - 1.0).abs() < 128.0 * f64::EPSILON);
        }
        let weights: f64 = degree_4_rule().iter().map(|(_, w)| w).sum();
        assert!((weights - 1.0 / 6.0).abs() < 16.0 * f64::EPSILON);
    }
}
