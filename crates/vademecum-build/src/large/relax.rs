//! The shape of least strain energy at given coordinates.

use faer::linalg::solvers::Solve as _;
use faer::{Mat, MatRef};

use crate::fem::{Factor, GreenStrain, Solve, Symbolic};
use crate::linalg::transposed_product;

/// Newton iterations of one shape.
const MOST_ITERATIONS: usize = 60;
/// Share of the energy that another iteration could still gain, at which a shape counts as found.
const GAIN: f64 = 1e-9;
/// Share of the gain predicted that a step must keep (Armijo).
const SUFFICIENT: f64 = 1e-4;
/// Halvings of a step.
const MOST_HALVINGS: usize = 12;

/// `argmin V(u)` under `PᵀM u = q`, from the start `u` that has these coordinates; `momenta` is `MP`, shape
/// (n, R). Newton's method in the plane of the constraints, with a line search; where the body buckles the
/// part of the stiffness that compression takes away is left out. `None` if it does not converge.
pub fn relax(
    strain: &GreenStrain<'_>,
    symbolic: &Symbolic,
    momenta: MatRef<'_, f64>,
    mut u: Vec<f64>,
) -> Option<Vec<f64>> {
    let (n, r) = (momenta.nrows(), momenta.ncols());
    let mut solve = Solve::new(symbolic, r + 1, false);
    let mut columns = Mat::zeros(n, r + 1);
    let mut force = vec![0.0; n];
    let mut energy = strain.energy(&u);
    for _ in 0..MOST_ITERATIONS {
        let factor = stiffness(strain, symbolic, &u)?;
        strain.force(&u, &mut force);
        columns.col_as_slice_mut(0).copy_from_slice(&force);
        columns.subcols_mut(1, r).copy_from(momenta);
        solve.solve_in_place(&factor, columns.as_mut());
        let shares = transposed_product(momenta, columns.as_ref());
        let schur = shares.subcols(1, r).to_owned();
        let multipliers = schur.partial_piv_lu().solve(shares.col(0));
        let step: Vec<f64> = (0..n)
            .map(|i| (0..r).map(|k| columns[(i, 1 + k)] * multipliers[k]).sum::<f64>() - columns[(i, 0)])
            .collect();
        let slope: f64 = step.iter().zip(&force).map(|(d, f)| d * f).sum();
        if !(slope.is_finite() && energy.is_finite()) {
            return None;
        }
        if -slope <= GAIN * energy {
            return Some(u);
        }
        let mut length = 1.0;
        let found = (0..MOST_HALVINGS).find_map(|_| {
            let trial: Vec<f64> = u.iter().zip(&step).map(|(u, d)| u + length * d).collect();
            let reached = strain.energy(&trial);
            let enough = reached <= energy + SUFFICIENT * length * slope;
            length *= 0.5;
            enough.then_some((trial, reached))
        });
        (u, energy) = found?;
    }
    None
}

/// The tangent, or what is left of it without compression where it is not positive definite.
fn stiffness(strain: &GreenStrain<'_>, symbolic: &Symbolic, u: &[f64]) -> Option<Factor> {
    if let Ok(factor) = symbolic.factorize(strain.tangent(u)) {
        return Some(factor);
    }
    let mut z = vec![0.0; strain.n_rows()];
    strain.strain(u, &mut z);
    symbolic.factorize(strain.weighted_tangent(u, 1.0, &z, true)).ok()
}
