//! The numbers of a sparse Cholesky factor, front by front (Duff and Reid 1983; Liu 1992).
//!
//! A group of columns takes its entries of the matrix, and what its children in the elimination tree left for
//! it. It is factorised densely, and leaves for its parent what it does to the rows below it:
//!
//! ```text
//! A_JJ = L_JJ L_JJᵀ        L_IJ = A_IJ L_JJ⁻ᵀ        U_II = Σ_children U − L_IJ L_IJᵀ
//! ```
//!
//! Threads share the elimination tree as [`super::tree`] says, and the rows of dense products, cut at a fixed
//! height. Children are added in one order. So the bits never depend on the number of threads.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::{LltError, cholesky_in_place, cholesky_in_place_scratch};
use faer::linalg::matmul::matmul;
use faer::linalg::matmul::triangular::{self, BlockStructure};
use faer::linalg::triangular_solve::solve_lower_triangular_in_place;
use faer::prelude::{Reborrow, ReborrowMut};
use faer::{Accum, MatMut, MatRef, Par, Spec};

use super::number::FactorScalar;
use super::sparse::SymmetricMatrix;
use super::supernodes::{Group, Scaling, Supernodes};
use crate::linalg::{SHARED, by_rows};
use crate::parallel;

/// Columns of a group that are factorised at a time.
const PANEL: usize = 128;

/// The values of `L` in the places of the groups, of the matrix or of its substitute; whatever is above a
/// diagonal means nothing.
///
/// # Errors
/// A pivot that is not positive, by its place in the order of elimination.
pub(super) fn factorise<T: FactorScalar>(
    supernodes: &Supernodes,
    matrix: &SymmetricMatrix,
    scaling: Option<&Scaling>,
) -> Result<Vec<T>, usize> {
    let mut values = supernodes.scatter(matrix, scaling);
    let parts = supernodes.split(&mut values, |group| group.values.len());
    supernodes.tree.upwards(parts, |at, own, children: Vec<(usize, Vec<T>)>| {
        let group = &supernodes.groups[at];
        let below = group.below();
        let mut update = fresh_square(below);
        for (child, from) in children {
            add(supernodes, &supernodes.groups[child], &from, group, own, &mut update);
        }
        let values = MatMut::from_column_major_slice_mut(own, group.height(), group.columns);
        front(values, &mut update).map(|()| update).map_err(|pivot| group.first + pivot)
    })?;
    Ok(values)
}

/// Zeros, `n` columns of as many.
pub(super) fn fresh_square<T: FactorScalar>(n: usize) -> Vec<T> {
    let mut square = vec![T::nearest(0.0); n * n];
    if (n * n) as f64 > SHARED {
        // Fresh pages are written at once, as those of the factor are.
        parallel::for_each_of(square.chunks_exact_mut(n), &|column, rows| {
            rows[column..].fill(T::nearest(0.0));
        });
    }
    square
}

/// Adds what a child left to the places of its parent, and to what that will leave.
pub(super) fn add<T: FactorScalar>(
    supernodes: &Supernodes,
    child: &Group,
    from: &[T],
    group: &Group,
    own: &mut [T],
    update: &mut [T],
) {
    let local = supernodes.in_parent(child);
    let (columns, below, rows) = (group.columns, group.below(), local.len());
    // Columns of the parent from the first row on that they hold.
    let targets = own.chunks_mut(columns + below).map(|target| (0, target));
    let targets = targets.chain(update.chunks_mut(below.max(1)).map(|target| (columns, target)));
    let mine = |(place, target)| local.binary_search(&(place as u32)).ok().map(|column| (column, target));
    let task = |(column, (first, target)): (usize, (usize, &mut [T]))| {
        let source = &from[column * rows + column..(column + 1) * rows];
        for (&place, &value) in local[column..].iter().zip(source) {
            target[place as usize - first] += value;
        }
    };
    if (rows * rows) as f64 > SHARED {
        let targets: Vec<_> = targets.enumerate().filter_map(mine).collect();
        parallel::for_each_of(targets, &|_, target| task(target));
    } else {
        targets.enumerate().filter_map(mine).for_each(task);
    }
}

/// Factorises a group in its places, and takes its product off the lower triangle of `update`.
///
/// # Errors
/// The first pivot that is not positive.
fn front<T: FactorScalar>(mut values: MatMut<'_, T>, update: &mut [T]) -> Result<(), usize> {
    let columns = values.ncols();
    let below = values.nrows() - columns;
    let mut rest = values.rb_mut();
    let mut memory = MemBuffer::new(cholesky_in_place_scratch::<T>(PANEL, Par::Seq, Spec::default()));
    for first in (0..columns).step_by(PANEL) {
        let width = PANEL.min(columns - first);
        let (panel, later) = rest.split_at_col_mut(width);
        let (mut pivot, mut ratio) = panel.split_at_row_mut(width);
        let stack = MemStack::new(&mut memory);
        let done = cholesky_in_place(pivot.rb_mut(), Default::default(), Par::Seq, stack, Spec::default());
        if let Err(LltError::NonPositivePivot { index }) = done {
            return Err(first + index);
        }
        let pivot = pivot.rb();
        by_rows(ratio.rb_mut(), width, |_, rows| {
            solve_lower_triangular_in_place(pivot, rows.transpose_mut(), Par::Seq);
        });
        rest = later.split_at_row_mut(width).1;
        subtract_square(rest.rb_mut(), ratio.rb());
    }
    let update = MatMut::from_column_major_slice_mut(update, below, below);
    subtract_square(update, values.rb().subrows(columns, below));
    Ok(())
}

/// Takes `G Gᵀ` off the first columns of a symmetric matrix, on and below the diagonal.
fn subtract_square<T: FactorScalar>(matrix: MatMut<'_, T>, g: MatRef<'_, T>) {
    let minus = T::nearest(-1.0);
    let columns = matrix.ncols();
    by_rows(matrix, g.ncols(), |first, rows| {
        let own = g.subrows(first, rows.nrows());
        let upto = columns.min(first);
        let (left, rest) = rows.split_at_col_mut(upto);
        matmul(left, Accum::Add, own, g.subrows(0, upto).transpose(), minus, Par::Seq);
        // On the diagonal the lower triangle is enough.
        let (square, below) = rest.split_at_row_mut(own.nrows().min(columns - upto));
        let wide = square.nrows();
        let (own, others) = (own.subrows(0, wide), own.subrows(wide, own.nrows() - wide));
        let [lower, full] = [BlockStructure::TriangularLower, BlockStructure::Rectangular];
        let square = square.subcols_mut(0, wide);
        triangular::matmul(square, lower, Accum::Add, own, full, own.transpose(), full, minus, Par::Seq);
        matmul(below.subcols_mut(0, wide), Accum::Add, others, own.transpose(), minus, Par::Seq);
    });
}
