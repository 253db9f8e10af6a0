//! The Green–Lagrange strain of a displacement, as a vector whose square is twice the strain energy.
//!
//! With `H = ∇u` the strain is `E = ½(H + Hᵀ + HᵀH)`, and the energy of a St. Venant–Kirchhoff solid is that
//! of Hooke's law in it: `V = ∫ ½ λ (tr E)² + μ E:E dV`. At each point of integration of each element,
//! `z = √(w det J) [√(λ + 2μ/3) tr E; √(2μ) dev E]` with five orthonormal components of the deviator, so that
//! `V(u) = ½ |z(u)|²`. Since `E` is quadratic in `u`,
//!
//! ```text
//! z(u) = B u + E₂(u, u)       G(u) = ∂z/∂u = B + 2 E₂(u, ·)       ∂V/∂u = G(u)ᵀ z(u)
//! ```
//!
//! The energy is a polynomial of degree four in `H`. One point is exact for linear elements, fourteen (degree
//! 5, Walkington 2000) for straight quadratic ones; curved elements have the points of the linear stiffness,
//! so that the tangent at rest is the stiffness of the pencil, whatever the mesh.
//!
//! No matrix of `G` is stored: each product is a loop over elements. Kept are 80 bytes for a straight
//! element, 80 for each point of a curved one, and lists of neighbours, some 300 bytes for a node of a
//! quadratic mesh. Elements run in parallel and are added in the order of the mesh, so the bytes are the same
//! for any number of threads.

use super::assembly::{NodeGraph, blocks_over_free_dofs, element_nodes, incident_elements};
use super::element::{ElementError, ElementKernel, jacobian};
use super::material::Material;
use super::model::Model;
use super::sparse::SymmetricMatrix;
use crate::linalg::vec3::{cross, dot};
use crate::mesh::Order;
use crate::mesh::rules::{rule_degree_5, rule_degree_6};
use crate::mesh::shapes::{Point, TET_NODES, tabulate_point};
use crate::parallel;

/// Rows of `z` at each point of integration.
const ROWS: usize = 6;

/// Elements that one parallel task handles.
const CHUNK: usize = 32;

/// Dofs that one parallel task sums the forces of.
const DOF_CHUNK: usize = 1024;

/// Elements whose tangents are held at a time: 30 MB of quadratic ones.
const WAVE: usize = 4096;

/// The stretch `1/√3`: a bar of St. Venant and Kirchhoff's law has its largest compressive force there.
pub(crate) const SOFTENING: f64 = 0.577_350_269_189_625_8;

/// A 3 × 3 matrix, row by row.
type Tensor = [[f64; 3]; 3];

/// Displacements of an element's nodes.
type Nodal = [[f64; 3]; TET_NODES];

/// Why a model has no strain field.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum GreenError {
    /// The model came as two matrices.
    #[error(
        "large displacements need elements and materials; this model was given as two matrices, which say nothing \
         beyond small displacements: give the mesh and its materials"
    )]
    NoElements,
    /// The mesh has other elements than tetrahedra of one order.
    #[error("large displacements take tetrahedra of one order, and the mesh has {kinds}: mesh it with those")]
    Elements {
        /// Its kinds of elements.
        kinds: String,
    },
    /// A material that is not the same in every direction.
    #[error("large displacements take isotropic materials: give `young` and `poisson`")]
    Anisotropic,
    /// An element folds over at a point of integration.
    #[error("element {element} (counted from 0)")]
    Folded {
        /// Index of the element.
        element: usize,
        /// The value found.
        source: ElementError,
    },
}

/// The inverse Jacobian of an element at a point, and the root of its volume form.
struct JacobianMap {
    inverse: Tensor,
    root: f64,
}

/// A point of integration as the element loops read it.
struct StrainPoint {
    gradients: [[f64; 3]; TET_NODES],
    root_weight: f64,
}

/// The strain of a model's displacements.
#[doc(alias("Green-Lagrange strain", "St. Venant-Kirchhoff"))]
pub struct GreenStrain<'m> {
    model: &'m Model,
    straight: Vec<StrainPoint>,
    curved: Vec<StrainPoint>,
    /// One for a straight element, one for each point of a curved one.
    maps: Vec<JacobianMap>,
    /// First map of each element, and first point; with the ends.
    first: Vec<[usize; 2]>,
    /// `√(λ + 2μ/3)` and `√(2μ)` of each region.
    roots: Vec<[f64; 2]>,
    /// For each node the places `element · nodes + local` of its occurrences, as offsets and list.
    places: (Vec<usize>, Vec<usize>),
    graph: NodeGraph,
}

impl<'m> GreenStrain<'m> {
    /// The strain field of a model.
    ///
    /// # Errors
    /// [`GreenError`]: a model without elements, a folded element.
    pub fn new(model: &'m Model) -> Result<GreenStrain<'m>, GreenError> {
        let mesh = model.mesh();
        if mesh.elements.is_empty() {
            return Err(GreenError::NoElements);
        }
        let others = || GreenError::Elements {
            kinds: mesh.kinds.distinct().iter().map(|kind| kind.name()).collect::<Vec<_>>().join(", "),
        };
        let order = mesh.tetrahedra().ok_or_else(others)?;
        let kernel = ElementKernel::tetrahedra(order);
        let n = kernel.n_nodes();
        let tabulate = |rule: Vec<([f64; 4], f64)>| -> Vec<Point> {
            rule.into_iter().map(|(l, weight)| tabulate_point(order, l, weight)).collect()
        };
        let straight = match order {
            Order::Linear => tabulate(vec![([0.25; 4], 1.0 / 6.0)]),
            Order::Quadratic => tabulate(rule_degree_5()),
        };
        let curved = tabulate(rule_degree_6());
        let (mut maps, mut first, mut points) = (vec![], vec![], 0);
        for element in 0..mesh.element_count() {
            first.push([maps.len(), points]);
            let nodes: Nodal = element_nodes(mesh, element as u32);
            let is_straight = kernel.is_straight(&nodes[..n]);
            let (mapped, own) =
                if is_straight { (&straight[..1], straight.len()) } else { (&curved[..], curved.len()) };
            for point in mapped {
                let (inverse, determinant) = jacobian(n, point, &nodes[..n])
                    .map_err(|source| GreenError::Folded { element, source })?;
                maps.push(JacobianMap { inverse, root: determinant.sqrt() });
            }
            points += own;
        }
        first.push([maps.len(), points]);
        let root = |material: &Material| {
            let (lambda, mu) = material.lame()?;
            Some([(lambda + 2.0 / 3.0 * mu).sqrt(), (2.0 * mu).sqrt()])
        };
        let roots: Option<Vec<[f64; 2]>> = model.materials().iter().map(root).collect();
        let strain_points = |points: Vec<Point>| {
            let each = |p: Point| StrainPoint {
                gradients: std::array::from_fn(|a| p.gradients[a]),
                root_weight: p.weight.sqrt(),
            };
            points.into_iter().map(each).collect()
        };
        Ok(GreenStrain {
            model,
            straight: strain_points(straight),
            curved: strain_points(curved),
            maps,
            first,
            roots: roots.ok_or(GreenError::Anisotropic)?,
            places: places_of_nodes(model),
            graph: NodeGraph::of(mesh),
        })
    }

    /// The model.
    pub fn model(&self) -> &'m Model {
        self.model
    }

    /// Length of `z`: six for each point of integration, element by element.
    pub(crate) fn n_rows(&self) -> usize {
        ROWS * self.first[self.first.len() - 1][1]
    }

    /// Number of free dofs, the length of `u`.
    pub fn n_dof(&self) -> usize {
        self.model.dofs().n_free()
    }

    /// Strain energy `V(u) = ½ |z(u)|²` \[J\].
    ///
    /// # Panics
    /// Here and below, if a vector over the dofs has not [`n_dof`](Self::n_dof) numbers or one over the rows
    /// not `n_rows`.
    pub fn energy(&self, u: &[f64]) -> f64 {
        let u = self.expand(u);
        let of_chunk = |chunk: usize| {
            let mut sum = 0.0;
            for element in self.elements_of(chunk) {
                let nodal = self.nodal(&u, element);
                for point in self.points(element) {
                    let z = point.rows(&green(&point.gradient(&nodal)));
                    sum += z.iter().map(|z| z * z).sum::<f64>();
                }
            }
            sum
        };
        let sums = parallel::map(self.n_chunks(), &of_chunk);
        0.5 * sums.iter().sum::<f64>()
    }

    /// `z ← z(u)`.
    pub fn strain(&self, u: &[f64], z: &mut [f64]) {
        let u = self.expand(u);
        self.fill_rows(z, |element, rows| {
            let nodal = self.nodal(&u, element);
            for (point, row) in self.points(element).zip(rows) {
                *row = point.rows(&green(&point.gradient(&nodal)));
            }
        });
    }

    /// `z ← B u`: the strain of small displacements.
    pub fn linear(&self, u: &[f64], z: &mut [f64]) {
        let u = self.expand(u);
        self.fill_rows(z, |element, rows| {
            let nodal = self.nodal(&u, element);
            for (point, row) in self.points(element).zip(rows) {
                *row = point.rows(&symmetric(&point.gradient(&nodal)));
            }
        });
    }

    /// `z ← E₂(u, v)`, symmetric: `z(u) = B u + E₂(u, u)`.
    pub(crate) fn bilinear(&self, u: &[f64], v: &[f64], z: &mut [f64]) {
        let (u, v) = (self.expand(u), self.expand(v));
        self.fill_rows(z, |element, rows| {
            let (u, v) = (self.nodal(&u, element), self.nodal(&v, element));
            for (point, row) in self.points(element).zip(rows) {
                let product = transposed_product(&point.gradient(&u), &point.gradient(&v));
                *row = point.rows(&scaled(&symmetric(&product), 0.5));
            }
        });
    }

    /// `z ← G(u) v = B v + 2 E₂(u, v)`: the rate of strain of the velocity `v`.
    pub(crate) fn rate(&self, u: &[f64], v: &[f64], z: &mut [f64]) {
        let (u, v) = (self.expand(u), self.expand(v));
        self.fill_rows(z, |element, rows| {
            let (u, v) = (self.nodal(&u, element), self.nodal(&v, element));
            for (point, row) in self.points(element).zip(rows) {
                let deformation = deformation(&point.gradient(&u));
                *row = point.rows(&symmetric(&transposed_product(&deformation, &point.gradient(&v))));
            }
        });
    }

    /// `f ← Bᵀ z`.
    pub(crate) fn linear_transpose(&self, z: &[f64], f: &mut [f64]) {
        assert_eq!(z.len(), self.n_rows());
        self.gather(f, |element, forces| {
            for (point, row) in self.points(element).zip(self.rows_of(z, element)) {
                point.add_forces(&point.stress(row), forces);
            }
        });
    }

    /// `f ← G(u)ᵀ z`.
    pub fn transpose(&self, u: &[f64], z: &[f64], f: &mut [f64]) {
        assert_eq!(z.len(), self.n_rows());
        let u = self.expand(u);
        self.gather(f, |element, forces| {
            let nodal = self.nodal(&u, element);
            for (point, row) in self.points(element).zip(self.rows_of(z, element)) {
                let deformation = deformation(&point.gradient(&nodal));
                point.add_forces(&product(&deformation, &point.stress(row)), forces);
            }
        });
    }

    /// `f ← G(u)ᵀ z(u)`: the elastic force \[N\], the gradient of the energy.
    pub fn force(&self, u: &[f64], f: &mut [f64]) {
        let u = self.expand(u);
        self.gather(f, |element, forces| {
            let nodal = self.nodal(&u, element);
            for point in self.points(element) {
                let gradient = point.gradient(&nodal);
                let stress = point.stress(&point.rows(&green(&gradient)));
                point.add_forces(&product(&deformation(&gradient), &stress), forces);
            }
        });
    }

    /// `m G(u)ᵀ G(u) + 2 E₂(·,·)ᵀ z`: the material part with the weight `m`, and the part that the stress of
    /// rows `z` adds. With `pulled`, compression is left out of that stress, so that the matrix is positive
    /// definite wherever `B` sees all motions.
    pub(crate) fn weighted_tangent(&self, u: &[f64], m: f64, z: &[f64], pulled: bool) -> SymmetricMatrix {
        assert_eq!(z.len(), self.n_rows());
        let u = self.expand(u);
        let mesh = self.model.mesh();
        let n = mesh.order().nodes_per_element();
        let elements: Vec<usize> = (0..mesh.element_count()).collect();
        let mut sums = vec![[0.0; 9]; self.graph.pairs()];
        let mut buffer = vec![[0.0; 9]; WAVE.min(elements.len()) * n * n];
        for wave in elements.chunks(WAVE) {
            parallel::for_each_of(buffer.chunks_mut(n * n).zip(wave), &|_, (blocks, &element)| {
                blocks.fill([0.0; 9]);
                let nodal = self.nodal(&u, element);
                for (point, row) in self.points(element).zip(self.rows_of(z, element)) {
                    let stress = point.stress(row);
                    let stress = if pulled { tensile(&stress) } else { stress };
                    point.add_tangent(&deformation(&point.gradient(&nodal)), m, &stress, n, blocks);
                }
                mirror(blocks, n);
            });
            for (blocks, &element) in buffer.chunks(n * n).zip(wave) {
                let nodes = mesh.element(element);
                for (a, &node) in nodes.iter().enumerate() {
                    for (b, &other) in nodes.iter().enumerate() {
                        let sum = &mut sums[self.graph.place(node, other)];
                        sum.iter_mut().zip(&blocks[a * n + b]).for_each(|(sum, x)| *sum += x);
                    }
                }
            }
        }
        let pattern = self.model.pencil().stiffness().pattern();
        blocks_over_free_dofs(&self.graph, self.model.dofs(), pattern, &sums)
    }

    /// The least principal stretch over the points of integration, with the sign of `det ∂x/∂X`: 1 at rest,
    /// and negative where an element is turned inside out, which the energy of St. Venant–Kirchhoff does not
    /// prevent. Below `SOFTENING` a bar that is compressed has less force, the more it is compressed.
    pub fn least_stretch(&self, u: &[f64]) -> f64 {
        let u = self.expand(u);
        let of_chunk = |chunk: usize| {
            let mut least = f64::INFINITY;
            for element in self.elements_of(chunk) {
                let nodal = self.nodal(&u, element);
                for point in self.points(element) {
                    let gradient = point.gradient(&nodal);
                    let [a, b, c] = deformation(&gradient);
                    let (strains, _) = principal(&green(&gradient));
                    let square = 1.0 + 2.0 * strains.into_iter().fold(f64::INFINITY, f64::min);
                    least = least.min(square.max(0.0).sqrt().copysign(dot(a, cross(b, c))));
                }
            }
            least
        };
        parallel::map(self.n_chunks(), &of_chunk).into_iter().fold(f64::INFINITY, f64::min)
    }

    fn n_chunks(&self) -> usize {
        (self.first.len() - 1).div_ceil(CHUNK)
    }

    fn elements_of(&self, chunk: usize) -> std::ops::Range<usize> {
        chunk * CHUNK..((chunk + 1) * CHUNK).min(self.first.len() - 1)
    }

    /// Displacements of all nodes.
    fn expand(&self, u: &[f64]) -> Vec<[f64; 3]> {
        let mut full = vec![[0.0; 3]; self.model.mesh().nodes.len()];
        self.model.dofs().expand_into(u, full.as_flattened_mut());
        full
    }

    fn nodal(&self, u: &[[f64; 3]], element: usize) -> Nodal {
        let mut nodal = [[0.0; 3]; TET_NODES];
        nodal.iter_mut().zip(self.model.mesh().element(element)).for_each(|(x, &node)| *x = u[node as usize]);
        nodal
    }

    /// The points of an element.
    fn points(&self, element: usize) -> impl Iterator<Item = ElementPoint<'_>> {
        let [[map, point], [next_map, next_point]] = [self.first[element], self.first[element + 1]];
        let mesh = self.model.mesh();
        let roots = self.roots[mesh.element_region[element] as usize];
        let count = next_point - point;
        let table = if count == self.straight.len() { &self.straight } else { &self.curved };
        let maps = &self.maps[map..next_map];
        let n = mesh.order().nodes_per_element();
        table.iter().enumerate().map(move |(k, point)| {
            let map = &maps[k.min(maps.len() - 1)];
            let root = map.root * point.root_weight;
            ElementPoint {
                gradients: &point.gradients[..n],
                inverse: &map.inverse,
                roots: roots.map(|x| root * x),
            }
        })
    }

    /// The rows of an element.
    fn rows_of<'z>(&self, z: &'z [f64], element: usize) -> &'z [[f64; ROWS]] {
        let rows = z.as_chunks::<ROWS>().0;
        &rows[self.first[element][1]..self.first[element + 1][1]]
    }

    /// Fills the rows of each element.
    fn fill_rows(&self, z: &mut [f64], task: impl Fn(usize, &mut [[f64; ROWS]]) + Sync) {
        assert_eq!(z.len(), self.n_rows());
        let mut rest = z.as_chunks_mut::<ROWS>().0;
        let mut chunks = Vec::with_capacity(self.n_chunks());
        for chunk in 0..self.n_chunks() {
            let elements = self.elements_of(chunk);
            let (own, others) =
                rest.split_at_mut(self.first[elements.end][1] - self.first[elements.start][1]);
            rest = others;
            chunks.push((elements, own));
        }
        parallel::for_each_of(chunks, &|_, (elements, mut rows)| {
            for element in elements {
                let (own, others) = rows.split_at_mut(self.first[element + 1][1] - self.first[element][1]);
                task(element, own);
                rows = others;
            }
        });
    }

    /// Sums what elements give to their nodes over the free dofs.
    fn gather(&self, f: &mut [f64], task: impl Fn(usize, &mut [[f64; 3]]) + Sync) {
        assert_eq!(f.len(), self.n_dof());
        let n = self.model.mesh().order().nodes_per_element();
        let mut forces = vec![[0.0; 3]; (self.first.len() - 1) * n];
        parallel::for_each_of(forces.chunks_mut(CHUNK * n), &|chunk, forces| {
            for (element, forces) in self.elements_of(chunk).zip(forces.chunks_mut(n)) {
                task(element, forces);
            }
        });
        let (starts, places) = &self.places;
        let free = self.model.dofs().dof_of_free();
        let chunks = f.chunks_mut(DOF_CHUNK).zip(free.chunks(DOF_CHUNK));
        parallel::for_each_of(chunks, &|_, (f, free)| {
            for (f, &dof) in f.iter_mut().zip(free) {
                let (node, c) = (dof as usize / 3, dof as usize % 3);
                *f = places[starts[node]..starts[node + 1]].iter().map(|&place| forces[place][c]).sum();
            }
        });
    }
}

/// An element at one of its points.
struct ElementPoint<'a> {
    gradients: &'a [[f64; 3]],
    inverse: &'a Tensor,
    /// `√(w det J)` times the roots of the moduli.
    roots: [f64; 2],
}

impl ElementPoint<'_> {
    /// `H`, `H_ij = ∂u_i/∂x_j`.
    fn gradient(&self, nodal: &Nodal) -> Tensor {
        let mut reference = [[0.0; 3]; 3];
        for (u, g) in nodal.iter().zip(self.gradients) {
            for i in 0..3 {
                for r in 0..3 {
                    reference[i][r] += u[i] * g[r];
                }
            }
        }
        product(&reference, self.inverse)
    }

    /// The weighted rows of a symmetric strain.
    fn rows(&self, e: &Tensor) -> [f64; ROWS] {
        let [bulk, shear] = self.roots;
        let (half, sixth) = (shear * std::f64::consts::FRAC_1_SQRT_2, shear * SIXTH);
        let twice = shear * std::f64::consts::SQRT_2;
        [
            bulk * (e[0][0] + e[1][1] + e[2][2]),
            half * (e[0][0] - e[1][1]),
            sixth * (2.0 * e[2][2] - e[0][0] - e[1][1]),
            twice * e[0][1],
            twice * e[1][2],
            twice * e[2][0],
        ]
    }

    /// The symmetric tensor `T` with `T : E = z · rows(E)` for all strains: of the rows of a strain its
    /// second Piola–Kirchhoff stress, times the weight of the point.
    fn stress(&self, z: &[f64; ROWS]) -> Tensor {
        let [bulk, shear] = self.roots;
        let (half, sixth) = (shear * std::f64::consts::FRAC_1_SQRT_2, shear * SIXTH);
        let (mean, plane, axial) = (bulk * z[0], half * z[1], sixth * z[2]);
        let [xy, yz, zx] = [half * z[3], half * z[4], half * z[5]];
        [[mean + plane - axial, xy, zx], [xy, mean - plane - axial, yz], [zx, yz, mean + 2.0 * axial]]
    }

    /// Adds `P ∇N_a` to each node, with `P` the weighted first Piola–Kirchhoff stress.
    fn add_forces(&self, p: &Tensor, forces: &mut [[f64; 3]]) {
        // P J⁻ᵀ, so that no gradient in space is needed.
        let reference: Tensor = p.map(|row| self.inverse.map(|j| dot(row, j)));
        for (f, g) in forces.iter_mut().zip(self.gradients) {
            for i in 0..3 {
                f[i] += dot(reference[i], *g);
            }
        }
    }

    /// Adds the blocks on and above the diagonal: with `g = ∇N` and `a = F g`,
    /// `m (λ a_a a_bᵀ + μ a_b a_aᵀ + μ (g_a·g_b) F Fᵀ) + (g_aᵀ T g_b) I`.
    fn add_tangent(&self, f: &Tensor, m: f64, stress: &Tensor, n: usize, blocks: &mut [[f64; 9]]) {
        let [bulk, shear] = self.roots.map(|x| m * x * x);
        let (mu, lambda) = (0.5 * shear, bulk - shear / 3.0);
        let mut g = [[0.0; 3]; TET_NODES];
        for (g, r) in g.iter_mut().zip(self.gradients) {
            *g = std::array::from_fn(|i| (0..3).map(|k| r[k] * self.inverse[k][i]).sum());
        }
        let turned: Nodal = g.map(|g| f.map(|row| dot(row, g)));
        let pulled: Nodal = g.map(|g| stress.map(|row| dot(row, g)));
        let left: Tensor = f.map(|row| f.map(|other| dot(row, other)));
        for a in 0..n {
            for b in a..n {
                let block = &mut blocks[a * n + b];
                let (shear, own) = (mu * dot(g[a], g[b]), dot(g[a], pulled[b]));
                for i in 0..3 {
                    for j in 0..3 {
                        block[3 * i + j] += lambda * turned[a][i] * turned[b][j]
                            + mu * turned[b][i] * turned[a][j]
                            + shear * left[i][j];
                    }
                    block[4 * i] += own;
                }
            }
        }
    }
}

const SIXTH: f64 = 0.408_248_290_463_863;

/// Places `element · nodes + local` of each node, in the order of the mesh.
fn places_of_nodes(model: &Model) -> (Vec<usize>, Vec<usize>) {
    let mesh = model.mesh();
    let n = mesh.order().nodes_per_element();
    let (starts, incident) = incident_elements(mesh);
    let mut places = Vec::with_capacity(incident.len());
    for node in 0..mesh.nodes.len() {
        for &element in &incident[starts[node]..starts[node + 1]] {
            let local = mesh.element(element as usize).iter().position(|&other| other as usize == node);
            places.push(element as usize * n + local.expect("an element at the node has the node"));
        }
    }
    (starts, places)
}

/// Copies the blocks above the diagonal below it, transposed: symmetric to the last bit.
fn mirror(blocks: &mut [[f64; 9]], n: usize) {
    for a in 0..n {
        for b in a..n {
            let block = blocks[a * n + b];
            let turned: [f64; 9] = std::array::from_fn(|k| {
                let (i, j) = (k / 3, k % 3);
                // In a diagonal block the upper triangle is the master.
                if a == b && i < j { block[k] } else { block[3 * j + i] }
            });
            blocks[b * n + a] = turned;
        }
    }
}

/// The part of a symmetric tensor with no negative principal value.
fn tensile(t: &Tensor) -> Tensor {
    let (values, axes) = principal(t);
    let mut out = [[0.0; 3]; 3];
    for k in 0..3 {
        for i in 0..3 {
            for j in 0..3 {
                out[i][j] += values[k].max(0.0) * axes[i][k] * axes[j][k];
            }
        }
    }
    out
}

/// Principal values and axes (as columns) by Jacobi's rotations.
fn principal(t: &Tensor) -> ([f64; 3], Tensor) {
    let (mut a, mut axes) = (*t, [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
    let size = a.as_flattened().iter().map(|x| x.abs()).fold(0.0, f64::max);
    // Each sweep squares what is left off the diagonal; five leave nothing that double precision shows.
    for _ in 0..8 {
        for [p, q] in [[0, 1], [1, 2], [0, 2]] {
            if a[p][q].abs() <= f64::EPSILON * size {
                continue;
            }
            let theta = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
            let tangent = theta.signum() / (theta.abs() + theta.hypot(1.0));
            let c = 1.0 / tangent.hypot(1.0);
            let s = tangent * c;
            for row in &mut a {
                (row[p], row[q]) = (c * row[p] - s * row[q], s * row[p] + c * row[q]);
            }
            let (from_p, from_q) = (a[p], a[q]);
            for k in 0..3 {
                (a[p][k], a[q][k]) = (c * from_p[k] - s * from_q[k], s * from_p[k] + c * from_q[k]);
            }
            for row in &mut axes {
                (row[p], row[q]) = (c * row[p] - s * row[q], s * row[p] + c * row[q]);
            }
        }
    }
    ([a[0][0], a[1][1], a[2][2]], axes)
}

/// `A B`.
fn product(a: &Tensor, b: &Tensor) -> Tensor {
    a.map(|row| std::array::from_fn(|j| row[0] * b[0][j] + row[1] * b[1][j] + row[2] * b[2][j]))
}

/// `Aᵀ B`.
fn transposed_product(a: &Tensor, b: &Tensor) -> Tensor {
    std::array::from_fn(|i| std::array::from_fn(|j| (0..3).map(|k| a[k][i] * b[k][j]).sum()))
}

/// `½ (A + Aᵀ)`.
fn symmetric(a: &Tensor) -> Tensor {
    std::array::from_fn(|i| std::array::from_fn(|j| 0.5 * (a[i][j] + a[j][i])))
}

fn scaled(a: &Tensor, factor: f64) -> Tensor {
    a.map(|row| row.map(|x| factor * x))
}

/// `F = I + H`.
fn deformation(h: &Tensor) -> Tensor {
    let mut f = *h;
    (0..3).for_each(|i| f[i][i] += 1.0);
    f
}

/// `½ (H + Hᵀ + HᵀH)`: no difference of large numbers at small displacements.
fn green(h: &Tensor) -> Tensor {
    let (small, square) = (symmetric(h), transposed_product(h, h));
    std::array::from_fn(|i| std::array::from_fn(|j| small[i][j] + 0.5 * square[i][j]))
}
