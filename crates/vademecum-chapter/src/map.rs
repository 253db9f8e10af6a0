//! The chapter's representation of a whole body: every stage of the scheme as a separated function of the
//! state's coordinates, the load's magnitude and its position (eqs. 5.8–5.13), projected on the basis.
//!
//! Stage `i` solves `(m̃M + k̃K) u_i = Σ_j (a_j M + b_j K) B x_j + Δt² p F(s)`, the `x_j` being what the
//! scheme's table takes of the history `(ζ, Δt ζ̇, Δt² ζ̈, ζ_1, …)`: three families for both stages of
//! Bathe's scheme, as in (5.5) and (5.6). The engine of [`separation`](crate::separation) finds
//! `u_i = Σ_t Π_a g_ta(x_a) F_t` at full order; kept are `ΠF_t`. Axes range over what the full-order runs of
//! the snapshots visit (`ranges`).
//!
//! Note: it is here to be compared with. The map is linear in all of this, so the answer is known
//! (one term per right-hand side), and greedy enrichment does not find it (docs/measurements/chapter.md).

use faer::linalg::solvers::Solve as _;
use faer::{Mat, MatRef};
use vademecum_format::scheme::{HISTORY, SchemeTable, StageCoefficients};
use vademecum_format::{ChapterAxis, ChapterRole};

use crate::error::ChapterError;
use crate::ranges::history_ranges;
use crate::separation::{ChapterOptions, ChapterStage, SeparatedPart, StageError, StateFamily, separate};
use vademecum_build::basis::{Basis, SnapshotSchedule, spread_nodes};
use vademecum_build::dynamics::FullOrder;
use vademecum_build::fem::{Factor, Pencil, Solve, Symbolic};
use vademecum_build::input::{ChapterEntry, Projection, Repair};
use vademecum_build::prepared::Prepared;
use vademecum_build::progress::Listener;
use vademecum_build::separated::{Axis, AxisKind, EnrichmentOptions, SeparatedError, Space, StopReason};

/// Names and units of the families of a history.
const FAMILIES: [(&str, &str); HISTORY] = [
    ("zeta_", "m kg^½"),
    ("zeta_dot_", "m kg^½/s"),
    ("zeta_ddot_", "m kg^½/s²"),
    ("zeta_stage1_", "m kg^½"),
    ("zeta_stage2_", "m kg^½"),
    ("zeta_stage3_", "m kg^½"),
];

/// Terms in a row that may fail to lower the error: greedy enrichment stalls for long and goes on.
const PATIENCE: usize = 30;

/// Terms over some of the axes of a stage.
#[derive(Clone, Debug)]
pub struct MapPart {
    /// The axes.
    pub axes: Vec<ChapterAxis>,
    /// Factors of each axis, `(n_points, n_terms)`.
    pub factors: Vec<Mat<f64>>,
    /// `ΠF_t`, `(r, n_terms)`.
    pub terms: Mat<f64>,
}

/// The map of one stage.
#[derive(Clone, Debug)]
pub struct StageMap {
    /// One part, or state and load apart.
    pub parts: Vec<MapPart>,
    /// Relative error of the full-order field over random points of the box.
    pub error: StageError,
    /// Why each enrichment ended.
    pub stops: Vec<StopReason>,
}

impl StageMap {
    /// Terms of all parts.
    pub fn n_terms(&self) -> usize {
        self.parts.iter().map(|part| part.terms.ncols()).sum()
    }
}

/// All stages of a scheme.
#[derive(Clone, Debug)]
pub struct ChapterMap {
    /// The scheme.
    pub table: SchemeTable,
    /// Number of modes r.
    pub n_modes: usize,
    /// The stages.
    pub stages: Vec<StageMap>,
    /// Mesh nodes the load can stand at.
    pub positions: Vec<u32>,
    /// Direction of the load; `None` when its components are axes.
    pub direction: Option<[f64; 3]>,
    /// Range of the load's magnitude \[N\].
    pub load: [f64; 2],
}

/// The domain that the stages are separated over: the source of the ranges, and the places where loads can
/// stand.
pub struct ChapterSetting {
    entry: ChapterEntry,
    /// `P` with `ζ = Pᵀu`, `(n, r)`.
    projector: Mat<f64>,
    /// Range of each entry of the history, scaled, as the table is: `[family][mode]`.
    ranges: Vec<Vec<(f64, f64)>>,
    positions: Vec<u32>,
    time_step: f64,
}

impl ChapterSetting {
    /// Marches the plan of the snapshots once more, for the ranges of everything a stage takes.
    ///
    /// # Errors
    /// [`ChapterError`]: a march that is stopped.
    pub fn new(
        entry: &ChapterEntry,
        prepared: &Prepared,
        basis: &Basis,
        full: &FullOrder<'_>,
        runs: &SnapshotSchedule,
        listener: &dyn Listener,
    ) -> Result<Self, ChapterError> {
        let body = &prepared.body;
        let projector = projector(entry.projection, body.model.pencil(), basis.vectors.as_ref())?;
        let ranges = history_ranges(body, full, runs, projector.as_ref(), entry, listener)?;
        let positions = spread_nodes(body, entry.positions.unwrap_or(usize::MAX));
        let time_step = prepared.step.time_step;
        Ok(Self { entry: entry.clone(), projector, ranges, positions, time_step })
    }

    /// Load positions, mesh nodes.
    pub fn positions(&self) -> &[u32] {
        &self.positions
    }

    /// The same with loads at these mesh nodes.
    pub fn at(self, positions: Vec<u32>) -> Self {
        Self { positions, ..self }
    }

    /// The same with other options of the separation (`repairs`, `tolerance`, `max_terms`, `points`).
    pub fn with(&self, entry: ChapterEntry) -> Self {
        let (projector, ranges) = (self.projector.clone(), self.ranges.clone());
        Self { entry, projector, ranges, positions: self.positions.clone(), time_step: self.time_step }
    }

    /// Separates all stages.
    ///
    /// # Errors
    /// [`ChapterError`]: a stage that does not factorise, a separation that fails.
    pub fn separate(&self, prepared: &Prepared, basis: &Basis) -> Result<ChapterMap, ChapterError> {
        let n_stages = prepared.scheme.active().len();
        let stage = |i| self.separate_stage(prepared, basis, i);
        Ok(ChapterMap {
            table: prepared.scheme,
            n_modes: basis.n_modes(),
            stages: (0..n_stages).map(stage).collect::<Result<_, ChapterError>>()?,
            positions: self.positions.clone(),
            direction: self.entry.unit_direction(),
            load: self.entry.load,
        })
    }

    fn separate_stage(
        &self,
        prepared: &Prepared,
        basis: &Basis,
        index: usize,
    ) -> Result<StageMap, ChapterError> {
        let pencil = prepared.body.model.pencil();
        let coefficients = StageCoefficients::new(&prepared.scheme, &prepared.step, index)?;
        let matrix = pencil.combine(coefficients.mass, coefficients.stiffness);
        let space = StageSpace { symbolic: &prepared.symbolic, factor: prepared.symbolic.factorize(matrix)? };
        let (stage, families) = self.stage(prepared, basis, index);
        let mass = |x: MatRef<'_, f64>| {
            let mut y = Mat::zeros(x.nrows(), x.ncols());
            pencil.mass().mul_into(x, y.as_mut());
            y
        };
        let options = self.options(stage.loads.ncols() + families.len() * basis.n_modes());
        let found = separate(&stage, &space, &mass, &options)?;
        let projected = self.projector.transpose() * &found.span;
        let part = |part: &SeparatedPart| {
            let axes = found.axes[part.axes.clone()].iter().zip(part.axes.clone());
            let terms = &projected * part.solution.blocks();
            let factors = (0..part.axes.len()).map(|a| part.solution.factors(a).to_owned()).collect();
            let axes = axes.map(|(axis, place)| self.map_axis(axis, place, &families, basis.n_modes()));
            MapPart { axes: axes.collect(), factors, terms }.with_a_term()
        };
        Ok(StageMap {
            parts: found.parts.iter().map(part).collect(),
            error: found.error,
            stops: found.reports.iter().map(|report| report.stop).collect(),
        })
    }

    /// The stage as the engine takes it, and which entries of the history its families are.
    fn stage(&self, prepared: &Prepared, basis: &Basis, index: usize) -> (ChapterStage, Vec<usize>) {
        let (pencil, step) = (prepared.body.model.pencil(), &prepared.step);
        let (row, dt) = (&prepared.scheme.active()[index], step.time_step);
        let mut families = vec![];
        let mut used = vec![];
        for (j, (name, unit)) in FAMILIES.iter().enumerate() {
            let m = row.mass_history[j] + dt * step.alpha * row.damping_history[j];
            let k = dt * dt * row.stiffness_history[j] + dt * step.beta * row.damping_history[j];
            if m == 0.0 && k == 0.0 {
                continue;
            }
            let mut columns = Mat::zeros(basis.vectors.nrows(), basis.n_modes());
            let (inertia, elastic) = (&basis.vectors * faer::Scale(m), &basis.vectors * faer::Scale(k));
            pencil.mass().mul_pair_into(
                inertia.as_ref(),
                pencil.stiffness(),
                elastic.as_ref(),
                columns.as_mut(),
            );
            let scale = family_scale(j, dt);
            let ranges = self.ranges[j].iter().map(|(low, high)| (low / scale, high / scale)).collect();
            let (name, unit) = (name.to_string(), unit.to_string());
            families.push(StateFamily { name, unit, ranges, scale, columns });
            used.push(j);
        }
        let components = if self.entry.components { vec![(-1.0, 1.0); 3] } else { vec![] };
        let stage = ChapterStage {
            families,
            magnitude: (self.entry.load[0], self.entry.load[1]),
            components,
            loads: self.loads(prepared),
            points: self.entry.points,
        };
        (stage, used)
    }

    /// `Δt² F` of a unit load at each position (and of each component there).
    fn loads(&self, prepared: &Prepared) -> Mat<f64> {
        let (body, dt) = (&prepared.body, prepared.step.time_step);
        let unit = |c: usize| std::array::from_fn(|k| f64::from(u8::from(k == c)));
        let directions = match self.entry.unit_direction() {
            Some(direction) => vec![direction],
            None => (0..3).map(unit).collect(),
        };
        let mut loads = Mat::zeros(body.n_dof(), self.positions.len() * directions.len());
        for (k, column) in loads.col_iter_mut().enumerate() {
            let mut force = vec![0.0; body.n_dof()];
            let node = self.positions[k / directions.len()];
            let direction = directions[k % directions.len()].map(|d| dt * dt * d);
            body.model.add_point_force(&[node], &[1.0], direction, &mut force);
            column.iter_mut().zip(force).for_each(|(out, f)| *out = f);
        }
        loads
    }

    fn options(&self, n_sources: usize) -> ChapterOptions {
        let has = |repair: Repair| self.entry.repairs.contains(&repair);
        ChapterOptions {
            scaled_coordinates: has(Repair::ScaledCoordinates),
            separate_blocks: has(Repair::SeparateBlocks),
            one_axis_start: has(Repair::OneAxisStart),
            enrichment: EnrichmentOptions {
                tolerance: self.entry.tolerance,
                max_terms: self.entry.max_terms.unwrap_or(n_sources),
                update_sweeps: if has(Repair::Updates) { 3 } else { 0 },
                patience: PATIENCE,
                ..EnrichmentOptions::default()
            },
        }
    }

    /// An axis of the engine as the file has it.
    fn map_axis(&self, axis: &Axis, place: usize, families: &[usize], r: usize) -> ChapterAxis {
        let ((lower, upper), points) = (axis.range(), axis.len());
        let n_state = families.len() * r;
        let role = match place.checked_sub(n_state) {
            None => ChapterRole::State { family: families[place / r], mode: place % r },
            Some(0) => ChapterRole::Magnitude,
            Some(_) if axis.kind() == AxisKind::Index => ChapterRole::Position,
            Some(c) => ChapterRole::Component { component: c - 1 },
        };
        let scaled = self.entry.repairs.contains(&Repair::ScaledCoordinates);
        let factor = match role {
            ChapterRole::State { family, .. } if !scaled => 1.0 / family_scale(family, self.time_step),
            _ => 1.0,
        };
        ChapterAxis { role, lower, upper, points, factor }
    }
}

impl MapPart {
    /// A part that found nothing has one term that is zero: the file wants one.
    fn with_a_term(self) -> Self {
        if self.terms.ncols() > 0 {
            return self;
        }
        let factors = self.axes.iter().map(|axis| Mat::zeros(axis.points, 1)).collect();
        Self { factors, terms: Mat::zeros(self.terms.nrows(), 1), ..self }
    }
}

/// Factor from a physical entry of the history to the table's scaled one.
fn family_scale(family: usize, time_step: f64) -> f64 {
    match family {
        1 => time_step,
        2 => time_step * time_step,
        _ => 1.0,
    }
}

/// `P` with `ζ = Pᵀu`: `MB`, or `B(BᵀB)⁻¹`.
fn projector(
    projection: Projection,
    pencil: &Pencil,
    basis: MatRef<'_, f64>,
) -> Result<Mat<f64>, ChapterError> {
    match projection {
        Projection::Mass => {
            let mut image = Mat::zeros(basis.nrows(), basis.ncols());
            pencil.mass().mul_into(basis, image.as_mut());
            Ok(image)
        }
        Projection::Euclidean => {
            let gram = basis.transpose() * basis;
            let factor = gram.llt(faer::Side::Lower).map_err(|_| ChapterError::DependentBasis)?;
            Ok(factor.solve(basis.transpose()).transpose().to_owned())
        }
    }
}

/// A stage's matrix as the engine's space: one operator, factorised once.
struct StageSpace<'a> {
    symbolic: &'a Symbolic,
    factor: Factor,
}

impl Space for StageSpace<'_> {
    fn n_rows(&self) -> usize {
        self.factor.matrix().n()
    }

    fn n_operators(&self) -> usize {
        1
    }

    fn apply(&self, _: usize, block: MatRef<'_, f64>) -> Mat<f64> {
        let mut image = Mat::zeros(block.nrows(), block.ncols());
        self.factor.matrix().mul_into(block, image.as_mut());
        image
    }

    fn solve(&self, weights: &[f64], rhs: MatRef<'_, f64>) -> Result<Mat<f64>, SeparatedError> {
        let mut x = rhs * faer::Scale(1.0 / weights[0]);
        Solve::new(self.symbolic, x.ncols(), true).solve_in_place(&self.factor, x.as_mut());
        Ok(x)
    }
}
