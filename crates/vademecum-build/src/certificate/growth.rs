//! How far the energy of free motions swings over a million steps.
//!
//! A step whose eigenvalues lie in the unit circle may let the energy grow for long all the same, where its
//! eigenvectors are not orthogonal in the energy and beat against each other. A march of a million steps
//! would be slow, but the step is linear: the state after `n` steps takes one product for each bit of `n`,
//! once the powers `A^(2ᵏ)` are known, which take a product each.
//!
//! Note: the powers are held as `Aⁿ − I`, whose squares are `2D + D²`, so that eigenvalues near 1
//! keep their digits.

use faer::{Mat, MatRef, Scale};

use crate::linalg::Random;

/// Bits of the longest motion: it is looked at for fewer than 2 to this power steps.
const BITS: usize = 20;
/// Instants looked at between 2ᵏ and 2ᵏ⁺¹ steps.
const INSTANTS: usize = 16;
/// Where the draw of the instants starts.
const SEED: u64 = 11;

/// States after `n < 2²⁰` free steps, of every start and at instants spread over all magnitudes of `n`.
///
/// `increment` is `A − I`, shape (3r, 3r); `starts` has a start in each column, shape (3r, m). A column of
/// the result belongs to the start of its number modulo m.
pub(super) fn free_states(increment: MatRef<'_, f64>, starts: MatRef<'_, f64>) -> Mat<f64> {
    let mut random = Random::new(SEED);
    let drawn = |bit: usize| (1 << bit) + random.below(1 << bit);
    let instants: Vec<usize> = (0..BITS).flat_map(|bit| [bit; INSTANTS]).map(drawn).collect();
    let columns = instants.len() * starts.ncols();
    let mut states = Mat::from_fn(starts.nrows(), columns, |i, j| starts[(i, j % starts.ncols())]);
    let mut power = increment.to_owned();
    for bit in 0..BITS {
        if bit > 0 {
            power = &power * &power + Scale(2.0) * &power;
        }
        let moved = &power * &states;
        for j in 0..columns {
            if instants[j / starts.ncols()] >> bit & 1 == 1 {
                for i in 0..states.nrows() {
                    states[(i, j)] += moved[(i, j)];
                }
            }
        }
    }
    states
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_states_are_those_of_stepping() {
        // A turn by a small angle and a slow decay: after n steps an angle n times as large, and the decay to
        // the power of n.
        let (angle, decay) = (1e-3_f64, 1e-6_f64);
        let (sine, cosine) = angle.sin_cos();
        let matrix = [[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0 - decay]];
        let increment = Mat::from_fn(3, 3, |i, j| matrix[i][j] - f64::from(u8::from(i == j)));
        let starts = Mat::from_fn(3, 2, |i, j| if i == 2 || i == j { 1.0 } else { 0.0 });
        let states = free_states(increment.as_ref(), starts.as_ref());
        assert_eq!(states.ncols(), 2 * BITS * INSTANTS);
        for j in 0..states.ncols() {
            let n = (states[(2, j)].ln() / (-decay).ln_1p()).round();
            assert!((1.0..1_048_576.0).contains(&n));
            let phase = n * angle + if j % 2 == 0 { 0.0 } else { std::f64::consts::FRAC_PI_2 };
            // Rounding of A alone turns it by 1e-16 in each step.
            let allowed = 1e-15 * n + 1e-12;
            assert!((states[(0, j)] - phase.cos()).abs() < allowed, "{n}");
            assert!((states[(1, j)] - phase.sin()).abs() < allowed, "{n}");
        }
    }
}
