//! Terms from a polynomial: greedy enrichment with alternating least squares on sparse Chebyshev
//! coefficients.
//!
//! When the problem in space is small, solving it at a few thousand parameter points costs less than one
//! coupled update of the Galerkin engine, and what remains is an approximation problem. In the coefficients
//! of orthonormal polynomials it is cheap: the normal equations of axis `a` are the *same* for all its
//! degrees, `W = (FᵀF) ∘ Π_{b≠a} (G_bᵀG_b)`, R × R and known from small Gram matrices, and only their
//! right-hand side `Σ_ν c_ν·F ∘ Π_{b≠a} g_b(ν_b)` sees the thousands of coefficients. On sampled values each
//! point of each axis has its own system over its own samples, a hundred times the work at 500 terms. Solved
//! for corrections, so that a ridge moves nothing once the gradient is gone.

use super::error::SeparatedError;
use super::expansion::Expansion;
use super::greedy::{EnrichmentOptions, EnrichmentReport, Progress, StopReason};
use super::linalg::{add_product, norm, product, solve_semidefinite, thin_svd, transposed_product};
use super::solution::Separated;
use crate::linalg::Random;
use crate::parallel;
use faer::{Mat, MatRef};

/// An error of a candidate, or the reason to give up.
pub(crate) type Measure<'a, E> = &'a dyn Fn(&Separated) -> Result<f64, E>;

/// Greedy fit of an expansion until `measure` (or, without one, the relative error of the coefficients) meets
/// the tolerance. `options.update_sweeps = 0` is the plain greedy method.
///
/// # Errors
/// [`SeparatedError::NoConvergence`] when a coefficient is not finite; what `measure` gives up with.
pub fn fit<E: From<SeparatedError>>(
    expansion: &Expansion,
    options: &EnrichmentOptions,
    measure: Option<Measure<'_, E>>,
) -> Result<(Separated, EnrichmentReport), E> {
    let (span, fitter) = Fitter::new(expansion, options)?;
    let nodal: Vec<Mat<f64>> = (0..expansion.axes.len()).map(|a| expansion.nodal(a)).collect();
    let (axes, rows) = (&expansion.axes, expansion.n_rows);
    let mut terms = fitter.empty();
    let mut progress = Progress::new(Separated::zero(axes, rows, span.nrows() / rows), 1.0);
    loop {
        // Late terms are small and many: some of them at a time share one update.
        let updated = options.update_sweeps > 0;
        let batch = if updated { 1 + terms.blocks.ncols().saturating_sub(48) / 8 } else { 1 };
        let mut residual = fitter.residual(&terms);
        for _ in 0..batch.min(options.max_terms - terms.blocks.ncols()) {
            if !fitter.add_term(&mut terms, &mut residual, options.max_sweeps) {
                return Ok(progress.finish(StopReason::Stagnation));
            }
        }
        // The last terms have had few updates: with room for no more, polish what is there.
        let last = terms.blocks.ncols() >= options.max_terms;
        for _ in 0..options.update_sweeps * if last { 8 } else { 1 } {
            fitter.sweep(&mut terms);
        }
        let factors = terms.factors.iter().zip(&nodal).map(|(g, n)| n * g).collect();
        let blocks = product(span.as_ref(), terms.blocks.as_ref());
        let now = Separated::new(axes.clone(), factors, blocks, rows)?;
        let error = match measure {
            Some(measure) => measure(&now)?,
            None => norm(fitter.residual(&terms).as_ref()) / fitter.size,
        };
        if let Some(stop) = progress.record(&now, error, options) {
            return Ok(progress.finish(stop));
        }
    }
}

/// What never changes during the fit.
struct Fitter<'a> {
    lengths: Vec<usize>,
    index: &'a [Vec<usize>],
    /// Coefficients in the span they share: `(n_degrees, width)`.
    values: Mat<f64>,
    size: f64,
}

/// Factors `(n_points, n_terms)` per axis, in coefficients, and blocks `(width, n_terms)`.
struct Terms {
    factors: Vec<Mat<f64>>,
    blocks: Mat<f64>,
}

impl<'a> Fitter<'a> {
    fn new(
        expansion: &'a Expansion,
        options: &EnrichmentOptions,
    ) -> Result<(Mat<f64>, Fitter<'a>), SeparatedError> {
        let coefficients = expansion.coefficients.as_ref();
        let span = shared_span(coefficients, 1e-2 * options.tolerance, &mut Random::new(options.seed))?;
        let values = transposed_product(coefficients, span.as_ref());
        let lengths = expansion.axes.iter().map(|a| a.len()).collect();
        let size = norm(values.as_ref());
        Ok((span, Fitter { lengths, index: &expansion.index, values, size }))
    }

    fn empty(&self) -> Terms {
        Terms {
            factors: self.lengths.iter().map(|l| Mat::zeros(*l, 0)).collect(),
            blocks: Mat::zeros(self.values.ncols(), 0),
        }
    }

    /// Products of the factors at every degree of the set, axis `skip` left out: `(n_degrees, n_terms)`.
    fn products(&self, factors: &[Mat<f64>], skip: Option<usize>) -> Mat<f64> {
        let terms = factors.first().map_or(0, |g| g.ncols());
        let column = |i: usize| {
            let mut out = vec![1.0; self.index.len()];
            for (a, g) in factors.iter().enumerate().filter(|(a, _)| Some(*a) != skip) {
                let g = g.col_as_slice(i);
                out.iter_mut().zip(self.index).for_each(|(v, nu)| *v *= g[nu[a]]);
            }
            out
        };
        let columns = parallel::map(terms, &column);
        let mut out = Mat::zeros(self.index.len(), terms);
        columns.iter().enumerate().for_each(|(i, c)| out.col_as_slice_mut(i).copy_from_slice(c));
        out
    }

    /// Coefficients less the terms, `(n_degrees, width)`.
    fn residual(&self, terms: &Terms) -> Mat<f64> {
        let k = self.products(&terms.factors, None);
        &self.values - parallel_product(k.as_ref(), terms.blocks.transpose())
    }

    /// Appends the best rank-one fit of the residual found by alternating directions from its largest
    /// coefficient, and takes it off the residual; false when nothing is left.
    fn add_term(&self, terms: &mut Terms, residual: &mut Mat<f64>, max_sweeps: usize) -> bool {
        let mut size = vec![0.0; self.index.len()];
        for k in 0..residual.ncols() {
            size.iter_mut().zip(residual.col_as_slice(k)).for_each(|(s, v)| *s += v * v);
        }
        let Some(largest) = (0..size.len()).max_by(|&p, &q| size[p].total_cmp(&size[q])) else {
            return false;
        };
        let unit = |(a, l): (usize, &usize)| {
            Mat::from_fn(*l, 1, |j, _| if j == self.index[largest][a] { 1.0 } else { 0.0 })
        };
        let mut factors: Vec<Mat<f64>> = self.lengths.iter().enumerate().map(unit).collect();
        let mut block = Mat::from_fn(self.values.ncols(), 1, |k, _| residual[(largest, k)]);
        for _ in 0..max_sweeps {
            let seen = product(residual.as_ref(), block.as_ref());
            let mut change = 0.0f64;
            for a in 0..self.lengths.len() {
                let k = self.products(&factors, Some(a));
                let mut new = vec![0.0; self.lengths[a]];
                (0..self.index.len()).for_each(|p| new[self.index[p][a]] += k[(p, 0)] * seen[(p, 0)]);
                let length = new.iter().map(|v| v * v).sum::<f64>().sqrt();
                if length == 0.0 || !length.is_finite() {
                    return false;
                }
                let new = Mat::from_fn(new.len(), 1, |j, _| new[j] / length);
                change = change.max((&new - &factors[a]).norm_max());
                factors[a] = new;
            }
            block = transposed_product(residual.as_ref(), self.products(&factors, None).as_ref());
            if change < 1e-3 {
                break;
            }
        }
        add_product(residual.as_mut(), -1.0, self.products(&factors, None).as_ref(), block.transpose());
        let join = |a: &Mat<f64>, b: &Mat<f64>| {
            Mat::from_fn(a.nrows(), a.ncols() + 1, |i, j| if j < a.ncols() { a[(i, j)] } else { b[(i, 0)] })
        };
        terms.factors.iter_mut().zip(&factors).for_each(|(g, new)| *g = join(g, new));
        terms.blocks = join(&terms.blocks, &block);
        true
    }

    /// One update of all factors and blocks.
    fn sweep(&self, terms: &mut Terms) {
        let mut seen = parallel_product(self.values.as_ref(), terms.blocks.as_ref());
        let gram = |g: &Mat<f64>| transposed_product(g.as_ref(), g.as_ref());
        let mut grams: Vec<Mat<f64>> = terms.factors.iter().map(gram).collect();
        for a in 0..self.lengths.len() {
            let mut w = gram(&terms.blocks);
            grams.iter().enumerate().filter(|(b, _)| *b != a).for_each(|(_, g)| hadamard(&mut w, g));
            let pull = self.pull(&terms.factors, &seen, a);
            let rest = pull - &w * terms.factors[a].transpose();
            terms.factors[a] += solve_semidefinite(w.as_ref(), rest).transpose();
            balance(&mut terms.factors[a], &mut terms.blocks, &mut seen);
            grams[a] = gram(&terms.factors[a]);
        }
        let mut w = Mat::from_fn(seen.ncols(), seen.ncols(), |_, _| 1.0);
        grams.iter().for_each(|g| hadamard(&mut w, g));
        let k = self.products(&terms.factors, None);
        let pull = parallel_product(k.transpose(), self.values.as_ref());
        let rest = pull - &w * terms.blocks.transpose();
        terms.blocks += solve_semidefinite(w.as_ref(), rest).transpose();
    }

    /// `Σ_ν seen_ν ∘ Π_{b≠a} g_b(ν_b)` for each degree of axis `a`: `(n_terms, n_points)`.
    fn pull(&self, factors: &[Mat<f64>], seen: &Mat<f64>, a: usize) -> Mat<f64> {
        let k = self.products(factors, Some(a));
        let row = |i: usize| {
            let mut sums = vec![0.0; self.lengths[a]];
            let both = k.col_as_slice(i).iter().zip(seen.col_as_slice(i));
            both.zip(self.index).for_each(|((k, s), nu)| sums[nu[a]] += k * s);
            sums
        };
        let rows = parallel::map(k.ncols(), &row);
        Mat::from_fn(rows.len(), self.lengths[a], |i, j| rows[i][j])
    }
}

/// `w ← w ∘ g`.
fn hadamard(w: &mut Mat<f64>, g: &Mat<f64>) {
    for j in 0..w.ncols() {
        w.col_as_slice_mut(j).iter_mut().zip(g.col_as_slice(j)).for_each(|(w, g)| *w *= g);
    }
}

/// `A B` in column panels of one width, so that threads do not change a bit.
fn parallel_product(a: MatRef<'_, f64>, b: MatRef<'_, f64>) -> Mat<f64> {
    const PANEL: usize = 32;
    let panel = |at: usize| product(a, b.subcols(at * PANEL, PANEL.min(b.ncols() - at * PANEL)));
    let parts = parallel::map(b.ncols().div_ceil(PANEL), &panel);
    let mut out = Mat::zeros(a.nrows(), b.ncols());
    for (at, part) in parts.iter().enumerate() {
        out.as_mut().subcols_mut(at * PANEL, part.ncols()).copy_from(part);
    }
    out
}

/// Unit length for every factor, its size moved into the block and what was seen through it.
fn balance(g: &mut Mat<f64>, blocks: &mut Mat<f64>, seen: &mut Mat<f64>) {
    for i in 0..g.ncols() {
        let size = norm(g.as_ref().subcols(i, 1));
        if size > 0.0 {
            g.col_as_slice_mut(i).iter_mut().for_each(|v| *v /= size);
            blocks.col_as_slice_mut(i).iter_mut().for_each(|v| *v *= size);
            seen.col_as_slice_mut(i).iter_mut().for_each(|v| *v *= size);
        }
    }
}
/// Orthonormal basis of what the columns of `a` share, to a relative `tolerance` in the Frobenius norm: a
/// decomposition of random mixtures of the columns, doubled until nothing is missed; exact when there are few
/// columns.
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
