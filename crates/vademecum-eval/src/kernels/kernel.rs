//! The two inner loops. Both read fixed-size arrays so that they vectorise without run-time lengths inside,
//! write the new state beside the old one, set what is below [`Scalar::FLOOR`] to zero and return `Σ|y|`,
//! which is not finite exactly when the new state is not (or overflows when summed).

use crate::base::lend::{Lender, Short};
use crate::base::scalar::Scalar;
use crate::base::vectors::{Kernel, vectorised};
use vademecum_format::Numbers;

/// Modes handled at once by the diagonal kernel; strides are multiples of it.
pub(crate) const LANES: usize = 16;
/// Rows handled at once by the dense kernel: `3r` for r = 8, and six SSE (three AVX) registers of `f32`.
pub(crate) const TILE: usize = 24;

/// The coefficients of [`LANES`] modes: `D` of each mode, `N × N`, row by row.
pub(crate) type ModeBlock<T, const N: usize> = [[[T; LANES]; N]; N];

/// A map in memory as blocks of modes.
#[inline(always)]
pub(crate) fn blocks<T, const N: usize>(map: &[T]) -> &[ModeBlock<T, N>] {
    map.as_chunks().0.as_chunks().0.as_chunks().0
}

/// One diagonal step: for each mode, `y + D y + ℓ` with a 3×3 `D`. All state slices are `(3, stride)`.
#[inline(always)]
pub(crate) fn step_diagonal<T: Scalar>(
    blocks: &[ModeBlock<T, 3>],
    old: &[T],
    load: &[T],
    new: &mut [T],
) -> Result<T, Short> {
    vectorised(ModeStep { blocks, old, load, new })
}

impl<T: Scalar> Kernel for ModeStep<'_, T, 3> {
    type Output = Result<T, Short>;

    #[inline(always)]
    fn run(self) -> Self::Output {
        let Self { blocks, old, load, new } = self;
        let stride = old.len() / 3;
        let ([z, v, a], [lz, lv, la]) = (parts(old, stride)?, parts(load, stride)?);
        let mut new = Lender::new(new);
        let (nz, nv, na) = (new.take(stride)?, new.take(stride)?, new.take(stride)?);
        let (nz, nv, na) = (nz.as_chunks_mut().0, nv.as_chunks_mut().0, na.as_chunks_mut().0);
        let state = z.iter().zip(v).zip(a);
        let load = lz.iter().zip(lv).zip(la);
        let new = nz.iter_mut().zip(nv).zip(na);
        let mut sums = [T::ZERO; LANES];
        for (((d, ((z, v), a)), ((lz, lv), la)), ((nz, nv), na)) in
            blocks.iter().zip(state).zip(load).zip(new)
        {
            let old: [&[T; LANES]; 3] = [z, v, a];
            *nz = mode_row(&d[0], old, z, lz, &mut sums);
            *nv = mode_row(&d[1], old, v, lv, &mut sums);
            *na = mode_row(&d[2], old, a, la, &mut sums);
        }
        Ok(total(&sums))
    }
}

/// One exact step: for each mode, `y + D y + ℓ` with a 2×2 `D`. All state slices are `(2, stride)`.
#[inline(always)]
pub(crate) fn step_exact<T: Scalar>(
    blocks: &[ModeBlock<T, 2>],
    old: &[T],
    load: &[T],
    new: &mut [T],
) -> Result<T, Short> {
    vectorised(ModeStep { blocks, old, load, new })
}

/// A step of independent modes.
struct ModeStep<'a, T, const N: usize> {
    blocks: &'a [ModeBlock<T, N>],
    old: &'a [T],
    load: &'a [T],
    new: &'a mut [T],
}

impl<T: Scalar> Kernel for ModeStep<'_, T, 2> {
    type Output = Result<T, Short>;

    #[inline(always)]
    fn run(self) -> Self::Output {
        let Self { blocks, old, load, new } = self;
        let stride = old.len() / 2;
        let ([z, v], [lz, lv]) = (parts(old, stride)?, parts(load, stride)?);
        let mut new = Lender::new(new);
        let (nz, nv) = (new.take(stride)?.as_chunks_mut().0, new.take(stride)?.as_chunks_mut().0);
        let mut sums = [T::ZERO; LANES];
        for (((d, (z, v)), (lz, lv)), (nz, nv)) in
            blocks.iter().zip(z.iter().zip(v)).zip(lz.iter().zip(lv)).zip(nz.iter_mut().zip(nv))
        {
            *nz = mode_row(&d[0], [z, v], z, lz, &mut sums);
            *nv = mode_row(&d[1], [z, v], v, lv, &mut sums);
        }
        Ok(total(&sums))
    }
}

/// One row of the blocks: `kept + (ℓ + d₀ y₀ + d₁ y₁ + …)`, the small sum first.
#[inline(always)]
fn mode_row<T: Scalar, const N: usize>(
    d: &[[T; LANES]; N],
    y: [&[T; LANES]; N],
    kept: &[T; LANES],
    load: &[T; LANES],
    sums: &mut [T; LANES],
) -> [T; LANES] {
    let mut new = [T::ZERO; LANES];
    for k in 0..LANES {
        let mut increment = load[k];
        for part in 0..N {
            increment += d[part][k] * y[part][k];
        }
        new[k] = flushed(kept[k] + increment, &mut sums[k]);
    }
    new
}

/// One dense step: `y + D y + ℓ`; `tiles` holds `D` in tiles of [`TILE`] rows, each tile column by column.
#[inline(never)]
pub(crate) fn step_dense<T: Scalar>(
    tiles: &[[T; TILE]],
    columns: usize,
    old: &[T],
    load: &[T],
    new: &mut [T],
) -> T {
    let mut sums = [T::ZERO; TILE];
    let kept = old.as_chunks::<TILE>().0;
    let load = load.as_chunks::<TILE>().0;
    let new = new.as_chunks_mut::<TILE>().0;
    for (((tile, kept), load), new) in tiles.chunks_exact(columns.max(1)).zip(kept).zip(load).zip(new) {
        let increment = columns_times(tile, old, *load);
        for k in 0..TILE {
            new[k] = flushed(kept[k] + increment[k], &mut sums[k]);
        }
    }
    total(&sums)
}

/// `out += tiles · x`, tiles as in [`step_dense`] with `x.len()` columns.
pub(crate) fn add_dense<T: Scalar>(tiles: &[[T; TILE]], x: &[T], out: &mut [T]) {
    for (tile, out) in tiles.chunks_exact(x.len().max(1)).zip(out.as_chunks_mut::<TILE>().0) {
        *out = columns_times(tile, x, *out);
    }
}

#[inline(always)]
pub(crate) fn columns_times<T: Scalar, const N: usize>(tile: &[[T; N]], x: &[T], mut sum: [T; N]) -> [T; N] {
    for (column, &x) in tile.iter().zip(x) {
        for k in 0..N {
            sum[k] += column[k] * x;
        }
    }
    sum
}

/// `value`, or zero below the floor; adds its magnitude to `sum`. NaN passes.
#[inline(always)]
pub(crate) fn flushed<T: Scalar>(value: T, sum: &mut T) -> T {
    let magnitude = value.magnitude();
    *sum += magnitude;
    if magnitude < T::FLOOR { T::ZERO } else { value }
}

#[inline(always)]
fn parts<T, const N: usize>(all: &[T], stride: usize) -> Result<[&[[T; LANES]]; N], Short> {
    let (mut all, mut parts) = (Lender::new(all), [&[][..]; N]);
    for part in &mut parts {
        *part = all.take(stride)?.as_chunks().0;
    }
    Ok(parts)
}

/// `x − share y`.
#[inline(always)]
pub(crate) fn less<T: Scalar, const N: usize>(mut x: [T; N], share: T, y: &[T; N]) -> [T; N] {
    for i in 0..N {
        x[i] = x[i] - share * y[i];
    }
    x
}

/// `ĝ·d` of a row in panels.
#[inline(always)]
pub(crate) fn along<'g, T: Scalar + 'g, const N: usize>(
    row: impl Iterator<Item = &'g [T; N]>,
    d: &[[T; N]],
) -> T {
    let mut sums = [T::ZERO; N];
    for (g, d) in row.zip(d) {
        for i in 0..N {
            sums[i] += g[i] * d[i];
        }
    }
    total(&sums)
}

/// Sum of all, in halves: one after the other they would wait for each other, longer than the step takes.
#[inline(always)]
pub(crate) fn total<T: Scalar, const N: usize>(sums: &[T; N]) -> T {
    let (mut sums, mut count) = (*sums, N);
    while count > 1 {
        let kept = count.div_ceil(2);
        for k in kept..count {
            let sum = sums[k];
            sums[k - kept] += sum;
        }
        count = kept;
    }
    sums[0]
}

/// `out += scale · row` for a row of the file; the kind of its numbers is looked at once.
pub(crate) fn add_row<T: Scalar>(row: Numbers<'_>, scale: T, out: &mut [T]) {
    match row {
        Numbers::F32(row) => {
            add_scaled(row.iter().map(|&bytes| T::from_f32(f32::from_le_bytes(bytes))), scale, out)
        }
        Numbers::F64(row) => {
            add_scaled(row.iter().map(|&bytes| T::from_f64(f64::from_le_bytes(bytes))), scale, out)
        }
        Numbers::I16(_) => add_scaled(row.iter().map(T::from_f64), scale, out),
    }
}

#[inline(always)]
fn add_scaled<T: Scalar>(row: impl Iterator<Item = T>, scale: T, out: &mut [T]) {
    out.iter_mut().zip(row).for_each(|(out, value)| *out += scale * value);
}
