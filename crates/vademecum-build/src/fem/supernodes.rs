//! Layout of a factor: groups of columns with the same rows below them (supernodes).
//!
//! A group of one column is a column of a simplicial factor. What is selected of an inverse lies in the same
//! places.

use std::ops::Range;

use faer::sparse::linalg::cholesky::{SymbolicCholesky, SymbolicCholeskyRaw};
use faer::{Index, MatRef};

use super::number::FactorScalar;
use super::sparse::SymmetricMatrix;
use super::tree::{Contribution, Tree};
use crate::parallel;

/// Numbers at the end of an array that are worth giving back to the system.
const RETURNED: usize = 1 << 20;

/// Columns with the same rows below them.
#[derive(Clone, Debug)]
pub(super) struct Group {
    /// The first of the columns, in the order of elimination.
    pub(crate) first: usize,
    /// Their number.
    pub(crate) columns: usize,
    /// Range of the rows below among those of all groups.
    rows: Range<usize>,
    /// Range of the values: shape (columns + rows, columns), column by column.
    pub(crate) values: Range<usize>,
}

impl Group {
    /// The column after the last one.
    pub(crate) fn end(&self) -> usize {
        self.first + self.columns
    }

    /// Rows below the columns.
    pub(crate) fn below(&self) -> usize {
        self.rows.len()
    }

    /// Columns, and rows below them.
    pub(crate) fn height(&self) -> usize {
        self.columns + self.below()
    }

    /// Multiplications to factorise the group, about.
    fn work(&self) -> f64 {
        self.columns as f64 * (self.height() as f64).powi(2)
    }

    /// Entries that a solve reads, about.
    fn entries(&self) -> f64 {
        self.columns as f64 * self.height() as f64
    }

    /// The square on the columns of the group, and the rows below it.
    pub(crate) fn parts<'v, T>(&self, values: &'v [T]) -> (MatRef<'v, T>, MatRef<'v, T>) {
        MatRef::from_column_major_slice(&values[self.values.clone()], self.height(), self.columns)
            .split_at_row(self.columns)
    }
}

/// All groups of a factor.
#[derive(Debug)]
pub(super) struct Supernodes {
    pub(crate) groups: Vec<Group>,
    /// For a factorisation.
    pub(crate) tree: Tree,
    /// For solves.
    pub(crate) solves: Tree,
    rows: Vec<u32>,
    /// For each row, its position in the parent of its group.
    in_parent: Vec<u32>,
    /// The group of each column.
    owner: Vec<u32>,
    /// The column of each row of the matrix.
    place: Vec<u32>,
    /// The row of the matrix of each column.
    order: Vec<u32>,
}

/// Scaled and shifted substitute of a matrix `A`: `D A D + δ I`.
#[derive(Clone, Debug)]
pub(super) struct Scaling {
    /// `D`.
    pub(crate) scale: Vec<f64>,
    /// `δ`.
    pub(crate) shift: f64,
}

impl Scaling {
    fn entry(&self, row: usize, column: usize, value: f64) -> f64 {
        let scaled = self.scale[row] * value * self.scale[column];
        if row == column { scaled + self.shift } else { scaled }
    }
}

/// Rows below a group that are columns of one other group.
pub(super) struct Run {
    /// Index of that group.
    pub(crate) owner: usize,
    /// Their places among the rows.
    pub(crate) places: Range<usize>,
    /// For these and all later rows, their rows in the values of the other group.
    pub(crate) local: Vec<u32>,
}

impl Supernodes {
    /// The groups of a structure, whose rows fit 32 bits whatever its entries need.
    pub(crate) fn new<I: Index>(cholesky: &SymbolicCholesky<I>) -> Self {
        let n = cholesky.ncols();
        let narrow = |indices: &[I]| indices.iter().map(|index| index.zx() as u32).collect::<Vec<_>>();
        let (order, place) = match cholesky.perm() {
            Some(permutation) => {
                let (order, place) = permutation.arrays();
                (narrow(order), narrow(place))
            }
            None => ((0..n as u32).collect(), (0..n as u32).collect()),
        };
        let (mut groups, mut rows, mut owner) = (vec![], vec![], vec![0; n]);
        let mut values = 0;
        let mut push = |first: usize, columns: usize, below: &[I]| {
            let start = rows.len();
            rows.extend(below.iter().map(|row| row.zx() as u32));
            let end = values + (columns + below.len()) * columns;
            owner[first..first + columns].fill(groups.len() as u32);
            groups.push(Group { first, columns, rows: start..rows.len(), values: values..end });
            values = end;
        };
        match cholesky.raw() {
            SymbolicCholeskyRaw::Simplicial(structure) => {
                for (column, ends) in structure.col_ptr().windows(2).enumerate() {
                    // The diagonal is the first of each column.
                    push(column, 1, &structure.row_idx()[ends[0].zx() + 1..ends[1].zx()]);
                }
            }
            SymbolicCholeskyRaw::Supernodal(structure) => {
                for s in 0..structure.n_supernodes() {
                    let [first, end] = [structure.supernode_begin()[s], structure.supernode_end()[s]]
                        .map(|column| column.zx());
                    push(first, end - first, structure.supernode(s).pattern());
                }
            }
        }
        let [tree, solves] = [(); 2].map(|()| Tree::new(vec![], vec![], Contribution::Much));
        let mut all = Self { groups, tree, solves, rows, in_parent: vec![], owner, place, order };
        let parent: Vec<_> = all.groups.iter().map(|group| all.parent(group)).collect();
        let local = |at: usize| {
            parent[at].map_or(vec![], |parent| all.local(all.rows(&all.groups[at]), &all.groups[parent]))
        };
        let places = parallel::map(parent.len(), &local);
        all.in_parent = places.concat();
        let work = |of: fn(&Group) -> f64| all.groups.iter().map(of).collect();
        let [factorise, solve] = [work(Group::work), work(Group::entries)];
        all.tree = Tree::new(parent.clone(), factorise, Contribution::Much);
        all.solves = Tree::new(parent, solve, Contribution::Little);
        all
    }

    /// The row of the matrix of each column.
    pub(crate) fn order(&self) -> &[u32] {
        &self.order
    }

    /// Positions of the rows below a group among the columns and rows of its parent.
    pub(crate) fn in_parent(&self, group: &Group) -> &[u32] {
        &self.in_parent[group.rows.clone()]
    }

    /// Numbers of all groups, cut into those of each; `count` says how many a group has.
    pub(crate) fn split<'v, T>(
        &self,
        numbers: &'v mut [T],
        count: impl Fn(&Group) -> usize,
    ) -> Vec<&'v mut [T]> {
        let mut rest = numbers;
        let mut part = |group: &Group| {
            let (own, later) = std::mem::take(&mut rest).split_at_mut(count(group));
            rest = later;
            own
        };
        self.groups.iter().map(&mut part).collect()
    }

    /// The same, each on its own, so that they can be freed one by one; at no time are all there twice.
    pub(crate) fn in_groups(&self, mut numbers: Vec<f64>) -> Vec<Vec<f64>> {
        let cut = |group: &Group| {
            let own = numbers.split_off(group.values.start);
            if numbers.capacity() - numbers.len() > RETURNED {
                numbers.shrink_to_fit();
            }
            own
        };
        let mut parts: Vec<Vec<f64>> = self.groups.iter().rev().map(cut).collect();
        parts.reverse();
        parts
    }

    /// Rows of the matrix.
    pub(crate) fn n(&self) -> usize {
        self.order.len()
    }

    /// Numbers in all groups.
    pub(crate) fn len(&self) -> usize {
        self.groups.last().map_or(0, |group| group.values.end)
    }

    /// The rows below a group, ascending.
    pub(crate) fn rows(&self, group: &Group) -> &[u32] {
        &self.rows[group.rows.clone()]
    }

    /// Most rows below a group.
    pub(crate) fn tallest(&self) -> usize {
        self.groups.iter().map(Group::below).max().unwrap_or(0)
    }

    /// Most numbers of a group.
    pub(crate) fn largest(&self) -> usize {
        self.groups.iter().map(|group| group.values.len()).max().unwrap_or(0)
    }

    /// The groups that own the rows below one, in order, each with the rows it owns.
    pub(crate) fn runs(&self, group: &Group) -> Vec<Run> {
        let rows = self.rows(group);
        let mut runs = vec![];
        let mut start = 0;
        while start < rows.len() {
            let owner = self.owner[rows[start] as usize] as usize;
            let other = &self.groups[owner];
            let end = start + rows[start..].partition_point(|&row| (row as usize) < other.end());
            let local = self.local(&rows[start..], other);
            runs.push(Run { owner, places: start..end, local });
            start = end;
        }
        runs
    }

    /// The group of the first row below one: its parent in the elimination tree.
    pub(crate) fn parent(&self, group: &Group) -> Option<usize> {
        self.rows(group).first().map(|&row| self.owner[row as usize] as usize)
    }

    /// Positions of rows among the columns and rows of a group that has them all; both ascend.
    pub(crate) fn local(&self, rows: &[u32], group: &Group) -> Vec<u32> {
        let below = self.rows(group);
        let mut at = 0;
        let place = |&row: &u32| match row as usize - group.first {
            local if local < group.columns => local as u32,
            _ => {
                at += below[at..].iter().position(|&other| other == row).expect("a row of the group");
                (group.columns + at) as u32
            }
        };
        rows.iter().map(place).collect()
    }

    /// Group of the value of two rows of the matrix, in either order, and its position there; `None` off the
    /// pattern of the factor.
    pub(crate) fn position(&self, row: usize, column: usize) -> Option<(usize, usize)> {
        let [a, b] = [self.place[row] as usize, self.place[column] as usize];
        let (low, high) = (a.min(b), a.max(b));
        let owner = self.owner[low] as usize;
        let group = &self.groups[owner];
        let height = group.height();
        let local = match high - group.first {
            local if local < group.columns => local,
            _ => group.columns + self.rows(group).binary_search(&(high as u32)).ok()?,
        };
        Some((owner, (low - group.first) * height + local))
    }

    /// True for each group that has one of these rows of the matrix among its columns, and for all above it
    /// in the elimination tree.
    pub(crate) fn with_ancestors(&self, rows: impl IntoIterator<Item = usize>) -> Vec<bool> {
        let mut found = vec![false; self.groups.len()];
        for row in rows {
            found[self.owner[self.place[row] as usize] as usize] = true;
        }
        // A parent comes after its children.
        for group in 0..found.len() {
            if let Some(parent) = self.parent(&self.groups[group]).filter(|_| found[group]) {
                found[parent] = true;
            }
        }
        found
    }

    /// The lower triangle of `A` in the places of one group.
    pub(crate) fn of_group(&self, group: &Group, matrix: &SymmetricMatrix) -> Vec<f64> {
        let mut own = vec![0.0; group.values.len()];
        self.fill(group, matrix, None, &mut own);
        own
    }

    /// The lower triangle of `A`, or of `D A D + δ I`, in the places of the groups, zeros elsewhere; all
    /// threads.
    pub(crate) fn scatter<T: FactorScalar>(
        &self,
        matrix: &SymmetricMatrix,
        scaling: Option<&Scaling>,
    ) -> Vec<T> {
        let mut values = vec![T::nearest(0.0); self.len()];
        let places = self.split(&mut values, |group| group.values.len());
        parallel::for_each_of(places, &|at, own| self.fill(&self.groups[at], matrix, scaling, own));
        values
    }

    /// The same for one group.
    fn fill<T: FactorScalar>(
        &self,
        group: &Group,
        matrix: &SymmetricMatrix,
        scaling: Option<&Scaling>,
        own: &mut [T],
    ) {
        let (pattern, rows) = (matrix.pattern(), self.rows(group));
        // Fresh pages are written at once: a first read would map the page of zeros, and the write after it
        // would interrupt all threads.
        own.fill(T::nearest(0.0));
        for (c, target) in own.chunks_exact_mut(group.height()).enumerate() {
            let column = self.order[group.first + c] as usize;
            let entries = pattern.rows_of(column).iter().zip(&matrix.values()[pattern.range(column)]);
            for (&row, &value) in entries {
                let value = scaling.map_or(value, |scaling| scaling.entry(row as usize, column, value));
                let place = self.place[row as usize];
                match (place as usize).checked_sub(group.first) {
                    Some(local) if local >= group.columns => {
                        let at = rows.binary_search(&place).expect("a place of the factor");
                        target[group.columns + at] = T::nearest(value);
                    }
                    Some(local) if local >= c => target[local] = T::nearest(value),
                    // Above the diagonal.
                    _ => {}
                }
            }
        }
    }
}
