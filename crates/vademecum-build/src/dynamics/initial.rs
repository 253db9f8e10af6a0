//! The start of a march: the acceleration that the forces of that instant demand.

use faer::{Mat, MatRef};

use super::full_order::{FullOrder, FullOrderError, State};
use crate::fem::{Pencil, contiguous_mut};
use crate::linalg::column_groups;
use crate::parallel;

impl FullOrder<'_> {
    /// A state with `Δt² ü = Δt² M⁻¹ (F − K u − C u̇)`, the acceleration the forces of that instant demand
    /// (never assumed zero). `displacement` in m, `velocity` in m/s, `force` in N, each `(n, c)`.
    ///
    /// `M` is solved by conjugate gradients scaled by its diagonal: its condition is then a small number
    /// whatever the mesh (Wathen 1987), so some tens of products replace a factor. Nothing is solved for a
    /// body at rest without force.
    ///
    /// # Errors
    /// [`FullOrderError::SingularMass`].
    pub fn initial_state(
        &self,
        displacement: MatRef<'_, f64>,
        velocity: MatRef<'_, f64>,
        force: Option<MatRef<'_, f64>>,
    ) -> Result<State, FullOrderError> {
        let (n, columns) = (self.n_dof(), displacement.ncols());
        let pencil = self.pencil;
        // α M v + K (u + β v) is the whole of the inner forces.
        let damped =
            Mat::from_fn(n, columns, |i, j| displacement[(i, j)] + self.damping.beta * velocity[(i, j)]);
        let drag = Mat::from_fn(n, columns, |i, j| self.damping.alpha * velocity[(i, j)]);
        let mut rhs = Mat::zeros(n, columns);
        pencil.mass().mul_pair_into(drag.as_ref(), pencil.stiffness(), damped.as_ref(), rhs.as_mut());
        for j in 0..columns {
            for i in 0..n {
                rhs[(i, j)] = force.map_or(0.0, |f| f[(i, j)]) - rhs[(i, j)];
            }
        }
        let mut acceleration = Mat::zeros(n, columns);
        let solved = parallel::map_of(column_groups(acceleration.as_mut(), 1), &|j, x| {
            solve_mass(pencil, rhs.col_as_slice(j), contiguous_mut(x, 0))
        });
        if solved.contains(&None) {
            return Err(FullOrderError::SingularMass);
        }
        Ok(State {
            displacement: displacement.to_owned(),
            dt_velocity: Mat::from_fn(n, columns, |i, j| self.dt() * velocity[(i, j)]),
            dt2_acceleration: Mat::from_fn(n, columns, |i, j| self.dt() * self.dt() * acceleration[(i, j)]),
        })
    }
}

/// `x ← M⁻¹ b` by conjugate gradients scaled with the diagonal; `None` if `M` is not positive definite.
pub(super) fn solve_mass(pencil: &Pencil, b: &[f64], x: &mut [f64]) -> Option<()> {
    let n = b.len();
    let mass = pencil.mass();
    let diagonal: Vec<f64> = (0..n).map(|i| mass.diagonal(i)).collect();
    if !diagonal.iter().all(|&d| d > 0.0) {
        return None;
    }
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
    let scaled = |r: &[f64]| -> Vec<f64> { r.iter().zip(&diagonal).map(|(r, d)| r / d).collect() };
    x.fill(0.0);
    let mut residual = b.to_vec();
    let mut preconditioned = scaled(&residual);
    let mut direction = preconditioned.clone();
    let mut product = Mat::zeros(n, 1);
    let mut size = dot(&residual, &preconditioned);
    // The residual cannot be known better than its rounding, a few units in the last place of b.
    let target = size * (4.0 * f64::EPSILON).powi(2);
    // In exact arithmetic n iterations end it; a well-scaled mass needs some tens of them.
    for _ in 0..2 * n + 100 {
        if size <= target {
            return Some(());
        }
        mass.mul_into(MatRef::from_column_major_slice(&direction, n, 1), product.as_mut());
        let product = product.col_as_slice(0);
        let curvature = dot(&direction, product);
        if curvature.is_nan() || curvature <= 0.0 {
            return None;
        }
        let length = size / curvature;
        for i in 0..n {
            x[i] += length * direction[i];
            residual[i] -= length * product[i];
        }
        preconditioned = scaled(&residual);
        let next = dot(&residual, &preconditioned);
        for i in 0..n {
            direction[i] = preconditioned[i] + next / size * direction[i];
        }
        size = next;
    }
    None
}
