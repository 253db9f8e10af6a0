//! Columns made orthonormal in the mass, to each other and to columns that are so already.

use std::ops::Range;

use faer::linalg::triangular_solve::solve_unit_lower_triangular_in_place;
use faer::prelude::ReborrowMut;
use faer::{Mat, MatRef, Par};

use crate::fem::{EngineError, LocalMass, MassProduct, SymmetricMatrix, sum_matrix};
use crate::linalg::{dot, subtract_product, transposed_product};

/// A column that loses this fraction of its length to the columns before it is rounding.
pub(super) const DEPENDENT: f64 = 1e-11;

/// A column of length one that loses more to columns it is orthogonal to has no direction of its own.
const SETTLED: f64 = 0.5;

/// Columns that are finished before those behind them follow: all of these then change in one pass over
/// memory.
const PANEL: usize = 6;

/// A block `X = V A + W R`, split by orthonormal columns `V`.
pub(super) struct BlockSplit {
    /// `W`, orthonormal to `V` and in itself; shape (n, k') with `k'` at most the columns of the block.
    pub(crate) new: Mat<f64>,
    /// `A`, shape (columns of `V`, k).
    pub(crate) onto_old: Mat<f64>,
    /// `R`, shape (k', k).
    pub(crate) onto_new: Mat<f64>,
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
) -> Result<BlockSplit, EngineError> {
    let first = pass(rows, old, block, None)?;
    let second = pass(rows, old, first.new, Some(SETTLED))?;
    Ok(BlockSplit {
        new: second.new,
        onto_old: first.onto_old + second.onto_old * &first.onto_new,
        onto_new: second.onto_new * first.onto_new,
    })
}

/// The same where all rows are in this process.
pub(super) fn orthonormalise_here(
    mass: &SymmetricMatrix,
    old: MatRef<'_, f64>,
    block: Mat<f64>,
) -> BlockSplit {
    orthonormalise(&mut LocalMass(mass), old, block).expect("one process waits for no other")
}

/// One pass over a block. Columns of which less than `least` is left are dropped; absent, those of which
/// [`DEPENDENT`] of their length is. A column is taken off those of its panel as soon as it is known, and the
/// panel off all behind it, so that ranks add up what they have of all of them at once.
fn pass(
    rows: &mut dyn MassProduct,
    old: MatRef<'_, f64>,
    mut block: Mat<f64>,
    least: Option<f64>,
) -> Result<BlockSplit, EngineError> {
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
    for panel in (0..k).step_by(PANEL) {
        let (before, end) = (used, k.min(panel + PANEL));
        for c in panel..end {
            let mut left = [dot(block.col_as_slice(c), weighted.col_as_slice(c))];
            rows.sum(&mut left)?;
            let left = left[0].max(0.0).sqrt();
            // `<=`: nothing is kept when all is zero; what is no number is not kept either.
            if left.is_nan() || left <= least[c] {
                continue;
            }
            onto_new[(used, c)] = left;
            for columns in [&mut block, &mut weighted] {
                if used < c {
                    let (mut before, from) = columns.as_mut().split_at_col_mut(c);
                    before.rb_mut().col_mut(used).copy_from(from.col(0));
                }
                columns.col_as_slice_mut(used).iter_mut().for_each(|entry| *entry /= left);
            }
            used += 1;
            take_off(rows, [&mut block, &mut weighted], used - 1..used, c + 1..end, &mut onto_new)?;
        }
        take_off(rows, [&mut block, &mut weighted], before..used, end..k, &mut onto_new)?;
    }
    let new = if used == k { block } else { block.subcols(0, used).to_owned() };
    Ok(BlockSplit { new, onto_old, onto_new: onto_new.subrows(0, used).to_owned() })
}

/// Takes the finished columns `own` of a block off its columns `later`, and writes down how much of each that
/// was. Their products by the mass follow them.
fn take_off(
    rows: &mut dyn MassProduct,
    [block, weighted]: [&mut Mat<f64>; 2],
    own: Range<usize>,
    later: Range<usize>,
    onto_new: &mut Mat<f64>,
) -> Result<(), EngineError> {
    if own.is_empty() || later.is_empty() {
        return Ok(());
    }
    let directions = weighted.as_ref().subcols(own.start, own.len());
    let mut parts = transposed_product(directions, block.as_ref().subcols(later.start, later.len()));
    sum_matrix(rows, &mut parts)?;
    if own.len() > 1 {
        // As if one finished column were taken off after the other: those of a first pass need not be
        // orthogonal to rounding, and what one of them leaves is then another one's to take.
        let mut overlap = transposed_product(directions, block.as_ref().subcols(own.start, own.len()));
        sum_matrix(rows, &mut overlap)?;
        solve_unit_lower_triangular_in_place(overlap.as_ref(), parts.as_mut(), Par::Seq);
    }
    for columns in [block, weighted] {
        let (earlier, rest) = columns.as_mut().split_at_col_mut(later.start);
        let own = earlier.as_ref().subcols(own.start, own.len());
        subtract_product(rest.subcols_mut(0, later.len()), own, parts.as_ref());
    }
    onto_new.submatrix_mut(own.start, later.start, own.len(), later.len()).copy_from(parts);
    Ok(())
}
