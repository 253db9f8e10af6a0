//! Temperatures of an Ansys deck.

use vademecum_build::fem::HeatLaw;

use crate::deck::{Deck, NodeNumber, Temperatures};

/// Temperatures, and coefficients of expansion, as far as they were read.
#[derive(Clone, Debug, Default)]
pub(super) struct Heat {
    /// That without expansion.
    pub(super) reference: f64,
    /// That of all other nodes, if it is not the former.
    pub(super) uniform: Option<f64>,
    /// Those of some.
    pub(super) nodes: Vec<(NodeNumber, f64)>,
    /// Mean coefficients of each material along the axes of space; zeros as along x.
    pub(super) coefficients: Vec<(u64, [f64; 3])>,
}

impl Heat {
    /// True if a material of the deck expands otherwise along one axis than along another.
    pub(super) fn has_axes(&self) -> bool {
        self.is_given() && self.coefficients.iter().any(|(_, along)| along[1..] != [0.0; 2])
    }

    /// Takes a coefficient of a material along an axis.
    pub(super) fn expand(&mut self, material: u64, axis: usize, value: f64) {
        match self.coefficients.iter_mut().find(|(id, _)| *id == material) {
            Some((_, along)) => along[axis] = value,
            None => {
                let mut along = [0.0; 3];
                along[axis] = value;
                self.coefficients.push((material, along));
            }
        }
    }

    fn is_given(&self) -> bool {
        self.uniform.is_some() || !self.nodes.is_empty()
    }

    /// Hands the temperatures to a deck, and gives those of its nodes; none where it has none.
    pub(super) fn finish(self, deck: &mut Deck) -> Vec<f64> {
        if !self.is_given() {
            return vec![];
        }
        let zero = self.reference;
        let law = |tag: i64| {
            let own = self.coefficients.iter().find(|(id, _)| *id == tag as u64);
            let [x, y, z] = own.map_or([0.0; 3], |own| own.1);
            let along = [x, if y == 0.0 { x } else { y }, if z == 0.0 { x } else { z }];
            HeatLaw { zero, expansion: vec![(zero, HeatLaw::along(along, None))], elasticity: vec![] }
        };
        let laws = deck.mesh.regions.iter().map(|region| law(region.tag)).collect();
        deck.heat = Some(Temperatures { laws, initial: vec![], lowered: false });
        let mut found = vec![self.uniform.unwrap_or(zero); deck.mesh.nodes.len()];
        for (node, value) in self.nodes {
            if let Some(slot) = found.get_mut(node as usize) {
                *slot = value;
            }
        }
        found
    }
}
