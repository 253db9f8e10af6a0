//! The residual flexibility: what a basis leaves out of the answer to a load that stays.
//!
//! ```text
//! R = K⁻¹ − B Λ⁻¹ Bᵀ        Λ = BᵀKB, diagonal
//! ```
//!
//! `R` is symmetric and positive semidefinite for every basis: it is `K⁻¹` after a projection that is
//! orthogonal in `K` (MacNeal 1971; Rubin 1975; Craig and Chang 1977). A file keeps the blocks that a contact
//! needs. `‖R F‖_M`, as a share of the static answer `‖K⁻¹F‖_M`, is also the bound of what the basis can miss
//! after a jump of the load.

mod basis;
mod bound;
mod complement;
mod count;
mod error;
mod further;
mod live;
mod near;
mod patch;
mod ports;
mod selected;
mod small;
mod stress;
mod sweep;
mod way;

pub(crate) use basis::ResidualBasis;
pub(crate) use bound::StaticBound;
pub(crate) use count::ModeSearch;
pub(crate) use count::modes_within;
pub use error::ResidualError;
pub(crate) use live::{ScaleTerm, residual_traces, scale_terms};
pub(crate) use near::Reaches;
pub(crate) use patch::{PatchFlexibility, patch_flexibility};
pub(crate) use ports::{PortFlexibility, port_flexibility};
pub(crate) use stress::{StressFlexibility, stress_residual};
pub(crate) use way::BlockMethod;

use crate::prepared::Body;
use crate::progress::Listener;

use bound::relative_bound;
use complement::ResidualOperator;
use faer::MatRef;
use selected::{Blocks, blocks, free_rows, selected};
use small::{Symmetric, semidefinite};
use sweep::{AtNode, answers, sweep};

/// `R` where a file keeps it, and its bound.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
#[doc(alias("static residual", "residual attachment modes", "static correction", "mode acceleration"))]
pub(crate) struct ResidualFlexibility {
    /// `R` between each loadable node and itself \[m/N\].
    pub(crate) contact: Vec<Symmetric>,
    /// Pairs of loadable nodes with a loadable facet in common, the first below the second, ascending.
    pub(crate) pairs: Vec<[u32; 2]>,
    /// `R` of each pair \[m/N\]: row the displacement at the first, column the force at the second.
    pub(crate) pair_blocks: Vec<[f64; 9]>,
    /// Per probe, its value under unit forces at each loadable node \[m/N\].
    pub(crate) probes: Vec<Vec<[f64; 3]>>,
    /// Per pattern, the displacement `R F_p` of each loadable node \[m\].
    pub(crate) patterns: Vec<Vec<[f64; 3]>>,
    /// Per pattern, the value of each probe under `R F_p` \[m\].
    pub(crate) pattern_probes: Vec<Vec<f64>>,
    /// `G = RᵀMR` of each loadable node \[kg m²/N²\].
    pub(crate) gram: Vec<Symmetric>,
    /// Largest relative bound of each loadable node.
    pub(crate) at_nodes: Vec<f64>,
    /// The bound over all of them.
    pub(crate) bound: StaticBound,
}

/// Bytes for the residual of `r` modes at the loadable nodes and at the ports, in addition to one factor.
pub fn memory(body: &Body, symbolic: &crate::fem::Symbolic, r: usize) -> f64 {
    let nodes = body.load_nodes.len();
    let column = size_of::<f64>() as f64 * symbolic.n() as f64;
    let solves = 4.0 * column * ResidualOperator::at_once(symbolic) as f64;
    // Answers to a force along each row, where they are found, side by side, and weighed.
    let rows: usize = body.ports.iter().map(|port| port.rows.len()).sum();
    let ports = if rows > 0 { solves + 3.0 * column * rows as f64 } else { 0.0 };
    let at_nodes = match BlockMethod::cheaper(body, symbolic, r, nodes) {
        BlockMethod::Solves => solves,
        // What is taken of the entries, and memory to find it.
        BlockMethod::Selection => {
            let selection = symbolic.select_bytes(free_rows(body, &body.load_nodes));
            8.0 * column * r as f64 + solves.max(selection as f64)
        }
    };
    at_nodes.max(ports)
}

/// The residual at the loadable nodes, given in the order in which they are counted, and between those of
/// `pairs`, which name their places: neighbours in the stiffness, each pair once, the first below the second,
/// ascending.
///
/// One solve for each probe and pattern; at the nodes one for each component, or a selected inversion. The
/// bytes do not depend on the number of threads.
///
/// # Errors
/// [`ResidualError`].
pub(crate) fn residual_flexibility(
    reduced: &ResidualBasis<'_>,
    way: BlockMethod,
    nodes: &[u32],
    pairs: &[[u32; 2]],
    listener: &dyn Listener,
) -> Result<ResidualFlexibility, ResidualError> {
    let body = reduced.body;
    let complement = ResidualOperator::new(reduced)?;
    let firsts = &firsts_of(pairs, nodes.len());
    let n_probes = body.probes.len();
    let fill = |place: usize, load: &mut [f64]| match body.probes.get(place) {
        Some(probe) => complement.add_probe(probe, load),
        None => load.copy_from_slice(&body.patterns[place - n_probes].1),
    };
    let rows = answers(&complement, n_probes + body.patterns.len(), fill, listener, |column| {
        let at = |&node: &u32| complement.row(column, node);
        (nodes.iter().map(at).collect::<Vec<[f64; 3]>>(), complement.probe_values(column))
    })?;
    let found = at_nodes(reduced, way, complement, (nodes, firsts), listener)?;
    let mut rows = rows.into_iter();
    let probes = rows.by_ref().take(body.probes.len()).map(|(at_nodes, _)| at_nodes).collect();
    let (patterns, pattern_probes) = rows.unzip();

    let mut pair_blocks = vec![[0.0; 9]; pairs.len()];
    let mut contact = vec![];
    let (mut gram, mut answer) = (vec![], vec![]);
    for (place, node) in found.into_iter().enumerate() {
        let (own, others) = node.taken;
        contact.push(own);
        for (&first, block) in firsts[place].iter().zip(others) {
            let pair = pairs.binary_search(&[first, place as u32]).expect("a pair of the list");
            pair_blocks[pair] = block;
        }
        gram.push(semidefinite(node.gram));
        answer.push(node.answer);
    }
    let (at_nodes, bound) = bound_of(reduced.rigorous, &gram, &answer);
    Ok(ResidualFlexibility {
        contact,
        pairs: pairs.to_vec(),
        pair_blocks,
        probes,
        patterns,
        pattern_probes,
        gram,
        at_nodes,
        bound,
    })
}

/// The bound alone, at the same nodes.
///
/// # Errors
/// [`ResidualError`].
pub(crate) fn static_bound(
    reduced: &ResidualBasis<'_>,
    nodes: &[u32],
    listener: &dyn Listener,
) -> Result<StaticBound, ResidualError> {
    let way = BlockMethod::cheaper(reduced.body, reduced.symbolic, reduced.eigenvalues.len(), nodes.len());
    let firsts = &firsts_of(&[], nodes.len());
    let found = at_nodes(reduced, way, ResidualOperator::new(reduced)?, (nodes, firsts), listener)?;
    let (gram, answer): (Vec<_>, Vec<_>) =
        found.into_iter().map(|node| (semidefinite(node.gram), node.answer)).unzip();
    Ok(bound_of(reduced.rigorous, &gram, &answer).1)
}

/// Blocks, `G` and `K⁻¹MK⁻¹` of each node.
fn at_nodes(
    reduced: &ResidualBasis<'_>,
    way: BlockMethod,
    complement: ResidualOperator<'_>,
    (nodes, firsts): (&[u32], &[Vec<u32>]),
    listener: &dyn Listener,
) -> Result<Vec<AtNode<Blocks>>, ResidualError> {
    let taken = |place: usize, columns: MatRef<'_, f64>| blocks(&complement, nodes, firsts, place, columns);
    match way {
        BlockMethod::Solves => sweep(&complement, nodes, listener, taken),
        BlockMethod::Selection => {
            selected(reduced.body, reduced.symbolic, complement, (nodes, firsts), listener)
        }
    }
}

/// The largest relative bound of each node, and the bound over all of them.
fn bound_of(rigorous: bool, gram: &[Symmetric], answer: &[Symmetric]) -> (Vec<f64>, StaticBound) {
    let at_nodes: Vec<f64> = gram.iter().zip(answer).map(|(g, s)| relative_bound(g, s)).collect();
    let bound = StaticBound::new(rigorous, gram, answer, &at_nodes);
    (at_nodes, bound)
}

/// For each node the first nodes of the pairs in which it is the second.
fn firsts_of(pairs: &[[u32; 2]], count: usize) -> Vec<Vec<u32>> {
    let mut firsts = vec![vec![]; count];
    pairs.iter().for_each(|&[first, second]| firsts[second as usize].push(first));
    firsts
}

#[cfg(test)]
mod tests;
