//! What the strain map is before it has seen a state.

use faer::prelude::ReborrowMut;
use faer::{Mat, MatMut, MatRef};

use super::map::{Columns, Pairs};
use crate::fem::{Factor, GreenStrain, Solve, Symbolic, contiguous, contiguous_mut};
use crate::linalg::{subtract_product, transposed_product};

/// How products of coordinates strain the body.
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
/// With [`Prior::Relaxed`] a displacement `w` is added for each product that has no mass in common with the
/// basis and the least energy: with `f = Bᵀ E₂(v_a, v_b)` and `y = K⁻¹ f`, `w = −(y − V Vᵀ M y)`, which holds
/// for natural modes. One solve for each product.
pub fn columns(
    strain: &GreenStrain<'_>,
    basis: (MatRef<'_, f64>, &[f64]),
    pairs: Pairs,
    prior: Prior,
    (symbolic, factor): (&Symbolic, &Factor),
) -> Columns {
    let (vectors, eigenvalues) = basis;
    let list: Vec<_> = pairs.iter().collect();
    let mut linear = Mat::zeros(strain.n_rows(), vectors.ncols());
    each_column(linear.as_mut(), |k, out| strain.linear(contiguous(vectors, k), out));
    let mut quadratic = Mat::zeros(strain.n_rows(), list.len());
    each_column(quadratic.as_mut(), |j, out| {
        let (a, b) = list[j];
        let of = |k: usize| contiguous(vectors, k);
        strain.bilinear(of(a), of(b), out);
        if a != b {
            out.iter_mut().for_each(|x| *x *= 2.0);
        }
    });
    if prior == Prior::Relaxed {
        let mut moved = Mat::zeros(strain.n_dof(), list.len());
        each_column(moved.as_mut(), |j, out| {
            strain.linear_transpose(quadratic.col_as_slice(j), out);
        });
        // What of the answer the basis could give itself is left to it: `y − V Λ⁻¹ Vᵀ f`.
        let mut shares = transposed_product(vectors, moved.as_ref());
        for j in 0..list.len() {
            shares.col_as_slice_mut(j).iter_mut().zip(eigenvalues).for_each(|(x, lambda)| *x /= lambda);
        }
        Solve::new(symbolic, moved.ncols(), true).solve_in_place(factor, moved.as_mut());
        subtract_product(moved.as_mut(), vectors, shares.as_ref());
        let mut own = vec![0.0; strain.n_rows()];
        for j in 0..list.len() {
            strain.linear(moved.col_as_slice(j), &mut own);
            let out = quadratic.col_as_slice_mut(j);
            out.iter_mut().zip(&own).for_each(|(x, w)| *x -= w);
        }
    }
    let frequencies = eigenvalues.iter().map(|x| x.sqrt()).collect();
    Columns { frequencies, pairs, linear, quadratic }
}

/// Fills the columns of a matrix, each by itself.
fn each_column(mut x: MatMut<'_, f64>, fill: impl Fn(usize, &mut [f64]) + Sync) {
    for k in 0..x.ncols() {
        fill(k, contiguous_mut(x.rb_mut(), k));
    }
}
