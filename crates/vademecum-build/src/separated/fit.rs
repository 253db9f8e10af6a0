//! Terms from sampled solutions: greedy enrichment with alternating least squares on a set of grid points.
//!
//! When the problem in space is small, solving it at a few thousand parameter points costs less than one coupled update
//! of the Galerkin engine, and what remains is an approximation problem. Blocks are compressed to the span they share;
//! each new term is a rank-one fit of the residual; then all factors are re-fitted axis by axis. At a fixed axis every
//! one of its points has its own small system, `(Σ_p k_p k_pᵀ ∘ FᵀF) δ = Σ_p k_p ∘ Fᵀe_p`, with `k_p` the product of the
//! other factors at sample `p` and `e_p` its residual. Residuals are formed explicitly, so the normal equations only
//! have to point downhill and do not cost half of the digits.

use super::axis::Axis;
use super::enrich::{EnrichmentOptions, EnrichmentReport, Progress, StopReason};
use super::error::{SeparatedError, check_len};
use super::linalg::{
    Random, add_product, column, norm, product, solve_semidefinite, thin_svd, transposed_product,
};
use super::solution::Separated;
use faer::{Mat, MatRef};
use rayon::prelude::*;

/// Solutions at grid points.
#[derive(Clone, Debug)]
pub struct SampledBlocks {
    /// The axes whose points make the grid.
    pub axes: Vec<Axis>,
    /// Point number on each axis, one list per sample.
    pub index: Vec<Vec<usize>>,
    /// `(n_rows · n_columns, n_samples)`, each column one block in column-major order.
    pub values: Mat<f64>,
    /// Rows of a block.
    pub n_rows: usize,
}

/// Greedy fit of the samples, every sample counted relative to its own size, until `measure` (or, without one, the
/// relative error over the samples) meets the tolerance. `options.update_sweeps = 0` is the plain greedy method.
///
/// # Errors
/// [`SeparatedError::Shape`]; [`SeparatedError::NoConvergence`] when a sample is not finite.
pub fn fit(
    samples: &SampledBlocks,
    options: &EnrichmentOptions,
    measure: Option<&dyn Fn(&Separated) -> f64>,
) -> Result<(Separated, EnrichmentReport), SeparatedError> {
    check_len("sampled blocks", samples.index.len(), samples.values.ncols())?;
    samples
        .index
        .iter()
        .try_for_each(|i| check_len("point numbers of a sample", samples.axes.len(), i.len()))?;
    let (span, fitter) = Fitter::new(samples, options)?;
    let mut state = fitter.empty();
    let mut progress =
        Progress::new(Separated::zero(&samples.axes, samples.n_rows, span.nrows() / samples.n_rows), 1.0);
    loop {
        // Late terms are small and many: a few at a time share one update, which also makes up for a short search.
        let updated = options.update_sweeps > 0;
        let batch = if updated { 1 + state.blocks.ncols().saturating_sub(48) / 16 } else { 1 };
        let sweeps = if updated { options.max_sweeps.min(6) } else { options.max_sweeps };
        for _ in 0..batch.min(options.max_terms - state.blocks.ncols()) {
            if !fitter.add_term(&mut state, sweeps) {
                return Ok(progress.finish(StopReason::Stagnation));
            }
        }
        // The last terms have had few updates: with room for no more, polish what is there.
        let last = state.blocks.ncols() >= options.max_terms;
        for _ in 0..options.update_sweeps * if last { 8 } else { 1 } {
            fitter.sweep(&mut state);
        }
        let blocks = product(span.as_ref(), state.blocks.as_ref());
        let now = Separated::new(samples.axes.clone(), state.factors.clone(), blocks, samples.n_rows)?;
        let error = measure.map_or_else(|| norm(state.residual.as_ref()) / fitter.size, |m| m(&now));
        if let Some(stop) = progress.record(&now, error, options) {
            return Ok(progress.finish(stop));
        }
    }
}

/// The compressed samples, and what never changes during the fit.
struct Fitter {
    lengths: Vec<usize>,
    index: Vec<Vec<usize>>,
    /// Samples in ascending order of their point on each axis, with the start of every point's run.
    groups: Vec<(Vec<usize>, Vec<usize>)>,
    /// One over the size of each sample, mean 1: least squares then sees relative errors.
    weight: Vec<f64>,
    /// Weighted samples in the shared span: `(n_samples, width)`.
    values: Mat<f64>,
    size: f64,
}

/// Factors `(n_points, n_terms)` per axis, blocks `(width, n_terms)`, and `values − Σ terms` at every sample.
struct State {
    factors: Vec<Mat<f64>>,
    blocks: Mat<f64>,
    residual: Mat<f64>,
}

impl Fitter {
    fn new(
        samples: &SampledBlocks,
        options: &EnrichmentOptions,
    ) -> Result<(Mat<f64>, Fitter), SeparatedError> {
        let count = samples.index.len();
        let sizes: Vec<f64> = (0..count).map(|p| norm(samples.values.as_ref().subcols(p, 1))).collect();
        let weight: Vec<f64> = sizes.iter().map(|s| if *s > 0.0 { s.recip() } else { 0.0 }).collect();
        let weighted = Mat::from_fn(samples.values.nrows(), count, |j, p| samples.values[(j, p)] * weight[p]);
        let span = shared_span(weighted.as_ref(), 1e-2 * options.tolerance, &mut Random::new(options.seed))?;
        let values = transposed_product(weighted.as_ref(), span.as_ref());
        let lengths: Vec<usize> = samples.axes.iter().map(Axis::len).collect();
        let groups = (0..lengths.len()).map(|a| group(&samples.index, a, lengths[a])).collect();
        let size = norm(values.as_ref());
        Ok((span, Fitter { lengths, index: samples.index.clone(), groups, weight, values, size }))
    }

    fn empty(&self) -> State {
        State {
            factors: self.lengths.iter().map(|l| Mat::zeros(*l, 0)).collect(),
            blocks: Mat::zeros(self.values.ncols(), 0),
            residual: self.values.clone(),
        }
    }

    /// Products of the factors at every sample, axis `skip` left out: `(n_samples, n_terms)`, weighted by `weight` when
    /// nothing is skipped. The weight belongs to the sample, not to the factors.
    fn products(&self, factors: &[Mat<f64>], skip: Option<usize>) -> Mat<f64> {
        let terms = factors.first().map_or(0, |g| g.ncols());
        let mut out = Mat::from_fn(self.index.len(), terms, |_, _| 1.0);
        for (a, g) in factors.iter().enumerate().filter(|(a, _)| Some(*a) != skip) {
            for i in 0..terms {
                let g = column(g, i);
                let column = out.col_as_slice_mut(i);
                column.iter_mut().zip(&self.index).for_each(|(v, index)| *v *= g[index[a]]);
            }
        }
        out
    }

    /// Appends the best rank-one fit of the residual found by alternating directions; false when nothing is left.
    fn add_term(&self, state: &mut State, max_sweeps: usize) -> bool {
        let size = |p: usize| norm(state.residual.as_ref().subrows(p, 1));
        let Some(worst) = (0..self.index.len()).max_by(|p, q| size(*p).total_cmp(&size(*q))) else {
            return false;
        };
        let mut block = Mat::from_fn(self.values.ncols(), 1, |k, _| state.residual[(worst, k)]);
        let mut factors: Vec<Mat<f64>> =
            self.lengths.iter().map(|l| Mat::from_fn(*l, 1, |_, _| 1.0)).collect();
        for _ in 0..max_sweeps {
            let mut change = 0.0f64;
            for a in 0..self.lengths.len() {
                let new = self.best_factor(&state.residual, &block, &factors, a);
                let largest = new.norm_max();
                if largest == 0.0 || !largest.is_finite() {
                    return false;
                }
                let new = Mat::from_fn(new.nrows(), 1, |j, _| new[(j, 0)] / largest);
                change = change.max((&new - &factors[a]).norm_max());
                factors[a] = new;
            }
            let k = self.weighted(self.products(&factors, None));
            block = transposed_product(state.residual.as_ref(), k.as_ref());
            let scale = norm(k.as_ref()).powi(2);
            (0..block.nrows()).for_each(|i| block[(i, 0)] /= scale);
            if change < 1e-3 {
                break;
            }
        }
        let join = |a: &Mat<f64>, b: &Mat<f64>| {
            Mat::from_fn(a.nrows(), a.ncols() + 1, |i, j| if j < a.ncols() { a[(i, j)] } else { b[(i, 0)] })
        };
        let k = self.weighted(self.products(&factors, None));
        add_product(state.residual.as_mut(), -1.0, k.as_ref(), block.transpose());
        state.factors.iter_mut().zip(&factors).for_each(|(g, new)| *g = join(g, new));
        state.blocks = join(&state.blocks, &block);
        true
    }

    /// `g_j = Σ_{p∈j} k_p ⟨e_p, f⟩ / (‖f‖² Σ_{p∈j} k_p²)` for one term.
    fn best_factor(&self, residual: &Mat<f64>, block: &Mat<f64>, factors: &[Mat<f64>], a: usize) -> Mat<f64> {
        let k = self.weighted(self.products(factors, Some(a)));
        let seen = product(residual.as_ref(), block.as_ref());
        let energy = norm(block.as_ref()).powi(2);
        let (mut above, mut below) = (vec![0.0; self.lengths[a]], vec![0.0; self.lengths[a]]);
        for (p, index) in self.index.iter().enumerate() {
            above[index[a]] += k[(p, 0)] * seen[(p, 0)];
            below[index[a]] += k[(p, 0)] * k[(p, 0)] * energy;
        }
        Mat::from_fn(self.lengths[a], 1, |j, _| if below[j] > 0.0 { above[j] / below[j] } else { 0.0 })
    }

    fn weighted(&self, mut k: Mat<f64>) -> Mat<f64> {
        for i in 0..k.ncols() {
            k.col_as_slice_mut(i).iter_mut().zip(&self.weight).for_each(|(v, w)| *v *= w);
        }
        k
    }

    /// One update of all factors and blocks.
    fn sweep(&self, state: &mut State) {
        for a in 0..self.lengths.len() {
            self.update_axis(state, a);
            balance(&mut state.factors[a], &mut state.blocks);
        }
        self.update_blocks(state);
    }

    fn update_blocks(&self, state: &mut State) {
        let k = self.weighted(self.products(&state.factors, None));
        let gram = transposed_product(k.as_ref(), k.as_ref());
        let pull = transposed_product(k.as_ref(), state.residual.as_ref());
        let correction = solve_semidefinite(gram.as_ref(), pull);
        state.blocks = &state.blocks + correction.transpose();
        add_product(state.residual.as_mut(), -1.0, k.as_ref(), correction.as_ref());
    }

    fn update_axis(&self, state: &mut State, a: usize) {
        let k = self.weighted(self.products(&state.factors, Some(a)));
        let blocks = transposed_product(state.blocks.as_ref(), state.blocks.as_ref());
        let seen = product(state.residual.as_ref(), state.blocks.as_ref());
        let terms = blocks.ncols();
        let (order, starts) = &self.groups[a];
        let mut step = Mat::zeros(self.index.len(), terms);
        // The points of an axis are independent of each other, so threads do not change a bit.
        let solve_at = |j: usize| {
            let members = &order[starts[j]..starts[j + 1]];
            let own = Mat::from_fn(members.len(), terms, |q, i| k[(members[q], i)]);
            let gram = transposed_product(own.as_ref(), own.as_ref());
            let gram = Mat::from_fn(terms, terms, |i, l| gram[(i, l)] * blocks[(i, l)]);
            let pull = |i: usize| (0..members.len()).map(|q| own[(q, i)] * seen[(members[q], i)]).sum();
            solve_semidefinite(gram.as_ref(), Mat::from_fn(terms, 1, |i, _| pull(i)))
        };
        let corrections: Vec<Mat<f64>> = (0..self.lengths[a]).into_par_iter().map(solve_at).collect();
        for (j, correction) in corrections.iter().enumerate() {
            for i in 0..terms {
                state.factors[a][(j, i)] += correction[(i, 0)];
                order[starts[j]..starts[j + 1]]
                    .iter()
                    .for_each(|&p| step[(p, i)] = k[(p, i)] * correction[(i, 0)]);
            }
        }
        add_product(state.residual.as_mut(), -1.0, step.as_ref(), state.blocks.transpose());
    }
}

/// Unit largest entry for every factor, its size moved into the block.
fn balance(g: &mut Mat<f64>, blocks: &mut Mat<f64>) {
    for i in 0..g.ncols() {
        let size = column(g, i).iter().fold(0.0f64, |m, v| m.max(v.abs()));
        if size > 0.0 {
            g.col_as_slice_mut(i).iter_mut().for_each(|v| *v /= size);
            blocks.col_as_slice_mut(i).iter_mut().for_each(|v| *v *= size);
        }
    }
}

/// Samples sorted by their point on axis `a`, and where each point's run starts.
fn group(index: &[Vec<usize>], a: usize, length: usize) -> (Vec<usize>, Vec<usize>) {
    let mut order: Vec<usize> = (0..index.len()).collect();
    order.sort_by_key(|&p| index[p][a]);
    let starts = (0..=length).map(|j| order.partition_point(|&p| index[p][a] < j)).collect();
    (order, starts)
}

/// Orthonormal basis of what the columns of `a` share, to a relative `tolerance` in the Frobenius norm: a decomposition
/// of random mixtures of the columns, doubled until nothing is missed; exact when there are few columns.
fn shared_span(a: MatRef<'_, f64>, tolerance: f64, random: &mut Random) -> Result<Mat<f64>, SeparatedError> {
    let mut sketch = 128;
    loop {
        let direct = 2 * sketch >= a.ncols().min(a.nrows());
        let mixed = if direct {
            a.to_owned()
        } else {
            let mix = Mat::from_fn(a.ncols(), sketch, |_, _| random.uniform() - 0.5);
            product(a, mix.as_ref())
        };
        let (u, s, _) = thin_svd(mixed.as_ref())?;
        // A sketch sees a direction √columns too small at worst; the check below is what counts.
        let floor = s[0] * (tolerance / (a.ncols().max(4) as f64).sqrt()).max(f64::EPSILON);
        let kept = s.iter().take_while(|x| **x > floor).count().max(1);
        let span = u.as_ref().subcols(0, kept).to_owned();
        if direct || norm(missed(a, &span).as_ref()) <= tolerance * norm(a) {
            return Ok(span);
        }
        sketch *= 2;
    }
}

fn missed(a: MatRef<'_, f64>, span: &Mat<f64>) -> Mat<f64> {
    let mut rest = a.to_owned();
    let inside = transposed_product(span.as_ref(), a);
    add_product(rest.as_mut(), -1.0, span.as_ref(), inside.as_ref());
    rest
}
