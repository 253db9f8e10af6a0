//! The problem file: what a build is asked for (normative: `formats/problem-1.md`).
//!
//! A problem is read whole or refused: unknown keys, missing keys and impossible values are errors that name
//! the file, the line or key, what was found and what was expected. Nothing here touches the mesh; names in
//! the mesh are resolved when the model is built.

mod chapter;
mod check;

pub use chapter::{ChapterEntry, Projection, Repair, Representation};

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use vademecum_format::policy;

use crate::dynamics::{Damping, DampingError, Rayleigh, SchemeError, SchemeKind};
use crate::input::toml_file::{self, TomlError};
use crate::mesh::Order;
use crate::mesh::select::Selection;

/// A problem file that cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum ProblemError {
    /// The file cannot be read, is not a problem, or has a value that no problem can have.
    #[error(transparent)]
    Toml(#[from] TomlError),
    /// A time scheme with a parameter outside its range.
    #[error("{path}: `time.scheme`")]
    Scheme {
        /// The file and line.
        path: String,
        /// The parameter.
        source: SchemeError,
    },
    /// Damping that would feed energy to some mode.
    #[error("{path}: `damping`")]
    Damping {
        /// The file and line.
        path: String,
        /// The coefficients.
        source: DampingError,
    },
}

/// What a build is asked for.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Problem {
    /// A line for people.
    #[serde(default)]
    pub title: String,
    /// The unit system all numbers are in; kept in the file, not interpreted.
    #[serde(default = "si_units")]
    pub units: String,
    /// The form of the stage maps in the file.
    #[serde(default)]
    pub representation: Representation,
    /// Options of the canonical one.
    pub canonical: Option<ChapterEntry>,
    /// Where the mesh comes from.
    pub mesh: MeshSource,
    /// Materials; the first that names a region wins, `"*"` stands for all. None beside matrices, which have
    /// them in them.
    #[serde(rename = "material", default)]
    pub materials: Vec<MaterialEntry>,
    /// Rayleigh damping.
    #[serde(default)]
    pub damping: DampingEntry,
    /// Supports; none beside matrices, whose rows are the free dofs.
    #[serde(rename = "support", default)]
    pub supports: Vec<SupportEntry>,
    /// Where and how the body can be loaded.
    pub load: LoadEntry,
    /// Scheme and step.
    pub time: TimeEntry,
    /// How the snapshots are made.
    #[serde(default)]
    pub snapshots: SnapshotPlan,
    /// The basis.
    #[serde(default)]
    pub basis: BasisEntry,
    /// What the build must reach.
    #[serde(default)]
    pub tolerance: Tolerances,
    /// What the file can show.
    #[serde(default)]
    pub output: OutputEntry,
    /// What stays free until the file is used.
    #[serde(rename = "parameter", default)]
    pub parameters: Vec<ParameterEntry>,
    /// The text this problem was read from.
    #[serde(skip)]
    pub text: String,
    /// The folder that relative paths start from.
    #[serde(skip)]
    pub folder: PathBuf,
    /// The name used in messages.
    #[serde(skip)]
    pub path: String,
}

fn si_units() -> String {
    "SI: m, kg, s, N, Pa".into()
}

/// Where the mesh comes from: exactly one of `file`, `tables`, `block` and `matrices`.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MeshSource {
    /// A mesh file.
    pub file: Option<PathBuf>,
    /// Two plain tables.
    pub tables: Option<TablesSource>,
    /// A generated block.
    pub block: Option<BlockSource>,
    /// The matrices of another program instead of a mesh.
    pub matrices: Option<MatricesSource>,
    /// Factor on all coordinates.
    #[serde(default = "one")]
    pub scale: f64,
    /// Regions cut out of the mesh here, on top of those its file has; later ones win.
    #[serde(rename = "region", default)]
    pub regions: Vec<RegionEntry>,
}

/// A region cut out of the mesh: the elements all of whose corners are selected.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RegionEntry {
    /// Its name.
    pub name: String,
    /// The nodes.
    pub on: Selection,
}

/// Two plain tables, as the chapter's program reads them.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TablesSource {
    /// One node per line: x y z.
    pub coordinates: PathBuf,
    /// One element per line: its nodes.
    pub connectivity: PathBuf,
}

/// A model that another program has assembled: its matrices over the free dofs, and what their rows are.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MatricesSource {
    /// Mass, a Matrix Market file.
    pub mass: PathBuf,
    /// Stiffness, the same.
    pub stiffness: PathBuf,
    /// What each row is: `row,node,component,x,y,z`.
    pub dofs: PathBuf,
    /// All nodes in order, those held in every component among them: `node,x,y,z`; absent: the nodes of
    /// `dofs`.
    pub nodes: Option<PathBuf>,
    /// Triangles of the surface by node number, outward; absent: no surface, and forces act on nodes.
    pub triangles: Option<PathBuf>,
}

/// A block `[0, lengths]` cut into cells of six tetrahedra.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BlockSource {
    /// Edge lengths.
    pub lengths: [f64; 3],
    /// Cells along each edge.
    pub divisions: [usize; 3],
    /// Order of the elements.
    #[serde(default)]
    pub order: OrderEntry,
}

/// Order of generated elements.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "lowercase")]
pub enum OrderEntry {
    /// 4-node tetrahedra.
    Linear,
    /// 10-node tetrahedra.
    #[default]
    Quadratic,
}

impl From<OrderEntry> for Order {
    fn from(entry: OrderEntry) -> Self {
        match entry {
            OrderEntry::Linear => Order::Linear,
            OrderEntry::Quadratic => Order::Quadratic,
        }
    }
}

/// An isotropic linear elastic material.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MaterialEntry {
    /// Region by name or tag; `"*"` for every region not named elsewhere.
    #[serde(default = "every_region")]
    pub region: String,
    /// Young's modulus, > 0.
    pub young: f64,
    /// Poisson's ratio, in (−1, ½).
    pub poisson: f64,
    /// Density, > 0.
    pub density: f64,
}

fn every_region() -> String {
    "*".into()
}

/// Rayleigh damping `C = α M + β K`: none, by coefficients, or by two (ratio, frequency) pairs.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DampingEntry {
    /// α \[1/s\].
    pub alpha: Option<f64>,
    /// β \[s\].
    pub beta: Option<f64>,
    /// Two pairs `[ratio, frequency in Hz]`.
    pub ratios: Option<[[f64; 2]; 2]>,
}

impl DampingEntry {
    /// As the dynamics take it.
    pub fn damping(&self) -> Damping {
        match (self.ratios, self.alpha, self.beta) {
            (Some(pairs), _, _) => Damping::Ratios(pairs.map(|[ratio, frequency]| (ratio, frequency))),
            (None, None, None) => Damping::None,
            (None, alpha, beta) => {
                Damping::Rayleigh(Rayleigh { alpha: alpha.unwrap_or(0.0), beta: beta.unwrap_or(0.0) })
            }
        }
    }
}

/// Displacement components held at zero.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SupportEntry {
    /// The nodes held.
    pub on: Selection,
    /// The components held.
    #[serde(default = "all_components")]
    pub components: Vec<Component>,
}

fn all_components() -> Vec<Component> {
    vec![Component::X, Component::Y, Component::Z]
}

/// One component of a displacement.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "lowercase")]
#[allow(missing_docs)]
pub enum Component {
    X,
    Y,
    Z,
}

/// Where and how the body can be loaded.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LoadEntry {
    /// Contacts may touch the surface facets all of whose corners are selected; absent: the whole free
    /// surface.
    pub surface: Option<Selection>,
    /// Distributed loads with an amplitude each.
    #[serde(rename = "pattern", default)]
    pub patterns: Vec<PatternEntry>,
}

/// One distributed load: exactly one of `acceleration`, `traction` and `pressure`.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PatternEntry {
    /// Its name.
    pub name: String,
    /// Facets it acts on (traction, pressure): those all of whose corners are selected.
    pub on: Option<Selection>,
    /// Body force per mass, such as gravity.
    pub acceleration: Option<[f64; 3]>,
    /// Force per area.
    pub traction: Option<[f64; 3]>,
    /// Force per area against the outward normal.
    pub pressure: Option<f64>,
}

/// Scheme and step.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TimeEntry {
    /// The scheme.
    #[serde(default)]
    pub scheme: SchemeKind,
    /// Δt \[s\].
    pub step: f64,
}

/// How the snapshots are made, or where they are read.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SnapshotPlan {
    /// Load positions, spread over the loadable surface.
    #[serde(default = "default_positions")]
    pub positions: usize,
    /// Directions of the force at each position.
    #[serde(default = "the_axes")]
    pub directions: Vec<[f64; 3]>,
    /// How long each force is held \[s\]; absent: half the first period.
    pub hold: Option<f64>,
    /// Length of each run \[s\]; absent: three first periods.
    pub duration: Option<f64>,
    /// A snapshot is kept every `stride` steps; absent: about 60 snapshots per run.
    pub stride: Option<usize>,
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
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BasisEntry {
    /// Kind of basis.
    #[serde(default)]
    pub kind: BasisKind,
    /// Number of modes; absent: by `energy`, else 8.
    pub modes: Option<usize>,
    /// Fraction of the snapshot energy to keep, in (0, 1).
    pub energy: Option<f64>,
    /// POD vectors per kept Ritz vector.
    #[serde(default = "default_oversampling")]
    pub oversampling: usize,
    /// Inner product of the POD.
    #[serde(default)]
    pub inner_product: InnerProduct,
}

fn default_oversampling() -> usize {
    4
}

impl Default for BasisEntry {
    fn default() -> Self {
        Self {
            kind: BasisKind::default(),
            modes: None,
            energy: None,
            oversampling: default_oversampling(),
            inner_product: InnerProduct::default(),
        }
    }
}

/// Kind of basis.
#[derive(Clone, Copy, Debug, Default, Deserialize, Serialize, PartialEq, Eq)]
#[serde(rename_all = "lowercase")]
pub enum BasisKind {
    /// Ritz vectors of an oversampled POD and of its static response (docs/theory/4-basis.md).
    #[default]
    Ritz,
    /// Plain POD, as the chapter has it.
    Pod,
    /// The lowest natural modes.
    Modes,
}

/// Inner product in which the POD is best.
#[derive(Clone, Copy, Debug, Default, Deserialize, Serialize, PartialEq, Eq)]
#[serde(rename_all = "lowercase")]
pub enum InnerProduct {
    /// `M`: kinetic energy.
    #[default]
    Mass,
    /// `K`: strain energy.
    Stiffness,
    /// `I`: the chapter's.
    Identity,
}

/// What the build must reach; a build that misses it writes nothing unless told to.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Tolerances {
    /// Largest trajectory error ÷ projection floor.
    #[serde(default = "default_ratio")]
    pub floor_ratio: f64,
    /// Added to the allowed error: what separation and rounding may cost.
    #[serde(default = "default_absolute")]
    pub absolute: f64,
    /// Steps of the certificate's unseen runs.
    #[serde(default = "default_steps")]
    pub steps: usize,
    /// Largest relative error of a stage map over the parameters, root mean square; ten times that at the
    /// worst point.
    #[serde(default = "default_map")]
    pub map: f64,
    /// Most terms of the separated solution.
    #[serde(default = "default_max_terms")]
    pub max_terms: usize,
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

fn default_steps() -> usize {
    500
}

impl Default for Tolerances {
    fn default() -> Self {
        Self {
            floor_ratio: default_ratio(),
            absolute: default_absolute(),
            steps: default_steps(),
            map: default_map(),
            max_terms: default_max_terms(),
        }
    }
}

/// What the file can show.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OutputEntry {
    /// Fields kept.
    #[serde(default)]
    pub fields: Fields,
    /// Number type of the fields.
    #[serde(default)]
    pub precision: Precision,
    /// Named values read at every step.
    #[serde(rename = "probe", default)]
    pub probes: Vec<ProbeEntry>,
}

/// Fields kept in the file.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "lowercase")]
pub enum Fields {
    /// Every node.
    #[default]
    Body,
    /// Nodes of the surface.
    Surface,
}

/// Number type of the fields.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "lowercase")]
pub enum Precision {
    /// 64 bits.
    #[default]
    F64,
    /// 32 bits.
    F32,
}

/// A displacement component at the node nearest to a point.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ProbeEntry {
    /// Its name.
    pub name: String,
    /// Where; the nearest node is taken.
    pub point: [f64; 3],
    /// Along what; normalised.
    pub direction: [f64; 3],
}

/// A quantity that stays free until the file is used, within a range.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ParameterEntry {
    /// Its name.
    pub name: String,
    /// What it changes.
    pub kind: ParameterKind,
    /// Region by name or tag (stiffness and density); `"*"`: all regions alike.
    #[serde(default = "every_region")]
    pub region: String,
    /// Smallest and largest value: a factor on the problem's value (stiffness, density), else the value
    /// itself.
    pub range: [f64; 2],
    /// How values are spread over the range.
    #[serde(default)]
    pub scale: ParameterScale,
}

/// What a parameter changes.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "kebab-case")]
pub enum ParameterKind {
    /// Factor on the stiffness of a region.
    Stiffness,
    /// Factor on the density of a region.
    Density,
    /// Rayleigh α \[1/s\].
    Alpha,
    /// Rayleigh β \[s\].
    Beta,
    /// Δt \[s\].
    TimeStep,
}

/// How values are spread over a range.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "lowercase")]
pub enum ParameterScale {
    /// Evenly.
    #[default]
    Linear,
    /// Evenly in the logarithm.
    Log,
}

fn one() -> f64 {
    1.0
}

impl Problem {
    /// Reads and checks a problem file.
    pub fn read(path: &Path) -> Result<Self, ProblemError> {
        let folder = path.parent().unwrap_or(Path::new("")).to_path_buf();
        Self::parse(&toml_file::read(path)?, &path.display().to_string(), folder)
    }

    /// Reads and checks a problem from its text; relative paths start from `folder`, messages name `path`.
    pub fn parse(text: &str, path: &str, folder: PathBuf) -> Result<Self, ProblemError> {
        let mut problem: Problem = toml_file::parse(text, path)?;
        problem.text = text.into();
        problem.folder = folder;
        problem.path = path.into();
        problem.check()?;
        Ok(problem)
    }

    /// A path of the problem file, from where the program stands.
    pub fn resolve(&self, path: &Path) -> PathBuf {
        self.folder.join(path)
    }

    /// `file:line` of a key, for messages.
    pub fn place(&self, key: &str) -> String {
        toml_file::place(&self.path, &self.text, key)
    }
}

impl Problem {
    /// Options of the chapter's representation, if it is asked for.
    pub fn chapter(&self) -> Option<ChapterEntry> {
        let asked = self.representation == Representation::Canonical;
        asked.then(|| self.canonical.clone().unwrap_or_default())
    }
}

#[cfg(test)]
mod tests;
