//! The basis of a slender body: natural modes, and the shapes that follow them.
//!
//! A beam that bends far also shortens, and its cross sections turn: no low mode does that. Those shapes are
//! the part of condensed shapes outside the modes. The best few of them, in the norm of the stiffness and for
//! states of one energy, join the modes. They share neither mass nor (with natural modes) stiffness with
//! them, so a rotation among themselves makes both matrices diagonal.

use faer::{Mat, MatRef};

use crate::fem::Pencil;
use crate::linalg::symmetric_eigen;
use crate::linalg::{NoConvergence, subtract_product, symmetric_part, transposed_product};

/// The basis `[modes, shapes]`, its mass the identity, and the diagonal of its stiffness. `momenta` is the
/// mass times the modes; states are displacements over the free dofs. Fewer shapes come back where the states
/// do not have as many.
pub(crate) fn with_followers(
    pencil: &Pencil,
    (modes, momenta, eigenvalues): (MatRef<'_, f64>, MatRef<'_, f64>, &[f64]),
    states: &[Vec<f64>],
    shapes: usize,
) -> Result<(Mat<f64>, Vec<f64>), NoConvergence> {
    /// Below this share of the largest a direction is rounding.
    const DEPENDENT: f64 = 1e-10;
    let (n, kept) = (modes.nrows(), modes.ncols());
    let mut beside = Mat::from_fn(n, states.len(), |i, s| states[s][i]);
    let coordinates = transposed_product(momenta, beside.as_ref());
    subtract_product(beside.as_mut(), modes, coordinates.as_ref());
    for s in 0..states.len() {
        let energy: f64 = (0..kept).map(|k| eigenvalues[k] * coordinates[(k, s)].powi(2)).sum();
        let scale = 1.0 / energy.max(f64::MIN_POSITIVE).sqrt();
        beside.col_as_slice_mut(s).iter_mut().for_each(|x| *x *= scale);
    }
    let image = |x: MatRef<'_, f64>, stiffness: bool| {
        let mut image = Mat::zeros(x.nrows(), x.ncols());
        let matrix = if stiffness { pencil.stiffness() } else { pencil.mass() };
        matrix.mul_into(x, image.as_mut());
        image
    };
    let gram = |x: MatRef<'_, f64>, stiffness: bool| {
        symmetric_part(transposed_product(x, image(x, stiffness).as_ref()).as_ref())
    };
    let (values, vectors) = symmetric_eigen(gram(beside.as_ref(), true).as_ref())?;
    let last = values.len();
    let largest = values.last().copied().unwrap_or(0.0);
    let rank = values.iter().filter(|&&value| value > DEPENDENT * largest).count().min(shapes);
    let chosen = Mat::from_fn(last, rank, |i, k| {
        let from = last - 1 - k;
        vectors[(i, from)] / values[from].sqrt()
    });
    let found = &beside * &chosen;
    // `VᵀKV = I` now: the eigenvalues of the mass are those of the pencil, upside down.
    let (masses, turn) = symmetric_eigen(gram(found.as_ref(), false).as_ref())?;
    let turn = Mat::from_fn(rank, rank, |i, k| turn[(i, rank - 1 - k)] / masses[rank - 1 - k].sqrt());
    let mut basis = Mat::zeros(n, kept + rank);
    basis.subcols_mut(0, kept).copy_from(modes);
    basis.subcols_mut(kept, rank).copy_from(&found * &turn);
    let own = (0..rank).map(|k| 1.0 / masses[rank - 1 - k]);
    Ok((basis, eigenvalues.iter().copied().chain(own).collect()))
}
