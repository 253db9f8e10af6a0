//! The sections of the stress, and what is read of them.

use crate::base::error::OutputError;
use crate::base::scalar::Scalar;
use crate::sections::residual::Statics;
use crate::sections::rows::{Factors, dot};
use vademecum_format::{File, Numbers, SectionKind};

/// A point whose stress the file has: a node, in the file's order, in one of its regions. A node between two
/// regions has a stress in each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StressPoint {
    /// The node.
    pub node: u32,
    /// The region, counted from 0.
    pub region: u32,
}

/// The sections of the stress; `None` where they are absent or compressed.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct StressRows<'m> {
    pub points: &'m [[[u8; 4]; 2]],
    basis: Option<Numbers<'m>>,
    contacts: Option<Numbers<'m>>,
    patterns: Option<Numbers<'m>>,
    /// Young's modulus and Poisson's ratio of each region.
    pub constants: &'m [[[u8; 8]; 2]],
    /// Upper triangle of the compliance of each region, in place of these.
    pub compliance: &'m [[[u8; 8]; 21]],
    n_load_nodes: usize,
    r: usize,
}

impl<'m> StressRows<'m> {
    /// Looks the sections up.
    pub fn of(file: &File<'m>) -> Self {
        use SectionKind as S;
        let optional = |kind| file.section(kind).and_then(|section| section.numbers().ok());
        let points = file.section(S::StressPoints).and_then(|section| section.u32s().ok());
        let reals = |kind| file.section(kind).and_then(|section| section.f64s().ok()).unwrap_or(&[]);
        Self {
            points: points.map_or(&[], |points| points.as_chunks().0),
            basis: optional(S::StressBasis),
            contacts: optional(S::StressResidual),
            patterns: optional(S::PatternStress),
            constants: reals(S::ElasticConstants).as_chunks().0,
            compliance: reals(S::Compliance).as_chunks().0,
            n_load_nodes: file.metadata().n_load_nodes as usize,
            r: file.metadata().n_modes as usize,
        }
    }

    /// One of the points.
    pub fn point(&self, index: usize) -> Option<StressPoint> {
        let [node, region] = self.points.get(index)?.map(u32::from_le_bytes);
        Some(StressPoint { node, region })
    }

    /// Row of a component of one of them over the modes, with the moduli as built.
    pub fn row(&self, index: usize, component: usize) -> Result<Numbers<'m>, OutputError> {
        let basis = self.basis.ok_or(OutputError::Missing { kind: SectionKind::StressBasis })?;
        let beyond = OutputError::OutOfRange { index, count: self.points.len() };
        if index >= self.points.len() {
            return Err(beyond);
        }
        basis.row((6 * index + component) * self.r, self.r).ok_or(beyond)
    }

    /// The part of the modes, with the moduli as built.
    pub fn moving<T: Scalar>(
        &self,
        index: usize,
        (x, scale): Factors<'_, T>,
    ) -> Result<[f64; 6], OutputError> {
        let mut stress = [0.0; 6];
        for (component, stress) in stress.iter_mut().enumerate() {
            *stress = dot(self.row(index, component)?, x) * scale;
        }
        Ok(stress)
    }

    /// Adds what the modes leave out.
    pub fn add_static<T: Scalar>(&self, index: usize, acting: &Statics<'_, T>, stress: &mut [f64; 6]) {
        if let Some(contacts) = self.contacts {
            for (node, force) in acting.forces().filter(|&(node, _)| node < self.n_load_nodes) {
                let block = contacts.row((index * self.n_load_nodes + node) * 18, 18);
                for (component, stress) in stress.iter_mut().enumerate() {
                    let at = |c: usize| block.and_then(|block| block.get(3 * component + c)).unwrap_or(0.0);
                    *stress += at(0) * force[0] + at(1) * force[1] + at(2) * force[2];
                }
            }
        }
        let Some(patterns) = self.patterns else { return };
        for (pattern, amplitude) in acting.amplitudes() {
            let row = patterns.row((pattern * self.points.len() + index) * 6, 6);
            for (component, stress) in stress.iter_mut().enumerate() {
                *stress += amplitude * row.and_then(|row| row.get(component)).unwrap_or(0.0);
            }
        }
    }
}
