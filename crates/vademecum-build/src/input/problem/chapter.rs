//! `representation` and `[canonical]`: which form the stage maps are written in, and what is done about the
//! chapter's.

use schemars::{JsonSchema, Schema};
use serde::Deserialize;
use serde_json::Value;

/// The form of the stage maps in the file.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq, JsonSchema)]
#[serde(rename_all = "lowercase")]
#[schemars(transform = with_aliases)]
pub(crate) enum Representation {
    /// The state enters as the vector it is.
    #[serde(alias = "separated")]
    Block,
    /// One basis for all values of live regions, whose modes are found as they are set.
    Parametric,
    /// The chapter's: every state coordinate, the load's magnitude and its position are axes.
    #[serde(alias = "chapter")]
    Canonical,
}

/// Adds the aliases, which the derive leaves out.
fn with_aliases(schema: &mut Schema) {
    let Some(Value::Array(choices)) = schema.get_mut("oneOf") else { return };
    for (own, alias) in [("canonical", "chapter"), ("block", "separated")] {
        let named = choices.iter().find(|choice| choice["const"] == own).cloned();
        choices.extend(named.map(|mut choice| {
            choice["const"] = alias.into();
            choice
        }));
    }
}

/// Options of the canonical representation; the defaults are the chapter's method.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ChapterEntry {
    /// Repairs of the chapter's method.
    pub repairs: Vec<Repair>,
    /// Projection of a full-order stage solution onto reduced coordinates.
    pub projection: Projection,
    /// Relative error of a stage map at which enrichment stops.
    pub tolerance: f64,
    /// Most terms of a stage; absent: as many as the exact map has, one per right-hand side.
    pub max_terms: Option<usize>,
    /// Points of each state axis.
    pub points: usize,
    /// Share of its length by which each range of the snapshots is widened on both sides.
    pub margin: f64,
    /// Load positions, spread over the loadable surface; absent: every loadable node.
    pub positions: Option<usize>,
    /// Range of the load's magnitude \[N\].
    pub load: [f64; 2],
    /// Direction of the load; absent: +z.
    pub direction: Option<[f64; 3]>,
    /// The components of the load's direction are axes.
    pub components: bool,
}

impl Default for ChapterEntry {
    fn default() -> Self {
        Self {
            repairs: vec![],
            projection: Projection::default(),
            tolerance: 1e-7,
            max_terms: None,
            points: 7,
            margin: 0.5,
            positions: None,
            load: [0.0, 1.0],
            direction: None,
            components: false,
        }
    }
}

/// One repair of the chapter's method (docs/explanation/5-vademecum.md).
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Repair {
    /// Axes in `(ζ, Δt ζ̇, Δt² ζ̈)`.
    ScaledCoordinates,
    /// State and load separated apart, each to its own tolerance.
    SeparateBlocks,
    /// Start from the one-axis terms.
    OneAxisStart,
    /// All factors re-fitted after each enrichment.
    Updates,
}

impl Repair {
    /// All of them.
    pub const ALL: [Self; 4] =
        [Self::ScaledCoordinates, Self::SeparateBlocks, Self::OneAxisStart, Self::Updates];
}

/// Projection of a full-order stage solution onto reduced coordinates.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Eq, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Projection {
    /// `BᵀM`.
    #[default]
    Mass,
    /// `(BᵀB)⁻¹Bᵀ`: the chapter's.
    Euclidean,
}

impl ChapterEntry {
    /// Direction of the load, of length 1; `None` when its components are axes.
    pub fn unit_direction(&self) -> Option<[f64; 3]> {
        let direction = self.direction.unwrap_or([0.0, 0.0, 1.0]);
        let length = direction.iter().map(|d| d * d).sum::<f64>().sqrt();
        (!self.components).then(|| direction.map(|d| d / length))
    }
}
