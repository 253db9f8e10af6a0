//! Columns made orthonormal in the mass, to each other and to columns that are so already.

use faer::{Mat, MatRef};
use pulp::Arch;
use rayon::prelude::*;

use crate::fem::{
    EngineError, LocalMass, MassProduct, SymmetricMatrix, contiguous, contiguous_mut, sum_matrix,
};
use crate::linalg::{column_groups, subtract_product, transposed_product};

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
pub(super) fn orthonormalise(
    rows: &mut dyn MassProduct,
    old: MatRef<'_, f64>,
    block: Mat<f64>,
) -> Result<Joined, EngineError> {
    let first = pass(rows, old, block, None)?;
    let second = pass(rows, old, first.new, Some(SETTLED))?;
    Ok(Joined {
        new: second.new,
        onto_old: first.onto_old + second.onto_old * &first.onto_new,
        onto_new: second.onto_new * first.onto_new,
    })
}

/// The same where all rows are in this process.
pub(super) fn orthonormalise_here(mass: &SymmetricMatrix, old: MatRef<'_, f64>, block: Mat<f64>) -> Joined {
    orthonormalise(&mut LocalMass(mass), old, block).expect("one process waits for no other")
}

/// One pass over a block. Columns of which less than `least` is left are dropped; absent, those of which
/// [`DEPENDENT`] of their length is. A column is taken off all columns behind it as soon as it is known, so
/// that ranks add up what they have of all of them at once.
fn pass(
    rows: &mut dyn MassProduct,
    old: MatRef<'_, f64>,
    mut block: Mat<f64>,
    least: Option<f64>,
) -> Result<Joined, EngineError> {
    let (n, k) = (block.nrows(), block.ncols());
    let mut weighted = Mat::zeros(n, k);
    rows.mul_mass(block.as_ref(), weighted.as_mut())?;
    let least: Vec<f64> = match least {
        Some(least) => vec![least; k],
        None => {
            let square = |c| dot(block.col_as_slice(c), weighted.col_as_slice(c));
            let mut squares: Vec<f64> = (0..k).map(square).collect();
            rows.sum(&mut squares)?;
            squares.iter().map(|square| DEPENDENT * square.max(0.0).sqrt()).collect()
        }
    };
    let mut onto_old = transposed_product(old, weighted.as_ref());
    if old.ncols() > 0 {
        sum_matrix(rows, &mut onto_old)?;
        subtract_product(block.as_mut(), old, onto_old.as_ref());
        rows.mul_mass(block.as_ref(), weighted.as_mut())?;
    }
    let mut onto_new = Mat::zeros(k, k);
    let mut used = 0;
    for c in 0..k {
        let mut left = [dot(block.col_as_slice(c), weighted.col_as_slice(c))];
        rows.sum(&mut left)?;
        let left = left[0].max(0.0).sqrt();
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
        let direction = weighted.col_as_slice(used);
        let along = |later| dot(direction, block.col_as_slice(later));
        let mut parts: Vec<f64> = (c + 1..k).into_par_iter().map(along).collect();
        rows.sum(&mut parts)?;
        // The product by the mass follows the column.
        for columns in [&mut block, &mut weighted] {
            let (earlier, later) = columns.as_mut().split_at_col_mut(c + 1);
            let direction = contiguous(earlier.as_ref(), used);
            column_groups(later, 1).into_par_iter().zip(&parts).for_each(|(column, part)| {
                contiguous_mut(column, 0).iter_mut().zip(direction).for_each(|(x, w)| *x -= part * w);
            });
        }
        (c + 1..k).zip(parts).for_each(|(later, part)| onto_new[(used, later)] = part);
        used += 1;
    }
    let new = if used == k { block } else { block.subcols(0, used).to_owned() };
    Ok(Joined { new, onto_old, onto_new: onto_new.subrows(0, used).to_owned() })
}

/// Sums side by side, on the longest vectors of the machine.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    const SUMS: usize = 16;
    Arch::new().dispatch(
        #[inline(always)]
        || {
            let (a, last_a) = a.as_chunks::<SUMS>();
            let (b, last_b) = b.as_chunks::<SUMS>();
            let mut sums = [0.0; SUMS];
            for (a, b) in a.iter().zip(b) {
                for s in 0..SUMS {
                    sums[s] += a[s] * b[s];
                }
            }
            let last: f64 = last_a.iter().zip(last_b).map(|(a, b)| a * b).sum();
            sums.iter().sum::<f64>() + last
        },
    )
}
