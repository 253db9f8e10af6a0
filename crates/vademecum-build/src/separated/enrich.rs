//! Greedy enrichment: one rank-one term at a time by alternating directions, eqs. (5.11)–(5.13) of the
//! chapter.
//!
//! A new term is the Galerkin fixed point: every direction is solved with all the others frozen and the same
//! frozen functions as weights (eq. 5.13), sweep after sweep. Terms already found join the right-hand side
//! with a minus sign (the last line of eq. 5.12). What the chapter lacks, and what makes the method usable at
//! small tolerances, is the update: after each new term all factors on one axis at a time are solved for
//! again, together.

use super::error::SeparatedError;
use super::greedy::{EnrichmentOptions, EnrichmentReport, Progress, StopReason};
use super::kronecker::KroneckerProblem;
use super::linalg::{column, dot, inner, norm, product, transposed_product};
use super::operator::AxisOperator;
use super::solution::Separated;
use super::space::Space;
use super::update::update;
use crate::linalg::Random;
use faer::{Mat, MatRef};

/// Enriches from `start` (or from zero) until `measure` (a relative error of a candidate, the caller's
/// choice; without one, the residual at 200 random grid points) meets the tolerance.
///
/// # Errors
/// [`SeparatedError::NotPositiveDefinite`] from the space solves, [`SeparatedError::Shape`] of a start that
/// does not fit.
pub fn enrich<S: Space>(
    problem: &KroneckerProblem<S>,
    options: &EnrichmentOptions,
    start: Option<&Separated>,
    measure: Option<&dyn Fn(&Separated) -> f64>,
) -> Result<(Separated, EnrichmentReport), SeparatedError> {
    let mut random = Random::new(options.seed);
    let probes = problem.random_indices(200, &mut random);
    let measured = |u: &Separated| measure.map_or_else(|| problem.residual(u, &probes), |m| m(u));
    let zero = Separated::zero(&problem.axes, problem.space.n_rows(), problem.n_columns);
    let mut now = start.map_or(Ok(zero.clone()), |s| zero.concatenate(s))?;
    let error = measured(&now);
    let mut progress = Progress::new(now.clone(), error);
    if error <= options.tolerance {
        return Ok(progress.finish(StopReason::Tolerance));
    }
    if now.n_terms() >= options.max_terms {
        return Ok(progress.finish(StopReason::MaxTerms));
    }
    loop {
        let guess = problem.guess(&mut random);
        let Some(term) = next_term(problem, &now, guess, options.max_sweeps)? else {
            return Ok(progress.finish(StopReason::Stagnation));
        };
        now = now.concatenate(&term)?;
        for _ in 0..options.update_sweeps {
            now = update(problem, &now)?;
        }
        if let Some(stop) = progress.record(&now, measured(&now), options) {
            return Ok(progress.finish(stop));
        }
    }
}

/// Sources of the problem that a new term must answer: those given, less the operator on the terms found.
struct Stack {
    /// Per axis `(n_points, n_sources)`.
    vectors: Vec<Mat<f64>>,
    /// `(n_rows · n_columns, n_sources)`.
    blocks: Mat<f64>,
}

impl Stack {
    fn residual<S: Space>(problem: &KroneckerProblem<S>, u: &Separated) -> Stack {
        let (given, terms) = (problem.sources.len(), u.n_terms());
        let total = given + problem.operators.len() * terms;
        let lifted: Vec<Mat<f64>> =
            (0..problem.operators.len()).map(|t| problem.apply_to_blocks(t, u)).collect();
        let n = u.n_rows();
        let blocks = Mat::from_fn(u.blocks().nrows(), total, |j, s| match s.checked_sub(given) {
            None => problem.sources[s].block[(j % n, j / n)],
            Some(k) => -lifted[k / terms][(j, k % terms)],
        });
        let vectors = (0..problem.axes.len()).map(|a| {
            let applied: Vec<Mat<f64>> =
                problem.operators.iter().map(|o| o[a].apply_all(u.factors(a))).collect();
            Mat::from_fn(problem.axes[a].len(), total, |j, s| match s.checked_sub(given) {
                None => problem.sources[s].vectors[a][j],
                Some(k) => applied[k / terms][(j, k % terms)],
            })
        });
        Stack { vectors: vectors.collect(), blocks }
    }

    fn n_sources(&self) -> usize {
        self.blocks.ncols()
    }
}

/// The term that follows those of `found`, by alternating directions from the functions `g`, one per axis;
/// `None` when nothing is left to answer.
pub(super) fn next_term<S: Space>(
    problem: &KroneckerProblem<S>,
    found: &Separated,
    mut g: Vec<Vec<f64>>,
    max_sweeps: usize,
) -> Result<Option<Separated>, SeparatedError> {
    let sources = &Stack::residual(problem, found);
    let axes = problem.axes.len();
    let mut seen: Vec<Vec<f64>> = (0..axes).map(|a| against(&sources.vectors[a], &g[a])).collect();
    let mut energy: Vec<Vec<f64>> = (0..axes).map(|a| problem.energies(a, &g[a])).collect();
    let mut block = solve_block(problem, sources, &seen, &energy)?;
    for _ in 0..max_sweeps {
        if norm(block.as_ref()) == 0.0 {
            return Ok(None);
        }
        let on_block = against_block(&sources.blocks, &block);
        let block_energy: Vec<f64> = (0..problem.operators.len())
            .map(|t| inner(block.as_ref(), problem.space.apply(t, block.as_ref()).as_ref()))
            .collect();
        let mut change = 0.0f64;
        for a in 0..axes {
            let weights: Vec<f64> =
                (0..sources.n_sources()).map(|s| on_block[s] * without(&seen, a, s)).collect();
            let rhs = combination(&sources.vectors[a], &weights);
            let mut operator = AxisOperator::diagonal(vec![0.0; rhs.len()]);
            for (t, o) in problem.operators.iter().enumerate() {
                operator.add(block_energy[t] * without(&energy, a, t), &o[a]);
            }
            let mut new = operator.solve(rhs);
            if !problem.normalise(a, &mut new) {
                return Ok(None);
            }
            change = change.max(distance(&new, &g[a]));
            seen[a] = against(&sources.vectors[a], &new);
            energy[a] = problem.energies(a, &new);
            g[a] = new;
        }
        block = solve_block(problem, sources, &seen, &energy)?;
        // Directions known to a thousandth are good enough: the term is corrected by the next ones or by the
        // update.
        if change < 1e-3 {
            break;
        }
    }
    let factors = g.iter().map(|g| Mat::from_fn(g.len(), 1, |j, _| g[j])).collect();
    let flat =
        Mat::from_fn(block.nrows() * block.ncols(), 1, |j, _| block[(j % block.nrows(), j / block.nrows())]);
    Separated::new(problem.axes.clone(), factors, flat, block.nrows()).map(Some)
}

/// The space direction: one solve with scalar weights.
fn solve_block<S: Space>(
    problem: &KroneckerProblem<S>,
    sources: &Stack,
    seen: &[Vec<f64>],
    energy: &[Vec<f64>],
) -> Result<Mat<f64>, SeparatedError> {
    let weights: Vec<f64> = (0..sources.n_sources()).map(|s| without(seen, usize::MAX, s)).collect();
    let rhs = combination(&sources.blocks, &weights);
    let operator: Vec<f64> = (0..problem.operators.len()).map(|t| without(energy, usize::MAX, t)).collect();
    problem
        .space
        .solve(&operator, MatRef::from_column_major_slice(&rhs, problem.space.n_rows(), problem.n_columns))
}

/// `Π_{b≠a} values[b][s]`.
fn without(values: &[Vec<f64>], a: usize, s: usize) -> f64 {
    values.iter().enumerate().filter(|(b, _)| *b != a).map(|(_, v)| v[s]).product()
}

/// `Vᵀ g`.
fn against(v: &Mat<f64>, g: &[f64]) -> Vec<f64> {
    let p = transposed_product(v.as_ref(), MatRef::from_column_major_slice(g, g.len(), 1));
    column(&p, 0).to_vec()
}

fn against_block(blocks: &Mat<f64>, block: &Mat<f64>) -> Vec<f64> {
    let n = block.nrows();
    let flat: Vec<f64> = (0..n * block.ncols()).map(|j| block[(j % n, j / n)]).collect();
    against(blocks, &flat)
}

/// `V w`.
fn combination(v: &Mat<f64>, w: &[f64]) -> Vec<f64> {
    let sum = product(v.as_ref(), MatRef::from_column_major_slice(w, w.len(), 1));
    column(&sum, 0).to_vec()
}

/// Distance of two unit functions up to sign, entry by entry.
fn distance(a: &[f64], b: &[f64]) -> f64 {
    let largest = a.iter().chain(b).fold(0.0f64, |m, v| m.max(v.abs()));
    let sign = if dot(a, b) < 0.0 { -1.0 } else { 1.0 };
    a.iter().zip(b).fold(0.0f64, |m, (x, y)| m.max((x - sign * y).abs())) / largest
}

impl<S: Space> KroneckerProblem<S> {
    /// `gᵀ A_ta g` of all operators.
    fn energies(&self, a: usize, g: &[f64]) -> Vec<f64> {
        self.operators.iter().map(|o| o[a].bilinear(g, g)).collect()
    }

    /// Brings a factor to unit Gram norm; false when it is zero or not finite.
    fn normalise(&self, a: usize, g: &mut [f64]) -> bool {
        let size = self.axes[a].gram().bilinear(g, g).sqrt();
        g.iter_mut().for_each(|v| *v /= size);
        size > 0.0 && size.is_finite()
    }

    /// Where the search of a term begins: random positive values on each axis.
    fn guess(&self, random: &mut Random) -> Vec<Vec<f64>> {
        let on_axis = |a: usize| {
            let mut g: Vec<f64> = (0..self.axes[a].len()).map(|_| 0.5 + random.uniform()).collect();
            if !self.normalise(a, &mut g) {
                g = vec![1.0; self.axes[a].len()];
            }
            g
        };
        (0..self.axes.len()).map(on_axis).collect()
    }

    /// `count` random grid points, one point number per axis each.
    fn random_indices(&self, count: usize, random: &mut Random) -> Vec<Vec<usize>> {
        (0..count).map(|_| self.axes.iter().map(|a| random.below(a.len())).collect()).collect()
    }

    /// Relative residual `‖b − A u‖ / ‖b‖` over the given grid points: the true one, formed entry by entry,
    /// so that it is meaningful down to rounding (a residual from inner products stops at half of all
    /// digits).
    pub fn residual(&self, u: &Separated, points: &[Vec<usize>]) -> f64 {
        let stack = Stack::residual(self, u);
        let given = self.sources.len();
        let (mut left, mut load) = (0.0, 0.0);
        for index in points {
            let weight =
                |s: usize| index.iter().zip(&stack.vectors).map(|(&j, v)| v[(j, s)]).product::<f64>();
            let weights: Vec<f64> = (0..stack.n_sources()).map(weight).collect();
            let total = combination(&stack.blocks, &weights);
            let only: Vec<f64> =
                weights.iter().enumerate().map(|(s, w)| if s < given { *w } else { 0.0 }).collect();
            let b = combination(&stack.blocks, &only);
            left += dot(&total, &total);
            load += dot(&b, &b);
        }
        if load > 0.0 { (left / load).sqrt() } else { left.sqrt() }
    }
}
