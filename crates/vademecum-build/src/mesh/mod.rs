//! Tetrahedral meshes: what a solid is made of, read from the formats engineers have.

use std::collections::BTreeMap;

/// Polynomial order of the displacement in an element.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// 4-node tetrahedra.
    Linear,
    /// 10-node tetrahedra, mid-side nodes on edges (0,1) (1,2) (2,0) (0,3) (1,3) (2,3).
    Quadratic,
}

impl Order {
    /// Nodes of one element.
    pub fn nodes_per_element(self) -> usize {
        match self {
            Order::Linear => 4,
            Order::Quadratic => 10,
        }
    }
}

/// A set of elements with one material.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Region {
    /// The number the mesh file gives it.
    pub tag: i64,
    /// The name the mesh file gives it, else the tag in words.
    pub name: String,
}

/// A tetrahedral mesh as the rest of the builder uses it: every node used, every element positively oriented.
#[derive(Clone, Debug)]
pub struct Mesh {
    /// Node coordinates, in the unit of the problem.
    pub nodes: Vec<[f64; 3]>,
    /// The number each node has in the file it came from.
    pub node_ids: Vec<u64>,
    /// Order of all elements.
    pub order: Order,
    /// Node indices, `order.nodes_per_element()` per element.
    pub elements: Vec<u32>,
    /// Index into `regions`, one per element.
    pub element_region: Vec<u32>,
    /// Element sets, in order of their tags.
    pub regions: Vec<Region>,
    /// Named sets of nodes, sorted and unique (those of facet groups included).
    pub node_groups: BTreeMap<String, Vec<u32>>,
    /// Named sets of surface triangles, by their three corner nodes.
    pub facet_groups: BTreeMap<String, Vec<[u32; 3]>>,
    /// What was mended on reading, in sentences for the user.
    pub notes: Vec<String>,
}
