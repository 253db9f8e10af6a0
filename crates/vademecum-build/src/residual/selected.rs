//! Residual blocks at all loadable nodes at once, from entries of `K⁻¹` and `K⁻¹MK⁻¹` on the pattern of the
//! factor.
//!
//! Nodes of a facet are neighbours in `K`, so their blocks are on the pattern. What the modes take of them
//! is often all but a thousandth, and the factor is off by its rounding, times the condition of `K`, along
//! the lowest modes. So nothing is subtracted by formula: with `F = KBΛ⁻¹` as it is in memory, `Z` the
//! inverse of the factor as it is, and `P = I − BFᵀ`
//!
//! ```text
//! R = P Z Pᵀ = Z − B Aᵀ − A Bᵀ + B (FᵀA) Bᵀ                     A = Z F
//! G = R M R = P H Pᵀ      H = ZMZ − A Aᵀ − A qᵀ − q Aᵀ          q = Z (MB − F)
//! ```
//!
//! Both hold for every `Z` and every basis with `BᵀMB = I`; an error of `Z` along `B` falls out. `A` and `q`
//! are a solve for each mode, `H F` follows from them and one more solve, `t = Z M (BΛ⁻¹ − A)`:
//!
//! ```text
//! H F = A (Λ⁻¹ − AᵀF − qᵀF) + q (Λ⁻¹ − AᵀF) − t
//! ```
//!
//! The rounding that is left is a small multiple of that of `Z`, not of `R`. It is measured at a few nodes
//! against solves, and where it would show, the nodes are solved for.

use std::time::Instant;

use faer::{Mat, MatRef};

use super::complement::{ResidualOperator, columns_of};
use super::error::ResidualError;
use super::small::{Symmetric, semidefinite, symmetric};
use super::sweep::{AtNode, note_long, sweep};
use super::way::selection_to_solves;
use crate::fem::{Factor, SelectedInverse, Solve, Symbolic};
use crate::linalg::sequential_product;
use crate::parallel;
use crate::prepared::Body;
use crate::progress::{Listener, Quiet};

/// Nodes at which the rounding is measured: three groups of right-hand sides.
const WITNESSES: usize = 8;
/// Largest relative error of `R` from rounding: well below what single precision keeps of it.
const RESIDUAL_LOSS: f64 = 1e-6;
/// Largest relative error of `G`: it is a bound, and its root is read to two digits.
const GRAM_LOSS: f64 = 1e-3;

/// Blocks for a contact: `R` of the node, and of the pairs in which it is the second.
pub(super) type Blocks = (Symmetric, Vec<[f64; 9]>);

/// Blocks of a node from the columns of three forces at it.
pub(super) fn blocks(
    complement: &ResidualOperator<'_>,
    nodes: &[u32],
    firsts: &[Vec<u32>],
    place: usize,
    columns: MatRef<'_, f64>,
) -> Blocks {
    let own = complement.rows(columns, nodes[place]);
    let others = firsts[place].iter().map(|&first| complement.rows(columns, nodes[first as usize]));
    (semidefinite(symmetric(&own)), others.collect())
}

/// `K⁻¹MK⁻¹` of each node.
pub(super) fn static_answers(
    body: &Body,
    factor: Factor,
    nodes: &[u32],
    listener: &dyn Listener,
) -> Result<Vec<Symmetric>, ResidualError> {
    let selected = factor.select(body.model.pencil().mass(), free_rows(body, nodes), listener)?;
    let at = |place: usize| symmetric(&nine(body, [nodes[place]; 2], |i, j| selected.weighted(i, j)));
    Ok(parallel::map(nodes.len(), &at))
}

/// The free dofs of nodes.
pub(super) fn free_rows(body: &Body, nodes: &[u32]) -> impl Iterator<Item = usize> {
    let components = nodes.iter().flat_map(|&node| (0..3).map(move |c| 3 * node as usize + c));
    components.flat_map(|dof| body.model.dofs().terms(dof)).map(|(free, _)| free as usize)
}

/// Low-rank correction of the blocks on the pattern: rows of the loadable nodes.
struct LoadableRows {
    /// `B`, `A − ½ B (FᵀA)`, `A`, `q`, `H F − ½ B (FᵀHF)`.
    vectors: Mat<f64>,
    half: Mat<f64>,
    answers: Mat<f64>,
    off: Mat<f64>,
    slopes: Mat<f64>,
}

impl LoadableRows {
    fn new(complement: &ResidualOperator<'_>) -> Self {
        let (vectors, mass) = (complement.vectors(), complement.pencil().mass());
        let r = vectors.ncols();
        let compliance = |k: usize| complement.compliances()[k];
        let scale = |m: &mut Mat<f64>| {
            for k in 0..r {
                m.col_as_slice_mut(k).iter_mut().for_each(|x| *x *= compliance(k));
            }
        };
        let weigh = |m: MatRef<'_, f64>| {
            let mut image = Mat::zeros(m.nrows(), r);
            columns_of(m, image.as_mut(), |from, to| mass.mul_into(from, to));
            image
        };
        let mut solve = Solve::new(complement.factor().symbolic(), r, false);
        let mut solved = |mut m: Mat<f64>| {
            solve.solve_in_place(complement.factor(), m.as_mut());
            m
        };
        let mut forces = complement.images().to_owned();
        scale(&mut forces);
        let answers = solved(forces.clone());
        let off = solved(weigh(vectors) - &forces);
        let mut lost = vectors.to_owned();
        scale(&mut lost);
        lost -= &answers;
        let lost = solved(weigh(lost.as_ref()));

        let own = sequential_product(answers.transpose(), forces.as_ref());
        let other = sequential_product(off.transpose(), forces.as_ref());
        let left = Mat::from_fn(r, r, |i, j| if i == j { compliance(i) } else { 0.0 } - own[(i, j)]);
        let slopes = &answers * (&left - other) + &off * &left - lost;
        let curve = sequential_product(forces.transpose(), slopes.as_ref());
        let halved = |m: &Mat<f64>| Mat::from_fn(r, r, |i, j| 0.25 * (m[(i, j)] + m[(j, i)]));
        let half = &answers - vectors * halved(&own);
        let slopes = slopes - vectors * halved(&curve);
        Self { vectors: vectors.to_owned(), half, answers, off, slopes }
    }

    /// Correction of `Z` between two dofs.
    fn of_inverse(&self, i: usize, j: usize) -> f64 {
        let [b, v] = [&self.vectors, &self.half];
        (0..b.ncols()).map(|k| b[(i, k)] * v[(j, k)] + v[(i, k)] * b[(j, k)]).sum()
    }

    /// Correction of `Z M Z` between two dofs.
    fn of_weighted(&self, i: usize, j: usize) -> f64 {
        let [b, a, q, u] = [&self.vectors, &self.answers, &self.off, &self.slopes];
        let modal = |k: usize| a[(i, k)] * a[(j, k)] + (a[(i, k)] * q[(j, k)] + q[(i, k)] * a[(j, k)]);
        let along = |k: usize| b[(i, k)] * u[(j, k)] + u[(i, k)] * b[(j, k)];
        (0..b.ncols()).map(|k| modal(k) + along(k)).sum()
    }
}

/// Nine numbers between two nodes, row by row, from those between free dofs; nothing where a component is
/// held. Free dofs that nodes of one facet follow are coupled by its element.
fn nine(body: &Body, [first, second]: [u32; 2], of: impl Fn(usize, usize) -> Option<f64>) -> [f64; 9] {
    let dofs = body.model.dofs();
    let between = |i: usize, j: usize| of(i, j).expect("nodes of one facet are neighbours");
    std::array::from_fn(|at| {
        let row = |i: usize| dofs.value(3 * second as usize + at % 3, |j| between(i, j));
        dofs.value(3 * first as usize + at / 3, row)
    })
}

/// One node, and how large what it is subtracted from is.
struct NodeEntry {
    node: AtNode<Blocks>,
    inverse: f64,
}

/// Blocks, `G` and `K⁻¹MK⁻¹` of each node, as [`sweep`] finds them with [`blocks`]; uses up the factor.
pub(super) fn selected(
    body: &Body,
    symbolic: &Symbolic,
    mut complement: ResidualOperator<'_>,
    (nodes, firsts): (&[u32], &[Vec<u32>]),
    listener: &dyn Listener,
) -> Result<Vec<AtNode<Blocks>>, ResidualError> {
    let swept = |complement: &ResidualOperator<'_>, places: &[usize], listener: &dyn Listener| {
        let some: Vec<u32> = places.iter().map(|&place| nodes[place]).collect();
        sweep(complement, &some, listener, |at, columns| {
            blocks(complement, nodes, firsts, places[at], columns)
        })
    };
    let count = WITNESSES.min(nodes.len());
    let witnesses: Vec<usize> = (0..count).map(|k| (2 * k + 1) * nodes.len() / (2 * count)).collect();
    let start = Instant::now();
    let witnessed = swept(&complement, &witnesses, &Quiet(listener))?;
    let r = complement.compliances().len();
    note_long(start.elapsed().as_secs_f64() * selection_to_solves(symbolic, r, count), nodes.len(), listener);

    let taken = LoadableRows::new(&complement);
    let factor = complement.take_factor()?;
    let selected = factor.select(body.model.pencil().mass(), free_rows(body, nodes), listener)?;
    let at = |place: usize| at_node(body, &selected, &taken, (nodes, firsts), place);
    let mut found: Vec<NodeEntry> = parallel::map(nodes.len(), &at);
    drop((selected, taken));

    let noise = RoundingError::new(&found, &witnesses, &witnessed);
    let doubtful: Vec<bool> = found.iter().map(|found| noise.shows(found)).collect();
    // A pair is found with its second node.
    let again =
        |&place: &usize| doubtful[place] || firsts[place].iter().any(|&first| doubtful[first as usize]);
    let again: Vec<usize> = (0..nodes.len()).filter(again).collect();
    if !again.is_empty() {
        complement.restore_factor()?;
        for (&place, node) in again.iter().zip(swept(&complement, &again, listener)?) {
            found[place].node = node;
        }
    }
    Ok(found.into_iter().map(|found| found.node).collect())
}

/// The blocks of one node.
fn at_node(
    body: &Body,
    selected: &SelectedInverse,
    taken: &LoadableRows,
    (nodes, firsts): (&[u32], &[Vec<u32>]),
    place: usize,
) -> NodeEntry {
    let node = nodes[place];
    let left = |i: usize, j: usize| Some(selected.inverse(i, j)? - taken.of_inverse(i, j));
    let own = semidefinite(symmetric(&nine(body, [node; 2], left)));
    let pair = |&first: &u32| nine(body, [nodes[first as usize], node], left);
    let others = firsts[place].iter().map(pair).collect();
    let gram = |i: usize, j: usize| Some(selected.weighted(i, j)? - taken.of_weighted(i, j));
    let gram = symmetric(&nine(body, [node; 2], gram));
    let answer = symmetric(&nine(body, [node; 2], |i, j| selected.weighted(i, j)));
    let inverse = largest(&symmetric(&nine(body, [node; 2], |i, j| selected.inverse(i, j))));
    NodeEntry { node: AtNode { taken: (own, others), gram, answer }, inverse }
}

/// Rounding error of entries, relative to their minuends.
struct RoundingError {
    inverse: f64,
    weighted: f64,
}

impl RoundingError {
    fn new(found: &[NodeEntry], places: &[usize], exact: &[AtNode<Blocks>]) -> Self {
        let mut noise = Self { inverse: 0.0, weighted: 0.0 };
        for (&place, exact) in places.iter().zip(exact) {
            let NodeEntry { node, inverse } = &found[place];
            let off = |a: &Symmetric, b: &Symmetric| largest(&std::array::from_fn(|k| a[k] - b[k]));
            let share = |off: f64, whole: f64| if whole > 0.0 { off / whole } else { 0.0 };
            noise.inverse = noise.inverse.max(share(off(&node.taken.0, &exact.taken.0), *inverse));
            noise.weighted = noise.weighted.max(share(off(&node.gram, &exact.gram), largest(&node.answer)));
        }
        noise
    }

    /// True if it is more than may be lost of the blocks of a node.
    fn shows(&self, NodeEntry { node, inverse }: &NodeEntry) -> bool {
        self.inverse * inverse > RESIDUAL_LOSS * largest(&node.taken.0)
            || self.weighted * largest(&node.answer) > GRAM_LOSS * largest(&node.gram)
    }
}

/// The largest entry.
fn largest(a: &Symmetric) -> f64 {
    a.iter().fold(0.0, |largest, x| x.abs().max(largest))
}
