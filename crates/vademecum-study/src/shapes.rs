//! Shapes for pictures: modes as displaced surfaces, and how good the triangles of a surface are.

use crate::contents::Geometry;

/// The largest displacement of a drawn mode, as a share of the body's size.
const DRAWN: f64 = 0.1;

/// A mode as it is drawn.
pub struct ModeShape {
    /// Places of the nodes, the largest displacement a tenth of the body's size \[m\].
    pub nodes: Vec<[f64; 3]>,
    /// Size of the displacement of each node of the surface, 1 at most.
    pub values: Vec<f64>,
}

/// The shape of mode `k` of `r`, from the basis of the surface, shape (n_surface_nodes, 3, r).
#[must_use]
pub fn mode_shape(geometry: &Geometry, basis: &[f64], (k, r): (usize, usize)) -> ModeShape {
    let moved = |node: usize| [0, 1, 2].map(|c| basis.get((3 * node + c) * r + k).copied().unwrap_or(0.0));
    let lengths: Vec<f64> = (0..basis.len() / (3 * r).max(1)).map(|node| length(moved(node))).collect();
    let largest = lengths.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
    let scale = DRAWN * size(&geometry.nodes) / largest;
    let drawn = geometry.nodes.iter().enumerate().map(|(node, x)| {
        let u = moved(node);
        std::array::from_fn(|c| x[c] + scale * u[c])
    });
    ModeShape { nodes: drawn.collect(), values: lengths.iter().map(|length| length / largest).collect() }
}

/// Smallest angle of each triangle of the surface \[degrees\], ascending; 60 at best.
#[must_use]
pub fn smallest_angles(Geometry { nodes, triangles }: &Geometry) -> Vec<f64> {
    let smallest = |t: &[u32; 3]| {
        let corners = t.map(|node| nodes.get(node as usize).copied().unwrap_or_default());
        let side = |i: usize, j: usize| length([0, 1, 2].map(|c| corners[i][c] - corners[j][c]));
        let [a, b, c] = [side(1, 2), side(2, 0), side(0, 1)];
        let angle =
            |a: f64, b: f64, c: f64| ((b * b + c * c - a * a) / (2.0 * b * c)).clamp(-1.0, 1.0).acos();
        angle(a, b, c).min(angle(b, c, a)).min(angle(c, a, b)).to_degrees()
    };
    let mut angles: Vec<f64> = triangles.iter().map(smallest).filter(|angle| angle.is_finite()).collect();
    angles.sort_by(f64::total_cmp);
    angles
}

fn length(x: [f64; 3]) -> f64 {
    x.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// Diagonal of the box around some nodes.
fn size(nodes: &[[f64; 3]]) -> f64 {
    let extent = |c: usize| {
        let [low, high] = nodes.iter().fold([f64::MAX, f64::MIN], |[a, b], x| [a.min(x[c]), b.max(x[c])]);
        high - low
    };
    length([0, 1, 2].map(extent))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn corner() -> Geometry {
        let nodes = vec![[0.0; 3], [3.0, 0.0, 0.0], [0.0, 4.0, 0.0]];
        Geometry { nodes, triangles: vec![[0, 1, 2]] }
    }

    #[test]
    fn a_mode_is_drawn_as_large_as_a_tenth_of_the_body() {
        // Two modes of three nodes; the second moves the last node along z.
        let mut basis = vec![0.0; 18];
        basis[(3 * 2 + 2) * 2 + 1] = 7.0;
        let shape = mode_shape(&corner(), &basis, (1, 2));
        assert_eq!(shape.values, [0.0, 0.0, 1.0]);
        assert!((shape.nodes[2][2] - 0.5).abs() < 1e-12 && shape.nodes[1] == [3.0, 0.0, 0.0]);
    }

    #[test]
    fn the_smallest_angle_is_opposite_the_shortest_side() {
        let angles = smallest_angles(&corner());
        assert!((angles[0] - (3.0_f64 / 4.0).atan().to_degrees()).abs() < 1e-9, "{angles:?}");
    }
}
