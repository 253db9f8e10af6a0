//! When an unloaded body is put at rest, and what energy that can take away.
//!
//! A body rests once `Σ|y| ≤ ε` over its `3r` state numbers. Its energy is then `½ s_ρ ζ̇ᵀM_rζ̇ + ½ s_K ζᵀK_rζ` with `|ζ| + |Δt ζ̇| ≤ ε`, which is
//! convex and therefore largest when one of the two has all of `ε`: `E ≤ ½ ε² max(s_ρ μ/Δt², s_K κ)` with `μ` and `κ` at least the
//! largest eigenvalues of `M_r` and `K_r` (theory page 6 says what the bound is good for).
//!
//! The odd thing: there is always a threshold, [`Scalar::REST`]. A kernel sets numbers below [`Scalar::FLOOR`] to zero, which feeds a
//! lightly damped body about as much as damping takes from it: without a threshold it moved for ever at some hundred times the floor.

use crate::options::{SceneOptions, Structure};
use crate::scalar::Scalar;
use crate::scene::Scene;

/// The threshold of a scene of these options, rounded.
pub(crate) fn threshold<T: Scalar>(options: &SceneOptions) -> T {
    let asked = T::from_f64(options.rest_below);
    if asked < T::REST { T::REST } else { asked }
}

impl<T: Scalar> Scene<'_, T> {
    /// The largest energy \[J\] that a body of this scene can have when it is put at rest; every later displacement it is spared is at most
    /// that of this energy. Goes with the square of [`SceneOptions::rest_below`]. `O(r)`.
    #[must_use]
    pub fn energy_at_rest(&self) -> f64 {
        let r = self.shape.r;
        let largest = |so_far: f64, value: f64| if value > so_far { value } else { so_far };
        let stiffness = match self.shape.structure {
            Structure::Diagonal => self.sections.stiffness.iter().fold(0.0, largest),
            // The sum of the diagonal: no eigenvalue of a positive matrix is larger.
            Structure::Block | Structure::Canonical => (0..r).map(|k| self.stiffness_entry(k)).sum(),
        };
        let mass = self.options.region_density.iter().copied().fold(0.0, largest);
        let step = &self.parameters;
        let kinetic = step.density * mass / (step.time_step * step.time_step);
        let threshold = self.rest_below.to_f64();
        0.5 * threshold * threshold * largest(kinetic, step.stiffness * stiffness)
    }
}
