//! Fields from a quantised basis, read where it lies.
//!
//! `Σ_k (s_k q_dk) x_k = Σ_k q_dk (s_k x_k)`: within a block of nodes the products `s_k x_k` are the same for
//! all rows of one component, so the inner loop costs what it costs over binary32, and reads half the bytes.

use crate::base::lend::{Lender, Short};
use crate::base::scalar::Scalar;
use vademecum_format::Quantised;

/// Modes whose products are kept at once.
const PANEL: usize = 64;
/// Modes of a row handled at once.
const WIDTH: usize = 8;

/// `out_d = scale Σ_k B_dk x_k` for all rows of `B`, three to a node, `out` of shape `(nodes, 3)`.
pub(crate) fn reconstruct_quantised<T: Scalar>(
    rows: Quantised<'_>,
    x: &[T],
    scale: T,
    out: &mut [T],
) -> Result<(), Short> {
    let r = x.len().max(1);
    let mut out = Lender::new(out);
    for (scales, numbers) in rows.blocks() {
        let block = out.take(numbers.len() / r)?;
        block.fill(T::ZERO);
        for (component, scales) in scales.chunks_exact(r).enumerate() {
            for (panel, (scales, x)) in scales.chunks(PANEL).zip(x.chunks(PANEL)).enumerate() {
                let products = products(scales, x, scale);
                let rows = numbers.chunks_exact(r).skip(component).step_by(3);
                let width = x.len();
                let short = Short { found: r, needed: panel * PANEL + width };
                for (row, out) in rows.zip(block.iter_mut().skip(component).step_by(3)) {
                    let row = row.get(panel * PANEL..panel * PANEL + width).ok_or(short)?;
                    *out += dot(row, &products);
                }
            }
        }
    }
    Ok(())
}

/// `scale s_k x_k`, zero past their end.
#[inline(always)]
fn products<T: Scalar>(scales: &[[u8; 4]], x: &[T], scale: T) -> [T; PANEL] {
    let mut products = [T::ZERO; PANEL];
    for ((out, &bytes), &x) in products.iter_mut().zip(scales).zip(x) {
        *out = T::from_f32(f32::from_le_bytes(bytes)) * (scale * x);
    }
    products
}

/// `Σ_k q_k y_k`, in [`WIDTH`] sums side by side.
#[inline(always)]
fn dot<T: Scalar>(row: &[[u8; 2]], products: &[T; PANEL]) -> T {
    let (wide, narrow) = row.as_chunks::<WIDTH>();
    let narrow_y = products.iter().skip(WIDTH * wide.len());
    let mut sums = [T::ZERO; WIDTH];
    for (row, y) in wide.iter().zip(products.as_chunks::<WIDTH>().0) {
        for k in 0..WIDTH {
            sums[k] += T::from_i16(i16::from_le_bytes(row[k])) * y[k];
        }
    }
    for ((&bytes, &y), sum) in narrow.iter().zip(narrow_y).zip(&mut sums) {
        *sum += T::from_i16(i16::from_le_bytes(bytes)) * y;
    }
    let [a, b, c, d, e, f, g, h] = sums;
    ((a + e) + (c + g)) + ((b + f) + (d + h))
}
