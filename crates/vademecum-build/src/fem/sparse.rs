//! Symmetric sparse matrices that share one pattern.
//!
//! Mass and stiffness of all regions have the same nonzero places, so the pattern is stored once and a matrix
//! is a vector of values on it. Both triangles are kept: a column is then also a row, and a product is a
//! gather that runs in parallel over rows with no sums across threads, hence the same bits for any number of
//! threads.
//!
//! If ranks share the work on a body, each has some rows of a matrix. Products are then made there, and
//! whatever asks for entries has the matrix assembled here.

use std::cell::Cell;
use std::sync::{Arc, OnceLock};

use faer::prelude::ReborrowMut;
use faer::sparse::SymbolicSparseColMatRef;
use faer::{Mat, MatMut, MatRef};
use pulp::Arch;

use super::late::Lazy;
use super::spread::SpreadMatrix;
use crate::linalg::row_groups;
use crate::parallel;

/// Rows one parallel task handles: some 100 µs of work, far above the cost of handing a task over.
const ROW_CHUNK: usize = 2048;

/// Columns that a product handles per pass over the matrix, and a solve over the factor, at most. The sums of
/// a product fit the vector registers, and are enough of them that none waits for the one before.
pub const AT_ONCE: usize = 24;

/// Nonzero places of a symmetric `(n, n)` matrix, both triangles, rows sorted within a column.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pattern {
    column_starts: Vec<u32>,
    rows: Vec<u32>,
}

impl Pattern {
    /// Wraps the two arrays of a compressed-column pattern.
    ///
    /// The caller guarantees symmetry, sorted rows and a place for every diagonal entry.
    pub(crate) fn new(column_starts: Vec<u32>, rows: Vec<u32>) -> Pattern {
        debug_assert_eq!(*column_starts.last().unwrap_or(&0) as usize, rows.len());
        Pattern { column_starts, rows }
    }

    /// Number of rows and columns.
    pub fn n(&self) -> usize {
        self.column_starts.len() - 1
    }

    /// Number of stored places, both triangles and the diagonal.
    pub(crate) fn n_stored(&self) -> usize {
        self.rows.len()
    }

    /// Range of column `j` in the value array.
    pub fn range(&self, j: usize) -> std::ops::Range<usize> {
        self.column_starts[j] as usize..self.column_starts[j + 1] as usize
    }

    /// Row indices of column `j`, ascending.
    pub fn rows_of(&self, j: usize) -> &[u32] {
        &self.rows[self.range(j)]
    }

    /// Starts of the columns, and rows.
    pub(super) fn arrays(&self) -> [&[u32]; 2] {
        [&self.column_starts, &self.rows]
    }

    /// The pattern as faer reads it; checked in one pass over the indices.
    pub(crate) fn as_faer(&self) -> SymbolicSparseColMatRef<'_, u32> {
        SymbolicSparseColMatRef::new_checked(self.n(), self.n(), &self.column_starts, None, &self.rows)
    }
}

/// A symmetric matrix: values on a shared [`Pattern`], or rows on several ranks. Its copies share them too.
#[derive(Clone, Debug)]
pub struct SymmetricMatrix(Entries);

/// Storage of the entries of a matrix.
#[derive(Clone, Debug)]
enum Entries {
    Here(Arc<Pattern>, Arc<Vec<f64>>, Arc<OnceLock<Option<NonZero>>>),
    /// On the ranks; here only once something needs them here.
    Distributed(Arc<dyn SpreadMatrix>, Arc<Lazy<SymmetricMatrix>>),
}

/// The entries of a matrix that are not zero, where they are few compared with the places of its pattern: a
/// mass couples no two components, so two thirds of its places hold zeros.
#[derive(Clone, Debug)]
struct NonZero {
    pattern: Pattern,
    values: Vec<f64>,
}

impl NonZero {
    /// Absent where more than half of the places are taken.
    fn of(pattern: &Pattern, values: &[f64]) -> Option<NonZero> {
        let count = values.iter().filter(|&&value| value != 0.0).count();
        if 2 * count > values.len() {
            return None;
        }
        let mut found = NonZero {
            pattern: Pattern { column_starts: vec![0], rows: Vec::with_capacity(count) },
            values: Vec::with_capacity(count),
        };
        for j in 0..pattern.n() {
            let column = pattern.rows_of(j).iter().zip(&values[pattern.range(j)]);
            for (&row, &value) in column.filter(|&(_, &value)| value != 0.0) {
                found.pattern.rows.push(row);
                found.values.push(value);
            }
            found.pattern.column_starts.push(found.values.len() as u32);
        }
        Some(found)
    }
}

impl SymmetricMatrix {
    /// Joins values, in the pattern's order, to their pattern.
    pub(crate) fn new(pattern: Arc<Pattern>, values: Vec<f64>) -> SymmetricMatrix {
        assert_eq!(pattern.n_stored(), values.len());
        SymmetricMatrix(Entries::Here(pattern, Arc::new(values), Arc::default()))
    }

    /// A matrix whose rows lie on the ranks, and how to have it here.
    pub(super) fn spread_over(
        rows: Arc<dyn SpreadMatrix>,
        here: impl Fn() -> SymmetricMatrix + Send + Sync + 'static,
    ) -> Self {
        SymmetricMatrix(Entries::Distributed(rows, Arc::new(Lazy::new(here))))
    }

    /// Number of rows and columns.
    pub fn n(&self) -> usize {
        match &self.0 {
            Entries::Here(pattern, ..) => pattern.n(),
            Entries::Distributed(rows, ..) => rows.diagonal().len(),
        }
    }

    /// The rows on the ranks, if they lie there.
    pub(super) fn spread(&self) -> Option<&Arc<dyn SpreadMatrix>> {
        match &self.0 {
            Entries::Here(..) => None,
            Entries::Distributed(rows, ..) => Some(rows),
        }
    }

    /// The entries in this process, assembled if they are not there yet.
    fn here(&self) -> (&Arc<Pattern>, &Arc<Vec<f64>>) {
        match &self.0 {
            Entries::Here(pattern, values, _) => (pattern, values),
            Entries::Distributed(_, here) => here.get().here(),
        }
    }

    /// The shared pattern; of rows on ranks, the matrix is assembled here.
    pub fn pattern(&self) -> &Arc<Pattern> {
        self.here().0
    }

    /// Values in the order of the pattern, both triangles; as [`SymmetricMatrix::pattern`].
    pub fn values(&self) -> &[f64] {
        self.here().1
    }

    /// True if two matrices have the same values, on one pattern.
    pub(super) fn is_same(&self, other: &SymmetricMatrix) -> bool {
        match (&self.0, &other.0) {
            (Entries::Here(_, own, _), Entries::Here(_, other, _)) => Arc::ptr_eq(own, other) || own == other,
            (Entries::Distributed(own, ..), Entries::Distributed(other, ..)) => Arc::ptr_eq(own, other),
            _ => false,
        }
    }

    /// Entry `(row, column)`; `None` where the pattern has no place.
    pub(crate) fn get(&self, row: usize, column: usize) -> Option<f64> {
        let (pattern, values) = self.here();
        let at = pattern.rows_of(column).binary_search(&(row as u32)).ok()?;
        Some(values[pattern.range(column).start + at])
    }

    /// Diagonal entry `j`.
    pub fn diagonal(&self, j: usize) -> f64 {
        match &self.0 {
            Entries::Here(..) => self.get(j, j).unwrap_or(0.0),
            Entries::Distributed(rows, ..) => rows.diagonal()[j],
        }
    }

    /// The same matrix with `stiffness` added to the diagonal at each `(dof, stiffness)`.
    pub(crate) fn with_springs(&self, springs: &[(usize, f64)]) -> SymmetricMatrix {
        let (pattern, mut values) = (self.pattern(), self.values().to_vec());
        for &(dof, stiffness) in springs {
            let at = pattern.rows_of(dof).binary_search(&(dof as u32));
            values[pattern.range(dof).start + at.expect("a diagonal entry")] += stiffness;
        }
        SymmetricMatrix::new(pattern.clone(), values)
    }

    /// True if every entry off the diagonal is zero.
    pub(crate) fn is_diagonal(&self) -> bool {
        let (pattern, values) = self.here();
        (0..self.n()).all(|j| {
            let mut column = pattern.rows_of(j).iter().zip(&values[pattern.range(j)]);
            column.all(|(&i, &value)| i as usize == j || value == 0.0)
        })
    }

    /// `Σ_i w_i A_i` on the common pattern, summed in the given order.
    ///
    /// # Panics
    /// If `parts` is empty or the matrices do not share one pattern.
    pub fn combine(parts: &[(f64, &SymmetricMatrix)]) -> SymmetricMatrix {
        if let [(weight, only)] = *parts
            && weight == 1.0
        {
            return only.clone();
        }
        let pattern = parts[0].1.pattern();
        let mut values = vec![0.0; pattern.n_stored()];
        for &(weight, matrix) in parts {
            assert!(Arc::ptr_eq(pattern, matrix.pattern()));
            for (sum, &value) in values.iter_mut().zip(matrix.values()) {
                *sum += weight * value;
            }
        }
        SymmetricMatrix::new(pattern.clone(), values)
    }

    /// `y ← A x` for `x` and `y` of shape `(n, c)`, column-major with contiguous columns.
    ///
    /// Parallel over rows, the same bits for any number of threads. A thread keeps memory for 24 columns from
    /// its first product to its next, and a matrix of few entries has them once more without its zeros.
    ///
    /// # Panics
    /// If the shapes differ.
    pub fn mul_into(&self, x: MatRef<'_, f64>, y: MatMut<'_, f64>) {
        match &self.0 {
            Entries::Here(pattern, values, few) => {
                // What is left out are products with zeros.
                let (pattern, values) = match few.get_or_init(|| NonZero::of(pattern, values)) {
                    Some(few) => (&few.pattern, &few.values),
                    None => (&**pattern, &**values),
                };
                mul_rows(pattern, [(values.as_slice(), x)], y);
            }
            Entries::Distributed(rows, ..) => rows.mul_into(x, y),
        }
    }

    /// `y ← A x`, shapes as of [`SymmetricMatrix::mul_into`], each row summed in twice the working precision
    /// and rounded once. Column by column, and some ten times slower.
    ///
    /// # Panics
    /// If the shapes differ.
    pub(super) fn mul_closely_into(&self, x: MatRef<'_, f64>, mut y: MatMut<'_, f64>) {
        let (pattern, values) = self.here();
        for c in 0..x.ncols() {
            let x = contiguous(x, c);
            let row = |i: usize| {
                let range = pattern.range(i);
                let row = pattern.rows[range.clone()].iter().zip(&values[range]);
                dot_closely(row.map(|(&j, &a)| (a, x[j as usize])))
            };
            let y = contiguous_mut(y.rb_mut(), c);
            parallel::for_each_of(y.chunks_mut(ROW_CHUNK), &|chunk, y| {
                y.iter_mut().zip(chunk * ROW_CHUNK..).for_each(|(y, i)| *y = row(i));
            });
        }
    }

    /// `y ← A x + B z` in one pass over the common pattern: one read of the indices for both products.
    ///
    /// # Panics
    /// If the shapes differ or the matrices do not share one pattern.
    pub fn mul_pair_into(
        &self,
        x: MatRef<'_, f64>,
        other: &SymmetricMatrix,
        z: MatRef<'_, f64>,
        y: MatMut<'_, f64>,
    ) {
        let ((pattern, own), (same, others)) = (self.here(), other.here());
        assert!(Arc::ptr_eq(pattern, same));
        mul_rows(pattern, [(own.as_slice(), x), (others.as_slice(), z)], y);
    }

    /// `xᵀ A y` of two columns, summed in row order.
    pub fn inner(&self, x: &[f64], y: &[f64]) -> f64 {
        let n = self.n();
        assert!(x.len() == n && y.len() == n);
        let Entries::Here(pattern, values, _) = &self.0 else {
            let mut image = Mat::zeros(n, 1);
            self.mul_into(MatRef::from_column_major_slice(y, n, 1), image.as_mut());
            return x.iter().zip(image.col_as_slice(0)).map(|(x, y)| x * y).sum();
        };
        (0..n)
            .map(|i| {
                let range = pattern.range(i);
                let row = pattern.rows[range.clone()].iter().zip(&values[range]);
                x[i] * row.map(|(&j, &a)| a * y[j as usize]).sum::<f64>()
            })
            .sum()
    }
}

/// A sum of products in twice the working precision (Ogita, Rump and Oishi 2005, algorithm 5.3, with the
/// products split after Dekker 1971).
fn dot_closely(factors: impl Iterator<Item = (f64, f64)>) -> f64 {
    let split = |a: f64| {
        let c = 134_217_729.0 * a;
        let high = c - (c - a);
        (high, a - high)
    };
    let (mut sum, mut rest) = (0.0, 0.0);
    for (a, b) in factors {
        let product = a * b;
        let ((ah, al), (bh, bl)) = (split(a), split(b));
        let of_product = ((ah * bh - product) + ah * bl + al * bh) + al * bl;
        let new = sum + product;
        let back = new - sum;
        let of_sum = (sum - (new - back)) + (product - back);
        sum = new;
        rest += of_product + of_sum;
    }
    sum + rest
}

/// Sum of `N` products on one pattern, split over rows.
fn mul_rows<const N: usize>(
    pattern: &Pattern,
    parts: [(&[f64], MatRef<'_, f64>); N],
    mut y: MatMut<'_, f64>,
) {
    assert_eq!(y.nrows(), pattern.n());
    for (_, x) in &parts {
        assert!(x.nrows() == pattern.n() && x.ncols() == y.ncols());
    }
    let mut turned = TURNED.take();
    let mut first = 0;
    while first < y.ncols() {
        // Eights, where there is no kernel for what is left.
        let width = match y.ncols() - first {
            AT_ONCE.. => AT_ONCE,
            left @ ..8 => left,
            left => left / 8 * 8,
        };
        let out = y.rb_mut().subcols_mut(first, width);
        mul_group(pattern, parts.map(|(values, x)| (values, x.subcols(first, width))), &mut turned, out);
        first += width;
    }
    TURNED.set(turned);
}

thread_local! {
    /// The right factors row by row, for the next product of this thread.
    static TURNED: Cell<Vec<f64>> = const { Cell::new(vec![]) };
}

/// Picks the kernel for the number of columns.
fn mul_group<const N: usize>(
    pattern: &Pattern,
    parts: [(&[f64], MatRef<'_, f64>); N],
    turned: &mut Vec<f64>,
    y: MatMut<'_, f64>,
) {
    match y.ncols() {
        1 => mul_columns::<N, 1>(pattern, parts, turned, y),
        2 => mul_columns::<N, 2>(pattern, parts, turned, y),
        3 => mul_columns::<N, 3>(pattern, parts, turned, y),
        4 => mul_columns::<N, 4>(pattern, parts, turned, y),
        5 => mul_columns::<N, 5>(pattern, parts, turned, y),
        6 => mul_columns::<N, 6>(pattern, parts, turned, y),
        7 => mul_columns::<N, 7>(pattern, parts, turned, y),
        8 => mul_columns::<N, 8>(pattern, parts, turned, y),
        16 => mul_columns::<N, 16>(pattern, parts, turned, y),
        _ => mul_columns::<N, AT_ONCE>(pattern, parts, turned, y),
    }
}

/// The kernel: `y[i, :] = Σ_parts Σ_j a_ij x[j, :]`, `C` columns at once.
///
/// An entry of the matrix meets `C` numbers of one row of `x`, so these are laid side by side first: one line
/// of memory is then read where there were `C`.
fn mul_columns<const N: usize, const C: usize>(
    pattern: &Pattern,
    parts: [(&[f64], MatRef<'_, f64>); N],
    turned: &mut Vec<f64>,
    y: MatMut<'_, f64>,
) {
    let n = pattern.n();
    turned.resize((N * n * C).max(turned.len()), 0.0);
    let (rows, _) = turned.as_chunks_mut::<C>();
    for (part, (_, x)) in parts.iter().enumerate() {
        let columns: [&[f64]; C] = std::array::from_fn(|c| contiguous(*x, c));
        let rows = &mut rows[part * n..(part + 1) * n];
        parallel::for_each_of(rows.chunks_mut(ROW_CHUNK), &|chunk, rows| {
            let first = chunk * ROW_CHUNK;
            let cut = columns.map(|column| &column[first..first + rows.len()]);
            for (at, row) in rows.iter_mut().enumerate() {
                *row = cut.map(|column| column[at]);
            }
        });
    }
    let right: [(&[f64], &[[f64; C]]); N] =
        std::array::from_fn(|part| (parts[part].0, &rows[part * n..(part + 1) * n]));
    // A product and a sum stay two roundings, whatever the vectors.
    let arch = Arch::new();
    parallel::for_each_of(row_groups(y, ROW_CHUNK), &|chunk, y| {
        arch.dispatch(
            #[inline(always)]
            || mul_chunk(pattern, chunk * ROW_CHUNK, right, y),
        );
    });
}

/// The rows of a product from `first` on.
#[inline(always)]
fn mul_chunk<const N: usize, const C: usize>(
    pattern: &Pattern,
    first: usize,
    right: [(&[f64], &[[f64; C]]); N],
    mut y: MatMut<'_, f64>,
) {
    for local in 0..y.nrows() {
        let range = pattern.range(first + local);
        let mut sums = [0.0; C];
        for (place, &j) in range.clone().zip(&pattern.rows[range]) {
            for (values, x) in right {
                let (a, x) = (values[place], &x[j as usize]);
                for c in 0..C {
                    sums[c] += a * x[c];
                }
            }
        }
        for c in 0..C {
            y[(local, c)] = sums[c];
        }
    }
}

/// Column `c` as a slice.
pub(crate) fn contiguous<'a>(x: MatRef<'a, f64>, c: usize) -> &'a [f64] {
    x.col(c).try_as_col_major().expect("columns are contiguous").as_slice()
}

/// Column `c` as a mutable slice.
pub(crate) fn contiguous_mut<'a>(x: MatMut<'a, f64>, c: usize) -> &'a mut [f64] {
    x.col_mut(c).try_as_col_major_mut().expect("columns are contiguous").as_slice_mut()
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use faer::Mat;

    use super::{NonZero, Pattern, SymmetricMatrix, dot_closely};

    #[test]
    fn zeros_on_the_pattern_are_left_out_of_products() {
        // Couples the first with the last of three alone; all nine places are there.
        let pattern = Arc::new(Pattern::new(vec![0, 3, 6, 9], vec![0, 1, 2, 0, 1, 2, 0, 1, 2]));
        let sparse = vec![2.0, 0.0, -1.0, 0.0, 0.0, 0.0, -1.0, 0.0, 5.0];
        let few = NonZero::of(&pattern, &sparse).expect("four of nine places");
        assert_eq!((few.pattern.rows, few.values), (vec![0, 2, 0, 2], vec![2.0, -1.0, -1.0, 5.0]));
        assert_eq!(few.pattern.column_starts, [0, 2, 2, 4]);
        let full: Vec<f64> = sparse.iter().map(|value| if *value == 0.0 { 1.0 } else { *value }).collect();
        assert!(NonZero::of(&pattern, &full).is_none());
        for (values, expected) in [(sparse, [-1.0, 0.0, 14.0]), (full, [1.0, 6.0, 16.0])] {
            let x = Mat::from_fn(3, 2, |i, j| (i + 1) as f64 * (j + 1) as f64);
            let mut y = Mat::zeros(3, 2);
            SymmetricMatrix::new(pattern.clone(), values).mul_into(x.as_ref(), y.as_mut());
            for j in 0..2 {
                assert_eq!(y.col_as_slice(j), expected.map(|value| (j + 1) as f64 * value));
            }
        }
    }

    #[test]
    fn what_cancels_is_summed_in_twice_the_precision() {
        // 1e16 (1 + ε) − 1e16 − 1e16 ε + 3: nothing of the 3 survives a plain sum.
        let large = 1e16_f64;
        let factors =
            [(large, 1.0 + f64::EPSILON), (0.1, 0.1), (-large, 1.0), (-large, f64::EPSILON), (3.0, 1.0)];
        let plain: f64 = factors.iter().map(|(a, b)| a * b).sum();
        let close = dot_closely(factors.into_iter());
        let exact = 3.01;
        assert!((close - exact).abs() < 1e-14 && (plain - exact).abs() > 1e-3, "{close} {plain}");
    }
}
