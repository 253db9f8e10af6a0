//! Dense products and triangular solves for the few right-hand sides of a few loads.
//!
//! A factor that is larger than the caches is read from memory for them, and how it is read decides. Products
//! made for many columns read a line of each column of a block, then the next line; here four columns are
//! gone down together. Without fused products of the machine there are no kernels.

use faer::MatRef;
use pulp::{Arch, NullaryFnOnce};

use super::number::FactorScalar;

/// Columns of the left factor that are gone down together.
const STRIP: usize = 4;

/// Right-hand sides that the kernels take. Eight are as fast with products made for many columns.
const K: usize = 4;

/// Right-hand sides that a solve with a large factor takes for `k` of them. One alone is a product of its
/// own.
pub(super) fn padded(k: usize) -> usize {
    if (2..K).contains(&k) { K } else { k }
}

/// An operation with a block of a factor.
#[derive(Clone, Copy)]
pub(super) enum BlockKernel {
    /// `x ← x − A y`.
    Product,
    /// `x ← x − Aᵀ y`.
    Transposed,
    /// `x ← A⁻¹ x`, `A` lower triangular.
    Lower,
    /// `x ← A⁻ᵀ x`, `A` lower triangular.
    Upper,
}

impl BlockKernel {
    /// Does it, where there is a kernel for `k` right-hand sides; whether there is. `x` and `y` hold `k`
    /// numbers for each row.
    pub(crate) fn apply<T: FactorScalar>(self, x: &mut [T], a: MatRef<'_, T>, y: &[T], k: usize) -> bool {
        let arch = Arch::new();
        if k != K || matches!(arch, Arch::Scalar) {
            return false;
        }
        arch.dispatch(KernelCall { what: self, x: x.as_chunks_mut().0, a, y: y.as_chunks().0 });
        true
    }
}

/// One of them.
struct KernelCall<'a, T> {
    what: BlockKernel,
    x: &'a mut [[T; K]],
    a: MatRef<'a, T>,
    y: &'a [[T; K]],
}

impl<T: FactorScalar> NullaryFnOnce for KernelCall<'_, T> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let KernelCall { what, x, a, y } = self;
        match what {
            BlockKernel::Product => product(x, a, 0, y),
            BlockKernel::Transposed => transposed(x, a, 0, y),
            BlockKernel::Lower => lower(x, a),
            BlockKernel::Upper => upper(x, a),
        }
    }
}

/// Column `j` of `a` from a row on.
#[inline(always)]
fn column<'a, T: FactorScalar>(a: MatRef<'a, T>, j: usize, row: usize) -> &'a [T] {
    &a.col(j).try_as_col_major().expect("columns of a factor are contiguous").as_slice()[row..]
}

/// `x ← x − A y`, the rows of `A` from `row` on.
#[inline(always)]
fn product<T: FactorScalar>(x: &mut [[T; K]], a: MatRef<'_, T>, row: usize, y: &[[T; K]]) {
    let (strips, rest) = y.as_chunks::<STRIP>();
    for (strip, y) in strips.iter().enumerate() {
        let columns: [&[T]; STRIP] = std::array::from_fn(|s| column(a, STRIP * strip + s, row));
        let columns = columns.map(|column| &column[..x.len()]);
        let minus = y.map(|y| y.map(|y| -y));
        for (r, x) in x.iter_mut().enumerate() {
            for s in 0..STRIP {
                for c in 0..K {
                    x[c] = columns[s][r].fused(minus[s][c], x[c]);
                }
            }
        }
    }
    for (y, j) in rest.iter().zip(STRIP * strips.len()..) {
        for (x, &a) in x.iter_mut().zip(column(a, j, row)) {
            for c in 0..K {
                x[c] = a.fused(-y[c], x[c]);
            }
        }
    }
}

/// `x ← x − Aᵀ y`, the rows of `A` from `row` on.
#[inline(always)]
fn transposed<T: FactorScalar>(x: &mut [[T; K]], a: MatRef<'_, T>, row: usize, y: &[[T; K]]) {
    let (strips, rest) = x.as_chunks_mut::<STRIP>();
    let n_strips = strips.len();
    for (strip, x) in strips.iter_mut().enumerate() {
        let columns: [&[T]; STRIP] = std::array::from_fn(|s| column(a, STRIP * strip + s, row));
        let columns = columns.map(|column| &column[..y.len()]);
        let mut sums = [[T::nearest(0.0); K]; STRIP];
        for (r, y) in y.iter().enumerate() {
            for s in 0..STRIP {
                for c in 0..K {
                    sums[s][c] = columns[s][r].fused(y[c], sums[s][c]);
                }
            }
        }
        for s in 0..STRIP {
            for c in 0..K {
                x[s][c] -= sums[s][c];
            }
        }
    }
    for (x, j) in rest.iter_mut().zip(STRIP * n_strips..) {
        let mut sums = [T::nearest(0.0); K];
        for (y, &a) in y.iter().zip(column(a, j, row)) {
            for c in 0..K {
                sums[c] = a.fused(y[c], sums[c]);
            }
        }
        for c in 0..K {
            x[c] -= sums[c];
        }
    }
}

/// `x ← A⁻¹ x`, `A` lower triangular.
#[inline(always)]
fn lower<T: FactorScalar>(x: &mut [[T; K]], a: MatRef<'_, T>) {
    for first in (0..x.len()).step_by(STRIP) {
        let end = x.len().min(first + STRIP);
        let (own, later) = x.split_at_mut(end);
        let own = &mut own[first..];
        for j in 0..own.len() {
            let below = column(a, first + j, first);
            for c in 0..K {
                own[j][c] /= below[j];
                for i in j + 1..own.len() {
                    own[i][c] = below[i].fused(-own[j][c], own[i][c]);
                }
            }
        }
        product(later, a.subcols(first, own.len()), end, own);
    }
}

/// `x ← A⁻ᵀ x`, `A` lower triangular.
#[inline(always)]
fn upper<T: FactorScalar>(x: &mut [[T; K]], a: MatRef<'_, T>) {
    for first in (0..x.len()).step_by(STRIP).rev() {
        let end = x.len().min(first + STRIP);
        let (own, later) = x.split_at_mut(end);
        let own = &mut own[first..];
        transposed(own, a.subcols(first, own.len()), end, later);
        for j in (0..own.len()).rev() {
            let below = column(a, first + j, first);
            for c in 0..K {
                for i in j + 1..own.len() {
                    own[j][c] = below[i].fused(-own[i][c], own[j][c]);
                }
                own[j][c] /= below[j];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use faer::Mat;

    use super::*;
    use crate::linalg::Random;

    #[test]
    fn kernels_do_what_dense_algebra_does() {
        let k = K;
        let mut random = Random::new(5);
        // Strips of four with and without a rest.
        for (rows, columns) in [(1, 1), (4, 4), (7, 3), (9, 8), (3, 6), (130, 130)] {
            let mut draw = |n: usize| (0..n * k).map(|_| random.uniform() - 0.5).collect::<Vec<f64>>();
            let (tall, wide) = (draw(rows), draw(columns));
            // Far from singular where it is taken for a triangle.
            let a = Mat::from_fn(rows, columns, |i, j| {
                if i == j { 2.0 } else { (1.0 + (3 * i + 7 * j) as f64).sin() / 20.0 }
            });
            let l = Mat::from_fn(rows, rows, |i, j| if j <= i && j < columns { a[(i, j)] } else { 0.0 });
            let dense = |x: &[f64], n: usize| Mat::from_fn(n, k, |i, c| x[i * k + c]);
            let check = |what: BlockKernel, x: &[f64], y: &[f64], a: MatRef<'_, f64>, answer: Mat<f64>| {
                let mut found = x.to_vec();
                assert!(what.apply(&mut found, a, y, k));
                let error = (dense(&found, answer.nrows()) - &answer).norm_max();
                assert!(error < 1e-14 * (1.0 + answer.norm_max()), "{rows} {columns} {k}: {error:e}");
            };
            let product = dense(&tall, rows) - &a * dense(&wide, columns);
            check(BlockKernel::Product, &tall, &wide, a.as_ref(), product);
            let product = dense(&wide, columns) - a.transpose() * dense(&tall, rows);
            check(BlockKernel::Transposed, &wide, &tall, a.as_ref(), product);
            if rows <= columns {
                let whole = a.get(..rows, ..rows);
                let image = &l * dense(&tall, rows);
                let image: Vec<f64> = (0..rows * k).map(|at| image[(at / k, at % k)]).collect();
                check(BlockKernel::Lower, &image, &[], whole, dense(&tall, rows));
                let image = l.transpose() * dense(&tall, rows);
                let image: Vec<f64> = (0..rows * k).map(|at| image[(at / k, at % k)]).collect();
                check(BlockKernel::Upper, &image, &[], whole, dense(&tall, rows));
            }
        }
        assert!(!BlockKernel::Product.apply(&mut [0.0; 3], Mat::<f64>::zeros(1, 1).as_ref(), &[0.0; 3], 3));
    }
}
