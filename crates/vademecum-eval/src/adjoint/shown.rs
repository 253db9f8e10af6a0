//! Cotangents of what outputs show of forces beside the modes: residual flexibility, and stress that the
//! modes leave out.
//!
//! These outputs are linear in the forces at the end of a step, so their gradient is what the cotangents read
//! of the answer to a unit load.

use crate::base::lend::{Lender, Short};
use crate::base::scalar::Scalar;
use crate::base::vec3::dot;
use crate::scene::scene::Scene;
use crate::sections::residual::Statics;

/// Cotangents of displacements of nodes, of probes and of stresses.
#[derive(Debug)]
pub(crate) struct Shown<'m, T> {
    /// A node, and the cotangent of its displacement.
    pub nodes: Statics<'m, T>,
    pub probes: &'m mut [T],
    /// Six numbers for each point.
    pub stress: &'m mut [T],
}

/// Numbers of cotangents of probes and of stresses; none where forces show nothing beside the modes.
fn counts<T: Scalar>(scene: &Scene<'_, T>) -> [usize; 2] {
    if scene.shape.statics == [0; 2] {
        return [0; 2];
    }
    [scene.metadata.n_probes as usize, 6 * scene.n_stress_points()]
}

impl<'m, T: Scalar> Shown<'m, T> {
    /// Numbers of memory, with room for so many nodes.
    pub fn len(scene: &Scene<'_, T>, nodes: usize) -> usize {
        let [probes, stress] = counts(scene);
        4 * nodes + probes + stress
    }

    /// No cotangents.
    pub fn new(scene: &Scene<'_, T>, nodes: usize, memory: &mut Lender<&'m mut [T]>) -> Result<Self, Short> {
        let [probes, stress] = counts(scene);
        let nodes = Statics::new([nodes, 0], memory)?;
        let mut shown = Self { nodes, probes: memory.take(probes)?, stress: memory.take(stress)? };
        shown.clear();
        Ok(shown)
    }

    /// Takes all cotangents away.
    pub fn clear(&mut self) {
        self.nodes.clear();
        self.probes.fill(T::ZERO);
        self.stress.fill(T::ZERO);
    }

    /// `c ← keep c + other`: what a step of the filter of the residual makes of cotangents, backwards. False
    /// where there is no room for the nodes.
    pub fn keep_and_add(&mut self, keep: T, other: &Shown<'_, T>) -> bool {
        if keep == T::ZERO {
            self.clear();
        }
        let add = |all: &mut [T], more: &[T]| {
            all.iter_mut().zip(more).for_each(|(sum, &x)| *sum = keep * *sum + x);
        };
        add(self.probes, other.probes);
        add(self.stress, other.stress);
        self.nodes.scale(keep);
        self.nodes.add_all(&other.nodes)
    }

    /// What the cotangents read of the answer to forces at the end of a step.
    pub fn answer(&self, scene: &Scene<'_, T>, acting: &Statics<'_, T>) -> f64 {
        let residual = &scene.sections.residual;
        let of_nodes = self.nodes.forces().map(|(node, own)| dot(own, residual.node(node, acting)));
        let probes = self.probes.iter().enumerate().filter(|own| *own.1 != T::ZERO);
        let of_probes = probes.map(|(probe, own)| own.to_f64() * residual.probe(probe, acting));
        let moved = (of_nodes.sum::<f64>() + of_probes.sum::<f64>()) / scene.parameters.stiffness;
        let points = self.stress.as_chunks::<6>().0.iter().enumerate();
        let stresses = points.filter(|own| *own.1 != [T::ZERO; 6]).map(|(point, own)| {
            let mut stress = [0.0; 6];
            scene.sections.stress.add_static(point, acting, &mut stress);
            own.iter().zip(stress).map(|(own, stress)| own.to_f64() * stress).sum::<f64>()
        });
        moved + stresses.sum::<f64>()
    }
}
