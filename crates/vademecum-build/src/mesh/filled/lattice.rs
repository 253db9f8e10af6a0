//! Tetrahedra that fill a surface: isosurface stuffing of a body-centred cubic lattice (Labelle and Shewchuk
//! 2007).
//!
//! Lattice points are inside or outside. Those that lie close to the surface move onto it; tetrahedra that
//! the surface still crosses are cut, and the parts inside are kept. So the shape of every tetrahedron is one
//! of a few, moved by little: no slivers, and no repair.

use std::collections::HashMap;

use super::winding::{Point, Winding};
use crate::mesh::EDGES;
use crate::mesh::quality::corner_volume;
use crate::parallel;

/// Lattice points move to a cut of one of their edges that is nearer than this share of it: long edges join
/// corners of cubes, or their centres; short ones a centre with a corner. The shares of the paper.
const NEAR_LONG: f64 = 0.24999;
const NEAR_SHORT: f64 = 0.41189;
/// Lattice points or edges that one task handles.
const CHUNK: usize = 4096;

/// Cubes of a lattice: the lowest corner, the side of a cube, cubes along each axis.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lattice {
    pub(super) origin: Point,
    pub(super) side: f64,
    pub(super) cubes: [usize; 3],
}

impl Lattice {
    /// `cells` cubes along the longest side of a box, in the middle, with a rim of one cube that stays
    /// outside.
    pub(super) fn around(low: Point, high: Point, cells: f64) -> Self {
        let longest = (0..3).map(|k| high[k] - low[k]).fold(0.0, f64::max);
        let side = longest / cells;
        let cubes = std::array::from_fn(|k| ((high[k] - low[k]) / side).ceil() as usize + 2);
        let origin = std::array::from_fn(|k| 0.5 * (low[k] + high[k] - side * cubes[k] as f64));
        Self { origin, side, cubes }
    }

    fn corners(&self) -> usize {
        self.cubes.iter().map(|n| n + 1).product()
    }

    /// Corners of cubes, then their centres.
    pub(super) fn count(&self) -> usize {
        self.corners() + self.cubes.iter().product::<usize>()
    }

    fn corner(&self, [i, j, k]: [usize; 3]) -> u32 {
        ((k * (self.cubes[1] + 1) + j) * (self.cubes[0] + 1) + i) as u32
    }

    fn centre(&self, [i, j, k]: [usize; 3]) -> u32 {
        (self.corners() + (k * self.cubes[1] + j) * self.cubes[0] + i) as u32
    }

    fn is_corner(&self, id: u32) -> bool {
        (id as usize) < self.corners()
    }

    fn point(&self, id: u32) -> Point {
        let (at, rim, half) = match (id as usize).checked_sub(self.corners()) {
            None => (id as usize, 1, 0.0),
            Some(at) => (at, 0, 0.5),
        };
        let [nx, ny] = [self.cubes[0] + rim, self.cubes[1] + rim];
        let place = [at % nx, at / nx % ny, at / (nx * ny)];
        std::array::from_fn(|k| self.origin[k] + self.side * (place[k] as f64 + half))
    }

    /// The four tetrahedra around each segment that joins the centres of two neighbouring cubes: the centres
    /// and an edge of the square between them.
    fn each_tetrahedron(&self, mut visit: impl FnMut([u32; 4])) {
        for axis in 0..3 {
            let (one, other) = ((axis + 1) % 3, (axis + 2) % 3);
            let mut cubes = self.cubes;
            cubes[axis] -= 1;
            for k in 0..cubes[2] {
                for j in 0..cubes[1] {
                    for i in 0..cubes[0] {
                        let cube = [i, j, k];
                        let moved = |steps: [usize; 3]| {
                            let mut place = cube;
                            place[axis] += steps[0];
                            place[one] += steps[1];
                            place[other] += steps[2];
                            place
                        };
                        let ends = [self.centre(cube), self.centre(moved([1, 0, 0]))];
                        let square =
                            [[1, 0, 0], [1, 1, 0], [1, 1, 1], [1, 0, 1]].map(|s| self.corner(moved(s)));
                        for at in 0..4 {
                            visit([ends[0], ends[1], square[at], square[(at + 1) % 4]]);
                        }
                    }
                }
            }
        }
    }

    /// Winding number of the surface about each lattice point.
    pub(super) fn numbers(&self, surface: &Winding) -> Vec<f32> {
        let count = self.count();
        let chunk = |at: usize| {
            let ids = at * CHUNK..((at + 1) * CHUNK).min(count);
            ids.map(|id| surface.number(self.point(id as u32)) as f32).collect::<Vec<f32>>()
        };
        parallel::map(count.div_ceil(CHUNK), &chunk).concat()
    }
}

/// Nodes and tetrahedra.
pub(super) struct Filled {
    pub(super) nodes: Vec<Point>,
    pub(super) tetrahedra: Vec<[u32; 4]>,
}

/// Fills a surface, of which `inside` tells which lattice points it encloses.
pub(super) fn fill(lattice: &Lattice, surface: &Winding, inside: &[bool]) -> Filled {
    let mut points: Vec<Point> = (0..lattice.count()).map(|id| lattice.point(id as u32)).collect();
    let mut cuts = cuts(lattice, surface, inside, &points);
    let on_surface = snap(lattice, &mut points, &mut cuts, inside);
    let mut filled = Cutter {
        points: &points,
        cuts: &cuts,
        numbers: HashMap::new(),
        filled: Filled { nodes: vec![], tetrahedra: vec![] },
    };
    lattice.each_tetrahedron(|tetrahedron| {
        let signs = tetrahedron.map(|id| match (on_surface[id as usize], inside[id as usize]) {
            (true, _) => 0,
            (_, true) => 1,
            _ => -1,
        });
        filled.keep(tetrahedron, signs);
    });
    filled.filled
}

/// Where the surface cuts the edges between a point inside and one outside, as shares from the first of the
/// two numbers, the smaller one.
type Cuts = HashMap<(u32, u32), f64>;

fn cuts(lattice: &Lattice, surface: &Winding, inside: &[bool], points: &[Point]) -> Cuts {
    let mut edges = vec![];
    lattice.each_tetrahedron(|t| {
        for [a, b] in EDGES {
            let (a, b) = (t[a].min(t[b]), t[a].max(t[b]));
            if inside[a as usize] != inside[b as usize] {
                edges.push((a, b));
            }
        }
    });
    edges.sort_unstable();
    edges.dedup();
    let chunks: Vec<&[(u32, u32)]> = edges.chunks(CHUNK / 16).collect();
    let chunk = |at: usize| {
        let share = |&(a, b): &(u32, u32)| {
            let (from, to) = (points[a as usize], points[b as usize]);
            if inside[a as usize] { surface.cut(from, to) } else { 1.0 - surface.cut(to, from) }
        };
        chunks[at].iter().map(share).collect::<Vec<f64>>()
    };
    let shares = parallel::map(chunks.len(), &chunk).concat();
    edges.into_iter().zip(shares).collect()
}

/// Moves lattice points onto the nearest cut of their edges where it is near, and removes the cuts of their
/// edges; which points lie on the surface then.
fn snap(lattice: &Lattice, points: &mut [Point], cuts: &mut Cuts, inside: &[bool]) -> Vec<bool> {
    let mut cut_edges: Vec<(u32, u32)> = cuts.iter().flat_map(|(&(a, b), _)| [(a, b), (b, a)]).collect();
    cut_edges.sort_unstable();
    let mut on_surface = vec![false; inside.len()];
    for edges in cut_edges.chunk_by(|x, y| x.0 == y.0) {
        let id = edges[0].0;
        let near = edges.iter().filter_map(|&(_, other)| {
            let key = (id.min(other), id.max(other));
            let &share = cuts.get(&key)?;
            let own = if id < other { share } else { 1.0 - share };
            let is_long = lattice.is_corner(id) == lattice.is_corner(other);
            let (most, length) = if is_long { (NEAR_LONG, 1.0) } else { (NEAR_SHORT, 0.75f64.sqrt()) };
            (own < most).then_some((own * length, share, key))
        });
        if let Some((_, share, (a, b))) = near.min_by(|x, y| x.0.total_cmp(&y.0)) {
            points[id as usize] = between(points[a as usize], points[b as usize], share);
            on_surface[id as usize] = true;
            edges.iter().for_each(|&(_, other)| _ = cuts.remove(&(id.min(other), id.max(other))));
        }
    }
    on_surface
}

fn between(a: Point, b: Point, share: f64) -> Point {
    std::array::from_fn(|k| a[k] + share * (b[k] - a[k]))
}

/// Keeps what of each tetrahedron is inside.
struct Cutter<'a> {
    points: &'a [Point],
    cuts: &'a Cuts,
    /// Nodes of lattice points, as a pair of equal numbers, and of cut edges.
    numbers: HashMap<(u32, u32), u32>,
    filled: Filled,
}

impl Cutter<'_> {
    /// The node of a lattice point, or of the cut of an edge.
    fn node(&mut self, a: u32, b: u32) -> u32 {
        let key = (a.min(b), a.max(b));
        *self.numbers.entry(key).or_insert_with(|| {
            let (from, to) = (self.points[key.0 as usize], self.points[key.1 as usize]);
            let point = if a == b { from } else { between(from, to, self.cuts[&key]) };
            self.filled.nodes.push(point);
            self.filled.nodes.len() as u32 - 1
        })
    }

    fn push(&mut self, mut nodes: [u32; 4]) {
        let [a, b, c, d] = nodes.map(|node| self.filled.nodes[node as usize]);
        let volume = corner_volume([a, b, c, d]);
        if volume < 0.0 {
            nodes.swap(2, 3);
        }
        if volume != 0.0 {
            self.filled.tetrahedra.push(nodes);
        }
    }

    /// `signs`: 1 inside, 0 on the surface, −1 outside.
    fn keep(&mut self, tetrahedron: [u32; 4], signs: [i8; 4]) {
        if signs.iter().all(|sign| *sign <= 0) {
            return;
        }
        let of = |sign: i8| {
            let mut ids: Vec<u32> = (0..4).filter(|&k| signs[k] == sign).map(|k| tetrahedron[k]).collect();
            ids.sort_unstable();
            ids
        };
        // In order: of two points inside, the diagonal between them and their cuts starts at the first, on
        // both sides of a face.
        let (inside, on, outside) = (of(1), of(0), of(-1));
        match (&inside[..], &on[..], &outside[..]) {
            (_, _, []) => {
                let nodes = tetrahedron.map(|id| self.node(id, id));
                self.push(nodes);
            }
            // A corner.
            ([p], ..) => {
                let nodes = tetrahedron
                    .map(|id| if outside.contains(&id) { self.node(*p, id) } else { self.node(id, id) });
                self.push(nodes);
            }
            // A pyramid on a quadrilateral.
            ([p, q], [on], [n]) => {
                let apex = self.node(*on, *on);
                let (a, b) = (self.node(*p, *p), self.node(*q, *q));
                let (below_a, below_b) = (self.node(*p, *n), self.node(*q, *n));
                self.push([apex, a, below_a, below_b]);
                self.push([apex, a, b, below_b]);
            }
            // Prisms.
            ([p, q], [], [m, n]) => {
                let ends = [[*p, *p], [*p, *m], [*p, *n]].map(|[a, b]| self.node(a, b));
                let others = [[*q, *q], [*q, *m], [*q, *n]].map(|[a, b]| self.node(a, b));
                self.prism(ends, others);
            }
            ([p, q, r], [], [n]) => {
                let ends = [*p, *q, *r];
                let top = ends.map(|id| self.node(id, id));
                let bottom = ends.map(|id| self.node(id, *n));
                self.prism(top, bottom);
            }
            _ => {}
        }
    }

    /// A prism between two triangles. The diagonals of its sides start at the earlier of two corners.
    fn prism(&mut self, [a, b, c]: [u32; 3], [d, e, f]: [u32; 3]) {
        self.push([a, d, e, f]);
        self.push([a, b, e, f]);
        self.push([a, b, c, f]);
    }
}
