//! From a mesh and materials to the full-order matrices: elements, assembly, loads, factorisation.
//!
//! A [`Model`] is the body: mesh, supports, materials. Its [`Pencil`] is the algebra: `M` and `K` over the
//! free dofs. Everything after this stage (dynamics, basis, vademecum) works on the pencil alone, so a
//! problem given as two matrices runs the same road as a solid.

mod assembly;
mod blocks;
mod coarse;
mod coupling;
mod dampers;
mod dofs;
mod element;
mod elimination;
mod engine;
mod factor;
mod factor_error;
mod freedom;
mod green;
mod heat;
mod hexahedron;
mod kernels;
mod late;
mod loads;
mod local_rows;
mod material;
mod model;
mod model_error;
mod multifrontal;
mod number;
mod ordering;
mod pencil;
mod point;
mod prestress;
mod raised;
mod rigid;
mod selected;
mod single;
mod sparse;
mod spread;
mod stress;
mod substitution;
mod supernodes;
mod thermal;
mod thin;
mod tie;
mod tree;
mod whole;

pub(crate) use assembly::{pair_bytes, pairs};
pub use blocks::{Block, BlockGroups, ElementMatrices, assemble_blocks, inertia_forces, internal_forces};
pub use coupling::{mean_rows, rigid_row};
pub(crate) use dampers::FEW_DASHPOTS;
pub use dampers::{Dampers, DampingBlock};
pub use dofs::DofMap;
pub use element::ElementError;
pub use elimination::{Constraints, Contradiction, Elimination};
pub use engine::{Engine, MassProduct, PencilRows, Search, SpreadFactor};
pub(crate) use engine::{LocalMass, agree_matrix, sum_matrix};
pub use factor::{Factor, FactorColumns, Solve, Symbolic};
pub use factor_error::FactorError;
pub(crate) use green::SOFTENING;
pub use green::{GreenError, GreenStrain};
pub use heat::{Heat, HeatLaw};
pub(crate) use loads::facet_shapes;
pub use loads::{Facet, LoadError, facet_load, facet_matrix, pressure_stiffness, surface_facets};
pub(crate) use local_rows::pencil_rows;
pub use material::{Cylinder, Elasticity, Material, Stiffness};
pub use model::{Attachments, Model};
pub use model_error::ModelError;
pub(crate) use ordering::elimination_order;
pub use pencil::{Pencil, PencilError};
pub use prestress::{Prestress, Rotation, buckling_factor};
pub(crate) use raised::RaisedSpace;
pub use rigid::RigidBody;
pub(crate) use selected::SelectedInverse;
pub use sparse::{AT_ONCE, Pattern, SymmetricMatrix};
pub(crate) use sparse::{contiguous, contiguous_mut};
pub use spread::{EngineError, Resource, SpreadMatrix};
pub use stress::{COMPONENTS, StressPoint, StressRows, stress_points};
pub(crate) use thermal::element_stress;
pub use thermal::thermal_forces;
pub use tie::{Anchor, anchors, over_gap};
pub use whole::{AssemblyPart, AssemblyPlan};

#[cfg(test)]
mod convergence_tests;
#[cfg(test)]
mod element_tests;
#[cfg(test)]
mod factor_tests;
#[cfg(test)]
mod foundation_tests;
#[cfg(test)]
mod green_tests;
#[cfg(test)]
mod oracle_tests;
#[cfg(test)]
mod prestress_tests;
#[cfg(test)]
mod rigid_attached_tests;
#[cfg(test)]
mod rigid_tests;
#[cfg(test)]
pub(crate) mod test_cells;
#[cfg(test)]
pub(crate) mod test_mesh;
