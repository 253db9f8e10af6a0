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
        self.recover(full, free);
    }

    /// The motions of reference points from the dofs that follow them: least squares, for each set of motions
    /// that have followers in common.
    fn recover(&self, full: &[f64], free: &mut [f64]) {
        let direct = self.dof_of_free.partition_point(|&dof| (dof as usize) < self.n_dof());
        let mut sets = Sets((0..self.n_free() - direct).collect());
        let followers = || self.dependent.range(..self.of_mesh as u32);
        let own = |row: &[(u32, f64)]| -> Vec<(usize, f64)> {
            row.iter().filter_map(|&(index, a)| Some(((index as usize).checked_sub(direct)?, a))).collect()
        };
        for (_, row) in followers() {
            own(row).windows(2).for_each(|pair| sets.join(pair[0].0, pair[1].0));
        }
        let mut members: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        (0..sets.0.len()).for_each(|motion| members.entry(sets.of(motion)).or_default().push(motion));
        let mut own_followers: BTreeMap<usize, Vec<u32>> = BTreeMap::new();
        for (&dof, row) in followers() {
            if let Some(first) = own(row).first() {
                own_followers.entry(sets.of(first.0)).or_default().push(dof);
            }
        }
        for (set, dofs) in own_followers {
            let members = &members[&set];
            let n = members.len();
            let place = |motion: usize| members.binary_search(&motion).expect("a motion of the set");
            let (mut normal, mut right) = (Mat::<f64>::zeros(n, n), vec![0.0; n]);
            for dof in dofs {
                let row = self.row(dof as usize);
                let others = row.iter().filter(|term| (term.0 as usize) < direct);
                let known: f64 = others.map(|&(index, a)| a * free[index as usize]).sum();
                let own: Vec<(usize, f64)> = own(row).iter().map(|&(motion, a)| (place(motion), a)).collect();
                for &(i, a) in &own {
                    right[i] += a * (full[dof as usize] - known);
                    own.iter().for_each(|&(j, b)| normal[(i, j)] += a * b);
                }
            }
            let Ok((values, vectors)) = symmetric_eigen(normal.as_ref()) else { return };
            let largest = values.last().copied().unwrap_or(0.0);
            for k in (0..n).filter(|&k| values[k] > ROUNDING * largest) {
                let along: f64 = (0..n).map(|i| vectors[(i, k)] * right[i]).sum();
                (0..n).for_each(|i| free[direct + members[i]] += vectors[(i, k)] * along / values[k]);
            }
        }
    }
}

/// Sets of numbers that are joined, each known by one of its members.
struct Sets(Vec<usize>);

impl Sets {
    fn of(&mut self, mut member: usize) -> usize {
        while self.0[member] != member {
            self.0[member] = self.0[self.0[member]];
            member = self.0[member];
        }
        member
    }

    fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.of(a), self.of(b));
        self.0[a.max(b)] = a.min(b);
    }
}

#[cfg(test)]
mod tests {
    use super::super::coupling::rigid_row;
    use super::super::elimination::Constraints;
    use super::*;
    use crate::linalg::vec3::sub;

    #[test]
    fn motions_of_reference_points_are_found_from_what_follows_them() {
        // Four nodes follow one point, one follows another, and one is free.
        let nodes = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.2], [0.0, 0.3, 1.0], [2.0, 0.0, 0.0]];
        let points = [[0.5, 0.5, 0.5], [2.0, 0.0, 0.0]];
        let (n, mut constraints) = (nodes.len() + 1, Constraints::default());
        for (node, &at) in nodes.iter().enumerate() {
            let point = usize::from(node == 4);
            for c in 0..3 {
                let first = (3 * n + 6 * point) as u32;
                let row = (first..).zip(rigid_row(sub(at, points[point]), c)).map(|(dof, a)| (dof, -a));
                let terms = std::iter::once(((3 * node + c) as u32, 1.0)).chain(row);
                constraints.equate(terms.filter(|term| term.1 != 0.0).collect(), "a test");
            }
        }
        // Nothing turns the second point.
        (3..6).for_each(|c| constraints.hold((3 * n + 6 + c) as u32, 0.0));
        let dofs = DofMap::of_elimination(n, &constraints.eliminate(3 * n + 12).unwrap());
        assert_eq!((dofs.n_free(), dofs.is_direct()), (12, false));
        let free: Vec<f64> = (0..12).map(|k| (k as f64 * 0.7).sin()).collect();
        let (mut full, mut found) = (vec![0.0; 3 * n], vec![0.0; 12]);
        dofs.expand_into(&free, &mut full);
        dofs.restrict_into(&full, &mut found);
        assert!(free.iter().zip(&found).all(|(a, b)| (a - b).abs() < 1e-12), "{found:?}");
        // Work is the same in both sets of dofs.
        let force: Vec<f64> = (0..3 * n).map(|k| (k as f64).cos()).collect();
        let mut gathered = vec![0.0; 12];
        dofs.gather_into(&force, &mut gathered);
        let work = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        assert!((work(&force, &full) - work(&gathered, &free)).abs() < 1e-12);
    }
}
