//! Finding points of the surface as it has moved, in the logarithm of its triangles: a tree of boxes in lent
//! memory.
//!
//! The triangles are put once in the order of a curve that fills space (Morton 1966), four to a leaf, and the
//! boxes of the leaves are joined in pairs. When the body moves, the boxes are fitted to it again and the
//! order stays, which is as good as long as the body keeps its shape roughly, and right in any case.

use crate::base::error::OutputError;
use crate::base::lend::{Lender, Short};
use crate::base::scalar::Scalar;
use crate::base::vec3::{cross, dot, minus};
use crate::sections::surface::{Surface, SurfacePoint, nearest_in_triangle};

/// Triangles of a leaf.
pub(crate) const LEAF: usize = 4;
/// Bits of a key and axis; three of them fit into 32.
const BITS: u32 = 10;
/// Nodes of the tree that wait at most: one for each level, and triangles are counted by 32 bits.
pub(crate) const WAITING: usize = 40;
/// So far outside of a triangle a ray still meets it, in weights: none passes between two of them.
const EDGE: f64 = 1e-9;

/// Memory to lend to a [`SurfaceTree`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TreeSizes {
    /// Of `u32`.
    pub order: usize,
    /// Of `f32`.
    pub boxes: usize,
}

/// A surface on the move, to be picked and touched.
///
/// ```
/// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/bound.rs"));
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// # bound!(BODY, Auto: file, sizes, scene, state, loads, work);
/// let surface = Surface::whole(&file)?;
/// let TreeSizes { order, boxes } = surface.tree_sizes();
/// let (mut order, mut boxes) = (vec![0; order], vec![0.0; boxes]);
/// let mut tree = SurfaceTree::new(&surface, &mut order, &mut boxes)?;
///
/// // In each frame: where the surface is, twenty times magnified, and what lies under the mouse.
/// let mut moved = vec![0.0; 3 * file.metadata().n_surface_nodes as usize];
/// scene.surface_into(&state, Field::Displacement, &mut moved)?;
/// tree.refit(&moved, 20.0)?;
/// let hit = tree.pick([0.01, 0.01, 5.0], [0.0, 0.0, -1.0]);
/// # assert!(hit.is_some());
/// # Ok(())
/// # }
/// ```
#[derive(Debug)]
pub struct SurfaceTree<'m> {
    surface: Surface<'m>,
    /// Triangles in the order of the curve.
    order: &'m mut [u32],
    /// Positions of the nodes \[m\], three numbers each.
    positions: &'m mut [f32],
    /// Lower and upper corner of each box; the two below box `i` are `2 i + 1` and `2 i + 2`.
    boxes: &'m mut [[f32; 6]],
}

/// A box around nothing.
const EMPTY: [f32; 6] =
    [f32::INFINITY, f32::INFINITY, f32::INFINITY, f32::NEG_INFINITY, f32::NEG_INFINITY, f32::NEG_INFINITY];

impl<'m> Surface<'m> {
    /// The memory that a [`SurfaceTree`] of this surface asks for.
    #[must_use]
    pub const fn tree_sizes(&self) -> TreeSizes {
        let n = self.n_triangles();
        let numbers = self.n_nodes().saturating_mul(3);
        TreeSizes { order: n.saturating_mul(4), boxes: numbers.saturating_add(n_boxes(n).saturating_mul(6)) }
    }
}

/// Boxes over `n` triangles.
pub(crate) const fn n_boxes(n: usize) -> usize {
    n.div_ceil(LEAF).saturating_mul(2).saturating_sub(1)
}

impl<'m> SurfaceTree<'m> {
    /// A tree over a surface at rest. `order` and `boxes` hold at least what [`Surface::tree_sizes`] says;
    /// what is in them does not matter. `O(n)`.
    ///
    /// # Errors
    /// [`OutputError::Length`]: too little memory.
    pub fn new(
        surface: &Surface<'m>,
        order: &'m mut [u32],
        boxes: &'m mut [f32],
    ) -> Result<Self, OutputError> {
        let (n, sizes) = (surface.n_triangles(), surface.tree_sizes());
        let short = |found, needed| OutputError::from(Short { found, needed });
        let found = [order.len(), boxes.len()];
        let order = order.get_mut(..sizes.order).ok_or(short(found[0], sizes.order))?;
        let boxes = boxes.get_mut(..sizes.boxes).ok_or(short(found[1], sizes.boxes))?;
        let mut boxes = Lender::new(boxes);
        let positions = boxes.take(3 * surface.n_nodes())?;
        let (boxes, _) = boxes.rest().as_chunks_mut();
        let mut keys = Lender::new(order);
        let (order, keys, mut spare) = (keys.take(n)?, keys.take(n)?, Lender::new(keys.rest()));
        let centre = |triangle: usize| -> Option<[f64; 3]> {
            let mut sum = [0.0; 3];
            for node in surface.triangle(triangle)? {
                for (k, x) in sum.iter_mut().enumerate() {
                    *x += surface.coordinate(3 * node as usize + k)? / 3.0;
                }
            }
            Some(sum)
        };
        sort_along_curve(centre, order, keys, spare.take(n)?, spare.take(n)?);
        let mut tree = Self { surface: *surface, order, positions, boxes };
        tree.refit::<f32>(&[], 0.0)?;
        Ok(tree)
    }

    /// Fits the tree to the surface as it has moved: `displacement` is what
    /// [`Scene::surface_into`](crate::Scene::surface_into) gives, `scale` how many times it is magnified in
    /// the picture. An empty displacement puts it back at rest. `O(n)`.
    ///
    /// # Errors
    /// [`OutputError::Length`]: not three numbers for each node.
    pub fn refit<T: Scalar>(&mut self, displacement: &[T], scale: f64) -> Result<(), OutputError> {
        let (found, needed) = (displacement.len(), self.positions.len());
        if !displacement.is_empty() && found < needed {
            return Err(OutputError::Length { found, needed });
        }
        for (i, position) in self.positions.iter_mut().enumerate() {
            let moved = displacement.get(i).map_or(0.0, |u| scale * u.to_f64());
            *position = (self.surface.coordinate(i).unwrap_or(f64::NAN) + moved) as f32;
        }
        let (surface, positions) = (&self.surface, &*self.positions);
        let leaves = self.order.len().div_ceil(LEAF);
        for (leaf, triangles) in self.order.chunks(LEAF).enumerate() {
            let mut around = EMPTY;
            for corner in triangles.iter().filter_map(|&t| corners(surface, positions, t)).flatten() {
                for (axis, x) in corner.into_iter().enumerate() {
                    let x = x as f32;
                    around[axis] = around[axis].min(x);
                    around[3 + axis] = around[3 + axis].max(x);
                }
            }
            if let Some(place) = self.boxes.get_mut(place_of_leaf(leaf, leaves)) {
                *place = around;
            }
        }
        for i in (0..leaves.saturating_sub(1)).rev() {
            let below = |k: usize| self.boxes.get(2 * i + k).copied().unwrap_or(EMPTY);
            let (a, b) = (below(1), below(2));
            if let Some(place) = self.boxes.get_mut(i) {
                *place = core::array::from_fn(|k| if k < 3 { a[k].min(b[k]) } else { a[k].max(b[k]) });
            }
        }
        Ok(())
    }

    /// The first point of the surface that a ray from `origin` meets, from either side of a triangle; its
    /// `distance` is along the ray \[m\]. `None` if it meets none, or has no direction.
    #[must_use]
    pub fn pick(&self, origin: [f64; 3], direction: [f64; 3]) -> Option<SurfacePoint> {
        let length = libm::sqrt(dot(direction, direction));
        let along = direction.map(|x| x / length);
        if !along.iter().chain(&origin).all(|x| x.is_finite()) {
            return None;
        }
        self.search(|around| entered(around, origin, along), |a, b, c| met(origin, along, a, b, c))
    }

    /// The nearest point of the surface, as it has moved, to `point` \[m\]; `None` if there is none, or the
    /// point is not finite.
    #[must_use]
    pub fn locate(&self, point: [f64; 3]) -> Option<SurfacePoint> {
        if !point.iter().all(|x| x.is_finite()) {
            return None;
        }
        let away = |around: &[f32; 6]| {
            let gap: [f64; 3] = core::array::from_fn(|k| {
                (f64::from(around[k]) - point[k]).max(point[k] - f64::from(around[3 + k])).max(0.0)
            });
            libm::sqrt(dot(gap, gap))
        };
        self.search(away, |a, b, c| {
            let weights = nearest_in_triangle(point, [a, b, c]);
            let gap = minus(point, weighted(weights, a, b, c));
            Some((weights, libm::sqrt(dot(gap, gap))))
        })
    }

    /// The point with the smallest distance: `bound` tells how near what is in a box may be, `measure`
    /// weights and distance of the best point of a triangle.
    fn search(
        &self,
        bound: impl Fn(&[f32; 6]) -> f64,
        measure: impl Fn([f64; 3], [f64; 3], [f64; 3]) -> Option<([f64; 3], f64)>,
    ) -> Option<SurfacePoint> {
        let leaves = self.order.len().div_ceil(LEAF);
        let limit = |i: usize| self.boxes.get(i).map_or(f64::INFINITY, &bound);
        let mut best = None;
        let mut reached = f64::INFINITY;
        let mut waiting = [(0, 0.0); WAITING];
        let mut count = 1_usize;
        waiting[0] = (0, limit(0));
        while let Some(&(i, nearest)) = count.checked_sub(1).and_then(|last| waiting.get(last)) {
            count -= 1;
            if nearest.is_nan() || nearest >= reached {
                continue;
            }
            if i + 1 < leaves {
                // The nearer one comes out first.
                let (left, right) = ((2 * i + 1, limit(2 * i + 1)), (2 * i + 2, limit(2 * i + 2)));
                let pair = if left.1 < right.1 { [right, left] } else { [left, right] };
                for child in pair {
                    if let Some(place) = waiting.get_mut(count) {
                        *place = child;
                        count += 1;
                    }
                }
                continue;
            }
            let first = LEAF * leaf_at(i, leaves);
            for &triangle in self.order.iter().skip(first).take(LEAF) {
                let Some([a, b, c]) = corners(&self.surface, self.positions, triangle) else { continue };
                let Some((weights, distance)) = measure(a, b, c) else { continue };
                let nodes = self.surface.triangle(triangle as usize);
                // Not a number is not below, and neither is infinity.
                if let Some(nodes) = nodes.filter(|_| distance < reached) {
                    reached = distance;
                    best = Some((triangle as usize, nodes, weights, weighted(weights, a, b, c)));
                }
            }
        }
        let (triangle, nodes, weights, position) = best?;
        let place = self.surface.place(triangle, nodes, weights);
        Some(SurfacePoint { place, position, distance: reached })
    }
}

/// Index of the box of a leaf: from left to right, the lowest level comes first.
pub(crate) const fn place_of_leaf(leaf: usize, leaves: usize) -> usize {
    let turned = leaf + leaves.next_power_of_two() - leaves;
    leaves - 1 + if turned < leaves { turned } else { turned - leaves }
}

/// The leaf whose box is there.
pub(crate) const fn leaf_at(place: usize, leaves: usize) -> usize {
    let turned = place + 1 + leaves - leaves.next_power_of_two();
    if turned < leaves { turned } else { turned - leaves }
}

fn weighted(weights: [f64; 3], a: [f64; 3], b: [f64; 3], c: [f64; 3]) -> [f64; 3] {
    core::array::from_fn(|k| weights[0] * a[k] + weights[1] * b[k] + weights[2] * c[k])
}

/// Corners of a triangle.
fn corners(surface: &Surface<'_>, positions: &[f32], triangle: u32) -> Option<[[f64; 3]; 3]> {
    let at = |node: u32| {
        let three = positions.as_chunks::<3>().0.get(node as usize)?;
        Some(three.map(f64::from)).filter(|at| at.iter().all(|x| x.is_finite()))
    };
    let [a, b, c] = surface.triangle(triangle as usize)?;
    Some([at(a)?, at(b)?, at(c)?])
}

/// Distance along a ray at which a box begins; infinite if the ray passes it.
fn entered(around: &[f32; 6], origin: [f64; 3], along: [f64; 3]) -> f64 {
    let (mut enters, mut leaves) = (0.0_f64, f64::INFINITY);
    for k in 0..3 {
        let [lower, upper] = [around[k], around[3 + k]].map(|x| f64::from(x) - origin[k]);
        if along[k] == 0.0 {
            // It runs beside the two sides, between them or not.
            if lower > 0.0 || upper < 0.0 {
                return f64::INFINITY;
            }
            continue;
        }
        let [lower, upper] = [lower, upper].map(|x| x / along[k]);
        enters = enters.max(lower.min(upper));
        leaves = leaves.min(lower.max(upper));
    }
    // A flat box is met where it is left; rounding must not make the two cross.
    if enters <= leaves * (1.0 + EDGE) { enters } else { f64::INFINITY }
}

/// Weights and distance of the point where a ray meets a triangle (Möller and Trumbore 1997).
fn met(origin: [f64; 3], along: [f64; 3], a: [f64; 3], b: [f64; 3], c: [f64; 3]) -> Option<([f64; 3], f64)> {
    let (ab, ac, from) = (minus(b, a), minus(c, a), minus(origin, a));
    let (p, q) = (cross(along, ac), cross(from, ab));
    let determinant = dot(ab, p);
    let [v, w, distance] = [dot(from, p), dot(along, q), dot(ac, q)].map(|x| x / determinant);
    let inside = v >= -EDGE && w >= -EDGE && v + w <= 1.0 + EDGE && distance >= 0.0;
    if !inside || !distance.is_finite() {
        return None;
    }
    let (v, w) = (v.max(0.0), w.max(0.0));
    let sum = (v + w).max(1.0);
    Some(([1.0 - (v + w) / sum, v / sum, w / sum], distance))
}

/// Sorts the triangles along the curve: their centres in a grid of `2^BITS` cells a side, the bits of the
/// three cell numbers interlaced, sorted byte by byte.
pub(crate) fn sort_along_curve(
    centre: impl Fn(usize) -> Option<[f64; 3]>,
    order: &mut [u32],
    keys: &mut [u32],
    other_order: &mut [u32],
    other_keys: &mut [u32],
) {
    let (mut lower, mut upper) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for at in (0..order.len()).filter_map(&centre) {
        for k in 0..3 {
            lower[k] = lower[k].min(at[k]);
            upper[k] = upper[k].max(at[k]);
        }
    }
    let size = (0..3).fold(0.0_f64, |size, k| size.max(upper[k] - lower[k]));
    let cells = f64::from(1_u32 << BITS);
    for (triangle, (place, key)) in order.iter_mut().zip(&mut *keys).enumerate() {
        *place = triangle as u32;
        let at = centre(triangle).unwrap_or(lower);
        // A cast to an integer stops at its ends, and makes 0 of what is no number.
        let cell = |k: usize| ((cells * (at[k] - lower[k]) / size) as u32).min((1 << BITS) - 1);
        let [x, y, z] = [cell(0), cell(1), cell(2)];
        *key = (0..BITS).fold(0, |key, bit| {
            let one = |cell: u32, axis: u32| ((cell >> bit) & 1) << (3 * bit + axis);
            key | one(x, 0) | one(y, 1) | one(z, 2)
        });
    }
    // Four passes: what is sorted comes back to where it was.
    for pass in 0..2 {
        by_byte(8 * (2 * pass), (order, keys), (other_order, other_keys));
        by_byte(8 * (2 * pass + 1), (other_order, other_keys), (order, keys));
    }
}

/// One pass of a radix sort, which keeps the order of equal bytes.
fn by_byte(shift: u32, from: (&[u32], &[u32]), to: (&mut [u32], &mut [u32])) {
    let byte = |key: u32| ((key >> shift) & 0xff) as u8;
    let mut next = [0_usize; 256];
    for &key in from.1 {
        next[byte(key) as usize] += 1;
    }
    let mut sum = 0;
    for place in &mut next {
        sum += core::mem::replace(place, sum);
    }
    for (&triangle, &key) in from.0.iter().zip(from.1) {
        let place = &mut next[byte(key) as usize];
        if let (Some(a), Some(b)) = (to.0.get_mut(*place), to.1.get_mut(*place)) {
            (*a, *b) = (triangle, key);
        }
        *place += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_leaf_has_a_place_of_its_own_at_the_end_of_the_boxes() {
        for leaves in 1..70 {
            let mut taken = [false; 70];
            for leaf in 0..leaves {
                let place = place_of_leaf(leaf, leaves);
                assert!((leaves - 1..2 * leaves - 1).contains(&place), "{leaf} of {leaves}");
                assert_eq!(leaf_at(place, leaves), leaf, "{leaves}");
                assert!(!core::mem::replace(&mut taken[leaf], true));
            }
        }
    }
}
