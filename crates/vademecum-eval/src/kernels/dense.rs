//! Dense matrices in lent slices, row by row: products, Cholesky's factor, elimination.
//!
//! A row outside of a matrix is empty, so a slice that is too short gives wrong numbers and no panic; callers
//! take theirs from memory whose length was checked.

use wide::f64x4;

/// Row `i` of a matrix of `n` columns.
#[inline]
pub(crate) fn row(a: &[f64], i: usize, n: usize) -> &[f64] {
    let start = i.saturating_mul(n);
    a.get(start..start.saturating_add(n)).unwrap_or_default()
}

/// [`row`], to be written.
#[inline]
pub(crate) fn row_mut(a: &mut [f64], i: usize, n: usize) -> &mut [f64] {
    let start = i.saturating_mul(n);
    a.get_mut(start..start.saturating_add(n)).unwrap_or_default()
}

/// Number `i`, 0 outside.
#[inline]
pub(crate) fn at(a: &[f64], i: usize) -> f64 {
    a.get(i).copied().unwrap_or(0.0)
}

/// Writes number `i`, if there is one.
#[inline]
pub(crate) fn set(a: &mut [f64], i: usize, value: f64) {
    if let Some(place) = a.get_mut(i) {
        *place = value;
    }
}

/// `a · b`, in four sums.
#[inline]
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    let n = a.len().min(b.len());
    let (a, b) = (a.get(..n).unwrap_or_default(), b.get(..n).unwrap_or_default());
    let ((a, a_rest), (b, b_rest)) = (a.as_chunks::<4>(), b.as_chunks::<4>());
    let mut sums = f64x4::ZERO;
    for (a, b) in a.iter().zip(b) {
        sums += f64x4::from(*a) * f64x4::from(*b);
    }
    let rest: f64 = a_rest.iter().zip(b_rest).map(|(a, b)| a * b).sum();
    let [p, q, r, s] = sums.to_array();
    (p + q) + (r + s) + rest
}

/// `out += s x`.
#[inline]
pub(crate) fn add_scaled(out: &mut [f64], s: f64, x: &[f64]) {
    out.iter_mut().zip(x).for_each(|(out, x)| *out += s * x);
}

/// `out += A B`, `A` of `k` columns, `B` of `n`.
#[cfg(feature = "assembly")]
pub(crate) fn add_product(out: &mut [f64], a: &[f64], k: usize, b: &[f64], n: usize) {
    for (out, a) in out.chunks_exact_mut(n.max(1)).zip(a.chunks_exact(k.max(1))) {
        for (&a, b) in a.iter().zip(b.chunks_exact(n.max(1))) {
            if a != 0.0 {
                add_scaled(out, a, b);
            }
        }
    }
}

/// `out += Aᵀ B`, `A` of `k` columns, `B` of `n`, with as many rows.
#[cfg(feature = "assembly")]
pub(crate) fn add_transposed_product(out: &mut [f64], a: &[f64], k: usize, b: &[f64], n: usize) {
    for (a, b) in a.chunks_exact(k.max(1)).zip(b.chunks_exact(n.max(1))) {
        for (out, &a) in out.chunks_exact_mut(n.max(1)).zip(a) {
            if a != 0.0 {
                add_scaled(out, a, b);
            }
        }
    }
}

/// `out = A x`, a number for each row of `A`.
pub(crate) fn apply(a: &[f64], x: &[f64], out: &mut [f64]) {
    for (i, out) in out.iter_mut().enumerate() {
        *out = dot(row(a, i, x.len()), x);
    }
}

/// `out += Aᵀ x`, a row of `A` for each number of `x`.
#[cfg(feature = "assembly")]
pub(crate) fn add_transposed(a: &[f64], x: &[f64], out: &mut [f64]) {
    let n = out.len();
    for (i, &x) in x.iter().enumerate() {
        add_scaled(out, x, row(a, i, n));
    }
}

/// `A ← (A + Aᵀ)/2`.
pub(crate) fn symmetrise(a: &mut [f64], n: usize) {
    for i in 0..n {
        for j in 0..i {
            let mean = 0.5 * (at(a, i * n + j) + at(a, j * n + i));
            set(a, i * n + j, mean);
            set(a, j * n + i, mean);
        }
    }
}

/// `A ← Aᵀ`.
pub(crate) fn transpose(a: &mut [f64], n: usize) {
    for i in 0..n {
        for j in 0..i {
            let (below, above) = (at(a, i * n + j), at(a, j * n + i));
            set(a, i * n + j, above);
            set(a, j * n + i, below);
        }
    }
}

/// Cholesky's factor `L` of the symmetric `A = L Lᵀ` of `n` rows, in the place of its lower half; the upper
/// half stays.
///
/// # Errors
/// The first row whose pivot is not above `least` of the diagonal entry, or not a number.
pub(crate) fn factor(a: &mut [f64], n: usize, least: f64) -> Result<(), usize> {
    for i in 0..n {
        let (above, own) = a.split_at_mut_checked(i * n).ok_or(i)?;
        let own = own.get_mut(..n).ok_or(i)?;
        for j in 0..i {
            let other = row(above, j, n);
            let (before, _) = own.split_at_checked(j).ok_or(i)?;
            let left = at(own, j) - dot(before, other.get(..j).ok_or(i)?);
            set(own, j, left / at(other, j));
        }
        let before = own.get(..i).ok_or(i)?;
        let (entry, taken) = (at(own, i), dot(before, before));
        let pivot = entry - taken;
        // Not a number is above nothing.
        if !(pivot > 0.0 && pivot > least * entry && pivot.is_finite()) {
            return Err(i);
        }
        set(own, i, libm::sqrt(pivot));
    }
    Ok(())
}

/// `x ← L⁻¹ x` with the leading rows of a factor of `n` columns, as many as `x` has numbers.
pub(crate) fn solve_lower(l: &[f64], n: usize, x: &mut [f64]) {
    for i in 0..x.len() {
        let own = row(l, i, n);
        let (before, rest) = x.split_at_mut(i.min(x.len()));
        if let Some(x) = rest.first_mut() {
            *x = (*x - dot(own, before)) / at(own, i);
        }
    }
}

/// `x ← L⁻ᵀ x`, as [`solve_lower`].
pub(crate) fn solve_upper(l: &[f64], n: usize, x: &mut [f64]) {
    for i in (0..x.len()).rev() {
        let own = row(l, i, n);
        let (before, rest) = x.split_at_mut(i.min(x.len()));
        if let Some(x) = rest.first_mut() {
            *x /= at(own, i);
            let value = *x;
            add_scaled(before, -value, own);
        }
    }
}

/// `X ← L⁻¹ X` for a matrix of `n` rows and `columns` columns.
pub(crate) fn solve_lower_rows(l: &[f64], n: usize, x: &mut [f64], columns: usize) {
    for i in 0..n {
        let own = row(l, i, n).get(..i).unwrap_or_default();
        let Some((above, rest)) = x.split_at_mut_checked(i.saturating_mul(columns)) else { return };
        let out = rest.get_mut(..columns).unwrap_or_default();
        let (fours, last) = own.as_chunks::<4>();
        for (&[p, q, r, s], rows) in fours.iter().zip(above.chunks_exact((4 * columns).max(1))) {
            let [a, b, c, d] = [0, 1, 2, 3].map(|j| row(rows, j, columns));
            for ((((out, a), b), c), d) in out.iter_mut().zip(a).zip(b).zip(c).zip(d) {
                *out -= (p * a + q * b) + (r * c + s * d);
            }
        }
        for (j, &l) in last.iter().enumerate() {
            add_scaled(out, -l, row(above, 4 * fours.len() + j, columns));
        }
        let scale = 1.0 / at(row(l, i, n), i);
        out.iter_mut().for_each(|x| *x *= scale);
    }
}

/// The half below the diagonal of `X ← X L⁻ᵀ` for a matrix of `n` rows and columns.
pub(crate) fn solve_right(l: &[f64], n: usize, x: &mut [f64]) {
    for (i, own) in x.chunks_exact_mut(n.max(1)).enumerate() {
        solve_lower(l, n, own.get_mut(..i + 1).unwrap_or_default());
    }
}

/// `X ← L⁻ᵀ X` for a matrix of `n` rows and `columns` columns.
#[cfg(feature = "assembly")]
pub(crate) fn solve_upper_rows(l: &[f64], n: usize, x: &mut [f64], columns: usize) {
    for i in (0..n).rev() {
        let own = row(l, i, n);
        let Some((above, rest)) = x.split_at_mut_checked(i.saturating_mul(columns)) else { return };
        let out = rest.get_mut(..columns).unwrap_or_default();
        let scale = 1.0 / at(own, i);
        out.iter_mut().for_each(|x| *x *= scale);
        for (j, &l) in own.iter().take(i).enumerate() {
            add_scaled(row_mut(above, j, columns), -l, out);
        }
    }
}

/// Solves `A x = b` by elimination with row pivots; `A` of `n` rows is overwritten, `b` becomes `x`.
///
/// # Errors
/// A column without a pivot.
#[cfg(feature = "assembly")]
pub(crate) fn eliminate(a: &mut [f64], n: usize, b: &mut [f64]) -> Result<(), usize> {
    for k in 0..n {
        let size = |i: &usize| at(a, i * n + k).abs();
        let best = (k..n).max_by(|i, j| size(i).total_cmp(&size(j))).ok_or(k)?;
        let (upper, lower) = a.split_at_mut_checked((k + 1) * n).ok_or(k)?;
        let own = row_mut(upper, k, n);
        if best != k {
            let other = row_mut(lower, best - k - 1, n);
            own.swap_with_slice(other.get_mut(..own.len()).ok_or(k)?);
            let (one, other) = (at(b, k), at(b, best));
            set(b, k, other);
            set(b, best, one);
        }
        let pivot = at(own, k);
        if pivot == 0.0 || !pivot.is_finite() {
            return Err(k);
        }
        let value = at(b, k);
        for (i, other) in lower.chunks_exact_mut(n).enumerate() {
            let share = at(other, k) / pivot;
            if share != 0.0 {
                let (to, from) = (other.get_mut(k..).unwrap_or_default(), own.get(k..).unwrap_or_default());
                add_scaled(to, -share, from);
                let left = at(b, k + 1 + i) - share * value;
                set(b, k + 1 + i, left);
            }
        }
    }
    for k in (0..n).rev() {
        let own = row(a, k, n);
        let known = dot(own.get(k + 1..).unwrap_or_default(), b.get(k + 1..).unwrap_or_default());
        let value = (at(b, k) - known) / at(own, k);
        set(b, k, value);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    extern crate std;

    use super::*;
    use std::vec;
    use std::vec::Vec;

    /// A matrix of numbers between −1 and 1.
    pub(crate) fn numbers(count: usize, mut seed: u64) -> Vec<f64> {
        let mut next = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 11) as f64 / (1u64 << 52) as f64 - 1.0
        };
        (0..count).map(|_| next()).collect()
    }

    fn largest(a: &[f64], b: &[f64]) -> f64 {
        assert_eq!(a.len(), b.len());
        a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    }

    /// `AᵀA + I`.
    fn definite(n: usize) -> Vec<f64> {
        let a = numbers(n * n, n as u64);
        let mut square = vec![0.0; n * n];
        add_transposed_product(&mut square, &a, n, &a, n);
        (0..n).for_each(|i| square[i * n + i] += 1.0);
        square
    }

    #[test]
    fn products_are_those_of_their_sums() {
        let (n, k, m) = (5, 7, 6);
        let (a, b) = (numbers(n * k, 1), numbers(k * m, 2));
        let mut out = vec![0.0; n * m];
        add_product(&mut out, &a, k, &b, m);
        let mut turned = vec![0.0; k * n];
        (0..n * k).for_each(|e| turned[(e % k) * n + e / k] = a[e]);
        let mut other = vec![0.0; n * m];
        add_transposed_product(&mut other, &turned, n, &b, m);
        for i in 0..n {
            for j in 0..m {
                let sum: f64 = (0..k).map(|l| a[i * k + l] * b[l * m + j]).sum();
                assert!((out[i * m + j] - sum).abs() < 1e-14 && (other[i * m + j] - sum).abs() < 1e-14);
            }
        }
        let mut image = vec![0.0; n];
        apply(&a, &b[..k], &mut image);
        assert!((image[2] - (0..k).map(|l| a[2 * k + l] * b[l]).sum::<f64>()).abs() < 1e-14);
        let mut image = vec![0.0; n];
        add_transposed(&turned, &b[..k], &mut image);
        assert!((image[3] - (0..k).map(|l| a[3 * k + l] * b[l]).sum::<f64>()).abs() < 1e-14);
    }

    #[test]
    fn a_factor_solves_from_both_sides_and_leading_rows_alone() {
        for n in [1, 2, 17, 64] {
            let a = definite(n);
            let mut l = a.clone();
            factor(&mut l, n, 1e-12).expect("definite");
            let x = numbers(n, 9);
            let mut b = vec![0.0; n];
            apply(&a, &x, &mut b);
            let mut columns: Vec<f64> = b.iter().flat_map(|b| [*b, 2.0 * b]).collect();
            solve_lower(&l, n, &mut b);
            solve_upper(&l, n, &mut b);
            assert!(largest(&b, &x) < 1e-11, "{n}");
            solve_lower_rows(&l, n, &mut columns, 2);
            solve_upper_rows(&l, n, &mut columns, 2);
            let expected: Vec<f64> = x.iter().flat_map(|x| [*x, 2.0 * x]).collect();
            assert!(largest(&columns, &expected) < 1e-11, "{n}");
            let half = n / 2;
            let (mut lead, mut known) = (vec![0.0; half * half], x[..half].to_vec());
            (0..half * half).for_each(|e| lead[e] = a[e / half.max(1) * n + e % half.max(1)]);
            solve_lower(&l, n, &mut known);
            solve_upper(&l, n, &mut known);
            let mut back = vec![0.0; half];
            apply(&lead, &known, &mut back);
            assert!(largest(&back, &x[..half]) < 1e-11, "{n}");
        }
    }

    #[test]
    fn the_row_that_follows_from_others_is_named() {
        let n = 6;
        let mut a = numbers(n * n, 3);
        // Row 4 of a Gram matrix is the sum of two others.
        for k in 0..n {
            a[4 * n + k] = a[n + k] + a[2 * n + k];
        }
        let mut gram = vec![0.0; n * n];
        for i in 0..n {
            for j in 0..n {
                gram[i * n + j] = dot(row(&a, i, n), row(&a, j, n));
            }
        }
        assert_eq!(factor(&mut gram, n, 1e-11), Err(4));
        assert_eq!(factor(&mut [0.0], 1, 0.0), Err(0));
        assert_eq!(factor(&mut [f64::NAN], 1, 0.0), Err(0));
        assert_eq!(factor(&mut [1.0], 2, 0.0), Err(0));
    }

    #[test]
    fn elimination_finds_what_went_in_and_names_a_column_without_pivot() {
        for n in [1, 2, 33] {
            let mut a = numbers(n * n, 4);
            let x = numbers(n, 5);
            let mut b = vec![0.0; n];
            apply(&a, &x, &mut b);
            eliminate(&mut a, n, &mut b).expect("regular");
            assert!(largest(&b, &x) < 1e-10, "{n}");
        }
        // A zero where the first pivot would stand.
        let (mut a, mut b) = ([0.0, 1.0, 2.0, 0.0], [3.0, 4.0]);
        eliminate(&mut a, 2, &mut b).expect("regular");
        assert_eq!(b, [2.0, 3.0]);
        assert_eq!(eliminate(&mut [1.0, 1.0, 1.0, 1.0], 2, &mut [1.0, 1.0]), Err(1));
    }

    #[test]
    fn symmetric_and_transposed_are_what_they_are_called() {
        let mut a = [1.0, 2.0, 4.0, 3.0];
        transpose(&mut a, 2);
        assert_eq!(a, [1.0, 4.0, 2.0, 3.0]);
        symmetrise(&mut a, 2);
        assert_eq!(a, [1.0, 3.0, 3.0, 3.0]);
    }
}
