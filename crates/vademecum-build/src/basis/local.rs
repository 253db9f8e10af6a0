//! Static shapes of the loads that a basis answers worst.
//!
//! A push beside a support moves little else than its own surroundings, and natural modes converge slowly to
//! that: its error, relative to its own motion, is the largest of all places. The static shapes of a few such
//! loads lower it for all of them, because neighbours have nearly the same shapes.

use faer::linalg::solvers::Solve as _;
use faer::{Mat, MatRef, Side};

use super::error::BasisError;
use crate::fem::{Pencil, Solve};
use crate::linalg::NoConvergence;
use crate::prepared::Prepared;
use crate::progress::Listener;

/// Loads that are tried at a point of the box: those that move the body least there.
const LOADS: usize = 384;
/// Error of a static answer, in the mass norm, that is small enough.
const SMALL: f64 = 0.015;

/// Static shapes at points of the box, as many as it takes there for the answers of `basis` and of these shapes
/// to the loads that are tried, at most `most` in equal shares. `basis` is M-orthonormal in the mass as built. Of a free body
/// there are none.
///
/// # Errors
/// [`BasisError`]: a stiffness that has no factor.
pub(crate) fn static_shapes(
    prepared: &Prepared,
    basis: MatRef<'_, f64>,
    nodes: &[u32],
    points: &[&Vec<f64>],
    most: usize,
    listener: &dyn Listener,
) -> Result<Mat<f64>, BasisError> {
    let nominal = prepared.body.model.pencil();
    let r = basis.ncols();
    let mut all = Mat::zeros(basis.nrows(), r + most);
    all.subcols_mut(0, r).copy_from(basis);
    let mut width = r;
    if nominal.rigid().is_none() && !prepared.symbolic.is_spread() {
        for (at, point) in points.iter().enumerate() {
            let pencil = prepared.space.setting(point).regional().pencil(nominal);
            let share = (r + most - width).div_ceil(points.len() - at);
            let columns = all.as_mut().subcols_mut(0, width + share);
            width = extend(prepared, &pencil, (columns, r, width), nodes)?;
            listener.checkpoint(at + 1, points.len()).map_err(|c| BasisError::Modes(c.into()))?;
        }
    }
    Ok(all.subcols(r, width - r).to_owned())
}

/// Adds the static shapes of one point of the box to the first `width` columns, of which `r` are the basis;
/// returns how many there are then.
fn extend(
    prepared: &Prepared,
    pencil: &Pencil,
    (mut all, r, mut width): (faer::MatMut<'_, f64>, usize, usize),
    nodes: &[u32],
) -> Result<usize, BasisError> {
    let (symbolic, dofs, n) = (&prepared.symbolic, prepared.body.model.dofs(), all.nrows());
    let known = all.as_ref().subcols(0, width);
    let mut image = Mat::zeros(n, width);
    pencil.stiffness().mul_into(known, image.as_mut());
    let reduced = known.transpose() * &image;
    let factor = reduced.llt(Side::Lower).map_err(|_| NoConvergence { what: "a reduced stiffness" })?;
    let free: Vec<usize> = nodes
        .iter()
        .flat_map(|&node| (0..3).map(move |c| 3 * node as usize + c))
        .filter(|&dof| !dofs.is_held(dof))
        .collect();
    // Answers of the known shapes to a unit load at each dof.
    let at = |dof: usize, k: usize| dofs.value(dof, |free| known[(free, k)]);
    let answers = factor.solve(Mat::from_fn(width, free.len(), |k, j| at(free[j], k)));
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
    let whole_factor = symbolic.factorize(pencil.stiffness().clone())?;
    Solve::new(symbolic, loads.len(), true).solve_in_place(&whole_factor, shapes.as_mut());
    let squares = |shapes: &Mat<f64>| -> Vec<f64> {
        let mut image = Mat::zeros(n, shapes.ncols());
        pencil.mass().mul_into(shapes.as_ref(), image.as_mut());
        (0..shapes.ncols()).map(|j| shapes.col(j).transpose() * image.col(j)).collect()
    };
    let whole = squares(&shapes);
    // The residuals, which the known shapes leave out.
    shapes -= known * Mat::from_fn(width, loads.len(), |k, j| answers[(k, ranked[j].1)]);
    let mut left = squares(&shapes);
    while width < all.ncols() {
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
        all.as_mut().col_mut(width).copy_from(shape.col(0));
        width += 1;
    }
    Ok(width)
}
