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
//! The energy is a polynomial of degree four in `H`. One point is exact for linear tetrahedra, fourteen
//! (degree 5, Walkington 2000) for straight quadratic ones; all other elements have the points of the linear
//! stiffness, so that the tangent at rest is the stiffness of the pencil, whatever the mesh. With mean
//! dilatation (Nagtegaal, Parks and Rice 1974) `tr E` is its mean over the element, at each of its points:
//! `z` is still quadratic, and no rotation strains. Hexahedra with incompatible modes or hourglass stiffness
//! are refused: inner functions that are eliminated are no polynomial of `u`.
//!
//! No matrix of `G` is stored: each product is a loop over elements. Kept are 80 bytes for a straight
//! tetrahedron, 80 for each point of another element, and lists of neighbours, some 300 bytes for a node of a
//! mesh of quadratic tetrahedra, 600 of 20-node hexahedra. Elements run in parallel and are added in the
//! order of the mesh, so the bytes are the same for any number of threads.

mod error;
mod point;
mod rule;
mod tensor;

use std::ops::Range;

pub use error::GreenError;
use point::{ElementPoint, ROWS, TangentRoom, add_mean_tangent, mirror};
use rule::StrainPoints;
use tensor::{deformation, green, principal, product, scaled, symmetric, tensile, transposed_product};

use super::assembly::{NodeGraph, blocks_over_free_dofs, incident_elements};
use super::material::Material;
use super::model::Model;
use super::sparse::SymmetricMatrix;
use crate::linalg::vec3::{cross, dot};
use crate::mesh::shapes::MAX_NODES;
use crate::parallel;

/// Elements that one parallel task handles.
const CHUNK: usize = 32;

/// Dofs that one parallel task sums the forces of.
const DOF_CHUNK: usize = 1024;

/// Elements whose tangents are held at a time, at most, and pairs of their nodes: 30 MB.
const WAVE: usize = 4096;
const WAVE_PAIRS: usize = WAVE * 100;

/// The stretch `1/√3`: a bar of St. Venant and Kirchhoff's law has its largest compressive force there.
pub(crate) const SOFTENING: f64 = 0.577_350_269_189_625_8;

/// Room for the displacements of an element's nodes.
type Nodal = [[f64; 3]; MAX_NODES];

/// The strain of a model's displacements.
#[doc(alias("Green-Lagrange strain", "St. Venant-Kirchhoff"))]
pub struct GreenStrain<'m> {
    model: &'m Model,
    points: StrainPoints,
    /// `√(λ + 2μ/3)` and `√(2μ)` of each region.
    roots: Vec<[f64; 2]>,
    /// For each node the places of its occurrences in the list of the elements' nodes, as offsets and list.
    places: (Vec<usize>, Vec<usize>),
    graph: NodeGraph,
}

impl<'m> GreenStrain<'m> {
    /// The strain field of a model.
    ///
    /// # Errors
    /// [`GreenError`]: a model without elements, a formulation that is more than a sum over points, a folded
    /// element, an anisotropic material.
    pub fn new(model: &'m Model) -> Result<GreenStrain<'m>, GreenError> {
        let mesh = model.mesh();
        if mesh.elements.is_empty() {
            return Err(GreenError::NoElements);
        }
        let points = StrainPoints::of(mesh)?;
        let root = |material: &Material| {
            let (lambda, mu) = material.lame()?;
            Some([(lambda + 2.0 / 3.0 * mu).sqrt(), (2.0 * mu).sqrt()])
        };
        let roots: Option<Vec<[f64; 2]>> = model.materials().iter().map(root).collect();
        Ok(GreenStrain {
            model,
            points,
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
        ROWS * self.points.before(self.points.n_elements())
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
            let (mut sum, mut room) = (0.0, [[0.0; 3]; MAX_NODES]);
            for element in self.elements_of(chunk) {
                let nodal = self.nodal(&u, element, &mut room);
                let row = |point: &ElementPoint<'_>| point.rows(&green(&point.gradient(nodal)));
                let mean = self.mean(element, |_, point| row(point)[0]);
                for point in self.points(element) {
                    let z = point.with_mean(row(&point), mean);
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
        self.fill_rows([u], z, |point, [u]| point.rows(&green(&point.gradient(u))));
    }

    /// `z ← B u`: the strain of small displacements.
    pub fn linear(&self, u: &[f64], z: &mut [f64]) {
        self.fill_rows([u], z, |point, [u]| point.rows(&symmetric(&point.gradient(u))));
    }

    /// `z ← E₂(u, v)`, symmetric: `z(u) = B u + E₂(u, u)`.
    pub(crate) fn bilinear(&self, u: &[f64], v: &[f64], z: &mut [f64]) {
        self.fill_rows([u, v], z, |point, [u, v]| {
            let product = transposed_product(&point.gradient(u), &point.gradient(v));
            point.rows(&scaled(&symmetric(&product), 0.5))
        });
    }

    /// `z ← G(u) v = B v + 2 E₂(u, v)`: the rate of strain of the velocity `v`.
    pub(crate) fn rate(&self, u: &[f64], v: &[f64], z: &mut [f64]) {
        self.fill_rows([u, v], z, |point, [u, v]| {
            let deformation = deformation(&point.gradient(u));
            point.rows(&symmetric(&transposed_product(&deformation, &point.gradient(v))))
        });
    }

    /// `f ← Bᵀ z`.
    pub(crate) fn linear_transpose(&self, z: &[f64], f: &mut [f64]) {
        assert_eq!(z.len(), self.n_rows());
        self.gather([], f, |element, [], forces| {
            for (point, row) in self.points_with_rows(z, element) {
                point.add_forces(&point.stress(&row), forces);
            }
        });
    }

    /// `f ← G(u)ᵀ z`.
    pub fn transpose(&self, u: &[f64], z: &[f64], f: &mut [f64]) {
        assert_eq!(z.len(), self.n_rows());
        self.gather([u], f, |element, [nodal], forces| {
            for (point, row) in self.points_with_rows(z, element) {
                let deformation = deformation(&point.gradient(nodal));
                point.add_forces(&product(&deformation, &point.stress(&row)), forces);
            }
        });
    }

    /// `f ← G(u)ᵀ z(u)`: the elastic force \[N\], the gradient of the energy.
    pub fn force(&self, u: &[f64], f: &mut [f64]) {
        self.gather([u], f, |element, [nodal], forces| {
            let mean = self.mean(element, |_, point| point.rows(&green(&point.gradient(nodal)))[0]);
            for point in self.points(element) {
                let gradient = point.gradient(nodal);
                let stress = point.stress(&point.with_mean(point.rows(&green(&gradient)), mean));
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
        let (mesh, count) = (self.model.mesh(), self.points.n_elements());
        let room = self.points.most_nodes().pow(2);
        let wave = (WAVE_PAIRS / room).clamp(1, WAVE);
        let mut sums = vec![[0.0; 9]; self.graph.pairs()];
        let mut buffer = vec![[0.0; 9]; wave.min(count) * room];
        for first in (0..count).step_by(wave) {
            let elements = first..count.min(first + wave);
            let chunks = elements.clone().step_by(CHUNK).zip(buffer.chunks_mut(CHUNK * room));
            parallel::for_each_of(chunks, &|_, (first, buffer)| {
                let mut rooms = (TangentRoom::new(), [[0.0; 3]; MAX_NODES], [[0.0; 3]; MAX_NODES]);
                for (element, blocks) in (first..elements.end).zip(buffer.chunks_mut(room)) {
                    self.element_tangent(element, (&u, z), (m, pulled), &mut rooms, blocks);
                }
            });
            for (element, blocks) in elements.zip(buffer.chunks(room)) {
                let nodes = mesh.element(element);
                for (a, &node) in nodes.iter().enumerate() {
                    for (b, &other) in nodes.iter().enumerate() {
                        let sum = &mut sums[self.graph.place(node, other)];
                        sum.iter_mut().zip(&blocks[a * nodes.len() + b]).for_each(|(sum, x)| *sum += x);
                    }
                }
            }
        }
        let pattern = self.model.pencil().stiffness().pattern();
        blocks_over_free_dofs(&self.graph, self.model.dofs(), pattern, &sums)
    }

    /// The blocks of one element, at displacements of all nodes.
    fn element_tangent(
        &self,
        element: usize,
        (u, z): (&[[f64; 3]], &[f64]),
        (m, pulled): (f64, bool),
        (room, nodal, sum): &mut (TangentRoom, Nodal, Nodal),
        blocks: &mut [[f64; 9]],
    ) {
        let nodal = self.nodal(u, element, nodal);
        let blocks = &mut blocks[..nodal.len().pow(2)];
        blocks.fill([0.0; 9]);
        let mut mean = self.points.has_mean(element).then(|| &mut sum[..nodal.len()]);
        if let Some(sum) = &mut mean {
            sum.fill([0.0; 3]);
        }
        for (point, row) in self.points_with_rows(z, element) {
            let stress = point.stress(&row);
            let stress = if pulled { tensile(&stress) } else { stress };
            let f = deformation(&point.gradient(nodal));
            point.add_tangent((&f, &stress, m), mean.as_deref_mut(), room, blocks);
        }
        if let Some(sum) = mean {
            let bulk: f64 = self.points(element).map(|point| point.roots[0] * point.roots[0]).sum();
            add_mean_tangent(sum, m / bulk, blocks);
        }
        mirror(blocks, nodal.len());
    }

    /// The least principal stretch over the points of integration, with the sign of `det ∂x/∂X`: 1 at rest,
    /// and negative where an element is turned inside out, which the energy of St. Venant–Kirchhoff does not
    /// prevent. Below `SOFTENING` a bar that is compressed has less force, the more it is compressed.
    pub fn least_stretch(&self, u: &[f64]) -> f64 {
        let u = self.expand(u);
        let of_chunk = |chunk: usize| {
            let (mut least, mut room) = (f64::INFINITY, [[0.0; 3]; MAX_NODES]);
            for element in self.elements_of(chunk) {
                let nodal = self.nodal(&u, element, &mut room);
                for point in self.points(element) {
                    let gradient = point.gradient(nodal);
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
        self.points.n_elements().div_ceil(CHUNK)
    }

    fn elements_of(&self, chunk: usize) -> Range<usize> {
        chunk * CHUNK..((chunk + 1) * CHUNK).min(self.points.n_elements())
    }

    /// Chunks of elements with their parts of a buffer; `size` is that of elements that follow each other.
    fn parted<'b, T>(
        &self,
        mut buffer: &'b mut [T],
        size: impl Fn(&Range<usize>) -> usize,
    ) -> Vec<(Range<usize>, &'b mut [T])> {
        let mut chunks = Vec::with_capacity(self.n_chunks());
        for elements in (0..self.n_chunks()).map(|chunk| self.elements_of(chunk)) {
            let (own, others) = buffer.split_at_mut(size(&elements));
            buffer = others;
            chunks.push((elements, own));
        }
        chunks
    }

    /// Displacements of all nodes.
    fn expand(&self, u: &[f64]) -> Vec<[f64; 3]> {
        let mut full = vec![[0.0; 3]; self.model.mesh().nodes.len()];
        self.model.dofs().expand_into(u, full.as_flattened_mut());
        full
    }

    /// Displacements of the nodes of an element.
    #[inline]
    fn nodal<'r>(&self, u: &[[f64; 3]], element: usize, room: &'r mut Nodal) -> &'r [[f64; 3]] {
        let nodes = self.model.mesh().element(element);
        let nodal = &mut room[..nodes.len()];
        nodal.iter_mut().zip(nodes).for_each(|(x, &node)| *x = u[node as usize]);
        nodal
    }

    /// The points of an element.
    #[inline]
    fn points(&self, element: usize) -> impl Iterator<Item = ElementPoint<'_>> {
        let region = self.model.mesh().element_region[element];
        self.points.of_element(element, self.roots[region as usize])
    }

    /// The mean volume strain of an element that has one, times `√(λ + 2μ/3)`, from the row of the volume
    /// strain at each point.
    #[inline]
    fn mean(&self, element: usize, row: impl Fn(usize, &ElementPoint<'_>) -> f64) -> Option<f64> {
        if !self.points.has_mean(element) {
            return None;
        }
        let (mut sum, mut square) = (0.0, 0.0);
        for (k, point) in self.points(element).enumerate() {
            sum += point.roots[0] * row(k, &point);
            square += point.roots[0] * point.roots[0];
        }
        Some(sum / square)
    }

    /// The points of an element with their rows; of the volume strain the mean, where the element has it.
    #[inline]
    fn points_with_rows(
        &self,
        z: &[f64],
        element: usize,
    ) -> impl Iterator<Item = (ElementPoint<'_>, [f64; ROWS])> {
        let rows = &z.as_chunks::<ROWS>().0[self.points.before(element)..self.points.before(element + 1)];
        let mean = self.mean(element, |k, _| rows[k][0]);
        self.points(element).zip(rows).map(move |(point, row)| {
            let row = point.with_mean(*row, mean);
            (point, row)
        })
    }

    /// Fills the rows of each element from displacements.
    fn fill_rows<const K: usize>(
        &self,
        fields: [&[f64]; K],
        z: &mut [f64],
        row: impl Fn(&ElementPoint<'_>, [&[[f64; 3]]; K]) -> [f64; ROWS] + Sync,
    ) {
        assert_eq!(z.len(), self.n_rows());
        let fields = fields.map(|u| self.expand(u));
        let size =
            |elements: &Range<usize>| self.points.before(elements.end) - self.points.before(elements.start);
        let chunks = self.parted(z.as_chunks_mut::<ROWS>().0, size);
        parallel::for_each_of(chunks, &|_, (elements, mut rows)| {
            let mut rooms = [[[0.0; 3]; MAX_NODES]; K];
            for element in elements {
                let nodal = self.nodal_of(&fields, element, &mut rooms);
                let (own, others) = rows.split_at_mut(size(&(element..element + 1)));
                let mean = self.mean(element, |_, point| row(point, nodal)[0]);
                for (point, z) in self.points(element).zip(own) {
                    *z = point.with_mean(row(&point, nodal), mean);
                }
                rows = others;
            }
        });
    }

    /// Those of several displacements.
    #[inline]
    fn nodal_of<'r, const K: usize>(
        &self,
        fields: &[Vec<[f64; 3]>; K],
        element: usize,
        rooms: &'r mut [Nodal; K],
    ) -> [&'r [[f64; 3]]; K] {
        let mut fields = fields.iter();
        rooms.each_mut().map(|room| self.nodal(fields.next().map_or(&[], Vec::as_slice), element, room))
    }

    /// Sums what elements give to their nodes, from displacements, over the free dofs.
    fn gather<const K: usize>(
        &self,
        fields: [&[f64]; K],
        f: &mut [f64],
        task: impl Fn(usize, [&[[f64; 3]]; K], &mut [[f64; 3]]) + Sync,
    ) {
        assert_eq!(f.len(), self.n_dof());
        let fields = fields.map(|u| self.expand(u));
        let mesh = self.model.mesh();
        let mut forces = vec![[0.0; 3]; mesh.elements.len()];
        let size = |elements: &Range<usize>| {
            mesh.kinds.range(elements.end - 1).end - mesh.kinds.range(elements.start).start
        };
        parallel::for_each_of(self.parted(&mut forces, size), &|_, (elements, mut forces)| {
            let mut rooms = [[[0.0; 3]; MAX_NODES]; K];
            for element in elements {
                let nodal = self.nodal_of(&fields, element, &mut rooms);
                let (own, others) = forces.split_at_mut(mesh.element(element).len());
                task(element, nodal, own);
                forces = others;
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

/// Places of each node in the list of the elements' nodes, in the order of the mesh.
fn places_of_nodes(model: &Model) -> (Vec<usize>, Vec<usize>) {
    let mesh = model.mesh();
    let (starts, incident) = incident_elements(mesh);
    let mut places = Vec::with_capacity(incident.len());
    for node in 0..mesh.nodes.len() {
        for &element in &incident[starts[node]..starts[node + 1]] {
            let element = element as usize;
            let local = mesh.element(element).iter().position(|&other| other as usize == node);
            let local = local.expect("an element at the node has the node");
            places.push(mesh.kinds.range(element).start + local);
        }
    }
    (starts, places)
}
