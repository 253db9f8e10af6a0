//! The chapter's representation: state coordinates, load magnitude and load position as axes (eqs. 5.8–5.13).
//!
//! One stage of the scheme solves `A u = Σ_j x_j b_j + p f(s)`: every reduced coordinate `x_j` (ζ, ζ̇, and ζ̈ or ζ½) is an
//! axis with hat functions, `b_j` is its column `(h_M M + h_K K) φ_j` (the chapter prints a ones vector for φ_j), `p` and
//! `s` are the load's magnitude and position, and the load's components are axes too when asked for. The unknown is a sum
//! of rank-one terms over all of them. `A = m M + k K` is one matrix, and on the parameter axes only mass matrices
//! appear, so every space solve of eq. (5.12) is with the same factor, and every space function lies in the span of the
//! `A⁻¹ b`: the engine runs in that span. Its iterates are those of the full mesh up to rounding, at no cost in `n`.
//!
//! The odd thing: the map is linear in the state, so one term per right-hand side is exact, and greedy does not find
//! them. The repairs of method.md §4 are switches of [`CanonicalOptions`] so that the effect of each can be shown.

use super::axis::{Axis, AxisKind};
use super::enrich::{EnrichmentOptions, EnrichmentReport, enrich};
use super::error::{SeparatedError, check_len};
use super::linalg::{Random, product, transposed_product};
use super::problem::{DenseSpace, Problem, Source, Space};
use super::reduce::{Energy, EnergyBasis};
use super::solution::Separated;
use faer::{Mat, MatRef};

/// Coordinates of one kind: all ζ, all ζ̇, or the third family of the stage.
#[derive(Clone, Debug)]
pub struct StateFamily {
    /// Name of the axes, to which the number of the mode is added.
    pub name: String,
    /// Unit of the unscaled coordinate.
    pub unit: String,
    /// Range of each coordinate in its unit, as the snapshots give it.
    pub ranges: Vec<(f64, f64)>,
    /// What turns the coordinate into a scaled one: 1, Δt or Δt².
    pub scale: f64,
    /// Right-hand sides per unit of the *scaled* coordinate, `(n_rows, n_modes)`: `(h_M M + h_K K) φ_j`.
    pub columns: Mat<f64>,
}

/// One stage to be separated, in the form `A u = …` multiplied by Δt², as the scheme table has it.
#[derive(Clone, Debug)]
pub struct CanonicalStage {
    /// The three families, in the order of the state.
    pub families: Vec<StateFamily>,
    /// Range of the load's magnitude, N. It should hold 0, a body without load.
    pub magnitude: (f64, f64),
    /// Ranges of the load's components, each an axis; empty when every position has its one direction.
    pub components: Vec<(f64, f64)>,
    /// Right-hand sides of a unit load, `(n_rows, n_positions · max(1, components))`, components of a position adjacent.
    pub loads: Mat<f64>,
    /// Points of a hat grid on a state axis, at least 2. (Magnitude and components have 2: the map is linear.)
    pub points: usize,
}

/// What is done about the chapter's weaknesses; with everything off it is the chapter.
#[derive(Clone, Debug, PartialEq)]
pub struct CanonicalOptions {
    /// Axes in `(ζ, Δt ζ̇, Δt² ζ̈)`. Makes the numbers comparable for rounding and `f32`; a change of units alone does not
    /// change which terms are found.
    pub scaled_coordinates: bool,
    /// State and load separated apart, each to the tolerance relative to itself.
    pub separate_blocks: bool,
    /// Start from the one-axis terms, one per right-hand side with its own functions and its own space solve, the largest
    /// `max_terms` of them, and enrich from there. Nothing is left to find when there is room for all.
    pub one_axis_start: bool,
    /// Tolerance, limits, start and updates of the engine. `max_terms` counts both blocks together.
    pub enrichment: EnrichmentOptions,
}

impl CanonicalOptions {
    /// The chapter's method.
    pub fn chapter(tolerance: f64, max_terms: usize) -> CanonicalOptions {
        let enrichment = EnrichmentOptions {
            tolerance,
            max_terms,
            update_sweeps: 0,
            patience: 30,
            ..EnrichmentOptions::default()
        };
        CanonicalOptions {
            scaled_coordinates: false,
            separate_blocks: false,
            one_axis_start: false,
            enrichment,
        }
    }

    /// All repairs.
    pub fn repaired(tolerance: f64, max_terms: usize) -> CanonicalOptions {
        let enrichment = EnrichmentOptions {
            tolerance,
            max_terms,
            ..EnrichmentOptions::default()
        };
        CanonicalOptions {
            scaled_coordinates: true,
            separate_blocks: true,
            one_axis_start: true,
            enrichment,
        }
    }
}

/// Relative errors of a stage map, in the energy norm given, over 200 fresh random points of the box: root mean square
/// of the error over root mean square of the exact map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StageError {
    /// State and load together.
    pub total: f64,
    /// Without load; NaN when the magnitude cannot be 0.
    pub state: f64,
    /// Load on a body at rest; NaN when a coordinate cannot be 0.
    pub load: f64,
}

/// A separated stage.
#[derive(Clone, Debug)]
pub struct Canonical {
    /// Over the axes: families in order, mode by mode; magnitude; components; position. Blocks are `(n_rows, 1)`.
    pub solution: Separated,
    /// Its error against the exact stage solve.
    pub error: StageError,
    /// What each enrichment did: one report, or state then load.
    pub reports: Vec<EnrichmentReport>,
}

/// Separates one stage. `space` has the one operator `A`; `energy` is the inner product errors are measured in, the mass.
///
/// # Errors
/// As [`Axis::new`] for the ranges; [`SeparatedError::NotPositiveDefinite`] for `A`; [`SeparatedError::Shape`].
pub fn separate<S: Space>(
    stage: &CanonicalStage,
    space: &S,
    energy: &Energy<'_>,
    options: &CanonicalOptions,
) -> Result<Canonical, SeparatedError> {
    check_len("operators of a canonical stage", 1, space.n_operators())?;
    let inputs = Inputs::new(stage, options.scaled_coordinates)?;
    let span = Span::new(space, &inputs.columns, energy)?;
    let fresh = Fresh::new(&inputs, &span, options.enrichment.seed);
    let parts = if options.separate_blocks {
        vec![inputs.state_part(), inputs.load_part()]
    } else {
        vec![inputs.all()]
    };
    let mut solution = Separated::zero(&inputs.axes, span.sources.nrows(), 1);
    let mut reports = Vec::new();
    for (number, part) in parts.iter().enumerate() {
        let others: usize = parts.iter().skip(number + 1).map(|p| p.sources.len()).sum();
        let left = options
            .enrichment
            .max_terms
            .saturating_sub(solution.n_terms());
        let max_terms = left
            .saturating_sub(others)
            .max(left.min(part.sources.len()));
        if max_terms == 0 || part.sources.is_empty() {
            continue;
        }
        let engine = EnrichmentOptions {
            max_terms,
            ..options.enrichment.clone()
        };
        let problem = part.problem(&inputs, &span)?;
        let points = fresh.of_part(part);
        let measure = |u: &Separated| points.error(u, &span);
        let start = if options.one_axis_start {
            Some(part.one_axis_terms(&inputs, &span, max_terms)?)
        } else {
            None
        };
        let (found, report) = enrich(&problem, &engine, start.as_ref(), Some(&measure))?;
        solution = solution.concatenate(&part.embed(&inputs, &found)?)?;
        reports.push(report);
    }
    let error = fresh.stage_error(&inputs, &span, &solution);
    Ok(Canonical {
        solution: solution.expand(span.basis.as_ref())?,
        error,
        reports,
    })
}

/// Axes, and for every right-hand side its functions on them (one where none is named).
struct Inputs {
    axes: Vec<Axis>,
    n_state: usize,
    /// `(axis, values at its points)` of each source.
    functions: Vec<Vec<(usize, Vec<f64>)>>,
    /// `(n_rows, n_sources)`.
    columns: Mat<f64>,
}

impl Inputs {
    fn new(stage: &CanonicalStage, scaled: bool) -> Result<Inputs, SeparatedError> {
        let (mut axes, mut functions, mut columns) = (Vec::new(), Vec::new(), Vec::new());
        let kind = AxisKind::Hat {
            points: stage.points,
        };
        for family in &stage.families {
            check_len(
                "ranges of a family, one per mode",
                family.columns.ncols(),
                family.ranges.len(),
            )?;
            let (scale, rest) = if scaled {
                (family.scale, 1.0)
            } else {
                (1.0, family.scale)
            };
            for (j, range) in family.ranges.iter().enumerate() {
                let name = format!("{}{}", family.name, j + 1);
                let unit = if scaled { "scaled" } else { &family.unit };
                axes.push(Axis::new(
                    &name,
                    unit,
                    scale * range.0,
                    scale * range.1,
                    kind,
                    false,
                )?);
                functions.push(vec![(
                    axes.len() - 1,
                    axes[axes.len() - 1].nodes().to_vec(),
                )]);
                columns.push((&family.columns, j, rest));
            }
        }
        let n_state = axes.len();
        let two = AxisKind::Hat { points: 2 };
        axes.push(Axis::new(
            "p",
            "N",
            stage.magnitude.0,
            stage.magnitude.1,
            two,
            false,
        )?);
        for (c, range) in stage.components.iter().enumerate() {
            axes.push(Axis::new(
                &format!("d{}", c + 1),
                "1",
                range.0,
                range.1,
                two,
                false,
            )?);
        }
        let per_position = stage.components.len().max(1);
        let positions = stage.loads.ncols() / per_position;
        check_len(
            "load columns, modulo components",
            0,
            stage.loads.ncols() % per_position,
        )?;
        axes.push(Axis::new(
            "s",
            "position",
            0.0,
            positions as f64 - 1.0,
            AxisKind::Index,
            false,
        )?);
        let last = axes.len() - 1;
        for k in 0..stage.loads.ncols() {
            let at = |j: usize| f64::from(j == k / per_position);
            let mut on = vec![
                (n_state, axes[n_state].nodes().to_vec()),
                (last, (0..positions).map(at).collect()),
            ];
            if !stage.components.is_empty() {
                let axis = n_state + 1 + k % per_position;
                on.push((axis, axes[axis].nodes().to_vec()));
            }
            functions.push(on);
            columns.push((&stage.loads, k, 1.0));
        }
        let n = stage.loads.nrows();
        columns
            .iter()
            .try_for_each(|(m, _, _)| check_len("rows of a right-hand side", n, m.nrows()))?;
        let columns = Mat::from_fn(n, columns.len(), |i, s| {
            columns[s].0[(i, columns[s].1)] * columns[s].2
        });
        Ok(Inputs {
            axes,
            n_state,
            functions,
            columns,
        })
    }

    /// Values of source `s` at the points of axis `a`.
    fn values(&self, s: usize, a: usize) -> Vec<f64> {
        match self.functions[s].iter().find(|(on, _)| *on == a) {
            Some((_, values)) => values.clone(),
            None => vec![1.0; self.axes[a].len()],
        }
    }

    fn all(&self) -> Part {
        Part {
            axes: 0..self.axes.len(),
            sources: 0..self.functions.len(),
        }
    }

    fn state_part(&self) -> Part {
        Part {
            axes: 0..self.n_state,
            sources: 0..self.n_state,
        }
    }

    fn load_part(&self) -> Part {
        Part {
            axes: self.n_state..self.axes.len(),
            sources: self.n_state..self.functions.len(),
        }
    }

    /// Value of each source's coefficient at a point of all axes; the points are on the axes by construction.
    fn weights(&self, point: &[f64]) -> Vec<f64> {
        let value =
            |(a, f): &(usize, Vec<f64>)| self.axes[*a].evaluate(f, point[*a]).unwrap_or(f64::NAN);
        self.functions
            .iter()
            .map(|on| on.iter().map(value).product())
            .collect()
    }
}

/// The span of all exact answers, orthonormal in `A`.
struct Span {
    /// `Q`, `(n_rows, k)`.
    basis: Mat<f64>,
    /// `Qᵀ b` of every source, which is also the answer's coordinates: `(k, n_sources)`.
    sources: Mat<f64>,
    /// `Qᵀ M Q`.
    energy: Mat<f64>,
}

impl Span {
    fn new<S: Space>(
        space: &S,
        columns: &Mat<f64>,
        energy: &Energy<'_>,
    ) -> Result<Span, SeparatedError> {
        let answers = space.solve(&[1.0], columns.as_ref())?;
        let a = |x: MatRef<'_, f64>| space.apply(0, x);
        let mut basis = EnergyBasis::new(columns.nrows());
        for s in 0..answers.ncols() {
            // Families share their columns up to a factor; what rounding leaves of a repeated one is no new direction.
            basis.append(answers.as_ref().subcols(s, 1), &a, 1e-12);
        }
        let basis = basis.into_vectors();
        let sources = transposed_product(basis.as_ref(), columns.as_ref());
        let energy = transposed_product(basis.as_ref(), energy(basis.as_ref()).as_ref());
        Ok(Span {
            basis,
            sources,
            energy,
        })
    }

    /// Energy norm squared of a vector of coordinates.
    fn size(&self, x: &Mat<f64>) -> f64 {
        transposed_product(
            x.as_ref(),
            product(self.energy.as_ref(), x.as_ref()).as_ref(),
        )[(0, 0)]
    }
}

/// Some axes and the sources that live on them.
struct Part {
    axes: std::ops::Range<usize>,
    sources: std::ops::Range<usize>,
}

impl Part {
    fn problem(&self, inputs: &Inputs, span: &Span) -> Result<Problem<DenseSpace>, SeparatedError> {
        let axes = inputs.axes[self.axes.clone()].to_vec();
        let grams: Vec<_> = axes.iter().map(Axis::gram).collect();
        let source = |s: usize| {
            let vectors = self
                .axes
                .clone()
                .map(|a| grams[a - self.axes.start].apply(&inputs.values(s, a)))
                .collect();
            Source {
                vectors,
                block: span.sources.as_ref().subcols(s, 1).to_owned(),
            }
        };
        let sources = self.sources.clone().map(source).collect();
        let k = span.sources.nrows();
        Problem::new(
            axes,
            vec![grams.clone()],
            DenseSpace::new(vec![Mat::identity(k, k)])?,
            sources,
        )
    }

    /// Every source's own answer, the largest `most` of them: exact when all are there.
    fn one_axis_terms(
        &self,
        inputs: &Inputs,
        span: &Span,
        most: usize,
    ) -> Result<Separated, SeparatedError> {
        let axes = inputs.axes[self.axes.clone()].to_vec();
        let values: Vec<Vec<Vec<f64>>> = self
            .axes
            .clone()
            .map(|a| self.sources.clone().map(|s| inputs.values(s, a)).collect())
            .collect();
        let factors = values
            .iter()
            .map(|v| Mat::from_fn(v[0].len(), v.len(), |j, s| v[s][j]))
            .collect();
        let blocks = span
            .sources
            .as_ref()
            .subcols(self.sources.start, self.sources.len())
            .to_owned();
        Ok(Separated::new(axes, factors, blocks, span.sources.nrows())?
            .normalised()
            .truncated(most))
    }

    /// The part's solution on all axes, constant on those it does not have.
    fn embed(&self, inputs: &Inputs, u: &Separated) -> Result<Separated, SeparatedError> {
        let factor = |a: usize| {
            if self.axes.contains(&a) {
                u.factors(a - self.axes.start).to_owned()
            } else {
                Mat::from_fn(inputs.axes[a].len(), u.n_terms(), |_, _| 1.0)
            }
        };
        let factors = (0..inputs.axes.len()).map(factor).collect();
        Separated::new(
            inputs.axes.clone(),
            factors,
            u.blocks().to_owned(),
            u.n_rows(),
        )
    }
}

/// Random points and the exact answers there, in coordinates of the span.
struct Fresh {
    points: Vec<Vec<f64>>,
    /// `(n_sources, n_points)`.
    weights: Mat<f64>,
    sources: Mat<f64>,
}

impl Fresh {
    fn new(inputs: &Inputs, span: &Span, seed: u64) -> Fresh {
        let mut random = Random::new(seed ^ 0x5eed_f00d);
        let mut point = || {
            inputs
                .axes
                .iter()
                .map(|a| a.at_fraction(random.uniform()))
                .collect()
        };
        Fresh::at((0..200).map(|_| point()).collect(), inputs, span)
    }

    fn at(points: Vec<Vec<f64>>, inputs: &Inputs, span: &Span) -> Fresh {
        let weights: Vec<Vec<f64>> = points.iter().map(|p| inputs.weights(p)).collect();
        let weights = Mat::from_fn(inputs.functions.len(), points.len(), |s, p| weights[p][s]);
        Fresh {
            points,
            weights,
            sources: span.sources.clone(),
        }
    }

    /// The same points seen by one part: its coordinates, its sources.
    fn of_part(&self, part: &Part) -> Fresh {
        let points = self
            .points
            .iter()
            .map(|p| p[part.axes.clone()].to_vec())
            .collect();
        let sources = self
            .sources
            .as_ref()
            .subcols(part.sources.start, part.sources.len())
            .to_owned();
        let weights = self
            .weights
            .as_ref()
            .subrows(part.sources.start, part.sources.len())
            .to_owned();
        Fresh {
            points,
            weights,
            sources,
        }
    }

    /// Error over size, each a root mean square in the energy norm.
    fn error(&self, u: &Separated, span: &Span) -> f64 {
        let exact = product(self.sources.as_ref(), self.weights.as_ref());
        let (mut gap, mut size) = (0.0, 0.0);
        for (p, point) in self.points.iter().enumerate() {
            let exact = exact.as_ref().subcols(p, 1).to_owned();
            let Ok(found) = u.evaluate(point) else {
                return f64::NAN;
            };
            gap += span.size(&(&exact - &found));
            size += span.size(&exact);
        }
        (gap / size).sqrt()
    }

    fn stage_error(&self, inputs: &Inputs, span: &Span, u: &Separated) -> StageError {
        let with_zero = |axes: std::ops::Range<usize>| {
            let holds_zero = axes
                .clone()
                .all(|a| inputs.axes[a].range().0 <= 0.0 && inputs.axes[a].range().1 >= 0.0);
            let mut points = self.points.clone();
            points.iter_mut().for_each(|p| p[axes.clone()].fill(0.0));
            if holds_zero {
                Fresh::at(points, inputs, span).error(u, span)
            } else {
                f64::NAN
            }
        };
        StageError {
            total: self.error(u, span),
            state: with_zero(inputs.n_state..inputs.n_state + 1),
            load: with_zero(0..inputs.n_state),
        }
    }
}

/// Ranges for the axes from coordinates seen in snapshots, `(n_coordinates, n_samples)`: the extreme values, widened by
/// `margin` of their distance on both sides, zero included so that a body at rest is on every axis.
pub fn ranges(coordinates: MatRef<'_, f64>, margin: f64) -> Vec<(f64, f64)> {
    let range = |i: usize| {
        let (mut low, mut high) = (0.0f64, 0.0f64);
        for j in 0..coordinates.ncols() {
            low = low.min(coordinates[(i, j)]);
            high = high.max(coordinates[(i, j)]);
        }
        let wide = margin * (high - low);
        (low - wide, high + wide)
    };
    (0..coordinates.nrows()).map(range).collect()
}

/// Relative size of the load in the stage map, `‖load part‖ / ‖state part‖` over the boxes; a global tolerance above it
/// drops the load.
pub fn load_share<S: Space>(
    stage: &CanonicalStage,
    space: &S,
    energy: &Energy<'_>,
) -> Result<f64, SeparatedError> {
    let inputs = Inputs::new(stage, true)?;
    let span = Span::new(space, &inputs.columns, energy)?;
    let fresh = Fresh::new(&inputs, &span, 1);
    let rms = |part: &Part| {
        let f = fresh.of_part(part);
        let exact = product(f.sources.as_ref(), f.weights.as_ref());
        let scaled = product(span.energy.as_ref(), exact.as_ref());
        (0..exact.ncols())
            .map(|p| {
                super::linalg::inner(exact.as_ref().subcols(p, 1), scaled.as_ref().subcols(p, 1))
            })
            .sum::<f64>()
    };
    Ok((rms(&inputs.load_part()) / rms(&inputs.state_part())).sqrt())
}
