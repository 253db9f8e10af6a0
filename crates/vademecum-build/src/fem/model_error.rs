//! Why there is no model.

use super::element::ElementError;
use super::elimination::Contradiction;
use super::material::Material;
use super::spread::EngineError;
use crate::linalg::NoConvergence;

/// Why a mesh, its materials and supports make no model.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ModelError {
    /// Not one material per region.
    #[error("{found} materials for {expected} regions")]
    MaterialCount {
        /// Materials given.
        found: usize,
        /// Regions of the mesh.
        expected: usize,
    },
    /// A constant that no solid has.
    #[error(
        "material of region \"{region}\" must have E > 0, -1 < nu < 0.5 or a positive definite stiffness, rho > 0; \
         found {material:?}"
    )]
    UnsoundMaterial {
        /// Name of the region.
        region: String,
        /// The material found.
        material: Box<Material>,
    },
    /// A dashpot, a spring or an equation with numbers that are not finite.
    #[error("a dashpot, a spring or an equation")]
    Attachment(#[from] NoConvergence),
    /// Not one support flag per dof.
    #[error("{found} support flags for {expected} dofs (3 per node)")]
    SupportCount {
        /// Flags given.
        found: usize,
        /// Dofs of the mesh.
        expected: usize,
    },
    /// An element folds over.
    #[error("element {element} (counted from 0)")]
    FoldedElement {
        /// Index of the element.
        element: u32,
        /// The value found.
        source: ElementError,
    },
    /// The mesh has no element, or every dof is held.
    #[error("nothing can move: the mesh has no element or all of its dofs are held")]
    NothingFree,
    /// A part of the body is not held.
    #[error(
        "the part of the body with node {node} ({n_nodes} nodes) can still move in {n_modes} of the 6 rigid ways: \
         support it"
    )]
    Unsupported {
        /// A node of the part, as the mesh file numbers it.
        node: u64,
        /// Nodes of the part.
        n_nodes: usize,
        /// Rigid-body modes left to it.
        n_modes: usize,
    },
    /// Supports and attachments resist some rigid motions of the body, not all.
    #[error(
        "{holder} resists rigid motions of the body, and nothing resists {n_modes} of the 6{}: hold it in all of them, by \
         supports, springs or a foundation, or in none: a body that flies has couplings and equations that its rigid \
         motions fulfil",
        among(named)
    )]
    PartlyHeld {
        /// The first one that does.
        holder: String,
        /// Rigid motions left to it.
        n_modes: usize,
        /// Those of them that are along or about an axis of space.
        named: String,
    },
    /// A free body with parts or reference points that can move by themselves.
    #[error(
        "the body has no support, and it can move without any strain in {more} ways more than the 6 rigid ones: a part of          its mesh or a reference point is not joined to the rest, or joined by a hinge; join it by couplings, ties or          springs"
    )]
    Mechanism {
        /// Motions beside the six.
        more: usize,
    },
    /// A dashpot to the ground on a body that flies freely.
    #[error(
        "a dashpot or a foundation damps rigid motions of a body that nothing holds: expected dashpots between two points          of the body, or a body that is held"
    )]
    DampedFlight,
    /// A body without supports that hangs together in several parts.
    #[error(
        "the body has no support, and {parts} parts that no element connects; the part with node {node} has {n_nodes} \
         nodes: expected one part, which may then move freely; support each part, or mesh them as one"
    )]
    FreeParts {
        /// Parts.
        parts: usize,
        /// A node of the second part, as the mesh file numbers it.
        node: u64,
        /// Nodes of that part.
        n_nodes: usize,
    },
    /// A part of the body is held, but at so small a place that double precision does not see it.
    #[error(
        "the part of the body with node {node} ({n_nodes} nodes) is {size:.1e} long and held over {span:.1e} of it: less than \
         a millionth does not hold it in double precision; support more of it, or correct its dimensions"
    )]
    SupportTooSmall {
        /// A node of the part, as the mesh file numbers it.
        node: u64,
        /// Nodes of the part.
        n_nodes: usize,
        /// Largest extent of the part.
        size: f64,
        /// Largest extent of its held nodes.
        span: f64,
    },
    /// Matrices of another size than the number of free dofs.
    #[error("matrices of {found} rows for {expected} free dofs")]
    PencilSize {
        /// Rows of the matrices.
        found: usize,
        /// Free dofs.
        expected: usize,
    },
    /// A spring, mass or beam on a coupling of very many nodes.
    #[error(
        "a spring, a mass or a beam couples {dofs} free dofs through the mean of its nodes; expected at most {most}: \
         couple it to fewer nodes, or rigidly"
    )]
    Coupled {
        /// Dofs that it couples.
        dofs: usize,
        /// Most that are assembled.
        most: usize,
    },
    /// Couplings, ties, equations and supports that cannot hold at once.
    #[error(transparent)]
    Contradiction(#[from] Contradiction),
    /// More matrix entries than a 32-bit index counts.
    #[error("the matrices have more entries than a 32-bit index can count")]
    TooLarge,
    /// The memory for an order of elimination was refused.
    #[error("not enough memory to order the dofs")]
    OutOfMemory,
    /// Ranks that assemble together had to stop.
    #[error(transparent)]
    Engine(#[from] EngineError),
}

/// Rigid motions in a message.
fn among(named: &str) -> String {
    if named.is_empty() { String::new() } else { format!(" ({named})") }
}
