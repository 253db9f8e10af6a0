//! The update: all factors on one axis (then all blocks) solved for together, the rest frozen.
//!
//! On axis `a` the unknown is the whole matrix `G_a` `(n_points, n_terms)` in `Σ_t A_ta G_a W_t = R`, with
//! `W_t = (F_iᵀS_tF_j) ∘ Π_{b≠a} G_bᵀA_tbG_b`. With one operator this is a small Kronecker solve; otherwise
//! points couple to their neighbours at most, and block elimination along the axis costs
//! `O(n_points · n_terms³)`. Everything is solved for the *correction*: parallel terms make `W` singular to
//! rounding, and a ridge on a correction moves nothing once the residual is gone.

use super::error::SeparatedError;
use super::kronecker::KroneckerProblem;
use super::linalg::{add_product, column, product, solve_semidefinite, transposed_product};
use super::solution::Separated;
use super::space::Space;
use faer::Mat;

/// One sweep: all blocks, then all factors axis by axis.
///
/// # Errors
/// [`SeparatedError::NotPositiveDefinite`] from the space solves.
pub(super) fn update<S: Space>(
    problem: &KroneckerProblem<S>,
    u: &Separated,
) -> Result<Separated, SeparatedError> {
    let mut grams = Grams::new(problem, u);
    let mut blocks = update_blocks(problem, u, &grams)?;
    let mut factors: Vec<Mat<f64>> = (0..problem.axes.len()).map(|a| u.factors(a).to_owned()).collect();
    let rows = u.n_rows();
    grams.set_blocks(problem, &Separated::new(problem.axes.clone(), factors.clone(), blocks.clone(), rows)?);
    for a in 0..problem.axes.len() {
        let correction = axis_correction(problem, &grams, &factors[a], a);
        factors[a] = &factors[a] + &correction;
        rescale(&mut factors[a], &mut blocks, &mut grams);
        grams.set_axis(problem, &factors[a], a);
    }
    Separated::new(problem.axes.clone(), factors, blocks, rows)
}

/// Everything the sweep needs of the frozen directions.
struct Grams {
    /// `[a][t]`: `G_aᵀ A_ta G_a`, `(n_terms, n_terms)`.
    axis: Vec<Vec<Mat<f64>>>,
    /// `[t]`: `F_iᵀ S_t F_j`.
    block: Vec<Mat<f64>>,
    /// `[a]`: source vectors against factors, `(n_sources, n_terms)`.
    source_axis: Vec<Mat<f64>>,
    /// Source blocks against blocks, `(n_sources, n_terms)`.
    source_block: Mat<f64>,
}

impl Grams {
    fn new<S: Space>(problem: &KroneckerProblem<S>, u: &Separated) -> Grams {
        let axes = problem.axes.len();
        let empty = Mat::zeros(0, 0);
        let mut grams = Grams {
            axis: vec![Vec::new(); axes],
            block: Vec::new(),
            source_axis: vec![empty.clone(); axes],
            source_block: empty,
        };
        (0..axes).for_each(|a| grams.set_axis(problem, &u.factors(a).to_owned(), a));
        grams.set_blocks(problem, u);
        grams
    }

    fn set_axis<S: Space>(&mut self, problem: &KroneckerProblem<S>, g: &Mat<f64>, a: usize) {
        let on = |o: &Vec<super::AxisOperator>| {
            transposed_product(g.as_ref(), o[a].apply_all(g.as_ref()).as_ref())
        };
        self.axis[a] = problem.operators.iter().map(on).collect();
        let vectors = Mat::from_fn(g.nrows(), problem.sources.len(), |j, s| problem.sources[s].vectors[a][j]);
        self.source_axis[a] = transposed_product(vectors.as_ref(), g.as_ref());
    }

    fn set_blocks<S: Space>(&mut self, problem: &KroneckerProblem<S>, u: &Separated) {
        let lifted = (0..problem.operators.len()).map(|t| problem.apply_to_blocks(t, u));
        self.block = lifted.map(|l| transposed_product(u.blocks(), l.as_ref())).collect();
        let n = u.n_rows();
        let sources = Mat::from_fn(u.blocks().nrows(), problem.sources.len(), |j, s| {
            problem.sources[s].block[(j % n, j / n)]
        });
        self.source_block = transposed_product(sources.as_ref(), u.blocks());
    }

    /// `Π_{b≠a}` of the axis Grams of operator `t`, times the block Gram unless `a` is `None`.
    fn weight(&self, t: usize, a: Option<usize>) -> Mat<f64> {
        let n = self.source_block.ncols();
        let others = || self.axis.iter().enumerate().filter(|(b, _)| Some(*b) != a);
        Mat::from_fn(n, n, |i, j| {
            let start = if a.is_some() { self.block[t][(i, j)] } else { 1.0 };
            others().fold(start, |w, (_, g)| w * g[t][(i, j)])
        })
    }

    /// The same products for the sources, `(n_sources, n_terms)`.
    fn source_weight(&self, a: Option<usize>) -> Mat<f64> {
        let others = || self.source_axis.iter().enumerate().filter(|(b, _)| Some(*b) != a);
        Mat::from_fn(self.source_block.nrows(), self.source_block.ncols(), |s, i| {
            let start = if a.is_some() { self.source_block[(s, i)] } else { 1.0 };
            others().fold(start, |w, (_, g)| w * g[(s, i)])
        })
    }
}

/// Unit largest entry for every factor, its size moved into the block: the solves after it see balanced
/// columns.
fn rescale(g: &mut Mat<f64>, blocks: &mut Mat<f64>, grams: &mut Grams) {
    let terms = g.ncols();
    let size: Vec<f64> =
        (0..terms).map(|i| column(g, i).iter().fold(0.0f64, |m, v| m.max(v.abs()))).collect();
    let size: Vec<f64> = size.into_iter().map(|s| if s > 0.0 { s } else { 1.0 }).collect();
    for i in 0..terms {
        (0..g.nrows()).for_each(|j| g[(j, i)] /= size[i]);
        (0..blocks.nrows()).for_each(|j| blocks[(j, i)] *= size[i]);
        (0..grams.source_block.nrows()).for_each(|s| grams.source_block[(s, i)] *= size[i]);
    }
    for gram in &mut grams.block {
        *gram = Mat::from_fn(terms, terms, |i, j| gram[(i, j)] * size[i] * size[j]);
    }
}

/// The correction of `G_a`, `(n_points, n_terms)`.
fn axis_correction<S: Space>(
    problem: &KroneckerProblem<S>,
    grams: &Grams,
    g: &Mat<f64>,
    a: usize,
) -> Mat<f64> {
    let weights: Vec<Mat<f64>> = (0..problem.operators.len()).map(|t| grams.weight(t, Some(a))).collect();
    let vectors = Mat::from_fn(g.nrows(), problem.sources.len(), |j, s| problem.sources[s].vectors[a][j]);
    let mut residual = product(vectors.as_ref(), grams.source_weight(Some(a)).as_ref());
    for (o, w) in problem.operators.iter().zip(&weights) {
        add_product(residual.as_mut(), -1.0, o[a].apply_all(g.as_ref()).as_ref(), w.as_ref());
    }
    if problem.operators.len() == 1 {
        let mut solved = Mat::zeros(g.nrows(), g.ncols());
        for i in 0..g.ncols() {
            let r = problem.operators[0][a].solve(column(&residual, i).to_vec());
            r.into_iter().enumerate().for_each(|(j, v)| solved[(j, i)] = v);
        }
        return solve_semidefinite(weights[0].as_ref(), solved.transpose().to_owned()).transpose().to_owned();
    }
    block_elimination(problem, &weights, residual, a)
}

/// Solves `Σ_t A_ta X W_t = R` point by point along the axis (block Thomas algorithm).
fn block_elimination<S: Space>(
    problem: &KroneckerProblem<S>,
    weights: &[Mat<f64>],
    residual: Mat<f64>,
    a: usize,
) -> Mat<f64> {
    let (points, terms) = (residual.nrows(), residual.ncols());
    // which = 0, 1, 2: the blocks below, on and above the diagonal; empty parts are zero.
    let sum = |which: usize, j: usize| {
        let mut sum = Mat::<f64>::zeros(terms, terms);
        for (o, w) in problem.operators.iter().zip(weights) {
            let parts = o[a].parts();
            let entry = [parts.0, parts.1, parts.2][which].get(j).copied().unwrap_or(0.0);
            super::linalg::axpy(sum.as_mut(), entry, w.as_ref());
        }
        sum
    };
    let coupled = problem.operators.iter().any(|o| !o[a].parts().0.is_empty());
    let mut right: Vec<Mat<f64>> =
        (0..points).map(|j| Mat::from_fn(terms, 1, |i, _| residual[(j, i)])).collect();
    let mut above: Vec<Mat<f64>> = Vec::new();
    for j in 0..points {
        let mut pivot = sum(1, j);
        if coupled && j > 0 {
            let below = sum(0, j - 1);
            add_product(pivot.as_mut(), -1.0, below.as_ref(), above[j - 1].as_ref());
            let previous = right[j - 1].clone();
            add_product(right[j].as_mut(), -1.0, below.as_ref(), previous.as_ref());
        }
        right[j] = solve_semidefinite(pivot.as_ref(), right[j].clone());
        if coupled && j + 1 < points {
            above.push(solve_semidefinite(pivot.as_ref(), sum(2, j)));
        }
    }
    if coupled {
        for j in (0..points - 1).rev() {
            let next = right[j + 1].clone();
            add_product(right[j].as_mut(), -1.0, above[j].as_ref(), next.as_ref());
        }
    }
    Mat::from_fn(points, terms, |j, i| right[j][(i, 0)])
}

/// New blocks, `(n_rows · n_columns, n_terms)`: jointly with one space operator, else term after term
/// (Gauss–Seidel, one pass; the energy never rises).
fn update_blocks<S: Space>(
    problem: &KroneckerProblem<S>,
    u: &Separated,
    grams: &Grams,
) -> Result<Mat<f64>, SeparatedError> {
    let (n, c, terms) = (u.n_rows(), u.n_columns(), u.n_terms());
    let sources = Mat::from_fn(n * c, problem.sources.len(), |j, s| problem.sources[s].block[(j % n, j / n)]);
    let load = product(sources.as_ref(), grams.source_weight(None).as_ref());
    let weights: Vec<Mat<f64>> = (0..problem.operators.len()).map(|t| grams.weight(t, None)).collect();
    let mut lifted: Vec<Mat<f64>> =
        (0..problem.operators.len()).map(|t| problem.apply_to_blocks(t, u)).collect();
    let mut blocks = u.blocks().to_owned();
    if problem.operators.len() == 1 {
        let mut residual = load;
        add_product(residual.as_mut(), -1.0, lifted[0].as_ref(), weights[0].as_ref());
        let z = solve_semidefinite(weights[0].as_ref(), residual.transpose().to_owned());
        let wide = Mat::from_fn(n, c * terms, |i, j| z[(j / c, i + (j % c) * n)]);
        let solved = problem.space.solve(&[1.0], wide.as_ref())?;
        return Ok(Mat::from_fn(n * c, terms, |j, i| blocks[(j, i)] + solved[(j % n, i * c + j / n)]));
    }
    for i in 0..terms {
        let mut residual = Mat::from_fn(n * c, 1, |j, _| load[(j, i)]);
        for (l, w) in lifted.iter().zip(&weights) {
            add_product(residual.as_mut(), -1.0, l.as_ref(), w.as_ref().subcols(i, 1));
        }
        let own: Vec<f64> = weights.iter().map(|w| w[(i, i)]).collect();
        if own.iter().all(|w| *w == 0.0) {
            continue;
        }
        let wide = Mat::from_fn(n, c, |r, k| residual[(r + k * n, 0)]);
        let solved = problem.space.solve(&own, wide.as_ref())?;
        for (t, l) in lifted.iter_mut().enumerate() {
            let applied = problem.space.apply(t, solved.as_ref());
            (0..n * c).for_each(|j| l[(j, i)] += applied[(j % n, j / n)]);
        }
        (0..n * c).for_each(|j| blocks[(j, i)] += solved[(j % n, j / n)]);
    }
    Ok(blocks)
}
