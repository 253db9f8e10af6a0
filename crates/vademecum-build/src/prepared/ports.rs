//! Ports of a problem on its mesh: rows over the free dofs.

use std::collections::BTreeMap;

use super::attachments::first_dof;
use super::body_error::BodyError;
use super::places::facets;
use crate::fem::{DofMap, Facet, facet_load, mean_rows};
use crate::input::{PortEntry, PortKind, Problem};
use crate::linalg::unit;
use crate::linalg::vec3::{cross, norm};
use crate::mesh::Mesh;
use crate::mesh::surface::Surface;

/// Motions of a frame.
pub(super) const MOTIONS: usize = 6;

/// A port of the body.
#[derive(Clone, Debug)]
pub struct Port {
    /// Its name.
    pub name: String,
    /// Mesh nodes of a patch, ascending; none of a frame.
    pub nodes: Vec<u32>,
    /// Facets of a patch, turned outward.
    pub facets: Vec<Facet>,
    /// Origin of a frame, or the mean of the nodes of a patch.
    pub origin: [f64; 3],
    /// Axes along which and about which the rows of a frame are; of a patch those of space.
    pub axes: [[f64; 3]; 3],
    /// Free dofs and weights of each row: three displacements of each node, or six motions.
    pub rows: Vec<Vec<(u32, f64)>>,
}

/// The ports of a problem.
///
/// # Errors
/// [`BodyError`]: a selection that fits no facet.
pub(super) fn ports(
    problem: &Problem,
    mesh: &Mesh,
    surface: &Surface,
    dofs: &DofMap,
) -> Result<Vec<Port>, BodyError> {
    let of = |(i, entry): (usize, &PortEntry)| match entry.kind {
        PortKind::Patch => patch(problem, (i, entry), mesh, surface, dofs),
        PortKind::Frame => frame(problem, (i, entry), mesh, surface, dofs),
    };
    problem.ports.iter().enumerate().map(of).collect()
}

fn patch(
    problem: &Problem,
    (i, entry): (usize, &PortEntry),
    mesh: &Mesh,
    surface: &Surface,
    dofs: &DofMap,
) -> Result<Port, BodyError> {
    let on = entry.on.as_ref().expect("a checked patch has nodes");
    let facets = facets(problem, on, mesh, surface, || format!("port[{i}].on"))?;
    let mut nodes: Vec<u32> = facets.iter().flat_map(Facet::nodes).copied().collect();
    nodes.sort_unstable();
    nodes.dedup();
    let of_node = |&node: &u32| (0..3).map(move |c| dofs.terms(3 * node as usize + c).collect());
    let rows = nodes.iter().flat_map(of_node).collect();
    Ok(Port { name: entry.name.clone(), origin: mean(mesh, &nodes), axes: SPACE, rows, nodes, facets })
}

fn frame(
    problem: &Problem,
    (i, entry): (usize, &PortEntry),
    mesh: &Mesh,
    surface: &Surface,
    dofs: &DofMap,
) -> Result<Port, BodyError> {
    // Displacements and rotations along the axes of space, over the dofs of the model.
    let (origin, motions) = match &entry.reference {
        Some(name) => {
            let point = problem.reference_point(name).expect("a checked name of a reference point");
            let first = first_dof(mesh, point);
            let motions = (0..MOTIONS as u32).map(|c| vec![(first + c, 1.0)]).collect();
            (problem.reference_points[point].at, motions)
        }
        None => {
            let on = entry.on.as_ref().expect("a checked frame has nodes");
            let facets = facets(problem, on, mesh, surface, || format!("port[{i}].on"))?;
            let cloud = cloud(mesh, &facets);
            let whole: f64 = cloud.iter().map(|(_, weight)| weight).sum();
            let centre =
                |c: usize| cloud.iter().map(|&(node, w)| w / whole * mesh.nodes[node as usize][c]).sum();
            let origin = entry.at.unwrap_or_else(|| std::array::from_fn(centre));
            (origin, mean_motion(mesh, origin, &cloud))
        }
    };
    let axes = three_axes(entry.axes);
    let rows = along(axes, &motions, dofs);
    Ok(Port { name: entry.name.clone(), nodes: vec![], facets: vec![], origin, axes, rows })
}

/// The axes of a frame, by the first two; those of space without.
pub(super) fn three_axes(given: Option<[[f64; 3]; 2]>) -> [[f64; 3]; 3] {
    given.map_or(SPACE, |[first, second]| {
        let [first, second] = [first, second].map(unit);
        [first, second, cross(first, second)]
    })
}

/// Motions along the axes of space, over the dofs of the model, as rows along and about those of a frame,
/// over the free dofs.
pub(super) fn along(axes: [[f64; 3]; 3], motions: &[Vec<(u32, f64)>], dofs: &DofMap) -> Vec<Vec<(u32, f64)>> {
    let row = |k: usize| {
        let (axis, block) = (axes[k % 3], 3 * (k / 3));
        let mut sum = BTreeMap::new();
        for (c, share) in axis.into_iter().enumerate().filter(|(_, share)| *share != 0.0) {
            for &(dof, weight) in &motions[block + c] {
                for (free, of_dof) in dofs.terms(dof as usize) {
                    *sum.entry(free).or_insert(0.0) += share * weight * of_dof;
                }
            }
        }
        sum.into_iter().collect()
    };
    (0..MOTIONS).map(row).collect()
}

/// Axes of space.
pub(super) const SPACE: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// Mean of nodes.
pub(super) fn mean(mesh: &Mesh, nodes: &[u32]) -> [f64; 3] {
    let count = nodes.len().max(1) as f64;
    std::array::from_fn(|c| nodes.iter().map(|&node| mesh.nodes[node as usize][c] / count).sum())
}

/// Nodes of facets, and the integrals of their shape functions.
pub(super) fn cloud(mesh: &Mesh, facets: &[Facet]) -> Vec<(u32, f64)> {
    let weights = facet_load(mesh, facets, |normal| [norm(normal), 0.0, 0.0]);
    let nodes = (0..).zip(weights.into_iter().step_by(3));
    nodes.filter(|(_, weight)| *weight != 0.0).collect()
}

/// Mean displacements and rotations of weighted nodes at `origin`, over the dofs of the mesh.
pub(super) fn mean_motion(mesh: &Mesh, origin: [f64; 3], cloud: &[(u32, f64)]) -> Vec<Vec<(u32, f64)>> {
    let places: Vec<([f64; 3], f64)> =
        cloud.iter().map(|&(node, weight)| (mesh.nodes[node as usize], weight)).collect();
    let rows = mean_rows(origin, &places);
    let motion = |c: usize| -> Vec<(u32, f64)> {
        let of_node = |(&(node, _), row): (&(u32, f64), &[[f64; 3]; MOTIONS])| {
            let weights = row[c];
            (0..3).map(move |k| (3 * node + k as u32, weights[k])).filter(|term| term.1 != 0.0)
        };
        cloud.iter().zip(&rows).flat_map(of_node).collect()
    };
    (0..MOTIONS).map(motion).collect()
}
