//! Symmetric matrices as files hold them, and how closely they must be what they say.
//!
//! Entry `(k, l)` of a reduced matrix is a sum of products over all dofs. It is known to about
//! `2⁻⁴⁰ max|A|` in absolute terms (rounding, 4 096 of them, of sums whose size is that of the largest
//! entry), and what differs by `2⁻²⁶ √(A_kk A_ll)`, half the digits of a number, changes no result that is
//! shown to anybody. A file may be off by the sum of both:
//!
//! ```text
//! t_kl = 2⁻²⁶ √|A_kk A_ll| + 2⁻⁴⁰ max|A|
//! ```

/// Half the digits of binary64.
pub(super) const HALF: f64 = 1.0 / (1u64 << 26) as f64;
/// Tolerance for rounding in a long sum, relative to its largest number.
pub(super) const ROUNDING: f64 = 1.0 / (1u64 << 40) as f64;

/// Sizes an entry of a matrix is compared with.
pub(super) struct Sizes {
    /// `√|A_kk|`.
    roots: Vec<f64>,
    /// `max|A|`.
    pub largest: f64,
}

impl Sizes {
    /// Of a matrix `(r, r)`, row by row.
    pub fn of(matrix: &[f64], r: usize) -> Self {
        let roots = (0..r).map(|k| matrix[k * r + k].abs().sqrt()).collect();
        Self { roots, largest: matrix.iter().fold(0.0, |m: f64, x| m.max(x.abs())) }
    }

    /// `t_kl` of the module's text.
    pub fn tolerance(&self, k: usize, l: usize) -> f64 {
        HALF * self.roots[k] * self.roots[l] + ROUNDING * self.largest
    }
}

/// The first place above the diagonal that differs from its mirror by more than is allowed.
pub(super) fn unsymmetric(
    matrix: &[f64],
    r: usize,
    allowed: impl Fn(usize, usize) -> f64,
) -> Option<[usize; 2]> {
    let off = |k: usize, l: usize| (matrix[k * r + l] - matrix[l * r + k]).abs();
    (0..r).flat_map(|k| (0..k).map(move |l| [l, k])).find(|&[l, k]| off(l, k) > allowed(l, k))
}

/// The first column whose pivot is negative in elimination without exchanges, after `r t_kk` were added to
/// the diagonal: then the matrix takes a negative value that rounding does not explain. `matrix` is
/// overwritten; costs `r³/3`.
pub(super) fn negative_pivot(matrix: &mut [f64], r: usize, allowed: impl Fn(usize) -> f64) -> Option<usize> {
    (0..r).for_each(|k| matrix[k * r + k] += r as f64 * allowed(k));
    for k in 0..r {
        let (above, below) = matrix.split_at_mut((k + 1) * r);
        let row = &above[k * r..];
        let pivot = row[k];
        if pivot < 0.0 || pivot.is_nan() {
            return Some(k);
        }
        for own in below.chunks_exact_mut(r).filter(|own| own[k] != 0.0) {
            let share = own[k] / pivot;
            own[k..].iter_mut().zip(&row[k..]).for_each(|(x, y)| *x -= share * y);
        }
    }
    None
}
