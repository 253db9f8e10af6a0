//! Prior of the reduced strain, before any training state.

use faer::prelude::ReborrowMut;
use faer::{Mat, MatMut, MatRef};

use super::map::Pairs;
use super::regression::StrainColumns;
use crate::fem::{Factor, GreenStrain, Solve, Symbolic, contiguous, contiguous_mut};
use crate::linalg::{subtract_product, transposed_product};

/// Prior of the quadratic strain.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub enum Prior {
    /// As the shapes of the basis do, and nothing else moves (Galerkin): for slender bodies, whose basis
    /// holds the shapes that follow.
    Galerkin,
    /// Everything outside the basis moves as the least energy wants (static modal derivatives): for compact
    /// bodies, and natural modes.
    Relaxed,
}

/// The columns of a strain map: `B V` and, for each product, `E₂(v_a, v_b)`, which of a product of two
/// different coordinates counts twice.
///
/// With [`Prior::Relaxed`] what the rest of the body does with a product (`let_go`) strains it, too.
pub fn columns(
    strain: &GreenStrain<'_>,
    basis: (MatRef<'_, f64>, &[f64]),
    pairs: Pairs,
    prior: Prior,
    factor: (&Symbolic, &Factor),
) -> StrainColumns {
    let (vectors, eigenvalues) = basis;
    let mut linear = Mat::zeros(strain.n_rows(), vectors.ncols());
    each_column(linear.as_mut(), |k, out| strain.linear(contiguous(vectors, k), out));
    let mut quadratic = Mat::zeros(strain.n_rows(), pairs.count());
    let product = products(strain, vectors, pairs);
    each_column(quadratic.as_mut(), &product);
    if prior == Prior::Relaxed {
        let moved = let_go(strain, basis, pairs, factor);
        let mut own = vec![0.0; strain.n_rows()];
        for j in 0..pairs.count() {
            strain.linear(moved.col_as_slice(j), &mut own);
            quadratic.col_as_slice_mut(j).iter_mut().zip(&own).for_each(|(x, w)| *x += w);
        }
    }
    let frequencies = eigenvalues.iter().map(|x| x.sqrt()).collect();
    StrainColumns { frequencies, pairs, linear, quadratic }
}

/// Response of the rest of a body to each product of coordinates, shape (n, products): the displacement `w`
/// of least energy that has no mass in common with the basis. With `f = Bᵀ E₂(v_a, v_b)` and `y = K⁻¹ f` it
/// is `−(y − V Vᵀ M y)`, which for natural modes is `−(y − V Λ⁻¹ Vᵀ f)`. One solve for each product.
pub(super) fn let_go(
    strain: &GreenStrain<'_>,
    (vectors, eigenvalues): (MatRef<'_, f64>, &[f64]),
    pairs: Pairs,
    (symbolic, factor): (&Symbolic, &Factor),
) -> Mat<f64> {
    let mut moved = Mat::zeros(strain.n_dof(), pairs.count());
    let product = products(strain, vectors, pairs);
    let mut own = vec![0.0; strain.n_rows()];
    for j in 0..pairs.count() {
        product(j, &mut own);
        own.iter_mut().for_each(|x| *x = -*x);
        strain.linear_transpose(&own, moved.col_as_slice_mut(j));
    }
    // What of the answer the basis could give itself is left to it.
    let mut shares = transposed_product(vectors, moved.as_ref());
    for j in 0..pairs.count() {
        shares.col_as_slice_mut(j).iter_mut().zip(eigenvalues).for_each(|(x, lambda)| *x /= lambda);
    }
    Solve::new(symbolic, moved.ncols(), true).solve_in_place(factor, moved.as_mut());
    subtract_product(moved.as_mut(), vectors, shares.as_ref());
    moved
}

/// Writes the strain of a product of coordinates.
fn products(
    strain: &GreenStrain<'_>,
    vectors: MatRef<'_, f64>,
    pairs: Pairs,
) -> impl Fn(usize, &mut [f64]) + Sync {
    let list: Vec<_> = pairs.iter().collect();
    move |j, out: &mut [f64]| {
        let (a, b) = list[j];
        strain.bilinear(contiguous(vectors, a), contiguous(vectors, b), out);
        if a != b {
            out.iter_mut().for_each(|x| *x *= 2.0);
        }
    }
}

/// Fills the columns of a matrix, each by itself.
fn each_column(mut x: MatMut<'_, f64>, fill: impl Fn(usize, &mut [f64]) + Sync) {
    for k in 0..x.ncols() {
        fill(k, contiguous_mut(x.rb_mut(), k));
    }
}
