//! Options of large displacements.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Law of the body's motion.
#[derive(Clone, Copy, Debug, Default, Deserialize, Serialize, PartialEq, Eq, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ModelKind {
    /// Small displacements: forces are linear in them.
    #[default]
    Linear,
    /// Large displacements and rotations: St. Venant–Kirchhoff, a linear law between Green's strain and its
    /// stress (docs/explanation/large-displacements.md).
    LargeDisplacement,
}

/// Options of large displacements.
#[derive(Clone, Debug, Default, Deserialize, Serialize, PartialEq, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LargeEntry {
    /// Largest displacement of the surface that the file is for \[m\]; absent: a fifth of the longest edge of
    /// the box around the body.
    pub displacement: Option<f64>,
    /// Strain rows beside one for each coordinate; absent: as many again.
    pub rows: Option<usize>,
    /// States that the strains are learnt from; absent: twice as many as there are products of coordinates.
    pub(crate) states: Option<usize>,
    /// Pushes at full order that certify the file, pulses and held ones in turn; absent: 2.
    pub(crate) pushes: Option<usize>,
}
