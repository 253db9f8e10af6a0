//! Formulations of the 8-node hexahedron beside full integration, which locks in bending.
//!
//! - *Incompatible modes* (Wilson, Taylor, Doherty and Ghaboussi 1973) add the functions `1 − ξ²`, `1 − η²`,
//!   `1 − ζ²` to each component of the displacement and eliminate them. Their gradients take the Jacobian of
//!   the centre (Taylor, Beresford and Wilson 1976), so that a distorted element passes the patch test.
//! - *Mean dilatation* (Nagtegaal, Parks and Rice 1974) takes the volume strain as its mean over the element.
//! - *Reduced* integrates at the centre and gives each hourglass mode, cleaned of linear displacements, a
//!   small stiffness (Flanagan and Belytschko 1981).

use faer::linalg::solvers::Solve;
use faer::{Mat, Side};

use super::material::{Law, LawAt, StressBlock, strain_block, work};
use super::point::{ElementError, add_block, add_stiffness, gradients, jacobian};
use crate::mesh::shapes::{CORNERS, MAX_NODES, Point};

/// Nodes.
const N: usize = 8;

/// Share of the largest stiffness of the element at its centre that an hourglass mode has.
const HOURGLASS: f64 = 0.05;

fn add_outer(stiffness: &mut [f64], a: usize, b: usize, g: [f64; 3], h: [f64; 3], factor: f64) {
    let block = &mut stiffness[(a * N + b) * 9..][..9];
    for i in 0..3 {
        for j in 0..3 {
            block[3 * i + j] += factor * g[i] * h[j];
        }
    }
}

/// Integral of the gradients over the element, and its volume.
pub(super) fn mean_gradients(
    rule: &[Point],
    nodes: &[[f64; 3]],
) -> Result<([[f64; 3]; N], f64), ElementError> {
    let (mut mean, mut volume) = ([[0.0; 3]; N], 0.0);
    for point in rule {
        let (inverse, determinant) = jacobian(N, point, nodes)?;
        let weight = determinant * point.weight;
        volume += weight;
        for (mean, g) in mean.iter_mut().zip(&gradients(N, point, &inverse)) {
            mean.iter_mut().zip(g).for_each(|(mean, g)| *mean += weight * g);
        }
    }
    Ok((mean, volume))
}

/// Adds the blocks on and above the diagonal of the stiffness of mean dilatation.
pub(super) fn mean_dilatation(
    rule: &[Point],
    nodes: &[[f64; 3]],
    law: LawAt<'_>,
    stiffness: &mut [f64],
) -> Result<(), ElementError> {
    let (mean, volume) = mean_gradients(rule, nodes)?;
    for point in rule {
        let (inverse, determinant) = jacobian(N, point, nodes)?;
        let g = gradients(N, point, &inverse);
        let weight = determinant * point.weight;
        let law = law(point);
        if let Law::Isotropic { mu, .. } = law {
            // The deviatoric part: λ = −2μ/3.
            add_stiffness(N, &g, weight, &Law::Isotropic { lambda: -2.0 / 3.0 * mu, mu }, stiffness);
            continue;
        }
        let strains: [StressBlock; N] = std::array::from_fn(|a| {
            let mut strain = strain_block(g[a]);
            for row in &mut strain[..3] {
                (0..3).for_each(|c| row[c] += (mean[a][c] / volume - g[a][c]) / 3.0);
            }
            strain
        });
        for b in 0..N {
            let stress = law.stress_of(&strains[b], weight);
            for a in 0..=b {
                add_block(&mut stiffness[(a * N + b) * 9..][..9], &work(&strains[a], &stress));
            }
        }
    }
    // An isotropic law is the same everywhere: an element of this kind has one temperature.
    if let Law::Isotropic { lambda, mu } = law(&rule[0]) {
        let bulk = lambda + 2.0 / 3.0 * mu;
        for a in 0..N {
            for b in a..N {
                add_outer(stiffness, a, b, mean[a], mean[b], bulk / volume);
            }
        }
    }
    Ok(())
}

/// Inner functions `1 − ξ²`, `1 − η²`, `1 − ζ²` of an element: stiffness over their nine components and of
/// these with the nodes, shape (9, 9) and (9, 24).
pub(super) struct InnerFunctions {
    pub(super) stiffness: Mat<f64>,
    pub(super) coupling: Mat<f64>,
    /// The volume form at the centre.
    centre: f64,
}

/// Place of a point of a rule: the map of the reference element onto itself.
fn place(point: &Point) -> [f64; 3] {
    std::array::from_fn(|i| CORNERS.iter().zip(&point.values).map(|(x, n)| x[i] * n).sum::<f64>())
}

/// The nodal blocks of full integration, on and above the diagonal, and the inner functions. Their gradients
/// take the Jacobian of the centre; `scaled` by the ratio of its determinant to that of the point, without
/// which a distorted element fails the patch test.
pub(super) fn with_inner_functions(
    rule: &[Point],
    nodes: &[[f64; 3]],
    (law, scaled): (LawAt<'_>, bool),
    stiffness: &mut [f64],
) -> Result<InnerFunctions, ElementError> {
    let map = InnerMap::new(nodes, scaled)?;
    let mut inner = Mat::<f64>::zeros(9, 9);
    let mut coupling = Mat::<f64>::zeros(9, 3 * N);
    for point in rule {
        let (inverse, determinant) = jacobian(N, point, nodes)?;
        let g = gradients(N, point, &inverse);
        let weight = determinant * point.weight;
        let law = law(point);
        add_stiffness(N, &g, weight, &law, stiffness);
        let h = map.gradients(point, determinant);
        for m in 0..3 {
            for (k, q) in h.iter().enumerate() {
                let block = law.block(h[m], *q);
                for i in 0..3 {
                    (0..3).for_each(|j| inner[(3 * m + i, 3 * k + j)] += weight * block[i][j]);
                }
            }
            for (b, &q) in g.iter().enumerate().take(N) {
                let block = law.block(h[m], q);
                for i in 0..3 {
                    (0..3).for_each(|j| coupling[(3 * m + i, 3 * b + j)] += weight * block[i][j]);
                }
            }
        }
    }
    Ok(InnerFunctions { stiffness: inner, coupling, centre: map.determinant })
}

/// The map of an element at its centre, which gradients of inner functions take.
pub(super) struct InnerMap {
    inverse: [[f64; 3]; 3],
    /// Volume form there.
    determinant: f64,
    /// Gradients are scaled by it over that of their place.
    scaled: bool,
}

impl InnerMap {
    pub(super) fn new(nodes: &[[f64; 3]], scaled: bool) -> Result<Self, ElementError> {
        let mut centre = Point { weight: 8.0, values: [0.125; MAX_NODES], gradients: [[0.0; 3]; MAX_NODES] };
        centre
            .gradients
            .iter_mut()
            .zip(CORNERS)
            .for_each(|(slope, corner)| *slope = corner.map(|x| 0.125 * x));
        let (inverse, determinant) = jacobian(N, &centre, nodes)?;
        Ok(Self { inverse, determinant, scaled })
    }

    /// Gradients of the inner functions at a point with this volume form.
    pub(super) fn gradients(&self, point: &Point, determinant: f64) -> [[f64; 3]; 3] {
        let at = place(point);
        let scale = if self.scaled { self.determinant / determinant } else { 1.0 };
        std::array::from_fn(|m| self.inverse[m].map(|slope| -2.0 * at[m] * scale * slope))
    }
}

impl InnerFunctions {
    /// `K_αα⁻¹ K_αu` over the components of the nodes, shape (9, 24): less this the inner functions carry no
    /// force.
    fn solved(&self) -> Result<Mat<f64>, ElementError> {
        self.answer(&self.coupling)
    }

    /// `K_αα⁻¹` times forces on the inner functions.
    pub(super) fn answer(&self, forces: &Mat<f64>) -> Result<Mat<f64>, ElementError> {
        // Positive definite: the inner functions have strains of their own.
        let factor = self.stiffness.llt(Side::Lower);
        factor.map(|factor| factor.solve(forces)).map_err(|_| ElementError { determinant: self.centre })
    }
}

/// Components of nodes and inner functions that follow the nodes, shape (33, 24).
pub(super) fn follow(rule: &[Point], nodes: &[[f64; 3]], law: LawAt<'_>) -> Result<Mat<f64>, ElementError> {
    let solved = with_inner_functions(rule, nodes, (law, true), &mut vec![0.0; 9 * N * N])?.solved()?;
    let unit = |i: usize, j: usize| if i == j { 1.0 } else { 0.0 };
    Ok(Mat::from_fn(33, 24, |i, j| if i < 24 { unit(i, j) } else { -solved[(i - 24, j)] }))
}

/// Mass of inner functions: of each pair, and of each with the nodes, the same for each component.
pub(super) type InnerMass = ([[f64; 3]; 3], [[f64; N]; 3]);

/// The mass of the inner functions for a density of 1.
pub(super) fn inner_mass(rule: &[Point], nodes: &[[f64; 3]]) -> Result<InnerMass, ElementError> {
    let (mut pairs, mut with_nodes) = ([[0.0; 3]; 3], [[0.0; N]; 3]);
    for point in rule {
        let functions = place(point).map(|x| 1.0 - x * x);
        let weight = jacobian(N, point, nodes)?.1 * point.weight;
        for m in 0..3 {
            (0..3).for_each(|k| pairs[m][k] += weight * functions[m] * functions[k]);
            (0..N).for_each(|a| with_nodes[m][a] += weight * functions[m] * point.values[a]);
        }
    }
    Ok((pairs, with_nodes))
}

/// The same of incompatible modes, which are eliminated.
pub(super) fn incompatible(
    rule: &[Point],
    nodes: &[[f64; 3]],
    law: LawAt<'_>,
    stiffness: &mut [f64],
) -> Result<(), ElementError> {
    let inner = with_inner_functions(rule, nodes, (law, true), stiffness)?;
    let lost = inner.coupling.transpose() * inner.solved()?;
    for a in 0..N {
        for b in a..N {
            let block = &mut stiffness[(a * N + b) * 9..][..9];
            for i in 0..3 {
                for j in 0..3 {
                    block[3 * i + j] -= lost[(3 * a + i, 3 * b + j)];
                }
            }
        }
    }
    Ok(())
}

/// The same of reduced integration with hourglass stiffness.
pub(super) fn reduced(
    rule: &[Point],
    nodes: &[[f64; 3]],
    law: LawAt<'_>,
    stiffness: &mut [f64],
) -> Result<(), ElementError> {
    let mut gradient = [[0.0; 3]; MAX_NODES];
    let (mut volume, mut normal) = (0.0, 0.0);
    for point in rule {
        let (inverse, determinant) = jacobian(N, point, nodes)?;
        gradient = gradients(N, point, &inverse);
        volume += determinant * point.weight;
        let law = law(point);
        normal = law.normal();
        add_stiffness(N, &gradient, determinant * point.weight, &law, stiffness);
    }
    let size: f64 = gradient[..N].iter().flatten().map(|g| g * g).sum();
    let scale = HOURGLASS * normal / 3.0 * volume * size / 8.0;
    let patterns: [fn([f64; 3]) -> f64; 4] =
        [|[x, y, _]| x * y, |[_, y, z]| y * z, |[x, _, z]| x * z, |[x, y, z]| x * y * z];
    for pattern in patterns {
        let hourglass = CORNERS.map(pattern);
        // Less what a linear displacement has of the pattern.
        let moment: [f64; 3] =
            std::array::from_fn(|i| (0..N).map(|a| hourglass[a] * nodes[a][i]).sum::<f64>());
        let gamma: [f64; N] =
            std::array::from_fn(|a| hourglass[a] - (0..3).map(|i| moment[i] * gradient[a][i]).sum::<f64>());
        for a in 0..N {
            for b in a..N {
                let block = &mut stiffness[(a * N + b) * 9..][..9];
                (0..3).for_each(|i| block[4 * i] += scale * gamma[a] * gamma[b]);
            }
        }
    }
    Ok(())
}
