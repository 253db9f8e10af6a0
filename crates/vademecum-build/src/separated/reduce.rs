//! Space compression: a few dozen vectors that hold the solution of a block problem over its whole box.
//!
//! Solutions are collected at parameter samples, each chosen where the reduced solution leaves the largest residual, and
//! compressed to a basis orthonormal in the energy inner product `M`. The Galerkin problem in that basis is small and
//! dense, and everything after it costs the same for a beam and for a liver. The stop is not an estimate: the error at
//! each newly chosen sample is measured before the sample is used, so it is the error at a point the basis has not seen.

use super::axis::Axis;
use super::block::{BlockProblem, BlockSource};
use super::error::{SeparatedError, check_len};
use super::linalg::{add_product, inner, norm, product, thin_svd, transposed_product};
use super::problem::{DenseSpace, Space};
use crate::linalg::Random;
use faer::{Mat, MatRef};
use rayon::prelude::*;

/// The energy inner product: `M X` for a block `X`, `M` symmetric positive definite.
pub type Energy<'a> = dyn Fn(MatRef<'_, f64>) -> Mat<f64> + Sync + 'a;

/// How samples are collected.
#[derive(Clone, Debug, PartialEq)]
pub struct ReductionOptions {
    /// Largest error of the reduced solution at two samples in a row that it has not seen, in the energy norm, relative.
    pub tolerance: f64,
    /// Most solves in the full space.
    pub max_samples: usize,
    /// Random candidates looked at per sample (corners of the box are looked at too, while there are at most 32).
    pub candidates: usize,
    /// Seed of the candidates.
    pub seed: u64,
}

impl Default for ReductionOptions {
    fn default() -> Self {
        ReductionOptions { tolerance: 1e-8, max_samples: 40, candidates: 32, seed: 1 }
    }
}

/// A block problem in its reduced space.
#[derive(Clone, Debug)]
pub struct Reduction {
    /// `U`, `(n_full, n_reduced)`, `UᵀMU = I`.
    pub basis: Mat<f64>,
    /// The Galerkin problem in `U`; its solutions have `n_reduced` rows.
    pub problem: BlockProblem<DenseSpace>,
    /// Where the full problem was solved.
    pub points: Vec<Vec<f64>>,
    /// Error found at each sample after the first, before it was added.
    pub history: Vec<f64>,
}

/// `M`-orthonormal basis `(n, k)` of the blocks, to a relative `tolerance` in the energy norm, every block counted
/// relative to its own size. By orthogonalisation and a small decomposition, so tolerances near rounding are met (a
/// Gram matrix would lose half of the digits).
///
/// # Errors
/// [`SeparatedError::Shape`]; [`SeparatedError::NoConvergence`] when an entry is not finite.
pub fn compress(
    samples: &[Mat<f64>],
    energy: &Energy<'_>,
    tolerance: f64,
) -> Result<Mat<f64>, SeparatedError> {
    let mut basis = EnergyBasis::new(samples.first().map_or(0, |x| x.nrows()));
    for x in samples {
        check_len("rows of a sample", samples[0].nrows(), x.nrows())?;
        basis.append(x.as_ref(), energy, 1e-2 * tolerance);
    }
    basis.truncated(tolerance)
}

/// Reduces a block problem: greedy samples, compression, Galerkin projection. `row_weights` turn a residual into an
/// estimate of the error's energy norm, one over the diagonal of `M`; they steer the choice of samples, nothing else.
///
/// # Errors
/// [`SeparatedError::NotPositiveDefinite`] from the solves, [`SeparatedError::Shape`].
pub fn reduce<S: Space>(
    problem: &BlockProblem<S>,
    energy: &Energy<'_>,
    row_weights: &[f64],
    options: &ReductionOptions,
) -> Result<Reduction, SeparatedError> {
    check_len("row weights", problem.space().n_rows(), row_weights.len())?;
    let mut random = Random::new(options.seed);
    let mut basis = EnergyBasis::new(row_weights.len());
    let mut points =
        vec![corner(problem.axes(), 0), corner(problem.axes(), usize::MAX), middle(problem.axes())];
    points.truncate(options.max_samples);
    for point in &points {
        basis.append(problem.solve(point)?.as_ref(), energy, 1e-2 * options.tolerance);
    }
    let mut history: Vec<f64> = Vec::new();
    while points.len() < options.max_samples {
        let reduced = Reduced::new(problem, basis.vectors.clone())?;
        let candidates = candidates(problem.axes(), options.candidates, &mut random);
        let estimates: Vec<f64> = candidates
            .par_iter()
            .map(|p| reduced.estimate(problem, p, row_weights))
            .collect::<Result<_, _>>()?;
        let worst = (0..candidates.len()).max_by(|i, j| estimates[*i].total_cmp(&estimates[*j]));
        let Some(point) = worst.map(|i| candidates[i].clone()) else {
            break;
        };
        let exact = problem.solve(&point)?;
        let error = reduced.error(&point, &exact, energy)?;
        history.push(error);
        let size = basis.vectors.ncols();
        basis.append(exact.as_ref(), energy, 1e-2 * options.tolerance);
        points.push(point);
        // A sample that adds no direction means that rounding, not the basis, is what is left.
        let met = history.iter().rev().take(2).filter(|e| **e <= options.tolerance).count() == 2;
        if met || basis.vectors.ncols() == size {
            break;
        }
    }
    let basis = basis.truncated(0.1 * options.tolerance)?;
    let problem = Reduced::new(problem, basis.clone())?.small;
    Ok(Reduction { basis, problem, points, history })
}

/// An orthonormal basis that grows, and the coordinates of everything it was grown from.
pub(crate) struct EnergyBasis {
    /// `(n, k)`.
    vectors: Mat<f64>,
    /// `M vectors`.
    images: Mat<f64>,
    /// Coordinates of each appended block, scaled to unit energy: `(k at that time, n_columns)`.
    coordinates: Vec<Mat<f64>>,
}

impl EnergyBasis {
    pub(crate) fn new(n: usize) -> EnergyBasis {
        EnergyBasis { vectors: Mat::zeros(n, 0), images: Mat::zeros(n, 0), coordinates: Vec::new() }
    }

    /// Adds what a block has outside the basis, leaving out columns whose remainder is below `drop` of the block.
    pub(crate) fn append(&mut self, block: MatRef<'_, f64>, energy: &Energy<'_>, drop: f64) {
        let size = inner(block, energy(block).as_ref()).max(0.0).sqrt();
        if size == 0.0 {
            return;
        }
        let n = block.nrows();
        let mut rest = Mat::from_fn(n, block.ncols(), |i, j| block[(i, j)] / size);
        let mut coordinates = Mat::zeros(self.vectors.ncols() + block.ncols(), block.ncols());
        for j in 0..block.ncols() {
            let mut v = rest.as_mut().subcols_mut(j, 1).to_owned();
            // Twice is enough: the second pass removes what rounding left of the first.
            for _ in 0..2 {
                let c = transposed_product(self.images.as_ref(), v.as_ref());
                add_product(v.as_mut(), -1.0, self.vectors.as_ref(), c.as_ref());
                (0..c.nrows()).for_each(|i| coordinates[(i, j)] += c[(i, 0)]);
            }
            let image = energy(v.as_ref());
            let length = inner(v.as_ref(), image.as_ref()).max(0.0).sqrt();
            if length > drop.max(8.0 * f64::EPSILON) {
                coordinates[(self.vectors.ncols(), j)] = length;
                push_column(&mut self.vectors, &v, length);
                push_column(&mut self.images, &image, length);
            }
        }
        self.coordinates.push(coordinates);
    }

    /// The basis as it stands.
    pub(crate) fn into_vectors(self) -> Mat<f64> {
        self.vectors
    }

    /// The leading directions of all coordinates, to a relative `tolerance`.
    fn truncated(&self, tolerance: f64) -> Result<Mat<f64>, SeparatedError> {
        let k = self.vectors.ncols();
        let columns: usize = self.coordinates.iter().map(|c| c.ncols()).sum();
        let mut all = Mat::zeros(k, columns);
        let mut at = 0;
        for c in &self.coordinates {
            for j in 0..c.ncols() {
                (0..c.nrows().min(k)).for_each(|i| all[(i, at)] = c[(i, j)]);
                at += 1;
            }
        }
        let (u, s, _) = thin_svd(all.as_ref())?;
        let total: f64 = s.iter().map(|x| x * x).sum();
        let (mut kept, mut tail) = (s.len(), 0.0);
        while kept > 1 && tail + s[kept - 1].powi(2) <= tolerance * tolerance * total {
            tail += s[kept - 1].powi(2);
            kept -= 1;
        }
        Ok(product(self.vectors.as_ref(), u.as_ref().subcols(0, kept)))
    }
}

fn push_column(to: &mut Mat<f64>, v: &Mat<f64>, length: f64) {
    let j = to.ncols();
    to.resize_with(v.nrows(), j + 1, |i, _| v[(i, 0)] / length);
}

/// A Galerkin projection and what its residual needs.
struct Reduced {
    basis: Mat<f64>,
    /// `S_t U`.
    images: Vec<Mat<f64>>,
    small: BlockProblem<DenseSpace>,
}

impl Reduced {
    fn new<S: Space>(problem: &BlockProblem<S>, basis: Mat<f64>) -> Result<Reduced, SeparatedError> {
        let images: Vec<_> =
            (0..problem.space().n_operators()).map(|t| problem.space().apply(t, basis.as_ref())).collect();
        let symmetric = |image: &Mat<f64>| {
            let m = transposed_product(basis.as_ref(), image.as_ref());
            Mat::from_fn(m.nrows(), m.ncols(), |i, j| 0.5 * (m[(i, j)] + m[(j, i)]))
        };
        let matrices = images.iter().map(symmetric).collect();
        let source = |s: &BlockSource| BlockSource {
            powers: s.powers.clone(),
            block: transposed_product(basis.as_ref(), s.block.as_ref()),
        };
        let sources = problem.sources().iter().map(source).collect();
        let space = DenseSpace::new(matrices)?;
        let small = BlockProblem::new(problem.axes().to_vec(), problem.powers().to_vec(), space, sources)?;
        Ok(Reduced { basis, images, small })
    }

    /// Weighted residual of the reduced solution over its size.
    fn estimate<S: Space>(
        &self,
        problem: &BlockProblem<S>,
        point: &[f64],
        row_weights: &[f64],
    ) -> Result<f64, SeparatedError> {
        let x = self.small.solve(point)?;
        let mut residual = problem.load(point);
        for (c, image) in problem.coefficients(point).into_iter().zip(&self.images) {
            add_product(residual.as_mut(), -c, image.as_ref(), x.as_ref());
        }
        let mass = problem.coefficients(point)[0].abs().max(f64::MIN_POSITIVE);
        let mut sum = 0.0;
        for j in 0..residual.ncols() {
            sum += (0..residual.nrows()).map(|i| row_weights[i] * residual[(i, j)].powi(2)).sum::<f64>();
        }
        Ok(sum.sqrt() / (mass * norm(x.as_ref())))
    }

    /// Error in the energy norm, relative.
    fn error(&self, point: &[f64], exact: &Mat<f64>, energy: &Energy<'_>) -> Result<f64, SeparatedError> {
        let x = self.small.solve(point)?;
        let mut gap = exact.clone();
        add_product(gap.as_mut(), -1.0, self.basis.as_ref(), x.as_ref());
        let size = |v: &Mat<f64>| inner(v.as_ref(), energy(v.as_ref()).as_ref()).max(0.0).sqrt();
        Ok(size(&gap) / size(exact))
    }
}

/// Corner of the box: bit `a` of `which` picks the upper end of axis `a`.
fn corner(axes: &[Axis], which: usize) -> Vec<f64> {
    axes.iter().enumerate().map(|(a, axis)| axis.at_fraction(((which >> a) & 1) as f64)).collect()
}

fn middle(axes: &[Axis]) -> Vec<f64> {
    axes.iter().map(|axis| axis.at_fraction(0.5)).collect()
}

fn candidates(axes: &[Axis], count: usize, random: &mut Random) -> Vec<Vec<f64>> {
    let corners = if axes.len() <= 5 { 1 << axes.len() } else { 0 };
    let mut points: Vec<Vec<f64>> = (0..corners).map(|which| corner(axes, which)).collect();
    points.extend((0..count).map(|_| axes.iter().map(|a| a.at_fraction(random.uniform())).collect()));
    points
}
