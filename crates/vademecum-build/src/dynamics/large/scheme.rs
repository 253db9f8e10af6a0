//! Time schemes and damping of marches at large displacements.

use vademecum_format::scheme::SchemeTable;

use crate::dynamics::schemes::{SchemeError, SchemeKind};

/// A time scheme for large displacements.
#[derive(Clone, Copy, Debug, PartialEq)]
// One value for a march, and easy to copy.
#[allow(clippy::large_enum_variant)]
pub enum LargeScheme {
    /// The stages of a table, each in balance at its own instant: Bathe's method, ρ∞-Bathe, Newmark.
    Table(SchemeTable),
    /// The midpoint rule with the mean of the stresses of both ends (Simo and Tarnow 1992; the discrete
    /// gradient of Gonzalez 2000): without loads and damping, energy and momenta stay to rounding.
    EnergyMomentum,
}

impl LargeScheme {
    /// Bathe's method.
    pub fn bathe() -> LargeScheme {
        LargeScheme::Table(crate::dynamics::schemes::bathe())
    }

    /// The scheme of a problem.
    ///
    /// # Errors
    /// [`SchemeError`]: a parameter outside its range. Whether it suits large displacements is found when the
    /// march is set up.
    pub fn of(kind: SchemeKind) -> Result<LargeScheme, SchemeError> {
        Ok(LargeScheme::Table(kind.table()?))
    }

    /// True if each stage balances the forces at its own instant.
    pub(crate) fn is_suitable(&self) -> bool {
        let LargeScheme::Table(table) = self else { return true };
        let own = table.active().iter().all(|stage| {
            stage.stiffness == 1.0 && stage.stiffness_history.iter().all(|&weight| weight == 0.0)
        });
        own && !table.is_exact()
    }
}

/// Damping at large displacements. Each part dissipates, whatever the motion.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LargeDamping {
    /// `α`, the weight of the mass \[1/s\]: slows rigid motion too.
    pub mass: f64,
    /// `β` of the stiffness at rest \[s\]: Rayleigh's, as in the linear march. It takes a rotation for a
    /// strain, so it is for comparison with linear models.
    pub stiffness: f64,
    /// `β` of the strain rate \[s\] (Kelvin–Voigt): stress `z + β ż`. Small motions see Rayleigh's `β K`, and
    /// a rotation is not damped.
    pub strain_rate: f64,
}

impl LargeDamping {
    /// True if no part is negative or infinite.
    pub(crate) fn is_sound(&self) -> bool {
        [self.mass, self.stiffness, self.strain_rate].iter().all(|x| *x >= 0.0 && x.is_finite())
    }
}
