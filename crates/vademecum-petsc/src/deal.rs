//! Rows of a matrix, dealt to ranks.

use std::ops::Range;

use vademecum_build::fem::{EngineError, SymmetricMatrix};

use crate::ranks::Ranks;

/// Rows of a rank in the order in which they are dealt.
pub struct Share {
    /// Where each row starts, and the end.
    pub starts: Vec<i64>,
    /// Columns by the same order, ascending in each row.
    pub columns: Vec<i64>,
    /// Values.
    pub values: Vec<f64>,
    /// The row of the whole matrix that each own row is.
    pub places: Vec<i64>,
}

/// An order of rows, both ways.
pub struct Order {
    /// The row of the matrix at each place.
    pub row: Vec<u32>,
    /// The place of each row of the matrix.
    place: Vec<u32>,
}

impl Order {
    /// From the row at each place.
    pub fn new(row: &[u32]) -> Self {
        let mut place = vec![0; row.len()];
        row.iter().enumerate().for_each(|(at, &row)| place[row as usize] = at as u32);
        Self { row: row.to_vec(), place }
    }

    /// The rows at some places.
    pub fn share(&self, matrix: &SymmetricMatrix, places: Range<usize>) -> Share {
        let pattern = matrix.pattern();
        let own = &self.row[places];
        let entries = own.iter().map(|&row| pattern.rows_of(row as usize).len()).sum();
        let mut share = Share {
            starts: vec![0],
            columns: Vec::with_capacity(entries),
            values: Vec::with_capacity(entries),
            places: own.iter().map(|&row| row.into()).collect(),
        };
        let mut entries: Vec<(u32, f64)> = vec![];
        for &row in own {
            // A column of a symmetric matrix is its row.
            let columns = pattern.rows_of(row as usize).iter().map(|&column| self.place[column as usize]);
            entries.clear();
            entries.extend(columns.zip(matrix.values()[pattern.range(row as usize)].iter().copied()));
            entries.sort_unstable_by_key(|&(column, _)| column);
            share.columns.extend(entries.iter().map(|&(column, _)| i64::from(column)));
            share.values.extend(entries.iter().map(|&(_, value)| value));
            share.starts.push(share.columns.len() as i64);
        }
        share
    }
}

impl Share {
    /// Sends it all.
    pub fn send(&self, ranks: &Ranks, to: usize) -> Result<(), EngineError> {
        ranks.send_list(&self.starts, to)?;
        ranks.send_list(&self.columns, to)?;
        ranks.send_list(&self.values, to)?;
        ranks.send_list(&self.places, to)
    }

    /// Receives it.
    pub fn receive(ranks: &Ranks, from: usize) -> Result<Self, EngineError> {
        Ok(Self {
            starts: ranks.receive_list(from)?,
            columns: ranks.receive_list(from)?,
            values: ranks.receive_list(from)?,
            places: ranks.receive_list(from)?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use vademecum_build::fem::Pencil;

    #[test]
    fn shares_are_the_rows_of_the_permuted_matrix() {
        let entries = [(0, 0, 1.0), (1, 1, 2.0), (2, 2, 3.0), (0, 2, 4.0), (2, 0, 4.0)];
        let pencil = Pencil::from_triplets(3, &entries, &entries).expect("a pencil");
        let order = Order::new(&[2, 1, 0]);
        let first = order.share(pencil.mass(), 0..1);
        assert_eq!((first.starts, first.columns), (vec![0, 2], vec![0, 2]));
        assert_eq!((first.values, first.places), (vec![3.0, 4.0], vec![2]));
        let rest = order.share(pencil.mass(), 1..3);
        assert_eq!((rest.starts, rest.columns), (vec![0, 1, 3], vec![1, 0, 2]));
        assert_eq!((rest.values, rest.places), (vec![2.0, 4.0, 1.0], vec![1, 0]));
    }
}
