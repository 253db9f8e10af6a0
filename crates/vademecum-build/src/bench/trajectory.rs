//! Full-order trajectories kept whole, and distances between trajectories.
//!
//! All distances are relative L2 over all dofs and steps in the mass norm: `√(Σ‖u − w‖²_M ÷ Σ‖w‖²_M)`.

use std::time::Instant;

use faer::{Mat, MatRef};

use crate::dynamics::FullOrder;
use crate::fem::SymmetricMatrix;
use crate::march::{ErrorMeter, MarchError, TimedLoad, TrajectoryError, march_full_order};
use crate::progress::Listener;

/// Columns compared at once: enough for the product with `M` to be bound by the columns and not by `M`.
const AT_ONCE: usize = 32;

/// A full-order march, kept.
pub struct Trajectory {
    /// Displacement \[m\] at each instant, the start included; shape (n, steps + 1).
    pub displacement: Mat<f64>,
    /// Wall time of each step \[s\], loads included.
    pub step_seconds: Vec<f64>,
}

impl Trajectory {
    /// Marches from rest, `split` steps of `full` for each of the `steps` instants kept.
    pub(super) fn march(
        full: &FullOrder<'_>,
        split: usize,
        loads: &[TimedLoad],
        steps: usize,
        listener: &dyn Listener,
    ) -> Result<Self, MarchError> {
        let mut displacement = Mat::zeros(full.n_dof(), steps + 1);
        let mut step_seconds = Vec::with_capacity(split * steps);
        // From the end of one look to the start of the next there is nothing but a step.
        let mut looked = Instant::now();
        march_full_order(full, loads, 1, split * steps, listener, |step, state| {
            if step > 0 {
                step_seconds.push(looked.elapsed().as_secs_f64());
            }
            if step % split == 0 {
                displacement.col_mut(step / split).copy_from(state.displacement.col(0));
            }
            looked = Instant::now();
        })?;
        Ok(Self { displacement, step_seconds })
    }
}

/// Distance of a trajectory from a reference, both (n, instants).
pub fn distance(mass: &SymmetricMatrix, trajectory: MatRef<'_, f64>, reference: MatRef<'_, f64>) -> f64 {
    let (mut apart, mut norm) = (0.0, 0.0);
    for start in (0..reference.ncols()).step_by(AT_ONCE) {
        let count = AT_ONCE.min(reference.ncols() - start);
        let reference = reference.subcols(start, count);
        let difference = trajectory.subcols(start, count) - reference;
        apart += squared_norm(mass, difference.as_ref());
        norm += squared_norm(mass, reference);
    }
    (apart / norm).sqrt()
}

/// `Σ_j x_jᵀ M x_j` over the columns.
fn squared_norm(mass: &SymmetricMatrix, columns: MatRef<'_, f64>) -> f64 {
    let mut weighted = Mat::zeros(columns.nrows(), columns.ncols());
    mass.mul_into(columns, weighted.as_mut());
    (0..columns.ncols()).map(|j| columns.col(j).transpose() * weighted.col(j)).sum()
}

/// Errors of reduced trajectories on one M-orthonormal basis, each of coordinates (r, instants), from a reference
/// (n, instants).
///
/// # Panics
/// If a shape differs.
pub fn reduced_errors(
    mass: &SymmetricMatrix,
    basis: MatRef<'_, f64>,
    reference: MatRef<'_, f64>,
    coordinates: &[&Mat<f64>],
) -> Vec<TrajectoryError> {
    let mut meter = ErrorMeter::new(mass, basis, coordinates.len());
    let mut same = Mat::zeros(reference.nrows(), coordinates.len());
    for instant in 0..reference.ncols() {
        (0..coordinates.len()).for_each(|j| same.col_mut(j).copy_from(reference.col(instant)));
        let reduced = Mat::from_fn(basis.ncols(), coordinates.len(), |k, j| coordinates[j][(k, instant)]);
        meter.add(same.as_ref(), reduced.as_ref());
    }
    meter.errors()
}
