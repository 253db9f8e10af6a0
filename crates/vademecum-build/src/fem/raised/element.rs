//! One tetrahedron whose displacement has one degree more than its shape.
//!
//! The functions are those of the mesh (4 or 10 nodes) and the increment of one degree: `4 Lᵢ Lⱼ` on the six
//! edges of a linear element; `Lᵢ Lⱼ (Lᵢ − Lⱼ)` on the edges and `27 Lᵢ Lⱼ Lₖ` on the faces of a quadratic
//! one. The map stays that of the mesh, so that curved elements keep their shape.

use crate::fem::element::{ElementKernel, jacobian};
use crate::fem::material::{Law, Material};
use crate::mesh::Order;
use crate::mesh::rules::{rule_degree_2, rule_degree_5, rule_degree_6};
use crate::mesh::shapes::{Point, TET_NODES, tabulate_point};
use crate::mesh::{EDGES, FACES};

/// Right-hand sides handled at once.
pub(super) const LANES: usize = 4;
/// A number for each of them.
pub(super) type Lanes = [f64; LANES];
/// Most functions of an element: 20 of degree three.
pub(super) const MAX_FUNCTIONS: usize = 20;

/// A displacement at the functions of one element, component by component.
pub(super) type Local = [[Lanes; 3]; MAX_FUNCTIONS];

/// All functions at one quadrature point.
struct RaisedPoint {
    /// The functions of the mesh, which make the map.
    map: Point,
    weight: f64,
    values: [f64; MAX_FUNCTIONS],
    gradients: [[f64; 3]; MAX_FUNCTIONS],
}

/// Functions of all elements of one order, tabulated.
pub(super) struct RaisedKernel {
    given: ElementKernel,
    functions: usize,
    /// Exact for the stiffness of a straight element.
    straight: Vec<RaisedPoint>,
    /// For curved elements, stiffness and mass.
    curved: Vec<RaisedPoint>,
    /// `∫ N_a N_b` over the reference element, `functions × functions`.
    reference_mass: Vec<f64>,
}

/// Functions that one degree more adds to an element.
pub(super) fn increment(order: Order) -> usize {
    match order {
        Order::Linear => EDGES.len(),
        Order::Quadratic => EDGES.len() + FACES.len(),
    }
}

impl RaisedKernel {
    pub(super) fn new(order: Order) -> Self {
        let table = |rule: Vec<([f64; 4], f64)>| -> Vec<RaisedPoint> {
            rule.into_iter().map(|(l, weight)| tabulate(order, l, weight)).collect()
        };
        let functions = order.nodes_per_element() + increment(order);
        let straight = match order {
            Order::Linear => table(rule_degree_2()),
            Order::Quadratic => table(rule_degree_5()),
        };
        let curved = table(rule_degree_6());
        let mut reference_mass = vec![0.0; functions * functions];
        for point in &curved {
            for a in 0..functions {
                for b in 0..functions {
                    reference_mass[a * functions + b] += point.weight * (point.values[a] * point.values[b]);
                }
            }
        }
        Self { given: ElementKernel::tetrahedra(order), functions, straight, curved, reference_mass }
    }

    /// Functions of an element.
    pub(super) fn functions(&self) -> usize {
        self.functions
    }

    fn is_straight(&self, nodes: &[[f64; 3]]) -> bool {
        self.given.is_straight(&nodes[..self.given.n_nodes()])
    }

    fn map(&self, point: &RaisedPoint, nodes: &[[f64; 3]]) -> ([[f64; 3]; 3], f64) {
        jacobian(self.given.n_nodes(), &point.map, nodes).expect("the assembled mesh has no folded element")
    }

    /// `out ← K u`.
    #[inline(always)]
    pub(super) fn stiffness(
        &self,
        nodes: &[[f64; 3]; TET_NODES],
        material: &Material,
        u: &Local,
        out: &mut Local,
    ) {
        let law = material.law();
        let rule = if self.is_straight(nodes) { &self.straight } else { &self.curved };
        *out = [[[0.0; LANES]; 3]; MAX_FUNCTIONS];
        for point in rule {
            let (inverse, determinant) = self.map(point, nodes);
            let mut slopes = [[[0.0; LANES]; 3]; 3]; // [c][r] = ∂u_c/∂ξ_r
            for (u, gradient) in u.iter().zip(&point.gradients).take(self.functions) {
                for c in 0..3 {
                    for r in 0..3 {
                        for k in 0..LANES {
                            slopes[c][r][k] += u[c][k] * gradient[r];
                        }
                    }
                }
            }
            let pulled = pulled_stress(&slopes, &inverse, &law, determinant * point.weight);
            for (out, gradient) in out.iter_mut().zip(&point.gradients).take(self.functions) {
                for c in 0..3 {
                    for r in 0..3 {
                        for k in 0..LANES {
                            out[c][k] += pulled[c][r][k] * gradient[r];
                        }
                    }
                }
            }
        }
    }

    /// `out ← M u`.
    #[inline(always)]
    pub(super) fn mass(&self, nodes: &[[f64; 3]; TET_NODES], density: f64, u: &Local, out: &mut Local) {
        *out = [[[0.0; LANES]; 3]; MAX_FUNCTIONS];
        let n = self.functions;
        if self.is_straight(nodes) {
            let (_, determinant) = self.map(&self.straight[0], nodes);
            for (out, row) in out.iter_mut().zip(self.reference_mass.chunks_exact(n)) {
                add_combination(out, row, u, density * determinant);
            }
            return;
        }
        for point in &self.curved {
            let (_, determinant) = self.map(point, nodes);
            let mut value = [[0.0; LANES]; 3];
            add_combination(&mut value, &point.values[..n], u, density * determinant * point.weight);
            for (out, share) in out.iter_mut().zip(&point.values).take(n) {
                for c in 0..3 {
                    for k in 0..LANES {
                        out[c][k] += share * value[c][k];
                    }
                }
            }
        }
    }

    /// Adds the 3 × 3 diagonal blocks of the stiffness, row by row, of the functions of the increment.
    pub(super) fn add_diagonal(
        &self,
        nodes: &[[f64; 3]; TET_NODES],
        material: &Material,
        blocks: &mut [[f64; 9]],
    ) {
        let law = material.law();
        let rule = if self.is_straight(nodes) { &self.straight } else { &self.curved };
        let given = self.given.n_nodes();
        for point in rule {
            let (inverse, determinant) = self.map(point, nodes);
            let weight = determinant * point.weight;
            for (block, slope) in blocks.iter_mut().zip(&point.gradients[given..self.functions]) {
                let g: [f64; 3] =
                    std::array::from_fn(|i| (0..3).map(|r| slope[r] * inverse[r][i]).sum::<f64>());
                let own = law.block(g, g);
                block.iter_mut().zip(own.as_flattened()).for_each(|(sum, value)| *sum += weight * value);
            }
        }
    }
}

/// `out += scale Σ_b row_b u_b`.
#[inline(always)]
fn add_combination(out: &mut [Lanes; 3], row: &[f64], u: &Local, scale: f64) {
    let mut sum = [[0.0; LANES]; 3];
    for (u, share) in u.iter().zip(row) {
        for c in 0..3 {
            for k in 0..LANES {
                sum[c][k] += share * u[c][k];
            }
        }
    }
    for c in 0..3 {
        for k in 0..LANES {
            out[c][k] += scale * sum[c][k];
        }
    }
}

/// The stress of slopes along the reference axes, taken back to them and weighted.
#[inline(always)]
fn pulled_stress(
    slopes: &[[Lanes; 3]; 3],
    inverse: &[[f64; 3]; 3],
    law: &Law,
    weight: f64,
) -> [[Lanes; 3]; 3] {
    let mut h = [[[0.0; LANES]; 3]; 3]; // [c][i] = ∂u_c/∂x_i
    for c in 0..3 {
        for i in 0..3 {
            for k in 0..LANES {
                h[c][i][k] = (0..3).map(|r| slopes[c][r][k] * inverse[r][i]).sum();
            }
        }
    }
    let mut stress = [[[0.0; LANES]; 3]; 3];
    match *law {
        Law::Isotropic { lambda, mu } => {
            for c in 0..3 {
                for i in 0..3 {
                    for k in 0..LANES {
                        let volume =
                            if c == i { lambda * (h[0][0][k] + h[1][1][k] + h[2][2][k]) } else { 0.0 };
                        stress[c][i][k] = weight * (volume + mu * (h[c][i][k] + h[i][c][k]));
                    }
                }
            }
        }
        Law::Anisotropic(_) => {
            for k in 0..LANES {
                let one = law.stress(&h.map(|row| row.map(|lanes| lanes[k])));
                for c in 0..3 {
                    (0..3).for_each(|i| stress[c][i][k] = weight * one[c][i]);
                }
            }
        }
    }
    let mut pulled = [[[0.0; LANES]; 3]; 3];
    for c in 0..3 {
        for r in 0..3 {
            for k in 0..LANES {
                pulled[c][r][k] = (0..3).map(|i| stress[c][i][k] * inverse[r][i]).sum();
            }
        }
    }
    pulled
}

/// All functions and their reference derivatives at barycentric coordinates `l`.
fn tabulate(order: Order, l: [f64; 4], weight: f64) -> RaisedPoint {
    const D: [[f64; 3]; 4] = [[-1.0, -1.0, -1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let map = tabulate_point(order, l, weight);
    let n = order.nodes_per_element();
    let (mut values, mut gradients) = ([0.0; MAX_FUNCTIONS], [[0.0; 3]; MAX_FUNCTIONS]);
    values[..n].copy_from_slice(&map.values[..n]);
    gradients[..n].copy_from_slice(&map.gradients[..n]);
    for (e, [a, b]) in EDGES.into_iter().enumerate() {
        let (p, q) = (l[a], l[b]);
        let (value, of_a, of_b) = match order {
            Order::Linear => (4.0 * p * q, 4.0 * q, 4.0 * p),
            Order::Quadratic => (p * q * (p - q), 2.0 * p * q - q * q, p * p - 2.0 * p * q),
        };
        values[n + e] = value;
        gradients[n + e] = std::array::from_fn(|r| of_a * D[a][r] + of_b * D[b][r]);
    }
    if order == Order::Quadratic {
        for (f, [a, b, c]) in FACES.into_iter().enumerate() {
            let place = n + EDGES.len() + f;
            values[place] = 27.0 * l[a] * l[b] * l[c];
            gradients[place] = std::array::from_fn(|r| {
                27.0 * (l[b] * l[c] * D[a][r] + l[a] * l[c] * D[b][r] + l[a] * l[b] * D[c][r])
            });
        }
    }
    RaisedPoint { map, weight, values, gradients }
}
