//! The response of one stage to every unit reduced state, full order: `H = (M + θK)⁻¹ M B` as its increment over `B`.
//!
//! With the projection `Π = BᵀM` one n × r matrix per stage carries everything the step needs: its square part
//! `C = BᵀM H` moves the state, and by reciprocity `Π (M + θK)⁻¹ F = HᵀF` its rows are the response to a unit force at
//! each dof. What is stored is `H − B` and `C − I`: the identity is exact and the small numbers keep all their digits.
//!
//! Source: chapter 5, eqs. (5.5), (5.6), with the state entering linearly and exactly instead of through axes
//! (method.md §3).

use faer::{Mat, MatRef};

use crate::fem::{FactorError, Pencil, Solve, Symbolic};

/// What one stage does to the reduced state and to loads, at one θ.
#[derive(Clone, Debug)]
pub struct StageResponse {
    /// θ = k̃/m̃ \[s²\].
    pub theta: f64,
    /// `H − B`, shape (n, r).
    pub increment: Mat<f64>,
    /// `E = C − I = BᵀM (H − B)`, shape (r, r), symmetric.
    pub state: Mat<f64>,
    /// ‖(M + θK)(H − B) + θKB‖ ÷ ‖θKB‖, Frobenius: what the solve left.
    pub residual: f64,
}

impl StageResponse {
    /// `(M + θK) (H − B) = −θ K B`, one factorisation and r solves with one step of iterative refinement.
    ///
    /// # Errors
    /// If `M + θK` is not positive definite.
    pub fn solve(
        pencil: &Pencil,
        symbolic: &Symbolic,
        basis: MatRef<'_, f64>,
        theta: f64,
    ) -> Result<Self, FactorError> {
        let factor = symbolic.factorize(pencil.combine(1.0, theta))?;
        let mut right_hand_side = Mat::zeros(basis.nrows(), basis.ncols());
        pencil.stiffness().mul_into(basis, right_hand_side.as_mut());
        right_hand_side *= faer::Scale(-theta);
        let mut increment = right_hand_side.clone();
        Solve::new(symbolic, basis.ncols(), true).solve_in_place(&factor, increment.as_mut());
        let mut weighted = Mat::zeros(basis.nrows(), basis.ncols());
        factor.matrix().mul_into(increment.as_ref(), weighted.as_mut());
        let residual = (&weighted - &right_hand_side).norm_l2() / right_hand_side.norm_l2();
        pencil.mass().mul_into(increment.as_ref(), weighted.as_mut());
        let product = basis.transpose() * weighted;
        let state = Mat::from_fn(basis.ncols(), basis.ncols(), |i, j| 0.5 * (product[(i, j)] + product[(j, i)]));
        Ok(Self { theta, increment, state, residual })
    }
}

/// The same inside the basis only (Galerkin), for coordinates in which `BᵀKB = diag(λ)`: `e_k = −θλ_k/(1 + θλ_k)`.
pub fn galerkin_increment(theta: f64, eigenvalue: f64) -> f64 {
    let x = theta * eigenvalue;
    -x / (1.0 + x)
}
