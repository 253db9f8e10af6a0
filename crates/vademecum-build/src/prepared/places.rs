//! Selections of a problem on its mesh.

use super::body_error::BodyError;
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

/// Facets all of whose corners are among `nodes`.
pub(super) fn facets_within(surface: &Surface, n_nodes: usize, nodes: &[u32]) -> Vec<usize> {
    let mut chosen = vec![false; n_nodes];
    nodes.iter().for_each(|&node| chosen[node as usize] = true);
    let whole = |corners: &[u32]| corners.iter().all(|&c| chosen[c as usize]);
    let corners = |f: usize| &surface.facet(f)[..surface.facet_kind(f).corners()];
    (0..surface.facet_count()).filter(|&f| whole(corners(f))).collect()
}
