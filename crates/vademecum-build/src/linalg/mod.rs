//! Dense helpers that every stage shares: one generator of numbers, symmetric parts, matrices under serde.

mod eigen;
mod random;
pub(crate) mod stored;
pub mod vec3;

pub use eigen::{eigenvalues, solve_dense, symmetric_eigen};
pub use random::LoadDraw;
pub use random::Random;

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatMut, MatRef, Par};
use pulp::Arch;

use crate::parallel;

/// A dense decomposition that met what it cannot decompose.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "{what} did not converge: a number left the range of double precision; are units, materials, `time.step` and \
     ranges of a sensible size beside each other?"
)]
pub struct NoConvergence {
    /// The decomposition named in the message.
    pub what: &'static str,
}

/// `½ (A + Aᵀ)`, shape (n, n): what rounding took from a product that is symmetric in exact arithmetic.
pub(crate) fn symmetric_part(a: MatRef<'_, f64>) -> Mat<f64> {
    Mat::from_fn(a.nrows(), a.ncols(), |i, j| 0.5 * (a[(i, j)] + a[(j, i)]))
}

/// The symmetric matrix (n, n) of an upper triangle, row by row.
///
/// # Panics
/// If there are fewer numbers than places.
pub(crate) fn from_upper(triangle: &[f64], n: usize) -> Mat<f64> {
    let place = |i: usize, j: usize| i * (2 * n + 1 - i) / 2 + j - i;
    Mat::from_fn(n, n, |i, j| triangle[place(i.min(j), i.max(j))])
}

/// `v / ‖v‖`; NaN for a zero vector.
pub fn unit(v: [f64; 3]) -> [f64; 3] {
    let length = v.iter().map(|x| x * x).sum::<f64>().sqrt();
    v.map(|x| x / length)
}

/// `VᵀF`, length r: what a force over the rows of `V` does along its columns.
pub fn project(vectors: MatRef<'_, f64>, force: &[f64]) -> Vec<f64> {
    let along = |k| match vectors.col(k).try_as_col_major() {
        Some(vector) => dot(vector.as_slice(), force),
        None => force.iter().enumerate().map(|(i, f)| f * vectors[(i, k)]).sum(),
    };
    (0..vectors.ncols()).map(along).collect()
}

/// `aᵀb`: sums side by side, on the longest vectors of the machine.
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    const SUMS: usize = 16;
    Arch::new().dispatch(
        #[inline(always)]
        || {
            let (a, last_a) = a.as_chunks::<SUMS>();
            let (b, last_b) = b.as_chunks::<SUMS>();
            let mut sums = [0.0; SUMS];
            for (a, b) in a.iter().zip(b) {
                for s in 0..SUMS {
                    sums[s] += a[s] * b[s];
                }
            }
            let last: f64 = last_a.iter().zip(last_b).map(|(a, b)| a * b).sum();
            sums.iter().sum::<f64>() + last
        },
    )
}

/// Rows of a tall matrix that one thread works on at a time.
pub(crate) const TALL: usize = 4096;

/// `VᵀX` of two tall matrices, shape (columns of `V`, columns of `X`): all threads, summed in one order.
pub(crate) fn transposed_product(v: MatRef<'_, f64>, x: MatRef<'_, f64>) -> Mat<f64> {
    let part = |at: usize| {
        let first = at * TALL;
        let height = TALL.min(v.nrows() - first);
        let mut part = Mat::zeros(v.ncols(), x.ncols());
        let (v, x) = (v.subrows(first, height), x.subrows(first, height));
        matmul(part.as_mut(), Accum::Replace, v.transpose(), x, 1.0, Par::Seq);
        part
    };
    let parts = parallel::map(v.nrows().div_ceil(TALL), &part);
    let zero = Mat::zeros(v.ncols(), x.ncols());
    parts.into_iter().fold(zero, |sum, part| sum + part)
}

/// `A B`; all threads.
pub(crate) fn product(a: MatRef<'_, f64>, b: MatRef<'_, f64>) -> Mat<f64> {
    let mut c = Mat::zeros(a.nrows(), b.ncols());
    by_rows(c.as_mut(), a.ncols(), |first, rows| {
        let a = a.subrows(first, rows.nrows());
        matmul(rows, Accum::Replace, a, b, 1.0, Par::Seq);
    });
    c
}

/// `A B` on one thread: the bits do not depend on the number of threads.
pub fn sequential_product(a: MatRef<'_, f64>, b: MatRef<'_, f64>) -> Mat<f64> {
    let mut c = Mat::zeros(a.nrows(), b.ncols());
    matmul(c.as_mut(), Accum::Replace, a, b, 1.0, Par::Seq);
    c
}

/// `X ← X − V C` for tall `X` and `V`; all threads.
pub(crate) fn subtract_product(x: MatMut<'_, f64>, v: MatRef<'_, f64>, c: MatRef<'_, f64>) {
    parallel::for_each_of(row_groups(x, TALL), &|at, rows| {
        let v = v.subrows(at * TALL, rows.nrows());
        matmul(rows, Accum::Add, v, c, -1.0, Par::Seq);
    });
}

/// A tall matrix that grows by columns. Pages are touched as columns come to them, and columns move only
/// where there is no more room.
pub(crate) struct Columns {
    matrix: Mat<f64>,
    room: usize,
}

impl Columns {
    /// No column yet; room for some of `n` rows.
    pub(crate) fn with_room(n: usize, room: usize) -> Self {
        let mut matrix = Mat::with_capacity(n, room);
        matrix.resize_with(n, 0, |_, _| 0.0);
        Self { matrix, room }
    }

    /// Copies columns behind those that are there.
    pub(crate) fn append(&mut self, columns: MatRef<'_, f64>) {
        let (n, old) = (self.matrix.nrows(), self.matrix.ncols());
        let new = old + columns.ncols();
        if new > self.room {
            self.room = 2 * new;
            self.matrix.reserve(n, self.room);
        }
        self.matrix.resize_with(n, new, |i, j| columns[(i, j - old)]);
    }

    pub(crate) fn as_ref(&self) -> MatRef<'_, f64> {
        self.matrix.as_ref()
    }
}

/// A matrix in groups of `width` columns, the last one of what is left: for threads that each write their
/// own.
pub(crate) fn column_groups(mut x: MatMut<'_, f64>, width: usize) -> Vec<MatMut<'_, f64>> {
    let mut groups = vec![];
    while x.ncols() > width {
        let (group, rest) = x.split_at_col_mut(width);
        groups.push(group);
        x = rest;
    }
    groups.push(x);
    groups
}

/// The same by rows, `height` at a time.
pub(crate) fn row_groups<T>(mut x: MatMut<'_, T>, height: usize) -> Vec<MatMut<'_, T>> {
    let mut groups = vec![];
    while x.nrows() > height {
        let (group, rest) = x.split_at_row_mut(height);
        groups.push(group);
        x = rest;
    }
    groups.push(x);
    groups
}

/// Rows of a product that one thread computes at a time, at least.
pub(crate) const HEIGHT: usize = 128;
/// Parts of a product of more rows: each of them reads the whole other factor.
const PARTS: usize = 16;
/// Multiplications below which a product is not shared among threads.
pub(crate) const SHARED: f64 = 1e6;

/// Some rows of a matrix at a time, with the first of them; `inner` multiplications make an entry. Threads
/// share them where there is enough to do.
pub(crate) fn by_rows<T: Send + Sync>(
    c: MatMut<'_, T>,
    inner: usize,
    task: impl Fn(usize, MatMut<'_, T>) + Sync,
) {
    let work = c.nrows() as f64 * c.ncols() as f64 * inner as f64;
    let height = HEIGHT.max(c.nrows().div_ceil(PARTS));
    let groups = row_groups(c, height);
    if work > SHARED {
        parallel::for_each_of(groups, &|at, rows| task(at * height, rows));
    } else {
        groups.into_iter().enumerate().for_each(|(at, rows)| task(at * height, rows));
    }
}
