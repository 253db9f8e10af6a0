//! A traction of one newton on a disc of the surface, integrated with the same points on both spaces.

use faer::MatRef;
use serde::{Deserialize, Serialize};

use crate::fem::{RaisedSpace, facet_shapes};
use crate::linalg::vec3::{cross, dot, norm, sub};
use crate::mesh::Order;
use crate::mesh::surface::Surface;
use crate::prepared::Body;

/// Cosine between the normals of the disc and of a facet that carries it: the other side of a plate does not.
const SAME_SIDE: f64 = 0.5;
/// Halvings of the edges of a facet, whose parts lie in the disc or do not: at least the first of them, and
/// as many as make eight parts of a radius, up to the second.
const HALVINGS: [f64; 2] = [3.0, 8.0];

/// A disc of the surface that carries a uniform traction along its normal, one newton in all.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct DiscLoad {
    /// The node in its middle \[m\].
    pub point: [f64; 3],
    /// Outward normal there.
    pub normal: [f64; 3],
    /// Radius \[m\].
    pub radius: f64,
}

/// The disc at the loadable node of largest compliance along its normal, as far as the modes tell, which a
/// single force at a node would not (it has no limit). With the facets of the surface; nothing where no
/// node is loadable.
pub(super) fn softest_place(
    body: &Body,
    eigenvalues: &[f64],
    vectors: MatRef<'_, f64>,
    radius: f64,
) -> Option<(DiscLoad, Surface)> {
    let (mesh, dofs) = (body.model.mesh(), body.model.dofs());
    let surface = Surface::of(mesh);
    let compliance = |place: usize| -> f64 {
        let (node, normal) = (surface.nodes[place] as usize, surface.normals[place]);
        let modes = eigenvalues.iter().enumerate().map(|(k, lambda)| {
            let moved = |c: usize| dofs.free(3 * node + c).map_or(0.0, |row| vectors[(row as usize, k)]);
            dot(std::array::from_fn(moved), normal).powi(2) / lambda
        });
        modes.sum()
    };
    let places = body.load_nodes.iter().filter_map(|&node| surface.position(node));
    let place = places.max_by(|&a, &b| compliance(a).total_cmp(&compliance(b)).then(b.cmp(&a)))?;
    let point = mesh.nodes[surface.nodes[place] as usize];
    Some((DiscLoad { point, normal: surface.normals[place], radius }, surface))
}

/// The load over the raised space; nothing where the disc meets no facet that can move.
pub(super) fn raised_load(
    space: &RaisedSpace<'_>,
    body: &Body,
    disc: &DiscLoad,
    surface: &Surface,
) -> Option<Vec<f64>> {
    [SAME_SIDE, 0.0].into_iter().find_map(|side| load_on(space, body, disc, surface, side))
}

fn load_on(
    space: &RaisedSpace<'_>,
    body: &Body,
    disc: &DiscLoad,
    surface: &Surface,
    side: f64,
) -> Option<Vec<f64>> {
    let (mesh, dofs) = (body.model.mesh(), body.model.dofs());
    let (mut load, mut area) = (vec![0.0; space.n()], 0.0);
    let mut points: Vec<Vec<([f64; 3], f64)>> = vec![];
    for index in 0..surface.facet_count() {
        let facet = surface.facet(index);
        let corners: [u32; 3] = std::array::from_fn(|i| facet[i]);
        let at = corners.map(|node| mesh.nodes[node as usize]);
        let flat = cross(sub(at[1], at[0]), sub(at[2], at[0]));
        let reach = (0..3).map(|i| norm(sub(at[i], at[(i + 1) % 3]))).fold(disc.radius, |r, e| r + e);
        let is_held = corners.iter().all(|&node| (0..3).all(|c| dofs.free(3 * node as usize + c).is_none()));
        if is_held || norm(sub(at[0], disc.point)) > reach || dot(flat, disc.normal) <= side * norm(flat) {
            continue;
        }
        let longest = (0..3).map(|i| norm(sub(at[i], at[(i + 1) % 3]))).fold(0.0, f64::max);
        let halvings = (8.0 * longest / disc.radius).log2().ceil().clamp(HALVINGS[0], HALVINGS[1]) as usize;
        while points.len() <= halvings {
            points.push(parts(points.len()));
        }
        for (l, weight) in &points[halvings] {
            let (values, slopes) = facet_shapes(mesh.order(), *l);
            let (mut x, mut tangents) = ([0.0; 3], [[0.0; 3]; 2]);
            for (a, &node) in facet.iter().enumerate() {
                for (i, p) in mesh.nodes[node as usize].into_iter().enumerate() {
                    x[i] += values[a] * p;
                    tangents[0][i] += slopes[a][0] * p;
                    tangents[1][i] += slopes[a][1] * p;
                }
            }
            if norm(sub(x, disc.point)) >= disc.radius {
                continue;
            }
            let share = weight * norm(cross(tangents[0], tangents[1]));
            area += share;
            for (a, &node) in facet.iter().enumerate() {
                for (c, n) in disc.normal.into_iter().enumerate() {
                    if let Some(row) = dofs.free(3 * node as usize + c) {
                        load[row as usize] += share * values[a] * n;
                    }
                }
            }
            let mut add = |function: usize, value: f64| {
                space.add_at(function, disc.normal.map(|n| share * value * n), &mut load);
            };
            for i in 0..3 {
                let j = (i + 1) % 3;
                let (edge, turned) = space.edge([corners[i], corners[j]]);
                let value = match mesh.order() {
                    Order::Linear => 4.0 * l[i] * l[j],
                    Order::Quadratic => l[i] * l[j] * (l[i] - l[j]),
                };
                add(edge, if turned { -value } else { value });
            }
            if mesh.order() == Order::Quadratic {
                add(space.face(corners), 27.0 * l[0] * l[1] * l[2]);
            }
        }
    }
    load.iter_mut().for_each(|f| *f /= area);
    (area > 0.0).then_some(load)
}

/// Three points in each of `4ⁿ` parts of a triangle, exact for degree 2 in each; weights sum to ½.
fn parts(halvings: usize) -> Vec<([f64; 3], f64)> {
    let mut triangles = vec![[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]];
    for _ in 0..halvings {
        let halve = |[a, b, c]: [[f64; 3]; 3]| {
            let middle = |p: [f64; 3], q: [f64; 3]| std::array::from_fn(|i| 0.5 * (p[i] + q[i]));
            let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
            [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        };
        triangles = triangles.into_iter().flat_map(halve).collect();
    }
    let weight = 0.5 / (3.0 * triangles.len() as f64);
    let point = |[a, b, c]: [[f64; 3]; 3], k: usize| {
        let shares: [f64; 3] = std::array::from_fn(|i| if i == k { 2.0 / 3.0 } else { 1.0 / 6.0 });
        std::array::from_fn(|i| shares[0] * a[i] + shares[1] * b[i] + shares[2] * c[i])
    };
    triangles.iter().flat_map(|&t| (0..3).map(move |k| (point(t, k), weight))).collect()
}
