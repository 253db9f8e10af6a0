//! The solve of a sub-step in twice the digits of its numbers: each number of matrix, factor and solution is
//! the sum of two.
//!
//! The matrix of a sub-step, `M + HᵀH`, is rounded to the entries of its stiffest rows, and single precision
//! soon has nothing left of the mass beside them. The rows themselves have enough digits, so here they are
//! squared, and the matrix is factored, in double precision. Few scenes ever need this; their steps
//! take longer.

use crate::base::scalar::Scalar;
use crate::kernels::kernel::less;

/// Numbers in two parts, `high + low`.
fn read<T: Scalar, const N: usize>(high: &[T; N], low: &[T; N]) -> [f64; N] {
    let mut out = [0.0; N];
    for i in 0..N {
        out[i] = high[i].to_f64() + low[i].to_f64();
    }
    out
}

/// Takes numbers apart.
fn write<T: Scalar, const N: usize>(values: &[f64; N], high: &mut [T; N], low: &mut [T; N]) {
    for i in 0..N {
        high[i] = T::from_f64(values[i]);
        low[i] = T::from_f64(values[i] - high[i].to_f64());
    }
}

/// The panels of two parts of a line or vector.
fn panels<'a, T, const N: usize>(
    high: &'a [T],
    low: &'a [T],
) -> impl Iterator<Item = (&'a [T; N], &'a [T; N])> {
    high.as_chunks::<N>().0.iter().zip(low.as_chunks::<N>().0)
}

/// The same, to be written to.
fn panels_mut<'a, T, const N: usize>(
    high: &'a mut [T],
    low: &'a mut [T],
) -> impl Iterator<Item = (&'a mut [T; N], &'a mut [T; N])> {
    high.as_chunks_mut::<N>().0.iter_mut().zip(low.as_chunks_mut::<N>().0)
}

/// One number of two parts.
fn number<T: Scalar>(high: &[T], low: &[T], at: usize) -> f64 {
    let part = |part: &[T]| part.get(at).map_or(0.0, |part| part.to_f64());
    part(high) + part(low)
}

/// The matrix of rows in panels of `N` numbers, `count` rows a panel, and of what is on the diagonal beside
/// their products, and its factor `A = Uᵀ D⁻¹ U`: `U` in the upper half.
#[inline(never)]
pub(crate) fn factor<T: Scalar, const N: usize>(
    (rows, count): (&[[T; N]], usize),
    diagonal: impl Fn(usize) -> f64,
    [mut high, mut low]: [&mut [T]; 2],
    n: usize,
) {
    gram((rows, count), &diagonal, [&mut *high, &mut *low], n);
    for j in 0..n {
        let (Some((line, high_rest)), Some((line_low, low_rest))) =
            (high.split_at_mut_checked(n), low.split_at_mut_checked(n))
        else {
            return;
        };
        let pivot = number(line, line_low, j);
        // Nor is it more if it is no number.
        let is_more = pivot > 0.5 * diagonal(j);
        if !is_more && let Some(pivot) = line.get_mut(j) {
            // Even these digits are lost: this coordinate rests for the step.
            *pivot = T::from_f64(f64::INFINITY);
        }
        let inverse = 1.0 / number(line, line_low, j);
        let lines = high_rest.chunks_exact_mut(n.max(1)).zip(low_rest.chunks_exact_mut(n.max(1)));
        for (i, (other, other_low)) in (j + 1..n).zip(lines) {
            let share = number(line, line_low, i) * inverse;
            let parts = panels_mut::<T, N>(other, other_low).zip(panels::<T, N>(line, line_low));
            for (out, from) in parts.skip(i / N) {
                let value = less(read(out.0, out.1), share, &read(from.0, from.1));
                write(&value, out.0, out.1);
            }
        }
        (high, low) = (high_rest, low_rest);
    }
}

/// The matrix, its upper half.
fn gram<T: Scalar, const N: usize>(
    (rows, count): (&[[T; N]], usize),
    diagonal: impl Fn(usize) -> f64,
    [high, low]: [&mut [T]; 2],
    n: usize,
) {
    let (n, count) = (n.max(1), count.max(1));
    for (i, first) in rows.chunks_exact(count).enumerate() {
        for (j, second) in rows.chunks_exact(count).enumerate().skip(i) {
            let mut block = [[0.0; N]; N];
            for (a, b) in first.iter().zip(second) {
                for (line, a) in block.iter_mut().zip(a) {
                    for (out, b) in line.iter_mut().zip(b) {
                        *out += a.to_f64() * b.to_f64();
                    }
                }
            }
            let lines = high.chunks_exact_mut(n).zip(low.chunks_exact_mut(n)).skip(N * i);
            for (k, ((high, low), mut values)) in lines.zip(block).enumerate() {
                if i == j {
                    values[k] += diagonal(N * i + k);
                }
                if let Some((high, low)) = panels_mut(high, low).nth(j) {
                    write(&values, high, low);
                }
            }
        }
    }
}

/// Solves with a factor of [`factor`].
#[inline(never)]
pub(crate) fn solve<T: Scalar, const N: usize>(
    [high, low]: [&[T]; 2],
    right: &[T],
    [x, x_low]: [&mut [T]; 2],
) {
    let n = x.len().max(1);
    x.iter_mut().zip(right).for_each(|(x, &right)| *x = right);
    x_low.fill(T::ZERO);
    let lines = || high.chunks_exact(n).zip(low.chunks_exact(n)).enumerate();
    for (j, (line, line_low)) in lines() {
        let known = number(x, x_low, j) / number(line, line_low, j);
        let parts = panels_mut::<T, N>(x, x_low).zip(panels::<T, N>(line, line_low)).enumerate();
        for (panel, (out, from)) in parts.skip(j / N) {
            let from = behind(j, panel, read(from.0, from.1));
            write(&less(read(out.0, out.1), known, &from), out.0, out.1);
        }
    }
    for (j, (line, line_low)) in lines().rev() {
        let mut value = number(x, x_low, j);
        let parts = panels::<T, N>(x, x_low).zip(panels::<T, N>(line, line_low)).enumerate();
        for (panel, (x, from)) in parts.skip(j / N) {
            let (x, from) = (read(x.0, x.1), behind(j, panel, read(from.0, from.1)));
            value -= x.iter().zip(&from).map(|(x, from)| x * from).sum::<f64>();
        }
        value /= number(line, line_low, j);
        if let (Some(high), Some(low)) = (x.get_mut(j), x_low.get_mut(j)) {
            *high = T::from_f64(value);
            *low = T::from_f64(value - high.to_f64());
        }
    }
}

/// Of the numbers of a panel of line `j` those behind its diagonal; the others are not of the factor.
fn behind<const N: usize>(j: usize, panel: usize, mut line: [f64; N]) -> [f64; N] {
    if panel == j / N {
        (0..=j % N).for_each(|i| line[i] = 0.0);
    }
    line
}
