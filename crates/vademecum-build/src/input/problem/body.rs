//! The body: mesh, materials, damping, supports, loads.

use schemars::JsonSchema;
use serde::Deserialize;
use std::path::PathBuf;

use crate::dynamics::{Damping, ModalRatios, Rayleigh};
use crate::fem::{Elasticity, HeatLaw, Stiffness};
use crate::mesh::select::Selection;
use crate::mesh::{Hexahedra, Order};

/// Source of the mesh: exactly one of `file`, `tables`, `block` and `matrices`.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
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
    /// Order to which linear elements are raised, by straight mid-side nodes; absent: as the mesh has them.
    pub order: Option<RaisedOrder>,
    /// Cells along the longest side of a surface file, which is filled with tetrahedra; absent: as many as
    /// its volume asks for.
    pub cells: Option<u32>,
    /// Parts that share no facet with the rest and have less than this share of the elements are left out.
    #[serde(default)]
    pub smallest_part: f64,
    /// Factor on all coordinates.
    #[serde(default = "one")]
    pub scale: f64,
    /// Regions cut out of the mesh here, on top of those its file has; later ones win.
    #[serde(rename = "region", default)]
    pub regions: Vec<RegionEntry>,
}

/// A region cut out of the mesh: the elements all of whose corners are selected.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RegionEntry {
    /// Its name.
    pub name: String,
    /// The nodes.
    pub on: Selection,
}

/// Two plain tables, as the chapter's program reads them.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TablesSource {
    /// One node per line: x y z.
    pub(crate) coordinates: PathBuf,
    /// One element per line: its nodes.
    pub(crate) connectivity: PathBuf,
}

/// A model that another program has assembled: its matrices over the free dofs, and what their rows are.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MatricesSource {
    /// Mass, a Matrix Market file.
    pub mass: PathBuf,
    /// Stiffness, the same.
    pub stiffness: PathBuf,
    /// Meaning of each row: `row,node,component,x,y,z`.
    pub dofs: PathBuf,
    /// All nodes in order, those held in every component among them: `node,x,y,z`; absent: the nodes of
    /// `dofs`.
    pub nodes: Option<PathBuf>,
    /// Triangles of the surface by node number, outward; absent: no surface, and forces act on nodes.
    pub(crate) triangles: Option<PathBuf>,
}

/// A block `[0, lengths]` cut into cells of six tetrahedra.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
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

/// Order to which elements are raised.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum RaisedOrder {
    /// 10-node tetrahedra.
    Quadratic,
}

/// Order of generated elements.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Eq, JsonSchema)]
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

/// A linear elastic material: isotropic by `young` and `poisson`, or by `orthotropic` or `stiffness`.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MaterialEntry {
    /// Region by name or tag; `"*"` for every region not named elsewhere.
    #[serde(default = "every_region")]
    pub region: String,
    /// Young's modulus, > 0.
    pub young: Option<f64>,
    /// Poisson's ratio, in (−1, ½).
    pub poisson: Option<f64>,
    /// Engineering constants along three axes.
    pub orthotropic: Option<OrthotropicEntry>,
    /// The upper triangle of the stiffness over the strains xx, yy, zz and the engineering shear strains xy,
    /// yz, zx, row by row.
    pub stiffness: Option<[f64; 21]>,
    /// Directions of the first and the second axis of the material, perpendicular; absent: those of space.
    pub axes: Option<[[f64; 3]; 2]>,
    /// Density, > 0.
    pub density: f64,
    /// Loss factor: twice the damping ratio of a mode that strains this material alone; absent: 0.
    pub loss_factor: Option<f64>,
    /// Coefficient of thermal expansion \[1/K\]; absent: a temperature does nothing to it.
    pub expansion: Option<ExpansionEntry>,
    /// Formulation of the region's hexahedra; absent: that of the mesh file, else incompatible modes in
    /// 8-node ones and full integration in larger ones.
    pub hexahedra: Option<Hexahedra>,
}

/// Coefficients of thermal expansion \[1/K\]: one, or those along the axes of the material.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, JsonSchema)]
#[serde(untagged, expecting = "a number, or three numbers along the axes of the material")]
pub enum ExpansionEntry {
    /// The same in every direction.
    One(f64),
    /// Along three axes.
    Along([f64; 3]),
}

impl ExpansionEntry {
    /// Along the three axes.
    pub fn along(self) -> [f64; 3] {
        match self {
            ExpansionEntry::One(one) => [one; 3],
            ExpansionEntry::Along(along) => along,
        }
    }
}

/// Engineering constants of an orthotropic material.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct OrthotropicEntry {
    /// Young's moduli along the three axes.
    pub young: [f64; 3],
    /// Poisson's ratios 12, 13, 23: the contraction along the second of two axes under a pull along the
    /// first.
    pub poisson: [f64; 3],
    /// Shear moduli 12, 13, 23.
    pub shear: [f64; 3],
}

impl MaterialEntry {
    /// Thermal strain of one kelvin along the axes of space; zeros where it does not expand.
    pub(crate) fn thermal_strain(&self) -> [[f64; 3]; 3] {
        let along = self.expansion.map_or([0.0; 3], ExpansionEntry::along);
        HeatLaw::along(along, self.axes)
    }

    /// Its elasticity; `None` where the constants are none, or those of no solid.
    pub fn elasticity(&self) -> Option<Elasticity> {
        if let (Some(young), Some(poisson)) = (self.young, self.poisson) {
            return Some(Elasticity::Isotropic { young, poisson });
        }
        let own = match (&self.orthotropic, &self.stiffness) {
            (Some(entry), _) => Stiffness::orthotropic(entry.young, entry.poisson, entry.shear)?,
            (None, Some(constants)) => Stiffness::from_upper(constants),
            (None, None) => return None,
        };
        let stiffness = self.axes.map_or(own, |axes| own.along(axes));
        stiffness.is_definite().then_some(Elasticity::Anisotropic(stiffness))
    }
}

pub(super) fn every_region() -> String {
    "*".into()
}

/// Rayleigh damping `C = α M + β K`: none, by coefficients, or by two (ratio, frequency) pairs. Beside it, a
/// damping ratio of each natural mode, or one of all.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DampingEntry {
    /// α \[1/s\].
    pub alpha: Option<f64>,
    /// β \[s\].
    pub beta: Option<f64>,
    /// Two pairs `[ratio, frequency in Hz]`.
    pub(crate) ratios: Option<[[f64; 2]; 2]>,
    /// Ratio of each natural mode, the last one of all further modes too.
    pub(crate) modal: Option<Vec<f64>>,
    /// Ratio of every natural mode.
    pub(crate) ratio: Option<f64>,
}

impl DampingEntry {
    /// Ratios of the natural modes.
    pub fn modal_ratios(&self) -> ModalRatios {
        let modal = self.modal.clone();
        ModalRatios(modal.or(self.ratio.map(|ratio| vec![ratio])).unwrap_or_default())
    }

    /// As the dynamics take it, without the ratios of the modes.
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
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SupportEntry {
    /// Its name, for its reaction; absent: `support1`, `support2`, … in the order of the file.
    pub name: Option<String>,
    /// The nodes held.
    pub on: Selection,
    /// The components held.
    #[serde(default = "all_components")]
    pub components: Vec<Component>,
}

/// Base of the supports, which may move.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BaseEntry {
    /// True for a moving base.
    pub moves: bool,
    /// The point about which it turns, and whose acceleration is given.
    #[serde(default)]
    pub point: [f64; 3],
}

impl SupportEntry {
    /// Its name where it is the support `index` of the problem.
    pub fn name(&self, index: usize) -> String {
        self.name.clone().unwrap_or_else(|| format!("support{}", index + 1))
    }
}

fn all_components() -> Vec<Component> {
    vec![Component::X, Component::Y, Component::Z]
}

/// One component of a displacement.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq, JsonSchema)]
#[serde(rename_all = "lowercase")]
#[allow(missing_docs)]
pub enum Component {
    X,
    Y,
    Z,
}

/// Places and patterns of loads; absent: contacts anywhere, no patterns.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LoadEntry {
    /// Contacts may touch the surface facets all of whose corners are selected; absent: the whole free
    /// surface.
    pub surface: Option<Selection>,
    /// Distributed loads with an amplitude each.
    #[serde(rename = "pattern", default)]
    pub patterns: Vec<PatternEntry>,
}

/// One load: exactly one of `acceleration`, `traction`, `pressure`, `temperature`, `forces` and `reference`.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PatternEntry {
    /// Its name.
    pub name: String,
    /// Facets it acts on (traction, pressure), or elements (temperature; absent: all): those all of whose
    /// corners are selected.
    pub on: Option<Selection>,
    /// Body force per mass, such as gravity.
    pub acceleration: Option<[f64; 3]>,
    /// Force per area.
    pub traction: Option<[f64; 3]>,
    /// Force per area against the outward normal.
    pub pressure: Option<f64>,
    /// Rise of the temperature \[K\].
    pub temperature: Option<f64>,
    /// Forces at nodes.
    pub forces: Option<Vec<NodalForce>>,
    /// Reference point that `force` and `moment` act on.
    pub reference: Option<String>,
    /// Force at the reference point.
    pub force: Option<[f64; 3]>,
    /// Moment at the reference point.
    pub moment: Option<[f64; 3]>,
}

/// Number of a node in the mesh file, and the components of a force.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
pub struct NodalForce(pub u64, pub f64, pub f64, pub f64);

impl NodalForce {
    /// The force.
    pub fn force(self) -> [f64; 3] {
        [self.1, self.2, self.3]
    }
}

fn one() -> f64 {
    1.0
}
