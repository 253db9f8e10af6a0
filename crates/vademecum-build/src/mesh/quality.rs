//! Volume, shape quality and Jacobians of tetrahedra.

use super::kind::{EDGES, ElementKind};
use super::rules::mass_rule;
use super::shapes::{reference_nodes, tabulate};
use crate::linalg::vec3::{cross, dot, norm, sub};

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

/// Volume of an element, exact for both orders of tetrahedra (the Jacobian of a quadratic one is cubic) and
/// for others as long as their faces are planes.
pub(crate) fn element_volume(kind: ElementKind, nodes: &[[f64; 3]], element: &[u32]) -> f64 {
    match kind {
        ElementKind::Tet4 => corner_volume(corners(nodes, element)),
        ElementKind::Tet10 => {
            let p = ten(nodes, element);
            degree_4_rule().iter().map(|&(x, w)| w * jacobian_10(&p, x)).sum()
        }
        _ => volume_forms(kind, nodes, element).map(|(form, weight)| weight * form).sum(),
    }
}

/// Volume form and weight at each point that integrates the mass of an element.
pub(crate) fn volume_forms(
    kind: ElementKind,
    nodes: &[[f64; 3]],
    element: &[u32],
) -> impl Iterator<Item = (f64, f64)> {
    mass_rule(kind).into_iter().map(move |(at, weight)| {
        let point = tabulate(kind, at, weight);
        let mut columns = [[0.0; 3]; 3];
        for (slope, &node) in point.gradients.iter().zip(element) {
            let p = nodes[node as usize];
            for (column, slope) in columns.iter_mut().zip(slope) {
                column.iter_mut().zip(p).for_each(|(sum, x)| *sum += slope * x);
            }
        }
        (dot(columns[0], cross(columns[1], columns[2])), weight)
    })
}

/// Shape quality of an element on its corners: 1 at best, 0 without volume, negative inside out.
pub(crate) fn shape_quality(kind: ElementKind, nodes: &[[f64; 3]], element: &[u32]) -> f64 {
    if kind.is_tetrahedron() {
        return quality(corners(nodes, element));
    }
    let reference = reference_nodes(kind);
    // The volume of the three edges at a corner; four meet at the apex of a pyramid.
    let volume = |places: &dyn Fn(usize) -> [f64; 3], corner: usize| {
        let ends = kind.edges().iter().filter_map(|&[a, b]| match corner {
            _ if a == corner => Some(b),
            _ if b == corner => Some(a),
            _ => None,
        });
        let edges: Vec<[f64; 3]> = ends.map(|end| sub(places(end), places(corner))).collect();
        let [a, b, c] = edges[..] else { return None };
        Some((dot(a, cross(b, c)), norm(a) * norm(b) * norm(c)))
    };
    let of_corner = |corner: usize| {
        let sense = volume(&|i| reference[i], corner).map_or(1.0, |(volume, _)| volume.signum());
        match volume(&|i| nodes[element[i] as usize], corner) {
            None => f64::INFINITY,
            Some((volume, lengths)) if lengths > 0.0 => sense * volume / lengths,
            Some(_) => 0.0,
        }
    };
    (0..kind.corners()).map(of_corner).fold(f64::INFINITY, f64::min)
}

/// True if rounding decides on the sign of an element's volume.
pub(crate) fn is_flat(kind: ElementKind, nodes: &[[f64; 3]], element: &[u32]) -> bool {
    if kind.is_tetrahedron() {
        let p = corners(nodes, element);
        // A NaN, from coordinates beyond 1e100, counts as flat too.
        let q = quality(p).abs();
        return q.is_nan() || q <= flatness(p);
    }
    let places = element.iter().map(|&node| nodes[node as usize]);
    let size = places.clone().flatten().fold(0.0, |m: f64, x| m.max(x.abs()));
    let edge = places.map(|p| norm(sub(p, nodes[element[0] as usize]))).fold(0.0, f64::max);
    let volume = element_volume(kind, nodes, element).abs();
    let least = 16.0 * f64::EPSILON * (1.0 + size / edge) * edge * edge * edge;
    volume.is_nan() || volume <= least
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
