//! Choice between solves and selected inversion for the blocks at the loadable nodes.

use crate::fem::Symbolic;
use crate::prepared::Body;

/// Time of a multiplication in a solve relative to one in a dense product: a solve of a few columns
/// waits for the memory of the factor.
const SOLVE: f64 = 2.0;
/// Multiplications of a mode with a column, as a column is projected twice and its `G` taken.
const PROJECTIONS: f64 = 6.0;

/// Method for the blocks at the loadable nodes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
pub(crate) enum BlockMethod {
    /// Three right-hand sides for each node.
    Solves,
    /// Entries of `K⁻¹` and `K⁻¹MK⁻¹` on the pattern of the factor, whatever the number of nodes.
    Selection,
}

impl BlockMethod {
    /// The cheaper one for `r` modes and `nodes` nodes, by the multiplications of both. Matrices of another
    /// program are solved with: nodes that are neighbours on the surface need not be coupled in them. A
    /// factor on several ranks or in single precision is solved with too: its entries are not here or not
    /// exact.
    pub(crate) fn cheaper(body: &Body, symbolic: &Symbolic, r: usize, nodes: usize) -> Self {
        let assembled = !body.model.mesh().elements.is_empty();
        let selects = assembled && symbolic.has_entries() && selection_to_solves(symbolic, r, nodes) < 1.0;
        if selects { Self::Selection } else { Self::Solves }
    }
}

/// Time of a selected inversion relative to solves at `nodes` nodes.
pub(super) fn selection_to_solves(symbolic: &Symbolic, r: usize, nodes: usize) -> f64 {
    let solve = SOLVE * 2.0 * (symbolic.factor_bytes() / size_of::<f64>()) as f64;
    let column = solve + PROJECTIONS * r as f64 * symbolic.n() as f64;
    (symbolic.select_work() + 3.0 * r as f64 * solve) / (3.0 * nodes.max(1) as f64 * column)
}
