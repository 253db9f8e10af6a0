//! Constants of a material.

use vademecum_build::fem::{Elasticity, Material};

use crate::error::DeckError;

/// Properties of a material as far as they were read.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Solid {
    /// Along the axes of the material.
    pub(crate) elasticity: Option<Elasticity>,
    pub(crate) density: f64,
}

/// Axes of a material.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Orientation {
    /// The first and the second one.
    Fixed([[f64; 3]; 2]),
    /// Those that are given in another way, or turn from place to place.
    Other,
}

impl Solid {
    /// The material of a section; a density of zero is none.
    pub(crate) fn material(&self, name: &str, axes: Option<Orientation>) -> Result<Material, DeckError> {
        let elasticity = self.elasticity.ok_or_else(|| DeckError::Incomplete {
            material: name.into(),
            quantity: "modulus",
            card: "*ELASTIC",
        })?;
        let elasticity = match (elasticity, axes) {
            (Elasticity::Isotropic { .. }, _) | (_, None) => elasticity,
            (Elasticity::Anisotropic(own), Some(Orientation::Fixed(axes))) => {
                Elasticity::Anisotropic(own.along(axes))
            }
            (_, Some(Orientation::Other)) => {
                return Err(DeckError::Incomplete {
                    material: name.into(),
                    quantity: "axes that are read",
                    card: "*ORIENTATION with SYSTEM=RECTANGULAR and the coordinates of two points",
                });
            }
        };
        Ok(Material { elasticity, density: self.density })
    }
}
