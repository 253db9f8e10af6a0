//! In which order dofs are eliminated, and the structure of the factor that follows from it.
//!
//! The fill-reducing order is a nested dissection of the *node* graph by METIS, each node then standing for
//! its free dofs: a third of the graph, and 1.3–2.7 times faster factors than minimum degree on solids. faer
//! finds the structure.

use std::sync::Mutex;

use faer::perm::PermRef;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, SymmetricOrdering, factorize_symbolic_cholesky,
};
use faer::sparse::{FaerError, SymbolicSparseColMatRef};
use faer::{Index, Side};

use super::assembly::NodeGraph;
use super::dofs::DofMap;
use super::pencil::Pencil;
use super::sparse::Pattern;
use super::supernodes::Supernodes;

/// Below this many nodes minimum degree orders as well as a dissection, and faster.
const METIS_NODES: usize = 200;

/// The structure of a factor of the matrices of a pencil.
///
/// # Errors
/// Memory that is not there.
pub(super) fn structure(pencil: &Pencil) -> Result<Supernodes, FaerError> {
    structure_under(pencil.mass().pattern(), elimination_order(pencil))
}

/// The order in which the dofs of a pencil are eliminated, as (old of new, new of old); `None` where one of
/// minimum degree is as good.
pub(crate) fn elimination_order(pencil: &Pencil) -> Option<(Vec<u32>, Vec<u32>)> {
    dissection_order(pencil.mass().pattern(), pencil.dof_nodes()?)
}

/// An order of the free dofs of a mesh, without their matrices: the dof at each place. With it the numbers of
/// a factor, nearly: nine for each pair of nodes.
///
/// # Errors
/// Memory that is not there.
pub(super) fn order_of_nodes(graph: &NodeGraph, dofs: &DofMap) -> Result<(Vec<u32>, usize), FaerError> {
    let dof_nodes: Vec<u32> = dofs.dof_of_free().iter().map(|dof| dof / 3).collect();
    let first_dofs = first_dofs(&dof_nodes);
    // Nodes as METIS counts them: those that have a free dof, without gaps.
    let nodes: Vec<u32> = first_dofs[..first_dofs.len() - 1].iter().map(|&d| dof_nodes[d as usize]).collect();
    let mut number = vec![u32::MAX; dofs.n_dof() / 3];
    nodes.iter().enumerate().for_each(|(at, &node)| number[node as usize] = at as u32);
    let (mut starts, mut neighbours) = (vec![0], vec![]);
    for &node in &nodes {
        let row = graph.row(node as usize).iter().map(|&other| number[other as usize]);
        neighbours.extend(row.filter(|&other| other != u32::MAX));
        starts.push(neighbours.len() as u32);
    }
    let pattern = Pattern::new(starts, neighbours);
    let (starts, neighbours) = without_loops(&pattern);
    let order = match nodes.len() {
        few if few < METIS_NODES => None,
        _ => nested_dissection(starts, neighbours),
    };
    let order: Vec<u32> = order.map_or_else(
        || (0..nodes.len() as u32).collect(),
        |order| order.into_iter().map(|node| node as u32).collect(),
    );
    let mut place = vec![0; order.len()];
    order.iter().enumerate().for_each(|(new, &old)| place[old as usize] = new as u32);
    let blocks = structure_under(&pattern, Some((order.clone(), place)))?.len();
    let dofs_of = |&node: &u32| first_dofs[node as usize]..first_dofs[node as usize + 1];
    Ok((order.iter().flat_map(dofs_of).collect(), 9 * blocks))
}

/// A pattern as METIS reads it.
fn without_loops(pattern: &Pattern) -> (Vec<i32>, Vec<i32>) {
    let (mut starts, mut neighbours) = (vec![0], vec![]);
    for node in 0..pattern.n() {
        let row = pattern.rows_of(node).iter();
        neighbours.extend(row.filter(|&&other| other as usize != node).map(|&other| other as i32));
        starts.push(neighbours.len() as i32);
    }
    (starts, neighbours)
}

/// Structure of the factor under one order, or under one of minimum degree. Indices count the entries of the
/// factor, and 32 bits are not enough for those of some million dofs.
fn structure_under(pattern: &Pattern, order: Option<(Vec<u32>, Vec<u32>)>) -> Result<Supernodes, FaerError> {
    match structure_by(pattern.as_faer(), order.as_ref().map(|(f, i)| [&f[..], &i[..]])) {
        Err(FaerError::IndexOverflow) => wide_structure(pattern, order),
        found => found,
    }
}

/// The same by indices of 64 bits.
fn wide_structure(pattern: &Pattern, order: Option<(Vec<u32>, Vec<u32>)>) -> Result<Supernodes, FaerError> {
    let wide = |indices: &[u32]| indices.iter().map(|&index| index as usize).collect::<Vec<_>>();
    let [starts, rows] = pattern.arrays().map(wide);
    let order = order.map(|(forward, inverse)| [wide(&forward), wide(&inverse)]);
    let n = pattern.n();
    let wide = SymbolicSparseColMatRef::new_checked(n, n, &starts, None, &rows);
    let order = order.as_ref().map(|order| order.each_ref().map(|indices| &indices[..]));
    structure_by(wide, order)
}

/// The same by indices of one width; an order is (old of new, new of old).
fn structure_by<I: Index>(
    pattern: SymbolicSparseColMatRef<'_, I>,
    order: Option<[&[I]; 2]>,
) -> Result<Supernodes, FaerError> {
    let n = pattern.nrows();
    let order = order.map(|[forward, inverse]| PermRef::new_checked(forward, inverse, n));
    let order = order.map_or(SymmetricOrdering::Amd, SymmetricOrdering::Custom);
    // Default parameters: faer chooses the supernodal form wherever it pays; forcing the simplicial one is 20
    // × slower.
    let params = CholeskySymbolicParams::default();
    Ok(Supernodes::new(&factorize_symbolic_cholesky(pattern, Side::Lower, order, params)?))
}

/// The dof order that dissects the node graph, as (old of new, new of old); `None` where it would not pay.
fn dissection_order(pattern: &Pattern, dof_nodes: &[u32]) -> Option<(Vec<u32>, Vec<u32>)> {
    let first_dofs = first_dofs(dof_nodes);
    if first_dofs.len() - 1 < METIS_NODES {
        return None;
    }
    let (starts, neighbours) = node_graph(pattern, dof_nodes, &first_dofs);
    let node_order = nested_dissection(starts, neighbours)?;
    let mut forward = Vec::with_capacity(pattern.n());
    for node in node_order {
        forward.extend(first_dofs[node as usize]..first_dofs[node as usize + 1]);
    }
    let mut inverse = vec![0; forward.len()];
    for (new, &old) in forward.iter().enumerate() {
        inverse[old as usize] = new as u32;
    }
    Some((forward, inverse))
}

/// First dof of each node that has one, and the number of dofs at the end.
fn first_dofs(dof_nodes: &[u32]) -> Vec<u32> {
    let mut first: Vec<u32> = (0..dof_nodes.len())
        .filter(|&d| d == 0 || dof_nodes[d] != dof_nodes[d - 1])
        .map(|d| d as u32)
        .collect();
    first.push(dof_nodes.len() as u32);
    first
}

/// Adjacency of nodes without loops: two nodes are neighbours where any of their dofs share a place.
fn node_graph(pattern: &Pattern, dof_nodes: &[u32], first_dofs: &[u32]) -> (Vec<i32>, Vec<i32>) {
    // Nodes as METIS counts them: those that have a dof, without gaps.
    let mut node_of_dof = vec![0; pattern.n()];
    for dof in 1..pattern.n() {
        node_of_dof[dof] = node_of_dof[dof - 1] + i32::from(dof_nodes[dof] != dof_nodes[dof - 1]);
    }
    let mut starts = vec![0];
    let mut neighbours = Vec::new();
    let mut row = Vec::new();
    for (node, dofs) in first_dofs.windows(2).enumerate() {
        row.clear();
        // Blocks of a mesh are dense, but matrices of another program may leave out their zeros.
        for dof in dofs[0]..dofs[1] {
            row.extend(pattern.rows_of(dof as usize).iter().map(|&other| node_of_dof[other as usize]));
        }
        row.sort_unstable();
        row.dedup();
        neighbours.extend(row.iter().filter(|&&other| other != node as i32));
        starts.push(neighbours.len() as i32);
    }
    (starts, neighbours)
}

/// METIS draws from one process-wide random sequence; two analyses at once would disturb each other's.
static METIS_LOCK: Mutex<()> = Mutex::new(());

/// Elimination order of the nodes (old number of each new one); `None` if METIS refuses.
fn nested_dissection(mut starts: Vec<i32>, mut neighbours: Vec<i32>) -> Option<Vec<i32>> {
    let mut n = i32::try_from(starts.len() - 1).ok()?;
    i32::try_from(neighbours.len()).ok()?;
    if neighbours.is_empty() {
        return None;
    }
    let mut order = vec![0; n as usize];
    let mut inverse = vec![0; n as usize];
    let _guard = METIS_LOCK.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
    // SAFETY: METIS_NodeND reads `starts` (n + 1 ascending offsets, the last equal to the length of
    // `neighbours`) and `neighbours` (indices in 0..n, symmetric, no loops), takes null for "no weights" and
    // "default options", and writes n numbers to each of `order` and `inverse`. All outlive the call, none
    // alias, and no pointer is kept.
    #[allow(unsafe_code)]
    let status = unsafe {
        metis_sys::METIS_NodeND(
            &mut n,
            starts.as_mut_ptr(),
            neighbours.as_mut_ptr(),
            std::ptr::null_mut(),
            std::ptr::null_mut(),
            order.as_mut_ptr(),
            inverse.as_mut_ptr(),
        )
    };
    (status == metis_sys::rstatus_et_METIS_OK).then_some(order)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fem::Model;

    #[test]
    fn nodes_are_neighbours_where_any_of_their_dofs_meet() {
        // Nodes 4 (x, y), 5 (x) and 9 (y): 4x meets 5x, 4y meets 9y.
        let dof_nodes = [4, 4, 5, 9];
        let couplings = [(0, 2), (2, 0), (1, 3), (3, 1)].map(|(i, j)| (i, j, 1.0));
        let pencil = Pencil::from_triplets(4, &[], &couplings).unwrap();
        let first = first_dofs(&dof_nodes);
        assert_eq!(first, [0, 2, 3, 4]);
        let (starts, neighbours) = node_graph(pencil.mass().pattern(), &dof_nodes, &first);
        assert_eq!((starts, neighbours), (vec![0, 2, 3, 4], vec![1, 2, 0, 0]));
    }

    #[test]
    fn indices_of_both_widths_find_the_same_structure() {
        let mesh = crate::mesh::block([1.0, 0.2, 0.2], [6, 3, 3], crate::mesh::Order::Quadratic);
        let held = mesh.nodes.iter().flat_map(|node| [node[0] == 0.0; 3]).collect::<Vec<_>>();
        let rubber = crate::fem::Material::isotropic(1e7, 0.3, 1000.0);
        let model = Model::assemble(mesh, &[rubber], &held).unwrap();
        let pattern = model.pencil().mass().pattern();
        let order = dissection_order(pattern, model.pencil().dof_nodes().unwrap()).unwrap();
        for order in [Some(order), None] {
            let [narrow, wide] =
                [structure_under, wide_structure].map(|find| find(pattern, order.clone()).unwrap());
            assert_eq!(narrow.order(), wide.order());
            let groups = |s: &Supernodes| -> Vec<(usize, Vec<u32>)> {
                s.groups.iter().map(|group| (group.columns, s.rows(group).to_vec())).collect()
            };
            assert!(narrow.len() > 100_000 && groups(&narrow) == groups(&wide));
        }
    }
}
