//! Loads over time, and the full-order march under them: what snapshots, certificates and `verify` share.

use std::borrow::Cow;
use std::time::Instant;

use faer::{Mat, MatMut, MatRef};
use vademecum_format::scheme::{MAX_STAGES, SchemeTable};

use super::full_order::{FullOrder, FullOrderError, StageLoads, State, Workspace};
use super::history::History;
use crate::progress::{Cancelled, Listener};

/// Instants a step looks at: its start and one per stage.
pub const INSTANTS: usize = 1 + MAX_STAGES;

/// One force field that acts for a while on one of the trajectories marched together.
#[derive(Clone, Debug)]
pub struct TimedLoad {
    /// The trajectory.
    pub column: usize,
    /// Force over the free dofs \[N\], length n.
    pub force: Vec<f64>,
    /// Its time function.
    pub when: History,
}

/// Factors on a load at the instants of step `step`: at its start, then at each stage.
pub fn factors(table: &SchemeTable, time_step: f64, step: usize, when: &History) -> [f64; INSTANTS] {
    table.instants().map(|c| when.factor((step as f64 + c) * time_step))
}

/// Amplitudes `p_i = Σ_j f_ij F_j` of a load in the stages, from its factors at the instants.
pub fn stage_amplitudes(table: &SchemeTable, factors: &[f64; INSTANTS]) -> [f64; MAX_STAGES] {
    let mut amplitudes = [0.0; MAX_STAGES];
    for (amplitude, stage) in amplitudes.iter_mut().zip(table.active()) {
        *amplitude = stage.load.iter().zip(factors).map(|(weight, factor)| weight * factor).sum();
    }
    amplitudes
}

/// The forces of one step, rebuilt only when a factor changes.
struct Forces<'a> {
    loads: &'a [TimedLoad],
    used: [bool; INSTANTS],
    current: Vec<[f64; INSTANTS]>,
    matrices: [Mat<f64>; INSTANTS],
}

impl<'a> Forces<'a> {
    fn new(table: &SchemeTable, loads: &'a [TimedLoad], n: usize, columns: usize) -> Self {
        let used = std::array::from_fn(|j| table.active().iter().any(|stage| stage.load[j] != 0.0));
        let matrices = std::array::from_fn(|j| if used[j] { Mat::zeros(n, columns) } else { Mat::new() });
        Self { loads, used, current: vec![[0.0; INSTANTS]; loads.len()], matrices }
    }

    fn update(&mut self, table: &SchemeTable, time_step: f64, step: usize) {
        let wanted: Vec<_> =
            self.loads.iter().map(|load| factors(table, time_step, step, &load.when)).collect();
        for j in 0..INSTANTS {
            let same = wanted.iter().zip(&self.current).all(|(new, old)| new[j] == old[j]);
            if !self.used[j] || same {
                continue;
            }
            let matrix = &mut self.matrices[j];
            matrix.fill(0.0);
            for (load, factor) in self.loads.iter().zip(&wanted).filter(|(_, factor)| factor[j] != 0.0) {
                let column = matrix.col_as_slice_mut(load.column);
                column.iter_mut().zip(&load.force).for_each(|(sum, force)| *sum += factor[j] * force);
            }
        }
        self.current = wanted;
    }

    fn stage_loads(&self) -> StageLoads<'_> {
        std::array::from_fn(|j| {
            let acts = self.used[j] && self.current.iter().any(|factor| factor[j] != 0.0);
            acts.then(|| self.matrices[j].as_ref())
        })
    }
}

/// Force on each trajectory at time zero, shape (n, columns): what the initial acceleration follows from.
fn initial_force(loads: &[TimedLoad], n: usize, columns: usize) -> Mat<f64> {
    let mut force = Mat::zeros(n, columns);
    for load in loads {
        let factor = load.when.factor(0.0);
        let column = force.col_as_slice_mut(load.column);
        column.iter_mut().zip(&load.force).for_each(|(sum, f)| *sum += factor * f);
    }
    force
}

/// Why a march ended early.
#[derive(Debug, thiserror::Error)]
pub enum MarchError {
    /// The full-order solver refused.
    #[error("the full-order march")]
    FullOrder(#[from] FullOrderError),
    /// On request.
    #[error("the march was stopped")]
    Cancelled(#[from] Cancelled),
}

/// Marches `columns` trajectories from rest and shows each state to `observe` with its step number; 0 is the
/// start.
///
/// Returns the seconds spent stepping, those of `observe` left out.
///
/// # Errors
/// If there is no initial acceleration, or the listener stops it.
pub fn march_full_order(
    full: &FullOrder<'_>,
    loads: &[TimedLoad],
    columns: usize,
    steps: usize,
    listener: &dyn Listener,
    mut observe: impl FnMut(usize, &State),
) -> Result<f64, MarchError> {
    march_stages(full, loads, columns, steps, listener, |step, state, _| observe(step, state))
}

/// [`march_full_order`], and `observe` sees the stages of the step behind it too ([`Workspace::increment`];
/// none at the start).
///
/// # Errors
/// As [`march_full_order`].
pub fn march_stages(
    full: &FullOrder<'_>,
    loads: &[TimedLoad],
    columns: usize,
    steps: usize,
    listener: &dyn Listener,
    mut observe: impl FnMut(usize, &State, &Workspace),
) -> Result<f64, MarchError> {
    let loads = &*of_elastic_motion(full, loads);
    let (n, table) = (full.n_dof(), full.table());
    let zero = Mat::zeros(n, columns);
    let force = initial_force(loads, n, columns);
    let mut state = full.initial_state(zero.as_ref(), zero.as_ref(), Some(force.as_ref()))?;
    let mut work = full.workspace(columns, false);
    let mut forces = Forces::new(table, loads, n, columns);
    let mut seconds = 0.0;
    observe(0, &state, &work);
    for step in 0..steps {
        let start = Instant::now();
        forces.update(table, full.dt(), step);
        full.step(&mut state, &forces.stage_loads(), &mut work);
        seconds += start.elapsed().as_secs_f64();
        observe(step + 1, &state, &work);
        listener.checkpoint(step + 1, steps)?;
    }
    Ok(seconds)
}

/// The loads; of a body without supports less what accelerates it as a whole, so that the march has no drift
/// in addition to the elastic motion.
fn of_elastic_motion<'l>(full: &FullOrder<'_>, loads: &'l [TimedLoad]) -> Cow<'l, [TimedLoad]> {
    let Some(rigid) = full.pencil.rigid() else { return Cow::Borrowed(loads) };
    let mut loads = loads.to_vec();
    for load in &mut loads {
        rigid.relieve(MatMut::from_column_major_slice_mut(&mut load.force, full.n_dof(), 1));
    }
    Cow::Owned(loads)
}

/// Error of a reduced trajectory against the full-order one, per trajectory, in the mass norm over all dofs
/// and steps.
pub struct ErrorMeter<'a> {
    mass: &'a crate::fem::SymmetricMatrix,
    basis: MatRef<'a, f64>,
    sums: Vec<ErrorSums>,
    weighted: Mat<f64>,
    residual: Mat<f64>,
}

#[derive(Clone, Copy, Default)]
struct ErrorSums {
    norm: f64,
    floor: f64,
    coordinates: f64,
}

/// Relative L2 errors of one trajectory.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct TrajectoryError {
    /// ‖u − Bζ‖ ÷ ‖u‖.
    pub error: f64,
    /// ‖u − BBᵀMu‖ ÷ ‖u‖: the projection error.
    pub floor: f64,
}

impl TrajectoryError {
    /// Error ÷ floor; a floor below the rounding of double precision counts as that.
    #[must_use]
    pub(crate) fn ratio(&self) -> f64 {
        self.error / self.floor.max(f64::EPSILON)
    }
}

impl<'a> ErrorMeter<'a> {
    /// Nothing measured yet; `basis` is M-orthonormal.
    pub fn new(mass: &'a crate::fem::SymmetricMatrix, basis: MatRef<'a, f64>, columns: usize) -> Self {
        let zero = || Mat::zeros(basis.nrows(), columns);
        let sums = vec![ErrorSums::default(); columns];
        Self { mass, basis, sums, weighted: zero(), residual: zero() }
    }

    /// Adds one instant: full-order displacement (n, c) against reduced coordinates (r, c).
    ///
    /// `u − Bζ = (u − BBᵀMu) + B(BᵀMu − ζ)` and the two are M-orthogonal, so the parts are summed apart: the
    /// floor keeps its digits however small the rest is.
    pub fn add(&mut self, displacement: MatRef<'_, f64>, coordinates: MatRef<'_, f64>) {
        self.mass.mul_into(displacement, self.weighted.as_mut());
        let projection = self.basis.transpose() * &self.weighted;
        for (j, sums) in self.sums.iter_mut().enumerate() {
            sums.norm += displacement.col(j).transpose() * self.weighted.col(j);
            sums.coordinates += (projection.col(j) - coordinates.col(j)).squared_norm_l2();
        }
        self.residual.copy_from(displacement - self.basis * projection);
        self.mass.mul_into(self.residual.as_ref(), self.weighted.as_mut());
        for (j, sums) in self.sums.iter_mut().enumerate() {
            sums.floor += self.residual.col(j).transpose() * self.weighted.col(j);
        }
    }

    /// The errors of all trajectories; NaN for one that never moved.
    pub fn errors(&self) -> Vec<TrajectoryError> {
        let relative = |part: f64, s: &ErrorSums| (part / s.norm).sqrt();
        let error = |s: &ErrorSums| TrajectoryError {
            error: relative(s.floor + s.coordinates, s),
            floor: relative(s.floor, s),
        };
        self.sums.iter().map(error).collect()
    }
}
