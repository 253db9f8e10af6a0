//! The residual flexibility between loadable nodes that are near each other.
//!
//! With the modes `Φ` that follow those of the file, what is left of a residual is
//! `R' = R − Φ Λ⁻¹ Φᵀ`. A file keeps the rows `Φ Λ^-½` of all loadable nodes, and `R'` of near ones. A reader
//! multiplies the block of two contacts by a positive definite function of their distance, which ends where
//! the pairs do: the product is semidefinite (Schur 1911; as in covariance tapering, Furrer, Genton and
//! Nychka 2006).

use std::time::Instant;

use faer::{Mat, MatRef};

use super::basis::ResidualBasis;
use super::complement::ResidualOperator;
use super::error::ResidualError;
use super::further::modes_beside;
use super::small::{full, symmetric};
use super::sweep::note_long;
use crate::dynamics::Modes;
use crate::parallel;
use crate::progress::Listener;

/// The residual between near nodes, where a file keeps it.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub(crate) struct PatchFlexibility {
    /// Number of further modes, `m`.
    pub(crate) n_modes: usize,
    /// Rows of `Φ Λ^-½` at the loadable nodes \[m/N^½\], shape (nodes, 3, m).
    pub(crate) modes: Vec<f64>,
    /// `R'` of each pair \[m/N\]: row the displacement at the first, column the force at the second.
    pub(crate) blocks: Vec<[f64; 9]>,
}

/// The residual between the loadable nodes of `pairs`, the first at most the second, beside the modes that
/// `found` has more than the basis, if any.
///
/// A solve for each component of each node. The bytes do not depend on the number of threads.
///
/// # Errors
/// [`ResidualError`].
pub(crate) fn patch_flexibility(
    reduced: &ResidualBasis<'_>,
    found: Option<&Modes>,
    nodes: &[u32],
    pairs: &[[u32; 2]],
    listener: &dyn Listener,
) -> Result<PatchFlexibility, ResidualError> {
    let ResidualBasis { pencil, vectors, eigenvalues, .. } = *reduced;
    let (further, values) = match found {
        Some(found) => modes_beside(pencil, vectors, found)?,
        None => (Mat::zeros(pencil.n_dof(), 0), vec![]),
    };
    let both = beside(vectors, further.as_ref());
    let all: Vec<f64> = eigenvalues.iter().chain(&values).copied().collect();
    let operator =
        ResidualOperator::new(&ResidualBasis { vectors: both.as_ref(), eigenvalues: &all, ..*reduced })?;

    // For each node the pairs in which it is the second.
    let mut firsts = vec![vec![]; nodes.len()];
    pairs.iter().enumerate().for_each(|(at, pair)| firsts[pair[1] as usize].push((pair[0], at)));
    let mut blocks = vec![[0.0; 9]; pairs.len()];
    let at_once = (operator.columns_at_once() / 3).min(nodes.len()).max(1);
    let mut memory = operator.workspace(3 * at_once);
    let start = Instant::now();
    for (batch, some) in nodes.chunks(at_once).enumerate() {
        let done = batch * at_once;
        listener.checkpoint(done, nodes.len())?;
        if batch == 1 {
            let seconds = start.elapsed().as_secs_f64() * nodes.len() as f64 / at_once as f64;
            note_long(seconds, nodes.len(), listener);
        }
        operator.fill_units(&mut memory, some);
        operator.apply(&mut memory, 3 * some.len());
        let columns = memory.columns.as_ref();
        let found = parallel::map(some.len(), &|place| {
            let own = columns.subcols(3 * place, 3);
            let block = |&(first, _): &(u32, usize)| operator.rows(own, nodes[first as usize]);
            firsts[done + place].iter().map(block).collect::<Vec<[f64; 9]>>()
        });
        for (place, found) in found.into_iter().enumerate() {
            for (&(first, at), block) in firsts[done + place].iter().zip(found) {
                let own = first as usize == done + place;
                blocks[at] = if own { flat(full(&symmetric(&block))) } else { block };
            }
        }
    }
    listener.checkpoint(nodes.len(), nodes.len())?;

    let row =
        |node: u32, c: usize, k: usize| operator.value(node, c, |free| further[(free, k)]) / values[k].sqrt();
    let m = values.len();
    let modes = nodes.iter().flat_map(|&node| (0..3 * m).map(move |at| (node, at / m, at % m)));
    let modes = modes.map(|(node, c, k)| row(node, c, k)).collect();
    Ok(PatchFlexibility { n_modes: m, modes, blocks })
}

/// Nine entries, row by row.
fn flat(a: [[f64; 3]; 3]) -> [f64; 9] {
    std::array::from_fn(|at| a[at / 3][at % 3])
}

/// The columns of two matrices beside each other.
fn beside(a: MatRef<'_, f64>, b: MatRef<'_, f64>) -> Mat<f64> {
    let mut both = Mat::zeros(a.nrows(), a.ncols() + b.ncols());
    both.as_mut().subcols_mut(0, a.ncols()).copy_from(a);
    both.as_mut().subcols_mut(a.ncols(), b.ncols()).copy_from(b);
    both
}

#[cfg(test)]
mod tests;
