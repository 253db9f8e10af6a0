//! Whole fields, `out = scale B x`, row by row of the basis where it lies.
//!
//! Every row is summed in the same order whatever its length: column `k` goes to partial sum `k mod 8`, and
//! the eight are added in pairs at the end. So the bits do not depend on which of the loops a row
//! takes, nor on the machine.

use crate::base::lend::Short;
use crate::base::scalar::Scalar;
use crate::sections::quantised::reconstruct_quantised;
use crate::sections::short_rows::short_rows;
use vademecum_format::Numbers;

/// Partial sums of a row.
const WIDTH: usize = 8;

/// `out_d = scale Σ_k B_dk x_k` for all rows of `B`, one per number of `out`.
pub(crate) fn reconstruct<T: Scalar>(
    rows: Numbers<'_>,
    x: &[T],
    scale: T,
    out: &mut [T],
) -> Result<(), Short> {
    let (found, needed) = (rows.len(), out.len().saturating_mul(x.len()));
    if found != needed {
        return Err(Short { found, needed });
    }
    match rows {
        Numbers::F32(rows) => match x.as_chunks() {
            ([a], []) => T::short_rows_f32(rows, &[*a], scale, out),
            ([a, b], []) => T::short_rows_f32(rows, &[*a, *b], scale, out),
            ([a, b, c], []) => T::short_rows_f32(rows, &[*a, *b, *c], scale, out),
            ([a, b, c, d], []) => T::short_rows_f32(rows, &[*a, *b, *c, *d], scale, out),
            _ => any_rows(rows, x, scale, out, binary32),
        },
        Numbers::F64(rows) => {
            let read = |bytes| T::from_f64(f64::from_le_bytes(bytes));
            match x.as_chunks() {
                ([a], []) => short_rows(rows, &[*a], scale, out, read),
                ([a, b], []) => short_rows(rows, &[*a, *b], scale, out, read),
                ([a, b, c], []) => short_rows(rows, &[*a, *b, *c], scale, out, read),
                _ => any_rows(rows, x, scale, out, read),
            }
        }
        Numbers::I16(rows) => reconstruct_quantised(rows, x, scale, out)?,
    }
    Ok(())
}

/// A binary32 number of a file.
#[inline(always)]
fn binary32<T: Scalar>(bytes: [u8; 4]) -> T {
    T::from_f32(f32::from_le_bytes(bytes))
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sections::short_rows::{QUAD, short_rows_f32};

    /// Numbers of both signs, zeros of both among them.
    fn number(i: usize) -> f32 {
        [0.0, -0.0, 1.0, -1.0, 0.3, -2.7e-3, 1e-30, 4.1e8][(i * i + i / 7) % 8]
    }

    #[test]
    fn short_rows_have_the_bits_of_any_rows() {
        fn check<const Q: usize>() {
            let x: [[f32; QUAD]; Q] =
                core::array::from_fn(|q| core::array::from_fn(|k| number(3 * (4 * q + k) + 1)));
            let rows: [[u8; 4]; 23 * 16] = core::array::from_fn(|i| number(i).to_le_bytes());
            let rows = &rows[..23 * 4 * Q];
            let (mut short, mut any) = ([f32::NAN; 23], [f32::NAN; 23]);
            short_rows_f32(rows, &x, -1.5, &mut short);
            any_rows(rows, x.as_flattened(), -1.5, &mut any, binary32);
            assert_eq!(short.map(f32::to_bits), any.map(f32::to_bits), "{Q}");
        }
        check::<1>();
        check::<2>();
        check::<3>();
        check::<4>();
    }
}
