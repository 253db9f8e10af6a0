//! The problem file: what a build is asked for (normative: `formats/problem-1.md`).
//!
//! A problem is read whole or refused: unknown keys, missing keys and impossible values are errors that name
//! the file, the line or key, what was found and what was expected. Nothing here touches the mesh; names in
//! the mesh are resolved when the model is built.

mod attachments;
mod body;
mod bounds;
mod chapter;
mod check;
mod check_attachments;
mod check_heat;
mod check_large;
mod check_patch;
mod check_ports;
mod check_prestress;
mod large;
mod plan;
mod ports;
mod prestress;
mod ranges;

pub use attachments::{
    CouplingEntry, CouplingKind, DashpotEntry, EquationEntry, EquationNode, EquationTerm, FoundationEntry,
    Motion, PointMassEntry, ReferencePointEntry, SpringEntry, TieEntry,
};
pub use body::{
    BaseEntry, BlockSource, Component, DampingEntry, ExpansionEntry, LoadEntry, MaterialEntry,
    MatricesSource, MeshSource, NodalForce, OrderEntry, OrthotropicEntry, PatternEntry, RaisedOrder,
    RegionEntry, SupportEntry, TablesSource,
};
pub(crate) use chapter::Representation;
pub use chapter::{ChapterEntry, Projection, Repair};
pub use check::OWN_COLUMNS;
pub(crate) use check::{CENTRIFUGAL, perpendicular};
pub use large::{LargeEntry, ModelKind};
pub use plan::{
    BasisEntry, BasisKind, Fields, OutputEntry, ParameterEntry, ParameterKind, ParameterScale, ProbeEntry,
    SnapshotPlan, StressPlaces, TimeEntry, Tolerances,
};
pub(crate) use plan::{GaugeEntry, InnerProduct, Precision, STRESS_UNASKED};
pub use ports::{PortEntry, PortKind};
pub use prestress::PrestressEntry;
pub use ranges::{problem_schema, range_table};

use std::path::{Path, PathBuf};

use schemars::JsonSchema;
use serde::Deserialize;

use crate::dynamics::{DampingError, SchemeError, SchemeKind};
use crate::input::toml_file::{self, TomlError};
use crate::limits::MAX_TEXT;
use crate::mesh;

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

/// A problem: the input of a build.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Problem {
    /// A line for people.
    #[serde(default)]
    pub title: String,
    /// The unit system all numbers are in; kept in the file, not interpreted.
    #[serde(default = "si_units")]
    pub units: String,
    /// Law of the body's motion.
    #[serde(default)]
    pub model: ModelKind,
    /// Options of large displacements.
    pub large: Option<LargeEntry>,
    /// The form of the stage maps in the file.
    #[serde(default)]
    pub(crate) representation: Option<Representation>,
    /// Options of the canonical one.
    pub canonical: Option<ChapterEntry>,
    /// Source of the mesh.
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
    /// Reference points, which couplings join to the body.
    #[serde(rename = "reference_point", default)]
    pub reference_points: Vec<ReferencePointEntry>,
    /// Couplings of surfaces to reference points.
    #[serde(rename = "coupling", default)]
    pub couplings: Vec<CouplingEntry>,
    /// Ties of surfaces.
    #[serde(rename = "tie", default)]
    pub ties: Vec<TieEntry>,
    /// Elastic grounds under facets.
    #[serde(rename = "foundation", default)]
    pub foundations: Vec<FoundationEntry>,
    /// Linear equations between displacements.
    #[serde(rename = "equation", default)]
    pub equations: Vec<EquationEntry>,
    /// Masses at reference points.
    #[serde(rename = "point_mass", default)]
    pub point_masses: Vec<PointMassEntry>,
    /// Springs at reference points.
    #[serde(rename = "spring", default)]
    pub springs: Vec<SpringEntry>,
    /// Dashpots at reference points.
    #[serde(rename = "dashpot", default)]
    pub dashpots: Vec<DashpotEntry>,
    /// Ports, by which an assembly joins the body to others.
    #[serde(rename = "port", default)]
    pub ports: Vec<PortEntry>,
    /// Static load case about which the body moves.
    pub prestress: Option<PrestressEntry>,
    /// Base of the supports.
    #[serde(default)]
    pub base: BaseEntry,
    /// Places and patterns of loads.
    #[serde(default)]
    pub load: LoadEntry,
    /// Scheme and step.
    #[serde(default)]
    pub time: TimeEntry,
    /// Plan of the snapshots.
    #[serde(default)]
    pub snapshots: SnapshotPlan,
    /// The basis.
    #[serde(default)]
    pub basis: BasisEntry,
    /// Tolerances of the build.
    #[serde(default)]
    pub tolerance: Tolerances,
    /// Outputs of the file.
    #[serde(default)]
    pub output: OutputEntry,
    /// Parameters that stay free until the file is used.
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
    /// True of a problem that was no text, whose keys stand in no line.
    #[serde(skip)]
    is_table: bool,
}

fn si_units() -> String {
    "SI: m, kg, s, N, Pa".into()
}

/// Keys that name files, as [`Problem::files`] reads them; those of snapshots may be lists.
pub const FILE_KEYS: [&str; 10] = [
    "mesh.file",
    "mesh.tables.coordinates",
    "mesh.tables.connectivity",
    "mesh.matrices.mass",
    "mesh.matrices.stiffness",
    "mesh.matrices.dofs",
    "mesh.matrices.nodes",
    "mesh.matrices.triangles",
    "snapshots.npy",
    "snapshots.vtu",
];

impl Problem {
    /// Reads and checks a problem file.
    pub fn read(path: &Path) -> Result<Self, ProblemError> {
        let folder = path.parent().unwrap_or(Path::new("")).to_path_buf();
        Self::parse(&toml_file::read_at_most(path, MAX_TEXT)?, &path.display().to_string(), folder)
    }

    /// Reads and checks a problem from its text; relative paths start from `folder`, messages name `path`.
    pub fn parse(text: &str, path: &str, folder: PathBuf) -> Result<Self, ProblemError> {
        toml_file::check_length(text.len(), MAX_TEXT, path)?;
        let mut problem: Problem = toml_file::parse(text, path)?;
        problem.text = text.into();
        problem.folder = folder;
        problem.path = path.into();
        problem.check()?;
        Ok(problem)
    }

    /// Checks a problem that another program has as a table; relative paths start from `folder`, messages
    /// name `path` and the keys.
    pub fn of_table(table: toml::Table, path: &str, folder: PathBuf) -> Result<Self, ProblemError> {
        let text = table.to_string();
        toml_file::check_length(text.len(), MAX_TEXT, path)?;
        let problem: Problem = toml_file::of_table(table, path)?;
        let problem = Problem { text, folder, path: path.into(), is_table: true, ..problem };
        problem.check()?;
        Ok(problem)
    }

    /// A path of the problem file, from where the program stands.
    pub fn resolve(&self, path: &Path) -> PathBuf {
        self.folder.join(path)
    }

    /// Every file that the problem names and a build of it reads, from where the program stands; of a mesh
    /// also the files that it is made of.
    pub fn files(&self) -> Vec<PathBuf> {
        let mesh = self.mesh.file.iter().flat_map(|file| mesh::sources(&self.resolve(file)));
        let tables = self.mesh.tables.iter().flat_map(|t| [&t.coordinates, &t.connectivity]);
        let matrices =
            self.mesh.matrices.iter().flat_map(|m| {
                [&m.mass, &m.stiffness, &m.dofs].into_iter().chain(&m.nodes).chain(&m.triangles)
            });
        let snapshots = self.snapshots.npy.iter().chain(self.snapshots.vtu.iter().flatten());
        let named = tables.chain(matrices).chain(snapshots).chain(&self.output.embedded);
        let named = named.map(|file| self.resolve(file));
        mesh.chain(named).collect()
    }

    /// `file:line` of a key, for messages.
    pub fn place(&self, key: &str) -> String {
        if self.is_table { self.path.clone() } else { toml_file::place(&self.path, &self.text, key) }
    }
}

impl Problem {
    /// The time scheme: the one asked for, or else exact steps where modes move apart, and Bathe's where the
    /// file needs stages.
    pub fn scheme(&self) -> SchemeKind {
        let stages = self.representation == Some(Representation::Canonical)
            || self.basis.kind == Some(BasisKind::Pod)
            || (!self.is_parametric() && self.parameters.iter().any(ParameterEntry::is_local));
        let usual = if stages { SchemeKind::Bathe {} } else { SchemeKind::Exact {} };
        self.time.scheme.unwrap_or(usual)
    }

    /// The kind of basis: the one asked for, or else natural modes for exact steps, if nothing of the
    /// snapshots is asked for, and Ritz vectors of snapshots otherwise.
    pub(crate) fn basis_kind(&self) -> BasisKind {
        let imported = self.snapshots.npy.is_some() || self.snapshots.vtu.is_some();
        let modes = self.scheme() == (SchemeKind::Exact {}) && !imported && self.basis.energy.is_none();
        self.basis.kind.unwrap_or(if modes { BasisKind::Modes } else { BasisKind::Ritz })
    }

    /// True if a quantity of a region or of attachments is live.
    pub(crate) fn has_local_parameters(&self) -> bool {
        self.parameters.iter().any(ParameterEntry::is_local)
    }

    /// True if matrices of each region are needed.
    pub(crate) fn splits_regions(&self) -> bool {
        self.has_local_parameters() || self.has_loss()
    }

    /// True if a material has a loss factor, be it zero, or one is live.
    pub fn has_loss(&self) -> bool {
        let live = |entry: &ParameterEntry| entry.kind == ParameterKind::LossFactor;
        self.materials.iter().any(|entry| entry.loss_factor.is_some()) || self.parameters.iter().any(live)
    }

    /// True for live regions by a parametric reduced-order model: unless a key asks for what it has not.
    pub fn is_parametric(&self) -> bool {
        self.has_local_parameters() && self.separated_by().is_none()
    }

    /// The key by which the time step is separated over live regions, none where a parametric reduced-order
    /// model is built.
    pub(crate) fn separated_by(&self) -> Option<&'static str> {
        match self.representation {
            Some(Representation::Parametric) => None,
            Some(Representation::Block) => Some("`representation = \"separated\"`"),
            Some(Representation::Canonical) => Some("`representation = \"chapter\"`"),
            None => self.beside_parametric(),
        }
    }

    /// The first key that a parametric reduced-order model has no answer to: stages, or a basis of snapshots.
    pub(crate) fn beside_parametric(&self) -> Option<&'static str> {
        let keys = [
            ("`time.scheme`", self.time.scheme.is_some_and(|scheme| scheme != SchemeKind::Exact {})),
            ("`basis.kind`", self.basis.kind.is_some_and(|kind| kind != BasisKind::Modes)),
            ("`basis.energy`", self.basis.energy.is_some()),
            ("`snapshots`", self.snapshots.npy.is_some() || self.snapshots.vtu.is_some()),
        ];
        keys.iter().find(|(_, given)| *given).map(|(key, _)| *key)
    }

    /// True for a free body: a problem with a mesh that nothing holds.
    pub fn is_free(&self) -> bool {
        self.supports.is_empty() && self.mesh.matrices.is_none() && !self.is_held_by_attachments()
    }

    /// Options of the chapter's representation, if it is asked for.
    pub fn chapter(&self) -> Option<ChapterEntry> {
        let asked = self.representation == Some(Representation::Canonical);
        asked.then(|| self.canonical.clone().unwrap_or_default())
    }
}

#[cfg(test)]
mod tests;
