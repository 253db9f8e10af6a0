//! Output of the parsers: cells as the file has them, before any check or repair.

use std::collections::{BTreeMap, HashMap};

use super::error::{FaultSite, MeshError};
use super::flaw::UnsupportedCells;
use super::place::Location;
use super::{ElementKind, FacetKind, Hexahedra};

/// The shape of a cell in a mesh file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum CellKind {
    Point,
    /// A line with this many nodes.
    Line(usize),
    /// A facet, its nodes in the order of [`FacetKind`].
    Facet(FacetKind),
    /// An element, its nodes in the order of [`ElementKind`].
    Solid(ElementKind),
    /// A surface cell that cannot be a facet of an element we compute with.
    OtherSurface(&'static str, usize),
    /// A volume cell that is refused by this name.
    OtherVolume(&'static str, usize),
}

impl CellKind {
    /// Nodes of the cell.
    pub(crate) fn node_count(self) -> usize {
        match self {
            CellKind::Point => 1,
            CellKind::Facet(kind) => kind.nodes(),
            CellKind::Solid(kind) => kind.nodes(),
            CellKind::Line(n) | CellKind::OtherSurface(_, n) | CellKind::OtherVolume(_, n) => n,
        }
    }

    /// Dimension of the cell, 0 to 3.
    pub(crate) fn dimension(self) -> usize {
        match self {
            CellKind::Point => 0,
            CellKind::Line(_) => 1,
            CellKind::Facet(_) | CellKind::OtherSurface(..) => 2,
            _ => 3,
        }
    }
}

/// The elements of a file.
#[derive(Clone, Debug, Default)]
pub struct RawElements {
    /// Kind per element.
    pub(crate) kinds: Vec<ElementKind>,
    /// Node indices, one element after the other.
    pub(crate) connectivity: Vec<u32>,
    /// Region tag per element.
    pub region: Vec<i64>,
}

impl RawElements {
    /// Kind, nodes and region of each element.
    pub(crate) fn each(&self) -> impl Iterator<Item = (ElementKind, &[u32], i64)> {
        let mut rest = &self.connectivity[..];
        self.kinds.iter().zip(&self.region).map(move |(&kind, &region)| {
            let (nodes, others) = rest.split_at(kind.nodes());
            rest = others;
            (kind, nodes, region)
        })
    }

    /// Adds an element.
    pub(crate) fn push(&mut self, kind: ElementKind, nodes: &[u32], region: i64) {
        self.kinds.push(kind);
        self.connectivity.extend_from_slice(nodes);
        self.region.push(region);
    }
}

/// A mesh as its file has it. Made by `mesh::parse`, looked at by `mesh::inspect`, made a `Mesh` by
/// `mesh::read`.
#[derive(Clone, Debug, Default)]
pub struct RawMesh {
    /// The file.
    pub file: std::path::PathBuf,
    /// Format in words.
    pub format: String,
    /// Cells along the longest side of a surface that was filled.
    pub cells: Option<u32>,
    /// Coordinates.
    pub nodes: Vec<[f64; 3]>,
    /// Number of each node in the file.
    pub node_ids: Vec<u64>,
    /// Elements that can be computed with.
    pub elements: RawElements,
    /// Formulations of hexahedra that the file names, by tag of the region.
    pub(crate) hexahedra: BTreeMap<i64, Hexahedra>,
    /// Names of regions by tag.
    pub(crate) region_names: BTreeMap<i64, String>,
    /// Node sets; not yet sorted.
    pub node_groups: BTreeMap<String, Vec<u32>>,
    /// Facet sets by three of their corner nodes.
    pub facet_groups: BTreeMap<String, Vec<[u32; 3]>>,
    /// Volume cells that are refused.
    pub(crate) unsupported: Vec<UnsupportedCells>,
    /// Surface cells that are no facets and were left out, by kind.
    pub(crate) skipped: BTreeMap<&'static str, usize>,
    /// Remarks made while reading.
    pub notes: Vec<String>,
    /// Names given by the file to cells of a dimension and tag.
    pub(crate) names: BTreeMap<(usize, i64), String>,
}

impl RawMesh {
    pub(crate) fn new(file: &std::path::Path, format: &str) -> Self {
        RawMesh { file: file.to_path_buf(), format: format.into(), ..RawMesh::default() }
    }

    /// The name of the cells of this dimension and tag: the file's, else the tag in words.
    pub(crate) fn group_name(&self, dimension: usize, tag: i64) -> String {
        const WORDS: [&str; 4] = ["point", "curve", "surface", "region"];
        match self.names.get(&(dimension, tag)) {
            Some(name) => name.clone(),
            None => format!("{} {tag}", WORDS[dimension.min(3)]),
        }
    }

    /// Adds a cell whose nodes are indices already. `tags` are the groups it is in; the first one of a volume
    /// is its region, further ones become node groups.
    pub(crate) fn push(&mut self, kind: CellKind, nodes: &[u32], tags: &[i64], place: Location) {
        match kind {
            CellKind::Solid(kind) => self.elements.push(kind, nodes, tags.first().copied().unwrap_or(0)),
            CellKind::OtherVolume(name, _) => self.refuse(name, place),
            CellKind::OtherSurface(name, _) => *self.skipped.entry(name).or_default() += 1,
            _ => {}
        }
        let dimension = kind.dimension();
        for &tag in tags.iter().skip(usize::from(dimension == 3)) {
            let name = self.group_name(dimension, tag);
            if matches!(kind, CellKind::Facet(_)) {
                let facet = [nodes[0], nodes[1], nodes[2]];
                self.facet_groups.entry(name.clone()).or_default().push(facet);
            }
            self.node_groups.entry(name).or_default().extend_from_slice(nodes);
        }
    }

    /// Counts a volume cell that cannot be computed with.
    pub(crate) fn refuse(&mut self, kind: &str, place: Location) {
        match self.unsupported.iter_mut().find(|u| u.kind == kind) {
            Some(known) => known.count += 1,
            None => self.unsupported.push(UnsupportedCells { kind: kind.into(), count: 1, first: place }),
        }
    }

    /// Groups that have a name but no cell: dimension, tag, name.
    pub(crate) fn missing_groups(&self) -> Vec<(usize, i64, String)> {
        let used = |dimension: usize, tag: i64, name: &str| match dimension {
            3 => self.region_names.contains_key(&tag) || self.node_groups.contains_key(name),
            _ => self.node_groups.contains_key(name),
        };
        let missing = self.names.iter().filter(|((d, tag), name)| !used(*d, *tag, name));
        missing.map(|((dimension, tag), name)| (*dimension, *tag, name.clone())).collect()
    }

    /// Takes over the names of the regions in use, once all cells are in.
    pub(crate) fn name_regions(&mut self) {
        let tags: Vec<i64> = self.elements.region.clone();
        for tag in tags {
            if !self.region_names.contains_key(&tag) {
                self.region_names.insert(tag, self.group_name(3, tag));
            }
        }
    }
}

/// Finds the index of a node by its number in the file, for numbers with gaps.
#[derive(Default)]
pub(crate) struct NodeIndex(HashMap<u64, u32>);

impl NodeIndex {
    /// Registers the next node; a number that was used before is a fault.
    pub(crate) fn insert(&mut self, id: u64, index: usize, at: &FaultSite<'_>) -> Result<(), MeshError> {
        match self.0.insert(id, index as u32) {
            None => Ok(()),
            Some(_) => Err(at.malformed(format!("node {id} a second time"), "every node number once")),
        }
    }

    pub(crate) fn get(&self, id: u64) -> Option<u32> {
        self.0.get(&id).copied()
    }

    pub(crate) fn find(&self, id: u64, at: &FaultSite<'_>) -> Result<u32, MeshError> {
        self.get(id).ok_or_else(|| at.malformed(format!("node {id}"), "a node number that the file defines"))
    }
}
