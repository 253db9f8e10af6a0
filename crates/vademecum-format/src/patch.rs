//! The residual flexibility between contacts that are near each other.

use crate::error::FormatError;
use crate::kind::SectionKind;
use crate::read::File;
use crate::section::Numbers;

/// Wendland's function `ψ(t) = (1 − t)⁴ (4t + 1)` of a distance `t` in units of `h`; 0 from 1 on.
///
/// A matrix of its values between any points of space is positive semidefinite.
#[must_use]
pub fn taper(t: f64) -> f64 {
    let left = 1.0 - t;
    if left > 0.0 { left * left * left * left * (4.0 * t + 1.0) } else { 0.0 }
}

/// Sections 107 to 110 of a file.
#[derive(Clone, Copy, Debug)]
pub struct ContactPatch<'a> {
    /// `h`: contacts at this distance and beyond have no block between them \[m\].
    pub distance: f64,
    /// Pairs of loadable nodes, the first at most the second, ascending.
    pub pairs: &'a [[[u8; 4]; 2]],
    /// Nine numbers for each pair.
    pub blocks: Numbers<'a>,
    /// Rows of the further modes, three for each loadable node; none of a file without them.
    pub modes: Option<Numbers<'a>>,
    /// Number of further modes.
    pub n_modes: usize,
}

impl ContactPatch<'_> {
    /// The block of two loadable nodes: row the component of displacement at `a`, column that of force at
    /// `b`, row by row; `None` of nodes that are no pair. By bisection.
    #[must_use]
    pub fn between(&self, a: u32, b: u32) -> Option<[f64; 9]> {
        let wanted = [a.min(b), a.max(b)];
        let place = self.pairs.binary_search_by_key(&wanted, |pair| pair.map(u32::from_le_bytes)).ok()?;
        let mut block = [0.0; 9];
        for (at, value) in block.iter_mut().enumerate() {
            let at = if a <= b { at } else { 3 * (at % 3) + at / 3 };
            *value = self.blocks.get(9 * place + at)?;
        }
        Some(block)
    }
}

impl<'a> File<'a> {
    /// The residual flexibility between contacts near each other; `None` of a file without it.
    ///
    /// # Errors
    /// Refusals 28 (compressed) and 19 (other numbers).
    pub fn contact_patch(&self) -> Result<Option<ContactPatch<'a>>, FormatError> {
        let sections = [SectionKind::ContactPatch, SectionKind::PatchPairs, SectionKind::PatchResidual];
        let [Some(distance), Some(pairs), Some(blocks)] = sections.map(|kind| self.section(kind)) else {
            return Ok(None);
        };
        let modes = self.section(SectionKind::ContactModes);
        Ok(Some(ContactPatch {
            distance: distance.numbers()?.get(0).unwrap_or(0.0),
            pairs: pairs.u32s()?.as_chunks().0,
            blocks: blocks.numbers()?,
            modes: modes.map(|section| section.numbers()).transpose()?,
            n_modes: modes.map_or(0, |section| section.shape()[2] as usize),
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::taper;

    #[test]
    fn the_taper_is_one_at_a_contact_and_ends_at_the_distance() {
        let found = [0.0, 0.5, 1.0, 7.0, f64::NAN].map(taper);
        assert_eq!(found, [1.0, 0.1875, 0.0, 0.0, 0.0]);
    }
}
