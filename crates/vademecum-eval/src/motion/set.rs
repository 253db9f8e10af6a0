//! Placing of a body: displacement, velocity, and the acceleration that goes with them.

use crate::base::error::StepError;
use crate::base::scalar::Scalar;
use crate::scene::equation::Equation;
use crate::scene::loads::Loads;
use crate::scene::scene::Scene;
use crate::scene::state::State;

impl<T: Scalar> Scene<'_, T> {
    /// Sets displacement and velocity in reduced coordinates and computes the acceleration that goes with
    /// them under `loads` (their force at the start of a step):
    /// `ζ̈ = M_r⁻¹ (BᵀF − s_K K_r (ζ + β ζ̇))/s_ρ − α ζ̇`.
    ///
    /// Under stiffness-proportional damping the residual flexibility starts in equilibrium with the loads;
    /// from zero if all numbers are zero, as that of a body at rest.
    ///
    /// `zeta` \[m kg^½\] and `zeta_dot` \[m kg^½/s\] have length `r`. With region densities, `M_r ζ̈ = …` is
    /// solved by conjugate gradients to rounding; otherwise `M_r` is the identity.
    ///
    /// # Errors
    /// [`StepError`]; the state is then unchanged.
    pub fn set(
        &self,
        state: &mut State<'_, T>,
        zeta: &[f64],
        zeta_dot: &[f64],
        loads: &Loads<'_, T>,
    ) -> Result<(), StepError> {
        if state.shape != self.shape || loads.shape != self.shape {
            return Err(StepError::Mismatch);
        }
        self.check_fresh(loads)?;
        self.equation().place(&mut state.y, zeta, zeta_dot, loads.force)?;
        state.settle_residual(loads);
        if self.shape.is_filtered() && zeta.iter().chain(zeta_dot).all(|&number| number == 0.0) {
            state.clear_filtered();
        }
        Ok(())
    }

    pub(crate) const fn equation(&self) -> Equation<'_, '_> {
        Equation {
            matrices: &self.sections.matrices,
            parameters: &self.parameters,
            region_stiffness: self.options.regions.stiffness(),
            region_density: self.options.regions.density(),
        }
    }
}
