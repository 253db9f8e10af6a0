//! The block problem `(Σ_t c_t(μ) S_t) X(μ) = Σ_s c_s(μ) B_s` with `c(μ) = Π_a μ_a^{p_a}`.
//!
//! The family of docs/theory/5-vademecum.md, `(M + Σ_q θ_q K_q) X = −Σ_q θ_q K_q B` with `X = H − B`, is one of these: `X` keeps the
//! state linear and exact, one column per mode, and only real parameters become axes. Coefficients are products of
//! powers because that is what every choice of axes asks for: one `θ_q` per region, a common `θ` with contrasts
//! (`θ_q = θ κ_q`), geometric contrasts (`θ_1 = θ c^½, θ_2 = θ c^−½`), density scales on parts of `M`.

use super::axis::Axis;
use super::enrich::{EnrichmentOptions, EnrichmentReport};
use super::error::{SeparatedError, check_len};
use super::expansion::{Expansion, SampledBlocks};
use super::fit::{Measure, fit};
use super::linalg::{axpy, norm};
use super::problem::{AxisOperator, DenseSpace, Problem, Source, Space};
use super::solution::Separated;
use crate::linalg::Random;
use faer::{Mat, MatRef};
use rayon::prelude::*;

/// A right-hand side `Π_a μ_a^{powers_a} · block`.
#[derive(Clone, Debug)]
pub struct BlockSource {
    /// Exponent on each axis.
    pub powers: Vec<f64>,
    /// `(n_rows, n_columns)`.
    pub block: Mat<f64>,
}

/// A parametric problem in space with product coefficients.
#[derive(Clone, Debug)]
pub struct BlockProblem<S> {
    axes: Vec<Axis>,
    powers: Vec<Vec<f64>>,
    space: S,
    sources: Vec<BlockSource>,
}

impl<S: Space> BlockProblem<S> {
    /// `powers[t]` are the exponents of space operator `t`, one per axis.
    ///
    /// # Errors
    /// [`SeparatedError::Shape`].
    pub fn new(
        axes: Vec<Axis>,
        powers: Vec<Vec<f64>>,
        space: S,
        sources: Vec<BlockSource>,
    ) -> Result<BlockProblem<S>, SeparatedError> {
        check_len("exponents, one list per space operator", space.n_operators(), powers.len())?;
        powers.iter().try_for_each(|p| check_len("exponents, one per axis", axes.len(), p.len()))?;
        let columns = sources.first().map_or(0, |s| s.block.ncols());
        for s in &sources {
            check_len("exponents, one per axis", axes.len(), s.powers.len())?;
            check_len("rows of a source block", space.n_rows(), s.block.nrows())?;
            check_len("columns of a source block", columns, s.block.ncols())?;
        }
        Ok(BlockProblem { axes, powers, space, sources })
    }

    /// The increment problem of docs/theory/5-vademecum.md, `(Σ_p ρ_p M_p + Σ_q θ_q K_q) X = −Σ_q θ_q K_q B`: `space` holds the mass
    /// matrices first, then the stiffness matrices; `mass_powers` and `stiffness_powers` are the exponents of `ρ_p` and
    /// `θ_q`, one list per matrix (`[[0, 0, …]]` for one mass without live density); `basis` is `B`, `(n_rows, n_modes)`.
    ///
    /// # Errors
    /// [`SeparatedError::Shape`].
    pub fn increment(
        axes: Vec<Axis>,
        mass_powers: &[Vec<f64>],
        stiffness_powers: &[Vec<f64>],
        space: S,
        basis: MatRef<'_, f64>,
    ) -> Result<BlockProblem<S>, SeparatedError> {
        let powers = [mass_powers, stiffness_powers].concat();
        check_len("exponents, one list per space operator", space.n_operators(), powers.len())?;
        check_len("rows of the basis", space.n_rows(), basis.nrows())?;
        let source = |(q, p): (usize, &Vec<f64>)| {
            let mut block = space.apply(mass_powers.len() + q, basis);
            (0..block.ncols()).for_each(|j| block.col_as_slice_mut(j).iter_mut().for_each(|v| *v = -*v));
            BlockSource { powers: p.clone(), block }
        };
        let sources = stiffness_powers.iter().enumerate().map(source).collect();
        BlockProblem::new(axes, powers, space, sources)
    }

    /// The parameter axes.
    pub fn axes(&self) -> &[Axis] {
        &self.axes
    }

    /// The space operators.
    pub fn space(&self) -> &S {
        &self.space
    }

    /// Exponents of the space operators.
    pub fn powers(&self) -> &[Vec<f64>] {
        &self.powers
    }

    /// The right-hand sides.
    pub fn sources(&self) -> &[BlockSource] {
        &self.sources
    }

    /// Columns of the solution.
    pub fn n_columns(&self) -> usize {
        self.sources.first().map_or(0, |s| s.block.ncols())
    }

    /// Coefficients of the space operators at `point`.
    pub fn coefficients(&self, point: &[f64]) -> Vec<f64> {
        self.powers.iter().map(|p| monomial(p, point)).collect()
    }

    /// Right-hand side at `point`: `(n_rows, n_columns)`.
    pub fn load(&self, point: &[f64]) -> Mat<f64> {
        let mut load = Mat::zeros(self.space.n_rows(), self.n_columns());
        for s in &self.sources {
            axpy(load.as_mut(), monomial(&s.powers, point), s.block.as_ref());
        }
        load
    }

    /// The solution at `point`, one factorisation: `(n_rows, n_columns)`.
    ///
    /// # Errors
    /// [`SeparatedError::NotPositiveDefinite`].
    pub fn solve(&self, point: &[f64]) -> Result<Mat<f64>, SeparatedError> {
        self.space.solve(&self.coefficients(point), self.load(point).as_ref())
    }

    /// `load − operator · x` at `point`: `(n_rows, n_columns)`.
    pub fn residual(&self, point: &[f64], x: &Mat<f64>) -> Mat<f64> {
        let mut residual = self.load(point);
        for (t, c) in self.coefficients(point).into_iter().enumerate() {
            axpy(residual.as_mut(), -c, self.space.apply(t, x.as_ref()).as_ref());
        }
        residual
    }

    /// Separates the solution, solved at up to `most` points of the grid, see [`SampledBlocks::collect`] and [`fit()`].
    ///
    /// # Errors
    /// As [`SampledBlocks::collect`] and [`fit()`].
    pub fn separate(
        &self,
        most: usize,
        options: &EnrichmentOptions,
        measure: Option<Measure<'_, SeparatedError>>,
    ) -> Result<(Separated, EnrichmentReport), SeparatedError> {
        let samples = SampledBlocks::collect(&self.axes, most, None, |point| self.solve(point))?;
        fit(&Expansion::new(&samples), options, measure)
    }
}

impl BlockProblem<DenseSpace> {
    /// The same problem for the Galerkin engine: collocation in the parameters with quadrature weights.
    ///
    /// # Errors
    /// [`SeparatedError::Shape`].
    pub fn galerkin(&self) -> Result<Problem<DenseSpace>, SeparatedError> {
        let on_axis = |power: f64, axis: &Axis| -> Vec<f64> {
            axis.weights().iter().zip(axis.nodes()).map(|(w, x)| w * x.powf(power)).collect()
        };
        let on_axes = |powers: &[f64]| -> Vec<Vec<f64>> {
            powers.iter().zip(&self.axes).map(|(p, a)| on_axis(*p, a)).collect()
        };
        let operators = self
            .powers
            .iter()
            .map(|p| on_axes(p).into_iter().map(AxisOperator::diagonal).collect())
            .collect();
        let source = |s: &BlockSource| Source { vectors: on_axes(&s.powers), block: s.block.clone() };
        let sources = self.sources.iter().map(source).collect();
        Problem::new(self.axes.clone(), operators, self.space.clone(), sources)
    }
}

/// `Π_a μ_a^{p_a}`.
fn monomial(powers: &[f64], point: &[f64]) -> f64 {
    powers.iter().zip(point).map(|(p, x)| if *p == 0.0 { 1.0 } else { x.powf(*p) }).product()
}

/// Exact solutions at random points that no fit has seen.
#[derive(Clone, Debug)]
pub struct FreshPoints {
    points: Vec<Vec<f64>>,
    exact: Vec<Mat<f64>>,
}

impl FreshPoints {
    /// Solves at the given points, in parallel.
    ///
    /// # Errors
    /// [`SeparatedError::NotPositiveDefinite`].
    pub fn at<S: Space>(
        problem: &BlockProblem<S>,
        points: Vec<Vec<f64>>,
    ) -> Result<FreshPoints, SeparatedError> {
        let exact = points.par_iter().map(|p| problem.solve(p)).collect::<Result<_, _>>()?;
        Ok(FreshPoints { points, exact })
    }

    /// `count` random points of the box, uniform along each axis (in `ln μ` on logarithmic ones).
    ///
    /// # Errors
    /// [`SeparatedError::NotPositiveDefinite`].
    pub fn random<S: Space>(
        problem: &BlockProblem<S>,
        count: usize,
        seed: u64,
    ) -> Result<FreshPoints, SeparatedError> {
        let mut random = Random::new(seed);
        let point = |_| problem.axes.iter().map(|a| a.at_fraction(random.uniform())).collect();
        let points = (0..count).map(point).collect();
        FreshPoints::at(problem, points)
    }

    /// Error of `u` relative to the exact solution *at the same point*: (root mean square, worst) over the points.
    ///
    /// # Errors
    /// [`SeparatedError::OutsideAxis`] when `u` has other axes than the problem had.
    pub fn error(&self, u: &Separated) -> Result<(f64, f64), SeparatedError> {
        let (mut squares, mut worst) = (0.0, 0.0f64);
        for (point, exact) in self.points.iter().zip(&self.exact) {
            let error = norm((exact - u.evaluate(point)?).as_ref()) / norm(exact.as_ref());
            squares += error * error;
            worst = worst.max(error);
        }
        Ok(((squares / self.points.len() as f64).sqrt(), worst))
    }
}
