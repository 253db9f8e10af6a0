//! One point of integration of an element: the map, the gradients, and their share of the stiffness.

use super::material::{Law, contract};
use crate::linalg::vec3::cross;
use crate::mesh::shapes::{MAX_NODES, Point};

/// The volume form of an element is not positive everywhere.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "the map of the element folds over: its volume form is {determinant:e} at one of the quadrature points"
)]
pub struct ElementError {
    /// The first volume form found that is not positive, m³ per unit of reference volume.
    pub determinant: f64,
}

/// `∇N_a` of each node at a point of an element.
pub(super) fn gradients(n: usize, point: &Point, inverse: &[[f64; 3]; 3]) -> [[f64; 3]; MAX_NODES] {
    let mut g = [[0.0; 3]; MAX_NODES];
    for a in 0..n {
        let r = point.gradients[a];
        g[a] = std::array::from_fn(|i| r[0] * inverse[0][i] + r[1] * inverse[1][i] + r[2] * inverse[2][i]);
    }
    g
}

/// Adds one quadrature point to all blocks on and above the diagonal.
pub(super) fn add_stiffness(
    n: usize,
    g: &[[f64; 3]; MAX_NODES],
    weight: f64,
    law: &Law,
    stiffness: &mut [f64],
) {
    match *law {
        Law::Isotropic { lambda, mu } => {
            for a in 0..n {
                for b in a..n {
                    let block = &mut stiffness[(a * n + b) * 9..][..9];
                    add_stiffness_block(block, g[a], g[b], weight * lambda, weight * mu);
                }
            }
        }
        Law::Anisotropic(_) => {
            for b in 0..n {
                let stress = law.stress_block(g[b], weight);
                for a in 0..=b {
                    add_block(&mut stiffness[(a * n + b) * 9..][..9], &contract(g[a], &stress));
                }
            }
        }
    }
}

/// Adds a 3 × 3 block, row by row.
pub(super) fn add_block(sum: &mut [f64], block: &[[f64; 3]; 3]) {
    sum.iter_mut().zip(block.as_flattened()).for_each(|(sum, value)| *sum += value);
}

/// Adds one quadrature point to block `(a, b)`.
fn add_stiffness_block(block: &mut [f64], ga: [f64; 3], gb: [f64; 3], lambda: f64, mu: f64) {
    let shear = mu * (ga[0] * gb[0] + ga[1] * gb[1] + ga[2] * gb[2]);
    for i in 0..3 {
        for j in 0..3 {
            block[3 * i + j] += lambda * ga[i] * gb[j] + mu * ga[j] * gb[i];
        }
        block[4 * i] += shear;
    }
}

/// Inverse of the map's Jacobian, `inverse[r][i] = ∂ξ_r/∂x_i`, and its determinant (m³ per reference volume).
pub(super) fn jacobian(
    n: usize,
    point: &Point,
    nodes: &[[f64; 3]],
) -> Result<([[f64; 3]; 3], f64), ElementError> {
    let mut j = [[0.0; 3]; 3]; // j[r] = ∂x/∂ξ_r
    for a in 0..n {
        for r in 0..3 {
            for i in 0..3 {
                j[r][i] += point.gradients[a][r] * nodes[a][i];
            }
        }
    }
    let cofactors = [cross(j[1], j[2]), cross(j[2], j[0]), cross(j[0], j[1])];
    let determinant = (0..3).map(|i| j[0][i] * cofactors[0][i]).sum::<f64>();
    // Written so that a NaN is refused too.
    if !(determinant > 0.0 && determinant.is_finite()) {
        return Err(ElementError { determinant });
    }
    Ok((cofactors.map(|c| c.map(|x| x / determinant)), determinant))
}
