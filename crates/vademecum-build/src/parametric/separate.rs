//! The stage responses over the whole box: sampled, compressed in space, separated, expanded.
//!
//! The block problem is method.md §3 with `X = H − B`. With live region densities the state and the loads need two
//! different columns, `X = (M(ρ)+θK)⁻¹ M(ρ) B − B` and `Z = (M(ρ)+θK)⁻¹ M₀ B − B`; they are separated side by side.

use faer::{Mat, MatRef};
use rayon::prelude::*;
use vademecum_format::scheme::{SchemeError, SchemeTable, theta};
use vademecum_format::{Axis as FileAxis, AxisKind as FileAxisKind, AxisRole, MAX_REGIONS};

use super::{ParameterSpace, Setting};
use crate::export::{AxisTable, BlockTerms};
use crate::fem::{Pencil, Solve, SymmetricMatrix, Symbolic};
use crate::progress::{Cancelled, Listener};
use crate::response::StageResponse;
use crate::separated::{
    Axis, AxisKind, BlockProblem, BlockSource, EnrichmentOptions, EnrichmentReport, FreshPoints, ReductionOptions,
    RegionAxes, Separated, SeparatedError, Space, chebyshev_points, reduce,
};

/// Parameter points at which the small problem is solved for the fit: few samples overfit many axes.
fn fit_samples(axes: usize) -> usize {
    if axes <= 3 { 4000 } else { 12_000 }
}
/// Fresh points at which errors are measured.
const FRESH: usize = 200;

/// Why there are no separated responses.
#[derive(Debug, thiserror::Error)]
pub enum ParametricError {
    /// The separation itself.
    #[error("the separated solution")]
    Separated(#[from] SeparatedError),
    /// The scheme refuses a parameter.
    #[error("`parameter`")]
    Scheme(#[from] SchemeError),
    /// On request.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// How far the separation goes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SeparationOptions {
    /// Largest relative error of `H − B` over fresh points, root mean square; ten times that at the worst.
    pub tolerance: f64,
    /// Most terms.
    pub max_terms: usize,
}

/// Stage responses as a separated solution over the box.
pub struct Parametric {
    map: AxisMap,
    /// Blocks of shape (n, r), or (n, 2r) with region densities: state columns, then load columns.
    solution: Separated,
    /// `BᵀM₀ F_t` of the state columns of each term, shape (r, r).
    states: Vec<Mat<f64>>,
    n_modes: usize,
    /// What the enrichment did.
    pub enrichment: EnrichmentReport,
    /// Vectors of the reduced space.
    pub reduced_size: usize,
    /// Full-order solves behind it.
    pub samples: usize,
    /// Relative error of `H − B` over fresh points of the box, mass norm, against full-order solves: (rms, worst).
    pub map_error: (f64, f64),
}

/// From θ and region factors to a point on the axes.
struct AxisMap {
    regions: RegionAxes,
    axes: Vec<Axis>,
    /// Region of each density axis.
    density_axes: Vec<usize>,
    /// Regions with live stiffness: the others stand at 1.
    n_regions: usize,
}

/// The operators of a pencil, factorised with its own symbolic analysis.
struct PencilSpace<'a> {
    matrices: Vec<&'a SymmetricMatrix>,
    symbolic: &'a Symbolic,
}

impl Space for PencilSpace<'_> {
    fn n_rows(&self) -> usize {
        self.matrices[0].n()
    }

    fn n_operators(&self) -> usize {
        self.matrices.len()
    }

    fn apply(&self, t: usize, block: MatRef<'_, f64>) -> Mat<f64> {
        let mut out = Mat::zeros(block.nrows(), block.ncols());
        self.matrices[t].mul_into(block, out.as_mut());
        out
    }

    fn solve(&self, weights: &[f64], rhs: MatRef<'_, f64>) -> Result<Mat<f64>, SeparatedError> {
        let parts: Vec<(f64, &SymmetricMatrix)> = weights.iter().copied().zip(self.matrices.iter().copied()).collect();
        let factor = self
            .symbolic
            .factorize(SymmetricMatrix::combine(&parts))
            .map_err(|_| SeparatedError::NotPositiveDefinite { what: "stage matrix at a parameter sample" })?;
        let mut x = rhs.to_owned();
        Solve::new(self.symbolic, x.ncols(), true).solve_in_place(&factor, x.as_mut());
        Ok(x)
    }
}

/// Chebyshev points on a density axis: the singularities of the response lie as for a stiffness factor, π away in the
/// complex logarithm.
fn density_points((lower, upper): (f64, f64), tolerance: f64) -> usize {
    chebyshev_points(upper / lower, std::f64::consts::PI, tolerance)
}

impl AxisMap {
    fn new(space: &ParameterSpace, theta: (f64, f64), tolerance: f64) -> Result<Self, SeparatedError> {
        // A scheme whose stages share θ, and no parameter that moves it, still need an axis of some width.
        let theta = if theta.1 > 1.001 * theta.0 { theta } else { (theta.0 / 1.01, theta.1 * 1.01) };
        let scales: Vec<_> = (0..space.n_regions).map(|q| space.region_range(q, false)).collect();
        let regions = RegionAxes::new(theta, &scales, 0.1 * tolerance)?;
        let mut axes = regions.axes().to_vec();
        let mut density_axes = vec![];
        for q in 0..space.n_regions {
            if let Some((lower, upper)) = space.region_range(q, true) {
                let points = density_points((lower, upper), 0.1 * tolerance);
                let name = format!("rho{}", q + 1);
                axes.push(Axis::new(&name, "1", lower, upper, AxisKind::Chebyshev { points }, true)?);
                density_axes.push(q);
            }
        }
        Ok(Self { regions, axes, density_axes, n_regions: space.n_regions })
    }

    fn point(&self, theta: f64, setting: &Setting) -> Result<Vec<f64>, SeparatedError> {
        let mut point = self.regions.point(theta, &setting.stiffness)?;
        point.extend(self.density_axes.iter().map(|&q| setting.density[q]));
        Ok(point)
    }

    /// Exponents of θ, the stiffness and the density factors in each axis: logarithms of the point of one variable at e.
    fn roles(&self) -> Result<Vec<AxisRole>, SeparatedError> {
        let point = |theta: f64, scaled: Option<usize>| {
            let mut scales = vec![1.0; self.n_regions];
            if let Some(q) = scaled {
                scales[q] = std::f64::consts::E;
            }
            self.regions.point(theta, &scales)
        };
        // Exponents are halves; rounding to quarters makes them exact.
        let exponent = |value: f64| (4.0 * value.ln()).round() / 4.0;
        let by_theta = point(std::f64::consts::E, None)?;
        let by_region = (0..self.n_regions).map(|q| point(1.0, Some(q))).collect::<Result<Vec<_>, _>>()?;
        let regional = self.regions.axes().len();
        let role = |a: usize| {
            let (mut stiffness, mut density) = ([0.0; MAX_REGIONS], [0.0; MAX_REGIONS]);
            if a < regional {
                (0..self.n_regions).for_each(|q| stiffness[q] = exponent(by_region[q][a]));
                return AxisRole::Monomial { theta: exponent(by_theta[a]), stiffness, density };
            }
            density[self.density_axes[a - regional]] = 1.0;
            AxisRole::Monomial { theta: 0.0, stiffness, density }
        };
        Ok((0..self.axes.len()).map(role).collect())
    }

    /// Exponents of the axes in θ_q, density axes included.
    fn stiffness_powers(&self) -> Vec<Vec<f64>> {
        let pad = |p: &Vec<f64>| p.iter().copied().chain(self.density_axes.iter().map(|_| 0.0)).collect();
        self.regions.powers().iter().map(pad).collect()
    }

    /// Exponents of the axes in ρ_q.
    fn density_powers(&self, region: usize) -> Vec<f64> {
        let first = self.regions.axes().len();
        let own = |a: usize| a >= first && self.density_axes[a - first] == region;
        (0..self.axes.len()).map(|a| if own(a) { 1.0 } else { 0.0 }).collect()
    }
}

/// The parametric block problem in the full space.
fn block_problem<'a>(
    map: &AxisMap,
    pencil: &'a Pencil,
    symbolic: &'a Symbolic,
    basis: &Mat<f64>,
) -> Result<BlockProblem<PencilSpace<'a>>, SeparatedError> {
    let powers = map.stiffness_powers();
    let mut matrices = vec![pencil.mass()];
    matrices.extend((0..map.n_regions).map(|q| pencil.region_stiffness(q)));
    if map.density_axes.is_empty() {
        let space = PencilSpace { matrices, symbolic };
        let fixed_mass = [vec![0.0; map.axes.len()]];
        return BlockProblem::increment(map.axes.clone(), &fixed_mass, &powers, space, basis.as_ref());
    }
    matrices.splice(0..1, (0..map.n_regions).map(|q| pencil.region_mass(q)));
    let space = PencilSpace { matrices, symbolic };
    let (n, r) = (basis.nrows(), basis.ncols());
    // Columns: X (state), Z (loads). (M(ρ)+θK) X = −θKB and (M(ρ)+θK) Z = Σ (1 − ρ_q) M_q B − θKB.
    let source = |powers: Vec<f64>, block: Mat<f64>, factor: f64, state: bool| BlockSource {
        powers,
        block: Mat::from_fn(n, 2 * r, |i, j| if j >= r || state { factor * block[(i, j % r)] } else { 0.0 }),
    };
    let mut sources = vec![];
    for q in 0..map.n_regions {
        let mass = space.apply(q, basis.as_ref());
        let stiffness = space.apply(map.n_regions + q, basis.as_ref());
        sources.push(source(vec![0.0; map.axes.len()], mass.clone(), 1.0, false));
        sources.push(source(map.density_powers(q), mass, -1.0, false));
        sources.push(source(powers[q].clone(), stiffness, -1.0, true));
    }
    let operators = (0..map.n_regions).map(|q| map.density_powers(q)).chain(powers.clone()).collect();
    BlockProblem::new(map.axes.clone(), operators, space, sources)
}

/// Separates the stage responses over the box.
///
/// Cost: some tens of factorisations and solves in the full space to compress it, a few thousand small dense solves and
/// the fit, which do not grow with the mesh, and one factorisation per fresh point to certify the result.
///
/// # Errors
/// [`ParametricError`].
pub fn separate_responses(
    pencil: &Pencil,
    symbolic: &Symbolic,
    basis: &Mat<f64>,
    space: &ParameterSpace,
    scheme: &SchemeTable,
    asked: &SeparationOptions,
    listener: &dyn Listener,
) -> Result<Parametric, ParametricError> {
    let SeparationOptions { tolerance, max_terms } = *asked;
    let range = space.theta_range(scheme)?;
    space.explain(range).iter().for_each(|line| listener.note(line));
    let map = AxisMap::new(space, range, tolerance)?;
    let problem = block_problem(&map, pencil, symbolic, basis)?;

    listener.stage("parameters: compress space");
    let energy = |x: MatRef<'_, f64>| {
        let mut y = Mat::zeros(x.nrows(), x.ncols());
        pencil.mass().mul_into(x, y.as_mut());
        y
    };
    let row_weights: Vec<f64> = (0..pencil.n_dof()).map(|i| 1.0 / pencil.mass().diagonal(i)).collect();
    let options = ReductionOptions { tolerance: 0.1 * tolerance, max_samples: 80, ..Default::default() };
    let reduction = reduce(&problem, &energy, &row_weights, &options)?;
    listener.checkpoint(1, 1)?;

    listener.stage("parameters: separate");
    let points = fresh_points(space, scheme, &map, FRESH, 7)?;
    let fresh = FreshPoints::at(&reduction.problem, points.clone())?;
    // Root mean square to the tolerance and the worst point to ten times it: whichever is farther decides.
    let measure = |u: &Separated| fresh.error(u).map_or(f64::INFINITY, |(rms, worst)| rms.max(0.1 * worst));
    let options = EnrichmentOptions { tolerance: 0.8 * tolerance, max_terms, ..Default::default() };
    let (small, enrichment) = reduction.problem.separate(fit_samples(map.axes.len()), &options, Some(&measure))?;
    let solution = small.expand(reduction.basis.as_ref())?;
    listener.checkpoint(1, 1)?;

    listener.stage("parameters: certify the maps");
    let points = fresh_points(space, scheme, &map, FRESH, 8)?;
    let map_error = full_space_error(&problem, &energy, &solution, &points, listener)?;
    let r = basis.ncols();
    let weighted = energy(basis.as_ref());
    let state = |t: usize| weighted.transpose() * solution.block(t).subcols(0, r);
    Ok(Parametric {
        states: (0..solution.n_terms()).map(state).collect(),
        n_modes: r,
        reduced_size: reduction.basis.ncols(),
        samples: reduction.points.len(),
        enrichment,
        map_error,
        solution,
        map,
    })
}

/// Random settings of the user's box, each in a random stage, as points on the axes.
fn fresh_points(
    space: &ParameterSpace,
    scheme: &SchemeTable,
    map: &AxisMap,
    count: usize,
    seed: u64,
) -> Result<Vec<Vec<f64>>, ParametricError> {
    let n_stages = scheme.active().len();
    let point = |(i, values): (usize, Vec<f64>)| {
        let setting = space.setting(&values);
        let theta = theta(scheme, &setting.step, i % n_stages)?;
        Ok(map.point(theta, &setting)?)
    };
    space.random(count, seed).into_iter().enumerate().map(point).collect()
}

/// Error of the separated solution against full-order solves, relative to each, mass norm: (rms, worst).
fn full_space_error(
    problem: &BlockProblem<PencilSpace<'_>>,
    energy: &(dyn Fn(MatRef<'_, f64>) -> Mat<f64> + Sync),
    solution: &Separated,
    points: &[Vec<f64>],
    listener: &dyn Listener,
) -> Result<(f64, f64), ParametricError> {
    let norm = |x: &Mat<f64>| {
        let weighted = energy(x.as_ref());
        (0..x.ncols()).map(|j| x.col(j).transpose() * weighted.col(j)).sum::<f64>().max(0.0).sqrt()
    };
    let error = |point: &Vec<f64>| -> Result<f64, ParametricError> {
        listener.checkpoint(0, points.len())?;
        let exact = problem.solve(point)?;
        let difference = &exact - solution.evaluate(point)?;
        Ok(norm(&difference) / norm(&exact))
    };
    let errors = points.par_iter().map(error).collect::<Result<Vec<f64>, _>>()?;
    let rms = (errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64).sqrt();
    Ok((rms, errors.iter().copied().fold(0.0, f64::max)))
}

impl Parametric {
    /// Number of terms.
    pub fn n_terms(&self) -> usize {
        self.solution.n_terms()
    }

    /// Points of each axis.
    pub fn axis_points(&self) -> Vec<usize> {
        self.map.axes.iter().map(Axis::len).collect()
    }

    /// The response of each stage at a setting: what the evaluator assembles when it binds.
    ///
    /// # Errors
    /// If the setting lies outside the box.
    pub fn responses(&self, scheme: &SchemeTable, setting: &Setting) -> Result<Vec<StageResponse>, ParametricError> {
        let r = self.n_modes;
        let response = |stage: usize| {
            let theta = theta(scheme, &setting.step, stage)?;
            let weights = self.solution.weights(&self.map.point(theta, setting)?)?;
            let block = self.solution.combine(&weights);
            let mut state = Mat::zeros(r, r);
            weights.iter().zip(&self.states).for_each(|(&w, s)| state += s * faer::Scale(w));
            let increment = block.subcols(block.ncols() - r, r).to_owned();
            Ok(StageResponse { theta, increment, state, residual: f64::NAN })
        };
        (0..scheme.active().len()).map(response).collect()
    }

    /// Only the square parts, for stability over many settings.
    ///
    /// # Errors
    /// If the setting lies outside the box.
    pub fn states(&self, scheme: &SchemeTable, setting: &Setting) -> Result<Vec<Mat<f64>>, ParametricError> {
        let state = |stage: usize| {
            let theta = theta(scheme, &setting.step, stage)?;
            let weights = self.solution.weights(&self.map.point(theta, setting)?)?;
            let mut state = Mat::zeros(self.n_modes, self.n_modes);
            weights.iter().zip(&self.states).for_each(|(&w, s)| state += s * faer::Scale(w));
            Ok(state)
        };
        (0..scheme.active().len()).map(state).collect()
    }

    /// The terms as the file keeps them.
    ///
    /// # Errors
    /// If the axes cannot be expressed in the file.
    pub fn terms(&self) -> Result<BlockTerms<'_>, ParametricError> {
        let r = self.n_modes;
        let table = |(a, role): (usize, AxisRole)| {
            let axis = &self.map.axes[a];
            let (lower, upper) = axis.range();
            AxisTable {
                axis: FileAxis {
                    name: axis.name(),
                    unit: axis.unit(),
                    role,
                    kind: FileAxisKind::Chebyshev,
                    log: axis.is_log(),
                    lower,
                    upper,
                    n_points: axis.len() as u32,
                },
                points: axis.nodes().to_vec(),
                factors: self.solution.factors(a).transpose().to_owned(),
            }
        };
        let load = |t: usize| {
            let block = self.solution.block(t);
            block.subcols(block.ncols() - r, r).to_owned()
        };
        Ok(BlockTerms {
            axes: self.map.roles()?.into_iter().enumerate().map(table).collect(),
            states: self.states.clone(),
            loads: (0..self.n_terms()).map(load).collect(),
        })
    }
}
