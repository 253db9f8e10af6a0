//! A scenario at full order beside the reduced coordinates another program marched: what `verify` rests on.

use faer::{Mat, MatRef};

use crate::body::Body;
use crate::dynamics::FullOrder;
use crate::march::{ErrorMeter, MarchError, TimedLoad, TrajectoryError, march_full_order};
use crate::progress::Listener;

/// A full-order march and its distance from a reduced one.
#[derive(Clone, Debug)]
pub struct Comparison {
    /// Relative L2 errors over all dofs and steps, mass norm.
    pub error: TrajectoryError,
    /// Energy at each instant, the start included \[J\].
    pub energy: Vec<f64>,
    /// Value of each probe at each instant, shape (instants, probes), row-major.
    pub probes: Vec<f64>,
    /// Wall time of one step \[s\].
    pub seconds_per_step: f64,
}

/// What is compared.
pub struct Reduced<'a> {
    /// Rows of `B` over the free dofs, shape (n, r).
    pub basis: MatRef<'a, f64>,
    /// ζ at each instant, the start included; shape (r, instants).
    pub coordinates: MatRef<'a, f64>,
    /// Row over the free dofs of each probe: (dof, weight).
    pub probes: &'a [Vec<(u32, f64)>],
}

/// Marches the loads from rest and measures the reduced trajectory against it.
///
/// # Errors
/// As [`march_full_order`].
pub fn compare(
    body: &Body,
    full: &FullOrder<'_>,
    loads: &[TimedLoad],
    reduced: &Reduced<'_>,
    listener: &dyn Listener,
) -> Result<Comparison, MarchError> {
    let steps = reduced.coordinates.ncols() - 1;
    let mut meter = ErrorMeter::new(body.model.pencil().mass(), reduced.basis, 1);
    let (mut energy, mut probes) = (Vec::with_capacity(steps + 1), vec![]);
    let seconds = march_full_order(full, loads, 1, steps, listener, |step, state| {
        meter.add(state.displacement.as_ref(), reduced.coordinates.subcols(step, 1));
        energy.push(full.energy(state, 0));
        let u = state.displacement.col_as_slice(0);
        let value =
            |row: &Vec<(u32, f64)>| row.iter().map(|&(dof, weight)| weight * u[dof as usize]).sum::<f64>();
        probes.extend(reduced.probes.iter().map(value));
    })?;
    Ok(Comparison { error: meter.errors()[0], energy, probes, seconds_per_step: seconds / steps as f64 })
}

/// Collects coordinates step by step.
pub fn coordinate_matrix(n_modes: usize, flat: &[f64]) -> Mat<f64> {
    MatRef::from_column_major_slice(flat, n_modes, flat.len() / n_modes.max(1)).to_owned()
}
