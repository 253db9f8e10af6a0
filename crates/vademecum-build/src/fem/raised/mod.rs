//! The space of one degree more on the same mesh, whose answers tell how far those of the mesh are off.
//!
//! The space of the mesh `V` is its leading block and the increment `W` of one degree follows
//! (hierarchical basis), so nothing is interpolated. Nothing is assembled either: products go element by
//! element. The preconditioner is the factor of the mesh's own stiffness beside 3 × 3 blocks of `W`:
//!
//! ```text
//! B r = ( K_VV⁻¹ r_V ,  D⁻¹ r_W )
//! ```

mod element;

use faer::{Mat, MatMut, MatRef};
use pulp::Arch;
use rayon::prelude::*;

use self::element::{LANES, Local, MAX_FUNCTIONS, RaisedKernel, increment};
use super::assembly::element_nodes;
use super::factor::{Factor, Solve};
use super::model::Model;
use super::sparse::{contiguous, contiguous_mut};
use crate::linalg::column_groups;
use crate::linalg::vec3::{norm, sub};
use crate::mesh::Order;
use crate::mesh::{EDGES, FACES};
use crate::parallel;

/// Elements whose products are computed before they are added up.
const WAVE: usize = 1024;
/// A held dof.
const HELD: u32 = u32::MAX;

/// A mesh with displacements of one degree more.
pub(crate) struct RaisedSpace<'a> {
    model: &'a Model,
    kernel: RaisedKernel,
    /// Edges, corners ascending, in ascending order; then the faces, likewise.
    edges: Vec<[u32; 2]>,
    faces: Vec<[u32; 3]>,
    /// For each element its functions of the increment.
    of_element: Vec<u32>,
    /// True where an element sees an odd edge function from its other end.
    turned: Vec<bool>,
    /// Row of each component of each function of the increment, or [`HELD`].
    rows: Vec<u32>,
    /// Inverse of the diagonal block of each function of the increment.
    inverses: Vec<[f64; 9]>,
    n: usize,
}

impl<'a> RaisedSpace<'a> {
    /// Numbers the functions. A function of the increment is held where all its corners are: then the held
    /// set is that of the mesh.
    pub(crate) fn new(model: &'a Model) -> Self {
        let mesh = model.mesh();
        let per = mesh.order().nodes_per_element();
        let elements = || mesh.elements.chunks_exact(per);
        let edges = distinct(elements().flat_map(|e| EDGES.map(|edge| ascending(edge.map(|i| e[i])))));
        let faces = match mesh.order() {
            Order::Linear => vec![],
            Order::Quadratic => {
                distinct(elements().flat_map(|e| FACES.map(|face| ascending(face.map(|i| e[i])))))
            }
        };
        let (mut of_element, mut turned) = (vec![], vec![]);
        for element in elements() {
            for edge in EDGES {
                let ends = edge.map(|i| element[i]);
                of_element.push(place(&edges, ascending(ends)) as u32);
                turned.push(mesh.order() == Order::Quadratic && ends[0] > ends[1]);
            }
            if mesh.order() == Order::Quadratic {
                for face in FACES {
                    let corners = ascending(face.map(|i| element[i]));
                    of_element.push((edges.len() + place(&faces, corners)) as u32);
                    turned.push(false);
                }
            }
        }
        let mut n = model.dofs().n_free();
        let held = |corners: &[u32], c: usize| {
            corners.iter().all(|&node| model.dofs().free(3 * node as usize + c).is_none())
        };
        let mut rows = vec![HELD; 3 * (edges.len() + faces.len())];
        let corners = edges.iter().map(|edge| &edge[..]).chain(faces.iter().map(|face| &face[..]));
        for (function, corners) in corners.enumerate() {
            for c in (0..3).filter(|&c| !held(corners, c)) {
                rows[3 * function + c] = n as u32;
                n += 1;
            }
        }
        let kernel = RaisedKernel::new(mesh.order());
        let mut space = Self { model, kernel, edges, faces, of_element, turned, rows, inverses: vec![], n };
        space.inverses = space.inverse_blocks();
        space
    }

    /// The order of the mesh, one below that of the displacements here.
    pub(crate) fn order(&self) -> Order {
        self.model.mesh().order()
    }

    /// Unknowns: those of the mesh come first.
    pub(crate) fn n(&self) -> usize {
        self.n
    }

    /// Unknowns of the mesh.
    pub(crate) fn n_given(&self) -> usize {
        self.model.dofs().n_free()
    }

    /// Mean length of the edges of all elements, corner to corner.
    pub(crate) fn mean_edge(&self) -> f64 {
        let nodes = &self.model.mesh().nodes;
        let length = |&[a, b]: &[u32; 2]| norm(sub(nodes[a as usize], nodes[b as usize]));
        self.edges.iter().map(length).sum::<f64>() / self.edges.len() as f64
    }

    /// The number of an edge's function, and whether the edge is seen from its other end.
    pub(crate) fn edge(&self, ends: [u32; 2]) -> (usize, bool) {
        let turned = self.model.mesh().order() == Order::Quadratic && ends[0] > ends[1];
        (place(&self.edges, ascending(ends)), turned)
    }

    /// The number of a face's function.
    pub(crate) fn face(&self, corners: [u32; 3]) -> usize {
        self.edges.len() + place(&self.faces, ascending(corners))
    }

    /// Adds a force at a function of the increment.
    pub(crate) fn add_at(&self, function: usize, force: [f64; 3], load: &mut [f64]) {
        for (&row, f) in self.rows[3 * function..].iter().zip(force) {
            if row != HELD {
                load[row as usize] += f;
            }
        }
    }

    /// `K x`, shape (n, columns).
    pub(crate) fn stiffness(&self, x: MatRef<'_, f64>) -> Mat<f64> {
        let mut out = Mat::zeros(self.n, x.ncols());
        self.add_products(x, &mut [(Product::Stiffness, out.as_mut())]);
        out
    }

    /// `K x` and `M x`, shape (n, columns).
    pub(crate) fn products(&self, x: MatRef<'_, f64>) -> [Mat<f64>; 2] {
        let mut out = [Mat::zeros(self.n, x.ncols()), Mat::zeros(self.n, x.ncols())];
        let [stiffness, mass] = &mut out;
        let wanted = &mut [(Product::Stiffness, stiffness.as_mut()), (Product::Mass, mass.as_mut())];
        self.add_products(x, wanted);
        out
    }

    /// `r ← B r`.
    pub(crate) fn precondition(&self, factor: &Factor, solve: &mut Solve, mut r: MatMut<'_, f64>) {
        let (n, columns) = (self.n_given(), r.ncols());
        let mut given = r.as_ref().subrows(0, n).to_owned();
        solve.solve_in_place(factor, given.as_mut());
        for column in 0..columns {
            let r = contiguous_mut(r.as_mut(), column);
            r[..n].copy_from_slice(given.col_as_slice(column));
            for (rows, inverse) in self.rows.as_chunks::<3>().0.iter().zip(&self.inverses) {
                let at = |c: usize| if rows[c] == HELD { 0.0 } else { r[rows[c] as usize] };
                let force = [at(0), at(1), at(2)];
                for i in (0..3).filter(|&i| rows[i] != HELD) {
                    r[rows[i] as usize] = (0..3).map(|j| inverse[3 * i + j] * force[j]).sum();
                }
            }
        }
    }

    /// Adds products, all threads, in one order.
    fn add_products(&self, x: MatRef<'_, f64>, wanted: &mut [(Product, MatMut<'_, f64>)]) {
        let (mesh, columns) = (self.model.mesh(), x.ncols());
        let groups = columns.div_ceil(LANES);
        let per = self.kernel.functions();
        let zero: Local = [[[0.0; LANES]; 3]; MAX_FUNCTIONS];
        let count = groups * wanted.len();
        let kinds: Vec<Product> = wanted.iter().map(|(kind, _)| *kind).collect();
        let mut results = vec![zero; WAVE.min(mesh.element_count()) * count];
        let arch = Arch::new();
        for first in (0..mesh.element_count()).step_by(WAVE) {
            let last = (first + WAVE).min(mesh.element_count());
            parallel::for_each_of(results.chunks_mut(count).zip(first..last), &|_, (results, element)| {
                let nodes = element_nodes(mesh, element as u32);
                let material = &self.model.materials()[mesh.element_region[element] as usize];
                let mut rows = [[HELD; 3]; MAX_FUNCTIONS];
                let signs = self.rows_of(element, &mut rows);
                for group in 0..groups {
                    let u = gather(x, group, &rows[..per], &signs);
                    for (kind, result) in kinds.iter().zip(&mut results[group * kinds.len()..]) {
                        arch.dispatch(
                            #[inline(always)]
                            || match kind {
                                Product::Stiffness => self.kernel.stiffness(&nodes, material, &u, result),
                                Product::Mass => self.kernel.mass(&nodes, material.density, &u, result),
                            },
                        );
                    }
                }
            });
            for (at, (_, out)) in wanted.iter_mut().enumerate() {
                parallel::for_each_of(column_groups(out.as_mut(), 1), &|column, out| {
                    let out = contiguous_mut(out, 0);
                    let place = (column / LANES) * kinds.len() + at;
                    for (element, results) in (first..last).zip(results.chunks_exact(count)) {
                        let mut rows = [[HELD; 3]; MAX_FUNCTIONS];
                        let signs = self.rows_of(element, &mut rows);
                        for ((rows, sign), sums) in rows.iter().zip(signs).zip(&results[place]).take(per) {
                            for (&row, sum) in rows.iter().zip(sums).filter(|(row, _)| **row != HELD) {
                                out[row as usize] += sign * sum[column % LANES];
                            }
                        }
                    }
                });
            }
        }
    }

    /// Rows of the components of an element's functions, and the sign with which the element sees each.
    fn rows_of(&self, element: usize, rows: &mut [[u32; 3]; MAX_FUNCTIONS]) -> [f64; MAX_FUNCTIONS] {
        let mesh = self.model.mesh();
        let (given, more) = (mesh.order().nodes_per_element(), increment(mesh.order()));
        for (rows, &node) in rows.iter_mut().zip(&mesh.elements[element * given..][..given]) {
            *rows = std::array::from_fn(|c| self.model.dofs().free(3 * node as usize + c).unwrap_or(HELD));
        }
        let mut signs = [1.0; MAX_FUNCTIONS];
        for (a, at) in (element * more..(element + 1) * more).enumerate() {
            let function = self.of_element[at] as usize;
            rows[given + a] = std::array::from_fn(|c| self.rows[3 * function + c]);
            if self.turned[at] {
                signs[given + a] = -1.0;
            }
        }
        signs
    }

    /// Inverses of the diagonal blocks of the increment. Where a component is held its row is left alone.
    fn inverse_blocks(&self) -> Vec<[f64; 9]> {
        let mesh = self.model.mesh();
        let more = increment(mesh.order());
        let mut blocks = vec![[0.0; 9]; self.rows.len() / 3];
        let mut of_element = vec![[0.0; 9]; more];
        for element in 0..mesh.element_count() {
            of_element.fill([0.0; 9]);
            let material = &self.model.materials()[mesh.element_region[element] as usize];
            self.kernel.add_diagonal(&element_nodes(mesh, element as u32), material, &mut of_element);
            for (block, &function) in of_element.iter().zip(&self.of_element[element * more..]) {
                for (sum, x) in blocks[function as usize].iter_mut().zip(block) {
                    *sum += x;
                }
            }
        }
        for (block, rows) in blocks.iter_mut().zip(self.rows.as_chunks::<3>().0) {
            for i in (0..3).filter(|&i| rows[i] == HELD) {
                for j in 0..3 {
                    (block[3 * i + j], block[3 * j + i]) = (0.0, 0.0);
                }
                block[4 * i] = 1.0;
            }
            *block = inverse(block);
        }
        blocks
    }
}

/// A product with a matrix of the body.
#[derive(Clone, Copy)]
enum Product {
    Stiffness,
    Mass,
}

/// Columns of a group at the functions of an element.
fn gather(x: MatRef<'_, f64>, group: usize, rows: &[[u32; 3]], signs: &[f64; MAX_FUNCTIONS]) -> Local {
    let mut u: Local = [[[0.0; LANES]; 3]; MAX_FUNCTIONS];
    let first = group * LANES;
    for k in 0..LANES.min(x.ncols() - first) {
        let x = contiguous(x, first + k);
        for ((u, rows), sign) in u.iter_mut().zip(rows).zip(signs) {
            for (u, &row) in u.iter_mut().zip(rows).filter(|(_, row)| **row != HELD) {
                u[k] = sign * x[row as usize];
            }
        }
    }
    u
}

fn ascending<const N: usize>(mut nodes: [u32; N]) -> [u32; N] {
    nodes.sort_unstable();
    nodes
}

fn distinct<const N: usize>(all: impl Iterator<Item = [u32; N]>) -> Vec<[u32; N]> {
    let mut all: Vec<_> = all.collect();
    all.par_sort_unstable();
    all.dedup();
    all
}

fn place<const N: usize>(all: &[[u32; N]], one: [u32; N]) -> usize {
    all.binary_search(&one).expect("every edge and face of an element is numbered")
}

/// The inverse of a symmetric positive definite 3 × 3 matrix.
fn inverse(a: &[f64; 9]) -> [f64; 9] {
    let minor = |i: usize, j: usize| {
        let at = |di: usize, dj: usize| a[3 * ((i + di) % 3) + (j + dj) % 3];
        at(1, 1) * at(2, 2) - at(1, 2) * at(2, 1)
    };
    let determinant: f64 = (0..3).map(|j| a[j] * minor(0, j)).sum();
    std::array::from_fn(|at| minor(at % 3, at / 3) / determinant)
}

#[cfg(test)]
mod tests;
