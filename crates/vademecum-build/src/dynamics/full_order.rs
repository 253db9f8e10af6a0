//! The march at full order: `M ü + C u̇ + K u = F` with `C = α M + β K`, by any scheme table, many
//! trajectories at once.
//!
//! Stage `i` of a table is one solve with `m_i M + d_i Δt C + k_i Δt² K`; stages with the same weights share
//! a factor. The march runs in increments `δ_i = u_i − u`: since a table keeps rigid translations, `u` drops
//! out of every term but the elastic force, and a solve's rounding is relative to the increment of one step
//! instead of the whole displacement. The state is scaled, `(u, Δt u̇, Δt² ü)`, as the tables are.

use faer::prelude::{Reborrow, ReborrowMut};
use faer::{Mat, MatMut, MatRef};
use vademecum_format::scheme::{HISTORY, MAX_STAGES, SchemeTable};

use super::damping::Rayleigh;
use super::schemes::inconsistency;
use crate::fem::{Factor, FactorError, Pencil, Solve, Symbolic};

/// Departure from consistency, relative to the coefficients, past which a table is refused: far above the
/// rounding of the few sums that make a table, far below any misprint.
const CONSISTENCY: f64 = 1e-12;

/// Why a march cannot start.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FullOrderError {
    /// The step is not a positive number.
    #[error("the time step must be positive and finite; found {0} s")]
    TimeStep(f64),
    /// A damping coefficient is negative or not finite.
    #[error("Rayleigh damping needs alpha >= 0 and beta >= 0; found {0:?}")]
    Damping(Rayleigh),
    /// The scheme would not keep a body at rest where it is.
    #[error("the scheme table is inconsistent by {0:e} of its coefficients")]
    InconsistentScheme(f64),
    /// A stage's matrix does not factorise.
    #[error("stage matrix of the scheme")]
    Factor(#[from] FactorError),
    /// The mass matrix is not positive definite, so there is no initial acceleration.
    #[error("the mass matrix is not positive definite: no acceleration follows from the forces")]
    SingularMass,
}

/// The motion of `c` trajectories at one instant, each matrix `(n, c)`, column-major.
#[derive(Clone, Debug, PartialEq)]
pub struct State {
    /// Displacement `u`, m.
    pub displacement: Mat<f64>,
    /// Scaled velocity `Δt u̇`, m.
    pub dt_velocity: Mat<f64>,
    /// Scaled acceleration `Δt² ü`, m.
    pub dt2_acceleration: Mat<f64>,
}

impl State {
    /// A body at rest: everything zero.
    pub fn rest(n: usize, columns: usize) -> State {
        let zero = || Mat::zeros(n, columns);
        State { displacement: zero(), dt_velocity: zero(), dt2_acceleration: zero() }
    }

    /// Number of trajectories.
    pub fn columns(&self) -> usize {
        self.displacement.ncols()
    }
}

/// Forces of one step, N, `(n, c)` each: at the start of the step, then at each stage's instant; `None` is no
/// force.
pub type StageLoads<'a> = [Option<MatRef<'a, f64>>; 1 + MAX_STAGES];

/// One stage in increments, all weights in the unit of its matrix.
#[derive(Clone, Debug)]
struct IncrementStage {
    factor: usize,
    /// Weights of `Δt² F` at each instant.
    load: [f64; 1 + MAX_STAGES],
    /// Weights of `M` on `(u, Δt u̇, Δt² ü, δ_1, …)`; that of `u` is zero.
    mass: [f64; HISTORY],
    /// Weights of `K`, s², on the same.
    stiffness: [f64; HISTORY],
}

/// A body marching with one scheme, one step length and one damping.
pub struct FullOrder<'a> {
    pub(super) pencil: &'a Pencil,
    table: SchemeTable,
    dt: f64,
    pub(super) damping: Rayleigh,
    factors: Vec<Factor>,
    stages: Vec<IncrementStage>,
}

/// Memory of a march of `c` trajectories, lent to each step.
pub struct Workspace {
    solve: Solve,
    /// Increments of the stages.
    increments: [Mat<f64>; MAX_STAGES],
    mass_side: Mat<f64>,
    stiffness_side: Mat<f64>,
}

impl Workspace {
    /// `u_i − u` of stage `i` (counted from 0) of the step taken last, `(n, c)`.
    pub fn increment(&self, stage: usize) -> MatRef<'_, f64> {
        self.increments[stage].as_ref()
    }
}

impl<'a> FullOrder<'a> {
    /// Mass and stiffness that it marches.
    pub fn pencil(&self) -> &'a Pencil {
        self.pencil
    }

    /// Factorises the stages of a scheme for the time step `dt`, s; one factor per distinct pair of weights,
    /// one thread each.
    ///
    /// # Errors
    /// [`FullOrderError`]: a step or damping that makes no sense, an inconsistent table, a matrix that is not
    /// positive definite.
    pub fn new(
        pencil: &'a Pencil,
        symbolic: &Symbolic,
        table: &SchemeTable,
        dt: f64,
        damping: Rayleigh,
    ) -> Result<FullOrder<'a>, FullOrderError> {
        if !(dt > 0.0 && dt.is_finite()) {
            return Err(FullOrderError::TimeStep(dt));
        }
        if !damping.is_sound() {
            return Err(FullOrderError::Damping(damping));
        }
        let off = inconsistency(table);
        if off > CONSISTENCY {
            return Err(FullOrderError::InconsistentScheme(off));
        }
        let mut pairs: Vec<(f64, f64)> = Vec::new();
        let stages = increment_stages(table, dt, damping, &mut pairs);
        let matrices = pairs.iter().map(|&(m, k)| pencil.combine(m, k)).collect();
        // What marches needs the memory.
        symbolic.forget();
        let factors = symbolic.factorize_all(matrices)?;
        Ok(FullOrder { pencil, table: *table, dt, damping, factors, stages })
    }

    /// Number of dofs `n`.
    pub fn n_dof(&self) -> usize {
        self.pencil.n_dof()
    }

    /// Step length, s.
    pub fn dt(&self) -> f64 {
        self.dt
    }

    /// The scheme's table.
    pub fn table(&self) -> &SchemeTable {
        &self.table
    }

    /// Memory for `columns` trajectories; `refine` adds one step of iterative refinement to every solve.
    pub fn workspace(&self, columns: usize, refine: bool) -> Workspace {
        let zero = || Mat::zeros(self.n_dof(), columns);
        Workspace {
            solve: Solve::new(self.factors[0].symbolic(), columns, refine),
            increments: std::array::from_fn(|i| if i < self.stages.len() { zero() } else { Mat::new() }),
            mass_side: zero(),
            stiffness_side: zero(),
        }
    }

    /// One step of all trajectories under the given forces. No allocation.
    ///
    /// # Panics
    /// If `state`, a load and `work` differ in shape.
    pub fn step(&self, state: &mut State, loads: &StageLoads<'_>, work: &mut Workspace) {
        for index in 0..self.stages.len() {
            self.solve_stage(index, state, loads, work);
        }
        self.finish(state, work);
    }

    /// Solves for the increment of one stage.
    fn solve_stage(&self, index: usize, state: &State, loads: &StageLoads<'_>, work: &mut Workspace) {
        let stage = &self.stages[index];
        let (earlier, rest) = work.increments.split_at_mut(index);
        let rhs = &mut rest[0];
        let history = |weights: &[f64; HISTORY], out: MatMut<'_, f64>| {
            let state = [&state.displacement, &state.dt_velocity, &state.dt2_acceleration];
            let terms = state.into_iter().chain(earlier.iter()).zip(weights);
            combine_into(terms.map(|(x, &w)| (w, x.as_ref())), out);
        };
        history(&stage.mass, work.mass_side.as_mut());
        history(&stage.stiffness, work.stiffness_side.as_mut());
        let (mass, stiffness) = (self.pencil.mass(), self.pencil.stiffness());
        mass.mul_pair_into(work.mass_side.as_ref(), stiffness, work.stiffness_side.as_ref(), rhs.as_mut());
        for (load, weight) in loads.iter().zip(stage.load) {
            if let Some(force) = load.filter(|_| weight != 0.0) {
                add_into(self.dt * self.dt * weight, force, rhs.as_mut());
            }
        }
        work.solve.solve_in_place(&self.factors[stage.factor], rhs.as_mut());
    }

    /// The new state from the old one and the stage increments.
    fn finish(&self, state: &mut State, work: &Workspace) {
        let n_stages = self.stages.len();
        let rows = &self.table.finish;
        for j in 0..state.columns() {
            let u = state.displacement.col_as_slice_mut(j);
            let v = state.dt_velocity.col_as_slice_mut(j);
            let a = state.dt2_acceleration.col_as_slice_mut(j);
            let increments: [&[f64]; MAX_STAGES] =
                std::array::from_fn(
                    |s| {
                        if s < n_stages { work.increments[s].col_as_slice(j) } else { &[][..] }
                    },
                );
            for i in 0..u.len() {
                let (old_v, old_a) = (v[i], a[i]);
                // The weights of u are 1, 0, 0 once the stages are increments.
                let new = |row: &[f64; HISTORY]| {
                    let stages: f64 = (0..n_stages).map(|s| row[3 + s] * increments[s][i]).sum();
                    row[1] * old_v + row[2] * old_a + stages
                };
                u[i] += new(&rows[0]);
                v[i] = new(&rows[1]);
                a[i] = new(&rows[2]);
            }
        }
    }

    /// Energy `½ u̇ᵀ M u̇ + ½ uᵀ K u` of trajectory `j`, J.
    pub fn energy(&self, state: &State, j: usize) -> f64 {
        let (u, v) = (state.displacement.col_as_slice(j), state.dt_velocity.col_as_slice(j));
        let kinetic = self.pencil.mass().inner(v, v) / (self.dt * self.dt);
        0.5 * (kinetic + self.pencil.stiffness().inner(u, u))
    }
}

/// Folds damping into the weights of `M` and `K`, moves `u` to the right-hand side, and collects the distinct
/// pairs.
fn increment_stages(
    table: &SchemeTable,
    dt: f64,
    damping: Rayleigh,
    pairs: &mut Vec<(f64, f64)>,
) -> Vec<IncrementStage> {
    // Δt C = (α Δt) M + (β Δt) K.
    let (alpha_dt, beta_dt) = (damping.alpha * dt, damping.beta * dt);
    let stages = table.stages[..table.n_stages as usize].iter();
    stages
        .map(|stage| {
            let m = stage.mass + alpha_dt * stage.damping;
            let k = dt * dt * stage.stiffness + beta_dt * stage.damping;
            let factor = pairs.iter().position(|&pair| pair == (m, k)).unwrap_or_else(|| {
                pairs.push((m, k));
                pairs.len() - 1
            });
            let mut mass = [0.0; HISTORY];
            let mut stiffness = [0.0; HISTORY];
            for p in 0..HISTORY {
                mass[p] = stage.mass_history[p] + alpha_dt * stage.damping_history[p];
                stiffness[p] = dt * dt * stage.stiffness_history[p] + beta_dt * stage.damping_history[p];
            }
            // Exactly what consistency says: a resting, undeformed shift costs no inertia, and the elastic
            // force of u is the load's whole counterweight.
            mass[0] = 0.0;
            stiffness[0] = -dt * dt;
            IncrementStage { factor, load: stage.load, mass, stiffness }
        })
        .collect()
}

/// `out ← Σ w_i x_i`, skipping zero weights.
fn combine_into<'m>(terms: impl Iterator<Item = (f64, MatRef<'m, f64>)>, mut out: MatMut<'_, f64>) {
    out.fill(0.0);
    for (weight, x) in terms {
        if weight != 0.0 {
            add_into(weight, x, out.rb_mut());
        }
    }
}

/// `out ← out + w x`.
fn add_into(weight: f64, x: MatRef<'_, f64>, mut out: MatMut<'_, f64>) {
    faer::zip!(out.rb_mut(), x.rb()).for_each(|faer::unzip!(sum, value)| *sum += weight * *value);
}
