//! The response of one stage to every unit reduced state, full order: `H = (M + θK)⁻¹ M B` as its increment
//! over `B`.
//!
//! With the projection `Π = BᵀM` one n × r matrix per stage carries everything the step needs: its square
//! part `C = BᵀM H` moves the state, and by reciprocity `Π (M + θK)⁻¹ F = HᵀF` its rows are the response to a
//! unit force at each dof. What is stored is `H − B` and `C − I`: the identity is exact and the small numbers
//! keep all their digits.
//!
//! Source: chapter 5, eqs. (5.5), (5.6), with the state entering linearly and exactly instead of through axes
//! (docs/explanation/5-vademecum.md).

use faer::prelude::Solve as _;
use faer::{Mat, MatRef};

use vademecum_format::scheme::theta;

use super::error::ResponseError;
use crate::basis::Basis;
use crate::fem::{FactorError, Pencil, Solve, Symbolic};
use crate::linalg::symmetric_part;
use crate::prepared::Prepared;
use crate::store::{Inputs, StageInput};

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

/// All stages of a step.
impl StageInput for [StageResponse] {
    fn add_to(&self, inputs: Inputs) -> Inputs {
        let one = |inputs: Inputs, r: &StageResponse| {
            inputs.value(&r.theta).matrix(r.increment.as_ref()).matrix(r.state.as_ref())
        };
        self.iter().fold(inputs, one)
    }
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
        let state = symmetric_part(product.as_ref());
        Ok(Self { theta, increment, state, residual })
    }

    /// The same inside the basis only, as a Galerkin reduced model has it: `H = B C` with `C = (I + θA)⁻¹`,
    /// `A = BᵀKB`.
    ///
    /// `E = C − I = −θA (I + θA)⁻¹`. What leaves the span of `B` within the step is lost; kept to compare
    /// with.
    ///
    /// # Panics
    /// If `stiffness`, `BᵀKB` of shape (r, r), is not positive semidefinite.
    pub fn galerkin(basis: MatRef<'_, f64>, stiffness: MatRef<'_, f64>, theta: f64) -> Self {
        let r = basis.ncols();
        let scaled = Mat::from_fn(r, r, |i, j| theta * stiffness[(i, j)]);
        let shifted = Mat::from_fn(r, r, |i, j| scaled[(i, j)] + f64::from(u8::from(i == j)));
        let factor = shifted.llt(faer::Side::Lower).expect("I + θA is positive definite");
        let solved = factor.solve(&scaled);
        let state = Mat::from_fn(r, r, |i, j| -0.5 * (solved[(i, j)] + solved[(j, i)]));
        Self { theta, increment: basis * &state, state, residual: 0.0 }
    }
}

/// One response per stage; stages that share θ share the solve.
///
/// # Errors
/// [`ResponseError`]: a stage that does not factorise.
pub fn stage_responses(prepared: &Prepared, basis: &Basis) -> Result<Vec<StageResponse>, ResponseError> {
    let Prepared { body, symbolic, scheme, step, .. } = prepared;
    let mut responses: Vec<StageResponse> = vec![];
    for i in 0..scheme.active().len() {
        let theta = theta(scheme, step, i)?;
        let response = match responses.iter().find(|r| r.theta == theta) {
            Some(same) => same.clone(),
            None => StageResponse::solve(body.model.pencil(), symbolic, basis.vectors.as_ref(), theta)?,
        };
        responses.push(response);
    }
    Ok(responses)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn galerkin_in_ritz_coordinates_is_the_closed_form() {
        let eigenvalues = [3.0, 40.0, 5e4];
        let stiffness = Mat::from_fn(3, 3, |i, j| if i == j { eigenvalues[i] } else { 0.0 });
        let basis = Mat::from_fn(5, 3, |i, j| (1 + i * 3 + j) as f64);
        let response = StageResponse::galerkin(basis.as_ref(), stiffness.as_ref(), 0.02);
        for (k, &eigenvalue) in eigenvalues.iter().enumerate() {
            let x = 0.02 * eigenvalue;
            let expected = -x / (1.0 + x);
            // Two roundings against one.
            assert!((response.state[(k, k)] - expected).abs() <= 4.0 * f64::EPSILON);
            assert!(
                (response.increment[(4, k)] - basis[(4, k)] * expected).abs()
                    <= 16.0 * f64::EPSILON * basis[(4, k)]
            );
        }
    }
}
