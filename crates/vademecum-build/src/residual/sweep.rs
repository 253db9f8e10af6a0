//! Residual answers in batches: one group of columns per thread is in memory at a time.

use std::time::Instant;

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatRef, Par};

use super::complement::ResidualOperator;
use super::error::ResidualError;
use super::small::{Symmetric, symmetric};
use crate::dynamics::time_in_words;
use crate::parallel;
use crate::progress::Listener;

/// Data kept of the responses to forces at one node.
pub(super) struct AtNode<T> {
    /// Data that the caller extracted from the three columns `R e`.
    pub(crate) taken: T,
    /// `(R e)ᵀ M (R e)`.
    pub(crate) gram: Symmetric,
    /// `(K⁻¹e)ᵀ M (K⁻¹e)`.
    pub(crate) answer: Symmetric,
}

/// The columns of `R` at each node, shape (n, 3), shown to `take` with the place of the node; nodes in order.
pub(super) fn sweep<T: Send>(
    complement: &ResidualOperator<'_>,
    nodes: &[u32],
    listener: &dyn Listener,
    take: impl Fn(usize, MatRef<'_, f64>) -> T + Sync,
) -> Result<Vec<AtNode<T>>, ResidualError> {
    let at_once = (complement.columns_at_once() / 3).min(nodes.len());
    let mut memory = complement.workspace(3 * at_once);
    let mut found = Vec::with_capacity(nodes.len());
    let start = Instant::now();
    for (batch, some) in nodes.chunks(at_once.max(1)).enumerate() {
        listener.checkpoint(found.len(), nodes.len())?;
        if batch == 1 {
            let seconds = start.elapsed().as_secs_f64() * nodes.len() as f64 / at_once as f64;
            note_long(seconds, nodes.len(), listener);
        }
        let used = 3 * some.len();
        complement.fill_units(&mut memory, some);
        complement.apply(&mut memory, used);
        complement.weigh(&mut memory, used);
        let (columns, weighed) = (memory.columns.as_ref(), memory.images.as_ref());
        let at = |place: usize| {
            let node = some[place];
            let [own, weighed] = [columns, weighed].map(|m| m.subcols(3 * place, 3));
            let gram = product(own, weighed);
            // K⁻¹e = R e + B c, and BᵀMB = I.
            let (modal, overlap) = (complement.modal(node), complement.project(weighed));
            let [twice, modes] =
                [product(modal.as_ref(), overlap.as_ref()), product(modal.as_ref(), modal.as_ref())];
            let answer = std::array::from_fn(|k| gram[k] + 2.0 * twice[k] + modes[k]);
            AtNode { taken: take(batch * at_once + place, own), gram, answer }
        };
        found.extend(parallel::map(some.len(), &at));
    }
    listener.checkpoint(nodes.len(), nodes.len())?;
    Ok(found)
}

/// Announces what takes more than a minute.
pub(super) fn note_long(seconds: f64, nodes: usize, listener: &dyn Listener) {
    if seconds > 60.0 {
        let time = time_in_words(seconds);
        listener.note(&format!("static answers at {nodes} loadable nodes: about {time}"));
    }
}

/// `R` of each of `count` loads, which `fill` adds to zeros, shown to `take` as one column; loads in order.
pub(super) fn answers<T: Send>(
    complement: &ResidualOperator<'_>,
    count: usize,
    fill: impl Fn(usize, &mut [f64]),
    listener: &dyn Listener,
    take: impl Fn(MatRef<'_, f64>) -> T + Sync,
) -> Result<Vec<T>, ResidualError> {
    let at_once = complement.columns_at_once().min(count);
    let mut memory = complement.workspace(at_once);
    let mut found = Vec::with_capacity(count);
    while found.len() < count {
        listener.checkpoint(found.len(), count)?;
        let some = at_once.min(count - found.len());
        for column in 0..some {
            let load = memory.columns.col_as_slice_mut(column);
            load.fill(0.0);
            fill(found.len() + column, load);
        }
        complement.apply(&mut memory, some);
        let columns = memory.columns.as_ref();
        found.extend(parallel::map(some, &|column| take(columns.subcols(column, 1))));
    }
    Ok(found)
}

/// The symmetric part of `AᵀB`, for two matrices of three columns.
fn product(a: MatRef<'_, f64>, b: MatRef<'_, f64>) -> Symmetric {
    let mut product = Mat::zeros(3, 3);
    if a.nrows() > 0 {
        matmul(product.as_mut(), Accum::Replace, a.transpose(), b, 1.0, Par::Seq);
    }
    symmetric(&std::array::from_fn(|at| product[(at / 3, at % 3)]))
}
