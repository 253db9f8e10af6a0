//! Ports: the patches and frames by which an assembly joins the body to others.

use schemars::JsonSchema;
use serde::Deserialize;

use crate::mesh::select::Selection;

/// A patch of the surface, or a frame, by which an assembly joins the body to others.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PortEntry {
    /// Its name.
    pub name: String,
    /// Its kind.
    #[serde(default)]
    pub kind: PortKind,
    /// The facets, all of whose corners are selected; a frame has their mean motion.
    pub on: Option<Selection>,
    /// The reference point whose motions a frame has; or `on`.
    pub reference: Option<String>,
    /// Origin of a frame of facets; absent: their centre.
    pub at: Option<[f64; 3]>,
    /// Directions of the first and the second axis of a frame, perpendicular; absent: those of space.
    pub axes: Option<[[f64; 3]; 2]>,
}

/// Kind of a port.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Eq, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum PortKind {
    /// Three displacements of each node of the facets.
    #[default]
    Patch,
    /// Three displacements and three rotations.
    Frame,
}
