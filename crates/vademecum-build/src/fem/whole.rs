//! A body whose matrices the ranks assemble, each its own rows.
//!
//! A row of a matrix is a sum over the elements at its node, so a rank needs these elements and their nodes,
//! and no more. It adds them in the order of the mesh: its rows have the bits that one process gives them.

use std::ops::Range;
use std::sync::Arc;

use super::assembly::{NodeGraph, assemble, pair_bytes, pairs};
use super::dofs::DofMap;
use super::late::Lazy;
use super::material::Material;
use super::model_error::ModelError;
use super::ordering::order_of_nodes;
use super::pencil::{Pencil, RemoteMatrices};
use crate::mesh::{ElementKinds, Hexahedra, Mesh, Region};

/// Input of the assembly of a body's matrices, and the order in which rows are distributed.
#[derive(Debug)]
#[doc(alias = "domain decomposition")]
pub struct AssemblyPlan {
    mesh: Arc<Mesh>,
    materials: Vec<Material>,
    dofs: Arc<DofMap>,
    order: Arc<Vec<u32>>,
    /// Place of each free dof in the order.
    places: Vec<u32>,
    factor_entries: usize,
}

impl AssemblyPlan {
    /// Orders the dofs of a body.
    ///
    /// # Errors
    /// [`ModelError::TooLarge`], [`ModelError::OutOfMemory`].
    pub(super) fn new(
        mesh: Arc<Mesh>,
        materials: &[Material],
        dofs: Arc<DofMap>,
    ) -> Result<Self, ModelError> {
        let graph = NodeGraph::of(&mesh);
        let free = |node: usize| (0..3).filter(|c| dofs.free(3 * node + c).is_some()).count();
        let entries = |node: usize| {
            free(node) * graph.row(node).iter().map(|&other| free(other as usize)).sum::<usize>()
        };
        if (0..mesh.nodes.len()).map(entries).sum::<usize>() > u32::MAX as usize {
            return Err(ModelError::TooLarge);
        }
        let (order, factor_entries) = order_of_nodes(&graph, &dofs).map_err(|_| ModelError::OutOfMemory)?;
        let mut places = vec![0; order.len()];
        order.iter().enumerate().for_each(|(place, &free)| places[free as usize] = place as u32);
        let (materials, order) = (materials.to_vec(), Arc::new(order));
        Ok(Self { mesh, materials, dofs, order, places, factor_entries })
    }

    /// The free dof at each place of the order of elimination.
    pub fn order(&self) -> &[u32] {
        &self.order
    }

    /// Source of the matrices that the ranks assemble.
    pub(super) fn away(self: &Arc<Self>) -> RemoteMatrices {
        let whole = self.clone();
        let assembled = move || {
            let pencil = assemble(&whole.mesh, &whole.materials, &whole.dofs);
            pencil.expect("what the ranks assembled can be assembled here")
        };
        RemoteMatrices {
            order: self.order.clone(),
            regions: self.materials.len(),
            factor_entries: self.factor_entries,
            here: Arc::new(Lazy::new(assembled)),
        }
    }

    /// The elements that the rows at some places are made of.
    pub fn part(&self, places: Range<usize>) -> AssemblyPart {
        let node_of = |free: u32| self.dofs.dof_of_free()[free as usize] as usize / 3;
        let mut own = vec![false; self.mesh.nodes.len()];
        self.order[places.clone()].iter().for_each(|&free| own[node_of(free)] = true);
        let reaches = |nodes: &[u32]| nodes.iter().any(|&node| own[node as usize]);
        let chosen = self.mesh.each().enumerate().filter(|(_, (_, nodes))| reaches(nodes));
        let numbers: Vec<u32> = chosen.map(|(element, _)| element as u32).collect();
        let mut near = vec![false; self.mesh.nodes.len()];
        let nodes_of = |&element: &u32| self.mesh.element(element as usize);
        numbers.iter().flat_map(nodes_of).for_each(|&node| near[node as usize] = true);
        let kept: Vec<usize> = (0..near.len()).filter(|&node| near[node]).collect();
        let mut local = vec![u32::MAX; near.len()];
        kept.iter().enumerate().for_each(|(at, &node)| local[node] = at as u32);
        let place = |dof: usize| self.dofs.free(dof).map_or(-1, |free| i64::from(self.places[free as usize]));
        AssemblyPart {
            kinds: numbers.iter().map(|&element| self.mesh.kinds.kind(element as usize)).collect(),
            hexahedra: self.mesh.regions.iter().map(|region| region.hexahedra).collect(),
            nodes: kept.iter().map(|&node| self.mesh.nodes[node]).collect(),
            elements: numbers.iter().flat_map(nodes_of).map(|&node| local[node as usize]).collect(),
            regions: numbers.iter().map(|&element| self.mesh.element_region[element as usize]).collect(),
            numbers,
            materials: self.materials.clone(),
            places: kept.iter().flat_map(|&node| (0..3).map(move |c| 3 * node + c)).map(place).collect(),
            rows: places,
        }
    }
}

/// The elements that some rows of a body's matrices are made of.
#[derive(Clone, Debug, PartialEq)]
pub struct AssemblyPart {
    /// Kinds of the elements.
    pub kinds: ElementKinds,
    /// Formulation of the hexahedra of each region.
    pub hexahedra: Vec<Option<Hexahedra>>,
    /// Coordinates of their nodes.
    pub nodes: Vec<[f64; 3]>,
    /// Nodes of each element, by these nodes.
    pub elements: Vec<u32>,
    /// Region of each element.
    pub regions: Vec<u32>,
    /// The number that each element has in the mesh of the body.
    pub numbers: Vec<u32>,
    /// One material per region.
    pub materials: Vec<Material>,
    /// Place in the order of elimination of each dof of these nodes; −1 where it is held.
    pub places: Vec<i64>,
    /// Places of the rows.
    pub rows: Range<usize>,
}

impl AssemblyPart {
    /// Mass and stiffness over the free dofs of the part, each of which is at [`AssemblyPart::free_places`];
    /// complete in the rows that it is for.
    ///
    /// # Errors
    /// [`ModelError::FoldedElement`], [`ModelError::TooLarge`].
    pub fn assemble(&self) -> Result<Pencil, ModelError> {
        let regions =
            self.hexahedra.iter().map(|&hexahedra| Region { tag: 0, name: String::new(), hexahedra });
        let mesh = Mesh {
            nodes: self.nodes.clone(),
            node_ids: vec![],
            kinds: self.kinds.clone(),
            elements: self.elements.clone(),
            element_region: self.regions.clone(),
            regions: regions.collect(),
            node_groups: Default::default(),
            facet_groups: Default::default(),
            notes: vec![],
        };
        let held: Vec<bool> = self.places.iter().map(|&place| place < 0).collect();
        assemble(&mesh, &self.materials, &DofMap::new(&held)).map_err(|error| match error {
            ModelError::FoldedElement { element, source } => {
                ModelError::FoldedElement { element: self.numbers[element as usize], source }
            }
            other => other,
        })
    }

    /// Memory while it is assembled, from below \[bytes\]: with an index and two values of 64 bits for each
    /// entry of what the rank is then left with.
    pub fn bytes(&self) -> f64 {
        const LEFT: f64 = 24.0;
        let pair = pair_bytes(self.materials.len()) + 9.0 * LEFT;
        (0..self.regions.len()).map(|element| pairs(self.kinds.kind(element))).sum::<f64>() * pair
    }

    /// The place of each free dof of the part.
    pub fn free_places(&self) -> Vec<i64> {
        self.places.iter().copied().filter(|&place| place >= 0).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fem::Model;
    use crate::mesh::{Order, block};

    const RUBBER: Material = Material::isotropic(1e7, 0.3, 1000.0);
    const STEEL: Material = Material::isotropic(2e11, 0.25, 7800.0);

    #[test]
    fn parts_have_the_rows_of_the_whole_to_the_bit() {
        let mut mesh = block([1.0, 0.3, 0.2], [6, 3, 2], Order::Quadratic);
        mesh.regions.push(mesh.regions[0].clone());
        let half = mesh.element_region.len() / 2;
        mesh.element_region[half..].fill(1);
        // One component of some nodes only, so that a node may be shared by two parts.
        let held: Vec<bool> =
            mesh.nodes.iter().flat_map(|x| [x[0] == 0.0, x[0] == 0.0, x[2] == 0.0]).collect();
        let materials = [RUBBER, STEEL];
        let dofs = Arc::new(DofMap::new(&held));
        let whole = AssemblyPlan::new(Arc::new(mesh.clone()), &materials, dofs).unwrap();
        let model = Model::assemble(mesh, &materials, &held).unwrap();
        let n = model.pencil().n_dof();
        let mut sorted = whole.order().to_vec();
        sorted.sort_unstable();
        assert_eq!(sorted, (0..n as u32).collect::<Vec<_>>());
        let mut rows = 0;
        for range in [0..n / 3 + 1, n / 3 + 1..n / 2, n / 2..n] {
            let part = whole.part(range.clone());
            assert!(part.numbers.len() < model.mesh().element_count());
            let (own, places) = (part.assemble().unwrap(), part.free_places());
            for (row, &place) in places.iter().enumerate().filter(|&(_, &p)| range.contains(&(p as usize))) {
                let at = whole.order()[place as usize] as usize;
                let [mass, stiffness] = [model.pencil().mass(), model.pencil().stiffness()];
                let columns = own.mass().pattern().rows_of(row);
                assert_eq!(columns.len(), mass.pattern().rows_of(at).len());
                for &column in columns {
                    let there = whole.order()[places[column as usize] as usize] as usize;
                    assert_eq!(own.mass().get(row, column as usize), mass.get(at, there));
                    assert_eq!(own.stiffness().get(row, column as usize), stiffness.get(at, there));
                }
                rows += 1;
            }
        }
        assert_eq!(rows, n);
    }

    #[test]
    fn a_folded_element_has_its_number_in_the_mesh() {
        let mut mesh = block([1.0, 0.3, 0.2], [6, 3, 2], Order::Linear);
        let last = mesh.element_count() - 1;
        mesh.elements.swap(4 * last, 4 * last + 1);
        let held: Vec<bool> = mesh.nodes.iter().flat_map(|x| [x[0] == 0.0; 3]).collect();
        let whole = AssemblyPlan::new(Arc::new(mesh), &[RUBBER], Arc::new(DofMap::new(&held))).unwrap();
        let refused = |range| whole.part(range).assemble().err();
        let n = whole.order().len();
        let found: Vec<u32> = [0..n / 2, n / 2..n]
            .into_iter()
            .filter_map(refused)
            .map(|error| match error {
                ModelError::FoldedElement { element, .. } => element,
                other => panic!("{other}"),
            })
            .collect();
        assert!(!found.is_empty() && found.iter().all(|&element| element as usize == last), "{found:?}");
    }
}
