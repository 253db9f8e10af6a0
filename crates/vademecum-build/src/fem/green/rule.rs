//! Points of integration of the strain energy: one table for each kind and formulation of element, and the
//! map of each element there.

use super::error::GreenError;
use super::point::ElementPoint;
use super::tensor::Tensor;
use crate::fem::assembly::element_nodes;
use crate::fem::element::{ElementKernel, jacobian};
use crate::fem::kernels::ElementKernels;
use crate::mesh::Mesh;
use crate::mesh::shapes::{MAX_NODES, Point};

/// The points of all elements.
pub(super) struct StrainPoints {
    rules: Vec<StrainRule>,
    /// Rule of each element.
    rule: Vec<u8>,
    /// One for an element with an affine map, one for each point of another.
    maps: Vec<JacobianMap>,
    /// First map of each element, and first point; with the ends.
    first: Vec<[usize; 2]>,
}

/// The points of one kind and formulation, as the element loops read them.
struct StrainRule {
    nodes: usize,
    /// Roots of the weights.
    roots: Vec<f64>,
    /// Derivatives of the shape functions along the reference axes, point by point.
    gradients: Vec<[f64; 3]>,
    mean: bool,
}

/// The inverse Jacobian of an element at a point, and the root of its volume form.
struct JacobianMap {
    inverse: Tensor,
    root: f64,
}

impl StrainRule {
    fn new(kernel: &ElementKernel, points: &[Point]) -> Self {
        let nodes = kernel.n_nodes();
        Self {
            nodes,
            roots: points.iter().map(|point| point.weight.sqrt()).collect(),
            gradients: points.iter().flat_map(|point| point.gradients[..nodes].iter().copied()).collect(),
            mean: kernel.has_mean_dilatation(),
        }
    }
}

impl StrainPoints {
    /// Finds the points of a mesh's elements.
    ///
    /// # Errors
    /// An element that folds over, or has a formulation that is not taken.
    pub(super) fn of(mesh: &Mesh) -> Result<Self, GreenError> {
        let kernels = ElementKernels::new(mesh);
        // Of each kernel the points of any element, then those of a tetrahedron with straight edges.
        let tables: Vec<Vec<Point>> = kernels
            .each()
            .flat_map(|kernel| [false, true].map(|straight| kernel.strain_points(straight)))
            .collect();
        let (mut maps, mut first, mut rule, mut points) = (vec![], vec![], vec![], 0);
        for element in 0..mesh.element_count() {
            let place = kernels.place(mesh, element);
            let kernel = kernels.at(place);
            if let Some(hexahedra) = kernel.more_than_points() {
                let region = &mesh.regions[mesh.element_region[element] as usize];
                return Err(GreenError::Formulation { region: region.name.clone(), hexahedra });
            }
            first.push([maps.len(), points]);
            let nodes = &element_nodes::<MAX_NODES>(mesh, element as u32)[..kernel.n_nodes()];
            let straight = kernel.is_straight(nodes);
            let own = 2 * place + usize::from(straight);
            let table = &tables[own];
            for point in &table[..if straight { 1 } else { table.len() }] {
                let (inverse, determinant) = jacobian(nodes.len(), point, nodes)
                    .map_err(|source| GreenError::Folded { element, source })?;
                maps.push(JacobianMap { inverse, root: determinant.sqrt() });
            }
            points += table.len();
            rule.push(u8::try_from(own).expect("there are fewer formulations of all kinds"));
        }
        first.push([maps.len(), points]);
        let tables = tables.chunks(2).zip(kernels.each());
        let rules = tables.flat_map(|(tables, kernel)| tables.iter().map(|t| StrainRule::new(kernel, t)));
        Ok(Self { rules: rules.collect(), rule, maps, first })
    }

    /// Number of elements.
    pub(super) fn n_elements(&self) -> usize {
        self.rule.len()
    }

    /// Number of points of the elements before this one.
    pub(super) fn before(&self, element: usize) -> usize {
        self.first[element][1]
    }

    /// Most nodes of an element.
    pub(super) fn most_nodes(&self) -> usize {
        self.rules.iter().map(|rule| rule.nodes).max().unwrap_or(0)
    }

    /// True if the volume strain of an element is its mean.
    #[inline]
    pub(super) fn has_mean(&self, element: usize) -> bool {
        self.rules[usize::from(self.rule[element])].mean
    }

    /// The points of an element whose material has these roots of the moduli.
    #[inline]
    pub(super) fn of_element(
        &self,
        element: usize,
        roots: [f64; 2],
    ) -> impl Iterator<Item = ElementPoint<'_>> {
        let rule = &self.rules[usize::from(self.rule[element])];
        let maps = &self.maps[self.first[element][0]..self.first[element + 1][0]];
        rule.roots.iter().enumerate().map(move |(k, root_weight)| {
            let map = &maps[k.min(maps.len() - 1)];
            let root = map.root * root_weight;
            ElementPoint {
                gradients: &rule.gradients[k * rule.nodes..][..rule.nodes],
                inverse: &map.inverse,
                roots: roots.map(|x| root * x),
            }
        })
    }
}
