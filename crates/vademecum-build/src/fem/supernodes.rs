//! How the numbers of a factor lie: groups of columns with the same rows below them.
//!
//! A group of one column is a column of a simplicial factor. What is selected of an inverse lies in the same
//! places.

use std::ops::Range;

use faer::sparse::linalg::cholesky::{SymbolicCholesky, SymbolicCholeskyRaw};
use rayon::prelude::*;

use super::sparse::SymmetricMatrix;

/// Columns with the same rows below them.
#[derive(Clone, Debug)]
pub(super) struct Group {
    /// The first of the columns, in the order of elimination.
    pub first: usize,
    /// How many.
    pub columns: usize,
    /// Where the rows below stand among those of all groups.
    rows: Range<usize>,
    /// Where the values stand: shape (columns + rows, columns), column by column.
    pub values: Range<usize>,
}

impl Group {
    /// Rows below the columns.
    pub fn below(&self) -> usize {
        self.rows.len()
    }
}

/// All groups of a factor.
#[derive(Clone, Debug)]
pub(super) struct Supernodes {
    pub groups: Vec<Group>,
    rows: Vec<u32>,
    /// The group of each column.
    owner: Vec<u32>,
    /// The column that stands for each row of the matrix.
    place: Vec<u32>,
    /// The row of the matrix that each column stands for.
    order: Vec<u32>,
}

/// Rows below a group that are columns of one other group.
pub(super) struct Run {
    /// That group.
    pub owner: usize,
    /// Their places among the rows.
    pub places: Range<usize>,
    /// For these and all later rows, their rows in the values of the other group.
    pub local: Vec<u32>,
}

impl Supernodes {
    pub fn new(cholesky: &SymbolicCholesky<u32>) -> Self {
        let n = cholesky.ncols();
        let (order, place) = match cholesky.perm() {
            Some(permutation) => {
                let (order, place) = permutation.arrays();
                (order.to_vec(), place.to_vec())
            }
            None => ((0..n as u32).collect(), (0..n as u32).collect()),
        };
        let (mut groups, mut rows, mut owner) = (vec![], vec![], vec![0; n]);
        let mut values = 0;
        let mut push = |first: usize, columns: usize, below: &[u32]| {
            let start = rows.len();
            rows.extend_from_slice(below);
            let end = values + (columns + below.len()) * columns;
            owner[first..first + columns].fill(groups.len() as u32);
            groups.push(Group { first, columns, rows: start..rows.len(), values: values..end });
            values = end;
        };
        match cholesky.raw() {
            SymbolicCholeskyRaw::Simplicial(structure) => {
                for (column, ends) in structure.col_ptr().windows(2).enumerate() {
                    // The diagonal is the first of each column.
                    push(column, 1, &structure.row_idx()[ends[0] as usize + 1..ends[1] as usize]);
                }
            }
            SymbolicCholeskyRaw::Supernodal(structure) => {
                for s in 0..structure.n_supernodes() {
                    let [first, end] = [structure.supernode_begin()[s], structure.supernode_end()[s]];
                    push(first as usize, (end - first) as usize, structure.supernode(s).pattern());
                }
            }
        }
        Self { groups, rows, owner, place, order }
    }

    /// Numbers in all groups.
    pub fn len(&self) -> usize {
        self.groups.last().map_or(0, |group| group.values.end)
    }

    /// The rows below a group, ascending.
    pub fn rows(&self, group: &Group) -> &[u32] {
        &self.rows[group.rows.clone()]
    }

    /// Most rows below a group.
    pub fn tallest(&self) -> usize {
        self.groups.iter().map(Group::below).max().unwrap_or(0)
    }

    /// Most numbers of a group.
    pub fn largest(&self) -> usize {
        self.groups.iter().map(|group| group.values.len()).max().unwrap_or(0)
    }

    /// The groups that own the rows below one, in order, each with the rows it owns.
    pub fn runs(&self, group: &Group) -> Vec<Run> {
        let rows = self.rows(group);
        let mut runs = vec![];
        let mut start = 0;
        while start < rows.len() {
            let owner = self.owner[rows[start] as usize] as usize;
            let other = &self.groups[owner];
            let end_column = other.first + other.columns;
            let end = start + rows[start..].partition_point(|&row| (row as usize) < end_column);
            let local = self.local(&rows[start..], other);
            runs.push(Run { owner, places: start..end, local });
            start = end;
        }
        runs
    }

    /// The group of the first row below one: its parent in the elimination tree.
    pub fn parent(&self, group: &Group) -> Option<usize> {
        self.rows(group).first().map(|&row| self.owner[row as usize] as usize)
    }

    /// Where rows stand among the columns and rows of a group that has them all; both ascend.
    pub fn local(&self, rows: &[u32], group: &Group) -> Vec<u32> {
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

    /// Where the value of two rows of the matrix stands, both ways round; `None` off the pattern of the
    /// factor.
    pub fn position(&self, row: usize, column: usize) -> Option<usize> {
        let [a, b] = [self.place[row] as usize, self.place[column] as usize];
        let (low, high) = (a.min(b), a.max(b));
        let group = &self.groups[self.owner[low] as usize];
        let height = group.columns + group.below();
        let local = match high - group.first {
            local if local < group.columns => local,
            _ => group.columns + self.rows(group).binary_search(&(high as u32)).ok()?,
        };
        Some(group.values.start + (low - group.first) * height + local)
    }

    /// The lower triangle of a matrix in the places of the groups, zeros elsewhere; all threads.
    pub fn scatter(&self, matrix: &SymmetricMatrix) -> Vec<f64> {
        let mut values = vec![0.0; self.len()];
        let (mut places, mut rest) = (vec![], &mut values[..]);
        for group in &self.groups {
            let (own, later) = rest.split_at_mut(group.values.len());
            places.push(own);
            rest = later;
        }
        self.groups.par_iter().zip(places).for_each(|(group, own)| self.fill(group, matrix, own));
        values
    }

    /// The same for one group.
    fn fill(&self, group: &Group, matrix: &SymmetricMatrix, own: &mut [f64]) {
        let (pattern, rows) = (matrix.pattern(), self.rows(group));
        let height = group.columns + rows.len();
        for (c, target) in own.chunks_exact_mut(height).enumerate() {
            let column = self.order[group.first + c] as usize;
            let entries = pattern.rows_of(column).iter().zip(&matrix.values()[pattern.range(column)]);
            for (&row, &value) in entries {
                let place = self.place[row as usize];
                match (place as usize).checked_sub(group.first) {
                    Some(local) if local >= group.columns => {
                        let at = rows.binary_search(&place).expect("a place of the factor");
                        target[group.columns + at] = value;
                    }
                    Some(local) if local >= c => target[local] = value,
                    // Above the diagonal.
                    _ => {}
                }
            }
        }
    }
}
