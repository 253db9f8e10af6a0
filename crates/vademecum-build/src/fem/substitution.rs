//! Forward and back substitution with a sparse Cholesky factor, `L y = b` and `Lᵀ x = y`.
//!
//! Blocks of right-hand sides are stored row by row, so that dense products use the factor in place and copy
//! none of it. Small factors are processed group by group, and threads share columns. A large one is read
//! once for all columns: threads share its elimination tree, and every group hands what it takes off the rows
//! below it to its parent, as a factorisation does (see [`super::multifrontal`]):
//!
//! ```text
//! y_J = L_JJ⁻¹ (b_J + Σ_children u_J)      u_I = Σ_children u_I − L_IJ y_J      x_J = L_JJ⁻ᵀ (y_J − L_IJᵀ x_I)
//! ```

use std::convert::Infallible;

use faer::linalg::matmul::matmul;
use faer::linalg::triangular_solve::{solve_lower_triangular_in_place, solve_upper_triangular_in_place};
use faer::prelude::{Reborrow, ReborrowMut};
use faer::{Accum, MatMut, MatRef, Par};

use super::number::FactorScalar;
use super::supernodes::{Group, Supernodes};
use super::thin::BlockKernel;
use crate::linalg::{HEIGHT, SHARED, column_groups};
use crate::parallel;

/// Columns of a group that are solved for at a time.
const PANEL: usize = 128;

/// Reading an entry of the factor takes as long as multiplying it with this number of columns.
const FEW_COLUMNS: usize = 16;

/// Rows that one thread copies at a time.
const FEW: usize = 4096;

/// Columns that one thread writes at a time.
const SIDE_BY_SIDE: usize = 4;

/// Factors of more numbers than this are read once for all columns: 16 MB in double precision, no longer in
/// the caches.
pub(super) const LARGE: usize = 1 << 21;

/// Overwrites `x` by `L⁻ᵀ L⁻¹ x`, on one thread. `x` holds the rows in the order of elimination, k numbers
/// each, and `spare` k numbers for each row of the tallest group.
pub(super) fn substitute<T: FactorScalar>(
    supernodes: &Supernodes,
    values: &[T],
    x: &mut [T],
    k: usize,
    spare: &mut [T],
) {
    let [one, minus] = [1.0, -1.0].map(T::nearest);
    for group in &supernodes.groups {
        let (lower, ratio) = group.parts(values);
        let (own, later) = x[group.first * k..].split_at_mut(group.columns * k);
        if is_zero(own) {
            continue;
        }
        let mut own = MatMut::from_row_major_slice_mut(own, group.columns, k);
        solve_lower_triangular_in_place(lower, own.rb_mut(), Par::Seq);
        let image = &mut spare[..group.below() * k];
        let rows = MatMut::from_row_major_slice_mut(image, group.below(), k);
        matmul(rows, Accum::Replace, ratio, own.rb(), one, Par::Seq);
        for (from, &row) in image.chunks_exact(k).zip(supernodes.rows(group)) {
            let to = &mut later[(row as usize - group.end()) * k..];
            to.iter_mut().zip(from).for_each(|(x, image)| *x -= *image);
        }
    }
    for group in supernodes.groups.iter().rev() {
        let (lower, ratio) = group.parts(values);
        let (own, later) = x[group.first * k..].split_at_mut(group.columns * k);
        let image = &mut spare[..group.below() * k];
        for (to, &row) in image.chunks_exact_mut(k).zip(supernodes.rows(group)) {
            to.copy_from_slice(&later[(row as usize - group.end()) * k..][..k]);
        }
        let mut own = MatMut::from_row_major_slice_mut(own, group.columns, k);
        let rows = MatRef::from_row_major_slice(image, group.below(), k);
        matmul(own.rb_mut(), Accum::Add, ratio.transpose(), rows, minus, Par::Seq);
        solve_upper_triangular_in_place(lower.transpose(), own, Par::Seq);
    }
}

/// True if a part of the right-hand sides holds zeros alone.
fn is_zero<T: FactorScalar>(part: &[T]) -> bool {
    part.iter().all(|x| *x == T::nearest(0.0))
}

/// The same with all threads.
pub(super) fn substitute_by_groups<T: FactorScalar>(
    supernodes: &Supernodes,
    values: &[T],
    x: &mut [T],
    k: usize,
) {
    // Fresh pages are written at once, as those of the factor are.
    let zeros = |rows: usize| {
        let mut zeros = Vec::with_capacity(rows * k);
        zeros.resize(rows * k, T::nearest(0.0));
        zeros
    };
    let up = |at: usize, own: &mut [T], children: Vec<(usize, Vec<T>)>| -> Result<Vec<T>, Infallible> {
        let group = &supernodes.groups[at];
        let (columns, below) = (group.columns, group.below());
        // Forces at a few nodes are felt above them in the tree alone.
        if children.iter().all(|(_, from)| from.is_empty()) && is_zero(own) {
            return Ok(vec![]);
        }
        let mut update = zeros(below);
        for (child, from) in children {
            let local = supernodes.in_parent(&supernodes.groups[child]);
            for (&place, from) in local.iter().zip(from.chunks_exact(k)) {
                let to = match (place as usize).checked_sub(columns) {
                    None => &mut own[place as usize * k..],
                    Some(place) => &mut update[place * k..],
                };
                to.iter_mut().zip(from).for_each(|(x, from)| *x += *from);
            }
        }
        forward(group, values, own, &mut update, k);
        Ok(update)
    };
    let Ok(()) = supernodes.solves.upwards(supernodes.split(x, |group| group.columns * k), up);
    let down = |at: usize, own: &mut [T], above: Option<&Vec<T>>| {
        let group = &supernodes.groups[at];
        // All rows of the group, for its children.
        let mut front = zeros(group.height());
        let (first, rows) = front.split_at_mut(group.columns * k);
        if let Some(above) = above {
            for (to, &place) in rows.chunks_exact_mut(k).zip(supernodes.in_parent(group)) {
                to.copy_from_slice(&above[place as usize * k..][..k]);
            }
        }
        back(group, values, own, rows, k);
        first.copy_from_slice(own);
        front
    };
    supernodes.solves.downwards(supernodes.split(x, |group| group.columns * k), down);
}

/// The columns of a block over the rows of the matrix as solves take them; `number` gives the entry at a row
/// and a column. All threads.
pub(super) fn gather<T: FactorScalar>(
    supernodes: &Supernodes,
    k: usize,
    x: &mut [T],
    number: impl Fn(usize, usize) -> T + Sync,
) {
    let chunks = x.chunks_mut(FEW * k).zip(supernodes.order().chunks(FEW));
    parallel::for_each_of(chunks, &|_, (x, order)| {
        for (x, &row) in x.chunks_exact_mut(k).zip(order) {
            x.iter_mut().enumerate().for_each(|(j, x)| *x = number(row as usize, j));
        }
    });
}

/// Writes the columns back from rows of `k` numbers; `number` gives the entry at a row and a column. All
/// threads.
pub(super) fn scatter<T: FactorScalar>(
    supernodes: &Supernodes,
    x: &[T],
    k: usize,
    to: MatMut<'_, f64>,
    number: impl Fn(T, usize, usize) -> f64 + Sync,
) {
    parallel::for_each_of(column_groups(to, SIDE_BY_SIDE), &|group, mut to| {
        let first = group * SIDE_BY_SIDE;
        for (x, &row) in x.chunks_exact(k).zip(supernodes.order()) {
            let row = row as usize;
            for (j, &x) in x[first..].iter().take(to.ncols()).enumerate() {
                to[(row, j)] = number(x, row, first + j);
            }
        }
    });
}

/// `k` numbers for each row, some rows at a time with the first of them; `inner` entries of the factor are
/// read for each. Threads share them where there is enough to read.
fn by_rows<T: Send>(x: &mut [T], k: usize, inner: usize, task: impl Fn(usize, &mut [T]) + Sync) {
    let work = x.len().max(x.len() / k * FEW_COLUMNS) as f64 * inner as f64;
    let groups = x.chunks_mut(HEIGHT * k);
    if work > SHARED {
        parallel::for_each_of(groups, &|at, rows| task(at * HEIGHT, rows));
    } else {
        groups.enumerate().for_each(|(at, rows)| task(at * HEIGHT, rows));
    }
}

/// `x ← x − A y`, on one thread.
fn take_off<T: FactorScalar>(x: &mut [T], a: MatRef<'_, T>, y: &[T], k: usize) {
    if !BlockKernel::Product.apply(x, a, y, k) {
        let x = MatMut::from_row_major_slice_mut(x, a.nrows(), k);
        let y = MatRef::from_row_major_slice(y, a.ncols(), k);
        matmul(x, Accum::Add, a, y, T::nearest(-1.0), Par::Seq);
    }
}

/// `x ← x − Aᵀ y`, on one thread.
fn take_off_transposed<T: FactorScalar>(x: &mut [T], a: MatRef<'_, T>, y: &[T], k: usize) {
    if !BlockKernel::Transposed.apply(x, a, y, k) {
        let x = MatMut::from_row_major_slice_mut(x, a.ncols(), k);
        let y = MatRef::from_row_major_slice(y, a.nrows(), k);
        matmul(x, Accum::Add, a.transpose(), y, T::nearest(-1.0), Par::Seq);
    }
}

/// `x_J ← L_JJ⁻¹ x_J`, and `L_IJ x_J` taken off `update`.
fn forward<T: FactorScalar>(group: &Group, values: &[T], own: &mut [T], update: &mut [T], k: usize) {
    let (lower, ratio) = group.parts(values);
    for first in (0..group.columns).step_by(PANEL) {
        let width = PANEL.min(group.columns - first);
        let (panel, later) = own[first * k..].split_at_mut(width * k);
        let columns = lower.subcols(first, width).split_at_row(first).1;
        let (pivot, below) = columns.split_at_row(width);
        if !BlockKernel::Lower.apply(panel, pivot, &[], k) {
            let panel = MatMut::from_row_major_slice_mut(panel, width, k);
            solve_lower_triangular_in_place(pivot, panel, Par::Seq);
        }
        by_rows(later, k, width, |at, rows| take_off(rows, below.subrows(at, rows.len() / k), panel, k));
    }
    by_rows(update, k, group.columns, |at, rows| {
        take_off(rows, ratio.subrows(at, rows.len() / k), own, k);
    });
}

/// `x_J ← L_JJ⁻ᵀ (x_J − L_IJᵀ x_I)`.
fn back<T: FactorScalar>(group: &Group, values: &[T], own: &mut [T], below: &[T], k: usize) {
    let (lower, ratio) = group.parts(values);
    by_rows(own, k, group.below(), |at, rows| {
        take_off_transposed(rows, ratio.subcols(at, rows.len() / k), below, k);
    });
    for first in (0..group.columns).step_by(PANEL).rev() {
        let width = PANEL.min(group.columns - first);
        let (earlier, panel) = own[..(first + width) * k].split_at_mut(first * k);
        let (left, pivot) = lower.subrows(first, width).subcols(0, first + width).split_at_col(first);
        if !BlockKernel::Upper.apply(panel, pivot, &[], k) {
            let panel = MatMut::from_row_major_slice_mut(panel, width, k);
            solve_upper_triangular_in_place(pivot.transpose(), panel, Par::Seq);
        }
        by_rows(earlier, k, width, |at, rows| {
            take_off_transposed(rows, left.subcols(at, rows.len() / k), panel, k);
        });
    }
}
