//! Whole fields, `out = scale B x`, row by row of the basis where it lies.
//!
//! Every row is summed in the same order whatever its length: column `k` goes to partial sum `k mod 8`, and the eight are added in pairs
//! at the end. So the bits do not depend on which of the two loops below a row takes, nor on the machine.

use crate::quantised::reconstruct_quantised;
use crate::scalar::Scalar;
use vademecum_format::Numbers;

/// Partial sums of a row.
const WIDTH: usize = 8;
/// Columns read at once, and rows whose sums are finished side by side.
const QUAD: usize = 4;

/// `out_d = scale Σ_k B_dk x_k` for all rows of `B`.
pub(crate) fn reconstruct<T: Scalar>(rows: Numbers<'_>, x: &[T], scale: T, out: &mut [T]) {
    match rows {
        Numbers::F32(rows) => {
            reconstruct_with(rows, x, scale, out, |bytes| T::from_f32(f32::from_le_bytes(bytes)))
        }
        Numbers::F64(rows) => {
            reconstruct_with(rows, x, scale, out, |bytes| T::from_f64(f64::from_le_bytes(bytes)))
        }
        Numbers::I16(rows) => reconstruct_quantised(rows, x, scale, out),
    }
}

/// Short rows have lengths the compiler knows: finishing the sum of each alone would cost more than reading it.
#[inline(always)]
fn reconstruct_with<T: Scalar, const N: usize>(
    rows: &[[u8; N]],
    x: &[T],
    scale: T,
    out: &mut [T],
    read: impl Fn([u8; N]) -> T + Copy,
) {
    match x.as_chunks() {
        ([a], []) => short_rows(rows, &[*a], scale, out, read),
        ([a, b], []) => short_rows(rows, &[*a, *b], scale, out, read),
        ([a, b, c], []) => short_rows(rows, &[*a, *b, *c], scale, out, read),
        _ => any_rows(rows, x, scale, out, read),
    }
}

/// Rows of `4 Q` columns, four at a time.
#[inline(always)]
fn short_rows<T: Scalar, const N: usize, const Q: usize>(
    rows: &[[u8; N]],
    x: &[[T; QUAD]; Q],
    scale: T,
    out: &mut [T],
    read: impl Fn([u8; N]) -> T + Copy,
) {
    let (blocks, rest) = rows.as_chunks::<QUAD>().0.as_chunks::<Q>().0.as_chunks::<QUAD>();
    let (out, out_rest) = out.as_chunks_mut::<QUAD>();
    for (rows, out) in blocks.iter().zip(out) {
        // Keeps the compiler from taking several blocks at once, which with AVX2 and AVX-512 it does byte by byte, six times slower.
        let rows = core::hint::black_box(rows);
        let mut sums = [[T::ZERO; QUAD]; QUAD];
        for row in 0..QUAD {
            sums[row] = partial_sums(&rows[row], x, read);
        }
        for row in 0..QUAD {
            out[row] = scale * ((sums[row][0] + sums[row][2]) + (sums[row][1] + sums[row][3]));
        }
    }
    for (row, out) in rest.iter().zip(out_rest) {
        let [a, b, c, d] = partial_sums(row, x, read);
        *out = scale * ((a + c) + (b + d));
    }
}

/// Columns `k mod 4` of a row; every second quad into a sum of its own.
#[inline(always)]
fn partial_sums<T: Scalar, const N: usize, const Q: usize>(
    row: &[[[u8; N]; QUAD]; Q],
    x: &[[T; QUAD]; Q],
    read: impl Fn([u8; N]) -> T + Copy,
) -> [T; QUAD] {
    // The row is read before it is summed: read one by one, some counts and precisions end in moves of single bytes.
    let mut values = [[T::ZERO; QUAD]; Q];
    for q in 0..Q {
        for k in 0..QUAD {
            values[q][k] = read(row[q][k]);
        }
    }
    let mut sums = [[T::ZERO; QUAD]; 2];
    for q in 0..Q {
        for k in 0..QUAD {
            sums[q % 2][k] += values[q][k] * x[q][k];
        }
    }
    let [mut even, odd] = sums;
    for k in 0..QUAD {
        even[k] += odd[k];
    }
    even
}

/// Rows of any number of columns.
#[inline(always)]
fn any_rows<T: Scalar, const N: usize>(
    rows: &[[u8; N]],
    x: &[T],
    scale: T,
    out: &mut [T],
    read: impl Fn([u8; N]) -> T + Copy,
) {
    let (wide, narrow) = x.as_chunks::<WIDTH>();
    for (row, out) in rows.chunks_exact(x.len().max(1)).zip(out) {
        let (row_wide, row_narrow) = row.as_chunks::<WIDTH>();
        let mut sums = [T::ZERO; WIDTH];
        for (row, x) in row_wide.iter().zip(wide) {
            for k in 0..WIDTH {
                sums[k] += read(row[k]) * x[k];
            }
        }
        for ((bytes, &x), sum) in row_narrow.iter().zip(narrow).zip(&mut sums) {
            *sum += read(*bytes) * x;
        }
        let [a, b, c, d, e, f, g, h] = sums;
        *out = scale * (((a + e) + (c + g)) + ((b + f) + (d + h)));
    }
}
