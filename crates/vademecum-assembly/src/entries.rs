//! Entries of an assembly file for a world: bodies that touch, and joints that turn far.

use std::path::PathBuf;

use schemars::JsonSchema;
use serde::Deserialize;

/// Largest size of a coordinate, a stiffness or a time.
pub(crate) const LARGEST: f64 = 1e30;

/// Most contacts for which there is room.
const MAX_CONTACTS: usize = 65_536;

/// Most sweeps of a step.
const MAX_SWEEPS: usize = 1_000_000;

/// A key, what was found there, and what was expected.
pub(crate) type Refused = (&'static str, String, &'static str);

/// A world: bodies that move, touch and turn in space.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WorldEntry {
    /// Time to march \[s\].
    pub time: f64,
    /// Step \[s\]; absent: that of the file, or else the smallest step of the parts.
    pub step: Option<f64>,
    /// Acceleration of gravity \[m/s²\], of free parts and rigid bodies.
    #[serde(default)]
    pub gravity: [f64; 3],
    /// Distance up to which nodes and triangles are paired \[m\]; absent: a fiftieth of the smallest part.
    pub reach: Option<f64>,
    /// Largest change of a displacement in the last sweep \[m\]; absent: 1e-10 of the smallest part.
    pub tolerance: Option<f64>,
    /// Most sweeps of a step.
    #[serde(default = "sweeps")]
    pub sweeps: usize,
    /// Contacts for which there is room.
    #[serde(default = "contacts")]
    pub contacts: usize,
}

fn sweeps() -> usize {
    200
}

fn contacts() -> usize {
    256
}

impl WorldEntry {
    /// The first value that no world can have.
    pub(crate) fn fault(&self) -> Option<Refused> {
        let time = |time: f64| time > 0.0 && time <= LARGEST;
        let length = |length: Option<f64>| length.is_none_or(|length| (0.0..=LARGEST).contains(&length));
        let seconds = "a time in seconds above 0";
        let metres = "a length of 0 or more";
        let finite = self.gravity.iter().all(|x| x.abs() <= LARGEST);
        let found = |number: Option<f64>| number.unwrap_or_default().to_string();
        first_of([
            (time(self.time), ("time", self.time.to_string(), seconds)),
            (self.step.is_none_or(time), ("step", found(self.step), seconds)),
            (finite, ("gravity", listed(&self.gravity), "finite numbers")),
            (length(self.reach), ("reach", found(self.reach), metres)),
            (length(self.tolerance), ("tolerance", found(self.tolerance), metres)),
            ((1..=MAX_SWEEPS).contains(&self.sweeps), ("sweeps", self.sweeps.to_string(), "1 to 1000000")),
            (
                (1..=MAX_CONTACTS).contains(&self.contacts),
                ("contacts", self.contacts.to_string(), "1 to 65536"),
            ),
        ])
    }
}

/// Two parts that may touch.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ContactEntry {
    /// Names of the two parts; with `*` at its end a name means every part whose name begins so.
    pub between: [String; 2],
    /// Coefficient of Coulomb's friction.
    #[serde(default)]
    pub friction: f64,
    /// Restitution of an impact that is shorter than a step.
    #[serde(default = "one")]
    pub restitution: f64,
    /// Parts whose nodes are held off the surface of the other.
    #[serde(default)]
    pub nodes: NodesEntry,
    /// Number of its `[[contact]]`.
    #[serde(skip)]
    pub entry: usize,
    /// True of a pair that was meant by the beginning of a name.
    #[serde(skip)]
    pub is_meant: bool,
}

fn one() -> f64 {
    1.0
}

/// Parts of a pair whose nodes are held off the surface of the other.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Eq, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum NodesEntry {
    /// Of both.
    #[default]
    Both,
    /// Of the first.
    First,
    /// Of the second.
    Second,
}

impl ContactEntry {
    /// The first value that no pair can have.
    pub(crate) fn fault(&self) -> Option<Refused> {
        let (friction, restitution) = (self.friction, self.restitution);
        first_of([
            (
                (0.0..=LARGEST).contains(&friction),
                ("friction", friction.to_string(), "a coefficient of 0 or more"),
            ),
            (
                (0.0..=1.0).contains(&restitution),
                ("restitution", restitution.to_string(), "a number from 0 to 1"),
            ),
        ])
    }
}

/// A rigid body in place of a vademecum file: a box or a closed surface.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RigidEntry {
    /// A box from the origin of its coordinates on.
    #[serde(rename = "box")]
    pub block: Option<BoxEntry>,
    /// A closed surface (STL, OBJ, PLY, OFF, GLB); a relative path starts from the folder of the assembly
    /// file.
    pub surface: Option<PathBuf>,
    /// Length \[m\] of the unit of the surface.
    #[serde(default = "one")]
    pub scale: f64,
    /// Density \[kg/m³\]; absent: the body stands still.
    pub density: Option<f64>,
}

/// A box.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BoxEntry {
    /// Lengths of its edges \[m\].
    pub lengths: [f64; 3],
}

impl RigidEntry {
    /// The first value that no rigid body can have.
    pub(crate) fn fault(&self) -> Option<Refused> {
        let above = |number: f64| number > 0.0 && number <= LARGEST;
        let both = if self.block.is_some() { "both" } else { "neither" };
        let one = self.block.is_some() != self.surface.is_some();
        let lengths = self.block.map_or([1.0; 3], |block| block.lengths);
        let sound = lengths.into_iter().all(above);
        let density = self.density.unwrap_or(1.0);
        first_of([
            (one, ("rigid", both.into(), "either `box` or `surface`")),
            (sound, ("rigid.box.lengths", listed(&lengths), "lengths above 0")),
            (above(self.scale), ("rigid.scale", self.scale.to_string(), "a length above 0")),
            (above(density), ("rigid.density", density.to_string(), "a density above 0")),
        ])
    }
}

/// A shake of a part: a sine over time.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ShakeEntry {
    /// Amplitude \[m\].
    pub amplitude: [f64; 3],
    /// Frequency \[Hz\].
    pub frequency: f64,
    /// Time over which it grows to its amplitude \[s\].
    #[serde(default)]
    pub ramp: f64,
}

impl ShakeEntry {
    /// The first value that no shake can have.
    pub(crate) fn fault(&self) -> Option<Refused> {
        let finite = self.amplitude.iter().all(|x| x.abs() <= LARGEST);
        first_of([
            (finite, ("shake.amplitude", listed(&self.amplitude), "finite numbers")),
            (
                (0.0..=LARGEST).contains(&self.frequency),
                ("shake.frequency", self.frequency.to_string(), "a frequency in hertz of 0 or more"),
            ),
            (
                (0.0..=LARGEST).contains(&self.ramp),
                ("shake.ramp", self.ramp.to_string(), "a time in seconds of 0 or more"),
            ),
        ])
    }
}

/// Columns of the table of a world: position of a place of a part in space.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct OutputEntry {
    /// Name of its columns; absent: that of the part.
    pub name: Option<String>,
    /// The part.
    pub part: String,
    /// A point in the coordinates of the part, for the nearest point of its surface at rest; absent: the
    /// centre of mass of a part that moves freely.
    pub point: Option<[f64; 3]>,
}

impl OutputEntry {
    /// Name of its columns.
    #[must_use]
    pub fn name(&self) -> &str {
        self.name.as_deref().unwrap_or(&self.part)
    }
}

/// The refusal of the first condition that does not hold.
fn first_of<const N: usize>(conditions: [(bool, Refused); N]) -> Option<Refused> {
    conditions.into_iter().find(|(holds, _)| !holds).map(|(_, refused)| refused)
}

/// Numbers as an assembly file has them.
pub(crate) fn listed(numbers: &[f64]) -> String {
    format!("[{}]", numbers.iter().map(f64::to_string).collect::<Vec<_>>().join(", "))
}
