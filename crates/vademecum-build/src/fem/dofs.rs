//! The map between the dofs of a mesh and those that are free.

use std::collections::BTreeMap;

use faer::Mat;

use super::elimination::Elimination;
use crate::linalg::symmetric_eigen;
use crate::store::Inputs;

/// A motion of reference points that dofs of the mesh follow by less than this share is not found from them.
const ROUNDING: f64 = 1e-12;

/// Marks a dof that is held or depends on others in the map from dofs to free indices.
const CONSTRAINED: u32 = u32::MAX;

/// Displacements of a mesh in its free dofs, `u = T û`. Dof `3 · node + component` is free, held at zero, or
/// depends on free ones: where attachments join parts of a body. Free dofs behind those of the mesh are the
/// motions of reference points.
#[derive(Clone, Debug, PartialEq)]
pub struct DofMap {
    free_of_dof: Vec<u32>,
    dof_of_free: Vec<u32>,
    /// Free indices and weights of each dependent dof.
    dependent: BTreeMap<u32, Vec<(u32, f64)>>,
    /// Number of dofs of the mesh.
    of_mesh: usize,
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
        let of_mesh = free_of_dof.len();
        DofMap { free_of_dof, dof_of_free, dependent: BTreeMap::new(), of_mesh }
    }

    /// The dofs of a mesh of `nodes` nodes under constraints, and those of what is attached to it.
    pub(crate) fn of_elimination(nodes: usize, elimination: &Elimination) -> DofMap {
        let n_free = elimination.n_free() as u32;
        let mut free_of_dof = vec![CONSTRAINED; elimination.n_dof()];
        let mut dependent = BTreeMap::new();
        for (dof, free) in free_of_dof.iter_mut().enumerate() {
            match *elimination.terms(dof) {
                [(index, 1.0)] if index < n_free && elimination.free()[index as usize] == dof as u32 => {
                    *free = index;
                }
                ref terms => {
                    let row: Vec<(u32, f64)> = terms.iter().copied().filter(|term| term.0 < n_free).collect();
                    if !row.is_empty() {
                        dependent.insert(dof as u32, row);
                    }
                }
            }
        }
        DofMap { free_of_dof, dof_of_free: elimination.free().to_vec(), dependent, of_mesh: 3 * nodes }
    }

    /// True if every free index is a dof of the mesh, and no dof depends on others.
    pub fn is_direct(&self) -> bool {
        let last = self.dof_of_free.last().is_none_or(|&dof| (dof as usize) < self.n_dof());
        self.dependent.is_empty() && last
    }

    /// The rows of dependent dofs as inputs of a stage.
    pub(super) fn add_dependent(&self, inputs: Inputs) -> Inputs {
        self.dependent.iter().fold(inputs, |inputs, (dof, row)| {
            let (indices, weights): (Vec<u32>, Vec<f64>) = row.iter().copied().unzip();
            inputs.value(dof).indices(&indices).numbers(&weights)
        })
    }

    /// Number of free dofs.
    pub fn n_free(&self) -> usize {
        self.dof_of_free.len()
    }

    /// Number of dofs of the mesh, three per node.
    pub fn n_dof(&self) -> usize {
        self.of_mesh
    }

    /// Free index of a dof; `None` if it is held or depends on others.
    pub fn free(&self, dof: usize) -> Option<u32> {
        Some(self.free_of_dof[dof]).filter(|&free| free != CONSTRAINED)
    }

    /// Row of `T`: free indices and weights of a dof, none if it is held.
    pub fn terms(&self, dof: usize) -> impl Iterator<Item = (u32, f64)> + '_ {
        let own = self.free(dof);
        let others = if own.is_none() { self.row(dof) } else { &[] };
        own.map(|free| (free, 1.0)).into_iter().chain(others.iter().copied())
    }

    /// True if a dof cannot move.
    pub fn is_held(&self, dof: usize) -> bool {
        self.free(dof).is_none() && self.row(dof).is_empty()
    }

    /// Value of a dof, from those of the free ones.
    pub fn value(&self, dof: usize, free: impl Fn(usize) -> f64) -> f64 {
        match self.free(dof) {
            Some(index) => free(index as usize),
            None => {
                self.row(dof).iter().fold(0.0, |sum, &(index, weight)| sum + weight * free(index as usize))
            }
        }
    }

    /// Free indices and weights of a dependent dof.
    fn row(&self, dof: usize) -> &[(u32, f64)] {
        if self.dependent.is_empty() {
            return &[];
        }
        self.dependent.get(&(dof as u32)).map_or(&[], |row| row)
    }

    /// Dof of each free index, ascending; those from [`DofMap::n_dof`] on belong to reference points, six
    /// each.
    pub fn dof_of_free(&self) -> &[u32] {
        &self.dof_of_free
    }

    /// Free values to all dofs, `T û`: zero where held.
    ///
    /// # Panics
    /// If the lengths are not `n_free` and `n_dof`.
    pub fn expand_into(&self, free: &[f64], full: &mut [f64]) {
        assert!(free.len() == self.n_free() && full.len() == self.n_dof());
        full.fill(0.0);
        for (&value, &dof) in free.iter().zip(&self.dof_of_free) {
            if let Some(place) = full.get_mut(dof as usize) {
                *place = value;
            }
        }
        for (&dof, _) in self.dependent.range(..self.of_mesh as u32) {
            full[dof as usize] = self.value(dof as usize, |index| free[index]);
        }
    }

    /// Forces at all dofs to the free ones, `Tᵀ f`.
    ///
    /// # Panics
    /// If the lengths are not `n_dof` and `n_free`.
    pub fn gather_into(&self, full: &[f64], free: &mut [f64]) {
        assert!(free.len() == self.n_free() && full.len() == self.n_dof());
        for (value, &dof) in free.iter_mut().zip(&self.dof_of_free) {
            *value = full.get(dof as usize).copied().unwrap_or(0.0);
        }
        for (&dof, row) in self.dependent.range(..self.of_mesh as u32) {
            row.iter().for_each(|&(index, weight)| free[index as usize] += weight * full[dof as usize]);
        }
    }

    /// Values of the free dofs, from those at all dofs of the mesh. Motions of reference points are those
    /// that fit the dofs that follow them best; zero where none does.
    ///
    /// # Panics
    /// If the lengths are not `n_dof` and `n_free`.
    pub fn restrict_into(&self, full: &[f64], free: &mut [f64]) {
        assert!(free.len() == self.n_free() && full.len() == self.n_dof());
        for (value, &dof) in free.iter_mut().zip(&self.dof_of_free) {
            *value = full.get(dof as usize).copied().unwrap_or(0.0);
        }
        let direct = self.dof_of_free.partition_point(|&dof| (dof as usize) < self.n_dof());
        let n = self.n_free() - direct;
        let (mut normal, mut right) = (Mat::<f64>::zeros(n, n), vec![0.0; n]);
        for (&dof, row) in self.dependent.range(..self.of_mesh as u32).filter(|_| n > 0) {
            let (own, others): (Vec<_>, Vec<_>) = row.iter().partition(|term| term.0 as usize >= direct);
            let known: f64 = others.iter().map(|&(index, weight)| weight * free[index as usize]).sum();
            for &(i, weight) in &own {
                right[i as usize - direct] += weight * (full[dof as usize] - known);
                own.iter().for_each(|&(j, other)| {
                    normal[(i as usize - direct, j as usize - direct)] += weight * other
                });
            }
        }
        let Ok((values, vectors)) = symmetric_eigen(normal.as_ref()) else { return };
        let largest = values.last().copied().unwrap_or(0.0);
        for k in (0..n).filter(|&k| values[k] > ROUNDING * largest) {
            let along: f64 = (0..n).map(|i| vectors[(i, k)] * right[i]).sum();
            (0..n).for_each(|i| free[direct + i] += vectors[(i, k)] * along / values[k]);
        }
    }
}
