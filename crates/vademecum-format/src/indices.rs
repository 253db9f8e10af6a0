//! Numbers of a file that count into it: the nodes of triangles, of quadrangles, of pairs, of points of
//! stress, of the embedded surface and of the factor. Here each is compared with what it counts, once for
//! every consumer.
//!
//! Opening does not read the sections, so it does not look at them; [`File::verify_all`] and
//! [`File::indices`] do. The positions of the chapter's structure are checked when a file is opened.

use crate::error::FormatError;
use crate::kind::SectionKind;
use crate::quadrangles::{CORNERS, NO_NODE};
use crate::read::File;

impl SectionKind {
    /// Kinds of sections whose numbers are indices, which [`File::verify_indices`] checks.
    pub const INDICES: [Self; 10] = [
        Self::Triangles,
        Self::ResidualPairs,
        Self::FactorOrder,
        Self::FactorRows,
        Self::StressPoints,
        Self::EmbeddedNodes,
        Self::EmbeddedTriangles,
        Self::Quadrangles,
        Self::PortNodes,
        Self::PatchPairs,
    ];
}

impl<'a> File<'a> {
    /// The indices of a section, each compared with what it counts; `None` if the file does not have it.
    /// Reads all of them.
    ///
    /// # Errors
    /// Refusals 28 (compressed), 19 (not integers) and 38.
    pub fn indices(&self, kind: SectionKind) -> Result<Option<&'a [[u8; 4]]>, FormatError> {
        let Some(section) = self.section(kind) else { return Ok(None) };
        let indices = section.u32s()?;
        self.check_indices(kind, indices)?;
        Ok(Some(indices))
    }

    /// Compares the indices of every raw section with what they count. Reads these sections.
    ///
    /// # Errors
    /// Refusal 38.
    pub fn verify_indices(&self) -> Result<(), FormatError> {
        for kind in SectionKind::INDICES {
            match self.indices(kind) {
                Err(error @ FormatError::Index { .. }) => return Err(error),
                _ => continue,
            }
        }
        Ok(())
    }

    /// Compares the decoded indices of a section of this kind with what they count; those of a kind without
    /// indices pass.
    ///
    /// # Errors
    /// Refusal 38.
    pub fn check_indices(&self, kind: SectionKind, indices: &[[u8; 4]]) -> Result<(), FormatError> {
        use SectionKind as S;
        let rows = |kind| self.section(kind).map_or(u64::MAX, |section| section.shape()[0]);
        let m = self.metadata();
        let [loadable, surface, nodes] = [m.n_load_nodes, m.n_surface_nodes, m.n_nodes].map(u64::from);
        // So many first numbers are loadable nodes; the others, in turn, count into these.
        let (head, even, odd) = match kind {
            S::Triangles => ((m.n_load_triangles as usize).saturating_mul(3), surface, surface),
            S::ResidualPairs | S::PatchPairs => (0, loadable, loadable),
            S::FactorOrder => (0, 3 * nodes, 3 * nodes),
            S::FactorRows => (0, rows(S::FactorOrder), rows(S::FactorOrder)),
            S::EmbeddedNodes | S::PortNodes => (0, surface, surface),
            S::EmbeddedTriangles => (0, rows(S::EmbeddedNodes), rows(S::EmbeddedNodes)),
            S::StressPoints => (0, nodes, rows(S::ElasticConstants).min(rows(S::Compliance))),
            S::Quadrangles => return self.check_quadrangles(indices),
            _ => return Ok(()),
        };
        for (place, &bytes) in indices.iter().enumerate() {
            let found = u32::from_le_bytes(bytes);
            let count = match place % 2 {
                _ if place < head => loadable,
                0 => even,
                _ => odd,
            };
            if u64::from(found) >= count {
                return Err(FormatError::Index { kind: kind.number(), place: place as u64, found, count });
            }
        }
        Ok(())
    }

    /// Triangles and nodes are loadable ones.
    fn check_quadrangles(&self, numbers: &[[u8; 4]]) -> Result<(), FormatError> {
        let (kind, m) = (SectionKind::Quadrangles, self.metadata());
        let [triangles, nodes] = [m.n_load_triangles, m.n_load_nodes].map(u64::from);
        let width = self.section(kind).map_or(0, |section| section.shape()[1] as usize).max(1);
        let mut left = 0;
        for (place, &bytes) in numbers.iter().enumerate() {
            let found = u32::from_le_bytes(bytes);
            let count = match place % width {
                0 => {
                    left = triangles.saturating_sub(u64::from(found));
                    triangles
                }
                1 => left + 1,
                column if column >= 2 + CORNERS && found == NO_NODE => continue,
                _ => nodes,
            };
            if u64::from(found) >= count {
                return Err(FormatError::Index { kind: kind.number(), place: place as u64, found, count });
            }
        }
        Ok(())
    }
}
