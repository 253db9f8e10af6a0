//! The generalised winding number of a triangle soup: how often it encloses a point.
//!
//! It is 1 inside a closed surface and 0 outside, harmonic in between where the surface has holes, and the
//! sum over surfaces that cross each other (Jacobson, Kavan and Sorkine-Hornung 2013). Far groups of
//! triangles count as one dipole (Barill, Dickson, Schmidt, Levin and Jacobson 2018).

use vademecum_eval::nearest_in_triangle;

use crate::linalg::vec3::{cross, dot, norm, sub};

/// Triangles in a leaf of the tree.
const LEAF: usize = 8;
/// Radii of a group of triangles from which it counts as a dipole; the winding number is then off by less
/// than 1 %.
const FAR: f64 = 3.0;
/// Crossings nearer to each other than this share of the segment are one: an edge between two triangles.
const SAME: f64 = 1e-9;

pub(super) type Point = [f64; 3];

/// A group of triangles.
struct Group {
    low: Point,
    high: Point,
    /// Mean of the triangles by their areas.
    centre: Point,
    /// Distance of the furthest corner from the centre, squared.
    radius: f64,
    /// Sum of the normals, as long as the areas.
    dipole: Point,
    /// Triangles of a leaf, the first and one past the last; else the two groups it consists of.
    range: (u32, u32),
    leaf: bool,
}

impl Group {
    /// Distance of a point from the box, squared.
    fn square(&self, point: Point) -> f64 {
        (0..3).map(|k| (self.low[k] - point[k]).max(point[k] - self.high[k]).max(0.0).powi(2)).sum()
    }
}

/// A triangle and its number.
struct Numbered {
    corners: [Point; 3],
    number: u32,
}

/// Triangles sorted into a tree of groups.
pub(crate) struct Winding {
    triangles: Vec<Numbered>,
    groups: Vec<Group>,
    /// −1 for triangles that are inside out, else 1.
    sign: f64,
}

/// Triangles that stand for the surface where it is judged.
const SAMPLES: usize = 20_000;

impl Winding {
    /// The tree of a surface; the orientation of the triangles tells inside from outside.
    pub(crate) fn new(corners: Vec<[Point; 3]>) -> Self {
        let numbered = corners.into_iter().zip(0..).map(|(corners, number)| Numbered { corners, number });
        let mut triangles: Vec<Numbered> = numbered.collect();
        let mut groups = Vec::with_capacity(triangles.len() / (LEAF / 4) + 1);
        if !triangles.is_empty() {
            let count = triangles.len();
            split(&mut triangles, 0, count, &mut groups);
        }
        Self { triangles, groups, sign: 1.0 }
    }

    /// The triangle nearest to a point, by its number, and its distance; none of an empty surface.
    pub(crate) fn nearest(&self, point: Point) -> Option<(u32, f64)> {
        let mut best: Option<(u32, f64)> = None;
        let mut open = vec![];
        open.extend(self.groups.len().checked_sub(1).map(|root| (0.0, root)));
        while let Some((square, at)) = open.pop() {
            if best.is_some_and(|(_, best)| square >= best) {
                continue;
            }
            let group = &self.groups[at];
            if group.leaf {
                for triangle in &self.triangles[group.range.0 as usize..group.range.1 as usize] {
                    let [a, b, c] = triangle.corners;
                    let w = nearest_in_triangle(point, triangle.corners);
                    let off = std::array::from_fn(|k| w[0] * a[k] + w[1] * b[k] + w[2] * c[k] - point[k]);
                    let square = dot(off, off);
                    if best.is_none_or(|(_, best)| square < best) {
                        best = Some((triangle.number, square));
                    }
                }
            } else {
                let child = |at: u32| (self.groups[at as usize].square(point), at as usize);
                let mut children = [child(group.range.0), child(group.range.1)];
                // The nearer one is on top.
                children.sort_unstable_by(|a, b| b.0.total_cmp(&a.0));
                open.extend(children);
            }
        }
        best.map(|(number, square)| (number, square.sqrt()))
    }

    /// Takes the triangles the other way round.
    pub(crate) fn turn_inside_out(&mut self) {
        self.sign = -self.sign;
    }

    /// Share of the area of the surface for which this holds of a point and the outward normal there.
    pub(crate) fn share_of_area(&self, holds: impl Fn(Point, Point) -> bool) -> f64 {
        let (mut all, mut found) = (0.0, 0.0);
        for t in self.triangles.iter().step_by(self.triangles.len().div_ceil(SAMPLES).max(1)) {
            let t = &t.corners;
            let normal = cross(sub(t[1], t[0]), sub(t[2], t[0]));
            let area = norm(normal);
            let middle = std::array::from_fn(|k| (t[0][k] + t[1][k] + t[2][k]) / 3.0);
            all += area;
            if holds(middle, normal.map(|x| self.sign * x / area)) {
                found += area;
            }
        }
        found / all
    }

    /// Winding number about a point.
    pub(crate) fn number(&self, point: Point) -> f64 {
        let mut angle = 0.0;
        let mut open = vec![];
        open.extend(self.groups.len().checked_sub(1));
        while let Some(at) = open.pop() {
            let group = &self.groups[at];
            let from = sub(group.centre, point);
            let square = dot(from, from);
            if square > FAR * FAR * group.radius {
                angle += dot(group.dipole, from) / (square * square.sqrt());
            } else if group.leaf {
                let range = group.range.0 as usize..group.range.1 as usize;
                angle += self.triangles[range].iter().map(|t| solid_angle(&t.corners, point)).sum::<f64>();
            } else {
                open.extend([group.range.0 as usize, group.range.1 as usize]);
            }
        }
        self.sign * angle / (4.0 * std::f64::consts::PI)
    }

    /// Where the segment between two points crosses the surface, as shares of its length in order.
    pub(crate) fn crossings(&self, from: Point, to: Point) -> Vec<f64> {
        let along = sub(to, from);
        let mut found = vec![];
        let mut open = vec![];
        open.extend(self.groups.len().checked_sub(1));
        while let Some(at) = open.pop() {
            let group = &self.groups[at];
            if !meets(group, from, along) {
                continue;
            }
            if group.leaf {
                let range = group.range.0 as usize..group.range.1 as usize;
                let triangles = self.triangles[range].iter();
                found.extend(triangles.filter_map(|t| crossing(&t.corners, from, along)));
            } else {
                open.extend([group.range.0 as usize, group.range.1 as usize]);
            }
        }
        found.sort_by(f64::total_cmp);
        found.dedup_by(|b, a| *b - *a < SAME);
        found
    }

    /// The share of a segment at which it leaves the body; exactly one of its ends is inside.
    pub(crate) fn cut(&self, inside: Point, outside: Point) -> f64 {
        let crossings = self.crossings(inside, outside);
        if let [only] = crossings[..] {
            return only;
        }
        // Several walls, or a hole: halving finds one place, and the crossing nearest to it is exact.
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..14 {
            let middle = 0.5 * (low + high);
            let point = std::array::from_fn(|k| inside[k] + middle * (outside[k] - inside[k]));
            if self.number(point) > 0.5 { low = middle } else { high = middle }
        }
        let middle = 0.5 * (low + high);
        let near = crossings.iter().copied().min_by(|a, b| (a - middle).abs().total_cmp(&(b - middle).abs()));
        near.filter(|t| (t - middle).abs() <= 2.0 * (high - low)).unwrap_or(middle)
    }
}

/// Sorts triangles `first` to `end` into groups, the whole last; its index.
fn split(triangles: &mut [Numbered], first: usize, end: usize, groups: &mut Vec<Group>) -> usize {
    let part = &mut triangles[first..end];
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    let (mut dipole, mut weighted, mut area, mut plain) = ([0.0; 3], [0.0; 3], 0.0, [0.0; 3]);
    for Numbered { corners: t, .. } in part.iter() {
        let normal = cross(sub(t[1], t[0]), sub(t[2], t[0])).map(|x| 0.5 * x);
        let own = dot(normal, normal).sqrt();
        area += own;
        for k in 0..3 {
            let middle = (t[0][k] + t[1][k] + t[2][k]) / 3.0;
            dipole[k] += normal[k];
            weighted[k] += own * middle;
            plain[k] += middle / part.len() as f64;
            for corner in t {
                low[k] = low[k].min(corner[k]);
                high[k] = high[k].max(corner[k]);
            }
        }
    }
    let centre = if area > 0.0 { weighted.map(|x| x / area) } else { plain };
    let reach = |p: &Point| dot(sub(*p, centre), sub(*p, centre));
    let radius = part.iter().flat_map(|t| &t.corners).map(reach).fold(0.0, f64::max);
    let mut group =
        Group { low, high, centre, radius, dipole, range: (first as u32, end as u32), leaf: true };
    if part.len() > LEAF {
        let axis = (0..3).max_by(|&a, &b| (high[a] - low[a]).total_cmp(&(high[b] - low[b]))).unwrap_or(0);
        let key = |t: &Numbered| t.corners.iter().map(|corner| corner[axis]).sum::<f64>();
        let half = part.len() / 2;
        part.select_nth_unstable_by(half, |a, b| key(a).total_cmp(&key(b)));
        let one = split(triangles, first, first + half, groups);
        let other = split(triangles, first + half, end, groups);
        group.range = (one as u32, other as u32);
        group.leaf = false;
    }
    groups.push(group);
    groups.len() - 1
}

/// Solid angle of a triangle seen from a point (Van Oosterom and Strackee 1983).
fn solid_angle(triangle: &[Point; 3], point: Point) -> f64 {
    let [a, b, c] = triangle.map(|corner| sub(corner, point));
    let [la, lb, lc] = [a, b, c].map(|v| dot(v, v).sqrt());
    let volume = dot(a, cross(b, c));
    let rest = la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb;
    2.0 * volume.atan2(rest)
}

/// Where a segment meets a triangle, in shares of its length (Möller and Trumbore 1997).
fn crossing(triangle: &[Point; 3], from: Point, along: Point) -> Option<f64> {
    const RIM: f64 = -1e-12;
    let (e1, e2) = (sub(triangle[1], triangle[0]), sub(triangle[2], triangle[0]));
    let p = cross(along, e2);
    let det = dot(e1, p);
    if det == 0.0 {
        return None;
    }
    let s = sub(from, triangle[0]);
    let u = dot(s, p) / det;
    let q = cross(s, e1);
    let v = dot(along, q) / det;
    let t = dot(e2, q) / det;
    (u >= RIM && v >= RIM && u + v <= 1.0 - RIM && (0.0..=1.0).contains(&t)).then_some(t)
}

/// True if a segment may meet the box of a group.
fn meets(group: &Group, from: Point, along: Point) -> bool {
    let (mut first, mut last) = (0.0f64, 1.0f64);
    for k in 0..3 {
        let pad = 1e-12 * (group.high[k] - group.low[k]);
        let (low, high) = (group.low[k] - pad - from[k], group.high[k] + pad - from[k]);
        if along[k] == 0.0 {
            if low > 0.0 || high < 0.0 {
                return false;
            }
            continue;
        }
        let (a, b) = (low / along[k], high / along[k]);
        first = first.max(a.min(b));
        last = last.min(a.max(b));
    }
    first <= last
}
