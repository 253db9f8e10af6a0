//! Static shapes of the loads that a basis answers worst.
//!
//! A push beside a support moves little else than its own surroundings, and natural modes converge slowly to
//! that: its error, relative to its own motion, is the largest of all places. The static shapes of a few such
//! loads lower it for all of them, because neighbours have nearly the same shapes.

use faer::Mat;

use super::error::BasisError;
use super::ritz::Basis;
use crate::fem::Solve;
use crate::prepared::Prepared;

/// Loads that are tried: those that move the body least.
const LOADS: usize = 768;
/// Most shapes.
const MOST: usize = 128;
/// Error of a static answer, in the mass norm, that is small enough.
const SMALL: f64 = 0.01;

/// Static shapes at the parameters as built, until the answers of `basis` and of these shapes to the loads
/// that are tried are good enough, at most [`MOST`]. `basis` is in Ritz coordinates; of a free body there are
/// none.
///
/// # Errors
/// [`BasisError`]: a stiffness that has no factor.
pub(crate) fn static_shapes(
    prepared: &Prepared,
    basis: &Basis,
    nodes: &[u32],
) -> Result<Mat<f64>, BasisError> {
    let (symbolic, dofs, pencil) =
        (&prepared.symbolic, prepared.body.model.dofs(), prepared.body.model.pencil());
    let (n, r) = (basis.vectors.nrows(), basis.n_modes());
    if pencil.rigid().is_some() || symbolic.is_spread() {
        return Ok(Mat::zeros(n, 0));
    }
    let free: Vec<usize> = nodes
        .iter()
        .flat_map(|&node| (0..3).map(move |c| 3 * node as usize + c))
        .filter(|&dof| !dofs.is_held(dof))
        .collect();
    // `Λ⁻¹Bᵀe`: the answer of the basis to a unit load at each dof, in its own coordinates.
    let at = |dof: usize, k: usize| dofs.value(dof, |free| basis.vectors[(free, k)]);
    let answers = Mat::from_fn(r, free.len(), |k, j| at(free[j], k) / basis.stiffness[(k, k)]);
    let size = |j: usize| (0..r).map(|k| answers[(k, j)].powi(2)).sum::<f64>();
    let mut ranked: Vec<(f64, usize)> = (0..free.len()).map(|j| (size(j), j)).collect();
    ranked.retain(|(size, _)| *size > 0.0);
    ranked.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    ranked.truncate(LOADS);
    let loads: Vec<usize> = ranked.iter().map(|&(_, j)| free[j]).collect();
    let mut shapes = Mat::zeros(n, loads.len());
    for (j, &dof) in loads.iter().enumerate() {
        dofs.terms(dof).for_each(|(free, share)| shapes[(free as usize, j)] += share);
    }
    let factor = symbolic.factorize(pencil.stiffness().clone())?;
    Solve::new(symbolic, loads.len(), true).solve_in_place(&factor, shapes.as_mut());
    let squares = |shapes: &Mat<f64>| -> Vec<f64> {
        let mut image = Mat::zeros(n, shapes.ncols());
        pencil.mass().mul_into(shapes.as_ref(), image.as_mut());
        (0..shapes.ncols()).map(|j| shapes.col(j).transpose() * image.col(j)).collect()
    };
    let whole = squares(&shapes);
    // The residuals, which the basis leaves out.
    shapes -= &basis.vectors * Mat::from_fn(r, loads.len(), |k, j| answers[(k, ranked[j].1)]);
    let mut left = squares(&shapes);
    let mut found: Vec<Mat<f64>> = vec![];
    while found.len() < MOST {
        let error = |j: usize| left[j] / whole[j];
        let Some(worst) = (0..loads.len()).max_by(|&a, &b| error(a).total_cmp(&error(b))) else { break };
        // Of the residual `E` of a load `e`: `EᵀKE = Eᵀe`.
        let energy = dofs.value(loads[worst], |free| shapes[(free, worst)]);
        if error(worst) <= SMALL * SMALL || energy <= 0.0 {
            break;
        }
        let shape = Mat::from_fn(n, 1, |i, _| shapes[(i, worst)] / energy.sqrt());
        let mut image = Mat::zeros(n, 1);
        pencil.mass().mul_into(shape.as_ref(), image.as_mut());
        let own = shape.col(0).transpose() * image.col(0);
        let along = shapes.transpose() * &image;
        let shares = Mat::from_fn(1, loads.len(), |_, j| dofs.value(loads[j], |free| shape[(free, 0)]));
        for (j, left) in left.iter_mut().enumerate() {
            let share = shares[(0, j)];
            *left = (*left - share * (2.0 * along[(j, 0)] - share * own)).max(0.0);
        }
        shapes -= &shape * shares;
        found.push(shape);
    }
    Ok(Mat::from_fn(n, found.len(), |i, j| found[j][(i, 0)]))
}
