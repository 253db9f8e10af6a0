//! A deck while it is read: nodes, elements, and everything that names them.

use std::collections::HashMap;
use std::rc::Rc;

use super::deck::{DataLine, LineLocation};
use super::dialect::Dialect;
use super::sets::Sets;
use crate::mesh::raw::{CellKind, NodeIndex, RawMesh};
use crate::mesh::{ElementKind, Hexahedra};

/// An element of a deck.
pub(crate) struct Element {
    /// Number in the deck.
    pub(crate) id: u64,
    /// Type as the deck names it, in capitals.
    pub(crate) name: Rc<str>,
    pub(crate) kind: CellKind,
    pub(crate) hexahedra: Option<Hexahedra>,
    pub(crate) nodes: Vec<u32>,
    /// Kind and nodes on its line, where repeated corners make another kind of it: faces are named by those.
    pub(crate) written: Option<Box<(ElementKind, Vec<u32>)>>,
    pub(crate) place: LineLocation,
}

/// A deck being read.
pub(crate) struct Deck {
    pub(crate) raw: RawMesh,
    pub(crate) index: NodeIndex,
    pub(crate) elements: Vec<Element>,
    pub(crate) element_index: HashMap<u64, usize>,
    /// Elements with repeated corners.
    pub(crate) collapsed: usize,
    pub(crate) node_sets: Sets,
    pub(crate) element_sets: Sets,
    /// Element sets that *SOLID SECTION names.
    pub(crate) sections: Vec<(String, LineLocation)>,
    pub(crate) surfaces: Vec<(String, Vec<DataLine>)>,
    pub(crate) instances: Vec<String>,
    /// Outside an instance but inside the assembly, where sets have their own name space.
    pub(crate) in_assembly: bool,
    pub(crate) part: String,
    pub(crate) part_with_nodes: Option<String>,
    pub(crate) dialect: Dialect,
}

pub(crate) fn is_volume(element: &Element) -> bool {
    element.kind.dimension() == 3
}
