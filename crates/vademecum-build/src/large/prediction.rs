//! Second-order displacement at coordinates of natural modes: where the search for a shape of least
//! energy begins.

use faer::{ColRef, Mat, MatRef};

use super::map::Pairs;
use super::prior::let_go;
use crate::dynamics::large::InitialGuess;
use crate::fem::{Factor, GreenStrain, Symbolic};

/// `u(q) = V q + Σ w_ab q_a q_b` over natural modes, with what the rest of the body does with each product.
#[doc(alias("static modal derivatives", "quadratic manifold"))]
pub(crate) struct Prediction<'a> {
    pub(super) strain: &'a GreenStrain<'a>,
    /// Shape (n, r).
    pub(super) modes: MatRef<'a, f64>,
    pairs: Pairs,
    /// `w`, shape (n, products).
    moved: Mat<f64>,
}

impl<'a> Prediction<'a> {
    /// One solve for each product of two modes.
    pub(crate) fn new(
        strain: &'a GreenStrain<'a>,
        (modes, eigenvalues): (MatRef<'a, f64>, &[f64]),
        factor: (&Symbolic, &Factor),
    ) -> Prediction<'a> {
        let pairs = Pairs { interacting: modes.ncols() };
        let moved = let_go(strain, (modes, eigenvalues), pairs, factor);
        Prediction { strain, modes, pairs, moved }
    }

    /// The displacement, and its stress to second order, `B u + E₂(V q, V q)`.
    pub(crate) fn at(&self, q: &[f64]) -> InitialGuess {
        let linear = self.modes * ColRef::from_slice(q);
        let displacement = &linear + &self.moved * ColRef::from_slice(&self.pairs.products(q));
        let of = |column: &faer::Col<f64>| column.iter().copied().collect::<Vec<f64>>();
        let (linear, displacement) = (of(&linear), of(&displacement));
        let [mut stress, mut product] = [(); 2].map(|()| vec![0.0; self.strain.n_rows()]);
        self.strain.linear(&displacement, &mut stress);
        self.strain.bilinear(&linear, &linear, &mut product);
        stress.iter_mut().zip(&product).for_each(|(x, own)| *x += own);
        InitialGuess { displacement, stress }
    }
}
