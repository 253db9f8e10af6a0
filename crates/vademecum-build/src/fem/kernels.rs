//! One element kernel for each kind and formulation of a mesh.

use super::element::ElementKernel;
use crate::mesh::{ElementKind, Hexahedra, Mesh};

/// The kernels of a mesh.
pub(crate) struct ElementKernels(Vec<(ElementKind, Option<Hexahedra>, ElementKernel)>);

impl ElementKernels {
    /// Tabulates the kernels that the elements of a mesh need.
    pub(crate) fn new(mesh: &Mesh) -> Self {
        let mut formulations: Vec<Option<Hexahedra>> =
            mesh.regions.iter().map(|region| region.hexahedra).collect();
        formulations.push(None);
        formulations.sort_unstable();
        formulations.dedup();
        let mut kernels = Vec::new();
        for kind in mesh.kinds.distinct() {
            for &hexahedra in &formulations {
                kernels.push((kind, hexahedra, ElementKernel::new(kind, hexahedra)));
            }
        }
        Self(kernels)
    }

    /// The kernel of one element.
    pub(crate) fn of(&self, mesh: &Mesh, element: usize) -> &ElementKernel {
        self.at(self.place(mesh, element))
    }

    /// Place of the kernel of one element among [all](Self::each).
    pub(super) fn place(&self, mesh: &Mesh, element: usize) -> usize {
        let kind = mesh.kinds.kind(element);
        let region = mesh.regions.get(mesh.element_region[element] as usize);
        let hexahedra = region.and_then(|region| region.hexahedra);
        let found = self.0.iter().position(|(k, h, _)| (*k, *h) == (kind, hexahedra));
        found.expect("a kernel for each kind and formulation")
    }

    /// The kernel at a place.
    pub(super) fn at(&self, place: usize) -> &ElementKernel {
        &self.0[place].2
    }

    /// All kernels.
    pub(super) fn each(&self) -> impl Iterator<Item = &ElementKernel> {
        self.0.iter().map(|(.., kernel)| kernel)
    }

    /// Most nodes of an element.
    pub(crate) fn most_nodes(&self) -> usize {
        self.0.iter().map(|(kind, ..)| kind.nodes()).max().unwrap_or(0)
    }

    /// Room for the mass of any element.
    pub(crate) fn mass_buffer(&self) -> Vec<f64> {
        vec![0.0; self.most_nodes().pow(2)]
    }
}
