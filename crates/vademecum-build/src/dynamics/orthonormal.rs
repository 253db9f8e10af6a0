//! Columns made orthonormal in the mass, to each other and to columns that are so already.

use faer::{Mat, MatRef};

use crate::fem::{SymmetricMatrix, contiguous, contiguous_mut};
use crate::linalg::{subtract_product, transposed_product};

/// A column that loses this fraction of its length to the columns before it is rounding.
pub(super) const DEPENDENT: f64 = 1e-11;

/// A column of length one that loses more to columns it is orthogonal to has no direction of its own.
const SETTLED: f64 = 0.5;

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
///
/// Two passes, each against `old` and within the block. Twice is enough (Parlett; by blocks Barlow and
/// Smoktunowicz 2013): the first leaves at most rounding divided by 1e-11 of its columns, which are then of
/// length one, and the second removes that.
pub(super) fn orthonormalise(mass: &SymmetricMatrix, old: MatRef<'_, f64>, block: Mat<f64>) -> Joined {
    let first = pass(mass, old, block, None);
    let second = pass(mass, old, first.new, Some(SETTLED));
    Joined {
        new: second.new,
        onto_old: first.onto_old + second.onto_old * &first.onto_new,
        onto_new: second.onto_new * first.onto_new,
    }
}

/// One pass over a block. Columns of which less than `least` is left are dropped; absent, those of which
/// [`DEPENDENT`] of their length is.
fn pass(mass: &SymmetricMatrix, old: MatRef<'_, f64>, mut block: Mat<f64>, least: Option<f64>) -> Joined {
    let (n, k) = (block.nrows(), block.ncols());
    let mut weighted = Mat::zeros(n, k);
    mass.mul_into(block.as_ref(), weighted.as_mut());
    let length = |c: usize| dot(block.col_as_slice(c), weighted.col_as_slice(c)).max(0.0).sqrt();
    let least: Vec<f64> = (0..k).map(|c| least.unwrap_or_else(|| DEPENDENT * length(c))).collect();
    let onto_old = transposed_product(old, weighted.as_ref());
    if old.ncols() > 0 {
        subtract_product(block.as_mut(), old, onto_old.as_ref());
        mass.mul_into(block.as_ref(), weighted.as_mut());
    }
    let mut onto_new = Mat::zeros(k, k);
    let mut used = 0;
    for c in 0..k {
        for i in 0..used {
            let part = dot(weighted.col_as_slice(i), block.col_as_slice(c));
            onto_new[(i, c)] = part;
            // The product by the mass follows the column.
            for columns in [&mut block, &mut weighted] {
                let (earlier, mut from) = columns.as_mut().split_at_col_mut(c);
                let column = contiguous_mut(from.as_mut(), 0);
                let direction = contiguous(earlier.as_ref(), i);
                column.iter_mut().zip(direction).for_each(|(x, w)| *x -= part * w);
            }
        }
        let left = dot(block.col_as_slice(c), weighted.col_as_slice(c)).max(0.0).sqrt();
        // `<=`: nothing is kept when all is zero; what is no number is not kept either.
        if left.is_nan() || left <= least[c] {
            continue;
        }
        onto_new[(used, c)] = left;
        for columns in [&mut block, &mut weighted] {
            for row in 0..n {
                columns[(row, used)] = columns[(row, c)] / left;
            }
        }
        used += 1;
    }
    let new = if used == k { block } else { block.subcols(0, used).to_owned() };
    Joined { new, onto_old, onto_new: onto_new.subrows(0, used).to_owned() }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}
