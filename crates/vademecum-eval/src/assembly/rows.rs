//! Rows of joints over the rows of ports, in lent memory: a compliance, and terms of a part, a row of its
//! ports and a weight.

use crate::kernels::dense::{at, row, set};

/// Most terms of a row: three of the first port, three for each node of a facet of the second.
const TERMS: usize = 3 + 3 * vademecum_format::PORT_FACET_NODES;

/// Numbers of a row: compliance, number of terms, and the terms.
pub(crate) const ROW: usize = 2 + 3 * TERMS;

/// Rows of all joints.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rows<'m> {
    numbers: &'m [f64],
}

impl<'m> Rows<'m> {
    /// Rows that a [`RowWriter`] wrote.
    pub const fn new(numbers: &'m [f64]) -> Self {
        Self { numbers }
    }

    /// Number of rows.
    pub const fn len(&self) -> usize {
        self.numbers.len() / ROW
    }

    /// Compliance \[m/N\]; 0 of rows that hold.
    pub fn compliance(&self, i: usize) -> f64 {
        at(row(self.numbers, i, ROW), 0)
    }

    /// Part, row of its ports and weight of each term.
    pub fn terms(&self, i: usize) -> impl Iterator<Item = (usize, usize, f64)> + Clone + use<'m> {
        let own = row(self.numbers, i, ROW);
        let count = at(own, 1) as usize;
        let terms = own.get(2..).unwrap_or_default().as_chunks::<3>().0;
        terms.iter().take(count).map(|&[part, row, weight]| (part as usize, row as usize, weight))
    }
}

/// Writes rows one after the other.
#[derive(Debug)]
pub(crate) struct RowWriter<'m> {
    numbers: &'m mut [f64],
    count: usize,
}

impl<'m> RowWriter<'m> {
    /// Rows in these numbers, [`ROW`] each.
    pub fn new(numbers: &'m mut [f64]) -> Self {
        numbers.fill(0.0);
        Self { numbers, count: 0 }
    }

    /// Begins a row.
    pub fn begin(&mut self, compliance: f64) {
        set(self.numbers, self.count * ROW, compliance);
        self.count += 1;
    }

    /// Adds a term to the row begun last; weights of 0 are left out.
    pub fn term(&mut self, part: usize, port_row: usize, weight: f64) {
        let Some(start) = self.count.checked_sub(1).map(|i| i * ROW) else { return };
        let n = at(self.numbers, start + 1) as usize;
        if weight == 0.0 || n >= TERMS {
            return;
        }
        for (k, value) in [part as f64, port_row as f64, weight].into_iter().enumerate() {
            set(self.numbers, start + 2 + 3 * n + k, value);
        }
        set(self.numbers, start + 1, (n + 1) as f64);
    }
}
