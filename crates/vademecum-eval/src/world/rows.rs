//! Sums over the coordinates of a member, three rows at once.

/// Numbers that are summed side by side: rows and coordinates are padded to a multiple of it.
pub(crate) const LANES: usize = 4;

/// `n` rounded up to whole lanes.
pub(crate) const fn padded(n: usize) -> usize {
    n.div_ceil(LANES).saturating_mul(LANES)
}

/// Three rows of as many numbers as `x`, one after the other, times `x`.
#[inline]
pub(crate) fn times(rows: &[f64], x: &[f64]) -> [f64; 3] {
    let (n, mut sums) = (x.len(), [[0.0; LANES]; 3]);
    let (first, rest) = rows.split_at(n.min(rows.len()));
    let (second, third) = rest.split_at(n.min(rest.len()));
    let each = first.as_chunks::<LANES>().0.iter().zip(second.as_chunks::<LANES>().0);
    for (((a, b), c), x) in each.zip(third.as_chunks::<LANES>().0).zip(x.as_chunks::<LANES>().0) {
        for lane in 0..LANES {
            sums[0][lane] += a[lane] * x[lane];
            sums[1][lane] += b[lane] * x[lane];
            sums[2][lane] += c[lane] * x[lane];
        }
    }
    sums.map(|sum| (sum[0] + sum[1]) + (sum[2] + sum[3]))
}

/// `x += P Gᵀ f` for three rows `G`.
#[inline]
pub(crate) fn add(rows: &[f64], p: &[f64], f: [f64; 3], x: &mut [f64]) {
    let n = x.len();
    let (first, rest) = rows.split_at(n.min(rows.len()));
    let (second, third) = rest.split_at(n.min(rest.len()));
    let each = first.as_chunks::<LANES>().0.iter().zip(second.as_chunks::<LANES>().0);
    let each = each.zip(third.as_chunks::<LANES>().0).zip(p.as_chunks::<LANES>().0);
    for ((((a, b), c), p), x) in each.zip(x.as_chunks_mut::<LANES>().0) {
        for lane in 0..LANES {
            x[lane] += p[lane] * (f[0] * a[lane] + f[1] * b[lane] + f[2] * c[lane]);
        }
    }
}

/// `G P Gᵀ` of three rows.
pub(crate) fn answers(rows: &[f64], p: &[f64]) -> [[f64; 3]; 3] {
    let n = p.len();
    let row = |i: usize| rows.iter().skip(i * n).take(n);
    let entry = |i: usize, j: usize| row(i).zip(row(j)).zip(p).map(|((a, b), p)| a * b * p).sum();
    core::array::from_fn(|i| core::array::from_fn(|j| entry(i, j)))
}
