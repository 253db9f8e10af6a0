//! Cotangents of what outputs show of forces beside the modes: residual flexibility, stress that the modes
//! leave out, and reactions of supports.
//!
//! These outputs are linear in the forces at the end of a step, so their gradient is what the cotangents read
//! of the answer to a unit load.

use crate::base::error::OutputError;
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
    /// Six numbers for each support. Reactions follow forces at once, without the filter of the residual.
    pub reactions: &'m mut [T],
}

/// Numbers of cotangents of probes, of stresses and of reactions; none where forces show nothing beside the
/// modes.
fn counts<T: Scalar>(scene: &Scene<'_, T>) -> [usize; 3] {
    if scene.shape.statics == [0; 2] {
        return [0; 3];
    }
    [scene.metadata.n_probes as usize, 6 * scene.n_stress_points(), 6 * scene.sections.supports.count]
}

impl<'m, T: Scalar> Shown<'m, T> {
    /// Numbers of memory, with room for so many nodes.
    pub fn len(scene: &Scene<'_, T>, nodes: usize) -> usize {
        counts(scene).into_iter().fold(4 * nodes, usize::saturating_add)
    }

    /// No cotangents.
    pub fn new(scene: &Scene<'_, T>, nodes: usize, memory: &mut Lender<&'m mut [T]>) -> Result<Self, Short> {
        let [probes, stress, reactions] = counts(scene);
        let nodes = Statics::new([nodes, 0], memory)?;
        let (probes, stress) = (memory.take(probes)?, memory.take(stress)?);
        let mut shown = Self { nodes, probes, stress, reactions: memory.take(reactions)? };
        shown.clear();
        Ok(shown)
    }

    /// Takes all cotangents away.
    pub fn clear(&mut self) {
        self.nodes.clear();
        self.probes.fill(T::ZERO);
        self.stress.fill(T::ZERO);
        self.reactions.fill(T::ZERO);
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
        self.reactions.iter_mut().zip(&*other.reactions).for_each(|(to, &from)| *to = from);
        self.nodes.scale(keep);
        self.nodes.add_all(&other.nodes)
    }

    /// Reading of the cotangents of the answer to forces at the end of a step.
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

    /// Reading of the cotangents of reactions of forces at the end of a step, at rest.
    pub fn held(&self, scene: &Scene<'_, T>, acting: &Statics<'_, T>) -> Result<f64, OutputError> {
        let mut sum = 0.0;
        for (support, own) in self.reactions.as_chunks::<6>().0.iter().enumerate() {
            if *own == [T::ZERO; 6] {
                continue;
            }
            let mut reaction = [0.0; 6];
            scene.sections.supports.hold(support, acting, &mut reaction)?;
            sum += own.iter().zip(reaction).map(|(own, part)| own.to_f64() * part).sum::<f64>();
        }
        Ok(sum)
    }
}
