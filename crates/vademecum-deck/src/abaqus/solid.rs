//! Constants of a material.

use vademecum_build::fem::{Cylinder, Elasticity, Material};

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
    /// Those that turn about a line, and the first and the second axis of the material along them.
    Turning(Cylinder, [[f64; 3]; 2]),
    /// Those that are given in another way.
    Other,
}

impl Solid {
    /// The material of a section, and the line about which its axes turn; a density of zero is none.
    pub(crate) fn material(
        &self,
        name: &str,
        axes: Option<Orientation>,
    ) -> Result<(Material, Option<Cylinder>), DeckError> {
        let elasticity = self.elasticity.ok_or_else(|| DeckError::Incomplete {
            material: name.into(),
            quantity: "modulus",
            card: "*ELASTIC",
        })?;
        let (elasticity, cylinder) = match (elasticity, axes) {
            (Elasticity::Isotropic { .. }, _) | (_, None) => (elasticity, None),
            (Elasticity::Anisotropic(own), Some(Orientation::Fixed(axes))) => {
                (Elasticity::Anisotropic(own.along(axes)), None)
            }
            (Elasticity::Anisotropic(own), Some(Orientation::Turning(cylinder, axes))) => {
                (Elasticity::Anisotropic(own.along(axes)), Some(cylinder))
            }
            (_, Some(Orientation::Other)) => {
                return Err(DeckError::Incomplete {
                    material: name.into(),
                    quantity: "axes that are read",
                    card: "*ORIENTATION with SYSTEM=RECTANGULAR or CYLINDRICAL and the coordinates of two \
                           points",
                });
            }
        };
        Ok((Material { elasticity, density: self.density }, cylinder))
    }
}
