//! From linear to quadratic tetrahedra: a node in the middle of every edge, the shape unchanged.

use std::collections::{BTreeSet, HashMap, HashSet};

use super::kind::EDGES;
use super::{Mesh, Order};

/// Ends of an edge, ascending.
type Edge = [u32; 2];

fn edge(a: u32, b: u32) -> Edge {
    [a.min(b), a.max(b)]
}

/// Adds a node in the middle of every edge of 4-node tetrahedra, in order of first use: their 10-node
/// tetrahedra, and the new node of each edge.
pub(super) fn with_mid_nodes(nodes: &mut Vec<[f64; 3]>, linear: &[u32]) -> (Vec<u32>, HashMap<Edge, u32>) {
    let mut middle: HashMap<Edge, u32> = HashMap::new();
    let mut elements = Vec::with_capacity(linear.len() / 4 * 10);
    for tetrahedron in linear.chunks_exact(4) {
        elements.extend_from_slice(tetrahedron);
        for [a, b] in EDGES.map(|ends| ends.map(|i| tetrahedron[i])) {
            let node = *middle.entry(edge(a, b)).or_insert_with(|| {
                let (p, q) = (nodes[a as usize], nodes[b as usize]);
                nodes.push(std::array::from_fn(|k| 0.5 * (p[k] + q[k])));
                nodes.len() as u32 - 1
            });
            elements.push(node);
        }
    }
    (elements, middle)
}

impl Mesh {
    /// The same solid of quadratic tetrahedra: straight mid-side nodes are added to a linear mesh; a
    /// quadratic one is left as it is, with a note.
    ///
    /// New nodes are numbered on from the largest number of the file. A group gets the mid-side nodes of the
    /// facets or of the region that it names, and those of every other edge with both ends in it: a straight
    /// edge whose ends are held in a linear mesh is held as a whole.
    pub fn raised(mut self) -> Mesh {
        match self.tetrahedra() {
            Some(Order::Linear) => {}
            Some(Order::Quadratic) => {
                self.notes.push("the mesh is quadratic already: `mesh.order` adds nothing".into());
                return self;
            }
            None => {
                self.notes.push("only tetrahedra are raised: `mesh.order` adds nothing".into());
                return self;
            }
        }
        let corners = self.nodes.len() as u32;
        let (elements, middle) = with_mid_nodes(&mut self.nodes, &self.elements);
        let edges_of = |facets: &[[u32; 3]]| -> HashSet<Edge> {
            facets.iter().flat_map(|&[a, b, c]| [edge(a, b), edge(b, c), edge(c, a)]).collect()
        };
        // By first use, not by hash.
        let mut edges: Vec<(Edge, u32)> = middle.into_iter().collect();
        edges.sort_unstable_by_key(|&(_, node)| node);
        for (name, nodes) in &mut self.node_groups {
            let region = self.regions.iter().position(|region| region.name == *name);
            let of_region = region.map(|region| nodes_of_region(&elements, &self.element_region, region));
            // A group of the file may have the name of a region and other nodes.
            if let Some(all) = of_region.filter(|all| all.range(..corners).eq(nodes.iter())) {
                *nodes = all.into_iter().collect();
                continue;
            }
            let facets = self.facet_groups.get(name).map_or(&[][..], Vec::as_slice);
            let (on_facets, of_facets) = (edges_of(facets), facets.as_flattened());
            let of_facets: HashSet<u32> = of_facets.iter().copied().collect();
            let inside = |&(ends, _): &&(Edge, u32)| {
                let both = ends.iter().all(|node| nodes.binary_search(node).is_ok());
                both && (on_facets.contains(ends) || !ends.iter().all(|node| of_facets.contains(node)))
            };
            let added: Vec<u32> = edges.iter().filter(inside).map(|&(_, node)| node).collect();
            nodes.extend(added);
        }
        let last = self.node_ids.iter().copied().max().unwrap_or(0);
        self.node_ids.extend((1..=edges.len() as u64).map(|i| last.saturating_add(i)));
        (self.kinds, self.elements) = (Order::Quadratic.into(), elements);
        self
    }
}

/// All nodes of the elements of a region.
fn nodes_of_region(elements: &[u32], element_region: &[u32], region: usize) -> BTreeSet<u32> {
    let inside = elements.chunks_exact(10).zip(element_region).filter(|(_, q)| **q as usize == region);
    inside.flat_map(|(element, _)| element.iter().copied()).collect()
}

#[cfg(test)]
mod tests {
    use super::super::block;
    use super::*;

    #[test]
    fn a_raised_block_is_the_quadratic_block() {
        let raised = block([3.0, 1.0, 2.0], [3, 1, 2], Order::Linear).raised();
        let written = block([3.0, 1.0, 2.0], [3, 1, 2], Order::Quadratic);
        assert_eq!((&raised.nodes, &raised.elements), (&written.nodes, &written.elements));
        assert_eq!((&raised.node_ids, &raised.kinds), (&written.node_ids, &written.kinds));
        // One cell is thin along y: edges run from side to side, and no group may take them in.
        assert_eq!(raised.node_groups, written.node_groups);
        assert_eq!(raised.facet_groups, written.facet_groups);
        let again = raised.clone().raised();
        assert_eq!(again.elements, raised.elements);
        assert!(again.notes.iter().any(|note| note.contains("quadratic already")), "{:?}", again.notes);
    }

    #[test]
    fn a_group_of_nodes_without_facets_takes_the_edges_between_them() {
        let mut mesh = block([1.0, 1.0, 1.0], [1, 1, 1], Order::Linear);
        let facets = mesh.facet_groups.remove("x_min").expect("a side");
        let raised = mesh.clone().raised();
        let written = block([1.0, 1.0, 1.0], [1, 1, 1], Order::Quadratic);
        assert_eq!(raised.node_groups["x_min"], written.node_groups["x_min"]);
        // A corner beside one facet of the side brings the edges that end in it.
        mesh.facet_groups.insert("x_min".into(), facets[..1].to_vec());
        assert_eq!(mesh.raised().node_groups["x_min"], written.node_groups["x_min"]);
    }
}
