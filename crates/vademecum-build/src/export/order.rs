//! The order of nodes and triangles in a file: what a contact needs first, what only a whole field needs
//! last.

use super::curve;
use crate::linalg::vec3::{norm, sub};
use crate::prepared::{Body, Quadrangle};

/// Nodes and triangles in file order.
#[derive(Clone, Debug)]
pub struct NodeOrder {
    /// Mesh node of each file node: loadable ones, other surface nodes and those that an embedded surface
    /// follows, interior ones; along a Hilbert curve in each part.
    pub nodes: Vec<u32>,
    /// File node of each mesh node.
    pub file_node: Vec<u32>,
    /// Number of loadable nodes.
    pub(crate) n_load: usize,
    /// Number of surface nodes, the loadable ones included.
    pub(crate) n_surface: usize,
    /// Surface triangles by file node, loadable ones first.
    pub(crate) triangles: Vec<[u32; 3]>,
    /// Number of loadable triangles.
    pub(crate) n_load_triangles: usize,
    /// Quadrangular facets that these are parts of, by file node, in their order.
    pub(crate) quadrangles: Vec<Quadrangle>,
}

impl NodeOrder {
    /// Orders the nodes of a body.
    pub fn new(body: &Body) -> Self {
        const INTERIOR: u8 = 2;
        let n = body.model.mesh().nodes.len();
        let mut part = vec![INTERIOR; n];
        let followed = body.embedded.iter().flat_map(|embedded| embedded.nodes.iter().flatten());
        body.surface.iter().flatten().chain(followed).for_each(|&node| part[node as usize] = 1);
        body.load_nodes.iter().for_each(|&node| part[node as usize] = 0);
        let mut nodes: Vec<u32> = (0..n as u32).collect();
        let places = curve::places(&body.model.mesh().nodes);
        nodes.sort_by_key(|&node| (part[node as usize], places[node as usize], node));
        let n_load = part.iter().filter(|&&p| p == 0).count();
        let n_surface = part.iter().filter(|&&p| p < INTERIOR).count();
        let mut file_node = vec![0; n];
        nodes.iter().enumerate().for_each(|(i, &node)| file_node[node as usize] = i as u32);
        let loadable: std::collections::HashSet<[u32; 3]> = body.loadable.iter().copied().collect();
        let others = body.surface.iter().filter(|triangle| !loadable.contains(*triangle));
        let triangles = body.loadable.iter().chain(others);
        let triangles: Vec<[u32; 3]> = triangles.map(|t| t.map(|node| file_node[node as usize])).collect();
        let of_file = |quadrangle: &Quadrangle| {
            let nodes = quadrangle.nodes.iter().map(|&node| file_node[node as usize]).collect();
            Quadrangle { nodes, ..*quadrangle }
        };
        let quadrangles = body.quadrangles.iter().map(of_file).collect();
        let n_load_triangles = body.loadable.len();
        Self { nodes, file_node, n_load, n_surface, triangles, n_load_triangles, quadrangles }
    }

    /// Pairs of loadable nodes that share a loadable facet, the first below the second, ascending: a contact
    /// needs the residual between them.
    pub(crate) fn load_pairs(&self) -> Vec<[u32; 2]> {
        let mut pairs = vec![];
        self.for_each_load_facet(|nodes| {
            for (place, &a) in nodes.iter().enumerate() {
                pairs.extend(nodes[..place].iter().map(|&b| [a.min(b), a.max(b)]));
            }
        });
        pairs.sort_unstable();
        pairs.dedup();
        pairs
    }

    /// Largest distance from each loadable node to a node of a loadable facet with it: a contact with a share
    /// at the node is no farther away. `places` are those of the mesh.
    pub(crate) fn load_reach(&self, places: &[[f64; 3]]) -> Vec<f64> {
        let mut reach = vec![0.0; self.n_load];
        let place = |node: u32| places[self.nodes[node as usize] as usize];
        self.for_each_load_facet(|nodes| {
            for &a in nodes {
                let own: &mut f64 = &mut reach[a as usize];
                nodes.iter().for_each(|&b| *own = own.max(norm(sub(place(a), place(b)))));
            }
        });
        reach
    }

    /// Calls `work` with the nodes of each loadable facet.
    fn for_each_load_facet(&self, mut work: impl FnMut(&[u32])) {
        let mut next = 0;
        for quadrangle in &self.quadrangles {
            self.triangles[next..quadrangle.first].iter().for_each(|triangle| work(triangle));
            work(&quadrangle.nodes);
            next = quadrangle.triangles().end;
        }
        self.triangles[next..self.n_load_triangles].iter().for_each(|triangle| work(triangle));
    }
}
