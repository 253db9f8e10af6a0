//! Constants of a material.

use vademecum_build::fem::Material;

use crate::error::DeckError;

/// Properties of a material as far as they were read.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Solid {
    pub(crate) young: Option<f64>,
    pub(crate) poisson: f64,
    pub(crate) density: f64,
}

impl Solid {
    /// An isotropic material; a density of zero is none.
    pub(crate) fn material(&self, name: &str) -> Result<Material, DeckError> {
        let young = self.young.ok_or_else(|| DeckError::Incomplete {
            material: name.into(),
            quantity: "modulus",
            card: "*ELASTIC",
        })?;
        Ok(Material { young, poisson: self.poisson, density: self.density })
    }
}
