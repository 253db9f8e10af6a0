//! Selections of a problem on its mesh.

use super::body_error::BodyError;
use crate::fem::{Facet, surface_facets};
use crate::input::Problem;
use crate::mesh::Mesh;
use crate::mesh::select::{SelectError, Selection};
use crate::mesh::surface::Surface;

/// Nodes of a selection; `key` names it in messages.
pub(super) fn select(
    problem: &Problem,
    selection: &Selection,
    mesh: &Mesh,
    key: impl Fn() -> String,
) -> Result<Vec<u32>, BodyError> {
    selection.nodes(mesh).map_err(|source| located(problem, &key, source))
}

/// The error of a key.
pub(super) fn located(problem: &Problem, key: &dyn Fn() -> String, source: SelectError) -> BodyError {
    BodyError::Selection { path: problem.place(&key()), key: key(), source: Box::new(source) }
}

/// Share of an edge at which the limit of a region is looked for.
const BESIDE_NODE: f64 = 0.02;

/// True if a selection by place ends between nodes of the surface: a finer mesh then has nodes of it where
/// this one has none.
pub(super) fn ends_between_nodes(
    selection: &Selection,
    mesh: &Mesh,
    surface: &Surface,
    nodes: &[u32],
) -> bool {
    let inside = |node: &u32| nodes.binary_search(node).is_ok();
    let edges = surface.triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
    let beside = edges.filter(|ends| inside(&ends[0]) && !inside(&ends[1])).map(|ends| {
        let [p, q] = ends.map(|node| mesh.nodes[node as usize]);
        std::array::from_fn(|k| p[k] + BESIDE_NODE * (q[k] - p[k]))
    });
    let n = mesh.nodes.len();
    let points = Mesh {
        nodes: mesh.nodes.iter().copied().chain(beside).collect(),
        // Numbers and groups of the file choose none of these points.
        node_ids: mesh.node_ids.clone(),
        node_groups: mesh.node_groups.clone(),
        ..Mesh::of_nothing()
    };
    selection.nodes(&points).is_ok_and(|chosen| chosen.last().is_some_and(|&last| last as usize >= n))
}

/// Facets all of whose corners are among `nodes`.
pub(super) fn facets_within(surface: &Surface, n_nodes: usize, nodes: &[u32]) -> Vec<usize> {
    let mut chosen = vec![false; n_nodes];
    nodes.iter().for_each(|&node| chosen[node as usize] = true);
    let whole = |corners: &[u32]| corners.iter().all(|&c| chosen[c as usize]);
    let corners = |f: usize| &surface.facet(f)[..surface.facet_kind(f).corners()];
    (0..surface.facet_count()).filter(|&f| whole(corners(f))).collect()
}

/// Facets of a selection, at least one, turned outward; `key` names it in messages.
///
/// # Errors
/// [`BodyError`]: a selection that fits no node or no facet.
pub(super) fn facets(
    problem: &Problem,
    selection: &Selection,
    mesh: &Mesh,
    surface: &Surface,
    key: impl Fn() -> String,
) -> Result<Vec<Facet>, BodyError> {
    let nodes = select(problem, selection, mesh, &key)?;
    let corners: Vec<[u32; 3]> = facets_within(surface, mesh.nodes.len(), &nodes)
        .into_iter()
        .map(|facet| std::array::from_fn(|k| surface.facet(facet)[k]))
        .collect();
    if corners.is_empty() {
        return Err(BodyError::NoFacet { path: problem.place(&key()), key: key() });
    }
    Ok(surface_facets(mesh, &corners)?)
}
