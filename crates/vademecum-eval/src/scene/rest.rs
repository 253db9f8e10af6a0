//! When an unloaded body is put at rest, and what energy that can take away.
//!
//! A body rests once `Σ|y| ≤ ε` over its `3r` state numbers. Its energy is then
//! `½ s_ρ ζ̇ᵀM_rζ̇ + ½ s_K ζᵀK_rζ` with `|ζ| + |Δt ζ̇| ≤ ε`, which is convex and therefore largest when one
//! of the two has all of `ε`: `E ≤ ½ ε² max(s_ρ μ/Δt², s_K κ)` with `μ` and `κ` at least the largest
//! eigenvalues of `M_r` and `K_r` (theory page 6 says what the bound is good for).
//!
//! Note: there is always a threshold, [`Scalar::REST`]. A kernel sets numbers below
//! [`Scalar::FLOOR`] to zero, which feeds a lightly damped body about as much as damping takes from it:
//! without a threshold it moved for ever at some hundred times the floor.

use crate::base::scalar::Scalar;
use crate::kernels::strain::map::bounds;
use crate::scene::equation::{Equation, larger};
use crate::scene::scene::Scene;

impl<T: Scalar> Scene<'_, T> {
    /// The largest energy \[J\] that a body of this scene can have when it is put at rest; every later
    /// displacement it is spared is at most that of this energy. Goes with the square of
    /// [`SceneOptions::rest_below`](crate::SceneOptions::rest_below). `O(r)`.
    #[must_use]
    pub fn energy_at_rest(&self) -> f64 {
        if self.shape.is_strain() {
            // |z| ≤ |L| |q| + |Q| |q|².
            let ([linear, quadratic], at) = (bounds(&self.sections.strain), self.rest_below.to_f64());
            let (strain, rate) = (linear * at + quadratic * at * at, at / self.parameters.time_step);
            return 0.5
                * (self.parameters.stiffness * strain * strain + self.parameters.density * rate * rate);
        }
        energy(self.rest_below, &self.equation(), self.shape.r)
    }
}

/// The largest energy \[J\] of a body of `r` modes put at rest below `threshold`; not a number if a matrix is
/// smaller than that.
pub(crate) fn energy<T: Scalar>(threshold: T, equation: &Equation<'_, '_>, r: usize) -> f64 {
    let stiffness = equation.stiffness_bound(r).unwrap_or(f64::NAN);
    let mass = equation.region_density.iter().copied().fold(0.0, larger);
    let step = equation.parameters;
    let kinetic = step.density * mass / (step.time_step * step.time_step);
    let threshold = threshold.to_f64();
    0.5 * threshold * threshold * larger(step.stiffness * stiffness, kinetic)
}
