//! Ports: the patches and frames by which an assembly joins a body to others.

use crate::error::FormatError;
use crate::kind::SectionKind;
use crate::read::File;

/// Nodes of a facet of a port; those that it does not have are [`u32::MAX`].
pub const PORT_FACET_NODES: usize = 9;

/// Numbers of a row of [`SectionKind::PortTable`].
pub const PORT_COLUMNS: usize = 7;

/// Kind of a port.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum PortKind {
    /// Three displacements of each of its nodes.
    Patch = 0,
    /// Three displacements and three rotations along and about its axes.
    Frame = 1,
}

/// A row of [`SectionKind::PortTable`]: where a port stands in the other sections.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PortRange {
    /// Its kind.
    pub kind: PortKind,
    /// First row of the displacements, and their number.
    pub rows: [usize; 2],
    /// First node, and their number; none of a frame.
    pub nodes: [usize; 2],
    /// First facet, and their number.
    pub facets: [usize; 2],
}

impl PortRange {
    /// A row of the table; `None` for a kind that there is not, and for rows that do not fit it.
    #[must_use]
    pub fn of(row: &[[u8; 4]; PORT_COLUMNS]) -> Option<Self> {
        let [kind, rows @ ..] = row.map(u32::from_le_bytes);
        let [row, n_rows, node, n_nodes, facet, n_facets] = rows.map(|number| number as usize);
        let (kind, expected) = match kind {
            0 => (PortKind::Patch, n_nodes.checked_mul(3)?),
            1 if n_nodes == 0 && n_facets == 0 => (PortKind::Frame, 6),
            _ => return None,
        };
        let port = Self { kind, rows: [row, n_rows], nodes: [node, n_nodes], facets: [facet, n_facets] };
        (n_rows == expected).then_some(port)
    }
}

impl<'a> File<'a> {
    /// Rows of the table of ports, one each; none of a file without ports.
    ///
    /// # Errors
    /// Refusals 28 (compressed) and 19 (not integers).
    pub fn port_table(&self) -> Result<&'a [[[u8; 4]; PORT_COLUMNS]], FormatError> {
        let Some(section) = self.section(SectionKind::PortTable) else { return Ok(&[]) };
        Ok(section.u32s()?.as_chunks().0)
    }
}
