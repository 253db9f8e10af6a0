//! An element at one point of integration: the gradient of a displacement, its rows, forces and stiffness.

use super::tensor::{Tensor, product};
use crate::linalg::vec3::dot;
use crate::mesh::shapes::MAX_NODES;

/// Rows of `z` at each point of integration.
pub(super) const ROWS: usize = 6;

const SIXTH: f64 = 0.408_248_290_463_863;

/// An element at one of its points.
pub(super) struct ElementPoint<'a> {
    pub(super) gradients: &'a [[f64; 3]],
    pub(super) inverse: &'a Tensor,
    /// `√(w det J)` times the roots of the moduli.
    pub(super) roots: [f64; 2],
}

/// Gradients of the nodes of an element, deformed ones, and their products with a stress.
pub(super) struct TangentRoom([[[f64; 3]; MAX_NODES]; 3]);

impl TangentRoom {
    pub(super) fn new() -> Self {
        Self([[[0.0; 3]; MAX_NODES]; 3])
    }
}

impl ElementPoint<'_> {
    /// `H`, `H_ij = ∂u_i/∂x_j`.
    #[inline]
    pub(super) fn gradient(&self, nodal: &[[f64; 3]]) -> Tensor {
        let mut reference = [[0.0; 3]; 3];
        for (u, g) in nodal.iter().zip(self.gradients) {
            for i in 0..3 {
                for r in 0..3 {
                    reference[i][r] += u[i] * g[r];
                }
            }
        }
        product(&reference, self.inverse)
    }

    /// The weighted rows of a symmetric strain.
    #[inline]
    pub(super) fn rows(&self, e: &Tensor) -> [f64; ROWS] {
        let [bulk, shear] = self.roots;
        let (half, sixth) = (shear * std::f64::consts::FRAC_1_SQRT_2, shear * SIXTH);
        let twice = shear * std::f64::consts::SQRT_2;
        [
            bulk * (e[0][0] + e[1][1] + e[2][2]),
            half * (e[0][0] - e[1][1]),
            sixth * (2.0 * e[2][2] - e[0][0] - e[1][1]),
            twice * e[0][1],
            twice * e[1][2],
            twice * e[2][0],
        ]
    }

    /// The rows with the mean of the volume strain over the element in place of that of the point.
    #[inline]
    pub(super) fn with_mean(&self, mut rows: [f64; ROWS], mean: Option<f64>) -> [f64; ROWS] {
        if let Some(mean) = mean {
            rows[0] = self.roots[0] * mean;
        }
        rows
    }

    /// The symmetric tensor `T` with `T : E = z · rows(E)` for all strains: of the rows of a strain its
    /// second Piola–Kirchhoff stress, times the weight of the point.
    #[inline]
    pub(super) fn stress(&self, z: &[f64; ROWS]) -> Tensor {
        let [bulk, shear] = self.roots;
        let (half, sixth) = (shear * std::f64::consts::FRAC_1_SQRT_2, shear * SIXTH);
        let (mean, plane, axial) = (bulk * z[0], half * z[1], sixth * z[2]);
        let [xy, yz, zx] = [half * z[3], half * z[4], half * z[5]];
        [[mean + plane - axial, xy, zx], [xy, mean - plane - axial, yz], [zx, yz, mean + 2.0 * axial]]
    }

    /// Adds `P ∇N_a` to each node, with `P` the weighted first Piola–Kirchhoff stress.
    #[inline]
    pub(super) fn add_forces(&self, p: &Tensor, forces: &mut [[f64; 3]]) {
        // P J⁻ᵀ, so that no gradient in space is needed.
        let reference: Tensor = p.map(|row| self.inverse.map(|j| dot(row, j)));
        for (f, g) in forces.iter_mut().zip(self.gradients) {
            for i in 0..3 {
                f[i] += dot(reference[i], *g);
            }
        }
    }

    /// Adds the blocks on and above the diagonal: with `g = ∇N` and `a = F g`,
    /// `m (λ a_a a_bᵀ + μ a_b a_aᵀ + μ (g_a·g_b) F Fᵀ) + (g_aᵀ T g_b) I`.
    ///
    /// With `mean`, the part of the volume strain is left out, and its derivative times the bulk modulus is
    /// added there, for [`add_mean_tangent`].
    pub(super) fn add_tangent(
        &self,
        (f, stress, m): (&Tensor, &Tensor, f64),
        mean: Option<&mut [[f64; 3]]>,
        room: &mut TangentRoom,
        blocks: &mut [[f64; 9]],
    ) {
        let n = self.gradients.len();
        let [g, turned, pulled] = room.0.each_mut().map(|room| &mut room[..n]);
        for (a, r) in self.gradients.iter().enumerate() {
            g[a] = std::array::from_fn(|i| (0..3).map(|k| r[k] * self.inverse[k][i]).sum());
            turned[a] = f.map(|row| dot(row, g[a]));
            pulled[a] = stress.map(|row| dot(row, g[a]));
        }
        let mut roots = self.roots;
        if let Some(mean) = mean {
            let bulk = roots[0] * roots[0];
            mean.iter_mut().zip(&*turned).for_each(|(sum, a)| (0..3).for_each(|i| sum[i] += bulk * a[i]));
            roots[0] = 0.0;
        }
        let [bulk, shear] = roots.map(|x| m * x * x);
        let (mu, lambda) = (0.5 * shear, bulk - shear / 3.0);
        let left: Tensor = f.map(|row| f.map(|other| dot(row, other)));
        for a in 0..n {
            for b in a..n {
                let block = &mut blocks[a * n + b];
                let (shear, own) = (mu * dot(g[a], g[b]), dot(g[a], pulled[b]));
                for i in 0..3 {
                    for j in 0..3 {
                        block[3 * i + j] += lambda * turned[a][i] * turned[b][j]
                            + mu * turned[b][i] * turned[a][j]
                            + shear * left[i][j];
                    }
                    block[4 * i] += own;
                }
            }
        }
    }
}

/// Adds the blocks on and above the diagonal of the mean volume strain: of its sums over the points, and of
/// the weight over the integral of the bulk modulus.
pub(super) fn add_mean_tangent(mean: &[[f64; 3]], weight: f64, blocks: &mut [[f64; 9]]) {
    let n = mean.len();
    for a in 0..n {
        for b in a..n {
            for i in 0..3 {
                for j in 0..3 {
                    blocks[a * n + b][3 * i + j] += weight * mean[a][i] * mean[b][j];
                }
            }
        }
    }
}

/// Copies the blocks above the diagonal below it, transposed: symmetric to the last bit.
pub(super) fn mirror(blocks: &mut [[f64; 9]], n: usize) {
    for a in 0..n {
        for b in a..n {
            let block = blocks[a * n + b];
            let turned: [f64; 9] = std::array::from_fn(|k| {
                let (i, j) = (k / 3, k % 3);
                // In a diagonal block the upper triangle is the master.
                if a == b && i < j { block[k] } else { block[3 * j + i] }
            });
            blocks[b * n + a] = turned;
        }
    }
}
