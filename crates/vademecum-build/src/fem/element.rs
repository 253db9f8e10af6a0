//! Matrices of one element of any kind.
//!
//! Isoparametric: position and displacement use the same shape functions `N_a`. With `g_a = ∇N_a`, the Lamé
//! constants `λ, μ` of an isotropic material, and the stiffness `C` and strains `B_a` of any other, block
//! `(a, b)` of the stiffness and entry `(a, b)` of the mass are
//!
//! ```text
//! K_ab = ∫ λ g_a g_bᵀ + μ g_b g_aᵀ + μ (g_a·g_b) I dV   or   ∫ B_aᵀ C B_b dV,      m_ab = ∫ ρ N_a N_b dV
//! ```
//!
//! (Hughes, *The Finite Element Method*, §2.7 and §3.4). Straight tetrahedra are integrated exactly. The
//! stiffness of a curved one is a rational function that no rule meets; degree 6 is far past the degree 2
//! that keeps the order of convergence, and its mass comes out exact as long as the volume form is of
//! degree 2. The rules of other kinds are those of common programs (`mesh::rules`); an 8-node hexahedron has
//! four formulations (`hexahedron`).

use faer::Mat;

use super::hexahedron::{incompatible, inner_mass, mean_dilatation, reduced, with_inner_functions};
use super::material::{LawAt, Material};
pub use super::point::ElementError;
pub(super) use super::point::{add_stiffness, gradients, jacobian};
use crate::mesh::rules::{mass_rule, rule_degree_2, rule_degree_5, rule_degree_6, stiffness_rule};
use crate::mesh::shapes::{Point, tabulate, tabulate_point};
use crate::mesh::{EDGES, ElementKind, Hexahedra, Order};

/// Data common to all elements of one kind and formulation.
pub(crate) struct ElementKernel {
    kind: ElementKind,
    /// Formulation of a hexahedron, or `Full`. Of tetrahedra, `Reduced` gives the stiffness the points of a
    /// straight one, and `ReducedMass` the mass too: one of 4 nodes, four of 10.
    hexahedra: Hexahedra,
    /// Exact for the stiffness of a straight tetrahedron, four points of a quadratic one; empty for other
    /// kinds.
    straight: Vec<Point>,
    /// Stiffness of curved tetrahedra and of other kinds.
    stiffness: Vec<Point>,
    /// Mass of curved tetrahedra and of other kinds.
    mass: Vec<Point>,
    /// `∫ N_a N_b` over the reference tetrahedron, row by row, `N × N`.
    reference_mass: Vec<f64>,
}

impl ElementKernel {
    /// Tabulates the shape functions. Without a formulation, 8-node hexahedra take incompatible modes and
    /// larger ones full integration.
    pub(crate) fn new(kind: ElementKind, hexahedra: Option<Hexahedra>) -> ElementKernel {
        let hexahedra = match (kind, hexahedra) {
            (ElementKind::Hex8, Some(Hexahedra::ReducedMass)) => Hexahedra::Reduced,
            (ElementKind::Hex8, given) => given.unwrap_or(Hexahedra::Incompatible),
            (
                ElementKind::Hex20 | ElementKind::Tet4 | ElementKind::Tet10,
                Some(few @ (Hexahedra::Reduced | Hexahedra::ReducedMass)),
            ) => few,
            _ => Hexahedra::Full,
        };
        let table = |rule: Vec<([f64; 3], f64)>| -> Vec<Point> {
            rule.into_iter().map(|(at, weight)| tabulate(kind, at, weight)).collect()
        };
        if !kind.is_tetrahedron() {
            let few = matches!(hexahedra, Hexahedra::Reduced | Hexahedra::ReducedMass);
            let stiffness = table(stiffness_rule(kind, few));
            let same = hexahedra == Hexahedra::ReducedMass;
            let mass = table(if same { stiffness_rule(kind, few) } else { mass_rule(kind) });
            return Self { kind, hexahedra, straight: vec![], stiffness, mass, reference_mass: vec![] };
        }
        let order = kind.order();
        let tabulate = |rule: Vec<([f64; 4], f64)>| -> Vec<Point> {
            rule.into_iter().map(|(l, weight)| tabulate_point(order, l, weight)).collect()
        };
        let straight = match order {
            Order::Linear => tabulate(vec![([0.25; 4], 1.0 / 6.0)]),
            Order::Quadratic => tabulate(rule_degree_2()),
        };
        let [stiffness, mass] = [(); 2].map(|()| tabulate(rule_degree_6()));
        let n = kind.nodes();
        let mut reference_mass = vec![0.0; n * n];
        for point in &mass {
            for a in 0..n {
                for b in 0..n {
                    reference_mass[a * n + b] += point.weight * (point.values[a] * point.values[b]);
                }
            }
        }
        Self { kind, hexahedra, straight, stiffness, mass, reference_mass }
    }

    /// That of tetrahedra.
    pub(crate) fn tetrahedra(order: Order) -> ElementKernel {
        Self::new(order.into(), None)
    }

    /// Nodes per element.
    pub(crate) fn n_nodes(&self) -> usize {
        self.kind.nodes()
    }

    /// Mass `(N, N)` (one entry per pair of nodes, the same for each component), kg, row by row.
    pub(crate) fn mass_into(
        &self,
        nodes: &[[f64; 3]],
        density: f64,
        mass: &mut [f64],
    ) -> Result<(), ElementError> {
        let n = self.n_nodes();
        let few = self.kind.is_tetrahedron() && self.hexahedra == Hexahedra::ReducedMass;
        if !few && self.is_straight(nodes) {
            let (_, determinant) = jacobian(n, &self.straight[0], nodes)?;
            for (out, &reference) in mass.iter_mut().zip(&self.reference_mass) {
                *out = density * determinant * reference;
            }
            return Ok(());
        }
        mass.fill(0.0);
        for point in if few { &self.straight } else { &self.mass } {
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
        let law = material.law();
        self.stiffness_by(nodes, &|_| law, stiffness)
    }

    /// The same of a law that depends on the point.
    pub(crate) fn stiffness_by(
        &self,
        nodes: &[[f64; 3]],
        law: LawAt<'_>,
        stiffness: &mut [f64],
    ) -> Result<(), ElementError> {
        let n = self.n_nodes();
        let rule = self.stiffness_points(nodes);
        stiffness.fill(0.0);
        match (self.kind, self.hexahedra) {
            (ElementKind::Hex8, Hexahedra::Incompatible) => incompatible(rule, nodes, law, stiffness)?,
            (ElementKind::Hex8, Hexahedra::MeanDilatation) => mean_dilatation(rule, nodes, law, stiffness)?,
            (ElementKind::Hex8, Hexahedra::Reduced) => reduced(rule, nodes, law, stiffness)?,
            _ => {
                for point in rule {
                    let (inverse, determinant) = jacobian(n, point, nodes)?;
                    let g = gradients(n, point, &inverse);
                    add_stiffness(n, &g, determinant * point.weight, &law(point), stiffness);
                }
            }
        }
        mirror_blocks(stiffness, n);
        Ok(())
    }

    /// Stiffness and mass of an 8-node hexahedron whose incompatible modes are kept as CalculiX has them,
    /// shape (33, 33): 24 components of the nodes, nine of the inner functions, whose gradients are not
    /// scaled.
    pub(crate) fn with_inner_functions(
        &self,
        nodes: &[[f64; 3]],
        law: LawAt<'_>,
        density: f64,
    ) -> Result<[Mat<f64>; 2], ElementError> {
        let mut blocks = vec![0.0; 9 * 64];
        let inner = with_inner_functions(&self.stiffness, nodes, (law, false), &mut blocks)?;
        mirror_blocks(&mut blocks, 8);
        let mut mass = vec![0.0; 64];
        self.mass_into(nodes, density, &mut mass)?;
        // The rule of the stiffness, as the program that keeps them has it.
        let (pairs, with_nodes) = inner_mass(&self.stiffness, nodes)?;
        let stiffness = Mat::from_fn(33, 33, |i, j| match (i < 24, j < 24) {
            (true, true) => blocks[(i / 3 * 8 + j / 3) * 9 + 3 * (i % 3) + j % 3],
            (true, false) => inner.coupling[(j - 24, i)],
            (false, true) => inner.coupling[(i - 24, j)],
            (false, false) => inner.stiffness[(i - 24, j - 24)],
        });
        let mass = Mat::from_fn(33, 33, |i, j| match (i < 24, j < 24) {
            _ if i % 3 != j % 3 => 0.0,
            (true, true) => mass[i / 3 * 8 + j / 3],
            (true, false) => density * with_nodes[j / 3 - 8][i / 3],
            (false, true) => density * with_nodes[i / 3 - 8][j / 3],
            (false, false) => density * pairs[i / 3 - 8][j / 3 - 8],
        });
        Ok([stiffness, mass])
    }

    /// Points of integration of the stiffness.
    pub(super) fn stiffness_points(&self, nodes: &[[f64; 3]]) -> &[Point] {
        self.points(self.is_straight(nodes))
    }

    fn points(&self, straight: bool) -> &[Point] {
        let few = self.kind == ElementKind::Tet10 && self.hexahedra != Hexahedra::Full;
        if few || straight { &self.straight } else { &self.stiffness }
    }

    /// Points of integration of the energy of large displacements: those of the stiffness, so that both agree
    /// at rest. A straight 10-node tetrahedron, whose stiffness needs fewer, has those that are exact for a
    /// polynomial of degree four.
    pub(super) fn strain_points(&self, straight: bool) -> Vec<Point> {
        if straight && self.kind == ElementKind::Tet10 {
            let points = rule_degree_5().into_iter();
            return points.map(|(l, weight)| tabulate_point(Order::Quadratic, l, weight)).collect();
        }
        self.points(straight).to_vec()
    }

    /// The formulation of an 8-node hexahedron whose stiffness has more than displacements of its nodes at
    /// its points: inner functions, or a stiffness against hourglass modes.
    pub(super) fn more_than_points(&self) -> Option<Hexahedra> {
        let more = matches!(self.hexahedra, Hexahedra::Incompatible | Hexahedra::Reduced);
        (self.kind == ElementKind::Hex8 && more).then_some(self.hexahedra)
    }

    /// True if the volume strain is its mean over the element.
    pub(super) fn has_mean_dilatation(&self) -> bool {
        self.kind == ElementKind::Hex8 && self.hexahedra == Hexahedra::MeanDilatation
    }

    /// True of a hexahedron of 20 nodes with all points of integration.
    pub(super) fn is_full_hexahedron(&self) -> bool {
        self.kind == ElementKind::Hex20 && self.hexahedra == Hexahedra::Full
    }

    /// True if incompatible modes are eliminated.
    pub(crate) fn is_incompatible(&self) -> bool {
        self.kind == ElementKind::Hex8 && self.hexahedra == Hexahedra::Incompatible
    }

    /// True if the map is affine: every mid-side node within 1e-10 of its edge's length from the middle, so
    /// that calling it affine moves nothing by more than that fraction.
    pub(super) fn is_straight(&self, nodes: &[[f64; 3]]) -> bool {
        match self.kind {
            ElementKind::Tet4 => return true,
            ElementKind::Tet10 => {}
            _ => return false,
        }
        EDGES.iter().enumerate().all(|(e, &[a, b])| {
            let (p, q, m) = (nodes[a], nodes[b], nodes[4 + e]);
            let off = (0..3).map(|i| (m[i] - 0.5 * (p[i] + q[i])).powi(2)).sum::<f64>();
            let length = (0..3).map(|i| (q[i] - p[i]).powi(2)).sum::<f64>();
            off <= 1e-20 * length
        })
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn linear_mass_is_the_textbook_matrix() {
        let nodes = [[0.0; 3], [2.0, 0.0, 0.0], [0.0, 3.0, 0.0], [0.0, 0.0, 5.0]];
        let mut mass = [0.0; 16];
        ElementKernel::tetrahedra(Order::Linear).mass_into(&nodes, 7.0, &mut mass).unwrap();
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
        let kernel = ElementKernel::tetrahedra(Order::Quadratic);
        assert!(!kernel.is_straight(&nodes));
        let mut mass = vec![0.0; 100];
        kernel.mass_into(&nodes, 6.0, &mut mass).unwrap();
        assert!((mass.iter().sum::<f64>() - 1.0).abs() < 1e-13);
    }

    #[test]
    fn inverted_element_is_refused() {
        let nodes = [[0.0; 3], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]];
        let mut mass = [0.0; 16];
        let refused = ElementKernel::tetrahedra(Order::Linear).mass_into(&nodes, 1.0, &mut mass);
        assert_eq!(refused, Err(ElementError { determinant: -1.0 }));
    }
}
