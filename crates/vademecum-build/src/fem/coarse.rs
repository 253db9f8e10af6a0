//! A coarse space for a preconditioner: the lowest modes of a stiffness, nearly.
//!
//! Rounding in single precision moves a stiffness by a share of its largest eigenvalue, and so spoils most
//! what belongs to its lowest ones. The columns of `W` span these nearly, and are orthonormal in the energy,
//! `Wᵀ A W = I`. What a preconditioner `B` does is then done outside of them, and they are solved for exactly
//! (the balancing preconditioner, Mandel 1993; compared with others by Tang, Nabben, Vuik and Erlangga 2009):
//!
//! ```text
//! c = Wᵀ r      y = B (r − A W c)      z = y + W (c − (A W)ᵀ y)
//! ```

use faer::linalg::triangular_solve::solve_lower_triangular_in_place;
use faer::{Mat, MatMut, Par, Side};

use super::sparse::SymmetricMatrix;
use crate::linalg::{Random, TALL, row_groups, subtract_product, transposed_product};
use crate::parallel;

/// Columns of a coarse space.
const COLUMNS: usize = 24;

/// Inverse iterations that find it.
const PASSES: usize = 2;

/// Columns near the lowest modes of a matrix, orthonormal in its energy.
#[derive(Clone, Debug)]
pub(super) struct CoarseSpace {
    /// `W`, shape (n, columns).
    columns: Mat<f64>,
    /// `A W`.
    images: Mat<f64>,
}

impl CoarseSpace {
    /// The space that inverse iterations with a preconditioner find from columns drawn at random; `None`
    /// where they lose their independence.
    pub(crate) fn find(
        matrix: &SymmetricMatrix,
        mut precondition: impl FnMut(MatMut<'_, f64>),
    ) -> Option<CoarseSpace> {
        let n = matrix.n();
        let mut random = Random::new(1);
        let mut columns = Mat::from_fn(n, COLUMNS.min(n), |_, _| random.uniform() - 0.5);
        let mut images = Mat::zeros(n, columns.ncols());
        for _ in 0..PASSES {
            precondition(columns.as_mut());
            matrix.mul_into(columns.as_ref(), images.as_mut());
            let energies = transposed_product(columns.as_ref(), images.as_ref());
            let lower = energies.llt(Side::Lower).ok()?;
            for block in [&mut columns, &mut images] {
                // `(X L⁻ᵀ)ᵀ = L⁻¹ Xᵀ`.
                parallel::for_each_of(row_groups(block.as_mut(), TALL), &|_, rows| {
                    solve_lower_triangular_in_place(lower.L(), rows.transpose_mut(), Par::Seq);
                });
            }
        }
        Some(CoarseSpace { columns, images })
    }

    /// `c = Wᵀ r`, and takes `A W c` off `r`.
    pub(crate) fn take_off(&self, r: MatMut<'_, f64>) -> Mat<f64> {
        let shares = transposed_product(self.columns.as_ref(), r.as_ref());
        subtract_product(r, self.images.as_ref(), shares.as_ref());
        shares
    }

    /// `z ← z + W (c − (A W)ᵀ z)`.
    pub(crate) fn put_back(&self, shares: Mat<f64>, z: MatMut<'_, f64>) {
        let more = transposed_product(self.images.as_ref(), z.as_ref()) - shares;
        subtract_product(z, self.columns.as_ref(), more.as_ref());
    }

    /// The same \[bytes\].
    pub(crate) fn bytes(n: usize) -> usize {
        n.saturating_mul(2 * COLUMNS * size_of::<f64>())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fem::Pencil;

    /// A chain of springs held at one end.
    fn chain(n: usize) -> SymmetricMatrix {
        let last = n as u32 - 1;
        let diagonal = (0..=last).map(|i| (i, i, if i == last { 1.0 } else { 2.0 }));
        let beside = (0..last).flat_map(|i| [(i, i + 1, -1.0), (i + 1, i, -1.0)]);
        let entries: Vec<_> = diagonal.chain(beside).collect();
        Pencil::from_triplets(n, &entries, &entries).expect("a pencil").stiffness().clone()
    }

    #[test]
    fn what_lies_in_the_space_is_solved_for_exactly_and_the_rest_is_left_to_the_preconditioner() {
        let matrix = chain(300);
        // A poor one: half the inverse of the diagonal.
        let precondition = |mut x: MatMut<'_, f64>| x *= faer::Scale(0.25);
        let coarse = CoarseSpace::find(&matrix, precondition).expect("a space");
        let k = coarse.columns.ncols();
        let energies = transposed_product(coarse.columns.as_ref(), coarse.images.as_ref());
        assert!((energies - Mat::<f64>::identity(k, k)).norm_max() < 1e-12);
        let mut random = Random::new(5);
        let shares = Mat::from_fn(k, 3, |_, _| random.uniform() - 0.5);
        let (answer, mut forces) = (&coarse.columns * &shares, &coarse.images * &shares);
        let size = forces.norm_max();
        let taken = coarse.take_off(forces.as_mut());
        assert!(forces.norm_max() < 1e-12 * size && (&taken - shares).norm_max() < 1e-12);
        coarse.put_back(taken, forces.as_mut());
        assert!((forces - &answer).norm_max() < 1e-10 * answer.norm_max());
        // What the preconditioner gives has no energy with the space.
        let mut other = Mat::from_fn(300, 1, |_, _| random.uniform() - 0.5);
        coarse.put_back(Mat::zeros(k, 1), other.as_mut());
        let shared = transposed_product(coarse.images.as_ref(), other.as_ref());
        assert!(shared.norm_max() < 1e-10 && other.norm_max() > 0.1);
    }
}
