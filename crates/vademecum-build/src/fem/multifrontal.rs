//! The numbers of a sparse Cholesky factor, front by front (Duff and Reid 1983; Liu 1992).
//!
//! A group of columns takes its entries of the matrix, and what its children in the elimination tree left for
//! it. It is factorised densely, and leaves for its parent what it does to the rows below it:
//!
//! ```text
//! A_JJ = L_JJ L_JJᵀ        L_IJ = A_IJ L_JJ⁻ᵀ        U_II = Σ_children U − L_IJ L_IJᵀ
//! ```
//!
//! Threads share the subtrees that are small beside the whole; above them, they share rows of the dense
//! products, cut at a fixed height. Children are added in one order. So the bits never depend on the number
//! of threads.

use std::collections::BTreeMap;

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::{LltError, cholesky_in_place, cholesky_in_place_scratch};
use faer::linalg::matmul::matmul;
use faer::linalg::matmul::triangular::{self, BlockStructure};
use faer::linalg::triangular_solve::solve_lower_triangular_in_place;
use faer::prelude::{Reborrow, ReborrowMut};
use faer::{Accum, MatMut, MatRef, Par, Spec};
use rayon::prelude::*;

use super::sparse::SymmetricMatrix;
use super::supernodes::{Group, Supernodes};
use crate::linalg::{SHARED, by_rows};

/// Columns of a group that are factorised at a time.
const PANEL: usize = 128;

/// Share of the whole work above which a subtree is no task of one thread.
const TASK: f64 = 1.0 / 128.0;

/// Share of the whole work in the subtrees that threads share at a time: what they leave lies in memory until
/// their parents take it.
const AT_ONCE: f64 = 1.0 / 32.0;

/// What groups left for their parents: lower triangles over their rows below, column by column.
type Left = BTreeMap<usize, Vec<f64>>;

/// Groups in the order of elimination, with the places of their values.
type Groups<'v> = Vec<(usize, &'v mut [f64])>;

/// What one thread eliminates.
struct Subtree<'v> {
    root: usize,
    /// Of the whole work.
    share: f64,
    groups: Groups<'v>,
}

/// The values of `L` in the places of the groups; whatever is above a diagonal means nothing.
///
/// # Errors
/// A pivot that is not positive, by its place in the order of elimination.
pub(super) fn factorise(supernodes: &Supernodes, matrix: &SymmetricMatrix) -> Result<Vec<f64>, usize> {
    let mut values = supernodes.scatter(matrix);
    let tree = Tree::new(supernodes);
    let (subtrees, above) = tree.split(supernodes, &mut values);
    let mut subtrees = subtrees.into_iter().peekable();
    // Those whose root comes before a group, and a few more.
    let mut until = |group: usize, left: &mut Left| -> Result<(), usize> {
        while subtrees.peek().is_some_and(|subtree| subtree.root < group) {
            let (mut some, mut share) = (vec![], 0.0);
            while share < AT_ONCE
                && let Some(subtree) = subtrees.next()
            {
                share += subtree.share;
                some.push(subtree.groups);
            }
            let done: Vec<_> =
                some.into_par_iter().map(|groups| tree.eliminate(supernodes, groups, Left::new())).collect();
            for done in done {
                left.append(&mut done?);
            }
        }
        Ok(())
    };
    let mut left = Left::new();
    for (at, own) in above {
        until(at, &mut left)?;
        left = tree.eliminate(supernodes, vec![(at, own)], left)?;
    }
    until(usize::MAX, &mut left)?;
    Ok(values)
}

/// The elimination tree of the groups.
struct Tree {
    /// The group of the first row below each.
    parent: Vec<Option<usize>>,
    /// Ascending.
    children: Vec<Vec<usize>>,
}

impl Tree {
    fn new(supernodes: &Supernodes) -> Tree {
        let parent: Vec<_> = supernodes.groups.iter().map(|group| supernodes.parent(group)).collect();
        let mut children = vec![vec![]; parent.len()];
        for (group, parent) in parent.iter().enumerate() {
            if let Some(parent) = parent {
                children[*parent].push(group);
            }
        }
        Tree { parent, children }
    }

    /// Subtrees for one thread each, ascending, and what stands above them.
    fn split<'v>(&self, supernodes: &Supernodes, values: &'v mut [f64]) -> (Vec<Subtree<'v>>, Groups<'v>) {
        let mut work: Vec<f64> = supernodes.groups.iter().map(work).collect();
        for group in 0..work.len() {
            if let Some(parent) = self.parent[group] {
                work[parent] += work[group];
            }
        }
        let roots = (0..work.len()).filter(|&group| self.parent[group].is_none());
        let total: f64 = roots.map(|group| work[group]).sum();
        // The subtree of each group that is in one: a parent comes after its children.
        let mut subtree: Vec<Option<usize>> = vec![None; work.len()];
        let mut subtrees = vec![];
        for group in (0..work.len()).rev().filter(|&group| work[group] <= TASK * total) {
            let inherited = self.parent[group].and_then(|parent| subtree[parent]);
            subtree[group] = Some(inherited.unwrap_or_else(|| {
                subtrees.push(Subtree { root: group, share: work[group] / total, groups: vec![] });
                subtrees.len() - 1
            }));
        }
        let (mut above, mut rest) = (vec![], values);
        for (group, subtree) in subtree.into_iter().enumerate() {
            let (own, later) = rest.split_at_mut(supernodes.groups[group].values.len());
            subtree.map_or(&mut above, |subtree| &mut subtrees[subtree].groups).push((group, own));
            rest = later;
        }
        // They were found from the last group to the first.
        subtrees.reverse();
        (subtrees, above)
    }

    /// Factorises some groups, whose children are among them or left something before.
    fn eliminate(&self, supernodes: &Supernodes, groups: Groups<'_>, mut left: Left) -> Result<Left, usize> {
        for (at, own) in groups {
            let group = &supernodes.groups[at];
            let mut update = vec![0.0; group.below().pow(2)];
            for child in &self.children[at] {
                let from = left.remove(child).expect("children come first");
                add(supernodes, &supernodes.groups[*child], &from, group, own, &mut update);
            }
            let values =
                MatMut::from_column_major_slice_mut(own, group.columns + group.below(), group.columns);
            front(values, &mut update).map_err(|pivot| group.first + pivot)?;
            left.insert(at, update);
        }
        Ok(left)
    }
}

/// Multiplications for a group.
fn work(group: &Group) -> f64 {
    group.columns as f64 * ((group.columns + group.below()) as f64).powi(2)
}

/// Adds what a child left to the places of its parent, and to what that will leave.
fn add(
    supernodes: &Supernodes,
    child: &Group,
    from: &[f64],
    group: &Group,
    own: &mut [f64],
    update: &mut [f64],
) {
    let local = supernodes.local(supernodes.rows(child), group);
    let (columns, below, rows) = (group.columns, group.below(), local.len());
    // Columns of the parent from the first row on that they hold.
    let targets = own.chunks_mut(columns + below).map(|target| (0, target));
    let targets = targets.chain(update.chunks_mut(below.max(1)).map(|target| (columns, target)));
    let mine = |(place, target)| local.binary_search(&(place as u32)).ok().map(|column| (column, target));
    let task = |(column, (first, target)): (usize, (usize, &mut [f64]))| {
        let source = &from[column * rows + column..(column + 1) * rows];
        for (&place, &value) in local[column..].iter().zip(source) {
            target[place as usize - first] += value;
        }
    };
    if (rows * rows) as f64 > SHARED {
        let targets: Vec<_> = targets.enumerate().filter_map(mine).collect();
        targets.into_par_iter().for_each(task);
    } else {
        targets.enumerate().filter_map(mine).for_each(task);
    }
}

/// Factorises a group in its places, and takes its product off the lower triangle of `update`.
///
/// # Errors
/// The first pivot that is not positive.
fn front(mut values: MatMut<'_, f64>, update: &mut [f64]) -> Result<(), usize> {
    let columns = values.ncols();
    let below = values.nrows() - columns;
    let mut rest = values.rb_mut();
    let mut memory = MemBuffer::new(cholesky_in_place_scratch::<f64>(PANEL, Par::Seq, Spec::default()));
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
fn subtract_square(matrix: MatMut<'_, f64>, g: MatRef<'_, f64>) {
    let columns = matrix.ncols();
    by_rows(matrix, g.ncols(), |first, rows| {
        let own = g.subrows(first, rows.nrows());
        let upto = columns.min(first);
        let (left, rest) = rows.split_at_col_mut(upto);
        matmul(left, Accum::Add, own, g.subrows(0, upto).transpose(), -1.0, Par::Seq);
        // On the diagonal the lower triangle is enough.
        let (square, below) = rest.split_at_row_mut(own.nrows().min(columns - upto));
        let wide = square.nrows();
        let (own, others) = (own.subrows(0, wide), own.subrows(wide, own.nrows() - wide));
        let [lower, full] = [BlockStructure::TriangularLower, BlockStructure::Rectangular];
        let square = square.subcols_mut(0, wide);
        triangular::matmul(square, lower, Accum::Add, own, full, own.transpose(), full, -1.0, Par::Seq);
        matmul(below.subcols_mut(0, wide), Accum::Add, others, own.transpose(), -1.0, Par::Seq);
    });
}
