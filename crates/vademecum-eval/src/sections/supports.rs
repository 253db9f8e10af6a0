//! The sections of a file for the reactions of its supports.

use crate::base::error::OutputError;
use crate::base::scalar::Scalar;
use crate::sections::residual::Statics;
use vademecum_format::{File, SectionKind};

/// The sections of the reactions; `None` where they are absent or compressed.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Supports<'m> {
    pub points: Option<&'m [[u8; 8]]>,
    pub basis: Option<&'m [[u8; 8]]>,
    loads: Option<&'m [[u8; 8]]>,
    patterns: Option<&'m [[u8; 8]]>,
    pub count: usize,
    pub n_load_nodes: usize,
}

impl<'m> Supports<'m> {
    /// Looks the sections up.
    pub fn of(file: &File<'m>) -> Self {
        let optional = |kind| file.section(kind).and_then(|section| section.f64s().ok());
        let count = file.section(SectionKind::ReactionBasis).map_or(0, |section| section.shape()[0]);
        let metadata = file.metadata();
        Self {
            points: optional(SectionKind::SupportPoints),
            basis: optional(SectionKind::ReactionBasis),
            loads: optional(SectionKind::ReactionLoads),
            patterns: optional(SectionKind::PatternReaction),
            count: usize::try_from(count).unwrap_or(0),
            n_load_nodes: metadata.n_load_nodes as usize,
        }
    }

    /// Adds what holds the forces that act.
    pub fn hold<T: Scalar>(
        &self,
        support: usize,
        acting: &Statics<'_, T>,
        out: &mut [f64; 6],
    ) -> Result<(), OutputError> {
        let missing = |kind| OutputError::Missing { kind };
        for (node, force) in acting.forces() {
            let rows = row(
                self.loads,
                support.saturating_mul(self.n_load_nodes).saturating_add(node).saturating_mul(18),
                18,
            );
            let rows = rows.ok_or(missing(SectionKind::ReactionLoads))?;
            for (out, row) in out.iter_mut().zip(rows.as_chunks::<3>().0) {
                *out += row.iter().zip(force).map(|(&share, f)| f64::from_le_bytes(share) * f).sum::<f64>();
            }
        }
        for (pattern, amplitude) in acting.amplitudes() {
            let rows = row(
                self.patterns,
                pattern.saturating_mul(self.count).saturating_add(support).saturating_mul(6),
                6,
            );
            let rows = rows.ok_or(missing(SectionKind::PatternReaction))?;
            out.iter_mut().zip(rows).for_each(|(out, &share)| *out += amplitude * f64::from_le_bytes(share));
        }
        Ok(())
    }
}

/// Some numbers of a section.
pub(crate) fn row(numbers: Option<&[[u8; 8]]>, start: usize, length: usize) -> Option<&[[u8; 8]]> {
    numbers?.get(start..start.checked_add(length)?)
}
