//! A static load case about which a body moves.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Deserialize;

/// A static load case, solved at small displacements; the body moves about it.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PrestressEntry {
    /// Load patterns by name, each with its amplitude.
    #[serde(default)]
    pub loads: BTreeMap<String, f64>,
    /// Body force per mass, such as gravity.
    pub acceleration: Option<[f64; 3]>,
    /// Angular velocity of a rotation at a constant speed \[rad/s\].
    pub speed: Option<f64>,
    /// Direction of its axis.
    pub axis: Option<[f64; 3]>,
    /// A point of the axis; absent: the origin.
    pub point: Option<[f64; 3]>,
}
