//! `out = scale B x` for rows of 4, 8, 12 or 16 columns, with the order of sums that [`crate::reconstruct`]
//! promises.

use core::ops::{Add, AddAssign, Mul};
use wide::f32x4;

/// Columns read at once, and rows whose sums are finished side by side.
pub(crate) const QUAD: usize = 4;

/// A number that can be summed; its default is zero.
pub(crate) trait Number: Copy + Default + Add<Output = Self> + Mul<Output = Self> + AddAssign {}

impl<T: Copy + Default + Add<Output = T> + Mul<Output = T> + AddAssign> Number for T {}

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
pub(crate) fn short_rows<T: Number, const N: usize, const Q: usize>(
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
        let mut sums = [[T::default(); QUAD]; QUAD];
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
fn partial_sums<T: Number, const N: usize, const Q: usize>(
    row: &[[[u8; N]; QUAD]; Q],
    x: &[[T; QUAD]; Q],
    read: impl Fn([u8; N]) -> T + Copy,
) -> [T; QUAD] {
    // The row is read before it is summed: read one by one, some counts and precisions end in moves of single
    // bytes.
    let mut values = [[T::default(); QUAD]; Q];
    for q in 0..Q {
        for k in 0..QUAD {
            values[q][k] = read(row[q][k]);
        }
    }
    let mut sums = [[T::default(); QUAD]; 2];
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
