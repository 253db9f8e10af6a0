//! Constants of a material.

use vademecum_build::fem::{Cylinder, Elasticity, HeatLaw, Material};

use crate::error::DeckError;

/// Properties of a material as far as they were read.
#[derive(Clone, Debug, Default)]
pub(crate) struct Solid {
    /// Along the axes of the material; the first one of a table.
    pub(crate) elasticity: Option<Elasticity>,
    /// The same by temperature.
    pub(crate) by_temperature: Vec<(f64, Elasticity)>,
    pub(crate) density: f64,
    pub(crate) expansion: Expansion,
}

/// Mean coefficients of expansion.
#[derive(Clone, Debug, Default)]
pub(crate) struct Expansion {
    /// Temperature from which they count.
    pub(crate) zero: f64,
    /// Temperature, and the coefficients along the axes of the material.
    pub(crate) rows: Vec<(f64, [f64; 3])>,
    /// True if they may differ along the axes.
    pub(crate) along_axes: bool,
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

/// The material of a region.
pub(crate) struct OfRegion {
    /// A density of zero is none.
    pub(crate) material: Material,
    /// The line about which its axes turn.
    pub(crate) cylinder: Option<Cylinder>,
    pub(crate) heat: HeatLaw,
}

impl Solid {
    /// True if a constant depends on the direction; of the expansion if the deck has temperatures.
    pub(crate) fn has_axes(&self, heated: bool) -> bool {
        matches!(self.elasticity, Some(Elasticity::Anisotropic(_))) || heated && self.expansion.along_axes
    }

    /// The material of a section.
    pub(crate) fn material(
        &self,
        name: &str,
        axes: Option<Orientation>,
        heated: bool,
    ) -> Result<OfRegion, DeckError> {
        let elasticity = self.elasticity.ok_or_else(|| DeckError::Incomplete {
            material: name.into(),
            quantity: "modulus",
            card: "*ELASTIC",
        })?;
        let (own, cylinder) = match axes.filter(|_| self.has_axes(heated)) {
            None => (None, None),
            Some(Orientation::Fixed(own)) => (Some(own), None),
            Some(Orientation::Turning(cylinder, own)) => (Some(own), Some(cylinder)),
            Some(Orientation::Other) => {
                return Err(DeckError::Incomplete {
                    material: name.into(),
                    quantity: "axes that are read",
                    card: "*ORIENTATION with SYSTEM=RECTANGULAR or CYLINDRICAL and the coordinates of two \
                           points",
                });
            }
        };
        let along = |elasticity: Elasticity| match (elasticity, own) {
            (Elasticity::Anisotropic(stiffness), Some(own)) => Elasticity::Anisotropic(stiffness.along(own)),
            _ => elasticity,
        };
        let Expansion { zero, rows, .. } = &self.expansion;
        let heat = HeatLaw {
            zero: *zero,
            expansion: rows.iter().map(|&(at, along)| (at, HeatLaw::along(along, own))).collect(),
            elasticity: self.by_temperature.iter().map(|&(at, own)| (at, along(own))).collect(),
        };
        Ok(OfRegion {
            material: Material { elasticity: along(elasticity), density: self.density },
            cylinder,
            heat,
        })
    }
}
