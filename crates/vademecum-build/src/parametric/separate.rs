//! The stage responses over the whole box: sampled, compressed in space, separated, expanded.
//!
//! Loads need `Z = (M + θK)⁻¹ M₀ B − B` (reciprocity: its rows), the state needs `E = BᵀM₀ X`. With regions live the
//! eigenvectors turn with the contrast and a fixed basis `B` cannot follow: taking `u = Bζ` for the state misplaces
//! what `B` does not span, and frequencies shift. So the state is lifted at the parameters themselves,
//!
//! ```text
//! u = B̃ ζ,   B̃ = G²B (BᵀM₀ G²B)⁻¹,   G = K⁻¹M        X = −(M + θK)⁻¹ θK B̃
//! ```
//!
//! `G²B` is two steps of inverse iteration from `B`: nearly invariant there, rational in the parameters, and
//! normalised so that `BᵀM₀B̃ = I`, which leaves every formula of the fused step as it is (`docs/decisions/lifting.md`).

use faer::linalg::solvers::DenseSolveCore as _;
use faer::{Mat, MatRef};
use rayon::prelude::*;
use vademecum_format::scheme::{SchemeError, SchemeTable, theta};
use vademecum_format::{Axis as FileAxis, AxisKind as FileAxisKind, AxisRole, MAX_REGIONS};

use super::{ParameterSpace, Setting};
use crate::export::{AxisTable, BlockTerms};
use crate::fem::{Pencil, Solve, Symbolic, SymmetricMatrix};
use crate::pod::Basis;
use crate::progress::{Cancelled, Listener};
use crate::response::StageResponse;
use crate::separated::{
    Axis, AxisKind, DenseSpace, Energy, EnrichmentOptions, EnrichmentReport, Random, RegionAxes,
    SampledBlocks, Separated, SeparatedError, Space, chebyshev_points, compress, fit,
};

/// Parameter points at which the small problem is solved for the fit: few samples overfit many axes.
fn fit_samples(axes: usize) -> usize {
    if axes <= 3 { 4000 } else { 12_000 }
}
/// Steps of inverse iteration from `B` to the lifted basis.
const INVERSE_ITERATIONS: usize = 2;
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
#[derive(serde::Serialize, serde::Deserialize)]
pub struct Parametric {
    map: AxisMap,
    /// Factors, and blocks in the compressed space: loads above states.
    solution: Separated,
    /// `H − B` of each term, shape (n, r).
    #[serde(with = "crate::resume::matrix::list")]
    loads: Vec<Mat<f64>>,
    /// `E` of each term, shape (r, r).
    #[serde(with = "crate::resume::matrix::list")]
    states: Vec<Mat<f64>>,
    /// What the enrichment did.
    pub enrichment: EnrichmentReport,
    /// Vectors of the compressed space.
    pub reduced_size: usize,
    /// Parameter points at which the full space was sampled.
    pub samples: usize,
    /// Relative error of loads and state over fresh points of the box against full-order solves: (rms, worst).
    pub map_error: (f64, f64),
}

/// From θ and region factors to a point on the axes.
#[derive(Clone, serde::Serialize, serde::Deserialize)]
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
        let parts: Vec<(f64, &SymmetricMatrix)> =
            weights.iter().copied().zip(self.matrices.iter().copied()).collect();
        let factor = self.symbolic.factorize(SymmetricMatrix::combine(&parts)).map_err(|_| {
            SeparatedError::NotPositiveDefinite { what: "stage matrix at a parameter sample" }
        })?;
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

/// Weights of the operators `[M_0, …, K_0, …]` at a point on the axes.
fn weights(map: &AxisMap, point: &[f64]) -> Vec<f64> {
    let monomial = |powers: Vec<f64>| powers.iter().zip(point).map(|(p, x)| x.powf(*p)).product::<f64>();
    let masses = (0..map.n_regions).map(|q| monomial(map.density_powers(q)));
    masses.chain(map.stiffness_powers().into_iter().map(monomial)).collect()
}

/// The problem in one space, full or compressed: operators, basis and `M₀ B` in its coordinates.
struct Responses<'a, S> {
    space: S,
    map: &'a AxisMap,
    basis: Mat<f64>,
    weighted: Mat<f64>,
    /// `s_k`, see [`mode_scales`]; states are separated as `S⁻¹ E S⁻¹`.
    scales: Vec<f64>,
    /// Whether the state is lifted; without live regions `B̃ = B` for every basis that a build makes.
    lift: bool,
}

/// What is separated at one point.
struct Response {
    /// `Z`, shape (n, r).
    load: Mat<f64>,
    /// `S⁻¹ E S⁻¹`, shape (r, r).
    state: Mat<f64>,
    /// Other vectors a compressed space must hold to find the same.
    auxiliary: Vec<Mat<f64>>,
}

impl<S: Space> Responses<'_, S> {
    fn apply(&self, weights: &[f64], range: std::ops::Range<usize>, block: MatRef<'_, f64>) -> Mat<f64> {
        let mut sum = Mat::zeros(block.nrows(), block.ncols());
        for t in range {
            sum += self.space.apply(t, block) * faer::Scale(weights[t]);
        }
        sum
    }

    /// `S⁻¹ E S⁻¹`.
    fn scaled(&self, state: Mat<f64>) -> Mat<f64> {
        Mat::from_fn(state.nrows(), state.ncols(), |i, j| state[(i, j)] / (self.scales[i] * self.scales[j]))
    }

    fn at(&self, point: &[f64]) -> Result<Response, SeparatedError> {
        let regions = self.map.n_regions;
        let (masses, stiffnesses) = (0..regions, regions..2 * regions);
        let weights = weights(self.map, point);
        let mut stiffness_only = weights.clone();
        stiffness_only[..regions].fill(0.0);
        let mass = |x: &Mat<f64>| self.apply(&weights, masses.clone(), x.as_ref());
        let stiffness = |x: &Mat<f64>| self.apply(&weights, stiffnesses.clone(), x.as_ref());
        let static_response = |x: &Mat<f64>| self.space.solve(&stiffness_only, mass(x).as_ref());

        if !self.lift {
            // M₀B − M(ρ)B vanishes without live densities; the rest is the increment, not a difference of large numbers.
            let mut rhs = &self.weighted - mass(&self.basis);
            rhs -= stiffness(&self.basis);
            let load = self.space.solve(&weights, rhs.as_ref())?;
            let state = self.scaled(self.weighted.transpose() * &load);
            return Ok(Response { load, state, auxiliary: vec![] });
        }
        let mut lifted = self.basis.clone();
        let mut auxiliary = vec![];
        for _ in 0..INVERSE_ITERATIONS {
            let next = static_response(&lifted)?;
            // Normalised at every step: the columns would all turn to the lowest modes otherwise.
            lifted = &next * (self.weighted.transpose() * &next).partial_piv_lu().inverse();
            auxiliary.push(normalised(next));
        }
        let reduced_mass = lifted.transpose() * mass(&lifted);
        let reduced_stiffness = lifted.transpose() * stiffness(&lifted);
        let inverse = (&reduced_mass + &reduced_stiffness).partial_piv_lu().inverse();
        let state = self.scaled(&inverse * reduced_stiffness * faer::Scale(-1.0));
        let load = &lifted * inverse - &self.basis;
        Ok(Response { load, state, auxiliary })
    }
}

/// `s_k² = x/(1 + x)` with `x = θλ_k` at the middle θ: the size of mode k's entry of `E`.
///
/// `E` spans the decades between the lowest and the highest mode. An error of 1e-6 of its norm is one of 1e-2 of the entry of a
/// mode with `θλ = 1e-4`, and shifts that mode's frequency by half as much; scaled, every mode gets the tolerance.
fn mode_scales(stiffness: MatRef<'_, f64>, theta: (f64, f64)) -> Vec<f64> {
    let middle = (theta.0 * theta.1).sqrt();
    let scale = |k: usize| {
        let x = middle * stiffness[(k, k)];
        (x / (1.0 + x)).sqrt()
    };
    (0..stiffness.nrows()).map(scale).collect()
}

/// Columns scaled to unit length: only their span counts.
fn normalised(mut block: Mat<f64>) -> Mat<f64> {
    for j in 0..block.ncols() {
        let length = block.col(j).norm_l2();
        block.col_as_slice_mut(j).iter_mut().for_each(|v| *v /= length);
    }
    block
}

/// Operators of all regions over the free dofs.
fn full_space<'a>(pencil: &'a Pencil, symbolic: &'a Symbolic, regions: usize) -> PencilSpace<'a> {
    let masses = (0..regions).map(|q| pencil.region_mass(q));
    PencilSpace {
        matrices: masses.chain((0..regions).map(|q| pencil.region_stiffness(q))).collect(),
        symbolic,
    }
}

/// Separates the stage responses over the box.
///
/// Cost: some tens of factorisations and solves in the full space to compress it, a few thousand small dense solves and
/// the fit, which do not grow with the mesh, and two factorisations per fresh point to certify the result.
///
/// # Errors
/// [`ParametricError`].
pub fn separate_responses(
    pencil: &Pencil,
    symbolic: &Symbolic,
    basis: &Basis,
    space: &ParameterSpace,
    scheme: &SchemeTable,
    asked: &SeparationOptions,
    listener: &dyn Listener,
) -> Result<Parametric, ParametricError> {
    let SeparationOptions { tolerance, max_terms } = *asked;
    let range = space.theta_range(scheme)?;
    space.explain(range).iter().for_each(|line| listener.note(line));
    let map = AxisMap::new(space, range, tolerance)?;
    let energy = |x: MatRef<'_, f64>| {
        let mut y = Mat::zeros(x.nrows(), x.ncols());
        pencil.mass().mul_into(x, y.as_mut());
        y
    };
    let full = Responses {
        space: full_space(pencil, symbolic, space.n_regions),
        map: &map,
        basis: basis.vectors.clone(),
        weighted: energy(basis.vectors.as_ref()),
        scales: mode_scales(basis.stiffness.as_ref(), range),
        lift: space.has_region_parameters(),
    };

    listener.stage("parameters: compress space");
    let points = compression_points(space, scheme, &map)?;
    let vectors = compressed_basis(&full, &points, &energy, tolerance, listener)?;

    listener.stage("parameters: separate");
    let small = compressed(&full, &vectors)?;
    let fresh = fresh_points(space, scheme, &map, FRESH, 7)?;
    let exact = fresh.par_iter().map(|p| small.at(p)).collect::<Result<Vec<_>, _>>()?;
    // Root mean square to the tolerance and the worst point to ten times it: whichever is farther decides.
    let rows = vectors.ncols();
    let measure = |u: &Separated| {
        let errors = fresh.iter().zip(&exact).map(|(point, exact)| small_error(u, rows, point, exact));
        spread(errors).map_or(f64::INFINITY, |(rms, worst)| rms.max(0.1 * worst))
    };
    let samples = grid_samples(&small, rows, fit_samples(map.axes.len()))?;
    let options =
        EnrichmentOptions { tolerance: 0.8 * tolerance, max_terms, update_sweeps: 15, ..Default::default() };
    let (solution, enrichment) = fit(&samples, &options, Some(&measure))?;
    listener.checkpoint(1, 1)?;

    let n_modes = basis.n_modes();
    let block = |t: usize| solution.block(t);
    let loads: Vec<Mat<f64>> =
        (0..solution.n_terms()).map(|t| &vectors * block(t).subrows(0, rows)).collect();
    let scales = &full.scales;
    let state =
        |t: usize| Mat::from_fn(n_modes, n_modes, |i, j| scales[i] * scales[j] * block(t)[(rows + i, j)]);
    let states = (0..solution.n_terms()).map(state).collect();
    let mut parametric = Parametric {
        states,
        loads,
        reduced_size: rows,
        samples: points.len(),
        enrichment,
        map_error: (f64::NAN, f64::NAN),
        solution,
        map: map.clone(),
    };
    listener.stage("parameters: certify the maps");
    let points = fresh_points(space, scheme, &map, FRESH, 8)?;
    parametric.map_error = full_space_error(&full, &energy, &parametric, &points, listener)?;
    Ok(parametric)
}

/// Points at which the full space is sampled: the corners of the user's box in the first and last stage, and random ones.
fn compression_points(
    space: &ParameterSpace,
    scheme: &SchemeTable,
    map: &AxisMap,
) -> Result<Vec<Vec<f64>>, ParametricError> {
    const RANDOM: usize = 24;
    const CORNERS: usize = 24;
    let mut points = fresh_points(space, scheme, map, RANDOM, 3)?;
    let last = scheme.active().len() - 1;
    for (i, values) in space.corners().into_iter().enumerate() {
        let setting = space.setting(&values);
        let point = map.point(theta(scheme, &setting.step, if i % 2 == 0 { 0 } else { last })?, &setting)?;
        points.push(point);
    }
    points.truncate(RANDOM + CORNERS);
    Ok(points)
}

/// An M-orthonormal basis that holds `B`, the responses at all points and what they are made of.
fn compressed_basis(
    full: &Responses<'_, PencilSpace<'_>>,
    points: &[Vec<f64>],
    energy: &Energy<'_>,
    tolerance: f64,
    listener: &dyn Listener,
) -> Result<Mat<f64>, ParametricError> {
    let mut blocks = vec![full.basis.clone()];
    // A few points at a time: their blocks are as long as the mesh is large.
    for (i, chunk) in points.chunks(2 * rayon::current_num_threads()).enumerate() {
        let responses = chunk.par_iter().map(|p| full.at(p)).collect::<Result<Vec<_>, _>>()?;
        for response in responses {
            blocks.push(response.load);
            blocks.extend(response.auxiliary);
        }
        listener.checkpoint(i * chunk.len(), points.len())?;
    }
    Ok(compress(&blocks, energy, 0.02 * tolerance)?)
}

/// The same problem in the coordinates of a compressed basis.
fn compressed<'a>(
    full: &Responses<'a, PencilSpace<'_>>,
    vectors: &Mat<f64>,
) -> Result<Responses<'a, DenseSpace>, SeparatedError> {
    let project = |t: usize| {
        let product = vectors.transpose() * full.space.apply(t, vectors.as_ref());
        Mat::from_fn(product.nrows(), product.ncols(), |i, j| 0.5 * (product[(i, j)] + product[(j, i)]))
    };
    Ok(Responses {
        space: DenseSpace::new((0..full.space.n_operators()).map(project).collect())?,
        map: full.map,
        // UᵀMU = I, so coordinates of B and the image M₀B in U are one matrix.
        basis: vectors.transpose() * &full.weighted,
        weighted: vectors.transpose() * &full.weighted,
        scales: full.scales.clone(),
        lift: full.lift,
    })
}

/// Responses at grid points of the axes, loads above states: all points if there are at most `most`, else random ones.
fn grid_samples(
    small: &Responses<'_, DenseSpace>,
    rows: usize,
    most: usize,
) -> Result<SampledBlocks, SeparatedError> {
    let lengths: Vec<usize> = small.map.axes.iter().map(Axis::len).collect();
    let total = lengths.iter().fold(1usize, |n, l| n.saturating_mul(*l));
    let digits = |mut k: usize| -> Vec<usize> { lengths.iter().map(|l| (k % l, k /= l).0).collect() };
    let mut random = Random::new(1);
    let index: Vec<Vec<usize>> = if total <= most {
        (0..total).map(digits).collect()
    } else {
        (0..most).map(|_| lengths.iter().map(|l| random.below(*l)).collect()).collect()
    };
    let point =
        |i: &Vec<usize>| -> Vec<f64> { i.iter().zip(&small.map.axes).map(|(&j, a)| a.nodes()[j]).collect() };
    let responses = index.par_iter().map(|i| small.at(&point(i))).collect::<Result<Vec<_>, _>>()?;
    let r = small.basis.ncols();
    let height = rows + r;
    let values =
        Mat::from_fn(height * r, index.len(), |k, p| stacked(&responses[p], rows, k % height, k / height));
    Ok(SampledBlocks { axes: small.map.axes.clone(), index, values, n_rows: height })
}

fn stacked(response: &Response, rows: usize, i: usize, j: usize) -> f64 {
    if i < rows { response.load[(i, j)] } else { response.state[(i - rows, j)] }
}

/// The larger of the relative errors of loads and state at a point.
fn small_error(u: &Separated, rows: usize, point: &[f64], exact: &Response) -> Result<f64, SeparatedError> {
    let block = u.evaluate(point)?;
    let r = block.ncols();
    let load = (block.subrows(0, rows) - &exact.load).norm_l2() / exact.load.norm_l2();
    let state = (block.subrows(rows, r) - &exact.state).norm_l2() / exact.state.norm_l2();
    Ok(load.max(state))
}

/// (root mean square, worst).
fn spread(errors: impl Iterator<Item = Result<f64, SeparatedError>>) -> Result<(f64, f64), SeparatedError> {
    let errors = errors.collect::<Result<Vec<f64>, _>>()?;
    let squares: f64 = errors.iter().map(|e| e * e).sum();
    Ok(((squares / errors.len() as f64).sqrt(), errors.iter().copied().fold(0.0, f64::max)))
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

/// Error of loads (mass norm) and state against full-order solves, the larger of the two: (rms, worst).
fn full_space_error(
    full: &Responses<'_, PencilSpace<'_>>,
    energy: &Energy<'_>,
    parametric: &Parametric,
    points: &[Vec<f64>],
    listener: &dyn Listener,
) -> Result<(f64, f64), ParametricError> {
    let norm = |x: &Mat<f64>| {
        let weighted = energy(x.as_ref());
        (0..x.ncols()).map(|j| x.col(j).transpose() * weighted.col(j)).sum::<f64>().max(0.0).sqrt()
    };
    let error = |point: &Vec<f64>| -> Result<f64, ParametricError> {
        listener.checkpoint(0, points.len())?;
        let exact = full.at(point)?;
        let (load, state) = parametric.combine(&parametric.solution.weights(point)?);
        let state = full.scaled(state);
        let load = norm(&(&exact.load - load)) / norm(&exact.load);
        Ok(load.max((&exact.state - state).norm_l2() / exact.state.norm_l2()))
    };
    let errors = points.par_iter().map(error).collect::<Result<Vec<f64>, _>>()?;
    Ok(spread(errors.into_iter().map(Ok))?)
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

    /// `(H − B, E)` for given weights of the terms.
    fn combine(&self, weights: &[f64]) -> (Mat<f64>, Mat<f64>) {
        let sum = |terms: &[Mat<f64>]| {
            let mut sum = Mat::zeros(terms[0].nrows(), terms[0].ncols());
            weights.iter().zip(terms).for_each(|(&w, term)| sum += term * faer::Scale(w));
            sum
        };
        (sum(&self.loads), sum(&self.states))
    }

    /// The response of each stage at a setting: what the evaluator assembles when it binds.
    ///
    /// # Errors
    /// If the setting lies outside the box.
    pub fn responses(
        &self,
        scheme: &SchemeTable,
        setting: &Setting,
    ) -> Result<Vec<StageResponse>, ParametricError> {
        let response = |stage: usize| {
            let theta = theta(scheme, &setting.step, stage)?;
            let (increment, state) = self.combine(&self.solution.weights(&self.map.point(theta, setting)?)?);
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
            let mut state = Mat::zeros(self.states[0].nrows(), self.states[0].ncols());
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
        Ok(BlockTerms {
            axes: self.map.roles()?.into_iter().enumerate().map(table).collect(),
            states: self.states.clone(),
            loads: self.loads.clone(),
        })
    }
}
