//! Dashpots in natural modes: damping ratios, and the coupling that they leave out.
//!
//! Along natural modes `Φ` the damping matrix of dashpots is `ΦᵀCΦ`. A mode has the ratio
//! `ζ_k = φ_kᵀCφ_k / (2 ω_k)`; what is off the diagonal couples modes (Craig and Kurdila 2006, §10.4).

use faer::{Mat, MatRef};

use crate::linalg::{NoConvergence, solve_dense, symmetric_eigen};

/// Eigenvalues closer than this share are those of modes that may be turned among each other.
const ALIKE: f64 = 1e-6;

/// Modes at whose frequencies the coupling is measured.
const MEASURED: usize = 64;

/// A mode whose damping is a smaller share of the largest is not damped.
const UNDAMPED: f64 = 1e-9;

/// Turns modes of one frequency, columns of `vectors`, so that dashpots do not couple them: `along` gives the
/// rows of dashpots along some of the columns. `eigenvalues` ascend.
///
/// # Errors
/// [`NoConvergence`]: numbers that double precision does not hold.
pub(crate) fn uncouple(
    along: impl Fn(MatRef<'_, f64>) -> Mat<f64>,
    eigenvalues: &[f64],
    vectors: &mut Mat<f64>,
) -> Result<(), NoConvergence> {
    let mut first = 0;
    while first < eigenvalues.len() {
        let alike = |value: &&f64| **value - eigenvalues[first] <= ALIKE * eigenvalues[first];
        let count = eigenvalues[first..].iter().take_while(alike).count();
        if count > 1 {
            let modes = vectors.subcols(first, count).to_owned();
            let rows = along(modes.as_ref());
            let (_, turn) = symmetric_eigen((rows.transpose() * &rows).as_ref())?;
            vectors.subcols_mut(first, count).copy_from(&modes * &turn);
        }
        first += count.max(1);
    }
    Ok(())
}

/// An eigenvalue of a damping matrix that is a smaller share of the largest is rounding.
const ROUNDING: f64 = 1e-15;

/// Rows of the same `DᵀD`, at most as many as there are columns.
///
/// # Errors
/// [`NoConvergence`]: numbers that double precision does not hold.
pub(crate) fn fewest_rows(rows: Mat<f64>) -> Result<Mat<f64>, NoConvergence> {
    if rows.nrows() <= rows.ncols() { Ok(rows) } else { damping_rows((rows.transpose() * &rows).as_ref()) }
}

/// Rows `D` of a damping matrix `DᵀD` along the modes, shape (r, r).
///
/// # Errors
/// [`NoConvergence`]: numbers that double precision does not hold.
pub fn damping_rows(damping: MatRef<'_, f64>) -> Result<Mat<f64>, NoConvergence> {
    let (values, vectors) = symmetric_eigen(damping)?;
    let largest = values.last().copied().unwrap_or(0.0);
    let kept: Vec<usize> = (0..values.len()).filter(|&k| values[k] > ROUNDING * largest).collect();
    Ok(Mat::from_fn(kept.len(), values.len(), |i, j| values[kept[i]].sqrt() * vectors[(j, kept[i])]))
}

/// The change by the coupling of modes ([`coupling_error`]) from which a file holds it.
pub const COUPLED: f64 = 1e-3;

/// Largest change of the answer to a force on one mode at its natural frequency if the coupling is left out,
/// relative, in the norm of the energy. `damping` is the whole damping matrix along the modes, shape (r, r)
/// \[1/s\].
pub fn coupling_error(eigenvalues: &[f64], damping: MatRef<'_, f64>) -> f64 {
    let r = eigenvalues.len();
    let largest = (0..r).map(|k| damping[(k, k)]).fold(0.0, f64::max);
    let of_mode = |k: usize| -> f64 {
        let (omega, own) = (eigenvalues[k].sqrt(), damping[(k, k)]);
        if own <= UNDAMPED * largest || omega <= 0.0 {
            return 0.0;
        }
        // (Λ − ω² + iωC) q = e, real and imaginary parts.
        let entry = |i: usize, j: usize| {
            let elastic = if i % r == j % r { eigenvalues[i % r] - eigenvalues[k] } else { 0.0 };
            let damped = omega * damping[(i % r, j % r)];
            match (i < r, j < r) {
                (true, true) | (false, false) => elastic,
                (true, false) => -damped,
                (false, true) => damped,
            }
        };
        let matrix = Mat::from_fn(2 * r, 2 * r, entry);
        let force = Mat::from_fn(2 * r, 1, |i, _| f64::from(u8::from(i == k)));
        let answer = solve_dense(matrix.as_ref(), force.as_ref());
        let alone = -1.0 / (omega * own);
        let energy = |j: usize, re: f64, im: f64| (eigenvalues[j] + eigenvalues[k]) * (re * re + im * im);
        let change = |j: usize| {
            let im = answer[(r + j, 0)] - if j == k { alone } else { 0.0 };
            energy(j, answer[(j, 0)], im)
        };
        ((0..r).map(change).sum::<f64>() / energy(k, 0.0, alone)).sqrt()
    };
    (0..r.min(MEASURED)).map(of_mode).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use faer::c64;

    use super::*;

    #[test]
    fn the_coupling_of_two_modes_is_that_of_their_inverse() {
        let (values, c) = ([4.0, 9.0_f64], [[0.2, 0.1], [0.1, 0.3]]);
        let of_mode = |k: usize| -> f64 {
            let (omega, other) = (values[k].sqrt(), 1 - k);
            let z = |i: usize, j: usize| {
                let elastic = if i == j { values[i] - values[k] } else { 0.0 };
                c64::new(elastic, omega * c[i][j])
            };
            // Cramer's rule.
            let determinant = z(k, k) * z(other, other) - z(k, other) * z(other, k);
            let (own, second) = (z(other, other) / determinant, z(other, k) / determinant);
            let alone = z(k, k).inv();
            let weight = |i: usize| values[i] + values[k];
            let change = weight(k) * (own - alone).norm_sqr() + weight(other) * second.norm_sqr();
            (change / (weight(k) * alone.norm_sqr())).sqrt()
        };
        let expected = of_mode(0).max(of_mode(1));
        let found = coupling_error(&values, Mat::from_fn(2, 2, |i, j| c[i][j]).as_ref());
        assert!((found / expected - 1.0).abs() < 1e-12 && found > 0.01, "{found} {expected}");
        let apart = Mat::from_fn(2, 2, |i, j| if i == j { c[i][j] } else { 0.0 });
        assert!(coupling_error(&values, apart.as_ref()) < 1e-14);
    }
}
