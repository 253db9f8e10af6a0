//! Linear elastic materials: constants, and the law that elements integrate.
//!
//! Strains and stresses have the components xx, yy, zz, xy, yz, zx; shear strains of a stiffness are those of
//! engineers, `γ = 2 ε`. A stiffness along axes of its own is turned into those of space by
//! `C = Tᵀ C' T`, where `T` takes strains along the axes of space to those along its own (Ting, *Anisotropic
//! Elasticity*, 1996, §2.3).

use faer::Mat;
use serde::{Deserialize, Serialize};

use crate::linalg::vec3::{cross, dot, norm, sub};
use crate::linalg::{from_upper, symmetric_eigen, unit};
use crate::mesh::shapes::Point;

/// Rows and columns of the components of a symmetric tensor.
const PLACES: [[usize; 2]; 6] = [[0, 0], [1, 1], [2, 2], [0, 1], [1, 2], [2, 0]];

/// Component of the tensor in a row and a column.
const COMPONENT: [[usize; 3]; 3] = [[0, 3, 5], [3, 1, 4], [5, 4, 2]];

/// A matrix whose smallest eigenvalue is a smaller share of the largest is not positive definite.
const DEFINITE: f64 = 1e-12;

/// A linear elastic solid.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Material {
    /// Its elasticity.
    pub elasticity: Elasticity,
    /// Mass density, kg/m³.
    pub density: f64,
}

/// Constants of linear elasticity.
#[doc(alias("Hooke law", "constitutive law"))]
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Elasticity {
    /// The same in every direction.
    Isotropic {
        /// Young's modulus, Pa.
        young: f64,
        /// Poisson's ratio, in (−1, ½).
        poisson: f64,
    },
    /// Any.
    Anisotropic(Stiffness),
}

/// Stiffness of a solid \[Pa\] along the axes of space, `σ = C ε`, symmetric.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Stiffness(pub [[f64; 6]; 6]);

impl Stiffness {
    /// From its 21 constants, the upper triangle row by row.
    pub fn from_upper(constants: &[f64; 21]) -> Stiffness {
        let all = from_upper(constants, 6);
        Stiffness(std::array::from_fn(|i| std::array::from_fn(|j| all[(i, j)])))
    }

    /// From engineering constants along its own axes: Young's moduli `E₁ E₂ E₃`, Poisson's ratios
    /// `ν₁₂ ν₁₃ ν₂₃` (contraction along the second axis under a pull along the first), shear moduli
    /// `G₁₂ G₁₃ G₂₃`. `None`: they are those of no solid.
    pub fn orthotropic(young: [f64; 3], poisson: [f64; 3], shear: [f64; 3]) -> Option<Stiffness> {
        let [e1, e2, e3] = young;
        let [n12, n13, n23] = poisson;
        let mut compliance = [[0.0; 6]; 6];
        (compliance[0][0], compliance[1][1], compliance[2][2]) = (1.0 / e1, 1.0 / e2, 1.0 / e3);
        for (i, j, value) in [(0, 1, -n12 / e1), (0, 2, -n13 / e1), (1, 2, -n23 / e2)] {
            (compliance[i][j], compliance[j][i]) = (value, value);
        }
        let [g12, g13, g23] = shear;
        (compliance[3][3], compliance[4][4], compliance[5][5]) = (1.0 / g12, 1.0 / g23, 1.0 / g13);
        inverse(&compliance).map(Stiffness)
    }

    /// The same along the axes of space, of a stiffness along a first and a second axis, which need not be of
    /// length 1, and the axis normal to both.
    #[must_use]
    pub fn along(&self, axes: [[f64; 3]; 2]) -> Stiffness {
        let axes = right_handed(axes);
        // Strain along the axes: ε'_kl = Σ a_ki a_lj ε_ij, with engineering shear on both sides.
        let turn: [[f64; 6]; 6] = std::array::from_fn(|to| {
            let [k, l] = PLACES[to];
            let both = if k == l { 1.0 } else { 2.0 };
            std::array::from_fn(|from| {
                let [i, j] = PLACES[from];
                let product = axes[k][i] * axes[l][j];
                if i == j { both * product } else { 0.5 * both * (product + axes[k][j] * axes[l][i]) }
            })
        });
        let half: [[f64; 6]; 6] =
            std::array::from_fn(|i| std::array::from_fn(|j| (0..6).map(|k| self.0[i][k] * turn[k][j]).sum()));
        let whole = |i: usize, j: usize| -> f64 { (0..6).map(|k| turn[k][i] * half[k][j]).sum() };
        Stiffness(std::array::from_fn(|i| std::array::from_fn(|j| 0.5 * (whole(i, j) + whole(j, i)))))
    }

    /// The compliance `C⁻¹` \[1/Pa\]; `None` where it is not positive definite.
    pub fn compliance(&self) -> Option<[[f64; 6]; 6]> {
        inverse(&self.0)
    }

    /// True if every strain has a positive energy.
    pub fn is_definite(&self) -> bool {
        self.compliance().is_some()
    }
}

/// Inverse of a symmetric positive definite matrix, from its eigenvalues.
fn inverse(matrix: &[[f64; 6]; 6]) -> Option<[[f64; 6]; 6]> {
    if !matrix.as_flattened().iter().all(|value| value.is_finite()) {
        return None;
    }
    let (values, vectors) = symmetric_eigen(Mat::from_fn(6, 6, |i, j| matrix[i][j]).as_ref()).ok()?;
    let definite = values[0] > DEFINITE * values[5] && values[5].is_finite();
    let entry =
        |i: usize, j: usize| (0..6).map(|k| vectors[(i, k)] * vectors[(j, k)] / values[k]).sum::<f64>();
    definite.then(|| std::array::from_fn(|i| std::array::from_fn(|j| entry(i, j))))
}

impl Elasticity {
    /// The compliance \[1/Pa\], which takes a stress to the strain with engineering shear; `None` where the
    /// constants are those of no solid.
    pub fn compliance(&self) -> Option<[[f64; 6]; 6]> {
        match self {
            Elasticity::Isotropic { young, poisson } => Some(std::array::from_fn(|i| {
                std::array::from_fn(|j| match (i, j) {
                    _ if i != j && (i > 2 || j > 2) => 0.0,
                    _ if i > 2 => 2.0 * (1.0 + poisson) / young,
                    _ if i == j => 1.0 / young,
                    _ => -poisson / young,
                })
            })),
            Elasticity::Anisotropic(stiffness) => stiffness.compliance(),
        }
    }

    /// Young's modulus \[Pa\], the largest of those along the axes of space; NaN of no solid.
    pub fn modulus(&self) -> f64 {
        match self {
            Elasticity::Isotropic { young, .. } => *young,
            Elasticity::Anisotropic(stiffness) => stiffness
                .compliance()
                .map_or(f64::NAN, |compliance| (0..3).map(|i| 1.0 / compliance[i][i]).fold(0.0, f64::max)),
        }
    }
}

impl Material {
    /// An isotropic material of Young's modulus \[Pa\], Poisson's ratio, density \[kg/m³\].
    pub const fn isotropic(young: f64, poisson: f64, density: f64) -> Material {
        Material { elasticity: Elasticity::Isotropic { young, poisson }, density }
    }

    /// Lamé constants `(λ, μ)`, Pa, of an isotropic material.
    pub(crate) fn lame(&self) -> Option<(f64, f64)> {
        match self.elasticity {
            Elasticity::Isotropic { young, poisson } => Some(lame(young, poisson)),
            Elasticity::Anisotropic(_) => None,
        }
    }

    /// True if the constants describe a solid: `E > 0`, `−1 < ν < ½`, a positive definite stiffness, `ρ > 0`,
    /// all finite.
    pub(crate) fn is_sound(&self) -> bool {
        let positive = |x: f64| x > 0.0 && x.is_finite();
        let elastic = match &self.elasticity {
            Elasticity::Isotropic { young, poisson } => positive(*young) && *poisson > -1.0 && *poisson < 0.5,
            Elasticity::Anisotropic(stiffness) => stiffness.is_definite(),
        };
        elastic && positive(self.density)
    }

    /// As elements integrate it.
    pub(crate) fn law(&self) -> Law {
        match &self.elasticity {
            Elasticity::Isotropic { young, poisson } => {
                let (lambda, mu) = lame(*young, *poisson);
                Law::Isotropic { lambda, mu }
            }
            Elasticity::Anisotropic(stiffness) => Law::Anisotropic(*stiffness),
        }
    }
}

/// Lamé constants `(λ, μ)`, Pa.
fn lame(young: f64, poisson: f64) -> (f64, f64) {
    let mu = young / (2.0 * (1.0 + poisson));
    (2.0 * mu * poisson / (1.0 - 2.0 * poisson), mu)
}

/// Orthonormal axes: the first one, the second one made normal to it, and the third.
pub(crate) fn right_handed([first, second]: [[f64; 3]; 2]) -> [[f64; 3]; 3] {
    let first = unit(first);
    let third = unit(cross(first, second));
    [first, cross(third, first), third]
}

/// Stress of the displacement `u = e_c N` for each component `c`.
pub(crate) type StressBlock = [[f64; 3]; 6];

/// The law at a point of an element.
pub(crate) type LawAt<'a> = &'a dyn Fn(&Point) -> Law;

/// Axes that turn about a line: radial, tangential and along the line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cylinder {
    /// A point of the line.
    pub point: [f64; 3],
    /// Its direction, of any length.
    pub axis: [f64; 3],
}

impl Cylinder {
    /// The axes at a place; on the line, where every direction is radial, one of them is taken.
    pub fn axes(&self, at: [f64; 3]) -> [[f64; 3]; 3] {
        /// A share of the distance from the point below this is rounding.
        const ON_THE_LINE: f64 = 1e-9;
        let (axis, arm) = (unit(self.axis), sub(at, self.point));
        let along = dot(arm, axis);
        let radial: [f64; 3] = std::array::from_fn(|c| arm[c] - along * axis[c]);
        let least = (0..3).min_by(|&i, &j| axis[i].abs().total_cmp(&axis[j].abs())).unwrap_or(0);
        let any = || cross(axis, std::array::from_fn(|c| f64::from(u8::from(c == least))));
        let first = unit(if norm(radial) > ON_THE_LINE * norm(arm) { radial } else { any() });
        [first, cross(axis, first), axis]
    }
}

impl Law {
    /// The law at a place where its axes turn about a line; an isotropic one has none.
    pub(crate) fn about(self, cylinder: &Cylinder, at: [f64; 3]) -> Law {
        match self {
            Law::Anisotropic(own) => {
                let [first, second, _] = cylinder.axes(at);
                Law::Anisotropic(own.along([first, second]))
            }
            isotropic @ Law::Isotropic { .. } => isotropic,
        }
    }
}

/// Stress from strain, as elements integrate it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Law {
    /// `σ = λ tr ε I + 2 μ ε`.
    Isotropic {
        /// First Lamé constant, Pa.
        lambda: f64,
        /// Shear modulus, Pa.
        mu: f64,
    },
    /// `σ = C ε`.
    Anisotropic(Stiffness),
}

/// Strain, with engineering shear, of `u = e_c N` for each component `c`, with `g = ∇N`.
pub(crate) fn strain_block([x, y, z]: [f64; 3]) -> StressBlock {
    [[x, 0.0, 0.0], [0.0, y, 0.0], [0.0, 0.0, z], [y, x, 0.0], [0.0, z, y], [z, 0.0, x]]
}

/// `Aᵀ B` of two blocks, a row per component of the first.
pub(crate) fn work(strain: &StressBlock, stress: &StressBlock) -> [[f64; 3]; 3] {
    std::array::from_fn(|i| std::array::from_fn(|j| (0..6).map(|k| strain[k][i] * stress[k][j]).sum()))
}

impl Law {
    /// The stress of `u = e_c N` for each component `c`, with `g = ∇N`, times a weight.
    pub(crate) fn stress_block(&self, g: [f64; 3], weight: f64) -> StressBlock {
        match *self {
            Law::Isotropic { lambda, mu } => {
                let (lambda, mu) = (weight * lambda, weight * mu);
                let ([x, y, z], own, l) = (g, lambda + 2.0 * mu, lambda);
                [
                    [own * x, l * y, l * z],
                    [l * x, own * y, l * z],
                    [l * x, l * y, own * z],
                    [mu * y, mu * x, 0.0],
                    [0.0, mu * z, mu * y],
                    [mu * z, 0.0, mu * x],
                ]
            }
            Law::Anisotropic(_) => self.stress_of(&strain_block(g), weight),
        }
    }

    /// Stress of strains with engineering shear, column by column, times a weight.
    pub(crate) fn stress_of(&self, strain: &StressBlock, weight: f64) -> StressBlock {
        match *self {
            Law::Isotropic { lambda, mu } => std::array::from_fn(|i| {
                std::array::from_fn(|c| {
                    let trace = strain[0][c] + strain[1][c] + strain[2][c];
                    let own =
                        if i < 3 { lambda * trace + 2.0 * mu * strain[i][c] } else { mu * strain[i][c] };
                    weight * own
                })
            }),
            Law::Anisotropic(Stiffness(c)) => std::array::from_fn(|i| {
                std::array::from_fn(|j| weight * (0..6).map(|k| c[i][k] * strain[k][j]).sum::<f64>())
            }),
        }
    }

    /// Block of the stiffness of two functions with gradients `p` and `q`.
    pub(crate) fn block(&self, p: [f64; 3], q: [f64; 3]) -> [[f64; 3]; 3] {
        match *self {
            Law::Isotropic { lambda, mu } => {
                let shear = mu * (p[0] * q[0] + p[1] * q[1] + p[2] * q[2]);
                std::array::from_fn(|i| {
                    std::array::from_fn(|j| {
                        lambda * p[i] * q[j] + mu * p[j] * q[i] + if i == j { shear } else { 0.0 }
                    })
                })
            }
            Law::Anisotropic(_) => contract(p, &self.stress_block(q, 1.0)),
        }
    }

    /// Stress of displacement gradients `h[c][i] = ∂u_c/∂x_i`.
    #[inline(always)]
    pub(crate) fn stress(&self, h: &[[f64; 3]; 3]) -> [[f64; 3]; 3] {
        match self {
            Law::Isotropic { lambda, mu } => {
                let volume = lambda * (h[0][0] + h[1][1] + h[2][2]);
                std::array::from_fn(|c| {
                    std::array::from_fn(|i| (if c == i { volume } else { 0.0 }) + mu * (h[c][i] + h[i][c]))
                })
            }
            Law::Anisotropic(Stiffness(stiffness)) => {
                let strain = PLACES.map(|[i, j]| if i == j { h[i][i] } else { h[i][j] + h[j][i] });
                let stress = stiffness.map(|row| (0..6).map(|k| row[k] * strain[k]).sum::<f64>());
                std::array::from_fn(|c| std::array::from_fn(|i| stress[COMPONENT[c][i]]))
            }
        }
    }

    /// Stiffness against a strain along one direction, of all directions the mean (Voigt) \[Pa\].
    pub(crate) fn normal(&self) -> f64 {
        match self {
            Law::Isotropic { lambda, mu } => lambda + 2.0 * mu,
            Law::Anisotropic(Stiffness(c)) => {
                let own = c[0][0] + c[1][1] + c[2][2];
                let across = c[0][1] + c[0][2] + c[1][2];
                let (bulk, shear) =
                    ((own + 2.0 * across) / 9.0, (own - across + 3.0 * (c[3][3] + c[4][4] + c[5][5])) / 15.0);
                bulk + 4.0 / 3.0 * shear
            }
        }
    }
}

/// `Σ_k g_k σ_ik` of the stresses of each component: the block of a function with gradient `g`.
pub(crate) fn contract(g: [f64; 3], stress: &StressBlock) -> [[f64; 3]; 3] {
    std::array::from_fn(|i| std::array::from_fn(|j| (0..3).map(|k| g[k] * stress[COMPONENT[i][k]][j]).sum()))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Spruce: moduli \[Pa\] along the grain, radial, tangential.
    fn spruce() -> Stiffness {
        let found =
            Stiffness::orthotropic([11.6e9, 0.9e9, 0.5e9], [0.37, 0.42, 0.47], [0.75e9, 0.72e9, 39e6]);
        found.expect("a solid")
    }

    #[test]
    fn an_isotropic_solid_is_one_of_equal_constants() {
        let (young, poisson) = (2.1e11, 0.3);
        let shear = young / (2.0 * (1.0 + poisson));
        let found = Stiffness::orthotropic([young; 3], [poisson; 3], [shear; 3]).expect("a solid");
        let (lambda, mu) = Material::isotropic(young, poisson, 1.0).lame().expect("isotropic");
        let (same, law) = (Law::Isotropic { lambda, mu }, Law::Anisotropic(found));
        let (p, q) = ([0.3, -0.4, 0.7], [1.1, 0.2, -0.5]);
        let h = [[0.1, 0.2, -0.3], [0.4, -0.5, 0.6], [0.7, 0.8, 0.9]];
        let alike = |a: &[f64], b: &[f64]| {
            let most = a.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
            assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-12 * most), "{a:?} {b:?}");
        };
        alike(law.block(p, q).as_flattened(), same.block(p, q).as_flattened());
        alike(&[law.normal()], &[same.normal()]);
        alike(law.stress(&h).as_flattened(), same.stress(&h).as_flattened());
        alike(law.stress_block(p, 0.5).as_flattened(), same.stress_block(p, 0.5).as_flattened());
        let strain = strain_block(q);
        alike(law.stress_of(&strain, 2.0).as_flattened(), same.stress_of(&strain, 2.0).as_flattened());
        // Turning it changes nothing.
        let turned = found.along([[1.0, 2.0, -0.5], [0.0, 1.0, 3.0]]);
        alike(turned.0.as_flattened(), found.0.as_flattened());
        let [own, other] = [
            Elasticity::Isotropic { young, poisson }.compliance().expect("a solid"),
            found.compliance().expect("a solid"),
        ];
        alike(own.as_flattened(), other.as_flattened());
    }

    #[test]
    fn a_turned_stiffness_gives_the_turned_stress() {
        let (stiffness, axes) = (spruce(), [[1.0, 2.0, -0.5], [2.0, -1.0, 0.7]]);
        let [own, turned] = [stiffness, stiffness.along(axes)].map(|c| Law::Anisotropic(c).normal());
        assert!((turned / own - 1.0).abs() < 1e-12, "{own} {turned}");
        let first = unit(axes[0]);
        let third = unit(cross(first, axes[1]));
        let frame = [first, cross(third, first), third];
        let h = [[0.1, 0.2, -0.3], [0.4, -0.5, 0.6], [0.7, 0.8, 0.9]];
        // h' = A h Aᵀ, σ = Aᵀ σ' A.
        let product = |a: &[[f64; 3]; 3], b: &[[f64; 3]; 3]| -> [[f64; 3]; 3] {
            std::array::from_fn(|i| std::array::from_fn(|j| (0..3).map(|k| a[i][k] * b[k][j]).sum()))
        };
        let flipped: [[f64; 3]; 3] = std::array::from_fn(|i| std::array::from_fn(|j| frame[j][i]));
        let own = product(&product(&frame, &h), &flipped);
        let along = Law::Anisotropic(stiffness).stress(&own);
        let expected = product(&product(&flipped, &along), &frame);
        let found = Law::Anisotropic(stiffness.along(axes)).stress(&h);
        let pairs = found.as_flattened().iter().zip(expected.as_flattened());
        assert!(pairs.fold(0.0_f64, |most, (a, b)| most.max((a - b).abs())) < 1e-12 * 1.2e10);
    }

    #[test]
    fn constants_of_no_solid_are_refused() {
        // ν₁₂ above √(E₁/E₂).
        assert_eq!(Stiffness::orthotropic([1.0; 3], [1.1, 0.0, 0.0], [1.0; 3]), None);
        assert_eq!(Stiffness::orthotropic([1.0, -1.0, 1.0], [0.0; 3], [1.0; 3]), None);
        assert_eq!(Stiffness::orthotropic([f64::NAN, 1.0, 1.0], [0.0; 3], [1.0; 3]), None);
        let mut constants = [0.0; 21];
        [0, 6, 11, 15, 18, 20].into_iter().for_each(|k| constants[k] = 1.0);
        assert!(Stiffness::from_upper(&constants).is_definite());
        constants[1] = 1.0;
        assert!(!Stiffness::from_upper(&constants).is_definite());
        assert!(spruce().is_definite());
    }
}
