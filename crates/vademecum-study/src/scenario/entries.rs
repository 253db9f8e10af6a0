//! Entries of a scenario file.

use std::borrow::Cow;
use std::sync::Arc;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use vademecum_build::dynamics::LoadTable;
use vademecum_eval::Quantity;

use super::tables::Rows;

/// Loads over time, from rest.
#[derive(Clone, Debug, Default, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Scenario {
    /// Length \[s\].
    pub duration: f64,
    /// Forces at points of the loadable surface.
    #[serde(rename = "contact", default)]
    pub contacts: Vec<ContactEntry>,
    /// Load patterns of the file; once read, the motions of the base behind them.
    #[serde(rename = "pattern", default)]
    pub patterns: Vec<PatternUse>,
    /// Initial motion of a free body; if absent, only its elastic motion is played.
    pub free: Option<FreeEntry>,
    /// Motion of the base.
    #[serde(skip_serializing_if = "is_among_patterns")]
    pub base: Option<BaseEntry>,
    /// Output of `run`.
    #[serde(default)]
    pub output: OutputPlan,
}

/// Once a scenario is read, the motions of its base are patterns, and need not be written twice.
fn is_among_patterns(_: &Option<BaseEntry>) -> bool {
    true
}

/// Initial motion of a free body, and gravity.
#[derive(Clone, Copy, Debug, Default, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FreeEntry {
    /// Velocity of its centre \[m/s\].
    #[serde(default)]
    pub velocity: [f64; 3],
    /// Angular velocity \[rad/s\].
    #[serde(default)]
    pub(crate) spin: [f64; 3],
    /// Acceleration of gravity \[m/s²\].
    #[serde(default)]
    pub gravity: [f64; 3],
}

/// One force at one point, which may move, for a while.
#[derive(Clone, Debug, Default, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ContactEntry {
    /// Position; the nearest point of the loadable surface is taken. Absent if `path` is given.
    pub point: Option<[f64; 3]>,
    /// Position over time, instead of `point`: rows `time,x,y,z` from the start of the load on.
    pub path: Option<Rows>,
    /// Force \[N\]. Absent where a table has it.
    pub force: Option<[f64; 3]>,
    /// First instant \[s\].
    #[serde(default)]
    pub start: f64,
    /// First instant without the load \[s\]; absent: to the end.
    #[serde(default = "forever")]
    pub end: f64,
    /// Time to full force \[s\].
    #[serde(default)]
    pub ramp: f64,
    /// Rows `time,amplitude`, a factor on `force`, or `time,fx,fy,fz` from the start of the load on.
    pub table: Option<Rows>,
    /// A factor on `force`.
    pub sinusoid: Option<SinusoidEntry>,
    /// A factor on `force`.
    pub(crate) chirp: Option<ChirpEntry>,
    /// The path as it was read.
    #[serde(skip)]
    pub(super) places: Option<Arc<LoadTable>>,
    /// The table as it was read.
    #[serde(skip)]
    pub(super) rows: Option<Arc<LoadTable>>,
}

/// A motion of the base that was recorded.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BaseEntry {
    /// Rows `time,ax,ay,az` in m/s², or `time,ax,ay,az,wx,wy,wz,dwx,dwy,dwz` with angular velocities
    /// \[rad/s\] and angular accelerations \[rad/s²\], in the axes of the base.
    pub(crate) record: Rows,
    /// A factor on `ax`, `ay` and `az`.
    #[serde(default = "one")]
    pub(crate) amplitude: f64,
}

/// One load pattern for a while.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PatternUse {
    /// The pattern's name in the file.
    pub name: String,
    /// Factor on the pattern.
    #[serde(default = "one")]
    pub(crate) amplitude: f64,
    /// First instant \[s\].
    #[serde(default)]
    pub start: f64,
    /// First instant without the load \[s\]; absent: to the end.
    #[serde(default = "forever")]
    pub end: f64,
    /// Time to full force \[s\].
    #[serde(default)]
    pub ramp: f64,
    /// Rows `time,amplitude`, a factor on `amplitude`, from the start of the load on.
    pub table: Option<Rows>,
    /// A factor on `amplitude`.
    pub(crate) sinusoid: Option<SinusoidEntry>,
    /// A factor on `amplitude`.
    pub(crate) chirp: Option<ChirpEntry>,
    /// The table as it was read.
    #[serde(skip)]
    pub(super) rows: Option<Arc<LoadTable>>,
}

/// `mean + sin(2π f t + phase)`, with `t` from the start of the load.
#[derive(Clone, Copy, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SinusoidEntry {
    /// `f` \[Hz\].
    pub frequency: f64,
    /// Phase at the start \[rad\].
    #[serde(default)]
    pub phase: f64,
    /// Mean value.
    #[serde(default)]
    pub mean: f64,
}

/// A sinusoid whose frequency rises or falls linearly from the start of the load to its end.
#[derive(Clone, Copy, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct ChirpEntry {
    /// Frequency at the start \[Hz\].
    pub(crate) from: f64,
    /// Frequency at the end \[Hz\].
    pub(crate) to: f64,
    /// Phase at the start \[rad\].
    #[serde(default)]
    pub(crate) phase: f64,
}

/// Output of `run` and its interval.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct OutputPlan {
    /// Probe rows every so many steps.
    #[serde(default = "one_step")]
    pub(crate) probes_every: usize,
    /// Fields every so many steps; 0: none.
    #[serde(default)]
    pub fields_every: usize,
    /// `"body"` or `"surface"`.
    #[serde(default)]
    pub fields: FieldChoice,
    /// Named values beside those of the file.
    #[serde(rename = "probe", default)]
    pub probes: Vec<OutputProbe>,
    /// Named stresses.
    #[serde(rename = "stress", default)]
    pub(crate) stresses: Vec<StressEntry>,
    /// The stress of every point of the file every so many steps; 0: never.
    #[serde(default)]
    pub stress_every: usize,
    /// True: the displacement under each contact, three columns of the table of probes.
    #[serde(default)]
    pub contacts: bool,
    /// Scalars of the whole body, columns of the table of probes.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) quantities: Vec<Total>,
}

/// A component of the motion at a point.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct OutputProbe {
    /// Its name.
    pub name: String,
    /// Position.
    pub(crate) point: [f64; 3],
    /// Component; normalised.
    pub(crate) direction: [f64; 3],
    /// Quantity.
    #[serde(default)]
    pub(crate) quantity: ProbeQuantity,
    /// `"node"`: the nearest node that the file shows, `"surface"`: the nearest point of the loadable
    /// surface.
    #[serde(default)]
    pub(crate) at: ProbePlace,
}

/// Quantity of a probe.
#[derive(Clone, Copy, Debug, Default, Deserialize, Serialize, PartialEq, Eq, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(crate) enum ProbeQuantity {
    /// Displacement \[m\].
    #[default]
    Displacement,
    /// Velocity \[m/s\].
    Velocity,
    /// Mean acceleration of the step that ends \[m/s²\].
    Acceleration,
}

/// Place of a probe.
#[derive(Clone, Copy, Debug, Default, Deserialize, Serialize, PartialEq, Eq, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(crate) enum ProbePlace {
    /// The nearest node.
    #[default]
    Node,
    /// The nearest point of the loadable surface.
    Surface,
}

/// A scalar of the whole body, one of [`Quantity::totals`], by its name there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Total(pub Quantity);

impl<'de> Deserialize<'de> for Total {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let name = String::deserialize(deserializer)?;
        Quantity::totals().find(|quantity| quantity.name() == name).map(Self).ok_or_else(|| {
            let known: Vec<_> = Quantity::totals().map(|known| format!("`{}`", known.name())).collect();
            D::Error::custom(format!("unknown variant `{name}`, expected one of {}", known.join(", ")))
        })
    }
}

impl Serialize for Total {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.0.name())
    }
}

impl JsonSchema for Total {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> Cow<'static, str> {
        "Total".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let names: Vec<_> = Quantity::totals().map(Quantity::name).collect();
        json_schema!({ "type": "string", "enum": names })
    }
}

/// A stress at the node nearest to a point, of those whose stress the file has.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct StressEntry {
    /// Its name.
    pub(crate) name: String,
    /// Position.
    pub(crate) point: [f64; 3],
    /// Quantity of the stress.
    #[serde(default)]
    pub(crate) quantity: StressQuantity,
}

/// A number that is taken of a stress \[Pa\].
#[derive(Clone, Copy, Debug, Default, Deserialize, Serialize, PartialEq, Eq, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum StressQuantity {
    /// Von Mises' equivalent stress.
    #[default]
    VonMises,
    /// The principal stress of the largest size, with its sign.
    SignedMaximum,
    /// The largest principal stress.
    First,
    /// The middle principal stress.
    Second,
    /// The smallest principal stress.
    Third,
    /// A component.
    Xx,
    /// A component.
    Yy,
    /// A component.
    Zz,
    /// A component.
    Xy,
    /// A component.
    Yz,
    /// A component.
    Zx,
}

/// Nodes of a field.
#[derive(Clone, Copy, Debug, Default, Deserialize, Serialize, PartialEq, Eq, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum FieldChoice {
    /// Nodes and triangles of the surface.
    #[default]
    Surface,
    /// Every node.
    Body,
}

impl Default for OutputPlan {
    fn default() -> Self {
        Self {
            probes_every: 1,
            fields_every: 0,
            fields: FieldChoice::default(),
            probes: vec![],
            stresses: vec![],
            stress_every: 0,
            contacts: false,
            quantities: vec![],
        }
    }
}

fn one() -> f64 {
    1.0
}

fn one_step() -> usize {
    1
}

/// The end of a load that says none.
pub(super) fn forever() -> f64 {
    f64::MAX
}
