//! Eigenvalues and eigenvectors of a symmetric matrix in lent memory.
//!
//! Householder's reflections make the matrix tridiagonal, and implicit steps of QL with Wilkinson's shift
//! make it diagonal (Golub and Van Loan 2013, §8.3). Eigenvectors are products of reflections and rotations,
//! so they are orthonormal to rounding, those of equal eigenvalues too.

use super::dense::{add_scaled, at, dot, row, row_mut, set};
use wide::f64x4;

/// Steps of QL for one eigenvalue; two are usual.
const STEPS: usize = 60;

/// Rounding of a matrix whose largest entry is 1: a smaller entry beside the diagonal is none.
const ROUNDING: f64 = 0.1 * f64::EPSILON;

/// Numbers of work for a matrix of `n` rows.
pub(crate) const fn eigen_work(n: usize) -> usize {
    n.saturating_mul(4)
}

/// The eigenproblem does not converge: a number is not finite.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct NoConvergence;

/// Eigenvalues of the symmetric `a` of `n` rows, ascending, into `values`, and eigenvectors into `vectors`,
/// the rows of which they are. `a` is overwritten; lends [`eigen_work`]. `O(n³)`.
///
/// # Errors
/// [`NoConvergence`]; also for lent memory that is too short.
pub(crate) fn symmetric_eigen(
    a: &mut [f64],
    n: usize,
    values: &mut [f64],
    vectors: &mut [f64],
    work: &mut [f64],
) -> Result<(), NoConvergence> {
    let square = n.checked_mul(n).ok_or(NoConvergence)?;
    let a = a.get_mut(..square).ok_or(NoConvergence)?;
    let vectors = vectors.get_mut(..square).ok_or(NoConvergence)?;
    let values = values.get_mut(..n).ok_or(NoConvergence)?;
    let (off, work) = work.split_at_mut_checked(n).ok_or(NoConvergence)?;
    let (betas, work) = work.split_at_mut_checked(n).ok_or(NoConvergence)?;
    let (w, work) = work.split_at_mut_checked(n).ok_or(NoConvergence)?;
    let next = work.get_mut(..n).ok_or(NoConvergence)?;
    if n == 0 {
        return Ok(());
    }
    let scale = to_one(a)?;
    reduce(a, n, values, off, (betas, w, next));
    accumulate(a, n, betas, vectors);
    diagonalise(values, off, vectors, n)?;
    values.iter_mut().for_each(|x| *x *= scale);
    sort(values, vectors, n);
    Ok(())
}

/// Divides numbers by the largest of them, which is given back: near 1 they neither overflow nor vanish when
/// they are squared.
///
/// # Errors
/// [`NoConvergence`]: a number that is not finite.
pub(super) fn to_one(a: &mut [f64]) -> Result<f64, NoConvergence> {
    let largest = a.iter().fold(0.0, |m: f64, x| if x.abs() > m || x.is_nan() { x.abs() } else { m });
    if !largest.is_finite() {
        return Err(NoConvergence);
    }
    let scale = if largest > 0.0 { largest } else { 1.0 };
    a.iter_mut().for_each(|x| *x /= scale);
    Ok(scale)
}

/// Reflections `I − β v vᵀ` that make the symmetric `a` tridiagonal, from the last row up, so that small
/// eigenvalues of a matrix whose first rows are the small ones keep their digits. Only the half below the
/// diagonal is read; `v` of row `k` stays in its first `k` entries.
///
/// A reflection changes the block before its row to `A − v wᵀ − w vᵀ` with `w = β A v − ½ β² (vᵀA v) v`. This
/// change and the product with the next `v` are one pass over `A`.
pub(super) fn reduce(
    a: &mut [f64],
    n: usize,
    diagonal: &mut [f64],
    off: &mut [f64],
    (betas, w, next): (&mut [f64], &mut [f64], &mut [f64]),
) {
    off.fill(0.0);
    betas.fill(0.0);
    w.fill(0.0);
    let (mut w, mut next) = (w, next);
    for k in (1..n).rev() {
        let Some((upper, lower)) = a.split_at_mut_checked(k * n) else { return };
        // The last reflection, whose `v` is the row below; none before the first.
        let (own, below) = lower.split_at_mut_checked(n).unwrap_or_default();
        let before = if below.is_empty() { &*w } else { below.get(..k + 1).unwrap_or_default() };
        let before = before.get(..k + 1).unwrap_or_default();
        let w_before = w.get(..k + 1).unwrap_or_default();
        let own = own.get_mut(..k + 1).unwrap_or_default();
        let [vk, wk] = [at(before, k), at(w_before, k)];
        own.iter_mut().zip(w_before).zip(before).for_each(|((a, w), v)| *a -= vk * w + wk * v);
        set(diagonal, k, at(own, k));
        let v = own.get_mut(..k).unwrap_or_default();
        let beta = reflection(v, off);
        set(betas, k, beta);
        let next_w = next.get_mut(..k).unwrap_or_default();
        next_w.fill(0.0);
        for (i, row) in upper.chunks_exact_mut(n).enumerate() {
            pass(row.get_mut(..i + 1).unwrap_or_default(), [before, w_before, v], next_w);
        }
        next_w.iter_mut().for_each(|w| *w *= beta);
        let share = 0.5 * beta * dot(next_w, v);
        add_scaled(next_w, -share, v);
        core::mem::swap(&mut w, &mut next);
    }
    let last = 2.0 * at(a, n) * at(w, 0);
    set(diagonal, 0, at(a, 0) - if n > 1 { last } else { 0.0 });
}

/// Makes a row the `v` of a reflection of it onto its last entry, which goes to `off`; returns its `β`.
fn reflection(v: &mut [f64], off: &mut [f64]) -> f64 {
    let count = v.len();
    let Some((first, rest)) = v.split_last_mut() else { return 0.0 };
    let squares = dot(rest, rest);
    if squares == 0.0 {
        set(off, count - 1, *first);
        return 0.0;
    }
    let length = libm::sqrt(*first * *first + squares);
    // The sign that does not cancel.
    let image = if *first > 0.0 { -length } else { length };
    set(off, count - 1, image);
    *first -= image;
    2.0 / (*first * *first + squares)
}

/// One row, up to its diagonal, of `A ← A − v wᵀ − w vᵀ`, and its part of `p += A u`.
#[inline]
fn pass(row: &mut [f64], vectors: [&[f64]; 3], p: &mut [f64]) {
    let Some((own, row)) = row.split_last_mut() else { return };
    let i = row.len();
    let [vi, wi, ui] = vectors.map(|x| at(x, i));
    let [v, w, u] = vectors.map(|x| x.get(..i).unwrap_or_default());
    let Some((p, behind)) = p.split_at_mut_checked(i) else { return };
    let [(v, v_rest), (w, w_rest), (u, u_rest)] = [v, w, u].map(<[f64]>::as_chunks::<4>);
    let (a, a_rest) = row.as_chunks_mut::<4>();
    let (p, p_rest) = p.as_chunks_mut::<4>();
    let mut sums = f64x4::ZERO;
    let [vs, ws, us] = [vi, wi, ui].map(f64x4::splat);
    for ((((a, v), w), u), p) in a.iter_mut().zip(v).zip(w).zip(u).zip(p) {
        let changed = f64x4::from(*a) - (vs * f64x4::from(*w) + ws * f64x4::from(*v));
        sums += changed * f64x4::from(*u);
        *p = (f64x4::from(*p) + us * changed).to_array();
        *a = changed.to_array();
    }
    let mut sum: f64 = sums.to_array().iter().sum();
    for ((((a, v), w), u), p) in a_rest.iter_mut().zip(v_rest).zip(w_rest).zip(u_rest).zip(p_rest) {
        *a -= vi * w + wi * v;
        sum += *a * u;
        *p += ui * *a;
    }
    *own -= 2.0 * vi * wi;
    if let Some(p) = behind.first_mut() {
        *p += sum + *own * ui;
    }
}

/// `x ← H x` of each row `x`, with the product `H` of all reflections of [`reduce`].
pub(super) fn turn_back(a: &[f64], n: usize, betas: &[f64], rows: &mut [f64]) {
    for k in 1..n {
        let beta = at(betas, k);
        if beta == 0.0 {
            continue;
        }
        let v = row(a, k, n).get(..k).unwrap_or_default();
        for x in rows.chunks_exact_mut(n) {
            let x = x.get_mut(..k).unwrap_or_default();
            let share = beta * dot(x, v);
            add_scaled(x, -share, v);
        }
    }
}

/// The product of all reflections, its columns as the rows of `vectors`.
fn accumulate(a: &[f64], n: usize, betas: &[f64], vectors: &mut [f64]) {
    vectors.fill(0.0);
    (0..n).for_each(|i| set(vectors, i * n + i, 1.0));
    for k in 1..n {
        let beta = at(betas, k);
        if beta == 0.0 {
            continue;
        }
        let v = row(a, k, n).get(..k).unwrap_or_default();
        for i in 0..k {
            let own = row_mut(vectors, i, n).get_mut(..k).unwrap_or_default();
            let share = beta * dot(own, v);
            add_scaled(own, -share, v);
        }
    }
}

/// Eigenvalues of a tridiagonal matrix by the rational QL of Pal, Walker and Kahan, which takes no square
/// roots (Parlett 1998, §8.15). `e` is overwritten; `d` becomes the eigenvalues, in any order.
pub(super) fn values_alone(d: &mut [f64], e: &mut [f64], n: usize) -> Result<(), NoConvergence> {
    e.iter_mut().for_each(|e| *e *= *e);
    for l in 0..n {
        let mut steps = 0;
        loop {
            let small = |m: &usize| {
                let size = at(d, *m).abs() + at(d, m + 1).abs();
                let least = (0.5 * f64::EPSILON * size).max(ROUNDING);
                at(e, *m) <= least * least
            };
            let m = (l..n - 1).find(small).unwrap_or(n - 1);
            if m == l {
                break;
            }
            steps += 1;
            if steps > STEPS {
                return Err(NoConvergence);
            }
            // Wilkinson's shift.
            let beside = libm::sqrt(at(e, l));
            let g = (at(d, l + 1) - at(d, l)) / (2.0 * beside);
            let shift = at(d, l) - beside / (g + libm::copysign(libm::hypot(g, 1.0), g));
            let (mut c, mut s) = (1.0, 0.0);
            let mut gamma = at(d, m) - shift;
            let mut p = gamma * gamma;
            for i in (l..m).rev() {
                let square = at(e, i);
                let r = p + square;
                if i + 1 < m {
                    set(e, i + 1, s * r);
                }
                let c_before = c;
                c = p / r;
                s = square / r;
                let gamma_before = gamma;
                let own = at(d, i);
                gamma = c * (own - shift) - s * gamma_before;
                set(d, i + 1, gamma_before + (own - gamma));
                p = if c == 0.0 { c_before * square } else { gamma * gamma / c };
            }
            set(e, l, s * p);
            set(d, l, shift + gamma);
            set(e, m, 0.0);
        }
    }
    Ok(())
}

/// QL on a tridiagonal matrix; rotations turn rows of `vectors`, which may be empty.
pub(super) fn diagonalise(
    d: &mut [f64],
    e: &mut [f64],
    vectors: &mut [f64],
    n: usize,
) -> Result<(), NoConvergence> {
    for l in 0..n {
        let mut steps = 0;
        loop {
            let small = |m: &usize| {
                let size = at(d, *m).abs() + at(d, m + 1).abs();
                at(e, *m).abs() <= (0.5 * f64::EPSILON * size).max(ROUNDING)
            };
            let m = (l..n - 1).find(small).unwrap_or(n - 1);
            if m == l {
                break;
            }
            steps += 1;
            if steps > STEPS {
                return Err(NoConvergence);
            }
            // Wilkinson's shift.
            let mut g = (at(d, l + 1) - at(d, l)) / (2.0 * at(e, l));
            let mut r = libm::hypot(g, 1.0);
            g = at(d, m) - at(d, l) + at(e, l) / (g + libm::copysign(r, g));
            let (mut s, mut c, mut p) = (1.0, 1.0, 0.0);
            let mut split = false;
            for i in (l..m).rev() {
                let f = s * at(e, i);
                let b = c * at(e, i);
                r = libm::hypot(f, g);
                set(e, i + 1, r);
                if r == 0.0 {
                    set(d, i + 1, at(d, i + 1) - p);
                    set(e, m, 0.0);
                    split = true;
                    break;
                }
                s = f / r;
                c = g / r;
                g = at(d, i + 1) - p;
                r = (at(d, i) - g) * s + 2.0 * c * b;
                p = s * r;
                set(d, i + 1, g + p);
                g = c * r - b;
                turn(vectors, i, n, [c, s]);
            }
            if !split {
                set(d, l, at(d, l) - p);
                set(e, l, g);
                set(e, m, 0.0);
            }
        }
    }
    Ok(())
}

/// Turns rows `i` and `i + 1`.
#[inline]
fn turn(vectors: &mut [f64], i: usize, n: usize, [c, s]: [f64; 2]) {
    let Some((head, tail)) = vectors.split_at_mut_checked((i + 1) * n) else { return };
    for (a, b) in row_mut(head, i, n).iter_mut().zip(row_mut(tail, 0, n)) {
        let f = *b;
        *b = s * *a + c * f;
        *a = c * *a - s * f;
    }
}

/// Ascending.
fn sort(values: &mut [f64], vectors: &mut [f64], n: usize) {
    for i in 0..n {
        let least = (i..n).min_by(|a, b| at(values, *a).total_cmp(&at(values, *b))).unwrap_or(i);
        if least == i {
            continue;
        }
        let (a, b) = (at(values, i), at(values, least));
        set(values, i, b);
        set(values, least, a);
        if let Some((head, tail)) = vectors.split_at_mut_checked(least * n) {
            let pair = row_mut(head, i, n).iter_mut().zip(row_mut(tail, 0, n));
            pair.for_each(|(a, b)| core::mem::swap(a, b));
        }
    }
}

/// `out = f(A) x` of the symmetric matrix with these eigenvalues and eigenvectors; `between` is as long as
/// `x`.
#[cfg(feature = "assembly")]
pub(crate) fn of_matrix(
    (values, vectors): (&[f64], &[f64]),
    f: impl Fn(f64) -> f64,
    x: &[f64],
    between: &mut [f64],
    out: &mut [f64],
) {
    super::dense::apply(vectors, x, between);
    between.iter_mut().zip(values).for_each(|(x, &value)| *x *= f(value));
    out.fill(0.0);
    super::dense::add_transposed(vectors, between, out);
}

#[cfg(test)]
mod tests {
    extern crate std;

    use super::super::dense::apply;
    use super::*;
    use std::vec;
    use std::vec::Vec;

    fn numbers(count: usize, mut seed: u64) -> Vec<f64> {
        let mut next = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 11) as f64 / (1u64 << 52) as f64 - 1.0
        };
        (0..count).map(|_| next()).collect()
    }

    fn solved(a: &[f64], n: usize) -> (Vec<f64>, Vec<f64>) {
        let (mut copy, mut values) = (a.to_vec(), vec![f64::NAN; n]);
        let (mut vectors, mut work) = (vec![f64::NAN; n * n], vec![f64::NAN; eigen_work(n)]);
        symmetric_eigen(&mut copy, n, &mut values, &mut vectors, &mut work).expect("converges");
        (values, vectors)
    }

    /// Residual and orthogonality against 1e-13 n of the largest entry, and ascending order.
    fn check(a: &[f64], n: usize) -> Vec<f64> {
        let (values, vectors) = solved(a, n);
        let size = a.iter().fold(f64::MIN_POSITIVE, |m: f64, x| m.max(x.abs()));
        for i in 0..n {
            let own = row(&vectors, i, n);
            for j in 0..n {
                let image = dot(row(a, j, n), own);
                let residual = (image - values[i] * own[j]).abs();
                assert!(residual <= 1e-13 * n as f64 * size, "{n}: residual {residual:e} at {i}");
                let expected = f64::from(u8::from(i == j));
                let off = (dot(own, row(&vectors, j, n)) - expected).abs();
                assert!(off <= 1e-13 * n as f64, "{n}: vectors {i} and {j} off by {off:e}");
            }
        }
        assert!(values.windows(2).all(|pair| pair[0] <= pair[1]), "{values:?}");
        values
    }

    /// `Q D Qᵀ` with a product of reflections `Q`.
    fn with(values: &[f64], seed: u64) -> Vec<f64> {
        let n = values.len();
        let mut a = vec![0.0; n * n];
        (0..n).for_each(|i| a[i * n + i] = values[i]);
        for k in 0..3 {
            let v = numbers(n, seed + k);
            let beta = 2.0 / dot(&v, &v);
            for _side in 0..2 {
                for own in a.chunks_exact_mut(n) {
                    let share = beta * dot(own, &v);
                    add_scaled(own, -share, &v);
                }
                super::super::dense::transpose(&mut a, n);
            }
        }
        super::super::dense::symmetrise(&mut a, n);
        a
    }

    #[test]
    fn random_matrices_are_diagonalised() {
        for n in [1, 2, 3, 64, 200] {
            let mut a = numbers(n * n, n as u64);
            super::super::dense::symmetrise(&mut a, n);
            let values = check(&a, n);
            let trace: f64 = (0..n).map(|i| a[i * n + i]).sum();
            assert!((values.iter().sum::<f64>() - trace).abs() < 1e-12 * n as f64);
        }
    }

    #[test]
    fn known_eigenvalues_are_found_clusters_and_zeros_among_them() {
        let clusters: Vec<f64> = (0..64).map(|k| f64::from(k / 8)).collect();
        let close: Vec<f64> = (0..64).map(|k| 1.0 + 1e-15 * f64::from(k)).collect();
        let graded: Vec<f64> = (0..64).map(|k| 10f64.powi(k / 4 - 16)).collect();
        let zeros: Vec<f64> = (0..200).map(|k| f64::from((k - 150).max(0))).collect();
        for expected in [clusters, close, graded, zeros] {
            let n = expected.len();
            let found = check(&with(&expected, 7), n);
            let largest = expected.last().copied().unwrap_or(0.0);
            for (a, b) in found.iter().zip(&expected) {
                assert!((a - b).abs() <= 1e-13 * largest, "{a:e} beside {b:e}");
            }
        }
    }

    #[test]
    fn a_string_of_masses_has_its_known_frequencies() {
        let n = 200;
        let mut a = vec![0.0; n * n];
        for i in 0..n {
            a[i * n + i] = 2.0;
            if i > 0 {
                (a[i * n + i - 1], a[(i - 1) * n + i]) = (-1.0, -1.0);
            }
        }
        for (k, found) in check(&a, n).iter().enumerate() {
            let angle = (k + 1) as f64 * core::f64::consts::PI / (2.0 * (n + 1) as f64);
            assert!((found - 4.0 * libm::sin(angle).powi(2)).abs() < 1e-13, "{k}");
        }
    }

    #[test]
    fn zero_and_diagonal_matrices_and_all_sizes_of_numbers_are_matrices() {
        assert_eq!(check(&[0.0; 16], 4), [0.0; 4]);
        assert_eq!(check(&[3.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, 2.0], 3), [-1.0, 2.0, 3.0]);
        assert_eq!(check(&[5.0], 1), [5.0]);
        for size in [1e-200, 1e200] {
            let a = [2.0 * size, size, size, 2.0 * size];
            let values = check(&a, 2);
            assert!((values[0] / size - 1.0).abs() < 1e-15 && (values[1] / size - 3.0).abs() < 1e-15);
        }
        assert!(symmetric_eigen(&mut [], 0, &mut [], &mut [], &mut []).is_ok());
    }

    #[test]
    fn what_is_not_finite_or_too_short_is_refused() {
        for wrong in [f64::NAN, f64::INFINITY] {
            let mut a = [1.0, wrong, wrong, 1.0];
            let found = symmetric_eigen(&mut a, 2, &mut [0.0; 2], &mut [0.0; 4], &mut [0.0; 6]);
            assert_eq!(found, Err(NoConvergence));
        }
        let found = symmetric_eigen(&mut [1.0; 4], 2, &mut [0.0; 2], &mut [0.0; 3], &mut [0.0; 6]);
        assert_eq!(found, Err(NoConvergence));
    }

    #[test]
    fn the_square_root_of_a_matrix_times_itself_is_the_matrix() {
        let a = with(&[1.0, 1.0, 1.5, 4.0], 3);
        let (values, vectors) = solved(&a, 4);
        let (x, mut between, mut half, mut whole) = ([1.0, -2.0, 0.5, 3.0], [0.0; 4], [0.0; 4], [0.0; 4]);
        of_matrix((&values, &vectors), libm::sqrt, &x, &mut between, &mut half);
        of_matrix((&values, &vectors), libm::sqrt, &half, &mut between, &mut whole);
        let mut expected = [0.0; 4];
        apply(&a, &x, &mut expected);
        assert!(whole.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-14));
    }
}
