//! The stage responses over the whole box: sampled, compressed in space, separated, expanded, certified.

use std::cell::RefCell;

use faer::{Mat, MatRef};
use vademecum_format::scheme::{SchemeTable, theta};
use vademecum_format::{Axis as FileAxis, AxisKind as FileAxisKind, AxisRole};

use super::axis_map::AxisMap;
use super::error::ParametricError;
use super::record::SeparationRecord;
use super::responses::{
    PencilSpace, Response, Responses, compressed, compressed_basis, full_space, mode_scales,
};
use crate::basis::Basis;
use crate::fem::{Pencil, Symbolic};
use crate::parallel;
use crate::prepared::{ParameterSpace, Setting};
use crate::progress::Listener;
use crate::response::StageResponse;
use crate::response::{AxisTable, BlockTerms};
use crate::separated::{
    Axis, DenseSpace, Energy, EnrichmentOptions, EnrichmentReport, Expansion, SampledBlocks, Separated,
    StopReason, fit,
};

/// Fresh points at which errors are measured.
const FRESH: usize = 200;
/// Solves of the small problem behind the first expansion; doubled until it keeps the tolerance, up to
/// [`MAX_SAMPLES`].
const FIRST_SAMPLES: usize = 1000;
/// See [`FIRST_SAMPLES`].
const MAX_SAMPLES: usize = 16_000;

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
    #[serde(with = "crate::linalg::stored::list")]
    loads: Vec<Mat<f64>>,
    /// `E` of each term, shape (r, r).
    #[serde(with = "crate::linalg::stored::list")]
    states: Vec<Mat<f64>>,
    /// What the enrichment did.
    pub(crate) enrichment: EnrichmentReport,
    /// Vectors of the compressed space.
    pub(crate) reduced_size: usize,
    /// Parameter points at which the full space was sampled.
    pub samples: usize,
    /// Relative error of loads and state over fresh points of the box against full-order solves: (rms,
    /// worst).
    pub(crate) map_error: (f64, f64),
}

/// Separates the stage responses over the box.
///
/// Cost: some tens of factorisations and solves in the full space to compress it, a few thousand small dense
/// solves and the fit, which do not grow with the mesh, and two factorisations per fresh point to certify the
/// result.
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
    let maps = FINER.map(|finer| AxisMap::new(space, range, finer * tolerance));
    let maps = maps.into_iter().collect::<Result<Vec<_>, _>>()?;
    let map = &maps[0];
    let energy = |x: MatRef<'_, f64>| {
        let mut y = Mat::zeros(x.nrows(), x.ncols());
        pencil.mass().mul_into(x, y.as_mut());
        y
    };
    let full = Responses {
        space: full_space(pencil, symbolic, space.n_regions),
        map,
        basis: basis.vectors.clone(),
        weighted: energy(basis.vectors.as_ref()),
        scales: mode_scales(basis.stiffness.as_ref(), range),
        lift: space.has_region_parameters(),
    };

    listener.stage("parameters: compress space");
    let points = compression_points(space, scheme, map)?;
    let vectors = compressed_basis(&full, &points, &energy, tolerance, listener)?;

    listener.stage("parameters: separate");
    let mut small = compressed(&full, &vectors)?;
    let fresh = fresh_points(space, scheme, map, FRESH, 7)?;
    let exact = parallel::try_map(fresh.len(), &|at| small.at(&fresh[at]))?;
    let rows = vectors.ncols();
    let fresh = Fresh { points: fresh, exact, rows };
    let (expansion, map) = expand(&mut small, &maps, &fresh, tolerance, listener)?;
    let seen = RefCell::new(vec![]);
    let measure = |u: &Separated| -> Result<f64, ParametricError> {
        listener.checkpoint(u.n_terms(), max_terms)?;
        let found = parallel::try_map(fresh.points.len(), &|at| u.evaluate(&fresh.points[at]))?;
        let error = fresh.error(&found);
        let mut seen = seen.borrow_mut();
        seen.push((u.n_terms(), error));
        if let Some(end) = foreseen(&seen, max_terms).filter(|end| *end > 10.0 * tolerance) {
            listener.note(&format!(
                "the build is about to miss its tolerance: the separated maps have an error of {error:.1e} with {} of at \
                 most {max_terms} terms, which falls to about {end:.0e} at the end, and `tolerance.map` is {tolerance:.1e}; \
                 raise `tolerance.max_terms` or `tolerance.map`, or narrow the ranges",
                u.n_terms()
            ));
        }
        Ok(error)
    };
    let (mut goal, mut seed) = (SHARE * tolerance, CERTIFY_SEED);
    loop {
        let options = EnrichmentOptions {
            tolerance: goal,
            max_terms,
            max_sweeps: 8,
            update_sweeps: update_sweeps(map.axes.len()),
            // The error falls in stairs, each as wide as the terms that share a mode: ten terms without a
            // gain may be one stair, and to stop on it would refuse a build that a few more terms complete.
            patience: 25,
            ..Default::default()
        };
        let (solution, enrichment) = fit(&expansion, &options, Some(&measure))?;
        let own = enrichment.error;
        let mut parametric =
            Parametric::new(solution, enrichment, (&vectors, rows), &full.scales, map, points.len())?;
        listener.stage("parameters: certify the maps");
        let points = fresh_points(space, scheme, map, FRESH, seed)?;
        parametric.map_error = full_space_error(&full, &energy, &parametric, &points, listener)?;
        let (rms, worst) = parametric.map_error;
        let certified = rms.max(0.1 * worst);
        if parametric.enrichment.stop != StopReason::Tolerance || certified <= tolerance {
            return Ok(parametric);
        }
        let Some(smaller) = next_goal(own, certified, tolerance) else {
            parametric.enrichment.stop = StopReason::Stagnation;
            return Ok(parametric);
        };
        listener.note(&format!(
            "map error {rms:.2e} rms, {worst:.2e} worst with {} terms at fresh points of the full space: more terms are \
             added",
            parametric.n_terms()
        ));
        (goal, seed) = (smaller, seed + 1);
        listener.stage("parameters: separate");
    }
}

/// The share of the tolerance that the terms keep at the points they are judged by while they are added:
/// other points, and the full space, are a little worse.
const SHARE: f64 = 0.8;

/// Seed of the points that the finished terms are judged by; each attempt adds one to it.
const CERTIFY_SEED: u64 = 8;

/// The least share of the tolerance that the terms are asked to keep; where that does not bring the error of
/// the full space below the tolerance, no number of terms does.
const LEAST_SHARE: f64 = 1e-2;

/// The error that the terms must reach at their own points, if they reached `own` there and missed the
/// tolerance at fresh points of the full space; none if more terms do not help.
fn next_goal(own: f64, certified: f64, tolerance: f64) -> Option<f64> {
    let goal = SHARE * own * tolerance / certified;
    (goal >= LEAST_SHARE * tolerance).then_some(goal)
}

/// The error that a separation of at most so many terms will have at its end, told once, when the first half
/// of them is there: the second half lowers it by as many decades as the second quarter did, twice.
fn foreseen(seen: &[(usize, f64)], max_terms: usize) -> Option<f64> {
    let half = max_terms.div_ceil(2);
    let [.., before, last] = seen else { return None };
    if !(before.0 < half && last.0 >= half) {
        return None;
    }
    let quarter = seen.iter().rev().find(|(terms, _)| *terms <= last.0 / 2)?;
    let decades = (quarter.1 / last.1).log10() / (last.0 - quarter.0) as f64;
    Some(last.1 * 10_f64.powf(-decades * max_terms.saturating_sub(last.0) as f64))
}

/// Points at which the full space is sampled: the corners of the user's box in the first and last stage, and
/// random ones.
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

/// Sweeps over all factors after each enrichment. With two or three axes the sum is short and each sweep
/// costs milliseconds: the terms they save are worth it. With more, ten sweeps come within a sixth of the
/// fewest terms.
fn update_sweeps(axes: usize) -> usize {
    if axes <= 3 { 60 } else { 10 }
}

/// Tolerances of the axes' points that are tried in turn, as factors on the one asked for.
///
/// The number of points follows from where the response of one stage has its poles. A lifted state has
/// others, nearer by: with live regions even the whole grid may miss the tolerance, and no number of terms
/// can then be better than the grid. Four decades are some ten points more on an axis.
const FINER: [f64; 3] = [1.0, 1e-2, 1e-4];

/// The responses as a polynomial over the box, of as many samples as a third of the tolerance takes, and the
/// axes it stands on: the first of `maps`, unless even its whole grid is too coarse.
fn expand<'a>(
    small: &mut Responses<'a, DenseSpace>,
    maps: &'a [AxisMap],
    fresh: &Fresh,
    tolerance: f64,
    listener: &dyn Listener,
) -> Result<(Expansion, &'a AxisMap), ParametricError> {
    let mut best: Option<(f64, Expansion, &AxisMap)> = None;
    for map in maps {
        small.map = map;
        let (expansion, whole) = expand_on(small, fresh, tolerance, listener)?;
        let error = fresh.error(&expansion.at(&fresh.points)?);
        if best.as_ref().is_none_or(|(least, ..)| error < *least) {
            best = Some((error, expansion, map));
        }
        if error <= tolerance / 3.0 || !whole {
            break;
        }
    }
    best.map(|(_, expansion, map)| (expansion, map)).ok_or(ParametricError::NoExpansion)
}

/// The same on given axes, and whether it took their whole grid.
fn expand_on(
    small: &Responses<'_, DenseSpace>,
    fresh: &Fresh,
    tolerance: f64,
    listener: &dyn Listener,
) -> Result<(Expansion, bool), ParametricError> {
    let mut known = None;
    let mut most = FIRST_SAMPLES;
    loop {
        let solve = |point: &[f64]| small.at(point).map(|response| fresh.stacked(&response));
        let samples = SampledBlocks::collect(&small.map.axes, most, known.as_ref(), solve)?;
        let expansion = Expansion::new(&samples);
        listener.checkpoint(most, MAX_SAMPLES)?;
        let enough = fresh.error(&expansion.at(&fresh.points)?) <= tolerance / 3.0;
        if enough || samples.is_whole_grid() || most >= MAX_SAMPLES {
            return Ok((expansion, samples.is_whole_grid()));
        }
        (known, most) = (Some(samples), 2 * most);
    }
}

/// Exact responses of the small problem at points that no fit has seen.
struct Fresh {
    points: Vec<Vec<f64>>,
    exact: Vec<Response>,
    /// Rows of a load response; the state stands below it.
    rows: usize,
}

impl Fresh {
    /// Load above state, in one block.
    fn stacked(&self, response: &Response) -> Mat<f64> {
        let r = response.state.nrows();
        let entry = |i: usize, j: usize| match i.checked_sub(self.rows) {
            None => response.load[(i, j)],
            Some(i) => response.state[(i, j)],
        };
        Mat::from_fn(self.rows + r, r, entry)
    }

    /// Relative error of stacked blocks at the points, the larger of loads and state at each: root mean
    /// square to the tolerance and the worst point to ten times it, whichever is farther.
    fn error(&self, blocks: &[Mat<f64>]) -> f64 {
        let error = |(block, exact): (&Mat<f64>, &Response)| {
            let load = (block.subrows(0, self.rows) - &exact.load).norm_l2() / exact.load.norm_l2();
            let state = block.subrows(self.rows, exact.state.nrows()) - &exact.state;
            load.max(state.norm_l2() / exact.state.norm_l2())
        };
        let (rms, worst) = spread(&blocks.iter().zip(&self.exact).map(error).collect::<Vec<f64>>());
        rms.max(0.1 * worst)
    }
}

/// (root mean square, worst).
fn spread(errors: &[f64]) -> (f64, f64) {
    let squares: f64 = errors.iter().map(|e| e * e).sum();
    ((squares / errors.len() as f64).sqrt(), errors.iter().copied().fold(0.0, f64::max))
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
    let error = |at: usize| -> Result<f64, ParametricError> {
        let point = &points[at];
        listener.checkpoint(0, points.len())?;
        let exact = full.at(point)?;
        let (load, state) = parametric.combine(&parametric.solution.weights(point)?);
        let state = full.scaled(state);
        let load = norm(&(&exact.load - load)) / norm(&exact.load);
        Ok(load.max((&exact.state - state).norm_l2() / exact.state.norm_l2()))
    };
    let errors = parallel::try_map(points.len(), &error)?;
    Ok(spread(&errors))
}

impl Parametric {
    /// Terms of the compressed space, brought back to the full one; their error there is not known yet.
    /// `vectors` span the compressed space, of which a load response has `rows`.
    fn new(
        solution: Separated,
        enrichment: EnrichmentReport,
        (vectors, rows): (&Mat<f64>, usize),
        scales: &[f64],
        map: &AxisMap,
        samples: usize,
    ) -> Result<Self, ParametricError> {
        if solution.n_terms() == 0 {
            return Err(ParametricError::NoExpansion);
        }
        let block = |t: usize| solution.block(t);
        let load = |t: usize| vectors * block(t).subrows(0, rows);
        let state = |t: usize| {
            let entry = |i: usize, j: usize| scales[i] * scales[j] * block(t)[(rows + i, j)];
            Mat::from_fn(scales.len(), scales.len(), entry)
        };
        Ok(Self {
            loads: (0..solution.n_terms()).map(load).collect(),
            states: (0..solution.n_terms()).map(state).collect(),
            reduced_size: rows,
            samples,
            enrichment,
            map_error: (f64::NAN, f64::NAN),
            solution,
            map: map.clone(),
        })
    }

    /// Number of terms.
    pub fn n_terms(&self) -> usize {
        self.solution.n_terms()
    }

    /// Points of each axis.
    pub(crate) fn axis_points(&self) -> Vec<usize> {
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
    pub(crate) fn responses(
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

    /// What the separation did; what a certificate measures of it is still empty.
    pub(crate) fn record(&self) -> SeparationRecord {
        SeparationRecord {
            terms: self.n_terms(),
            axis_points: self.axis_points(),
            history: self.enrichment.history.clone(),
            history_terms: self.enrichment.terms.clone(),
            stop: self.enrichment.stop,
            reduced_size: self.reduced_size,
            samples: self.samples,
            parameters: vec![],
            worst_trajectory_at: vec![],
            worst_radius_at: vec![],
            radius_samples: vec![],
            repairs: vec![],
        }
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
