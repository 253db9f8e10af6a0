//! Forces and energy of a thermal strain.
//!
//! With the strain `ε` of the displacement, the stress is `D (ε − ε_T)`:
//!
//! ```text
//! f = ∫ Bᵀ D ε_T dV,      V = ½ ∫ (ε − ε_T) D (ε − ε_T) dV = ½ uᵀKu − uᵀf + ½ ∫ ε_T D ε_T dV
//! ```
//!
//! (Zienkiewicz and Taylor, *The Finite Element Method*, vol. 1, §2.2). It is integrated where the stiffness
//! is, with the strains of the formulation: a body whose strain may be `ε_T` has no stress.

use faer::Mat;

use super::assembly::element_nodes;
use super::blocks::ElementMatrices;
use super::element::ElementKernel;
use super::heat::{StrainAt, Tensor};
use super::hexahedron::{InnerMap, mean_gradients, with_inner_functions};
use super::kernels::ElementKernels;
use super::material::{LawAt, Material};
use super::model::Model;
use super::model_error::ModelError;
use super::point::{ElementError, gradients, jacobian};
use crate::mesh::shapes::MAX_NODES;

impl ElementKernel {
    /// `∫ Bᵀ D ε_T` over three components for each node, and behind them for each inner function that is
    /// kept, and the energy of the element in no displacement, less that of eliminated inner functions.
    #[inline(never)]
    pub(super) fn thermal_force(
        &self,
        nodes: &[[f64; 3]],
        (law, strain): (LawAt<'_>, StrainAt<'_>),
        keeps: bool,
    ) -> Result<(Vec<f64>, f64), ElementError> {
        let (n, rule) = (nodes.len(), self.stiffness_points(nodes));
        let inner = self.is_incompatible().then(|| InnerMap::new(nodes, !keeps)).transpose()?;
        let mean = self.has_mean_dilatation().then(|| mean_gradients(rule, nodes)).transpose()?;
        let mut forces = vec![0.0; 3 * n + if inner.is_some() { 9 } else { 0 }];
        let (mut energy, mut pressure) = (0.0, 0.0);
        for point in rule {
            let (inverse, determinant) = jacobian(n, point, nodes)?;
            let mut g = gradients(n, point, &inverse)[..n].to_vec();
            g.extend(inner.iter().flat_map(|inner| inner.gradients(point, determinant)));
            let (weight, own) = (determinant * point.weight, strain(point));
            let mut stress = law(point).stress(&own).map(|row| row.map(|s| weight * s));
            energy +=
                0.5 * stress.iter().zip(&own).flat_map(|(s, e)| (0..3).map(|c| s[c] * e[c])).sum::<f64>();
            if mean.is_some() {
                let third = (stress[0][0] + stress[1][1] + stress[2][2]) / 3.0;
                (0..3).for_each(|c| stress[c][c] -= third);
                pressure += third;
            }
            for (force, g) in forces.as_chunks_mut::<3>().0.iter_mut().zip(&g) {
                (0..3).for_each(|c| force[c] += (0..3).map(|i| stress[c][i] * g[i]).sum::<f64>());
            }
        }
        if let Some((whole, volume)) = &mean {
            for (force, g) in forces.as_chunks_mut::<3>().0.iter_mut().zip(whole) {
                (0..3).for_each(|c| force[c] += pressure / volume * g[c]);
            }
        }
        if inner.is_some() && !keeps {
            let functions = with_inner_functions(rule, nodes, (law, true), &mut vec![0.0; 9 * n * n])?;
            let own = Mat::from_fn(9, 1, |i, _| forces[3 * n + i]);
            let answer = functions.answer(&own)?;
            let lost = functions.coupling.transpose() * &answer;
            forces.truncate(3 * n);
            forces.iter_mut().enumerate().for_each(|(i, force)| *force -= lost[(i, 0)]);
            energy -= 0.5 * (0..9).map(|i| own[(i, 0)] * answer[(i, 0)]).sum::<f64>();
        }
        Ok((forces, energy))
    }
}

impl Model {
    /// `∫ Bᵀ D ε_T` over all dofs, of a thermal strain of each element.
    pub(crate) fn thermal_load(&self, strain: &[Tensor]) -> Vec<f64> {
        let (mesh, mut load) = (self.mesh(), vec![0.0; self.dofs().n_dof()]);
        let kernels = ElementKernels::new(mesh);
        for (e, (_, element)) in mesh.each().enumerate() {
            let law = self.materials()[mesh.element_region[e] as usize].law();
            let nodes = element_nodes::<MAX_NODES>(mesh, e as u32);
            let found =
                kernels.of(mesh, e).thermal_force(&nodes[..element.len()], (&|_| law, &|_| strain[e]), false);
            let (forces, _) = found.expect("the assembled mesh has no folded element");
            for (&node, force) in element.iter().zip(forces.as_chunks::<3>().0) {
                let sums = &mut load[3 * node as usize..][..3];
                sums.iter_mut().zip(force).for_each(|(sum, f)| *sum += f);
            }
        }
        load
    }
}

/// The stress of a strain by the law of a material: xx, yy, zz, xy, yz, zx.
pub(crate) fn element_stress(material: &Material, strain: &Tensor) -> [f64; 6] {
    let s = material.law().stress(strain);
    [s[0][0], s[1][1], s[2][2], s[0][1], s[1][2], s[2][0]]
}

/// The forces of the thermal strain over `n` dofs, and the energy `½ ∫ ε_T D ε_T` of a body that it cannot
/// move: with these, the strain energy is `½ uᵀKu − uᵀf` and the energy.
///
/// # Errors
/// [`ModelError::FoldedElement`].
pub fn thermal_forces(elements: &ElementMatrices<'_>, n: usize) -> Result<(Vec<f64>, f64), ModelError> {
    let (mut sums, mut energy) = (vec![0.0; n], 0.0);
    for element in 0..elements.count() {
        let folded = |source| ModelError::FoldedElement { element: element as u32, source };
        let Some((dofs, forces, own)) = elements.thermal_force(element).map_err(folded)? else { continue };
        dofs.iter().zip(forces).for_each(|(&dof, force)| sums[dof as usize] += force);
        energy += own;
    }
    Ok((sums, energy))
}
