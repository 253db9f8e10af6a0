//! Symmetric 3 × 3 matrices.

/// A symmetric 3 × 3 matrix: xx, xy, xz, yy, yz, zz.
pub(crate) type Symmetric = [f64; 6];

/// Rotations of a Jacobi iteration at most, in sweeps over the three pairs; it takes some five.
const SWEEPS: usize = 30;

/// All nine entries, row by row.
pub(super) fn full(a: &Symmetric) -> [[f64; 3]; 3] {
    let &[xx, xy, xz, yy, yz, zz] = a;
    [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]
}

/// The symmetric part of nine entries, row by row.
pub(super) fn symmetric(a: &[f64; 9]) -> Symmetric {
    let half = |i: usize, j: usize| 0.5 * (a[3 * i + j] + a[3 * j + i]);
    [half(0, 0), half(0, 1), half(0, 2), half(1, 1), half(1, 2), half(2, 2)]
}

/// `dᵀ A d`.
pub(super) fn form(a: &Symmetric, d: [f64; 3]) -> f64 {
    let a = full(a);
    (0..3).map(|i| d[i] * (0..3).map(|j| a[i][j] * d[j]).sum::<f64>()).sum()
}

/// Eigenvalues, and eigenvectors as columns, by Jacobi's rotations.
pub(super) fn eigen(a: &Symmetric) -> ([f64; 3], [[f64; 3]; 3]) {
    let mut a = full(a);
    let mut vectors = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    for _ in 0..SWEEPS {
        let mut turned = false;
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            if a[p][q].abs() <= f64::EPSILON * f64::EPSILON * (a[p][p] * a[q][q]).abs().sqrt() {
                continue;
            }
            turned = true;
            let ratio = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
            let tangent = ratio.signum() / (ratio.abs() + ratio.hypot(1.0));
            let cosine = 1.0 / tangent.hypot(1.0);
            let sine = tangent * cosine;
            for row in &mut a {
                (row[p], row[q]) = (cosine * row[p] - sine * row[q], sine * row[p] + cosine * row[q]);
            }
            for k in 0..3 {
                (a[p][k], a[q][k]) = (cosine * a[p][k] - sine * a[q][k], sine * a[p][k] + cosine * a[q][k]);
            }
            (a[p][q], a[q][p]) = (0.0, 0.0);
            for row in &mut vectors {
                (row[p], row[q]) = (cosine * row[p] - sine * row[q], sine * row[p] + cosine * row[q]);
            }
        }
        if !turned {
            break;
        }
    }
    ([a[0][0], a[1][1], a[2][2]], vectors)
}

/// The nearest positive semidefinite matrix: rounding may have left a negative eigenvalue where there is
/// none.
pub(super) fn semidefinite(a: Symmetric) -> Symmetric {
    let (values, vectors) = eigen(&a);
    if values.iter().all(|&value| value >= 0.0) {
        return a;
    }
    let entry = |i: usize, j: usize| -> f64 {
        (0..3).map(|k| values[k].max(0.0) * vectors[i][k] * vectors[j][k]).sum()
    };
    [entry(0, 0), entry(0, 1), entry(0, 2), entry(1, 1), entry(1, 2), entry(2, 2)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn eigenvalues_are_those_of_the_characteristic_polynomial() {
        // Rotated about (1, 1, 1): eigenvalues 1, 4, 4 of I·3 + … and three different ones.
        let (mut values, vectors) = eigen(&[2.0, -1.0, 0.0, 2.0, -1.0, 2.0]);
        let a = full(&[2.0, -1.0, 0.0, 2.0, -1.0, 2.0]);
        for k in 0..3 {
            for i in 0..3 {
                let image: f64 = (0..3).map(|j| a[i][j] * vectors[j][k]).sum();
                assert!((image - values[k] * vectors[i][k]).abs() < 1e-14);
            }
        }
        values.sort_by(f64::total_cmp);
        let root = 2.0_f64.sqrt();
        for (found, exact) in values.into_iter().zip([2.0 - root, 2.0, 2.0 + root]) {
            assert!((found - exact).abs() < 1e-14);
        }
    }

    #[test]
    fn a_negative_eigenvalue_is_taken_away_and_nothing_else() {
        // Eigenvalues 3 and −1 along (1, 1) and (1, −1), and 5.
        let mended = semidefinite([1.0, 2.0, 0.0, 1.0, 0.0, 5.0]);
        for (found, exact) in mended.into_iter().zip([1.5, 1.5, 0.0, 1.5, 0.0, 5.0]) {
            assert!((found - exact).abs() < 1e-14);
        }
        let sound = [1.0, 0.5, 0.25, 1.0, 0.125, 1.0];
        assert_eq!(semidefinite(sound), sound);
    }
}
