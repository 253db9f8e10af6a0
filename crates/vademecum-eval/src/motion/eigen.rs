//! Eigenvalues and vectors of a small matrix with real eigenvalues, by Jacobi's method for general matrices:
//! each plane rotation diagonalises the symmetric part of its plane and a shear then lessens the norm of the
//! matrix, until it is normal (Eberlein 1962). Simple, without heap, and both `X` and `X⁻¹` come with it.
//!
//! The shear `e^{yJ}`, `J` the exchange of the plane's two axes, changes `‖A‖²` by `g cosh 2y + 2h sinh 2y`
//! outside of the plane and by `½(D² + E²) cosh 4y − D E sinh 4y` within; `y ≈ tanh y` is one Newton step to
//! the minimum from 0.

use crate::base::lend::Short;

/// Pairs whose rotation and shear are both below this are left alone; a sweep of only such ones is the last.
const SMALL: f64 = 1e-12;
/// A plane whose entries beside the diagonal are below this share of those on it is left alone: between equal
/// eigenvalues rounding would turn it for ever.
const NEGLIGIBLE: f64 = 1e-14;
/// More sweeps than any matrix has needed that is similar to a symmetric one; convergence is quadratic at the
/// end.
const MAX_SWEEPS: usize = 40;

/// Turns `a` `(r, r)` into `X⁻¹ A X`, whose diagonal holds the eigenvalues. `columns` receives `X` column by
/// column, `rows` receives `X⁻¹` row by row. Returns the sweeps taken, [`MAX_SWEEPS`] if it has not
/// converged. All three have `r²` numbers.
pub(crate) fn diagonalise(
    a: &mut [f64],
    columns: &mut [f64],
    rows: &mut [f64],
    r: usize,
) -> Result<usize, Short> {
    let (found, needed) = (a.len().min(columns.len()).min(rows.len()), r.saturating_mul(r));
    if found < needed {
        return Err(Short { found, needed });
    }
    for vectors in [&mut *columns, &mut *rows] {
        vectors
            .iter_mut()
            .enumerate()
            .for_each(|(i, x)| *x = if i / r.max(1) == i % r.max(1) { 1.0 } else { 0.0 });
    }
    for sweep in 0..MAX_SWEEPS {
        let mut largest = 0.0f64;
        for k in 0..r {
            for m in k + 1..r {
                let Some(turn) = Turn::of(a, r, k, m) else { continue };
                largest = largest.max(turn.size);
                if turn.size > SMALL {
                    turn.apply_left(a, r, k, m);
                    turn.apply_right(a, r, k, m);
                    turn.apply_left(rows, r, k, m);
                    turn.apply_right_transposed(columns, r, k, m);
                }
            }
        }
        if largest <= SMALL {
            return Ok(sweep);
        }
    }
    Ok(MAX_SWEEPS)
}

/// A rotation and a shear of one plane: rows are multiplied by `[[c1, s1], [s2, c2]]`, columns by its inverse
/// `[[c2, −s1], [−s2, c1]]`.
struct Turn {
    c1: f64,
    c2: f64,
    s1: f64,
    s2: f64,
    /// The larger of `|tan x|` and `|tanh y|`.
    size: f64,
}

impl Turn {
    /// `None` where nothing is left to do.
    fn of(a: &[f64], r: usize, k: usize, m: usize) -> Option<Self> {
        let (row_k, row_m) = (a.get(k * r..(k + 1) * r)?, a.get(m * r..(m + 1) * r)?);
        let (kk, mm, km, mk) = (*row_k.get(k)?, *row_m.get(m)?, *row_k.get(m)?, *row_m.get(k)?);
        if km.abs() + mk.abs() <= NEGLIGIBLE * (kk.abs() + mm.abs()) {
            return None;
        }
        let (mut g, mut h, mut turned) = (0.0, 0.0, 0.0);
        let columns = a.iter().skip(k).step_by(r.max(1)).zip(a.iter().skip(m).step_by(r.max(1)));
        for ((ki, mi), (ik, im)) in row_k.iter().zip(row_m).zip(columns) {
            g += ki * ki + mi * mi + ik * ik + im * im;
            h += ki * mi - ik * im;
            turned += 0.5 * ((ki * ki - mi * mi) - (ik * ik - im * im));
        }
        // The sums are meant without the plane itself.
        g -= 2.0 * (kk * kk + mm * mm + km * km + mk * mk);
        h -= kk * mk + km * mm - kk * km - mk * mm;
        turned -= km * km - mk * mk;
        let (d, symmetric, e) = (kk - mm, km + mk, km - mk);
        let tan = if symmetric == 0.0 {
            0.0
        } else {
            let cot2 = d / symmetric;
            let root = libm::sqrt(1.0 + cot2 * cot2);
            1.0 / (cot2 + if cot2 < 0.0 { -root } else { root })
        };
        let tan = if tan.is_finite() { tan } else { 0.0 };
        let c = 1.0 / libm::sqrt(1.0 + tan * tan);
        let s = tan * c;
        let (cos2, sin2) = (c * c - s * s, 2.0 * s * c);
        let d = d * cos2 + symmetric * sin2;
        let h = h * cos2 - turned * sin2;
        let scale = (if g > 0.0 { g } else { 0.0 }) + 2.0 * (d * d + e * e);
        let tanh = if scale > 0.0 { ((d * e - h) / scale).clamp(-0.5, 0.5) } else { 0.0 };
        let ch = 1.0 / libm::sqrt(1.0 - tanh * tanh);
        let sh = ch * tanh;
        Some(Self {
            c1: ch * c - sh * s,
            c2: ch * c + sh * s,
            s1: ch * s + sh * c,
            s2: sh * c - ch * s,
            size: tan.abs().max(tanh.abs()),
        })
    }

    /// Rows `k` and `m` of `a`.
    fn apply_left(&self, a: &mut [f64], r: usize, k: usize, m: usize) {
        let Some((row_k, row_m)) = pair(a, r, k, m) else { return };
        for (x, y) in row_k.iter_mut().zip(row_m) {
            (*x, *y) = (self.c1 * *x + self.s1 * *y, self.s2 * *x + self.c2 * *y);
        }
    }

    /// Columns `k` and `m` of `a`.
    fn apply_right(&self, a: &mut [f64], r: usize, k: usize, m: usize) {
        for row in a.chunks_exact_mut(r.max(1)) {
            let (Some(&x), Some(&y)) = (row.get(k), row.get(m)) else { return };
            if let Some(out) = row.get_mut(k) {
                *out = self.c2 * x - self.s2 * y;
            }
            if let Some(out) = row.get_mut(m) {
                *out = self.c1 * y - self.s1 * x;
            }
        }
    }

    /// Columns `k` and `m` of a matrix stored column by column.
    fn apply_right_transposed(&self, a: &mut [f64], r: usize, k: usize, m: usize) {
        let Some((column_k, column_m)) = pair(a, r, k, m) else { return };
        for (x, y) in column_k.iter_mut().zip(column_m) {
            (*x, *y) = (self.c2 * *x - self.s2 * *y, self.c1 * *y - self.s1 * *x);
        }
    }
}

/// Rows `k < m`.
fn pair(a: &mut [f64], r: usize, k: usize, m: usize) -> Option<(&mut [f64], &mut [f64])> {
    let (before, from_m) = a.split_at_mut_checked(m * r)?;
    Some((before.get_mut(k * r..(k + 1) * r)?, from_m.get_mut(..r)?))
}

#[cfg(test)]
mod tests {
    use super::{MAX_SWEEPS, diagonalise};

    const R: usize = 9;

    /// Numbers between −1 and 1, the same everywhere.
    fn numbers() -> impl Iterator<Item = f64> {
        (1u32..).map(|n| f64::from(n.wrapping_mul(2_654_435_761) >> 8) / f64::from(1 << 23) - 1.0)
    }

    fn product(a: &[f64], b: &[f64]) -> [f64; R * R] {
        core::array::from_fn(|ij| (0..R).map(|k| a[ij / R * R + k] * b[k * R + ij % R]).sum())
    }

    /// `P diag(λ) Q` of a `P` near the identity and its inverse by the Neumann series.
    fn similar(lambda: [f64; R]) -> [f64; R * R] {
        let mut random = numbers();
        let small: [f64; R * R] = core::array::from_fn(|_| 0.08 * random.next().unwrap_or_default());
        let unit = |ij: usize| f64::from(u8::from(ij / R == ij % R));
        let (mut inverse, mut power): ([f64; R * R], [f64; R * R]) =
            (core::array::from_fn(unit), core::array::from_fn(unit));
        for _ in 0..200 {
            power = product(&power, &small.map(|x| -x));
            inverse.iter_mut().zip(power).for_each(|(sum, x)| *sum += x);
        }
        let scaled: [f64; R * R] = core::array::from_fn(|ij| (small[ij] + unit(ij)) * lambda[ij % R]);
        product(&scaled, &inverse)
    }

    fn solved(a: [f64; R * R]) -> ([f64; R * R], [f64; R * R], [f64; R * R], usize) {
        let (mut d, mut columns, mut rows) = (a, [0.0; R * R], [0.0; R * R]);
        let sweeps = diagonalise(&mut d, &mut columns, &mut rows, R).expect("R² numbers each");
        (d, columns, rows, sweeps)
    }

    #[test]
    fn eigenvalues_come_back_and_the_vectors_rebuild_the_matrix() {
        // Four decades, and a triple one: nothing to choose between its vectors.
        let spread = core::array::from_fn(|k| -(10.0f64).powf(-0.5 * k as f64));
        let triple = [-0.9, -0.5, -0.5, -0.5, -0.1, -0.05, -0.01, -0.01, -0.002];
        for lambda in [spread, triple] {
            let a = similar(lambda);
            let (d, columns, rows, sweeps) = solved(a);
            assert!(sweeps < 12, "{sweeps} sweeps");
            let mut found: [f64; R] = core::array::from_fn(|k| d[k * R + k]);
            found.sort_by(f64::total_cmp);
            let mut known = lambda;
            known.sort_by(f64::total_cmp);
            // A few hundred rotations, each good to a rounding of the largest entry (1).
            assert!(found.iter().zip(known).all(|(a, b)| (a - b).abs() < 1e-13), "{found:?} {known:?}");
            let x: [f64; R * R] = core::array::from_fn(|ij| columns[ij % R * R + ij / R]);
            let rebuilt = product(&product(&x, &d), &rows);
            assert!(rebuilt.iter().zip(a).all(|(a, b)| (a - b).abs() < 1e-13));
            let unit = product(&x, &rows);
            assert!((0..R * R).all(|ij| (unit[ij] - f64::from(u8::from(ij / R == ij % R))).abs() < 1e-13));
        }
    }

    #[test]
    fn what_has_no_real_eigenvectors_ends_too() {
        let mut turning = similar([-0.5; R]);
        (turning[1], turning[R]) = (0.3, -0.3);
        let defective = core::array::from_fn(|ij| if ij / R <= ij % R { 1.0 } else { 0.0 });
        for a in [turning, defective, [f64::NAN; R * R], [f64::INFINITY; R * R], [0.0; R * R]] {
            assert!(solved(a).3 <= MAX_SWEEPS);
        }
    }
}
