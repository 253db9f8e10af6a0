//! Forward and back substitution with a sparse Cholesky factor, `L y = b` and `Lᵀ x = y`.
//!
//! Small factors are gone through group by group, and threads share columns. A large one is read once for all
//! columns: threads share its elimination tree, and every group hands what it takes off the rows below it to
//! its parent, as a factorisation does (see [`super::multifrontal`]):
//!
//! ```text
//! y_J = L_JJ⁻¹ (b_J + Σ_children u_J)      u_I = Σ_children u_I − L_IJ y_J      x_J = L_JJ⁻ᵀ (y_J − L_IJᵀ x_I)
//! ```

use std::convert::Infallible;

use faer::linalg::matmul::matmul;
use faer::linalg::triangular_solve::{solve_lower_triangular_in_place, solve_upper_triangular_in_place};
use faer::prelude::{Reborrow, ReborrowMut};
use faer::{Accum, MatMut, MatRef, Par};
use rayon::prelude::*;

use super::number::Number;
use super::sparse::contiguous_mut;
use super::supernodes::{Group, Supernodes};
use crate::linalg::{by_rows, column_groups};

/// Columns of a group that are solved for at a time.
const PANEL: usize = 128;

/// Groups at least that one thread copies at a time.
const FEW: usize = 64;

/// Factors of more numbers than this are read once for all columns: 16 MB in double precision, no longer in
/// the caches.
pub(super) const LARGE: usize = 1 << 21;

/// Overwrites `x`, shape (n, k) in the order of elimination, by `L⁻ᵀ L⁻¹ x`, on one thread. `spare` holds k
/// numbers for each row of the tallest group.
pub(super) fn substitute<T: Number>(
    supernodes: &Supernodes,
    values: &[T],
    mut x: MatMut<'_, T>,
    spare: &mut [T],
) {
    let k = x.ncols();
    let [one, minus] = [1.0, -1.0].map(T::nearest);
    for group in &supernodes.groups {
        let (lower, ratio) = group.parts(values);
        let mut own = x.rb_mut().subrows_mut(group.first, group.columns);
        solve_lower_triangular_in_place(lower, own.rb_mut(), Par::Seq);
        let below = group.below();
        let mut image = MatMut::from_column_major_slice_mut(&mut spare[..below * k], below, k);
        matmul(image.rb_mut(), Accum::Replace, ratio, own.rb(), one, Par::Seq);
        for j in 0..k {
            for (i, &row) in supernodes.rows(group).iter().enumerate() {
                x[(row as usize, j)] -= image[(i, j)];
            }
        }
    }
    for group in supernodes.groups.iter().rev() {
        let (lower, ratio) = group.parts(values);
        let below = group.below();
        let mut image = MatMut::from_column_major_slice_mut(&mut spare[..below * k], below, k);
        for j in 0..k {
            for (i, &row) in supernodes.rows(group).iter().enumerate() {
                image[(i, j)] = x[(row as usize, j)];
            }
        }
        let mut own = x.rb_mut().subrows_mut(group.first, group.columns);
        matmul(own.rb_mut(), Accum::Add, ratio.transpose(), image.rb(), minus, Par::Seq);
        solve_upper_triangular_in_place(lower.transpose(), own, Par::Seq);
    }
}

/// The same with all threads. `x` holds the rows of each group together, column by column.
pub(super) fn substitute_by_groups<T: Number>(supernodes: &Supernodes, values: &[T], x: &mut [T], k: usize) {
    let zeros = |below: usize| vec![T::nearest(0.0); below * k];
    let up = |at: usize, own: &mut [T], children: Vec<(usize, Vec<T>)>| -> Result<Vec<T>, Infallible> {
        let group = &supernodes.groups[at];
        let (columns, below) = (group.columns, group.below());
        let mut update = zeros(below);
        for (child, from) in children {
            let local = supernodes.in_parent(&supernodes.groups[child]);
            for (j, from) in from.chunks_exact(local.len()).enumerate() {
                let (own, update) = (&mut own[j * columns..], &mut update[j * below..]);
                for (&place, &value) in local.iter().zip(from) {
                    let place = place as usize;
                    *if place < columns { &mut own[place] } else { &mut update[place - columns] } += value;
                }
            }
        }
        let own = MatMut::from_column_major_slice_mut(own, columns, k);
        forward(group, values, own, MatMut::from_column_major_slice_mut(&mut update, below, k));
        Ok(update)
    };
    let Ok(()) = supernodes.tree.upwards(supernodes.split(x, |group| group.columns * k), up);
    supernodes.tree.downwards(
        supernodes.split(x, |group| group.columns * k),
        |at, own: &mut [T], above: Option<&Vec<T>>| {
            let group = &supernodes.groups[at];
            let (columns, below, height) = (group.columns, group.below(), group.height());
            // All rows of the group, for its children.
            let mut front = zeros(height);
            if let Some(above) = above {
                let local = supernodes.in_parent(group);
                for (target, from) in front.chunks_exact_mut(height).zip(above.chunks_exact(above.len() / k))
                {
                    target[columns..].iter_mut().zip(local).for_each(|(x, &place)| *x = from[place as usize]);
                }
            }
            let rows = MatRef::from_column_major_slice(&front, height, k).subrows(columns, below);
            back(group, values, MatMut::from_column_major_slice_mut(own, columns, k), rows);
            for (target, own) in front.chunks_exact_mut(height).zip(own.chunks_exact(columns)) {
                target[..columns].copy_from_slice(own);
            }
            front
        },
    );
}

/// The columns of a block over the rows of the matrix as [`substitute_by_groups`] takes them; `number` gives
/// the entry at a row and a column.
pub(super) fn gather<T: Number>(
    supernodes: &Supernodes,
    k: usize,
    x: &mut [T],
    number: impl Fn(usize, usize) -> T + Sync,
) {
    let groups =
        supernodes.groups.par_iter().zip(supernodes.split(x, |group| group.columns * k)).with_min_len(FEW);
    groups.for_each(|(group, own)| {
        let rows = &supernodes.order()[group.first..group.first + group.columns];
        for (j, own) in own.chunks_exact_mut(group.columns).enumerate() {
            own.iter_mut().zip(rows).for_each(|(x, &row)| *x = number(row as usize, j));
        }
    });
}

/// Writes the columns back; `number` gives the entry at a row and a column.
pub(super) fn scatter<T: Number>(
    supernodes: &Supernodes,
    x: &[T],
    to: MatMut<'_, f64>,
    number: impl Fn(T, usize, usize) -> f64 + Sync,
) {
    let k = to.ncols();
    column_groups(to, 1).into_par_iter().enumerate().for_each(|(j, to)| {
        let to = contiguous_mut(to, 0);
        for group in &supernodes.groups {
            let rows = &supernodes.order()[group.first..group.first + group.columns];
            let own = &x[group.first * k + j * group.columns..];
            rows.iter().zip(own).for_each(|(&row, &x)| to[row as usize] = number(x, row as usize, j));
        }
    });
}

/// `x_J ← L_JJ⁻¹ x_J`, and `L_IJ x_J` taken off `update`.
fn forward<T: Number>(group: &Group, values: &[T], mut own: MatMut<'_, T>, update: MatMut<'_, T>) {
    let (lower, ratio) = group.parts(values);
    let minus = T::nearest(-1.0);
    let mut rest = own.rb_mut();
    for first in (0..group.columns).step_by(PANEL) {
        let width = PANEL.min(group.columns - first);
        let (mut panel, mut later) = rest.split_at_row_mut(width);
        let columns = lower.subcols(first, width).split_at_row(first).1;
        let (pivot, below) = columns.split_at_row(width);
        solve_lower_triangular_in_place(pivot, panel.rb_mut(), Par::Seq);
        let panel = panel.rb();
        by_rows(later.rb_mut(), width, |at, rows| {
            let own = below.subrows(at, rows.nrows());
            matmul(rows, Accum::Add, own, panel, minus, Par::Seq);
        });
        rest = later;
    }
    let own = own.rb();
    by_rows(update, group.columns, |at, rows| {
        let ratio = ratio.subrows(at, rows.nrows());
        matmul(rows, Accum::Add, ratio, own, minus, Par::Seq);
    });
}

/// `x_J ← L_JJ⁻ᵀ (x_J − L_IJᵀ x_I)`.
fn back<T: Number>(group: &Group, values: &[T], mut own: MatMut<'_, T>, below: MatRef<'_, T>) {
    let (lower, ratio) = group.parts(values);
    let minus = T::nearest(-1.0);
    by_rows(own.rb_mut(), group.below(), |at, rows| {
        let ratio = ratio.subcols(at, rows.nrows());
        matmul(rows, Accum::Add, ratio.transpose(), below, minus, Par::Seq);
    });
    let mut rest = own;
    for first in (0..group.columns).step_by(PANEL).rev() {
        let width = PANEL.min(group.columns - first);
        let (mut earlier, mut panel) = rest.split_at_row_mut(first);
        let (left, pivot) = lower.subrows(first, width).subcols(0, first + width).split_at_col(first);
        solve_upper_triangular_in_place(pivot.transpose(), panel.rb_mut(), Par::Seq);
        let panel = panel.rb();
        by_rows(earlier.rb_mut(), width, |at, rows| {
            let own = left.subcols(at, rows.nrows());
            matmul(rows, Accum::Add, own.transpose(), panel, minus, Par::Seq);
        });
        rest = earlier;
    }
}
