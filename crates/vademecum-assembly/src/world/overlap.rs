//! Overlap of two bodies at the start of a world.

use vademecum_build::linalg::vec3::{cross, dot, norm, sub};
use vademecum_eval::nearest_in_triangle;

/// Depth that rounding of coordinates leaves, as a share of the smaller body.
const ROUNDING: f64 = 1e-6;

/// A closed surface in space.
pub(crate) struct Skin<'a> {
    pub nodes: Vec<[f64; 3]>,
    pub triangles: &'a [[u32; 3]],
}

impl Skin<'_> {
    fn corners(&self) -> [[f64; 3]; 2] {
        let start = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
        self.nodes.iter().fold(start, |[low, high], node| {
            [std::array::from_fn(|k| low[k].min(node[k])), std::array::from_fn(|k| high[k].max(node[k]))]
        })
    }

    /// Diagonal of its box \[m\].
    pub fn size(&self) -> f64 {
        let [low, high] = self.corners();
        norm(sub(high, low))
    }

    fn triangles(&self) -> impl Iterator<Item = [[f64; 3]; 3]> {
        self.triangles.iter().map(|nodes| nodes.map(|node| self.nodes[node as usize]))
    }

    /// True of a point inside, by the winding number of the surface around it.
    fn holds(&self, point: [f64; 3]) -> bool {
        let angle = |corners: [[f64; 3]; 3]| {
            let [a, b, c] = corners.map(|corner| sub(corner, point));
            let [x, y, z] = [a, b, c].map(norm);
            let below = x * y * z + dot(a, b) * z + dot(b, c) * x + dot(c, a) * y;
            2.0 * dot(a, cross(b, c)).atan2(below)
        };
        self.triangles().map(angle).sum::<f64>() > std::f64::consts::TAU
    }

    /// Distance of a point from the surface \[m\], and the nearest point.
    pub fn nearest(&self, point: [f64; 3]) -> (f64, [f64; 3]) {
        let near = |corners: [[f64; 3]; 3]| {
            let weights = nearest_in_triangle(point, corners);
            let at = std::array::from_fn(|k| (0..3).map(|i| weights[i] * corners[i][k]).sum());
            (norm(sub(point, at)), at)
        };
        let start = (f64::INFINITY, point);
        self.triangles().map(near).fold(start, |best, found| if found.0 < best.0 { found } else { best })
    }
}

/// Depth \[m\] of the deepest node of one of two bodies in the other; `None` if they are apart or touch.
pub(crate) fn overlap(a: &Skin<'_>, b: &Skin<'_>) -> Option<f64> {
    let least = ROUNDING * a.size().min(b.size());
    let deepest = [(a, b), (b, a)].into_iter().map(|(nodes, surface)| depth(nodes, surface, least));
    Some(deepest.fold(0.0, f64::max)).filter(|depth| *depth > least)
}

/// Depth of the deepest node in a surface, of those that are deeper than `least`.
fn depth(of: &Skin<'_>, surface: &Skin<'_>, least: f64) -> f64 {
    let [low, high] = surface.corners();
    let inside = |node: &&[f64; 3]| (0..3).all(|k| node[k] > low[k] + least && node[k] < high[k] - least);
    let depths = of.nodes.iter().filter(inside).map(|node| {
        let (distance, _) = surface.nearest(*node);
        if distance > least && surface.holds(*node) { distance } else { 0.0 }
    });
    depths.fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::block::block;

    #[test]
    fn blocks_that_touch_do_not_overlap_and_their_depth_is_found() {
        let (nodes, triangles) = block([1.0, 1.0, 1.0]);
        let at = |by: [f64; 3]| Skin {
            nodes: nodes.iter().map(|node| std::array::from_fn(|k| node[k] + by[k])).collect(),
            triangles: &triangles,
        };
        assert_eq!(overlap(&at([0.0; 3]), &at([0.2, 0.2, 1.0])), None);
        assert_eq!(overlap(&at([0.0; 3]), &at([3.0, 0.0, 0.0])), None);
        let depth = overlap(&at([0.0; 3]), &at([0.2, 0.3, 0.9])).expect("an overlap");
        assert!((depth - 0.1).abs() < 1e-12, "{depth}");
    }
}
