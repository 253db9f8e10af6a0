//! The strain map: reduced strains that are quadratic in the coordinates, and the rows a file keeps of them.
//!
//! The strain of St. Venant and Kirchhoff is quadratic in the displacement, so over a basis
//!
//! ```text
//! z(q) = A_l q + A_q m(q)        V(q) = ½ |z(q)|²
//! ```
//!
//! with `m` the products of coordinates that interact. With `VᵀMV = I` and `VᵀKV = diag(ω²)` the columns
//! `U = A_l diag(1/ω)` are orthonormal, and the energy depends on `UᵀA_q` and on the Gram matrix of what is
//! left of `A_q` alone. So a few rows hold it: one for each coordinate, exact in the linear and the cubic
//! terms, and as many more as the rest of the quartic term needs.

use faer::linalg::solvers::SolveCore;
use faer::{Conj, Mat, MatRef, Side};

use super::states::States;
use crate::dynamics::symmetric_eigen;
use crate::linalg::{NoConvergence, subtract_product, symmetric_part, transposed_product};

/// Strains that are fitted at a time.
const FITTED: usize = 4096;

/// Products of coordinates: each pair once, in the order of its first coordinate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Pairs {
    /// Coordinates whose products all count.
    pub interacting: usize,
    /// Coordinates after them whose products with those count, but not those among themselves.
    pub coupled: usize,
}

impl Pairs {
    /// The pairs `(a, b)`, `a ≤ b`: first those of coordinates that interact, then the coupled ones.
    pub fn iter(self) -> impl Iterator<Item = (usize, usize)> {
        let (n, all) = (self.interacting, self.interacting + self.coupled);
        let own = (0..n).flat_map(move |a| (a..n).map(move |b| (a, b)));
        own.chain((0..n).flat_map(move |a| (n..all).map(move |b| (a, b))))
    }

    /// How many there are.
    pub fn count(self) -> usize {
        let n = self.interacting;
        n * (n + 1) / 2 + n * self.coupled
    }

    /// The products of coordinates.
    pub fn products(self, q: &[f64]) -> Vec<f64> {
        self.iter().map(|(a, b)| q[a] * q[b]).collect()
    }
}

/// A strain map by rows: `z_k = ω_k q_k + Q_k · m(q)` for `k < R`, `Q_k · m(q)` after.
#[derive(Clone, Debug)]
pub struct StrainMap {
    /// `ω`, one for each coordinate \[rad/s\].
    pub frequencies: Vec<f64>,
    /// The products that count.
    pub pairs: Pairs,
    /// `Q`, shape (rows, products).
    pub quadratic: Mat<f64>,
}

impl StrainMap {
    /// `z(q)`, length rows.
    pub fn strain(&self, q: &[f64]) -> Vec<f64> {
        let products = self.pairs.products(q);
        let mut z: Vec<f64> = (0..self.quadratic.nrows())
            .map(|k| products.iter().enumerate().map(|(j, m)| self.quadratic[(k, j)] * m).sum())
            .collect();
        z.iter_mut().zip(self.frequencies.iter().zip(q)).for_each(|(z, (w, q))| *z += w * q);
        z
    }

    /// `½ |z(q)|²`.
    pub fn energy(&self, q: &[f64]) -> f64 {
        0.5 * self.strain(q).iter().map(|z| z * z).sum::<f64>()
    }
}

/// Full strains as columns: what a strain map is cut from.
#[derive(Clone, Debug)]
pub struct Columns {
    /// `ω`.
    pub frequencies: Vec<f64>,
    /// The products that count.
    pub pairs: Pairs,
    /// `A_l`, shape (strains, R).
    pub linear: Mat<f64>,
    /// `A_q`, shape (strains, products).
    pub quadratic: Mat<f64>,
}

impl Columns {
    /// Moves `A_q` to where the strains of states are met best: ridge regression of what is missing on the
    /// products, with a ridge of `ridge` times their mean square.
    pub fn fit(&mut self, states: &States, ridge: f64) -> Result<(), NoConvergence> {
        let (n, p) = (states.coordinates.ncols(), self.pairs.count());
        let products = self.products_of(states.coordinates.as_ref());
        // Every state counts by its relative error.
        let weight = |s: usize| 1.0 / states.energies[s].max(f64::MIN_POSITIVE);
        let weighted = Mat::from_fn(n, p, |s, j| weight(s) * products[(j, s)]);
        let mut gram = &products * &weighted;
        let trace: f64 = (0..p).map(|j| gram[(j, j)]).sum();
        for j in 0..p {
            gram[(j, j)] += ridge * trace / p as f64;
        }
        let factor =
            gram.llt(Side::Lower).map_err(|_| NoConvergence { what: "the regression of strains" })?;
        // Each strain is fitted by itself: a few thousand at a time need no second matrix of all.
        let rows = self.quadratic.nrows();
        for first in (0..rows).step_by(FITTED) {
            let count = FITTED.min(rows - first);
            let mut own = self.quadratic.as_mut().subrows_mut(first, count);
            let mut missing = states.strains.as_ref().subrows(first, count).to_owned();
            let linear = self.linear.as_ref().subrows(first, count);
            subtract_product(missing.as_mut(), linear, states.coordinates.as_ref());
            subtract_product(missing.as_mut(), own.as_ref(), products.as_ref());
            let mut step = weighted.transpose() * missing.transpose();
            SolveCore::solve_in_place_with_conj(&factor, Conj::No, step.as_mut());
            own += step.transpose();
        }
        Ok(())
    }

    /// The products of coordinates, one state a column.
    fn products_of(&self, q: MatRef<'_, f64>) -> Mat<f64> {
        let pairs: Vec<_> = self.pairs.iter().collect();
        Mat::from_fn(pairs.len(), q.ncols(), |j, s| q[(pairs[j].0, s)] * q[(pairs[j].1, s)])
    }

    /// The rows: one for each coordinate and `extra` more, those that hold most of the rest on `states`
    /// (their coordinates, one a column). What is left out only lowers the energy.
    pub fn rows(&self, states: MatRef<'_, f64>, extra: usize) -> Result<StrainMap, NoConvergence> {
        let (r, p) = (self.frequencies.len(), self.pairs.count());
        let mut top = transposed_product(self.linear.as_ref(), self.quadratic.as_ref());
        for k in 0..r {
            for j in 0..p {
                top[(k, j)] /= self.frequencies[k];
            }
        }
        let gram = transposed_product(self.quadratic.as_ref(), self.quadratic.as_ref());
        let rest = symmetric_part((gram - top.transpose() * &top).as_ref());
        let (squares, axes) = symmetric_eigen(rest.as_ref())?;
        let root = |j: usize| squares[j].max(0.0).sqrt();
        // C with CᵀC the rest, in the axes of its eigenvectors.
        let c = Mat::from_fn(p, p, |i, j| root(i) * axes[(j, i)]);
        let seen = &c * self.products_of(states);
        let spread = symmetric_part((&seen * seen.transpose()).as_ref());
        let (_, kept) = symmetric_eigen(spread.as_ref())?;
        let extra = extra.min(p);
        let mut quadratic = Mat::zeros(r + extra, p);
        quadratic.subrows_mut(0, r).copy_from(&top);
        for k in 0..extra {
            // Eigenvalues ascend.
            let row = kept.col(p - 1 - k).transpose() * &c;
            quadratic.row_mut(r + k).copy_from(&row);
        }
        Ok(StrainMap { frequencies: self.frequencies.clone(), pairs: self.pairs, quadratic })
    }
}
