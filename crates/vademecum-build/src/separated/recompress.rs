//! Fewer terms for the same function, to a tolerance.

use super::enrich::{EnrichmentOptions, enrich};
use super::error::SeparatedError;
use super::linalg::{column, product, thin_svd, transposed_product};
use super::problem::{DenseSpace, Problem, Source};
use super::solution::Separated;
use crate::linalg::Random;
use faer::Mat;

/// The same function with as few terms as are found for the relative `tolerance`, never more than it has.
///
/// The blocks are brought to their own small space first. With one axis the result is a truncated singular value
/// decomposition, hence optimal in the axis' Gram norm; with more it is the greedy engine with updates on the
/// identity, its error measured on the grid points (all of them, or 2 000 random ones). Deterministic.
///
/// # Errors
/// [`SeparatedError::NoConvergence`] when an entry is not finite.
pub fn recompress(u: &Separated, tolerance: f64) -> Result<Separated, SeparatedError> {
    let (space, s, v) = thin_svd(u.blocks())?;
    // Directions below a hundredth of the tolerance cannot matter.
    let kept = s.iter().take_while(|x| **x > 1e-2 * tolerance * s[0] / (s.len() as f64).sqrt()).count();
    let core = Mat::from_fn(kept, u.n_terms(), |i, j| s[i] * v[(j, i)]);
    let compact = match u.axes().len() {
        _ if kept == 0 => return Ok(Separated::zero(u.axes(), u.n_rows(), u.n_columns())),
        1 => one_axis(u, &core, tolerance)?,
        _ => greedy(u, &core, tolerance)?,
    };
    let Some(compact) = compact else {
        return Ok(u.clone());
    };
    let blocks = product(space.as_ref().subcols(0, kept), compact.blocks());
    let factors = (0..u.axes().len()).map(|a| compact.factors(a).to_owned()).collect();
    Separated::new(u.axes().to_vec(), factors, blocks, u.n_rows())
}

/// Truncated decomposition of `√w ∘ (G coreᵀ)`, a matrix `(n_points, kept)`, with quadrature weights `w`.
fn one_axis(u: &Separated, core: &Mat<f64>, tolerance: f64) -> Result<Option<Separated>, SeparatedError> {
    let axis = &u.axes()[0];
    let root: Vec<f64> = axis.weights().iter().map(|w| w.sqrt()).collect();
    let values = product(u.factors(0), core.transpose());
    let weighted = Mat::from_fn(axis.len(), core.nrows(), |j, k| root[j] * values[(j, k)]);
    let (g, s, f) = thin_svd(weighted.as_ref())?;
    let total: f64 = s.iter().map(|x| x * x).sum();
    let mut tail = 0.0;
    let mut terms = s.len();
    while terms > 0 && tail + s[terms - 1].powi(2) <= tolerance * tolerance * total {
        tail += s[terms - 1].powi(2);
        terms -= 1;
    }
    if terms >= u.n_terms() {
        return Ok(None);
    }
    let factor = Mat::from_fn(axis.len(), terms, |j, i| g[(j, i)] / root[j]);
    let blocks = Mat::from_fn(core.nrows(), terms, |k, i| f[(k, i)] * s[i]);
    Separated::new(u.axes().to_vec(), vec![factor], blocks, core.nrows()).map(Some)
}

fn greedy(u: &Separated, core: &Mat<f64>, tolerance: f64) -> Result<Option<Separated>, SeparatedError> {
    let grams: Vec<_> = u.axes().iter().map(|a| a.gram()).collect();
    let source = |i: usize| Source {
        vectors: grams
            .iter()
            .enumerate()
            .map(|(a, m)| m.apply(column(&u.factors(a).to_owned(), i)))
            .collect(),
        block: Mat::from_fn(core.nrows(), 1, |k, _| core[(k, i)]),
    };
    let sources = (0..u.n_terms()).map(source).collect();
    let space = DenseSpace::new(vec![Mat::identity(core.nrows(), core.nrows())])?;
    let problem = Problem::new(u.axes().to_vec(), vec![grams.clone()], space, sources)?;
    let factors = (0..u.axes().len()).map(|a| u.factors(a).to_owned()).collect();
    let target = Separated::new(u.axes().to_vec(), factors, core.clone(), core.nrows())?;
    let points = grid_points(u, 2000);
    let exact: Vec<Mat<f64>> = points.iter().map(|p| target.combine(&target.weights_at(p))).collect();
    let size: f64 = exact.iter().map(|e| transposed_product(e.as_ref(), e.as_ref())[(0, 0)]).sum();
    let measure = |v: &Separated| {
        let gap = |(p, e): (&Vec<usize>, &Mat<f64>)| {
            let d = e - v.combine(&v.weights_at(p));
            transposed_product(d.as_ref(), d.as_ref())[(0, 0)]
        };
        (points.iter().zip(&exact).map(gap).sum::<f64>() / size).sqrt()
    };
    let options = EnrichmentOptions {
        tolerance,
        max_terms: u.n_terms() - 1,
        update_sweeps: 8,
        patience: u.n_terms(),
        ..EnrichmentOptions::default()
    };
    if u.n_terms() < 2 {
        return Ok(None);
    }
    let (found, report) = enrich(&problem, &options, None, Some(&measure))?;
    Ok((report.error <= tolerance).then_some(found))
}

/// All grid points when there are at most `most`, else that many random ones.
fn grid_points(u: &Separated, most: usize) -> Vec<Vec<usize>> {
    let lengths: Vec<usize> = u.axes().iter().map(|a| a.len()).collect();
    let total = lengths.iter().fold(1usize, |n, l| n.saturating_mul(*l));
    if total > most {
        let mut random = Random::new(2);
        return (0..most).map(|_| lengths.iter().map(|l| random.below(*l)).collect()).collect();
    }
    let digits = |mut k: usize| lengths.iter().map(|l| (k % l, k /= l).0).collect();
    (0..total).map(digits).collect()
}
