//! Reduced solvers that step without the evaluator: what the fused step through a file is measured against.

use faer::{Mat, MatRef};
use vademecum_build::linalg::project;
use vademecum_format::scheme::{HISTORY, SchemeTable};

use vademecum_build::dynamics::{History, INSTANTS, TimedLoad};

/// Common data of reduced solvers.
pub struct Frame {
    /// `B`, shape (n, r).
    pub basis: Mat<f64>,
    /// Δt \[s\].
    pub time_step: f64,
    /// Instants of a step at which loads are looked at, as fractions of Δt.
    pub instants: [f64; INSTANTS],
    /// Stages of its scheme that are solved one after the other.
    pub stages: usize,
}

impl Frame {
    /// Data of a scheme whose stages are taken one after the other.
    pub(super) fn staged(basis: MatRef<'_, f64>, table: &SchemeTable, time_step: f64) -> Self {
        let (instants, stages) = (table.instants(), table.active().len());
        Self { basis: basis.to_owned(), time_step, instants, stages }
    }

    /// Number of modes r.
    pub fn n_modes(&self) -> usize {
        self.basis.ncols()
    }
}

/// A reduced solver on a basis `B`, from rest. Lengths and the start are those of a scheme taken stage by
/// stage unless it says otherwise.
pub trait ReducedSolver {
    /// Common data.
    fn frame(&self) -> &Frame;
    /// Load vector of a step from a force over the free dofs, per unit of its factor at each
    /// instant; empty for an instant it does not use.
    fn responses(&self, force: &[f64]) -> [Vec<f64>; INSTANTS];
    /// One step of the state under a load vector. No allocation.
    fn step(&self, state: &mut [f64], load: &[f64], work: &mut [f64]);

    /// Length of the load vector: what the loads add to each stage, one after the other.
    fn load_len(&self) -> usize {
        self.frame().stages * self.frame().n_modes()
    }

    /// The state at rest under the reduced force `BᵀF`, length r, coordinates first: `u, Δt u̇, Δt² ü` with
    /// `ζ̈ = BᵀF`, and a block per stage.
    fn rest(&self, force: &[f64]) -> Vec<f64> {
        let (r, Frame { time_step, stages, .. }) = (force.len(), self.frame());
        let mut state = vec![0.0; (3 + stages) * r];
        state[2 * r..3 * r].iter_mut().zip(force).for_each(|(a, f)| *a = time_step * time_step * f);
        state
    }

    /// Length of the scratch a step wants: the new state.
    fn work_len(&self) -> usize {
        3 * self.frame().n_modes()
    }
}

/// A load as a solver sees it.
pub struct Load {
    responses: [Vec<f64>; INSTANTS],
    reduced: Vec<f64>,
    when: History,
}

/// Loads over the free dofs, reduced.
pub fn reduce(solver: &dyn ReducedSolver, loads: &[TimedLoad]) -> Vec<Load> {
    let reduce = |load: &TimedLoad| Load {
        responses: solver.responses(&load.force),
        reduced: project(solver.frame().basis.as_ref(), &load.force),
        when: load.when.clone(),
    };
    loads.iter().map(reduce).collect()
}

/// The load vector of step `step`.
fn load_vector(solver: &dyn ReducedSolver, loads: &[Load], step: usize) -> Vec<f64> {
    let Frame { time_step: dt, instants, .. } = solver.frame();
    sum(solver, loads, |load, j| load.when.factor((step as f64 + instants[j]) * dt))
}

/// The load vector of all loads at full height, at every instant.
pub fn held(solver: &dyn ReducedSolver, loads: &[Load]) -> Vec<f64> {
    sum(solver, loads, |_, _| 1.0)
}

fn sum(solver: &dyn ReducedSolver, loads: &[Load], factor: impl Fn(&Load, usize) -> f64) -> Vec<f64> {
    let mut vector = vec![0.0; solver.load_len()];
    for load in loads {
        for (j, response) in load.responses.iter().enumerate().filter(|(_, r)| !r.is_empty()) {
            let factor = factor(load, j);
            vector.iter_mut().zip(response).for_each(|(sum, r)| *sum += factor * r);
        }
    }
    vector
}

/// At rest under the loads at time zero.
pub fn start(solver: &dyn ReducedSolver, loads: &[Load]) -> Vec<f64> {
    let mut force = vec![0.0; solver.frame().n_modes()];
    for load in loads {
        let factor = load.when.factor(0.0);
        force.iter_mut().zip(&load.reduced).for_each(|(sum, f)| *sum += factor * f);
    }
    solver.rest(&force)
}

/// Coordinates at each instant of a march from rest, the start included; shape (r, steps + 1).
pub fn play(solver: &dyn ReducedSolver, loads: &[TimedLoad], steps: usize) -> Mat<f64> {
    let r = solver.frame().n_modes();
    let loads = reduce(solver, loads);
    let mut state = start(solver, &loads);
    let mut work = vec![0.0; solver.work_len()];
    let mut coordinates = Mat::zeros(r, steps + 1);
    for step in 0..steps {
        solver.step(&mut state, &load_vector(solver, &loads, step), &mut work);
        coordinates.col_as_slice_mut(step + 1).copy_from_slice(&state[..r]);
    }
    coordinates
}

/// `out ← B ζ` over the free dofs, length n. Bound by reading the basis once.
pub fn reconstruct_into(basis: MatRef<'_, f64>, state: &[f64], out: &mut [f64]) {
    out.fill(0.0);
    for (j, &value) in state[..basis.ncols()].iter().enumerate() {
        let column = basis.col(j).try_as_col_major().expect("columns are contiguous").as_slice();
        axpy(value, column, out);
    }
}

/// `out ← out + w x`.
pub(super) fn axpy(w: f64, x: &[f64], out: &mut [f64]) {
    out.iter_mut().zip(x).for_each(|(sum, x)| *sum += w * x);
}

/// `out ← out + matrix x`, column by column.
pub(super) fn add_product(matrix: &Mat<f64>, x: &[f64], out: &mut [f64]) {
    for (j, &value) in x.iter().enumerate() {
        axpy(value, matrix.col_as_slice(j), out);
    }
}

/// `out ← out + Σ_p w_p x_p` over the blocks of length r of a history, skipping zero weights.
pub(super) fn add_weighted(weights: &[f64], history: &[f64], out: &mut [f64]) {
    for (&weight, block) in weights.iter().zip(history.chunks_exact(out.len())) {
        if weight != 0.0 {
            axpy(weight, block, out);
        }
    }
}

const _: () = assert!(HISTORY == 2 + INSTANTS);
