//! A deck while it is read: nodes, elements, and everything that names them.

use std::collections::HashMap;

use super::deck::{DataLine, LineLocation};
use super::sets::Sets;
use crate::mesh::raw::{CellKind, NodeIndex, RawMesh};

/// An element of a deck.
pub(crate) struct Element {
    pub kind: CellKind,
    pub nodes: Vec<u32>,
    pub place: LineLocation,
}

/// A deck being read.
pub(crate) struct Deck {
    pub raw: RawMesh,
    pub index: NodeIndex,
    pub elements: Vec<Element>,
    pub element_index: HashMap<u64, usize>,
    pub node_sets: Sets,
    pub element_sets: Sets,
    /// Element sets that *SOLID SECTION names.
    pub sections: Vec<(String, LineLocation)>,
    pub surfaces: Vec<(String, Vec<DataLine>)>,
    pub instances: Vec<String>,
    /// Outside an instance but inside the assembly, where sets have their own name space.
    pub in_assembly: bool,
    pub part: String,
    pub part_with_nodes: Option<String>,
}

pub(crate) fn is_volume(element: &Element) -> bool {
    element.kind.dimension() == 3
}
