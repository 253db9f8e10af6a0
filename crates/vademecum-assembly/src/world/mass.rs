//! Mass, centre and moments of inertia of a body that a closed surface encloses.

use std::collections::HashMap;

use faer::Mat;
use vademecum_build::linalg::symmetric_eigen;
use vademecum_build::linalg::vec3::{cross, dot, sub};
use vademecum_eval::RigidBody;

/// True if every edge of the triangles is that of one other triangle that turns the other way.
pub(crate) fn is_closed(triangles: &[[u32; 3]]) -> bool {
    let mut edges: HashMap<[u32; 2], i64> = HashMap::new();
    for [a, b, c] in triangles {
        for [from, to] in [[*a, *b], [*b, *c], [*c, *a]] {
            *edges.entry([from.min(to), from.max(to)]).or_default() += if from < to { 1 } else { -1 };
        }
    }
    edges.values().all(|&sum| sum == 0)
}

/// The body of this density within a closed surface whose triangles turn counterclockwise from outside;
/// `None` of one that encloses nothing.
pub(crate) fn solid(nodes: &[[f64; 3]], triangles: &[[u32; 3]], density: f64) -> Option<RigidBody> {
    let middle = *nodes.first()?;
    let (mut volume, mut first, mut second) = (0.0, [0.0; 3], [[0.0; 3]; 3]);
    for triangle in triangles {
        let corners = triangle.map(|node| sub(nodes[node as usize], middle));
        let [a, b, c] = corners;
        // A tetrahedron from the first node, with `s = a + b + c`:
        // `∫ x xᵀ = v/20 (s sᵀ + a aᵀ + b bᵀ + c cᵀ)`.
        let own = dot(a, cross(b, c)) / 6.0;
        let sum: [f64; 3] = std::array::from_fn(|k| a[k] + b[k] + c[k]);
        volume += own;
        for i in 0..3 {
            first[i] += 0.25 * own * sum[i];
            for j in 0..3 {
                let each: f64 = corners.iter().map(|x| x[i] * x[j]).sum();
                second[i][j] += own / 20.0 * (sum[i] * sum[j] + each);
            }
        }
    }
    if !(volume > 0.0 && volume.is_finite()) {
        return None;
    }
    let centre = first.map(|x| x / volume);
    let about = |i: usize, j: usize| density * (second[i][j] - volume * centre[i] * centre[j]);
    let trace: f64 = (0..3).map(|k| about(k, k)).sum();
    let inertia = Mat::from_fn(3, 3, |i, j| if i == j { trace } else { 0.0 } - about(i, j));
    let (moments, axes) = symmetric_eigen(inertia.as_ref()).ok()?;
    let moments = [moments[0], moments[1], moments[2]];
    let sound = moments.iter().all(|moment| *moment > 0.0 && moment.is_finite());
    sound.then(|| RigidBody {
        mass: density * volume,
        centre: std::array::from_fn(|k| middle[k] + centre[k]),
        moments,
        axes: std::array::from_fn(|k| std::array::from_fn(|c| axes[(c, k)])),
        first_pattern: 0,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::block::block;

    #[test]
    fn a_box_has_its_mass_centre_and_moments() {
        let (nodes, triangles) = block([0.1, 0.2, 0.3]);
        assert!(is_closed(&triangles) && !is_closed(&triangles[1..]));
        let body = solid(&nodes, &triangles, 1000.0).expect("a body");
        assert!((body.mass - 6.0).abs() < 1e-12, "{}", body.mass);
        for (found, expected) in body.centre.into_iter().zip([0.05, 0.1, 0.15]) {
            assert!((found - expected).abs() < 1e-15, "{found}");
        }
        // `m/12 (b² + c²)`, ascending.
        let expected = [0.5 * (0.01 + 0.04), 0.5 * (0.01 + 0.09), 0.5 * (0.04 + 0.09)];
        for (found, expected) in body.moments.into_iter().zip(expected) {
            assert!((found / expected - 1.0).abs() < 1e-12, "{found}");
        }
        let inside_out: Vec<[u32; 3]> = triangles.iter().map(|[a, b, c]| [*a, *c, *b]).collect();
        assert!(solid(&nodes, &inside_out, 1000.0).is_none());
    }
}
