//! Temperatures of a body, and the thermal strain that they ask for.
//!
//! A material expands by mean coefficients `α` from a temperature `T_z` on. With its initial temperature
//! `T_0` the strain without stress is `ε_T = α(T) (T − T_z) − α(T_0) (T_0 − T_z)`.

use super::element::ElementKernel;
use super::material::{Elasticity, Stiffness, right_handed};
use crate::mesh::ElementKind;
use crate::mesh::shapes::{MAX_NODES, Point};

/// A symmetric tensor along the axes of space.
pub(crate) type Tensor = [[f64; 3]; 3];

/// The thermal strain at a point of an element.
pub(super) type StrainAt<'a> = &'a dyn Fn(&Point) -> Tensor;

/// Constants of a material by temperature: linear between rows, constant beyond them. Rows ascend.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct HeatLaw {
    /// Temperature from which the mean coefficients count.
    pub zero: f64,
    /// Temperature, and strain by temperature along the axes of space, or those that turn about a line; none:
    /// it does not expand.
    pub expansion: Vec<(f64, [[f64; 3]; 3])>,
    /// Temperature and elasticity; none: that of the material.
    pub elasticity: Vec<(f64, Elasticity)>,
}

/// Temperatures of a body.
#[derive(Clone, Copy, Debug)]
pub struct Heat<'a> {
    /// One for each region.
    pub laws: &'a [HeatLaw],
    /// Temperature of each node at which the body has neither stress nor strain; none: where each material
    /// counts its coefficients from.
    pub initial: &'a [f64],
    /// Temperature of each node.
    pub now: &'a [f64],
    /// True if temperatures of hexahedra are of a lower order than displacements, as CalculiX has them: their
    /// mean with 8 nodes, linear along each axis in those of 20 nodes that are fully integrated.
    pub lowered: bool,
}

impl HeatLaw {
    /// The tensor of three coefficients along axes, of which the first two are given; none: those of space.
    pub fn along([x, y, z]: [f64; 3], axes: Option<[[f64; 3]; 2]>) -> [[f64; 3]; 3] {
        let own = [[x, 0.0, 0.0], [0.0, y, 0.0], [0.0, 0.0, z]];
        axes.map_or(own, |axes| turned(&own, &right_handed(axes)))
    }

    /// Elasticity at a temperature, if it depends on it.
    pub fn elasticity_at(&self, temperature: f64) -> Option<Elasticity> {
        between(&self.elasticity, temperature, |a, b, share| {
            let mix = |a: f64, b: f64| a + share * (b - a);
            match (a, b) {
                (
                    Elasticity::Isotropic { young, poisson },
                    Elasticity::Isotropic { young: e, poisson: nu },
                ) => Elasticity::Isotropic { young: mix(*young, *e), poisson: mix(*poisson, *nu) },
                (Elasticity::Anisotropic(Stiffness(a)), Elasticity::Anisotropic(Stiffness(b))) => {
                    let row = |i: usize| std::array::from_fn(|j| mix(a[i][j], b[i][j]));
                    Elasticity::Anisotropic(Stiffness(std::array::from_fn(row)))
                }
                _ => *a,
            }
        })
    }

    /// Strain between the temperature without one and another.
    fn strain(&self, temperature: f64) -> Tensor {
        let mix = |a: &Tensor, b: &Tensor, share: f64| -> Tensor {
            std::array::from_fn(|i| std::array::from_fn(|j| a[i][j] + share * (b[i][j] - a[i][j])))
        };
        let coefficient = between(&self.expansion, temperature, mix).unwrap_or_default();
        coefficient.map(|row| row.map(|c| c * (temperature - self.zero)))
    }
}

/// The value of a table.
fn between<T: Copy>(rows: &[(f64, T)], at: f64, mix: impl Fn(&T, &T, f64) -> T) -> Option<T> {
    let after = rows.partition_point(|row| row.0 < at);
    match (after.checked_sub(1).and_then(|k| rows.get(k)), rows.get(after)) {
        (Some(a), Some(b)) => Some(mix(&a.1, &b.1, (at - a.0) / (b.0 - a.0))),
        (Some(end), None) | (None, Some(end)) => Some(end.1),
        (None, None) => None,
    }
}

/// A tensor along axes of its own, along those of space.
fn turned(own: &Tensor, axes: &[[f64; 3]; 3]) -> Tensor {
    let of = |i: usize, j: usize| {
        let pairs = (0..9).map(|at| (at / 3, at % 3));
        pairs.map(|(k, l)| axes[k][i] * own[k][l] * axes[l][j]).sum::<f64>()
    };
    std::array::from_fn(|i| std::array::from_fn(|j| of(i, j)))
}

/// Temperatures of the nodes of an element, the initial ones and those of now.
pub(super) struct HeatedElement<'a> {
    law: &'a HeatLaw,
    temperatures: [[f64; MAX_NODES]; 2],
}

impl<'a> Heat<'a> {
    /// Those of an element.
    pub(super) fn of(
        &self,
        (kind, region): (ElementKind, u32),
        nodes: &[u32],
        kernel: &ElementKernel,
    ) -> Option<HeatedElement<'a>> {
        let law = self.laws.get(region as usize)?;
        let temperatures = [self.initial, self.now].map(|all| {
            let mut own = [0.0; MAX_NODES];
            let of = |&node: &u32| all.get(node as usize).copied().unwrap_or(law.zero);
            own.iter_mut().zip(nodes).for_each(|(own, node)| *own = of(node));
            match kind {
                _ if !self.lowered => {}
                ElementKind::Hex8 => own = [own[..8].iter().sum::<f64>() / 8.0; MAX_NODES],
                ElementKind::Hex20 if kernel.is_full_hexahedron() => lower(kind.edges(), &mut own),
                _ => {}
            }
            own
        });
        Some(HeatedElement { law, temperatures })
    }
}

/// Temperatures of the corners such that interpolation along each axis has the mean along each edge of the
/// quadratic functions.
fn lower(edges: &[[usize; 2]], own: &mut [f64; MAX_NODES]) {
    let given = *own;
    for (e, &[a, b]) in edges.iter().enumerate() {
        let bulge = given[8 + e] - 0.5 * (given[a] + given[b]);
        // The mean of `1 − ξ²`.
        [a, b].into_iter().for_each(|corner| own[corner] += 2.0 / 3.0 * bulge);
    }
    for (e, &[a, b]) in edges.iter().enumerate() {
        own[8 + e] = 0.5 * (own[a] + own[b]);
    }
}

impl HeatedElement<'_> {
    fn at(&self, point: &Point) -> [f64; 2] {
        self.temperatures.map(|own| point.values.iter().zip(own).map(|(n, t)| n * t).sum())
    }

    /// Elasticity at a point, if it depends on the temperature.
    pub(super) fn elasticity(&self, point: &Point) -> Option<Elasticity> {
        self.law.elasticity_at(self.at(point)[1])
    }

    /// The thermal strain at a point, along axes that turn there.
    pub(super) fn strain(&self, point: &Point, axes: Option<[[f64; 3]; 3]>) -> Tensor {
        let [before, now] = self.at(point).map(|temperature| self.law.strain(temperature));
        let own = std::array::from_fn(|i| std::array::from_fn(|j| now[i][j] - before[i][j]));
        axes.map_or(own, |axes| turned(&own, &axes))
    }
}
