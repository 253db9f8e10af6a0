//! The map between the dofs of a mesh and those that are free.

/// Marks a constrained dof in the map from dofs to free indices.
const CONSTRAINED: u32 = u32::MAX;

/// Which dofs are free. Dof `3 · node + component` is a number or held at zero.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DofMap {
    free_of_dof: Vec<u32>,
    dof_of_free: Vec<u32>,
}

impl DofMap {
    /// Numbers the free dofs in ascending order.
    pub(crate) fn new(constrained: &[bool]) -> DofMap {
        let dof_of_free: Vec<u32> =
            (0..constrained.len() as u32).filter(|&d| !constrained[d as usize]).collect();
        let mut free_of_dof = vec![CONSTRAINED; constrained.len()];
        for (free, &dof) in dof_of_free.iter().enumerate() {
            free_of_dof[dof as usize] = free as u32;
        }
        DofMap { free_of_dof, dof_of_free }
    }

    /// Number of free dofs.
    pub fn n_free(&self) -> usize {
        self.dof_of_free.len()
    }

    /// Number of dofs, three per node.
    pub fn n_dof(&self) -> usize {
        self.free_of_dof.len()
    }

    /// Free index of a dof; `None` if it is held.
    pub fn free(&self, dof: usize) -> Option<u32> {
        Some(self.free_of_dof[dof]).filter(|&free| free != CONSTRAINED)
    }

    /// Dof of each free index, ascending.
    pub fn dof_of_free(&self) -> &[u32] {
        &self.dof_of_free
    }

    /// Free values to all dofs, zero where held.
    ///
    /// # Panics
    /// If the lengths are not `n_free` and `n_dof`.
    pub fn expand_into(&self, free: &[f64], full: &mut [f64]) {
        assert!(free.len() == self.n_free() && full.len() == self.n_dof());
        full.fill(0.0);
        for (&value, &dof) in free.iter().zip(&self.dof_of_free) {
            full[dof as usize] = value;
        }
    }

    /// The free part of values at all dofs.
    ///
    /// # Panics
    /// If the lengths are not `n_dof` and `n_free`.
    pub fn restrict_into(&self, full: &[f64], free: &mut [f64]) {
        assert!(free.len() == self.n_free() && full.len() == self.n_dof());
        for (value, &dof) in free.iter_mut().zip(&self.dof_of_free) {
            *value = full[dof as usize];
        }
    }
}
