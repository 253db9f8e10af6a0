//! Matrices of one tetrahedron, straight or curved, with 4 or 10 nodes.
//!
//! Isoparametric: position and displacement use the same shape functions `N_a` of the barycentric coordinates
//! `L_0…L_3`. With `g_a = ∇N_a` and the Lamé constants `λ, μ`, block `(a, b)` of the stiffness and entry
//! `(a, b)` of the mass are
//!
//! ```text
//! K_ab = ∫ λ g_a g_bᵀ + μ g_b g_aᵀ + μ (g_a·g_b) I dV,      m_ab = ∫ ρ N_a N_b dV
//! ```
//!
//! (Hughes, *The Finite Element Method*, §2.7 and §3.4). Straight elements are integrated exactly. The
//! stiffness of a curved element is a rational function that no rule meets; degree 6 is far past the degree 2
//! that keeps the order of convergence, and its mass comes out exact as long as the volume form is of
//! degree 2.

use serde::{Deserialize, Serialize};

use crate::linalg::vec3::cross;
use crate::mesh::Order;

/// Most nodes of an element.
pub(crate) const MAX_NODES: usize = 10;

/// The edges that carry the nodes 4 to 9 of a quadratic tetrahedron.
pub(crate) const EDGES: [[usize; 2]; 6] = [[0, 1], [1, 2], [2, 0], [0, 3], [1, 3], [2, 3]];

/// An isotropic linear elastic solid.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Material {
    /// Young's modulus, Pa.
    pub young: f64,
    /// Poisson's ratio, in (−1, ½).
    pub poisson: f64,
    /// Mass density, kg/m³.
    pub density: f64,
}

impl Material {
    /// Lamé constants `(λ, μ)`, Pa.
    pub(crate) fn lame(&self) -> (f64, f64) {
        let mu = self.young / (2.0 * (1.0 + self.poisson));
        (2.0 * mu * self.poisson / (1.0 - 2.0 * self.poisson), mu)
    }

    /// True if the three constants describe a solid: `E > 0`, `−1 < ν < ½`, `ρ > 0`, all finite.
    pub(crate) fn is_sound(&self) -> bool {
        let positive = |x: f64| x > 0.0 && x.is_finite();
        positive(self.young) && positive(self.density) && self.poisson > -1.0 && self.poisson < 0.5
    }
}

/// The volume form of an element is not positive everywhere.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "the map of the element folds over: its volume form is {determinant:e} at one of the quadrature points"
)]
pub struct ElementError {
    /// The first volume form found that is not positive, m³ per unit of reference volume.
    pub determinant: f64,
}

/// Shape functions at one quadrature point.
pub(super) struct Point {
    pub(crate) weight: f64,
    pub(crate) values: [f64; MAX_NODES],
    /// Derivatives along the reference axes `ξ = L_1, η = L_2, ζ = L_3`.
    pub(crate) gradients: [[f64; 3]; MAX_NODES],
}

/// Data common to all elements of one order.
pub(crate) struct ElementKernel {
    order: Order,
    /// Exact for the stiffness of a straight element.
    straight: Vec<Point>,
    /// For curved elements, stiffness and mass.
    curved: Vec<Point>,
    /// `∫ N_a N_b` over the reference element, row by row, `N × N`.
    reference_mass: Vec<f64>,
}

impl ElementKernel {
    /// Tabulates the shape functions.
    pub(crate) fn new(order: Order) -> ElementKernel {
        let tabulate = |rule: Vec<([f64; 4], f64)>| -> Vec<Point> {
            rule.into_iter().map(|(l, weight)| tabulate_point(order, l, weight)).collect()
        };
        let straight = match order {
            Order::Linear => tabulate(vec![([0.25; 4], 1.0 / 6.0)]),
            Order::Quadratic => tabulate(rule_degree_2()),
        };
        let curved = tabulate(rule_degree_6());
        let n = order.nodes_per_element();
        let mut reference_mass = vec![0.0; n * n];
        for point in &curved {
            for a in 0..n {
                for b in 0..n {
                    reference_mass[a * n + b] += point.weight * (point.values[a] * point.values[b]);
                }
            }
        }
        ElementKernel { order, straight, curved, reference_mass }
    }

    /// Nodes per element.
    pub(crate) fn n_nodes(&self) -> usize {
        self.order.nodes_per_element()
    }

    /// Mass `(N, N)` (one entry per pair of nodes, the same for each component), kg, row by row.
    pub(crate) fn mass_into(
        &self,
        nodes: &[[f64; 3]],
        density: f64,
        mass: &mut [f64],
    ) -> Result<(), ElementError> {
        let n = self.n_nodes();
        if self.is_straight(nodes) {
            let (_, determinant) = jacobian(n, &self.straight[0], nodes)?;
            for (out, &reference) in mass.iter_mut().zip(&self.reference_mass) {
                *out = density * determinant * reference;
            }
            return Ok(());
        }
        mass.fill(0.0);
        for point in &self.curved {
            let (_, determinant) = jacobian(n, point, nodes)?;
            let scale = density * determinant * point.weight;
            for a in 0..n {
                for b in 0..n {
                    // The pair first: the product is then symmetric to the last bit.
                    mass[a * n + b] += scale * (point.values[a] * point.values[b]);
                }
            }
        }
        Ok(())
    }

    /// Stiffness: `N × N` blocks of 3 × 3, N/m, block row by block row, each block row by row.
    pub(crate) fn stiffness_into(
        &self,
        nodes: &[[f64; 3]],
        material: &Material,
        stiffness: &mut [f64],
    ) -> Result<(), ElementError> {
        let n = self.n_nodes();
        let (lambda, mu) = material.lame();
        let rule = if self.is_straight(nodes) { &self.straight } else { &self.curved };
        stiffness.fill(0.0);
        for point in rule {
            let (inverse, determinant) = jacobian(n, point, nodes)?;
            let mut g = [[0.0; 3]; MAX_NODES];
            for a in 0..n {
                let r = point.gradients[a];
                g[a] = std::array::from_fn(|i| {
                    r[0] * inverse[0][i] + r[1] * inverse[1][i] + r[2] * inverse[2][i]
                });
            }
            let w = determinant * point.weight;
            for a in 0..n {
                for b in a..n {
                    let block = &mut stiffness[(a * n + b) * 9..][..9];
                    add_stiffness_block(block, g[a], g[b], w * lambda, w * mu);
                }
            }
        }
        mirror_blocks(stiffness, n);
        Ok(())
    }

    /// True if the map is affine: every mid-side node within 1e-10 of its edge's length from the middle, so
    /// that calling it affine moves nothing by more than that fraction.
    pub(super) fn is_straight(&self, nodes: &[[f64; 3]]) -> bool {
        if self.order == Order::Linear {
            return true;
        }
        EDGES.iter().enumerate().all(|(e, &[a, b])| {
            let (p, q, m) = (nodes[a], nodes[b], nodes[4 + e]);
            let off = (0..3).map(|i| (m[i] - 0.5 * (p[i] + q[i])).powi(2)).sum::<f64>();
            let length = (0..3).map(|i| (q[i] - p[i]).powi(2)).sum::<f64>();
            off <= 1e-20 * length
        })
    }
}

/// Adds one quadrature point to block `(a, b)`.
fn add_stiffness_block(block: &mut [f64], ga: [f64; 3], gb: [f64; 3], lambda: f64, mu: f64) {
    let shear = mu * (ga[0] * gb[0] + ga[1] * gb[1] + ga[2] * gb[2]);
    for i in 0..3 {
        for j in 0..3 {
            block[3 * i + j] += lambda * ga[i] * gb[j] + mu * ga[j] * gb[i];
        }
        block[4 * i] += shear;
    }
}

/// Copies the blocks above the diagonal below it, transposed: the element is symmetric to the last bit.
fn mirror_blocks(stiffness: &mut [f64], n: usize) {
    for a in 0..n {
        for b in 0..=a {
            for i in 0..3 {
                // In a diagonal block the upper triangle is the master.
                let first = if a == b { i + 1 } else { 0 };
                for j in first..3 {
                    let (upper, lower) = ((b * n + a) * 9, (a * n + b) * 9);
                    stiffness[lower + 3 * j + i] = stiffness[upper + 3 * i + j];
                }
            }
        }
    }
}

/// Inverse of the map's Jacobian, `inverse[r][i] = ∂ξ_r/∂x_i`, and its determinant (m³ per reference volume).
pub(super) fn jacobian(
    n: usize,
    point: &Point,
    nodes: &[[f64; 3]],
) -> Result<([[f64; 3]; 3], f64), ElementError> {
    let mut j = [[0.0; 3]; 3]; // j[r] = ∂x/∂ξ_r
    for a in 0..n {
        for r in 0..3 {
            for i in 0..3 {
                j[r][i] += point.gradients[a][r] * nodes[a][i];
            }
        }
    }
    let cofactors = [cross(j[1], j[2]), cross(j[2], j[0]), cross(j[0], j[1])];
    let determinant = (0..3).map(|i| j[0][i] * cofactors[0][i]).sum::<f64>();
    // Written so that a NaN is refused too.
    if !(determinant > 0.0 && determinant.is_finite()) {
        return Err(ElementError { determinant });
    }
    Ok((cofactors.map(|c| c.map(|x| x / determinant)), determinant))
}

/// Shape functions and their reference derivatives at barycentric coordinates `l`.
pub(super) fn tabulate_point(order: Order, l: [f64; 4], weight: f64) -> Point {
    // ∇L_0 … ∇L_3 along (ξ, η, ζ).
    const D: [[f64; 3]; 4] = [[-1.0, -1.0, -1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let mut point = Point { weight, values: [0.0; MAX_NODES], gradients: [[0.0; 3]; MAX_NODES] };
    for a in 0..4 {
        let (value, slope) = match order {
            Order::Linear => (l[a], 1.0),
            Order::Quadratic => (l[a] * (2.0 * l[a] - 1.0), 4.0 * l[a] - 1.0),
        };
        point.values[a] = value;
        point.gradients[a] = D[a].map(|d| slope * d);
    }
    if order == Order::Quadratic {
        for (e, &[a, b]) in EDGES.iter().enumerate() {
            point.values[4 + e] = 4.0 * l[a] * l[b];
            point.gradients[4 + e] = std::array::from_fn(|r| 4.0 * (l[b] * D[a][r] + l[a] * D[b][r]));
        }
    }
    point
}

/// Four points, exact for degree 2 (Hammer and Stroud 1956); weights sum to the volume 1/6.
pub(super) fn rule_degree_2() -> Vec<([f64; 4], f64)> {
    let b = (5.0 - 5.0_f64.sqrt()) / 20.0;
    orbit_4(1.0 - 3.0 * b, b, 1.0 / 24.0)
}

/// Fourteen points, exact for degree 5, all weights positive (Walkington 2000).
pub(super) fn rule_degree_5() -> Vec<([f64; 4], f64)> {
    let (inner, outer, edge) = (0.3108859192633005, 0.09273525031089122, 0.04550370412564965);
    let mut rule = orbit_4(1.0 - 3.0 * inner, inner, 0.018_781_320_953_002_64);
    rule.extend(orbit_4(1.0 - 3.0 * outer, outer, 0.012_248_840_519_393_66));
    for [i, j] in EDGES {
        let mut l = [edge; 4];
        (l[i], l[j]) = (0.5 - edge, 0.5 - edge);
        rule.push((l, 0.007_091_003_462_846_912));
    }
    rule
}

/// Twenty-four points, exact for degree 6, all weights positive (Keast 1986).
pub(crate) fn rule_degree_6() -> Vec<([f64; 4], f64)> {
    let mut rule = orbit_4(0.3561913862225449, 0.2146028712591517, 0.006_653_791_709_694_582);
    rule.extend(orbit_4(0.877_978_124_396_166, 0.0406739585346113, 0.001_679_535_175_886_774));
    rule.extend(orbit_4(0.0329863295731731, 0.3223378901422757, 0.009_226_196_923_942_453));
    let (pair, c, d) = (0.0636610018750175, 0.2696723314583159, 0.6030056647916491);
    for i in 0..4 {
        for j in (0..4).filter(|&j| j != i) {
            let mut l = [pair; 4];
            (l[i], l[j]) = (c, d);
            rule.push((l, 0.008_035_714_285_714_285));
        }
    }
    rule
}

/// The four points with one coordinate `a` and three `b`.
fn orbit_4(a: f64, b: f64, weight: f64) -> Vec<([f64; 4], f64)> {
    (0..4).map(|i| (std::array::from_fn(|j| if i == j { a } else { b }), weight)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `∫ L_1^p L_2^q L_3^s = p! q! s! / (p+q+s+3)!`.
    fn exact_monomial(p: u32, q: u32, s: u32) -> f64 {
        let factorial = |n: u32| (1..=n).map(f64::from).product::<f64>();
        factorial(p) * factorial(q) * factorial(s) / factorial(p + q + s + 3)
    }

    fn check_rule(rule: &[([f64; 4], f64)], degree: u32) {
        for p in 0..=degree {
            for q in 0..=degree - p {
                for s in 0..=degree - p - q {
                    let sum: f64 = rule
                        .iter()
                        .map(|(l, w)| w * l[1].powi(p as i32) * l[2].powi(q as i32) * l[3].powi(s as i32))
                        .sum();
                    // The rule's constants carry 16 digits; 24 terms of at most the weight 1/100 each.
                    assert!((sum - exact_monomial(p, q, s)).abs() < 24.0 * 1e-2 * 1e-15, "{p} {q} {s}");
                }
            }
        }
    }

    #[test]
    fn rules_integrate_all_monomials_of_their_degree() {
        check_rule(&rule_degree_2(), 2);
        check_rule(&rule_degree_5(), 5);
        check_rule(&rule_degree_6(), 6);
    }

    #[test]
    fn linear_mass_is_the_textbook_matrix() {
        let nodes = [[0.0; 3], [2.0, 0.0, 0.0], [0.0, 3.0, 0.0], [0.0, 0.0, 5.0]];
        let mut mass = [0.0; 16];
        ElementKernel::new(Order::Linear).mass_into(&nodes, 7.0, &mut mass).unwrap();
        let volume = 5.0;
        for a in 0..4 {
            for b in 0..4 {
                let expected = 7.0 * volume / 20.0 * if a == b { 2.0 } else { 1.0 };
                assert!((mass[4 * a + b] - expected).abs() < 1e-13 * expected);
            }
        }
    }

    #[test]
    fn curved_element_has_the_mass_of_its_volume() {
        // x → x + ε y² moves mid-side nodes off the middle but keeps the volume (unit Jacobian).
        let corners = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let mut nodes = corners.to_vec();
        nodes.extend(EDGES.map(|[a, b]| std::array::from_fn(|i| 0.5 * (corners[a][i] + corners[b][i]))));
        for node in &mut nodes {
            node[0] += 0.3 * node[1] * node[1];
        }
        let kernel = ElementKernel::new(Order::Quadratic);
        assert!(!kernel.is_straight(&nodes));
        let mut mass = vec![0.0; 100];
        kernel.mass_into(&nodes, 6.0, &mut mass).unwrap();
        assert!((mass.iter().sum::<f64>() - 1.0).abs() < 1e-13);
    }

    #[test]
    fn inverted_element_is_refused() {
        let nodes = [[0.0; 3], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]];
        let mut mass = [0.0; 16];
        let refused = ElementKernel::new(Order::Linear).mass_into(&nodes, 1.0, &mut mass);
        assert_eq!(refused, Err(ElementError { determinant: -1.0 }));
    }
}
