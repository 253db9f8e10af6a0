//! A surface embedded in a mesh of tetrahedra: each vertex follows the four corners of one of them.
//!
//! The tetrahedron is that below the nearest triangle of the boundary, and the weights are the barycentric
//! coordinates of the vertex there, negative ones where it lies outside: affine motions are kept exactly.
//! Triangles longer than those of the mesh are divided, so that they bend with it.

use std::collections::HashMap;
use std::path::Path;

use super::winding::{Point, Winding};
use super::{cleaned, read};
use crate::linalg::vec3::{cross, dot, norm, sub};
use crate::mesh::detect::surface_format;
use crate::mesh::error::MeshError;
use crate::mesh::load::load;
use crate::mesh::surface::Surface;
use crate::mesh::{Mesh, bounding_box};
use crate::parallel;

/// Longest edge of a triangle, in mean edges of the triangles of the boundary.
const LONGEST: f64 = 2.0;
/// Most triangles.
const MAX_TRIANGLES: usize = 4_000_000;
/// Largest distance of a vertex from the boundary, in diagonals of the box around the mesh.
const FURTHEST: f64 = 0.1;
/// Vertices of a task.
const CHUNK: usize = 512;

/// A surface that follows a mesh.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Embedded {
    /// Nodes of the mesh that each vertex follows.
    pub(crate) nodes: Vec<[u32; 4]>,
    /// Their weights, which sum to 1.
    pub(crate) weights: Vec<[f64; 4]>,
    /// Vertices of each triangle, outward.
    pub(crate) triangles: Vec<[u32; 3]>,
    /// Number of triangles away from the mesh, which are left out.
    pub(crate) left_out: usize,
}

impl Embedded {
    /// Reads a surface, in units of `scale`, and embeds it in a mesh that has this boundary.
    ///
    /// # Errors
    /// [`MeshError`]: a file that is no surface, a mesh of other elements, a surface away from the mesh.
    pub(crate) fn read(file: &Path, scale: f64, mesh: &Mesh, boundary: &Surface) -> Result<Self, MeshError> {
        let refused = |reason: String| MeshError::NotEmbedded { file: file.to_path_buf(), reason };
        if mesh.tetrahedra().is_none() {
            return Err(refused("the mesh has other elements than tetrahedra".into()));
        }
        let bytes = load(file)?;
        let format = surface_format(file, &bytes);
        let format = format.ok_or_else(|| refused("expected an STL, OBJ, PLY, OFF or GLB surface".into()))?;
        let mut corners = read(file, &bytes, format)?.corners;
        corners.iter_mut().flatten().flatten().for_each(|x| *x *= scale);
        let (mut points, mut triangles) = joined(&mut corners);
        let places = |triangle: &[u32; 3]| triangle.map(|node| mesh.nodes[node as usize]);
        let of_boundary: Vec<[Point; 3]> = boundary.triangles.iter().map(places).collect();
        let edges =
            of_boundary.iter().map(|[a, b, c]| norm(sub(*b, *a)) + norm(sub(*c, *b)) + norm(sub(*a, *c)));
        let mean = edges.sum::<f64>() / (3.0 * of_boundary.len().max(1) as f64);
        divide(&mut points, &mut triangles, LONGEST * mean);
        if triangles.is_empty() || triangles.len() > MAX_TRIANGLES {
            let count = triangles.len();
            return Err(refused(format!("it has {count} triangles; expected 1 to {MAX_TRIANGLES}")));
        }
        let (low, high) = bounding_box(&mesh.nodes);
        let reach = FURTHEST * norm(sub(high, low));
        let tree = Winding::new(of_boundary);
        let placed = |point: Point| {
            let (triangle, _) = tree.nearest(point).filter(|(_, distance)| *distance <= reach)?;
            let facet = boundary.triangle_facet[triangle as usize] as usize;
            let element = mesh.element(boundary.facet_element[facet] as usize);
            let nodes = [element[0], element[1], element[2], element[3]];
            Some((nodes, barycentric(nodes.map(|node| mesh.nodes[node as usize]), point)))
        };
        let chunks: Vec<&[Point]> = points.chunks(CHUNK).collect();
        let found =
            parallel::map(chunks.len(), &|at| chunks[at].iter().map(|p| placed(*p)).collect::<Vec<_>>());
        let found: Vec<_> = found.into_iter().flatten().collect();
        let far = found.iter().position(Option::is_none);
        let near = found.iter().flatten().count();
        if let Some(far) = far.filter(|_| 2 * near < found.len()) {
            let [x, y, z] = points[far];
            return Err(refused(format!(
                "{} of its {} vertices lie more than {reach:.3e} m off the mesh, a tenth of its size, such as ({x:.4e}, \
                 {y:.4e}, {z:.4e}) m: is it the surface of this body, in the unit of the mesh?",
                found.len() - near,
                found.len()
            )));
        }
        // Numbers of the vertices that stay.
        let mut next = 0..;
        let numbers: Vec<Option<u32>> = found.iter().map(|place| place.and_then(|_| next.next())).collect();
        let count = triangles.len();
        let kept = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|vertex| numbers[vertex as usize]);
            Some([a?, b?, c?])
        };
        let triangles: Vec<[u32; 3]> = triangles.iter().filter_map(kept).collect();
        let left_out = count - triangles.len();
        let (nodes, weights) = found.into_iter().flatten().unzip();
        Ok(Self { nodes, weights, triangles, left_out })
    }
}

/// Vertices and triangles of a soup: corners at one place are one vertex; outward, if the soup encloses
/// something.
pub(super) fn joined(corners: &mut Vec<[Point; 3]>) -> (Vec<Point>, Vec<[u32; 3]>) {
    let mut triangles = cleaned(corners, &mut vec![]);
    let count = triangles.as_flattened().iter().max().map_or(0, |last| *last as usize + 1);
    let mut points = vec![[0.0; 3]; count];
    for (triangle, corners) in triangles.iter().zip(&*corners) {
        triangle.iter().zip(corners).for_each(|(&vertex, corner)| points[vertex as usize] = *corner);
    }
    triangles.retain(|[a, b, c]| a != b && b != c && c != a);
    let middle = points.first().copied().unwrap_or_default();
    let volume = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|vertex| sub(points[vertex as usize], middle));
        dot(a, cross(b, c))
    };
    if triangles.iter().map(volume).sum::<f64>() < 0.0 {
        triangles.iter_mut().for_each(|t| t.swap(1, 2));
    }
    (points, triangles)
}

/// Halves edges until none is longer than this, in all triangles of an edge alike.
fn divide(points: &mut Vec<Point>, triangles: &mut Vec<[u32; 3]>, longest: f64) {
    while triangles.len() <= MAX_TRIANGLES {
        let mut middles: HashMap<(u32, u32), u32> = HashMap::new();
        let mut found = Vec::with_capacity(triangles.len());
        for t in triangles.iter() {
            // A middle for each edge that is too long, from the first corner on.
            let middle: [Option<u32>; 3] = std::array::from_fn(|k| {
                let (a, b) = (t[k], t[(k + 1) % 3]);
                let (p, q) = (points[a as usize], points[b as usize]);
                (norm(sub(q, p)) > longest).then(|| {
                    *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                        points.push(std::array::from_fn(|c| 0.5 * (p[c] + q[c])));
                        points.len() as u32 - 1
                    })
                })
            });
            divide_one(*t, middle, &mut found);
        }
        *triangles = found;
        if middles.is_empty() {
            return;
        }
    }
}

/// The parts of a triangle that has middles on some of its edges.
fn divide_one(t: [u32; 3], middle: [Option<u32>; 3], found: &mut Vec<[u32; 3]>) {
    match middle {
        [None, None, None] => found.push(t),
        [Some(m), Some(n), Some(o)] => found.extend([[t[0], m, o], [m, t[1], n], [o, n, t[2]], [m, n, o]]),
        _ => {
            // Turned until the first edge has a middle, and of two middles the other one is on the second.
            let turn = (0..3).find(|&k| middle[k].is_some() && middle[(k + 2) % 3].is_none()).unwrap_or(0);
            let [a, b, c] = [0, 1, 2].map(|k| t[(turn + k) % 3]);
            let m = middle[turn].unwrap_or(a);
            match middle[(turn + 1) % 3] {
                None => found.extend([[a, m, c], [m, b, c]]),
                Some(n) => found.extend([[m, b, n], [a, m, n], [a, n, c]]),
            }
        }
    }
}

/// Barycentric coordinates of a point in a tetrahedron.
fn barycentric([a, b, c, d]: [Point; 4], point: Point) -> [f64; 4] {
    let [u, v, w, p] = [b, c, d, point].map(|x| sub(x, a));
    let volume = dot(u, cross(v, w));
    let shares = [dot(p, cross(v, w)), dot(u, cross(p, w)), dot(u, cross(v, p))].map(|x| x / volume);
    [1.0 - shares.iter().sum::<f64>(), shares[0], shares[1], shares[2]]
}
