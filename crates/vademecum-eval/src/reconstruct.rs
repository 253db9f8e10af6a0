//! Whole fields, `out = scale B x`, row by row of the basis where it lies.
//!
//! Every row is summed in the same order whatever its length: column `k` goes to partial sum `k mod 8`, and
//! the eight are added in pairs at the end. So the bits do not depend on which of the two loops below a row
//! takes, nor on the machine.

use crate::lend::Short;
use crate::quantised::reconstruct_quantised;
use crate::scalar::Scalar;
use vademecum_format::Numbers;
use wide::f32x4;

/// Partial sums of a row.
const WIDTH: usize = 8;
/// Columns read at once, and rows whose sums are finished side by side.
pub(crate) const QUAD: usize = 4;

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
pub(crate) fn binary32<T: Scalar>(bytes: [u8; 4]) -> T {
    T::from_f32(f32::from_le_bytes(bytes))
}

/// [`short_rows`] of binary32 numbers into binary32, which is what most scenes show, with vectors of four
/// named as such: the compiler reads four rows of the plain loop one number at a time, which takes twice as
/// long.
///
/// Not inlined: beside the other loops it would run out of registers.
#[inline(never)]
pub(crate) fn short_rows_f32<const Q: usize>(
    rows: &[[u8; 4]],
    x: &[[f32; QUAD]; Q],
    scale: f32,
    out: &mut [f32],
) {
    const { assert!(Q >= 1 && Q <= 4, "the sums below are written out for these") };
    let (blocks, rest) = rows.as_chunks::<QUAD>().0.as_chunks::<Q>().0.as_chunks::<QUAD>();
    let (out, out_rest) = out.as_chunks_mut::<QUAD>();
    let x = x.map(f32x4::new);
    let partial_sums = |row: &[[[u8; 4]; QUAD]; Q]| {
        let mut products = [f32x4::ZERO; Q];
        for q in 0..Q {
            products[q] = quad(&row[q]) * x[q];
        }
        match products.as_slice() {
            [a] => *a,
            [a, b] => *a + *b,
            [a, b, c] => (*a + *c) + *b,
            [a, b, c, d] => (*a + *c) + (*b + *d),
            _ => f32x4::ZERO,
        }
    };
    // Zero last, not first as in the other loops: the same bits (only a sum of −0 changes) for fewer
    // additions.
    let finished = |sums| {
        let [a, b, c, d] = f32x4::transpose(sums);
        (f32x4::splat(scale) * (((a + c) + (b + d)) + f32x4::ZERO)).to_array()
    };
    for ([a, b, c, d], out) in blocks.iter().zip(out) {
        *out = finished([partial_sums(a), partial_sums(b), partial_sums(c), partial_sums(d)]);
    }
    for (row, out) in rest.iter().zip(out_rest) {
        [*out, ..] = finished([partial_sums(row); QUAD]);
    }
}

/// Four numbers of a file; one move where the machine is little-endian, too.
#[inline(always)]
fn quad(bytes: &[[u8; 4]; QUAD]) -> f32x4 {
    if cfg!(target_endian = "little") {
        bytemuck::cast(*bytes)
    } else {
        f32x4::new(bytes.map(f32::from_le_bytes))
    }
}

/// Rows of `4 Q` columns, four at a time: finishing the sum of each alone would cost more than reading it.
#[inline(always)]
pub(crate) fn short_rows<T: Scalar, const N: usize, const Q: usize>(
    rows: &[[u8; N]],
    x: &[[T; QUAD]; Q],
    scale: T,
    out: &mut [T],
    read: impl Fn([u8; N]) -> T + Copy,
) {
    let (blocks, rest) = rows.as_chunks::<QUAD>().0.as_chunks::<Q>().0.as_chunks::<QUAD>();
    let (out, out_rest) = out.as_chunks_mut::<QUAD>();
    for (rows, out) in blocks.iter().zip(out) {
        // Keeps the compiler from taking several blocks at once, which with AVX2 and AVX-512 it does byte by
        // byte, six times slower.
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
    // The row is read before it is summed: read one by one, some counts and precisions end in moves of single
    // bytes.
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

#[cfg(test)]
mod tests {
    use super::*;

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
