//! Attachments: reference points, couplings, ties, foundations, masses, springs and dashpots.

use schemars::JsonSchema;
use serde::Deserialize;

use super::body::Component;
use crate::mesh::select::Selection;

/// A point with three displacements and three rotations, which couplings join to the body.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ReferencePointEntry {
    /// Its name.
    pub name: String,
    /// Its place.
    pub at: [f64; 3],
    /// Motions held at zero.
    #[serde(default)]
    pub held: Vec<Motion>,
}

/// A motion of a reference point: a displacement or a rotation about an axis.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq, JsonSchema)]
#[serde(rename_all = "lowercase")]
#[allow(missing_docs)]
pub enum Motion {
    X,
    Y,
    Z,
    Rx,
    Ry,
    Rz,
}

/// A coupling of nodes to a reference point.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CouplingEntry {
    /// The reference point.
    pub reference: String,
    /// The nodes; or `weights`.
    pub on: Option<Selection>,
    /// Which follows which.
    pub kind: CouplingKind,
    /// Nodes by their number in the mesh file, with their weights in the mean of an average coupling.
    pub weights: Option<Vec<(u64, f64)>>,
    /// Displacements of the nodes that follow a rigid coupling; absent: all three.
    pub components: Option<Vec<Component>>,
}

/// Kind of a coupling.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum CouplingKind {
    /// The nodes follow the reference point as a rigid body does (RBE2, kinematic coupling).
    Rigid,
    /// The reference point follows the mean motion of the nodes (RBE3, distributing coupling).
    Average,
}

/// Nodes that follow the facets of another surface.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TieEntry {
    /// The nodes that follow.
    pub on: Selection,
    /// The facets, all of whose corners are selected.
    pub to: Selection,
    /// Largest distance from a facet.
    pub distance: f64,
}

/// Facets on an elastic ground: stiffness and damping per area (Winkler's foundation).
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FoundationEntry {
    /// Its name, by which a live parameter scales it; several may share one.
    pub name: Option<String>,
    /// The facets, all of whose corners are selected.
    pub on: Selection,
    /// Stiffness per area along the normal of the facets.
    #[serde(default)]
    pub normal: f64,
    /// Stiffness per area along the facets.
    #[serde(default)]
    pub tangential: f64,
    /// Damping per area along the normal of the facets.
    #[serde(default)]
    pub damping_normal: f64,
    /// Damping per area along the facets.
    #[serde(default)]
    pub damping_tangential: f64,
}

/// A linear equation between displacements, `Σ a u = 0`.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EquationEntry {
    /// Its terms; the first displacement is the one that is eliminated, if it can be.
    pub terms: Vec<EquationTerm>,
}

/// Node, component and coefficient of a term: components 1 to 3 are displacements, 4 to 6 rotations of a
/// reference point.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
pub struct EquationTerm(pub EquationNode, pub u8, pub f64);

/// A node of the mesh by its number, or a reference point by its name.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum EquationNode {
    /// Number of a node in the mesh file.
    Node(u64),
    /// Name of a reference point.
    Point(String),
}

/// A mass at a reference point.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PointMassEntry {
    /// Its name, by which a live parameter scales it; several may share one.
    pub name: Option<String>,
    /// The reference point.
    pub reference: String,
    /// The mass.
    pub mass: f64,
    /// Moments of inertia about the point, xx, yy, zz, and products of inertia, xy, xz, yz.
    #[serde(default)]
    pub inertia: [f64; 6],
}

/// A spring between two reference points, or from one to the ground.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SpringEntry {
    /// Its name, by which a live parameter scales it; several may share one.
    pub name: Option<String>,
    /// The first reference point.
    pub from: String,
    /// The second one; absent: the ground.
    pub to: Option<String>,
    /// Stiffness along the three axes and about them; or `matrix`.
    pub stiffness: Option<[f64; 6]>,
    /// Upper triangle, row by row, of the stiffness over the six motions of the first point, then of the
    /// second one: 78 numbers, or 21 of a spring to the ground.
    pub matrix: Option<Vec<f64>>,
    /// Directions of the first and the second axis, perpendicular; absent: those of space.
    pub axes: Option<[[f64; 3]; 2]>,
}

/// A dashpot between two reference points, or from one to the ground.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DashpotEntry {
    /// Its name, by which a live parameter scales it; several may share one.
    pub name: Option<String>,
    /// The first reference point.
    pub from: String,
    /// The second one; absent: the ground.
    pub to: Option<String>,
    /// Damping along the three axes and about them.
    pub damping: [f64; 6],
    /// Directions of the first and the second axis, perpendicular; absent: those of space.
    pub axes: Option<[[f64; 3]; 2]>,
}
