//! `representation` and `[canonical]`: which form the stage maps are written in, and what is done about the chapter's.

use serde::Deserialize;

use super::check::positive;
use super::{Problem, ProblemError};

/// The form of the stage maps in the file.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "lowercase")]
pub enum Representation {
    /// The state enters as the vector it is.
    #[default]
    Block,
    /// The chapter's: every state coordinate, the load's magnitude and its position are axes.
    Canonical,
}

/// Options of the canonical representation; the defaults are the chapter's method.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ChapterEntry {
    /// What is done about the chapter's weaknesses.
    pub repairs: Vec<Repair>,
    /// What turns a full-order stage solution into reduced coordinates.
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

/// One repair of the chapter's method (docs/theory/5-vademecum.md).
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
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

/// What turns a full-order stage solution into reduced coordinates.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Eq)]
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

impl Problem {
    /// Options of the chapter's representation, if it is asked for.
    pub fn chapter(&self) -> Option<ChapterEntry> {
        let asked = self.representation == Representation::Canonical;
        asked.then(|| self.canonical.clone().unwrap_or_default())
    }

    pub(super) fn check_chapter(&self) -> Result<(), ProblemError> {
        let asked = self.representation == Representation::Canonical;
        self.require(
            !asked || self.parameters.is_empty(),
            "representation",
            "canonical beside `[[parameter]]`",
            "\"block\" where parameters are live",
        )?;
        let Some(c) = &self.canonical else { return Ok(()) };
        self.require(asked, "canonical", "a table", "`representation = \"canonical\"` beside it")?;
        let tolerance = c.tolerance >= 1e-12 && c.tolerance < 1.0;
        self.require(tolerance, "canonical.tolerance", c.tolerance, "at least 1e-12 and below 1")?;
        self.require(c.max_terms.is_none_or(|t| t >= 2), "canonical.max_terms", c.max_terms, "at least 2")?;
        let points = (2..=1000).contains(&c.points);
        self.require(points, "canonical.points", c.points, "2 to 1000")?;
        let margin = c.margin >= 0.0 && c.margin.is_finite();
        self.require(margin, "canonical.margin", c.margin, "zero or a positive number")?;
        self.require(c.positions != Some(0), "canonical.positions", 0, "at least 1")?;
        let [lower, upper] = c.load;
        let load = lower <= 0.0 && upper >= 0.0 && lower < upper && (upper - lower).is_finite();
        self.require(load, "canonical.load", c.load, "two finite numbers around zero, the smaller first")?;
        let length = c.direction.is_none_or(|d| positive(d.iter().map(|x| x * x).sum()));
        self.require(length, "canonical.direction", c.direction, "a vector of some length")?;
        let one = !(c.components && c.direction.is_some());
        self.require(one, "canonical.components", "true beside `direction`", "one of them")
    }
}
