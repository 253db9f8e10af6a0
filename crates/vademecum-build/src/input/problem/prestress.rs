//! A static load case about which a body moves.

use schemars::JsonSchema;
use serde::Deserialize;

/// A static load case, solved at small displacements; the body moves about it.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PrestressEntry {
    /// Load patterns, each with its amplitude.
    #[serde(default)]
    pub loads: Vec<PrestressLoad>,
    /// Body force per mass, such as gravity.
    pub acceleration: Option<[f64; 3]>,
    /// Rotation at a constant speed.
    pub rotation: Option<RotationEntry>,
}

/// Name of a load pattern, and its amplitude.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
pub struct PrestressLoad(pub String, pub f64);

/// Rotation about an axis in space.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RotationEntry {
    /// Angular velocity \[rad/s\].
    pub speed: f64,
    /// Direction of the axis.
    pub axis: [f64; 3],
    /// A point of the axis.
    #[serde(default)]
    pub point: [f64; 3],
}
