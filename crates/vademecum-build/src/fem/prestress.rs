//! Stiffness of a body about a static state: the part of its stress, and that of a rotation.
//!
//! With the stress `σ` of a static displacement, a motion about it has, beside the elastic stiffness, the
//! geometric one (Bathe, *Finite Element Procedures*, §6.3), and in a frame that rotates at the speed `ω`
//! about the axis `n` the centrifugal softening:
//!
//! ```text
//! K_σ,ab = ∫ (g_a · σ g_b) I dV,      K_ω,ab = −ω² ∫ ρ N_a N_b dV (I − n nᵀ)
//! ```
//!
//! Both are linear in the load case. The stress is taken where the stiffness is integrated. Incompatible
//! modes follow the nodes as they do in the elastic stiffness, `α = −K_αα⁻¹ K_αu u`, in the static
//! displacement and in the motion. Coriolis forces are left out. The stress is less that of a thermal strain,
//! which moves no incompatible mode where it is the same in all of an element.

use faer::Mat;

use super::element::ElementKernel;
use super::factor::Symbolic;
use super::factor_error::FactorError;
use super::heat::StrainAt;
use super::hexahedron::{InnerMap, follow, mean_gradients};
use super::material::{Law, LawAt, StressBlock, work};
use super::point::{ElementError, gradients, jacobian};
use super::sparse::SymmetricMatrix;
use crate::linalg::symmetric_part;
use crate::mesh::shapes::Point;

/// Static state of a body, about which it moves.
#[derive(Clone, Debug, Default)]
pub struct Prestress {
    /// Displacement over all dofs.
    pub displacement: Vec<f64>,
    /// Strain of each element that makes no stress; none at all where there is none.
    pub free: Vec<[[f64; 3]; 3]>,
    /// Rotations of the body or of parts of it.
    pub rotations: Vec<Rotation>,
    /// True if strains of a motion are those about the displaced body, `δE = sym (Fᵀ ∇δu)` with
    /// `F = I + ∇u`, as CalculiX takes them; false for `F = I`.
    pub displaced: bool,
}

/// Rotation at a constant speed.
#[derive(Clone, Debug)]
pub struct Rotation {
    /// The elements that rotate, ascending; absent: all.
    pub elements: Option<Vec<u32>>,
    /// Square of the angular velocity \[rad²/s²\].
    pub speed_squared: f64,
    /// A point of the axis \[m\].
    pub point: [f64; 3],
    /// Its direction, of length 1.
    pub axis: [f64; 3],
}

impl Rotation {
    /// The centrifugal acceleration at a place \[m/s²\].
    pub fn acceleration(&self, at: [f64; 3]) -> [f64; 3] {
        let arm: [f64; 3] = std::array::from_fn(|c| at[c] - self.point[c]);
        std::array::from_fn(|c| (0..3).map(|d| self.across(c, d) * arm[d]).sum())
    }

    /// `ω² (I − n nᵀ)`.
    fn across(&self, c: usize, d: usize) -> f64 {
        let own = if c == d { 1.0 } else { 0.0 };
        self.speed_squared * (own - self.axis[c] * self.axis[d])
    }

    /// True if it turns an element.
    fn turns(&self, element: u32) -> bool {
        self.elements.as_ref().is_none_or(|elements| elements.binary_search(&element).is_ok())
    }

    /// Subtracts the softening of a mass over three components for each function.
    pub(super) fn soften(&self, mass: &Mat<f64>, stiffness: &mut Mat<f64>) {
        for j in 0..mass.ncols() {
            for i in 0..mass.nrows() {
                let heavy = mass[(i - i % 3, j - j % 3)];
                stiffness[(i, j)] -= heavy * self.across(i % 3, j % 3);
            }
        }
    }
}

impl Prestress {
    /// Adds the stiffness of the state to that of an element; `dofs` are those of its matrices.
    pub(super) fn add_to(
        &self,
        (element, kernel, (law, strain)): (u32, &ElementKernel, (LawAt<'_>, StrainAt<'_>)),
        (nodes, dofs): (&[[f64; 3]], &[u32]),
        (mass, stiffness): (&Mat<f64>, &mut Mat<f64>),
    ) -> Result<(), ElementError> {
        let of = |dofs: &[u32; 3]| dofs.map(|dof| self.displacement[dof as usize]);
        let moved: Vec<[f64; 3]> = dofs.as_chunks::<3>().0.iter().map(of).collect();
        let own = self.free.get(element as usize).copied().unwrap_or_default();
        let free = |point: &Point| -> [[f64; 3]; 3] {
            let strain = strain(point);
            std::array::from_fn(|c| std::array::from_fn(|i| strain[c][i] + own[c][i]))
        };
        *stiffness += kernel.geometric_stiffness(nodes, (law, &free), &moved, self.displaced)?;
        let turning = self.rotations.iter().filter(|rotation| rotation.turns(element));
        turning.for_each(|rotation| rotation.soften(mass, stiffness));
        Ok(())
    }
}

impl ElementKernel {
    /// Stiffness that a static displacement `u` adds, over three components for each entry of `u`: the nodes,
    /// and behind them the inner functions of an element that keeps them.
    #[inline(never)]
    fn geometric_stiffness(
        &self,
        nodes: &[[f64; 3]],
        (law, free): (LawAt<'_>, StrainAt<'_>),
        u: &[[f64; 3]],
        displaced: bool,
    ) -> Result<Mat<f64>, ElementError> {
        let (n, rule) = (nodes.len(), self.stiffness_points(nodes));
        let inner = self.is_incompatible().then(|| InnerMap::new(nodes, u.len() == n)).transpose()?;
        let follow = match &inner {
            Some(_) if u.len() == n => Some(follow(rule, nodes, law)?),
            _ => None,
        };
        let mut moved = u.to_vec();
        if let Some(follow) = &follow {
            let of = |row: usize| (0..3 * n).map(|k| follow[(row, k)] * u[k / 3][k % 3]).sum();
            moved.extend((n..n + 3).map(|m| std::array::from_fn(|c| of(3 * m + c))));
        }
        let mean = self.has_mean_dilatation().then(|| mean_gradients(rule, nodes)).transpose()?;
        let mean = mean.map(|(whole, volume)| {
            let change = whole.iter().zip(u).map(|(g, u)| g[0] * u[0] + g[1] * u[1] + g[2] * u[2]);
            change.sum::<f64>() / volume
        });
        let mut sum = Mat::zeros(3 * moved.len(), 3 * moved.len());
        for point in rule {
            let (inverse, determinant) = jacobian(n, point, nodes)?;
            let mut g = gradients(n, point, &inverse)[..n].to_vec();
            g.extend(inner.iter().flat_map(|inner| inner.gradients(point, determinant)));
            let mut h = [[0.0; 3]; 3];
            for (u, g) in moved.iter().zip(&g) {
                (0..3).for_each(|c| (0..3).for_each(|i| h[c][i] += u[c] * g[i]));
            }
            let (law, free, h) = (law(point), free(point), strained(h, mean));
            let elastic: [[f64; 3]; 3] =
                std::array::from_fn(|c| std::array::from_fn(|i| h[c][i] - free[c][i]));
            let stress = law.stress(&elastic);
            add_point(&g, determinant * point.weight, (&law, stress), (h, displaced), &mut sum);
        }
        let sum = follow.map_or_else(|| sum.clone(), |follow| follow.transpose() * (&sum * &follow));
        Ok(symmetric_part(sum.as_ref()))
    }
}

/// Displacement gradients with the mean dilatation of the element in place of their own.
fn strained(mut h: [[f64; 3]; 3], mean: Option<f64>) -> [[f64; 3]; 3] {
    let own = h[0][0] + h[1][1] + h[2][2];
    let change = mean.map_or(0.0, |mean| (mean - own) / 3.0);
    (0..3).for_each(|c| h[c][c] += change);
    h
}

/// Adds a point of integration, of functions with gradients `g`.
#[inline(never)]
fn add_point(
    g: &[[f64; 3]],
    weight: f64,
    (law, stress): (&Law, [[f64; 3]; 3]),
    (h, displaced): ([[f64; 3]; 3], bool),
    sum: &mut Mat<f64>,
) {
    let stress = stress.map(|row| row.map(|s| weight * s));
    let [unit, turned] = [false, true].map(|turn| -> [[f64; 3]; 3] {
        std::array::from_fn(|c| {
            std::array::from_fn(|i| if c == i { 1.0 } else { 0.0 } + if turn { h[c][i] } else { 0.0 })
        })
    });
    for (b, q) in g.iter().enumerate() {
        let pull: [f64; 3] = std::array::from_fn(|i| (0..3).map(|j| stress[i][j] * q[j]).sum());
        for (a, p) in g.iter().enumerate() {
            let own = p[0] * pull[0] + p[1] * pull[1] + p[2] * pull[2];
            (0..3).for_each(|c| sum[(3 * a + c, 3 * b + c)] += own);
        }
        if !displaced {
            continue;
        }
        for (frame, sign) in [(&turned, weight), (&unit, -weight)] {
            let stress = law.stress_of(&strain_about(frame, *q), sign);
            for (a, &p) in g.iter().enumerate() {
                let block = work(&strain_about(frame, p), &stress);
                for c in 0..3 {
                    (0..3).for_each(|d| sum[(3 * a + c, 3 * b + d)] += block[c][d]);
                }
            }
        }
    }
}

/// Strain `sym (Fᵀ ∇u)`, with engineering shear, of `u = e_c N` for each component `c`, with `g = ∇N`.
fn strain_about(f: &[[f64; 3]; 3], [x, y, z]: [f64; 3]) -> StressBlock {
    let of = |of: fn([f64; 3], [f64; 3]) -> f64| f.map(|row| of(row, [x, y, z]));
    [
        of(|f, g| f[0] * g[0]),
        of(|f, g| f[1] * g[1]),
        of(|f, g| f[2] * g[2]),
        of(|f, g| f[0] * g[1] + f[1] * g[0]),
        of(|f, g| f[1] * g[2] + f[2] * g[1]),
        of(|f, g| f[2] * g[0] + f[0] * g[2]),
    ]
}

/// The factor on a load case at which a body buckles that buckles under the whole of it: `K + s K_σ` is
/// positive definite up to it, to a thousandth. `symbolic` is that of the loaded stiffness.
///
/// # Errors
/// [`FactorError`], other than of a matrix that is not positive definite.
///
/// # Panics
/// If the two stiffnesses do not have entries at the same places.
pub fn buckling_factor(
    symbolic: &Symbolic,
    unloaded: &SymmetricMatrix,
    loaded: &SymmetricMatrix,
) -> Result<f64, FactorError> {
    /// A body that buckles under less than this share of a load case has no use for the number.
    const LEAST: f64 = 1e-12;
    assert_eq!(unloaded.values().len(), loaded.values().len(), "one pattern");
    let stands = |share: f64| {
        let pairs = unloaded.values().iter().zip(loaded.values());
        let values = pairs.map(|(own, whole)| own + share * (whole - own)).collect();
        match symbolic.factorize(SymmetricMatrix::new(loaded.pattern().clone(), values)) {
            Ok(_) => Ok(true),
            Err(FactorError::NotPositiveDefinite { .. }) => Ok(false),
            Err(other) => Err(other),
        }
    };
    // Shares under which the matrix is definite are an interval from zero on.
    let (mut lower, mut upper) = (0.1, 1.0);
    while lower > LEAST && !stands(lower)? {
        (lower, upper) = (0.1 * lower, lower);
    }
    while upper > 1.001 * lower {
        let middle = (lower * upper).sqrt();
        if stands(middle)? { lower = middle } else { upper = middle }
    }
    Ok(lower)
}
