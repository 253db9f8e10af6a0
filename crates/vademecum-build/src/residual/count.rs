//! As many natural modes as a bound asks for.
//!
//! Static answers are solved for once. With one mode more, `G = (R e)ᵀM(R e)` loses `c cᵀ`, where `c` is the
//! row of the mode at the node over its eigenvalue; so the bounds of every number of modes follow from the
//! answers and the modes without another solve.

use faer::Mat;

use super::basis::ResidualBasis;
use super::bound::relative_bound;
use super::complement::ResidualOperator;
use super::error::ResidualError;
use super::selected::static_answers;
use super::small::{Symmetric, semidefinite};
use super::sweep::sweep;
use super::way::BlockMethod;
use crate::dynamics::{FirstMode, Modes, lowest_modes_kept, search_vectors};
use crate::fem::Symbolic;
use crate::limits::Memory;
use crate::parallel;
use crate::prepared::Body;
use crate::progress::Listener;
use crate::store::CachedSolves;

/// Natural modes tried first.
const FIRST: usize = 16;

/// Nodes that one parallel task handles.
const CHUNK: usize = 64;
/// Natural modes at most: beyond them every mode more takes next to nothing off the bound.
const MAX_MODES: usize = 512;

/// The value found.
pub(crate) enum ModeSearch {
    /// The fewest modes that keep the bound, and what they reach.
    Modes(Modes, f64),
    /// So many modes reach no more than this.
    Missed {
        /// Modes tried.
        modes: usize,
        /// The bound they reach.
        reached: f64,
    },
}

/// The fewest natural modes whose relative bound is at most `error` at every loadable node and in every
/// direction; at most 512, and no more than memory holds. Their search keeps its solves while it goes on, and
/// may go on from that for the first mode.
///
/// # Errors
/// [`ResidualError`].
pub(crate) fn modes_within(
    body: &Body,
    symbolic: &Symbolic,
    error: f64,
    listener: &dyn Listener,
    begun: (&CachedSolves<'_>, Option<&FirstMode>),
) -> Result<ModeSearch, ResidualError> {
    let (pencil, nodes) = (body.model.pencil(), &body.load_nodes);
    let none = Mat::<f64>::zeros(pencil.n_dof(), 0);
    let vectors = none.as_ref();
    let nothing = ResidualBasis { body, pencil, symbolic, vectors, eigenvalues: &[], rigorous: false };
    let mut complement = ResidualOperator::new(&nothing)?;
    let answers: Vec<Symmetric> = match BlockMethod::cheaper(body, symbolic, 0, nodes.len()) {
        BlockMethod::Solves => {
            let found = sweep(&complement, nodes, listener, |_, _| ())?;
            found.into_iter().map(|node| node.answer).collect()
        }
        BlockMethod::Selection => static_answers(body, complement.take_factor()?, nodes, listener)?,
    };
    let limit = Memory::asked_or_available(None).limit() as f64;
    let mut missed = 0;
    let mut count = FIRST.min(pencil.n_elastic());
    loop {
        let modes = lowest_modes_kept(pencil, symbolic, count, begun)?;
        // From the beginning: two modes of one frequency may have turned.
        let mut grams = answers.clone();
        let mut reached = f64::INFINITY;
        for k in 0..count {
            let column = modes.vectors.col_as_slice(k);
            let take = |gram: &mut Symmetric, node: u32| {
                let at = |c| complement.value(node, c, |free| column[free]);
                let [x, y, z] = [0, 1, 2].map(|c| at(c) / modes.eigenvalues[k]);
                let own = [x * x, x * y, x * z, y * y, y * z, z * z];
                gram.iter_mut().zip(own).for_each(|(g, own)| *g -= own);
            };
            let chunks = grams.chunks_mut(CHUNK).zip(nodes.chunks(CHUNK)).zip(answers.chunks(CHUNK));
            let bounds = parallel::map_of(chunks, &|_, ((grams, nodes), answers)| {
                grams.iter_mut().zip(nodes).for_each(|(gram, &node)| take(gram, node));
                let bound =
                    |(gram, answer): (&Symmetric, &Symmetric)| relative_bound(&semidefinite(*gram), answer);
                if k < missed { 0.0 } else { grams.iter().zip(answers).map(bound).fold(0.0, f64::max) }
            });
            if k < missed {
                continue;
            }
            reached = bounds.into_iter().fold(0.0, f64::max);
            if reached <= error {
                return Ok(ModeSearch::Modes(first(modes, k + 1), reached));
            }
        }
        missed = count;
        let next = (2 * count).min(MAX_MODES).min(pencil.n_elastic());
        let bytes = 8.0 * (pencil.n_dof() * search_vectors(next)) as f64;
        if next == count || bytes > limit {
            return Ok(ModeSearch::Missed { modes: count, reached });
        }
        listener.note(&format!("{count} natural modes have a bound of {reached:.2e}: trying {next}"));
        count = next;
    }
}

/// The first modes of a list.
fn first(modes: Modes, count: usize) -> Modes {
    let Modes { mut eigenvalues, vectors, mut residuals } = modes;
    eigenvalues.truncate(count);
    residuals.truncate(count);
    Modes { eigenvalues, vectors: vectors.subcols(0, count).to_owned(), residuals }
}
