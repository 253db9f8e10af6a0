//! Element matrices into global ones, the same bits for any number of threads.
//!
//! Elements are taken in waves of fixed size: one wave's matrices are computed in parallel, then added one
//! element after the other in the order of the mesh. Sums are kept per pair of nodes (one mass, a 3 × 3
//! stiffness block) and only then written to the free dofs, so that supports cost nothing in the inner loop.

use std::sync::Arc;

use faer::{Mat, MatRef};

use super::dofs::DofMap;
use super::element::ElementError;
use super::kernels::ElementKernels;
use super::material::Material;
use super::model_error::ModelError;
use super::pencil::{Pencil, RegionMatrices};
use super::sparse::{Pattern, SymmetricMatrix};
use crate::mesh::shapes::MAX_NODES;
use crate::mesh::{ElementKind, Mesh};
use crate::parallel;

/// Pairs of nodes of the elements of a wave: 30 MB of matrices, and enough for many threads.
const WAVE: usize = 4096 * 100;

/// Pairs of nodes that share an element, per element, from below: a large block has 2.5 with linear
/// tetrahedra and 37 with quadratic ones, and smaller or looser meshes have more. A block of hexahedra has 27
/// with 8 nodes, 190 with 20.
pub(crate) fn pairs(kind: ElementKind) -> f64 {
    match kind {
        ElementKind::Tet4 => 2.0,
        ElementKind::Tet10 => 30.0,
        ElementKind::Pyramid5 | ElementKind::Wedge6 => 8.0,
        ElementKind::Hex8 => 20.0,
        ElementKind::Pyramid13 | ElementKind::Wedge15 => 60.0,
        ElementKind::Hex20 | ElementKind::Hex27 => 150.0,
    }
}

/// Bytes for each pair while matrices are assembled: a mass and a 3 × 3 stiffness, and their nine entries in
/// the pattern and in the matrices of every region.
pub(crate) fn pair_bytes(regions: usize) -> f64 {
    80.0 + 9.0 * (4.0 + 16.0 * regions as f64)
}

/// Mass and stiffness of every region over the free dofs.
///
/// # Errors
/// An element that folds over, or more matrix entries than an index counts.
pub(crate) fn assemble(mesh: &Mesh, materials: &[Material], dofs: &DofMap) -> Result<Pencil, ModelError> {
    let graph = NodeGraph::of(mesh);
    let pattern = Arc::new(dof_pattern(&graph, dofs)?);
    let kernels = ElementKernels::new(mesh);
    let regions = materials
        .iter()
        .enumerate()
        .map(|(region, material)| {
            let blocks = assemble_region(mesh, &kernels, &graph, region as u32, material)?;
            Ok(blocks.over_free_dofs(&graph, dofs, &pattern))
        })
        .collect::<Result<Vec<_>, ModelError>>()?;
    let dof_nodes = dofs.dof_of_free().iter().map(|dof| dof / 3).collect();
    Ok(Pencil::from_regions(regions, Some(dof_nodes)))
}

/// For each node, the nodes it shares an element with (itself among them), ascending.
pub(crate) struct NodeGraph {
    starts: Vec<usize>,
    neighbours: Vec<u32>,
}

impl NodeGraph {
    /// Reads the graph off the elements.
    pub(crate) fn of(mesh: &Mesh) -> NodeGraph {
        let (first, incident) = incident_elements(mesh);
        let mut starts = vec![0];
        let mut neighbours = Vec::new();
        let mut row = Vec::new();
        for node in 0..mesh.nodes.len() {
            row.clear();
            for &element in &incident[first[node]..first[node + 1]] {
                row.extend_from_slice(mesh.element(element as usize));
            }
            row.sort_unstable();
            row.dedup();
            neighbours.extend_from_slice(&row);
            starts.push(neighbours.len());
        }
        NodeGraph { starts, neighbours }
    }

    /// Neighbours of a node, ascending.
    pub(crate) fn row(&self, node: usize) -> &[u32] {
        &self.neighbours[self.starts[node]..self.starts[node + 1]]
    }

    /// Number of pairs of neighbours, each counted from both sides.
    pub(super) fn pairs(&self) -> usize {
        self.neighbours.len()
    }

    /// Place of the pair `(node, other)` among all pairs.
    pub(super) fn place(&self, node: u32, other: u32) -> usize {
        let at = self.row(node as usize).binary_search(&other);
        self.starts[node as usize] + at.expect("nodes of one element are neighbours")
    }
}

/// Values on the pattern of the free dofs from one 3 × 3 block for each pair of neighbours, where the block
/// of `(b, a)` is that of `(a, b)` transposed, to the bit.
pub(super) fn blocks_over_free_dofs(
    graph: &NodeGraph,
    dofs: &DofMap,
    pattern: &Arc<Pattern>,
    blocks: &[[f64; 9]],
) -> SymmetricMatrix {
    let mut values = Vec::with_capacity(pattern.n_stored());
    for &dof in dofs.dof_of_free() {
        let (node, c) = (dof as usize / 3, dof as usize % 3);
        for place in graph.starts[node]..graph.starts[node + 1] {
            let other = graph.neighbours[place] as usize;
            // Column (node, c), row (other, d): the block of (node, other) serves.
            let free = (0..3).filter(|&d| dofs.free(3 * other + d).is_some());
            values.extend(free.map(|d| blocks[place][3 * c + d]));
        }
    }
    SymmetricMatrix::new(pattern.clone(), values)
}

/// Elements at each node, in the order of the mesh, as offsets and list.
pub(super) fn incident_elements(mesh: &Mesh) -> (Vec<usize>, Vec<u32>) {
    let mut first = vec![0; mesh.nodes.len() + 1];
    for &node in &mesh.elements {
        first[node as usize + 1] += 1;
    }
    for node in 0..mesh.nodes.len() {
        first[node + 1] += first[node];
    }
    let mut next = first.clone();
    let mut incident = vec![0; mesh.elements.len()];
    for (element, (_, nodes)) in mesh.each().enumerate() {
        for &node in nodes {
            incident[next[node as usize]] = element as u32;
            next[node as usize] += 1;
        }
    }
    (first, incident)
}

/// The pattern over free dofs: full 3 × 3 blocks between neighbours, less the constrained dofs.
fn dof_pattern(graph: &NodeGraph, dofs: &DofMap) -> Result<Pattern, ModelError> {
    let mut starts = vec![0];
    let mut rows = Vec::new();
    for &dof in dofs.dof_of_free() {
        for &other in graph.row(dof as usize / 3) {
            rows.extend((0..3).filter_map(|c| dofs.free(3 * other as usize + c)));
        }
        let end = u32::try_from(rows.len()).map_err(|_| ModelError::TooLarge)?;
        starts.push(end);
    }
    Ok(Pattern::new(starts, rows))
}

/// Sums over one region, per pair of neighbouring nodes.
struct NodeBlocks {
    mass: Vec<f64>,
    stiffness: Vec<[f64; 9]>,
}

/// Adds up the elements of one region.
fn assemble_region(
    mesh: &Mesh,
    kernels: &ElementKernels,
    graph: &NodeGraph,
    region: u32,
    material: &Material,
) -> Result<NodeBlocks, ModelError> {
    let most = kernels.most_nodes();
    let room = most * most * 10;
    let elements: Vec<u32> = (0..mesh.element_region.len() as u32)
        .filter(|&e| mesh.element_region[e as usize] == region)
        .collect();
    let pairs = graph.neighbours.len();
    let mut blocks = NodeBlocks { mass: vec![0.0; pairs], stiffness: vec![[0.0; 9]; pairs] };
    let together = (WAVE / (most * most).max(1)).max(1);
    let mut buffer = vec![0.0; together.min(elements.len()) * room];
    for wave in elements.chunks(together) {
        let folded: Vec<Option<ElementError>> =
            parallel::map_of(buffer.chunks_mut(room).zip(wave), &|_, (matrices, &element)| {
                element_matrices(mesh, kernels, element, material, matrices).err()
            });
        for (error, &element) in folded.into_iter().zip(wave) {
            if let Some(source) = error {
                return Err(ModelError::FoldedElement { element, source });
            }
        }
        for (matrices, &element) in buffer.chunks(room).zip(wave) {
            let nodes = mesh.element(element as usize);
            blocks.add_element(graph, nodes, matrices);
        }
    }
    Ok(blocks)
}

/// `K_fs t` and `M_fs t` of the elements of some regions over the free dofs, for displacements `t` of held
/// dofs: shape (n_dof, columns), and zero at free dofs. No matrix over held dofs is made; only elements that
/// `t` moves are looked at.
pub(super) fn couple(
    mesh: &Mesh,
    materials: &[Material],
    dofs: &DofMap,
    t: MatRef<'_, f64>,
    is_counted: &dyn Fn(usize) -> bool,
) -> Result<[Mat<f64>; 2], ElementError> {
    let kernels = ElementKernels::new(mesh);
    let columns = t.ncols();
    let mut sums = [Mat::zeros(dofs.n_free(), columns), Mat::zeros(dofs.n_free(), columns)];
    let moved = |node: u32| {
        let rows = t.subrows(3 * node as usize, 3);
        rows.col_iter().any(|column| column.iter().any(|&value| value != 0.0))
    };
    let mut matrices = vec![0.0; kernels.most_nodes().pow(2) * 10];
    for (element, (_, nodes)) in mesh.each().enumerate() {
        let n = nodes.len();
        let held: Vec<usize> = (0..n).filter(|&b| moved(nodes[b])).collect();
        let region = mesh.element_region[element];
        if held.is_empty() || !is_counted(region as usize) {
            continue;
        }
        let material = &materials[region as usize];
        element_matrices(mesh, &kernels, element as u32, material, &mut matrices)?;
        let (mass, stiffness) = matrices.split_at(n * n);
        for (a, &node) in nodes.iter().enumerate() {
            for c in 0..3 {
                let Some(free) = dofs.free(3 * node as usize + c) else { continue };
                for &b in &held {
                    let block = &stiffness[(a * n + b) * 9..][..9];
                    for column in 0..columns {
                        let t = |d: usize| t[(3 * nodes[b] as usize + d, column)];
                        let [stiff, heavy] = &mut sums;
                        stiff[(free as usize, column)] +=
                            (0..3).map(|d| block[3 * c + d] * t(d)).sum::<f64>();
                        heavy[(free as usize, column)] += mass[a * n + b] * t(c);
                    }
                }
            }
        }
    }
    Ok(sums)
}

/// Mass, then stiffness of one element into its share of the wave's buffer.
fn element_matrices(
    mesh: &Mesh,
    kernels: &ElementKernels,
    element: u32,
    material: &Material,
    matrices: &mut [f64],
) -> Result<(), ElementError> {
    let kernel = kernels.of(mesh, element as usize);
    let n = kernel.n_nodes();
    let (mass, stiffness) = matrices[..n * n * 10].split_at_mut(n * n);
    let nodes = element_nodes::<MAX_NODES>(mesh, element);
    kernel.mass_into(&nodes[..n], material.density, mass)?;
    kernel.stiffness_into(&nodes[..n], material, stiffness)
}

/// Coordinates of an element's nodes, zeros behind them.
pub(crate) fn element_nodes<const N: usize>(mesh: &Mesh, element: u32) -> [[f64; 3]; N] {
    let mut nodes = [[0.0; 3]; N];
    for (place, &node) in nodes.iter_mut().zip(mesh.element(element as usize)) {
        *place = mesh.nodes[node as usize];
    }
    nodes
}

impl NodeBlocks {
    /// Adds one element.
    fn add_element(&mut self, graph: &NodeGraph, nodes: &[u32], matrices: &[f64]) {
        let n = nodes.len();
        let (mass, stiffness) = matrices.split_at(n * n);
        for a in 0..n {
            for b in 0..n {
                let place = graph.place(nodes[a], nodes[b]);
                self.mass[place] += mass[a * n + b];
                let block = &stiffness[(a * n + b) * 9..][..9];
                for (sum, &entry) in self.stiffness[place].iter_mut().zip(block) {
                    *sum += entry;
                }
            }
        }
    }

    /// Writes the sums to the free dofs, column by column of the pattern.
    fn over_free_dofs(&self, graph: &NodeGraph, dofs: &DofMap, pattern: &Arc<Pattern>) -> RegionMatrices {
        let mut mass = Vec::with_capacity(pattern.n_stored());
        for &dof in dofs.dof_of_free() {
            let (node, c) = (dof as usize / 3, dof as usize % 3);
            for place in graph.starts[node]..graph.starts[node + 1] {
                let other = graph.neighbours[place] as usize;
                for d in (0..3).filter(|&d| dofs.free(3 * other + d).is_some()) {
                    mass.push(if c == d { self.mass[place] } else { 0.0 });
                }
            }
        }
        RegionMatrices {
            mass: SymmetricMatrix::new(pattern.clone(), mass),
            stiffness: blocks_over_free_dofs(graph, dofs, pattern, &self.stiffness),
        }
    }
}
