//! A pencil to test on without meshes: a clamped Euler–Bernoulli beam of several regions, 2 dofs per node.
//!
//! Its frequencies spread as 1 : 6 : 18 : 34 : …, as those of a slender solid do, and its stiffness is singularly ill
//! conditioned, so it is not an easy case.

use super::linalg::{Cholesky, product, transposed_product};
use faer::sparse::{SparseColMat, Triplet};
use faer::{Mat, Side};

pub(crate) struct Beam {
    pub(crate) mass: SparseColMat<usize, f64>,
    /// One per region, all on the same pattern as the mass.
    pub(crate) stiffness: Vec<SparseColMat<usize, f64>>,
    /// Lowest eigenvalues of the nominal pencil.
    pub(crate) eigenvalues: Vec<f64>,
    /// Ritz vectors of a space of static responses, `(n, n_modes)`: near the eigenmodes but not invariant, as a basis
    /// that comes from snapshots.
    pub(crate) modes: Mat<f64>,
}

impl Beam {
    /// `elements` beam elements on unit length with unit bending stiffness and mass, split into equal regions.
    pub(crate) fn new(elements: usize, regions: usize, n_modes: usize) -> Beam {
        let h = 1.0 / elements as f64;
        let bending = [[12.0, 6.0 * h, -12.0, 6.0 * h], [6.0 * h, 4.0 * h * h, -6.0 * h, 2.0 * h * h]];
        let inertia = [[156.0, 22.0 * h, 54.0, -13.0 * h], [22.0 * h, 4.0 * h * h, 13.0 * h, -3.0 * h * h]];
        let entry = |rows: &[[f64; 4]; 2], i: usize, j: usize| {
            // The lower half of an element is the upper one seen from the other end, rotations reversed.
            let sign = |k: usize| if k % 2 == 1 { -1.0 } else { 1.0 };
            if i < 2 { rows[i][j] } else { rows[i - 2][(j + 2) % 4] * sign(i) * sign(j) }
        };
        let assemble = |scale: f64, rows: &[[f64; 4]; 2], region: Option<usize>| {
            let mut entries = Vec::new();
            for e in 0..elements {
                let inside = region.is_none_or(|q| e * regions / elements == q);
                for i in 0..4 {
                    for j in 0..4 {
                        let (row, col) = ((2 * e + i).checked_sub(2), (2 * e + j).checked_sub(2));
                        if let (Some(row), Some(col)) = (row, col) {
                            let value = if inside { scale * entry(rows, i, j) } else { 0.0 };
                            entries.push(Triplet::new(row, col, value));
                        }
                    }
                }
            }
            SparseColMat::try_new_from_triplets(2 * elements, 2 * elements, &entries).unwrap()
        };
        let mass = assemble(h / 420.0, &inertia, None);
        let stiffness: Vec<_> = (0..regions).map(|q| assemble(h.powi(-3), &bending, Some(q))).collect();
        let (eigenvalues, modes) = ritz(&mass, &stiffness, n_modes);
        Beam { mass, stiffness, eigenvalues, modes }
    }
}

/// Lowest eigenvalues, and the Ritz vectors of `3 n_modes` responses to point loads, once through the inertia.
fn ritz(mass: &SparseColMat<usize, f64>, stiffness: &[SparseColMat<usize, f64>], count: usize) -> (Vec<f64>, Mat<f64>) {
    let n = mass.nrows();
    let m = mass.to_dense();
    let mut k = Mat::zeros(n, n);
    stiffness.iter().for_each(|q| k += q.to_dense());
    let factor = Cholesky::new(k.clone()).unwrap();
    let width = 3 * count;
    let mut v = Mat::from_fn(n, width, |i, j| f64::from(i == 2 * ((j + 1) * n / (2 * width) - 1)));
    factor.solve_in_place(v.as_mut());
    let inverse = |v: &Mat<f64>| {
        let mut w = product(m.as_ref(), v.as_ref());
        factor.solve_in_place(w.as_mut());
        rayleigh_ritz(&m, &k, &w)
    };
    let (_, mut v) = inverse(&v);
    let basis = v.as_ref().subcols(0, count).to_owned();
    let mut values = Vec::new();
    for _ in 0..20 {
        (values, v) = inverse(&v);
    }
    values.truncate(count);
    (values, basis)
}

/// Ritz values and mass-orthonormal Ritz vectors of the span of `w`.
fn rayleigh_ritz(m: &Mat<f64>, k: &Mat<f64>, w: &Mat<f64>) -> (Vec<f64>, Mat<f64>) {
    // columns of unit length first, then an orthonormal basis: static responses are nearly parallel
    let (w, _, _) = super::linalg::thin_svd(w.as_ref()).unwrap();
    let gram = transposed_product(w.as_ref(), product(m.as_ref(), w.as_ref()).as_ref());
    let l = gram.llt(Side::Lower).unwrap();
    let mut t = w.transpose().to_owned();
    faer::linalg::triangular_solve::solve_lower_triangular_in_place(l.L(), t.as_mut(), faer::Par::Seq);
    let q = t.transpose().to_owned();
    let small = transposed_product(q.as_ref(), product(k.as_ref(), q.as_ref()).as_ref());
    let evd = small.self_adjoint_eigen(Side::Lower).unwrap();
    let values = (0..w.ncols()).map(|i| evd.S().column_vector()[i]).collect();
    (values, product(q.as_ref(), evd.U()))
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_surrogate_has_the_frequencies_of_a_cantilever() {
        let beam = super::Beam::new(40, 2, 4);
        // (βL)⁴ of a clamped-free beam; Hermite elements are of order 4 in the eigenvalue, (k h)⁴/720 here
        for (value, root) in beam.eigenvalues.iter().zip([1.875104f64, 4.694091, 7.854757, 10.995541]) {
            let exact = root.powi(4);
            assert!((value / exact - 1.0).abs() < (root / 40.0).powi(4) / 100.0 + 2e-6, "{value} {exact}");
        }
    }
}
