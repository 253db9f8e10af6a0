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
    /// Their mass-orthonormal vectors, `(n, n_modes)`.
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
        let (eigenvalues, modes) = lowest(&mass, &stiffness, n_modes);
        Beam { mass, stiffness, eigenvalues, modes }
    }
}

/// Eigenpairs by subspace iteration with the inverse of the stiffness.
fn lowest(mass: &SparseColMat<usize, f64>, stiffness: &[SparseColMat<usize, f64>], count: usize) -> (Vec<f64>, Mat<f64>) {
    let n = mass.nrows();
    let m = mass.to_dense();
    let mut k = Mat::zeros(n, n);
    stiffness.iter().for_each(|q| k += q.to_dense());
    let factor = Cholesky::new(k.clone()).unwrap();
    let mut random = super::Random::new(5);
    let mut v = Mat::from_fn(n, 2 * count + 4, |_, _| random.uniform() - 0.5);
    let mut values = Vec::new();
    for _ in 0..30 {
        let mut w = product(m.as_ref(), v.as_ref());
        factor.solve_in_place(w.as_mut());
        let mw = product(m.as_ref(), w.as_ref());
        let gram = transposed_product(w.as_ref(), mw.as_ref());
        let l = gram.llt(Side::Lower).unwrap();
        // w L⁻ᵀ is mass-orthonormal; the projected stiffness in it is an ordinary symmetric eigenproblem.
        let mut t = w.transpose().to_owned();
        faer::linalg::triangular_solve::solve_lower_triangular_in_place(l.L(), t.as_mut(), faer::Par::Seq);
        let q = t.transpose().to_owned();
        let small = transposed_product(q.as_ref(), product(k.as_ref(), q.as_ref()).as_ref());
        let evd = small.self_adjoint_eigen(Side::Lower).unwrap();
        values = (0..count).map(|i| evd.S().column_vector()[i]).collect();
        v = product(q.as_ref(), evd.U());
    }
    (values, v.as_ref().subcols(0, count).to_owned())
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
