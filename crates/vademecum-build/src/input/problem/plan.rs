//! Options of the build: time, snapshots, basis, tolerances, outputs, live parameters.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

use super::body::every_region;
use crate::dynamics::SchemeKind;
use crate::mesh::select::Selection;
use vademecum_format::policy;

/// Scheme and step.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TimeEntry {
    /// The scheme; absent: exact steps, or Bathe's scheme where the file needs stages
    /// ([`Problem::scheme`](super::Problem::scheme)).
    pub scheme: Option<SchemeKind>,
    /// Δt \[s\]; absent: the middle of the range of a live time step, else a round one with at least
    /// 40 steps in the first natural period ([`proposed_time_step`](crate::prepared::proposed_time_step)).
    pub step: Option<f64>,
}

/// Plan of the snapshots, or their files.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SnapshotPlan {
    /// Load positions, spread over the loadable surface.
    #[serde(default = "default_positions")]
    pub positions: usize,
    /// Directions of the force at each position.
    #[serde(default = "the_axes")]
    pub(crate) directions: Vec<[f64; 3]>,
    /// Duration of each force \[s\]; absent: half the first period.
    pub hold: Option<f64>,
    /// Length of each run \[s\]; absent: three first periods.
    pub duration: Option<f64>,
    /// A snapshot is kept every `stride` steps; absent: about 60 snapshots per run.
    pub(crate) stride: Option<usize>,
    /// Snapshots of another program: `.npy` of shape (3 × nodes, snapshots), dof `3 node + component`.
    pub npy: Option<PathBuf>,
    /// Snapshots of another program: VTU files, one snapshot each.
    pub vtu: Option<Vec<PathBuf>>,
    /// Point array of the VTU files that holds the displacement.
    #[serde(default = "displacement")]
    pub field: String,
}

fn default_positions() -> usize {
    12
}

fn the_axes() -> Vec<[f64; 3]> {
    vec![[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
}

fn displacement() -> String {
    "displacement".into()
}

impl Default for SnapshotPlan {
    fn default() -> Self {
        Self {
            positions: default_positions(),
            directions: the_axes(),
            hold: None,
            duration: None,
            stride: None,
            npy: None,
            vtu: None,
            field: displacement(),
        }
    }
}

/// The basis.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BasisEntry {
    /// Kind of basis; absent: natural modes with exact steps, else Ritz vectors
    /// (`Problem::basis_kind`).
    pub kind: Option<BasisKind>,
    /// Number of modes; absent: by `energy`, else 8.
    pub modes: Option<usize>,
    /// Fraction of the snapshot energy to keep, in (0, 1).
    pub energy: Option<f64>,
    /// Largest relative bound of natural modes, which then are as many as it takes.
    pub error: Option<f64>,
    /// POD vectors per kept Ritz vector.
    #[serde(default = "default_oversampling")]
    pub oversampling: usize,
    /// Inner product of the POD.
    #[serde(default)]
    pub(crate) inner_product: InnerProduct,
}

fn default_oversampling() -> usize {
    4
}

impl Default for BasisEntry {
    fn default() -> Self {
        Self {
            kind: None,
            modes: None,
            energy: None,
            error: None,
            oversampling: default_oversampling(),
            inner_product: InnerProduct::default(),
        }
    }
}

/// Kind of basis.
#[derive(Clone, Copy, Debug, Deserialize, Serialize, PartialEq, Eq, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum BasisKind {
    /// Ritz vectors of an oversampled POD and of its static response (docs/explanation/4-basis.md).
    Ritz,
    /// Plain POD, as the chapter has it.
    Pod,
    /// The lowest natural modes.
    Modes,
}

impl BasisKind {
    /// As messages have it.
    pub(super) fn words(self) -> &'static str {
        match self {
            Self::Ritz => "Ritz vectors",
            Self::Pod => "POD vectors",
            Self::Modes => "natural modes",
        }
    }
}

/// Inner product in which the POD is best.
#[derive(Clone, Copy, Debug, Default, Deserialize, Serialize, PartialEq, Eq, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(crate) enum InnerProduct {
    /// `M`: kinetic energy.
    #[default]
    Mass,
    /// `K`: strain energy.
    Stiffness,
    /// `I`: the chapter's.
    Identity,
}

/// Tolerances of the build; a build that misses them writes nothing unless told to.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Tolerances {
    /// Largest trajectory error ÷ projection floor.
    #[serde(default = "default_ratio")]
    pub floor_ratio: f64,
    /// Added to the allowed error: what separation and rounding may cost.
    #[serde(default = "default_absolute")]
    pub absolute: f64,
    /// Largest trajectory error, whatever its floor.
    #[serde(default = "default_error")]
    pub error: f64,
    /// Steps of the certificate's unseen runs; absent: three first periods, and at least 500 steps.
    pub steps: Option<usize>,
    /// Largest relative error of a stage map over the parameters, root mean square; ten times that at the
    /// worst point.
    #[serde(default = "default_map")]
    pub map: f64,
    /// Most terms of the separated solution.
    #[serde(default = "default_max_terms")]
    pub(crate) max_terms: usize,
}

fn default_map() -> f64 {
    1e-6
}

fn default_max_terms() -> usize {
    100
}

fn default_ratio() -> f64 {
    policy::FLOOR_RATIO
}

fn default_absolute() -> f64 {
    policy::ABSOLUTE_ERROR
}

fn default_error() -> f64 {
    5e-2
}

impl Default for Tolerances {
    fn default() -> Self {
        Self {
            floor_ratio: default_ratio(),
            absolute: default_absolute(),
            error: default_error(),
            steps: None,
            map: default_map(),
            max_terms: default_max_terms(),
        }
    }
}

/// Outputs of the file.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct OutputEntry {
    /// Fields kept.
    #[serde(default)]
    pub fields: Fields,
    /// Number type of the fields.
    #[serde(default)]
    pub(crate) precision: Precision,
    /// Compute and keep the residual flexibility and its bound; absent: with exact steps.
    pub residual: Option<bool>,
    /// Distance below which the residual flexibility between contacts is kept \[m\].
    pub contact_patch: Option<f64>,
    /// Further natural modes by which contacts of a patch answer statically; absent: 64.
    pub contact_modes: Option<usize>,
    /// Include the static correction in whole fields, by the factor of the stiffness in the file; absent:
    /// where the certificate would miss `tolerance.error` without it.
    pub(crate) static_fields: Option<bool>,
    /// Keep the reactions of the supports: 144 bytes for each support and loadable node.
    #[serde(default)]
    pub reactions: bool,
    /// Named values read at every step.
    #[serde(rename = "probe", default)]
    pub probes: Vec<ProbeEntry>,
    /// Virtual strain gauges, read like probes.
    #[serde(rename = "gauge", default)]
    pub(crate) gauges: Vec<GaugeEntry>,
    /// Nodes whose stress the file can show.
    pub stress: Option<StressPlaces>,
    /// Keep the stress under a contact that the modes leave out; absent: up to
    /// [`STRESS_UNASKED`].
    pub(crate) stress_residual: Option<bool>,
    /// A surface (STL, OBJ, PLY, OFF, GLB) in the unit of the mesh, which is drawn in place of that of the
    /// mesh and follows it.
    pub embedded: Option<PathBuf>,
}

/// Bytes of the stress under contacts that a file gets without being asked, in double precision.
pub(crate) const STRESS_UNASKED: u64 = 64_000_000;

/// Nodes whose stress a file can show.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(untagged, expecting = "\"surface\", \"body\", or nodes like { group = \"root\" }")]
pub enum StressPlaces {
    /// Every node of the surface or of the body.
    Every(Fields),
    /// Chosen nodes.
    Chosen(Selection),
}

/// The mean strain of the surface between two points.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct GaugeEntry {
    /// Its name.
    pub(crate) name: String,
    /// Its middle \[m\].
    pub(crate) point: [f64; 3],
    /// Along what; normalised.
    pub(crate) direction: [f64; 3],
    /// Its length \[m\].
    pub(crate) length: f64,
}

/// Fields kept in the file.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Eq, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Fields {
    /// Every node.
    #[default]
    Body,
    /// Nodes of the surface.
    Surface,
}

/// Number type of the fields.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Eq, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Precision {
    /// 64 bits.
    #[default]
    F64,
    /// 32 bits.
    F32,
}

/// A displacement component at the node nearest to a point.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ProbeEntry {
    /// Its name.
    pub name: String,
    /// Its place; the nearest node is taken.
    pub point: [f64; 3],
    /// Along what; normalised.
    pub direction: [f64; 3],
}

/// A quantity that stays free until the file is used, within a range.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ParameterEntry {
    /// Its name.
    pub name: String,
    /// The quantity it changes.
    pub kind: ParameterKind,
    /// Region by name or tag (stiffness, density and loss factor); `"*"`: all regions alike.
    #[serde(default = "every_region")]
    pub region: String,
    /// Springs and foundations (stiffness), point masses (mass) or dashpots and foundations (damping) of this
    /// name, in place of a region.
    pub attachment: Option<String>,
    /// Smallest and largest value: a factor on the problem's value (stiffness, density), else the value
    /// itself.
    pub range: [f64; 2],
    /// Spacing of values over the range.
    #[serde(default)]
    pub scale: ParameterScale,
}

/// Quantity changed by a parameter.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ParameterKind {
    /// Factor on the stiffness of a region.
    Stiffness,
    /// Factor on the density of a region.
    Density,
    /// Factor on mass and inertia of attached masses.
    Mass,
    /// Factor on the damping of dashpots and foundations.
    Damping,
    /// Loss factor of the material of a region.
    LossFactor,
    /// Rayleigh α \[1/s\].
    Alpha,
    /// Rayleigh β \[s\].
    Beta,
    /// Δt \[s\].
    TimeStep,
}

impl ParameterEntry {
    /// True of a quantity of a region or of attachments, which turns the modes.
    pub fn is_local(&self) -> bool {
        use ParameterKind as K;
        let of_parts = matches!(self.kind, K::Mass | K::Damping | K::LossFactor);
        self.region != "*" || self.attachment.is_some() || of_parts
    }
}

impl ParameterKind {
    /// True of a factor on the stiffness.
    pub(crate) fn is_stiffness(self) -> bool {
        self == Self::Stiffness
    }

    /// True of a damping, which may be none.
    pub(super) fn may_vanish(self) -> bool {
        matches!(self, Self::Alpha | Self::Beta | Self::LossFactor | Self::Damping)
    }

    /// True of a factor on the mass.
    pub(crate) fn is_mass(self) -> bool {
        matches!(self, Self::Density | Self::Mass)
    }

    /// As the problem file spells it.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Stiffness => "stiffness",
            Self::Density => "density",
            Self::Mass => "mass",
            Self::Damping => "damping",
            Self::LossFactor => "loss-factor",
            Self::Alpha => "alpha",
            Self::Beta => "beta",
            Self::TimeStep => "time-step",
        }
    }
}

/// Spacing of values over a range.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Eq, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum ParameterScale {
    /// Evenly.
    #[default]
    Linear,
    /// Evenly in the logarithm.
    Log,
}
