//! Linear constraints between displacements, solved for dependent ones: `u = T û`.
//!
//! A constraint is `Σ_i a_i u_i = 0`. They are taken one after the other: dofs that are dependent already
//! are replaced, and the equation is solved for one of those that are left. Chains (a reference point
//! that follows another one) and dofs that several constraints name are resolved by that alone; what is
//! left without an unknown is redundant or contradicts the others.

use std::collections::BTreeMap;

/// A share below this of the largest one is rounding.
const ROUNDING: f64 = 1e-10;

/// Constraints of a body while they are collected.
#[derive(Clone, Debug, Default)]
pub struct Constraints {
    /// Dofs with a given value.
    held: BTreeMap<u32, f64>,
    equations: Vec<Equation>,
}

/// `Σ_i a_i u_i = 0`.
#[derive(Clone, Debug)]
struct Equation {
    /// Dofs and coefficients; the first is the one to be solved for, if it can be.
    terms: Vec<(u32, f64)>,
    /// Origin, for messages.
    origin: String,
}

/// Constraints that cannot hold at once.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{origin}: its displacements are fixed by other constraints and supports, and contradict it")]
pub struct Contradiction {
    /// Origin of the constraint.
    pub origin: String,
}

/// `u = T (û, v)`: every dof as a combination of free dofs and of dofs whose value `v` is given.
#[derive(Clone, Debug, PartialEq)]
#[doc(alias("multi-point constraint", "master-slave elimination"))]
pub struct Elimination {
    starts: Vec<u32>,
    terms: Vec<(u32, f64)>,
    /// Dof of each free index, ascending.
    free: Vec<u32>,
    /// Dofs with a given value, ascending, and the values.
    held: Vec<(u32, f64)>,
}

impl Constraints {
    /// Gives a dof a value; the last one counts.
    pub fn hold(&mut self, dof: u32, value: f64) {
        self.held.insert(dof, value);
    }

    /// Releases a dof that was held.
    pub fn release(&mut self, dof: u32) {
        self.held.remove(&dof);
    }

    /// Adds `Σ_i a_i u_i = 0`, to be solved for the first of its dofs if that is not taken; `origin` names it
    /// in messages.
    pub fn equate(&mut self, terms: Vec<(u32, f64)>, origin: impl Into<String>) {
        self.equations.push(Equation { terms, origin: origin.into() });
    }

    /// Dofs of the equations.
    pub fn dofs(&self) -> impl Iterator<Item = u32> {
        self.equations.iter().flat_map(|equation| equation.terms.iter().map(|term| term.0))
    }

    /// Terms of each equation, and its origin.
    pub(super) fn equations(&self) -> impl Iterator<Item = (&[(u32, f64)], &str)> {
        self.equations.iter().map(|equation| (equation.terms.as_slice(), equation.origin.as_str()))
    }

    /// True of a dof with a given value.
    pub(super) fn holds(&self, dof: u32) -> bool {
        self.held.contains_key(&dof)
    }

    /// Solves for the dependent ones of `n` dofs.
    ///
    /// # Errors
    /// [`Contradiction`].
    pub fn eliminate(&self, n: usize) -> Result<Elimination, Contradiction> {
        let mut rows: BTreeMap<u32, Vec<(u32, f64)>> = BTreeMap::new();
        let mut order = Vec::new();
        for equation in &self.equations {
            let size = equation.terms.iter().fold(0.0_f64, |most, (_, a)| most.max(a.abs()));
            let left = substituted(&equation.terms, &rows);
            let open = |dof: &u32| !self.held.contains_key(dof);
            let first = equation.terms.first().map(|term| term.0);
            let weight = |dof: u32| left.get(&dof).copied().unwrap_or(0.0);
            let wanted = first.filter(|dof| open(dof) && weight(*dof).abs() > ROUNDING * size);
            let largest = left.iter().filter(|(dof, a)| open(dof) && a.abs() > ROUNDING * size);
            let largest = largest.max_by(|a, b| a.1.abs().total_cmp(&b.1.abs())).map(|(dof, _)| *dof);
            let Some(pivot) = wanted.or(largest) else {
                let rest: f64 = left.iter().map(|(dof, a)| a * self.held.get(dof).unwrap_or(&0.0)).sum();
                let values = left.keys().map(|dof| self.held.get(dof).unwrap_or(&0.0).abs());
                if rest.abs() > ROUNDING * size * values.fold(0.0, f64::max) {
                    return Err(Contradiction { origin: equation.origin.clone() });
                }
                continue;
            };
            let divisor = -weight(pivot);
            let row = left.into_iter().filter(|(dof, _)| *dof != pivot);
            let row = row.map(|(dof, a)| (dof, a / divisor)).filter(|(_, a)| *a != 0.0).collect();
            rows.insert(pivot, row);
            order.push(pivot);
        }
        // A row holds dofs that became dependent after it, and none from before: from the last one on, each
        // is replaced once.
        let mut resolved = BTreeMap::new();
        for pivot in order.into_iter().rev() {
            let row = substituted(&rows[&pivot], &resolved).into_iter().filter(|(_, a)| *a != 0.0);
            resolved.insert(pivot, row.collect());
        }
        Ok(self.numbered(n, &resolved))
    }

    /// Numbers the free dofs and then the held ones.
    fn numbered(&self, n: usize, rows: &BTreeMap<u32, Vec<(u32, f64)>>) -> Elimination {
        let is_free = |dof: &u32| !self.held.contains_key(dof) && !rows.contains_key(dof);
        let free: Vec<u32> = (0..n as u32).filter(is_free).collect();
        let mut number = vec![u32::MAX; n];
        for (place, &dof) in free.iter().chain(self.held.keys()).enumerate() {
            number[dof as usize] = place as u32;
        }
        let (mut starts, mut terms) = (vec![0], Vec::with_capacity(n));
        for dof in 0..n as u32 {
            match rows.get(&dof) {
                None => terms.push((number[dof as usize], 1.0)),
                Some(row) => terms.extend(row.iter().map(|&(dof, a)| (number[dof as usize], a))),
            }
            starts.push(terms.len() as u32);
        }
        let held = self.held.iter().map(|(&dof, &value)| (dof, value)).collect();
        Elimination { starts, terms, free, held }
    }
}

/// Terms without dependent dofs. A dependent dof was written in dofs that were not dependent before it, so
/// this ends.
fn substituted(terms: &[(u32, f64)], rows: &BTreeMap<u32, Vec<(u32, f64)>>) -> BTreeMap<u32, f64> {
    let mut done: BTreeMap<u32, f64> = BTreeMap::new();
    let mut open: Vec<(u32, f64)> = terms.to_vec();
    while !open.is_empty() {
        // Equal dofs are summed before they are replaced: chains that meet again do not double.
        let mut next: BTreeMap<u32, f64> = BTreeMap::new();
        for (dof, a) in open.drain(..) {
            match rows.get(&dof) {
                None => *done.entry(dof).or_default() += a,
                Some(row) => row.iter().for_each(|&(other, b)| *next.entry(other).or_default() += a * b),
            }
        }
        open.extend(next);
    }
    done
}

impl Elimination {
    /// Number of free dofs.
    pub fn n_free(&self) -> usize {
        self.free.len()
    }

    /// Number of all dofs.
    pub fn n_dof(&self) -> usize {
        self.starts.len() - 1
    }

    /// Dof of each free index, ascending.
    pub fn free(&self) -> &[u32] {
        &self.free
    }

    /// Dofs with a given value, and the values.
    pub fn held(&self) -> &[(u32, f64)] {
        &self.held
    }

    /// Indices and coefficients of a dof; indices from [`Elimination::n_free`] on are those of held dofs.
    pub fn terms(&self, dof: usize) -> &[(u32, f64)] {
        &self.terms[self.starts[dof] as usize..self.starts[dof + 1] as usize]
    }

    /// True if every dof is free.
    pub fn is_trivial(&self) -> bool {
        self.n_free() == self.n_dof()
    }

    /// `u = T (û, v)`.
    ///
    /// # Panics
    /// If there is not one value for each free dof.
    pub fn expand(&self, free: &[f64]) -> Vec<f64> {
        assert_eq!(free.len(), self.n_free());
        let value = |index: u32| match free.get(index as usize) {
            Some(value) => *value,
            None => self.held[index as usize - free.len()].1,
        };
        let dof = |dof: usize| self.terms(dof).iter().map(|&(index, a)| a * value(index)).sum();
        (0..self.n_dof()).map(dof).collect()
    }

    /// `Tᵀ f`: forces on the free dofs, and those that the held dofs take.
    ///
    /// # Panics
    /// If there is not one value for each dof.
    pub fn gather(&self, forces: &[f64]) -> (Vec<f64>, Vec<f64>) {
        assert_eq!(forces.len(), self.n_dof());
        let mut sums = vec![0.0; self.free.len() + self.held.len()];
        for (dof, force) in forces.iter().enumerate() {
            for &(index, a) in self.terms(dof) {
                sums[index as usize] += a * force;
            }
        }
        let held = sums.split_off(self.free.len());
        (sums, held)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chains_and_double_owners_are_resolved() {
        let mut constraints = Constraints::default();
        // u0 = 2 u1, u1 = u2 + u3, u0 = 4 u3: so u1 = 2 u3, u2 = u3.
        constraints.equate(vec![(0, 1.0), (1, -2.0)], "a");
        constraints.equate(vec![(1, 1.0), (2, -1.0), (3, -1.0)], "b");
        constraints.equate(vec![(0, 1.0), (3, -4.0)], "c");
        let found = constraints.eliminate(5).unwrap();
        assert_eq!(found.n_free(), 2);
        let u = found.expand(&[3.0, 7.0]);
        // Of u2 and u3 one is free, and u4.
        let base = u[3];
        assert_eq!(u, [4.0 * base, 2.0 * base, base, base, 7.0]);
        // Once more is redundant.
        constraints.equate(vec![(0, 1.0), (1, -1.0), (2, -2.0)], "d");
        assert_eq!(constraints.eliminate(5).unwrap().n_free(), 2);
    }

    #[test]
    fn given_values_are_carried_and_contradictions_named() {
        let mut constraints = Constraints::default();
        constraints.hold(1, 3.0);
        constraints.equate(vec![(1, 1.0), (0, -2.0)], "half");
        let found = constraints.eliminate(2).unwrap();
        assert_eq!(found.expand(&[]), [1.5, 3.0]);
        // A force on the dependent dof goes to the held one.
        assert_eq!(found.gather(&[4.0, 1.0]), (vec![], vec![3.0]));
        constraints.hold(0, 1.0);
        let found = constraints.eliminate(2);
        assert_eq!(found, Err(Contradiction { origin: "half".into() }));
        constraints.hold(0, 1.5);
        assert!(constraints.eliminate(2).is_ok());
        constraints.release(1);
        assert_eq!(constraints.eliminate(2).unwrap().expand(&[]), [1.5, 3.0]);
    }

    #[test]
    fn equations_over_the_same_dofs_are_solved_together() {
        // Ten copies of one chain that meets again: no path is followed twice.
        let mut constraints = Constraints::default();
        for k in 0..40 {
            constraints.equate(vec![(2 * k, 1.0), (2 * k + 2, -0.5), (2 * k + 3, -0.5)], "left");
            constraints.equate(vec![(2 * k + 1, 1.0), (2 * k + 2, -0.5), (2 * k + 3, -0.5)], "right");
        }
        let found = constraints.eliminate(82).unwrap();
        let u = found.expand(&[1.0, 2.0]);
        assert!(u[..80].iter().all(|x| (x - 1.5).abs() < 1e-12), "{u:?}");
    }
}
