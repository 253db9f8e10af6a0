//! Formulations of hexahedra.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Formulation of the hexahedra of a region.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Hexahedra {
    /// Incompatible modes in 8-node hexahedra, full integration in larger ones (C3D8I, C3D20).
    Incompatible,
    /// Mean dilatation in 8-node hexahedra, full integration in larger ones (Abaqus: C3D8).
    MeanDilatation,
    /// Full integration, which locks in bending with 8 nodes (CalculiX: C3D8).
    Full,
    /// One point and hourglass stiffness in 8-node hexahedra, eight points in 20-node ones (C3D8R, C3D20R).
    Reduced,
    /// The same, with eight points for the mass of 20-node hexahedra too (CalculiX: C3D20R).
    ReducedMass,
}

impl Hexahedra {
    /// All formulations, in order.
    pub const ALL: [Self; 5] =
        [Self::Incompatible, Self::MeanDilatation, Self::Full, Self::Reduced, Self::ReducedMass];
}
