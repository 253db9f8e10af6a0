//! Refusals of the strain field.

use crate::fem::element::ElementError;
use crate::mesh::Hexahedra;

/// Why a model has no strain field.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum GreenError {
    /// The model came as two matrices.
    #[error(
        "large displacements need elements and materials; this model was given as two matrices, which say nothing \
         beyond small displacements: give the mesh and its materials"
    )]
    NoElements,
    /// The stiffness of an element is more than a sum over its points of integration.
    #[error(
        "large displacements take no 8-node hexahedra with {} (region `{region}`): mesh it with quadratic elements, \
         or give its `[[material]]` `hexahedra = \"full\"` or `\"mean-dilatation\"`, which are too stiff where the \
         body bends",
        what(*.hexahedra)
    )]
    Formulation {
        /// Name of the region.
        region: String,
        /// Its formulation.
        hexahedra: Hexahedra,
    },
    /// A material that is not the same in every direction.
    #[error("large displacements take isotropic materials: give `young` and `poisson`")]
    Anisotropic,
    /// An element folds over at a point of integration.
    #[error("element {element} (counted from 0)")]
    Folded {
        /// Index of the element.
        element: usize,
        /// The value found.
        source: ElementError,
    },
}

fn what(hexahedra: Hexahedra) -> &'static str {
    match hexahedra {
        Hexahedra::Incompatible => "incompatible modes",
        Hexahedra::Reduced | Hexahedra::ReducedMass => "one point and hourglass stiffness",
        Hexahedra::MeanDilatation => "mean dilatation",
        Hexahedra::Full => "full integration",
    }
}
