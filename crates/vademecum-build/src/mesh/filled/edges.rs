//! Sharp edges and corners of a surface: nodes of the boundary near them move onto them.
//!
//! A lattice cuts off what lies between its points. The nearest node of each corner moves there, then the
//! nodes close to an edge move onto it, each as far as its tetrahedra stay well shaped.

use std::collections::{HashMap, HashSet};

use super::lattice::Filled;
use super::winding::Point;
use crate::linalg::vec3::{cross, dot, norm, sub};
use crate::mesh::FACES;
use crate::mesh::quality::{corner_volume, quality};

/// Cosine between the normals of two triangles whose common edge is sharp.
const SHARP: f64 = 0.8;
/// Reach of an edge and of a corner, in sides of a cube.
const NEAR_EDGE: f64 = 0.75;
const NEAR_CORNER: f64 = 1.0;
/// Qualities of tetrahedra below which a node stays, at first and for what is left.
const QUALITIES: [f64; 2] = [0.15, 0.05];
/// Least change of the volume by a node that moves onto an edge, in cubes.
const GAIN: f64 = 1e-4;

/// Sharp edges and corners.
pub(super) struct Edges {
    segments: Vec<[Point; 2]>,
    corners: Vec<Point>,
}

impl Edges {
    /// Those of triangles whose corners are numbered.
    pub(super) fn of(corners: &[[Point; 3]], numbers: &[[u32; 3]]) -> Self {
        let mut sides: HashMap<(u32, u32), Vec<usize>> = HashMap::new();
        for (at, t) in numbers.iter().enumerate() {
            for (a, b) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])].into_iter().filter(|(a, b)| a != b) {
                sides.entry((a.min(b), a.max(b))).or_default().push(at);
            }
        }
        let normal = |at: usize| {
            let [a, b, c] = corners[at];
            let n = cross(sub(b, a), sub(c, a));
            let length = norm(n);
            n.map(|x| x / length)
        };
        let place = |at: usize, number: u32| {
            let k = (0..3).find(|&k| numbers[at][k] == number).unwrap_or(0);
            corners[at][k]
        };
        let mut found: Vec<((u32, u32), [Point; 2])> = sides
            .iter()
            .filter(|(_, triangles)| matches!(triangles[..], [a, b] if dot(normal(a), normal(b)) < SHARP))
            .map(|(&(a, b), triangles)| ((a, b), [place(triangles[0], a), place(triangles[0], b)]))
            .collect();
        found.sort_unstable_by_key(|(numbers, _)| *numbers);
        // A corner is where sharp edges end, meet, or turn.
        let mut ends: HashMap<u32, Vec<(Point, Point)>> = HashMap::new();
        for ((a, b), [p, q]) in &found {
            ends.entry(*a).or_default().push((*p, sub(*q, *p)));
            ends.entry(*b).or_default().push((*q, sub(*p, *q)));
        }
        let mut ends: Vec<_> = ends.into_iter().collect();
        ends.sort_unstable_by_key(|(number, _)| *number);
        let turns = |ways: &[(Point, Point)]| match ways {
            [(_, a), (_, b)] => -dot(*a, *b) < SHARP * norm(*a) * norm(*b),
            _ => true,
        };
        let corners = ends.iter().filter(|(_, ways)| turns(ways)).map(|(_, ways)| ways[0].0).collect();
        Self { segments: found.into_iter().map(|(_, segment)| segment).collect(), corners }
    }
}

/// Moves nodes of the boundary onto sharp edges; `side` is that of the cubes.
pub(super) fn sharpen(filled: &mut Filled, edges: &Edges, side: f64) {
    if edges.segments.is_empty() {
        return;
    }
    let boundary = boundary(&filled.tetrahedra);
    let mut around: HashMap<u32, Vec<u32>> = boundary.iter().map(|node| (*node, vec![])).collect();
    for (at, tetrahedron) in filled.tetrahedra.iter().enumerate() {
        for node in tetrahedron {
            if let Some(list) = around.get_mut(node) {
                list.push(at as u32);
            }
        }
    }
    let corners = edges.corners.iter().map(|corner| [*corner; 2]);
    let corners = wishes(filled, &boundary, corners, NEAR_CORNER, side);
    let mut fixed = HashSet::new();
    let mut taken = HashSet::new();
    let least_gain = GAIN * side.powi(3);
    for least in QUALITIES {
        for (_, node, corner, target) in &corners {
            let is_free = !taken.contains(corner) && !fixed.contains(node);
            if is_free && moves(filled, &around[node], *node, *target, least, 0.0) {
                fixed.insert(*node);
                taken.insert(*corner);
            }
        }
        for (_, node, _, target) in wishes(filled, &boundary, edges.segments.iter().copied(), NEAR_EDGE, side)
        {
            if !fixed.contains(&node) && moves(filled, &around[&node], node, target, least, least_gain) {
                fixed.insert(node);
            }
        }
    }
}

/// Nodes of faces that one tetrahedron has, in order.
fn boundary(tetrahedra: &[[u32; 4]]) -> Vec<u32> {
    let mut faces: HashMap<[u32; 3], u32> = HashMap::new();
    for face in tetrahedra.iter().flat_map(|t| FACES.map(|face| face.map(|corner| t[corner]))) {
        let mut key = face;
        key.sort_unstable();
        *faces.entry(key).or_default() += 1;
    }
    let mut nodes: Vec<u32> =
        faces.into_iter().filter(|(_, count)| *count == 1).flat_map(|(face, _)| face).collect();
    nodes.sort_unstable();
    nodes.dedup();
    nodes
}

/// A node, the segment it is near to, and where on it, the nearest first.
type Wish = (f64, u32, u32, Point);

fn wishes(
    filled: &Filled,
    nodes: &[u32],
    segments: impl Iterator<Item = [Point; 2]>,
    reach: f64,
    side: f64,
) -> Vec<Wish> {
    let cell = |point: Point| point.map(|x| (x / side).floor() as i64);
    let mut cells: HashMap<[i64; 3], Vec<u32>> = HashMap::new();
    for &node in nodes {
        cells.entry(cell(filled.nodes[node as usize])).or_default().push(node);
    }
    let mut best: HashMap<u32, Wish> = HashMap::new();
    let mut all = vec![];
    for (at, [from, to]) in segments.enumerate() {
        let along = sub(to, from);
        let square = dot(along, along);
        let steps = (square.sqrt() / side).ceil();
        let mut seen = vec![];
        for step in 0..=steps as usize {
            let share = if steps == 0.0 { 0.0 } else { step as f64 / steps };
            let middle = cell(std::array::from_fn(|k| from[k] + share * along[k]));
            for offset in 0..27 {
                let near =
                    [middle[0] + offset % 3 - 1, middle[1] + offset / 3 % 3 - 1, middle[2] + offset / 9 - 1];
                seen.extend(cells.get(&near).into_iter().flatten().copied());
            }
        }
        seen.sort_unstable();
        seen.dedup();
        for node in seen {
            let point = filled.nodes[node as usize];
            let share =
                if square == 0.0 { 0.0 } else { (dot(sub(point, from), along) / square).clamp(0.0, 1.0) };
            let target = std::array::from_fn(|k| from[k] + share * along[k]);
            let distance = norm(sub(point, target));
            let wish = (distance, node, at as u32, target);
            if distance > reach * side {
                continue;
            }
            if square == 0.0 {
                all.push(wish);
            } else {
                let nearest = best.entry(node).or_insert(wish);
                if distance < nearest.0 {
                    *nearest = wish;
                }
            }
        }
    }
    all.extend(best.into_values());
    all.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)).then(a.2.cmp(&b.2)));
    all
}

/// Moves a node if its tetrahedra stay this well shaped, and their volume changes by more than this: nodes of
/// a flat face whose edge is there already stay.
fn moves(filled: &mut Filled, around: &[u32], node: u32, target: Point, least: f64, gain: f64) -> bool {
    let corners = |filled: &Filled, at: u32| filled.tetrahedra[at as usize].map(|n| filled.nodes[n as usize]);
    let volume = |filled: &Filled| around.iter().map(|&at| corner_volume(corners(filled, at))).sum::<f64>();
    let before = volume(filled);
    let old = std::mem::replace(&mut filled.nodes[node as usize], target);
    let is_good = around.iter().all(|&at| quality(corners(filled, at)) > least);
    if is_good && (volume(filled) - before).abs() >= gain {
        return true;
    }
    filled.nodes[node as usize] = old;
    false
}
