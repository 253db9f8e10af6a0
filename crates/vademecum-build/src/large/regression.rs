//! Strains of products moved to where the strains of states are met best: ridge regressions, each begun where
//! the one before ended.
//!
//! States `s` with coordinates `q_s`, products `P = [m(q_s)]`, strains `S = [z_s]` and weights `W`, one over
//! the energy, so that each counts by its relative error. A regression with the ridge `ρ` moves `A` by
//! `(S − A_l Q − A P) W Pᵀ (P W Pᵀ + ρ)⁻¹`. With `P W Pᵀ = E diag(g) Eᵀ` a sequence of them ends at
//!
//! ```text
//! A = A_q + (S − A_l Q − A_q P) W Pᵀ E diag(c) Eᵀ        c ← (ρ c + 1)/(g + ρ), from c = 0
//! ```
//!
//! so all of them need what is missing once, along the axes `E`, and of it only Gram matrices: a strain map
//! is cut from those. The axes are scaled by `1/√(g + ρ)` with the least ridge, so that directions which few
//! states tell apart do not lose their digits.

use faer::linalg::matmul::matmul;
use faer::prelude::{Reborrow, ReborrowMut};
use faer::{Accum, Mat, MatMut, MatRef, Par};

use super::map::{Pairs, StrainGram};
use super::states::TrainingStates;
use crate::linalg::symmetric_eigen;
use crate::linalg::{NoConvergence, column_groups, product, symmetric_part, transposed_product};
use crate::parallel;

/// Strains that are worked on at a time.
const TOGETHER: usize = 4096;
/// Columns that one thread works on at a time.
const WIDTH: usize = 128;

/// Full strains as columns.
#[derive(Clone, Debug)]
pub struct StrainColumns {
    /// `ω`.
    pub frequencies: Vec<f64>,
    /// The products that count.
    pub(crate) pairs: Pairs,
    /// `A_l`, shape (strains, R).
    pub linear: Mat<f64>,
    /// `A_q`, shape (strains, products).
    pub quadratic: Mat<f64>,
}

impl StrainColumns {
    /// Data that determine the energy, before any regression.
    pub(crate) fn gram(&self) -> StrainGram {
        let top = transposed_product(self.linear.as_ref(), self.quadratic.as_ref());
        let mut gram = Mat::zeros(self.pairs.count(), self.pairs.count());
        for (own, _) in self.chunks() {
            add_gram(gram.as_mut(), own);
        }
        self.of(top, mirrored(gram))
    }

    /// The same after each of a sequence of regressions on states, with ridges that are given in mean squares
    /// of the products.
    ///
    /// # Errors
    /// [`NoConvergence`].
    pub(crate) fn fitted(
        &self,
        states: &TrainingStates,
        ridges: &[f64],
    ) -> Result<Vec<StrainGram>, NoConvergence> {
        let (p, q) = (self.pairs.count(), states.coordinates.as_ref());
        let products = self.pairs.products_of(q);
        let weight = |s: usize| 1.0 / states.energies[s].max(f64::MIN_POSITIVE);
        let weighted = Mat::from_fn(q.ncols(), p, |s, j| weight(s) * products[(j, s)]);
        let (squares, axes) =
            symmetric_eigen(symmetric_part(product(products.as_ref(), weighted.as_ref()).as_ref()).as_ref())?;
        let mean = squares.iter().sum::<f64>() / p as f64;
        let least = mean * ridges.iter().copied().fold(f64::INFINITY, f64::min);
        let sizes: Vec<f64> = squares.iter().map(|g| (g.max(0.0) + least).sqrt()).collect();
        // W Pᵀ E, scaled: what is missing times this is what every regression needs.
        let mut axial = product(weighted.as_ref(), axes.as_ref());
        for j in 0..p {
            axial.col_mut(j).iter_mut().for_each(|x| *x /= sizes[j]);
        }
        let axial_linear = product(q, axial.as_ref());
        let axial_products = product(products.as_ref(), axial.as_ref());

        let [mut gram, mut cross, mut square] = [(); 3].map(|()| Mat::zeros(p, p));
        let mut top = Mat::zeros(self.linear.ncols(), p);
        let mut memory = Mat::zeros(TOGETHER.min(self.quadratic.nrows()), p);
        for (first, (own, linear)) in self.chunks().enumerate() {
            let strains = states.strains.as_ref().subrows(first * TOGETHER, own.nrows());
            let mut missing = memory.as_mut().subrows_mut(0, own.nrows());
            each_group(missing.rb_mut(), |at, mut x| {
                let width = x.ncols();
                let parts = [(strains, &axial), (linear, &axial_linear), (own, &axial_products)];
                for (k, (left, right)) in parts.into_iter().enumerate() {
                    let right = right.as_ref().subcols(at, width);
                    let (accum, sign) = if k == 0 { (Accum::Replace, 1.0) } else { (Accum::Add, -1.0) };
                    matmul(x.rb_mut(), accum, left, right, sign, Par::Seq);
                }
            });
            let missing = missing.rb();
            add_gram(gram.as_mut(), own);
            add_gram(square.as_mut(), missing);
            add_transposed_product(cross.as_mut(), own, missing);
            add_transposed_product(top.as_mut(), linear, missing);
        }
        let (gram, square) = (mirrored(gram), mirrored(square));
        let own_top = transposed_product(self.linear.as_ref(), self.quadratic.as_ref());

        let mut gone = vec![0.0; p];
        let of_ridge = |ridge: &f64| {
            let ridge = ridge * mean;
            gone.iter_mut().zip(&squares).for_each(|(c, g)| *c = (ridge * *c + 1.0) / (g.max(0.0) + ridge));
            let step = Mat::from_fn(p, p, |i, j| gone[i] * sizes[i] * axes[(j, i)]);
            let mixed = product(cross.as_ref(), step.as_ref());
            let moved = product(step.transpose(), product(square.as_ref(), step.as_ref()).as_ref());
            let top = &own_top + product(top.as_ref(), step.as_ref());
            self.of(top, symmetric_part((&gram + mixed.transpose() + &mixed + moved).as_ref()))
        };
        Ok(ridges.iter().map(of_ridge).collect())
    }

    /// From `A_lᵀA_q` and the Gram matrix.
    fn of(&self, mut top: Mat<f64>, gram: Mat<f64>) -> StrainGram {
        for column in top.col_iter_mut() {
            column.iter_mut().zip(&self.frequencies).for_each(|(x, w)| *x /= w);
        }
        StrainGram { frequencies: self.frequencies.clone(), pairs: self.pairs, top, gram }
    }

    /// Some rows at a time of `A_q` and of `A_l`.
    fn chunks(&self) -> impl Iterator<Item = (MatRef<'_, f64>, MatRef<'_, f64>)> {
        let rows = self.quadratic.nrows();
        (0..rows).step_by(TOGETHER).map(move |first| {
            let count = TOGETHER.min(rows - first);
            (self.quadratic.as_ref().subrows(first, count), self.linear.as_ref().subrows(first, count))
        })
    }
}

/// Some columns at a time, with the first of them; threads share them.
fn each_group(x: MatMut<'_, f64>, task: impl Fn(usize, MatMut<'_, f64>) + Sync) {
    parallel::for_each_of(column_groups(x, WIDTH), &|k, group| task(k * WIDTH, group));
}

/// `C ← C + AᵀB`.
fn add_transposed_product(c: MatMut<'_, f64>, a: MatRef<'_, f64>, b: MatRef<'_, f64>) {
    each_group(c, |at, c| {
        let b = b.subcols(at, c.ncols());
        matmul(c, Accum::Add, a.transpose(), b, 1.0, Par::Seq);
    });
}

/// `G ← G + AᵀA` on and below the diagonal.
fn add_gram(g: MatMut<'_, f64>, a: MatRef<'_, f64>) {
    each_group(g, |at, g| {
        let (left, right) = (a.subcols(at, a.ncols() - at), a.subcols(at, g.ncols()));
        let below = g.nrows() - at;
        matmul(g.subrows_mut(at, below), Accum::Add, left.transpose(), right, 1.0, Par::Seq);
    });
}

/// A symmetric matrix of which only the part below the diagonal counts.
fn mirrored(g: Mat<f64>) -> Mat<f64> {
    Mat::from_fn(g.nrows(), g.ncols(), |i, j| g[(i.max(j), i.min(j))])
}
