//! A scenario at full order beside the reduced coordinates another program marched: what `verify` rests on.
//!
//! The basis is what a file shows, and rounding has cost it its orthonormality: with `G = BᵀMB = LLᵀ` the
//! same field is `(BL⁻ᵀ)(Lᵀζ)`, in an orthonormal basis of the same span.

use faer::linalg::triangular_solve::solve_lower_triangular_in_place;
use faer::{Mat, MatRef, Par, Side};

use vademecum_build::dynamics::{ErrorMeter, FullOrder, State, TimedLoad, TrajectoryError, march_full_order};
use vademecum_build::fem::SymmetricMatrix;
use vademecum_build::progress::Listener;

use crate::error::{FileError, StudyError};

/// A full-order march and its distance from a reduced one.
#[derive(Clone, Debug)]
pub(crate) struct Comparison {
    /// Relative L2 errors over all dofs and steps, mass norm.
    pub(crate) error: TrajectoryError,
    /// Energy at each instant, the start included \[J\].
    pub(crate) energy: Vec<f64>,
    /// Value of each probe at each instant, shape (instants, probes), row-major.
    pub(crate) probes: Vec<f64>,
    /// Wall time of one step \[s\].
    pub(crate) seconds_per_step: f64,
}

/// A reduced motion, for comparison.
pub(crate) struct ReducedMotion<'a> {
    /// Rows of `B` over the free dofs, shape (n, r).
    pub(crate) basis: MatRef<'a, f64>,
    /// ζ at each instant, the start included; shape (r, instants).
    pub(crate) coordinates: MatRef<'a, f64>,
    /// Row over the free dofs of each probe: (dof, weight).
    pub(crate) probes: &'a [Vec<(u32, f64)>],
}

/// Marches the loads from rest and measures the reduced trajectory against it. `observe` sees every state,
/// the start first.
///
/// # Errors
/// [`StudyError::March`]: as [`march_full_order`]; [`FileError::DependentColumns`].
pub(crate) fn compare(
    full: &FullOrder<'_>,
    loads: &[TimedLoad],
    reduced: &ReducedMotion<'_>,
    listener: &dyn Listener,
    mut observe: impl FnMut(&State),
) -> Result<Comparison, StudyError> {
    let steps = reduced.coordinates.ncols() - 1;
    // A live density moves the norm, too.
    let mass = full.pencil().mass();
    let (basis, coordinates) = orthonormal(mass, reduced.basis, reduced.coordinates)?;
    let mut meter = ErrorMeter::new(mass, basis.as_ref(), 1);
    let (mut energy, mut probes) = (Vec::with_capacity(steps + 1), vec![]);
    let seconds = march_full_order(full, loads, 1, steps, listener, |step, state| {
        observe(state);
        meter.add(state.displacement.as_ref(), coordinates.as_ref().subcols(step, 1));
        energy.push(full.energy(state, 0));
        let u = state.displacement.col_as_slice(0);
        let value =
            |row: &Vec<(u32, f64)>| row.iter().map(|&(dof, weight)| weight * u[dof as usize]).sum::<f64>();
        probes.extend(reduced.probes.iter().map(value));
    })?;
    Ok(Comparison { error: meter.errors()[0], energy, probes, seconds_per_step: seconds / steps as f64 })
}

/// `BL⁻ᵀ` and `Lᵀζ`, `LLᵀ = BᵀMB`: the same fields in an M-orthonormal basis.
pub fn orthonormal(
    mass: &SymmetricMatrix,
    basis: MatRef<'_, f64>,
    coordinates: MatRef<'_, f64>,
) -> Result<(Mat<f64>, Mat<f64>), FileError> {
    let mut weighted = Mat::zeros(basis.nrows(), basis.ncols());
    mass.mul_into(basis, weighted.as_mut());
    let gram = basis.transpose() * weighted;
    let factor = gram.llt(Side::Lower).map_err(|_| FileError::DependentColumns)?;
    let mut orthonormal = basis.to_owned();
    solve_lower_triangular_in_place(factor.L(), orthonormal.as_mut().transpose_mut(), Par::Seq);
    Ok((orthonormal, factor.L().transpose() * coordinates))
}

/// Collects coordinates step by step.
pub fn coordinate_matrix(n_modes: usize, flat: &[f64]) -> Mat<f64> {
    MatRef::from_column_major_slice(flat, n_modes, flat.len() / n_modes.max(1)).to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use vademecum_build::fem::Pencil;

    #[test]
    fn an_orthonormal_basis_shows_the_same_fields_and_dependent_columns_are_refused() {
        let mass = Mat::from_fn(3, 3, |i, j| if i == j { 2.0 + i as f64 } else { 0.5 });
        let pencil = Pencil::from_matrices(mass.as_ref(), mass.as_ref()).expect("a pencil");
        let basis = Mat::from_fn(3, 2, |i, j| [[1.0, 0.2], [0.1, 1.5], [0.3, -0.4]][i][j]);
        let zeta = Mat::from_fn(2, 2, |i, j| [[1.0, -2.0], [0.5, 3.0]][i][j]);
        let (found, coordinates) =
            orthonormal(pencil.mass(), basis.as_ref(), zeta.as_ref()).expect("independent");
        let gram = found.transpose() * &mass * &found;
        assert!((gram - Mat::<f64>::identity(2, 2)).norm_max() < 1e-14);
        assert!((&found * coordinates - &basis * &zeta).norm_max() < 1e-14);
        let dependent = Mat::from_fn(3, 2, |i, _| 1.0 + i as f64);
        for bad in [dependent, Mat::zeros(3, 2), Mat::full(3, 2, f64::NAN)] {
            let refused = orthonormal(pencil.mass(), bad.as_ref(), zeta.as_ref());
            assert!(matches!(refused, Err(FileError::DependentColumns)));
        }
    }
}
