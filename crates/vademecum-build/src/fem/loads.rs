//! Load vectors, N: body acceleration, traction and pressure on facets, a force at a point.
//!
//! All are consistent: `F_a = ∫ N_a f`, with the shape functions of the displacement. What falls on a held
//! dof goes into the support: distributed loads are over all dofs, and [`Model::free_part`] drops it.

use std::collections::{HashMap, HashSet};

use faer::{Mat, MatMut, MatRef};

use super::assembly::element_nodes;
use super::blocks::Block;
use super::kernels::ElementKernels;
use super::model::Model;
use crate::linalg::symmetric_part;
use crate::linalg::vec3::{cross, norm};
use crate::mesh::rules::quadrangle_rule;
use crate::mesh::shapes::MAX_NODES;
use crate::mesh::shapes::quadrangle_shapes;
use crate::mesh::{FacetKind, MAX_FACET_NODES, Mesh, Order, corner_triples, face_key};

/// A facet of the body's surface with all its nodes, counter-clockwise seen from outside.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Facet {
    nodes: [u32; MAX_FACET_NODES],
    kind: FacetKind,
}

impl Facet {
    /// A facet of 3, 4, 6, 8 or 9 nodes, corners first.
    pub fn of(nodes: &[u32]) -> Option<Self> {
        use FacetKind as K;
        let kinds = [K::Tri3, K::Quad4, K::Tri6, K::Quad8, K::Quad9];
        let kind = kinds.into_iter().find(|kind| kind.nodes() == nodes.len())?;
        let mut own = [0; MAX_FACET_NODES];
        own[..nodes.len()].copy_from_slice(nodes);
        Some(Self { nodes: own, kind })
    }

    /// Its nodes, as [`FacetKind`] orders them.
    pub fn nodes(&self) -> &[u32] {
        &self.nodes[..self.kind.nodes()]
    }

    /// Its shape.
    pub fn kind(&self) -> FacetKind {
        self.kind
    }
}

/// Why a set of facets cannot carry a load.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum LoadError {
    /// No element has this face.
    #[error("facet of nodes {corners:?} (counted from 0) is no face of an element")]
    NoSuchFacet {
        /// Its corners.
        corners: [u32; 3],
    },
    /// Two elements share this face: it has no outside.
    #[error("facet of nodes {corners:?} (counted from 0) lies inside the body")]
    InnerFacet {
        /// Its corners.
        corners: [u32; 3],
    },
}

/// The surface facets with the given corners, three of each, in the given order, turned so that their normal
/// points outward. A quadrangle that is named by two triples of its corners comes once.
///
/// # Errors
/// [`LoadError`] for corners that are no face of an element, or of two.
pub fn surface_facets(mesh: &Mesh, corners: &[[u32; 3]]) -> Result<Vec<Facet>, LoadError> {
    let mut wanted: HashMap<[u32; 3], (Option<Facet>, usize)> =
        corners.iter().map(|&c| (sorted(c), (None, 0))).collect();
    for (kind, element) in mesh.each() {
        for face in kind.faces() {
            for triple in corner_triples(face_key(face, element).0) {
                if let Some(slot) = wanted.get_mut(&triple) {
                    *slot = (Some(element_facet(element, *face)), slot.1 + 1);
                }
            }
        }
    }
    let mut facets: Vec<Facet> = Vec::with_capacity(corners.len());
    let mut quadrangles = HashSet::new();
    for &c in corners {
        let facet = match wanted[&sorted(c)] {
            (Some(facet), 1) => facet,
            (None, _) => return Err(LoadError::NoSuchFacet { corners: c }),
            _ => return Err(LoadError::InnerFacet { corners: c }),
        };
        if facet.kind.corners() == 3 || quadrangles.insert(facet.nodes) {
            facets.push(facet);
        }
    }
    Ok(facets)
}

/// One face of an element, with all its nodes.
fn element_facet(element: &[u32], (kind, places): (FacetKind, &[usize])) -> Facet {
    let mut nodes = [0; MAX_FACET_NODES];
    nodes.iter_mut().zip(places).for_each(|(node, &place)| *node = element[place]);
    Facet { nodes, kind }
}

fn sorted(mut corners: [u32; 3]) -> [u32; 3] {
    corners.sort_unstable();
    corners
}

impl Model {
    /// `∫ ρ N_a b` for a uniform acceleration `b`, m/s² (gravity, or minus the acceleration of the frame).
    ///
    /// Without elements it is `M a`, with `a` the rigid translation over the free dofs. That leaves out what
    /// held dofs would add, and is the same integral where no held dof shares an entry of the mass with a
    /// free one.
    pub fn body_load(&self, acceleration: [f64; 3]) -> Vec<f64> {
        let mesh = self.mesh();
        let mut load = vec![0.0; self.dofs().n_dof()];
        if mesh.elements.is_empty() {
            self.dofs().expand_into(&self.translation_load(acceleration), &mut load);
            return load;
        }
        let kernels = ElementKernels::new(mesh);
        let mut mass = kernels.mass_buffer();
        for (e, (_, element)) in mesh.each().enumerate() {
            let density = self.materials()[mesh.element_region[e] as usize].density;
            let (n, nodes) = (element.len(), element_nodes::<MAX_NODES>(mesh, e as u32));
            kernels
                .of(mesh, e)
                .mass_into(&nodes[..n], density, &mut mass[..n * n])
                .expect("the assembled mesh has no folded element");
            for (a, &node) in element.iter().enumerate() {
                // Shape functions sum to one, so a row of the mass sums to ∫ ρ N_a.
                let weight: f64 = mass[a * n..][..n].iter().sum();
                add_at_node(node, acceleration.map(|b| weight * b), &mut load);
            }
        }
        load
    }

    /// `M a` over all dofs, for accelerations `a` of all nodes that are linear in their place.
    pub fn inertia_load(&self, field: impl Fn([f64; 3]) -> [f64; 3]) -> Vec<f64> {
        let mesh = self.mesh();
        let kernels = ElementKernels::new(mesh);
        let mut mass = kernels.mass_buffer();
        let mut load = vec![0.0; self.dofs().n_dof()];
        for (e, (_, element)) in mesh.each().enumerate() {
            let density = self.materials()[mesh.element_region[e] as usize].density;
            let (n, nodes) = (element.len(), element_nodes::<MAX_NODES>(mesh, e as u32));
            kernels
                .of(mesh, e)
                .mass_into(&nodes[..n], density, &mut mass[..n * n])
                .expect("the assembled mesh has no folded element");
            for (a, &node) in element.iter().enumerate() {
                let mut force = [0.0; 3];
                for (weight, &at) in mass[a * n..][..n].iter().zip(&nodes) {
                    force.iter_mut().zip(field(at)).for_each(|(sum, a)| *sum += weight * a);
                }
                add_at_node(node, force, &mut load);
            }
        }
        load
    }

    /// `M a`.
    fn translation_load(&self, acceleration: [f64; 3]) -> Vec<f64> {
        let of_dof = |&dof: &u32| acceleration[dof as usize % 3];
        let rigid: Vec<f64> = self.dofs().dof_of_free().iter().map(of_dof).collect();
        let n = rigid.len();
        let mut load = vec![0.0; n];
        let column = MatMut::from_column_major_slice_mut(&mut load, n, 1);
        self.pencil().mass().mul_into(MatRef::from_column_major_slice(&rigid, n, 1), column);
        load
    }

    /// `∫ N_a t dA` for a uniform traction `t`, Pa, on a set of facets.
    pub(crate) fn traction_load(&self, facets: &[Facet], traction: [f64; 3]) -> Vec<f64> {
        facet_load(self.mesh(), facets, |normal| {
            let area = normal.iter().map(|x| x * x).sum::<f64>().sqrt();
            traction.map(|t| t * area)
        })
    }

    /// `−∫ N_a p n dA` for a uniform pressure `p`, Pa, pushing against the outward normal `n`.
    pub(crate) fn pressure_load(&self, facets: &[Facet], pressure: f64) -> Vec<f64> {
        facet_load(self.mesh(), facets, |normal| normal.map(|n| -pressure * n))
    }

    /// A force, N, at the point `Σ_i w_i x_i` of a facet or element: node `nodes[i]` receives the share
    /// `weights[i]` (barycentric weights on three corners, or shape-function values on all nodes). Added to
    /// `load`, `(n_free)`.
    ///
    /// # Panics
    /// If the two lists differ in length, a node does not exist, or `load` is not of length `n_free`.
    pub fn add_point_force(&self, nodes: &[u32], weights: &[f64], force: [f64; 3], load: &mut [f64]) {
        assert!(nodes.len() == weights.len() && load.len() == self.dofs().n_free());
        for (&node, &weight) in nodes.iter().zip(weights) {
            self.add_nodal_force(node, force.map(|f| weight * f), load);
        }
    }

    /// Adds a force at one node.
    fn add_nodal_force(&self, node: u32, force: [f64; 3], load: &mut [f64]) {
        for (c, &f) in force.iter().enumerate() {
            self.add_force(3 * node as usize + c, f, load);
        }
    }

    /// Adds a force at one dof to a load over the free ones.
    pub(crate) fn add_force(&self, dof: usize, force: f64, load: &mut [f64]) {
        for (free, weight) in self.dofs().terms(dof) {
            load[free as usize] += weight * force;
        }
    }

    /// A load over all dofs on the free ones, length `n_free`.
    pub fn free_part(&self, load: &[f64]) -> Vec<f64> {
        let mut free = vec![0.0; self.dofs().n_free()];
        self.dofs().gather_into(load, &mut free);
        free
    }
}

/// `∫ N_a f dA` over facets, three numbers for each node of the mesh; `density` maps the outward normal,
/// scaled by the area form, to the force per reference area: `n ↦ −p n` for a pressure.
pub fn facet_load(mesh: &Mesh, facets: &[Facet], density: impl Fn([f64; 3]) -> [f64; 3]) -> Vec<f64> {
    let mut load = vec![0.0; 3 * mesh.nodes.len()];
    for facet in facets {
        for point in facet_points(facet.kind) {
            let force = density(point.normal(mesh, facet));
            for (&node, value) in facet.nodes().iter().zip(&point.values) {
                add_at_node(node, force.map(|f| f * point.weight * value), &mut load);
            }
        }
    }
    load
}

/// `∫ N_a N_b (n p nᵀ + t (I − n nᵀ)) dA` over a facet with the normal `n`: stiffness or damping of a ground
/// that has `p` per area along the normal and `t` along the facet. Shape (k, k), three displacements for each
/// node of the facet.
pub fn facet_matrix(mesh: &Mesh, facet: &Facet, p: f64, t: f64) -> Mat<f64> {
    let n = 3 * facet.nodes().len();
    let mut sum = Mat::zeros(n, n);
    for point in facet_points(facet.kind) {
        let normal = point.normal(mesh, facet);
        let area = norm(normal);
        let unit = normal.map(|x| x / area);
        for j in 0..n {
            for i in 0..n {
                let along = (p - t) * unit[i % 3] * unit[j % 3] + if i % 3 == j % 3 { t } else { 0.0 };
                sum[(i, j)] += point.weight * area * (point.values[i / 3] * point.values[j / 3]) * along;
            }
        }
    }
    sum
}

/// Stiffness of a pressure that stays normal to each facet, `−∂f/∂u` of its forces in a displacement of all
/// nodes, symmetric part: that of the whole is symmetric but for the rim of the facets (Bathe, *Finite
/// Element Procedures*, §6.3).
pub fn pressure_stiffness(mesh: &Mesh, facets: &[Facet], pressure: f64, displacement: &[f64]) -> Vec<Block> {
    let of_facet = |facet: &Facet| {
        let nodes = facet.nodes();
        let dofs: Vec<u32> = nodes.iter().flat_map(|&node| (0..3).map(move |c| 3 * node + c)).collect();
        let mut turn = Mat::zeros(dofs.len(), dofs.len());
        for FacetPoint { weight, values, slopes } in facet_points(facet.kind) {
            let mut tangents = [[0.0; 3]; 2];
            for (&node, slope) in nodes.iter().zip(&slopes) {
                let (x, u) = (mesh.nodes[node as usize], &displacement[3 * node as usize..]);
                (0..3).for_each(|i| (0..2).for_each(|r| tangents[r][i] += slope[r] * (x[i] + u[i])));
            }
            for column in 0..dofs.len() {
                let (slope, mut along) = (slopes[column / 3], [0.0; 3]);
                along[column % 3] = 1.0;
                let (one, other) = (cross(along, tangents[1]), cross(tangents[0], along));
                for row in 0..dofs.len() {
                    let normal = slope[0] * one[row % 3] + slope[1] * other[row % 3];
                    turn[(row, column)] += pressure * weight * values[row / 3] * normal;
                }
            }
        }
        Block { stiffness: symmetric_part(turn.as_ref()), mass: Mat::zeros(dofs.len(), dofs.len()), dofs }
    };
    facets.iter().map(of_facet).collect()
}

/// A point of integration on a facet.
struct FacetPoint {
    weight: f64,
    values: Vec<f64>,
    slopes: Vec<[f64; 2]>,
}

impl FacetPoint {
    /// The outward normal, scaled by the area form.
    fn normal(&self, mesh: &Mesh, facet: &Facet) -> [f64; 3] {
        let mut tangents = [[0.0; 3]; 2];
        for (&node, slope) in facet.nodes().iter().zip(&self.slopes) {
            let x = mesh.nodes[node as usize];
            for r in 0..2 {
                for i in 0..3 {
                    tangents[r][i] += slope[r] * x[i];
                }
            }
        }
        cross(tangents[0], tangents[1])
    }
}

/// Points that integrate a force density times a shape function, and two shape functions on a flat facet.
fn facet_points(kind: FacetKind) -> Vec<FacetPoint> {
    let order = match kind {
        FacetKind::Tri3 => Order::Linear,
        FacetKind::Tri6 => Order::Quadratic,
        FacetKind::Quad4 | FacetKind::Quad8 | FacetKind::Quad9 => {
            let point = |([x, y], weight): ([f64; 2], f64)| {
                let (values, slopes) = quadrangle_shapes(kind, x, y);
                FacetPoint { weight, values, slopes }
            };
            return quadrangle_rule().into_iter().map(point).collect();
        }
    };
    let point = |(l, weight)| {
        let (values, slopes) = facet_shapes(order, l);
        FacetPoint { weight, values: values.to_vec(), slopes: slopes.to_vec() }
    };
    triangle_rule().into_iter().map(point).collect()
}

/// Adds a force at one node to a load over all dofs.
fn add_at_node(node: u32, force: [f64; 3], load: &mut [f64]) {
    load.iter_mut().skip(3 * node as usize).zip(force).for_each(|(sum, f)| *sum += f);
}

/// Shape functions of a triangle and their slopes along `L_1` and `L_2`.
pub(crate) fn facet_shapes(order: Order, l: [f64; 3]) -> ([f64; 6], [[f64; 2]; 6]) {
    const D: [[f64; 2]; 3] = [[-1.0, -1.0], [1.0, 0.0], [0.0, 1.0]];
    let mut values = [0.0; 6];
    let mut slopes = [[0.0; 2]; 6];
    for a in 0..3 {
        let b = (a + 1) % 3;
        match order {
            Order::Linear => (values[a], slopes[a]) = (l[a], D[a]),
            Order::Quadratic => {
                values[a] = l[a] * (2.0 * l[a] - 1.0);
                slopes[a] = D[a].map(|d| (4.0 * l[a] - 1.0) * d);
                values[3 + a] = 4.0 * l[a] * l[b];
                slopes[3 + a] = std::array::from_fn(|r| 4.0 * (l[b] * D[a][r] + l[a] * D[b][r]));
            }
        }
    }
    (values, slopes)
}

/// Seven points on a triangle, exact for degree 5 (Radon 1948), weights summing to ½. The force density of a
/// quadratic facet times a shape function is of degree 4 for a pressure, flat or curved.
fn triangle_rule() -> [([f64; 3], f64); 7] {
    let root = 15.0_f64.sqrt();
    let (a, b) = ((6.0 - root) / 21.0, (6.0 + root) / 21.0);
    let (wa, wb) = ((155.0 - root) / 2400.0, (155.0 + root) / 2400.0);
    [
        ([1.0 / 3.0; 3], 9.0 / 80.0),
        ([1.0 - 2.0 * a, a, a], wa),
        ([a, 1.0 - 2.0 * a, a], wa),
        ([a, a, 1.0 - 2.0 * a], wa),
        ([1.0 - 2.0 * b, b, b], wb),
        ([b, 1.0 - 2.0 * b, b], wb),
        ([b, b, 1.0 - 2.0 * b], wb),
    ]
}
