//! Groups of nodes from lists of their numbers.

use super::error::{FaultSite, MeshError};
use super::place::Location;
use super::ranges::IdRanges;
use super::raw::RawMesh;

/// Maker of the groups of one file.
pub(crate) struct Groups {
    /// Numbers of nodes, ascending, with their indices.
    known: Vec<(u64, u32)>,
    /// Members that groups may still have.
    left: usize,
}

impl Groups {
    /// The maker for the nodes of a mesh.
    pub(crate) fn of(raw: &RawMesh) -> Self {
        let mut known: Vec<(u64, u32)> = raw.node_ids.iter().copied().zip(0..).collect();
        known.sort_unstable();
        // A line can name all nodes: no honest file has more of those.
        let left = 64 * (known.len() + 64);
        Self { known, left }
    }

    /// Adds a group of the listed nodes that there are; none if there is none.
    pub(crate) fn add(&mut self, raw: &mut RawMesh, name: String, ids: &IdRanges) -> Result<(), MeshError> {
        let members = ids.members(&self.known);
        self.add_nodes(raw, name, members)
    }

    /// Adds nodes to a group.
    pub(crate) fn add_nodes(
        &mut self,
        raw: &mut RawMesh,
        name: String,
        members: Vec<u32>,
    ) -> Result<(), MeshError> {
        let Some(left) = self.left.checked_sub(members.len()) else {
            let at = FaultSite { file: &raw.file, place: Location::Whole, section: &name };
            return Err(at.malformed("the same nodes in group after group", "64 groups of all nodes at most"));
        };
        self.left = left;
        if !members.is_empty() {
            raw.node_groups.entry(name).or_default().extend(members);
        }
        Ok(())
    }
}
