//! Columns made orthonormal in the mass, to each other and to columns that are so already.

use faer::linalg::matmul::matmul;
use faer::prelude::ReborrowMut;
use faer::{Accum, Mat, MatMut, MatRef, Par};

use crate::fem::SymmetricMatrix;

/// A column that loses this fraction of its length to the columns before it is rounding.
pub(super) const DEPENDENT: f64 = 1e-11;

/// Most passes over a column that keeps shrinking.
const PASSES: usize = 5;

/// A block `X = V A + W R` beside orthonormal columns `V`.
pub(super) struct Joined {
    /// `W`, orthonormal to `V` and in itself; shape (n, k') with `k'` at most the columns of the block.
    pub new: Mat<f64>,
    /// `A`, shape (columns of `V`, k).
    pub onto_old: Mat<f64>,
    /// `R`, shape (k', k).
    pub onto_new: Mat<f64>,
}

/// Splits a block into its part along `old` and an orthonormal rest. Columns that depend on those before them
/// (by a part in 1e11 of their length) add nothing to the rest.
pub(super) fn orthonormalise(mass: &SymmetricMatrix, old: MatRef<'_, f64>, mut block: Mat<f64>) -> Joined {
    let (n, k) = (block.nrows(), block.ncols());
    let mut weighted = Mat::zeros(n, k);
    mass.mul_into(block.as_ref(), weighted.as_mut());
    let length = |c: usize| dot(block.col_as_slice(c), weighted.col_as_slice(c)).max(0.0).sqrt();
    let lengths: Vec<f64> = (0..k).map(length).collect();
    let mut onto_old = Mat::zeros(old.ncols(), k);
    // Twice is enough (Parlett): what the first pass leaves by cancellation the second removes.
    for _ in 0..2 {
        take_off(mass, old, block.as_mut(), weighted.as_mut(), onto_old.as_mut());
    }
    let mut rest =
        Rest { new: Mat::zeros(n, k), weighted: Mat::zeros(n, k), onto: Mat::zeros(k, k), used: 0 };
    for c in 0..k {
        // Each column meets the old ones again: what a subtraction within the block leaves of them would grow
        // from column to column. A pass that leaves half of a column leaves nothing else in it.
        let mut settled = rest.used == 0;
        for _ in 0..PASSES {
            if settled {
                break;
            }
            let before = norm(block.col_as_slice(c));
            let (column, onto) = (block.as_mut().subcols_mut(c, 1), onto_old.as_mut().subcols_mut(c, 1));
            take_off(mass, old, column, weighted.as_mut().subcols_mut(c, 1), onto);
            rest.take_off(block.col_as_slice_mut(c), c);
            settled = norm(block.col_as_slice(c)) > 0.5 * before;
        }
        // What shrinks with every pass has no direction of its own.
        if settled {
            rest.keep(mass, block.as_ref().subcols(c, 1), c, lengths[c]);
        }
    }
    let used = rest.used;
    let new = if used == k { rest.new } else { rest.new.subcols(0, used).to_owned() };
    Joined { new, onto_old, onto_new: rest.onto.subrows(0, used).to_owned() }
}

/// Takes the components along `old` off a block and adds them to `onto`.
fn take_off(
    mass: &SymmetricMatrix,
    old: MatRef<'_, f64>,
    mut block: MatMut<'_, f64>,
    mut weighted: MatMut<'_, f64>,
    mut onto: MatMut<'_, f64>,
) {
    mass.mul_into(block.as_ref(), weighted.rb_mut());
    let mut part = Mat::zeros(old.ncols(), block.ncols());
    matmul(part.as_mut(), Accum::Replace, old.transpose(), weighted.as_ref(), 1.0, Par::Seq);
    matmul(block.rb_mut(), Accum::Add, old, part.as_ref(), -1.0, Par::Seq);
    onto += part;
}

/// The orthonormal rest as it grows, with its product by the mass.
struct Rest {
    new: Mat<f64>,
    weighted: Mat<f64>,
    onto: Mat<f64>,
    used: usize,
}

impl Rest {
    /// Takes the components along the rest off column `c` of the block.
    fn take_off(&mut self, column: &mut [f64], c: usize) {
        for i in 0..self.used {
            let part = dot(self.weighted.col_as_slice(i), column);
            column.iter_mut().zip(self.new.col_as_slice(i)).for_each(|(x, w)| *x -= part * w);
            self.onto[(i, c)] += part;
        }
    }

    /// Keeps what is left of column `c`, whose length was `length`, unless that is rounding.
    fn keep(&mut self, mass: &SymmetricMatrix, column: MatRef<'_, f64>, c: usize, length: f64) {
        let at = self.used;
        let (mut new, mut weighted) =
            (self.new.as_mut().subcols_mut(at, 1), self.weighted.as_mut().subcols_mut(at, 1));
        mass.mul_into(column, weighted.rb_mut());
        let left = (column.transpose() * weighted.as_ref())[(0, 0)].max(0.0).sqrt();
        // `<=`: nothing is kept when all is zero; what is no number is not kept either.
        if left.is_nan() || left <= DEPENDENT * length {
            return;
        }
        new.copy_from(column);
        new *= faer::Scale(1.0 / left);
        weighted *= faer::Scale(1.0 / left);
        self.onto[(at, c)] = left;
        self.used += 1;
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

fn norm(a: &[f64]) -> f64 {
    dot(a, a).sqrt()
}
