//! The lowest eigenvalues and eigenvectors of a symmetric matrix in lent memory.
//!
//! Householder's reflections make the matrix tridiagonal, rational QL finds its eigenvalues without vectors,
//! inverse iteration the vectors of the lowest (Golub and Van Loan 2013, §8.3, §8.4; Parlett 1998, §8.15;
//! Wilkinson 1965). Each is orthogonalised against those before it, twice where that takes much of it away,
//! so that vectors of equal eigenvalues are orthonormal to rounding.

use super::dense::{add_scaled, at, dot, set};
use super::eigen::{NoConvergence, eigen_work, reduce, symmetric_eigen, to_one, turn_back, values_alone};
use crate::base::lend::Lender;

/// Inverse iterations of one vector; two are usual.
const ITERATIONS: usize = 4;

/// Numbers of work for the lowest `m` of a matrix of `n` rows.
pub(crate) const fn lowest_work(n: usize, m: usize) -> usize {
    let few = n.saturating_mul(9);
    let all = n.saturating_mul(n).saturating_add(n).saturating_add(eigen_work(n));
    if takes_all(n, m) { all } else { few }
}

/// True where all vectors together are found faster than so many of them one by one.
const fn takes_all(n: usize, m: usize) -> bool {
    n < 8 || m.saturating_mul(2) > n
}

/// The lowest eigenvalues of the symmetric `a` of `n` rows, ascending, as many as `values` has numbers, and
/// their eigenvectors into `vectors`, the rows of which they are. `a` is overwritten; lends [`lowest_work`].
///
/// # Errors
/// [`NoConvergence`]; also for lent memory that is too short.
pub(crate) fn lowest_eigen(
    a: &mut [f64],
    n: usize,
    values: &mut [f64],
    vectors: &mut [f64],
    work: &mut [f64],
) -> Result<(), NoConvergence> {
    let m = values.len();
    if m > n || vectors.len() < m.saturating_mul(n) {
        return Err(NoConvergence);
    }
    let mut lender = Lender::new(work);
    let cut = |_| NoConvergence;
    if takes_all(n, m) {
        let (all, every) = (lender.take(n).map_err(cut)?, lender.take(n * n).map_err(cut)?);
        symmetric_eigen(a, n, all, every, lender.rest())?;
        values.copy_from_slice(all.get(..m).unwrap_or_default());
        vectors.iter_mut().zip(every).for_each(|(to, from)| *to = *from);
        return Ok(());
    }
    let a = a.get_mut(..n * n).ok_or(NoConvergence)?;
    let mut next = || lender.take(n).map_err(cut);
    let (diagonal, off, betas, w, all) = (next()?, next()?, next()?, next()?, next()?);
    let mut pieces = [next()?, next()?, next()?, next()?];
    let scale = to_one(a)?;
    let [next, ..] = &mut pieces;
    reduce(a, n, diagonal, off, (betas, w, next));
    all.copy_from_slice(diagonal);
    w.copy_from_slice(off);
    values_alone(all, w, n)?;
    // The lowest ones, one after the other: a sort is larger, and has a panic that no linker can rule out.
    for value in &mut *values {
        if let Some(least) = all.iter_mut().min_by(|a, b| a.total_cmp(b)) {
            (*value, *least) = (*least, f64::INFINITY);
        }
    }
    inverse_iteration((diagonal, off), values, n, vectors, pieces)?;
    turn_back(a, n, betas, vectors.get_mut(..m * n).unwrap_or_default());
    values.iter_mut().for_each(|x| *x *= scale);
    Ok(())
}

/// Eigenvectors of a tridiagonal matrix of entries up to 1.
fn inverse_iteration(
    (diagonal, off): (&[f64], &[f64]),
    values: &[f64],
    n: usize,
    vectors: &mut [f64],
    [lower, own, upper, second]: [&mut [f64]; 4],
) -> Result<(), NoConvergence> {
    let mut seed = 1_u64;
    let mut shift = f64::NEG_INFINITY;
    for (k, &value) in values.iter().enumerate() {
        // Equal eigenvalues get shifts of their own, so that their matrices differ.
        let apart = 10.0 * f64::EPSILON * value.abs().max(f64::EPSILON);
        shift = if value - shift < apart { shift + apart } else { value };
        eliminate((diagonal, off), shift, n, [lower, own, upper, second]);
        let (before, rest) = vectors.split_at_mut_checked(k * n).ok_or(NoConvergence)?;
        let x = rest.get_mut(..n).ok_or(NoConvergence)?;
        x.iter_mut().for_each(|x| {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            *x = 0.5 + (seed >> 11) as f64 / (1_u64 << 53) as f64;
        });
        orthonormalise(before, n, x)?;
        for _ in 0..ITERATIONS {
            substitute([lower, own, upper, second], x);
            orthonormalise(before, n, x)?;
            if residual((diagonal, off), value, x) <= 4.0 * f64::EPSILON {
                break;
            }
        }
    }
    Ok(())
}

/// Largest entry of `(T − λ) x`.
fn residual((diagonal, off): (&[f64], &[f64]), value: f64, x: &[f64]) -> f64 {
    let entry = |i: usize| {
        let before = if i > 0 { at(off, i - 1) * at(x, i - 1) } else { 0.0 };
        let behind = if i + 1 < x.len() { at(off, i) * at(x, i + 1) } else { 0.0 };
        (before + (at(diagonal, i) - value) * at(x, i) + behind).abs()
    };
    (0..x.len()).map(entry).fold(0.0, f64::max)
}

/// Takes the parts along earlier rows away, twice if they are large, and makes the length 1.
fn orthonormalise(before: &[f64], n: usize, x: &mut [f64]) -> Result<(), NoConvergence> {
    let largest = x.iter().fold(0.0_f64, |m, x| if x.abs() > m || x.is_nan() { x.abs() } else { m });
    if !(largest > 0.0 && largest.is_finite()) {
        return Err(NoConvergence);
    }
    x.iter_mut().for_each(|x| *x /= largest);
    for _ in 0..2 {
        let size = dot(x, x);
        for earlier in before.chunks_exact(n) {
            let share = dot(earlier, x);
            add_scaled(x, -share, earlier);
        }
        let left = dot(x, x);
        let length = libm::sqrt(left);
        if !(length > 0.0 && length.is_finite()) {
            return Err(NoConvergence);
        }
        x.iter_mut().for_each(|x| *x /= length);
        // What is left of a vector that hardly changed is orthogonal to rounding (Parlett 1998, §6.9).
        if left > 0.5 * size {
            break;
        }
    }
    Ok(())
}

/// Elimination of `T − λ` with row pivots: multipliers in `lower`, 4 above their value where rows were
/// exchanged, and the upper diagonals in the others.
fn eliminate(
    (diagonal, off): (&[f64], &[f64]),
    shift: f64,
    n: usize,
    [lower, own, upper, second]: [&mut [f64]; 4],
) {
    for i in 0..n {
        set(own, i, at(diagonal, i) - shift);
        set(upper, i, at(off, i));
        set(second, i, 0.0);
    }
    for i in 0..n.saturating_sub(1) {
        let below = at(off, i);
        let (pivot, beside) = (at(own, i), at(upper, i));
        let (next, behind) = (at(own, i + 1), at(upper, i + 1));
        if pivot.abs() >= below.abs() {
            let pivot = if pivot == 0.0 { f64::EPSILON * f64::EPSILON } else { pivot };
            let share = below / pivot;
            set(own, i, pivot);
            set(lower, i, share);
            set(own, i + 1, next - share * beside);
        } else {
            // Rows are exchanged; such a multiplier is stored 4 away, which no other is.
            let share = pivot / below;
            set(own, i, below);
            set(upper, i, next);
            set(second, i, behind);
            set(lower, i, share + 4.0);
            set(own, i + 1, beside - share * next);
            set(upper, i + 1, -share * behind);
        }
    }
    let last = n.saturating_sub(1);
    if at(own, last).abs() < f64::EPSILON * f64::EPSILON {
        set(own, last, f64::EPSILON * f64::EPSILON);
    }
}

/// Solves with what [`eliminate`] left.
fn substitute([lower, own, upper, second]: [&[f64]; 4], x: &mut [f64]) {
    let n = x.len();
    for i in 0..n.saturating_sub(1) {
        let share = at(lower, i);
        let (this, next) = (at(x, i), at(x, i + 1));
        if share > 2.0 {
            set(x, i, next);
            set(x, i + 1, this - (share - 4.0) * next);
        } else {
            set(x, i + 1, next - share * this);
        }
    }
    for i in (0..n).rev() {
        let known = at(upper, i) * at(x, i + 1) + at(second, i) * at(x, i + 2);
        let known = if i + 1 < n { known } else { 0.0 };
        set(x, i, (at(x, i) - known) / at(own, i));
    }
}

#[cfg(test)]
mod tests {
    extern crate std;

    use super::*;
    use crate::kernels::dense::{row, symmetrise, transpose};
    use std::vec;
    use std::vec::Vec;

    /// `Q D Qᵀ` with a product of reflections `Q`.
    fn with(values: &[f64], mut seed: u64) -> Vec<f64> {
        let n = values.len();
        let mut a = vec![0.0; n * n];
        (0..n).for_each(|i| a[i * n + i] = values[i]);
        for _ in 0..3 {
            let mut next = || {
                seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                (seed >> 11) as f64 / (1u64 << 52) as f64 - 1.0
            };
            let v: Vec<f64> = (0..n).map(|_| next()).collect();
            let beta = 2.0 / dot(&v, &v);
            for _side in 0..2 {
                for own in a.chunks_exact_mut(n) {
                    let share = beta * dot(own, &v);
                    add_scaled(own, -share, &v);
                }
                transpose(&mut a, n);
            }
        }
        symmetrise(&mut a, n);
        a
    }

    #[test]
    fn the_lowest_are_those_of_all_with_clusters_among_them() {
        let spread: Vec<f64> = (0..64).map(|k| 1.0 + f64::from(k * k)).collect();
        // Pairs of equal bending modes, as a square section has them.
        let pairs: Vec<f64> = (0..64).map(|k| f64::from((k / 2 + 1) * (k / 2 + 1))).collect();
        let graded: Vec<f64> = (0..96).map(|k| 10f64.powf(f64::from(k) / 16.0)).collect();
        let equal = vec![2.0; 40];
        for expected in [spread, pairs, graded, equal] {
            let n = expected.len();
            for m in [1, 8, n / 3, n] {
                let a = with(&expected, 11);
                let (mut copy, mut values) = (a.clone(), vec![f64::NAN; m]);
                let (mut vectors, mut work) = (vec![f64::NAN; m * n], vec![f64::NAN; lowest_work(n, m)]);
                lowest_eigen(&mut copy, n, &mut values, &mut vectors, &mut work).expect("converges");
                let largest = expected.last().copied().unwrap_or(1.0);
                for i in 0..m {
                    assert!((values[i] - expected[i]).abs() < 1e-13 * largest * n as f64, "{n} {m} {i}");
                    let own = row(&vectors, i, n);
                    for j in 0..n {
                        let off = (dot(row(&a, j, n), own) - values[i] * own[j]).abs();
                        assert!(off < 1e-13 * largest * n as f64, "{n} {m}: residual {off:e} at {i}");
                    }
                    for j in 0..=i {
                        let unit = f64::from(u8::from(i == j));
                        let off = (dot(own, row(&vectors, j, n)) - unit).abs();
                        assert!(off < 1e-13, "{n} {m}: vectors {i} and {j} off by {off:e}");
                    }
                }
            }
        }
    }

    #[test]
    fn what_is_not_finite_or_too_short_is_refused() {
        let n = 16;
        let mut a = with(&[1.0; 16], 1);
        a[5] = f64::NAN;
        let (mut values, mut vectors) = ([0.0; 2], vec![0.0; 2 * n]);
        let mut work = vec![0.0; lowest_work(n, 2)];
        let found = lowest_eigen(&mut a, n, &mut values, &mut vectors, &mut work);
        assert_eq!(found, Err(NoConvergence));
        let found = lowest_eigen(&mut with(&[1.0; 16], 1), n, &mut values, &mut vectors, &mut []);
        assert_eq!(found, Err(NoConvergence));
    }
}
