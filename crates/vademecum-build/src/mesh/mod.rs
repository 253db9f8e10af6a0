//! Meshes of solids: tetrahedra, hexahedra, wedges and pyramids, read from the formats engineers have.
//!
//! [`parse`] turns a file into a [`RawMesh`]: the content of the file, unchecked. [`read`] repairs what is
//! harmless (with a note), refuses what is not, and gives the [`Mesh`] everything else is built on;
//! [`inspect`] gives a report on any raw mesh without refusing it. Files are untrusted: no input makes a
//! parser panic or allocate beyond the file's own size. A surface is filled with tetrahedra.

pub mod ansys;
mod block;
pub mod cells;
pub(crate) mod check;
mod degenerate;
mod detect;
mod error;
mod filled;
mod flaw;
mod foreign;
mod fortran;
mod gmsh;
mod groups;
mod hash;
mod hexahedra;
pub mod inp;
mod kind;
mod load;
mod medit;
mod mfem;
pub mod nastran;
mod order;
mod parts;
mod place;
pub(crate) mod quality;
mod raise;
mod ranges;
mod raw;
mod report;
mod rows;
pub(crate) mod rules;
pub mod select;
pub(crate) mod shapes;
mod solids;
mod sources;
pub mod surface;
mod tables;
mod tetgen;
pub(crate) mod text;
mod unv;
pub(crate) mod vtk;

use std::collections::BTreeMap;

pub use block::block;
pub use detect::{parse, parse_with_cells, read, read_without, repaired, repaired_apart, repaired_deck};
pub use error::{Fault, MeshError};
pub(crate) use error::{FaultSite, shown};
pub(crate) use filled::Embedded;
pub use filled::{CELLS, SurfaceMesh, read_surface};
pub use flaw::{Flaw, UnsupportedCells};
pub use foreign::LS_DYNA_EXTENSIONS;
pub use hash::hash;
pub use hexahedra::Hexahedra;
pub(crate) use kind::{EDGES, FACES, FaceKey, MAX_FACET_NODES, corner_triples, face_key};
pub use kind::{ElementKind, ElementKinds, FacetKind};
pub use order::Order;
pub use parts::part_sizes;
pub use place::Location;
pub use quality::jacobian_10;
pub use raw::{RawElements, RawMesh};
pub use report::{MeshReport, QualityReport, RegionReport, inspect};
pub(crate) use sources::sources;
pub use tables::{read_tables, read_tables_without};

/// A set of elements with one material.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Region {
    /// The number the mesh file gives it.
    pub tag: i64,
    /// The name the mesh file gives it, else the tag in words.
    pub name: String,
    /// Formulation of its hexahedra, where the file or the problem names one.
    pub hexahedra: Option<Hexahedra>,
}

impl Region {
    /// A region without a formulation.
    pub fn new(tag: i64, name: impl Into<String>) -> Self {
        Self { tag, name: name.into(), hexahedra: None }
    }
}

/// A mesh as the rest of the builder uses it: every node used, every element positively oriented.
#[derive(Clone, Debug)]
pub struct Mesh {
    /// Node coordinates, in the unit of the problem.
    pub nodes: Vec<[f64; 3]>,
    /// The number each node has in the file it came from.
    pub node_ids: Vec<u64>,
    /// Kind of each element.
    pub kinds: ElementKinds,
    /// Node indices of the elements, one after the other.
    pub elements: Vec<u32>,
    /// Index into `regions`, one per element.
    pub element_region: Vec<u32>,
    /// Element sets, in order of their tags.
    pub regions: Vec<Region>,
    /// Named sets of nodes, sorted and unique (those of facet groups included).
    pub node_groups: BTreeMap<String, Vec<u32>>,
    /// Named sets of surface facets, by three of their corner nodes.
    pub facet_groups: BTreeMap<String, Vec<[u32; 3]>>,
    /// Repairs made on reading, in sentences for the user.
    pub notes: Vec<String>,
}

impl Mesh {
    /// Points without elements.
    pub fn of_points(nodes: Vec<[f64; 3]>) -> Self {
        let node_ids = (1..=nodes.len() as u64).collect();
        Self { nodes, node_ids, ..Self::of_nothing() }
    }

    /// A mesh without nodes and elements.
    pub(crate) fn of_nothing() -> Self {
        Self {
            nodes: vec![],
            node_ids: vec![],
            kinds: ElementKinds::Uniform(ElementKind::Tet4),
            elements: vec![],
            element_region: vec![],
            regions: vec![],
            node_groups: BTreeMap::new(),
            facet_groups: BTreeMap::new(),
            notes: vec![],
        }
    }

    /// Number of elements.
    pub fn element_count(&self) -> usize {
        self.element_region.len()
    }

    /// Kind and node indices of each element.
    pub fn each(&self) -> impl Iterator<Item = (ElementKind, &[u32])> {
        self.kinds.each(&self.elements)
    }

    /// Node indices of one element.
    ///
    /// # Panics
    /// If there is no such element.
    pub fn element(&self, index: usize) -> &[u32] {
        &self.elements[self.kinds.range(index)]
    }

    /// Order of the tetrahedra of a mesh that has no other elements.
    pub fn tetrahedra(&self) -> Option<Order> {
        self.kinds.uniform().filter(|kind| kind.is_tetrahedron()).map(ElementKind::order)
    }

    /// Polynomial order of all elements: a mesh has one.
    pub fn order(&self) -> Order {
        match &self.kinds {
            ElementKinds::Uniform(kind) => kind.order(),
            ElementKinds::Mixed { kinds, .. } => kinds.first().map_or(Order::Linear, |kind| kind.order()),
        }
    }

    /// Lower and upper corner of the box around all nodes, in the unit of the mesh.
    pub fn bounding_box(&self) -> ([f64; 3], [f64; 3]) {
        bounding_box(&self.nodes)
    }

    /// Volume of all elements (of the curved ones if quadratic), in the mesh's unit cubed.
    pub fn volume(&self) -> f64 {
        self.each().map(|(kind, e)| quality::element_volume(kind, &self.nodes, e)).sum()
    }
}

/// Lower and upper corner of the box around points; zeros for none.
pub(crate) fn bounding_box(points: &[[f64; 3]]) -> ([f64; 3], [f64; 3]) {
    let Some(&first) = points.first() else {
        return ([0.0; 3], [0.0; 3]);
    };
    points.iter().fold((first, first), |(low, high), p| {
        (std::array::from_fn(|k| low[k].min(p[k])), std::array::from_fn(|k| high[k].max(p[k])))
    })
}
