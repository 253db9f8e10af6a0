//! Forces that the residual flexibility answers: those on nodes of contacts, and amplitudes of load patterns.

use crate::base::error::LoadError;
use crate::base::lend::{Lender, Short};
use crate::base::scalar::Scalar;
use crate::base::vec3::dot;
use crate::sections::contact::Shares;

/// A 3×3 block, row by row: displacement by force \[m/N\].
pub(crate) type Block = [[f64; 3]; 3];

pub(crate) fn times(block: Block, force: [f64; 3]) -> [f64; 3] {
    block.map(|row| dot(row, force))
}

/// Forces on nodes and amplitudes of patterns, in lent memory.
#[derive(Debug)]
pub(crate) struct Statics<'m, T> {
    /// A node and the force on it; the first `used` count.
    pub(super) forces: &'m mut [[T; 4]],
    /// Place at rest of the contact of each of these forces \[m\]: of a file with a contact patch, where
    /// contacts at different places have forces of their own on the same node; else empty.
    pub(super) places: &'m mut [[T; 3]],
    pub(super) used: usize,
    pub(super) patterns: &'m mut [T],
    pub(super) some_pattern: bool,
    /// Something may have acted that is not known any more.
    pub forgotten: bool,
}

impl<'m, T: Scalar> Statics<'m, T> {
    /// Nothing acts.
    pub fn new(
        [nodes, patterns]: [usize; 2],
        has_patch: bool,
        memory: &mut Lender<&'m mut [T]>,
    ) -> Result<Self, Short> {
        let (forces, patterns) = (memory.take(4 * nodes)?.as_chunks_mut().0, memory.take(patterns)?);
        let places = memory.take(if has_patch { 3 * nodes } else { 0 })?.as_chunks_mut().0;
        patterns.fill(T::ZERO);
        Ok(Self { forces, places, used: 0, patterns, some_pattern: false, forgotten: false })
    }

    /// Takes everything away.
    pub fn clear(&mut self) {
        self.used = 0;
        self.forgotten = false;
        if self.some_pattern {
            self.patterns.fill(T::ZERO);
            self.some_pattern = false;
        }
    }

    /// Nothing is shown of what has acted, and nothing that depends on it is reported.
    pub fn forget(&mut self) {
        self.clear();
        self.forgotten = true;
    }

    /// `true` if nothing acts.
    pub const fn is_empty(&self) -> bool {
        self.used == 0 && !self.some_pattern
    }

    /// Copies what acts on another. Every step does this, so it does no more than it must.
    #[inline(always)]
    pub fn copy(&mut self, other: &Statics<'_, T>) {
        self.forgotten = false;
        if let (Some(to), Some(from)) = (self.forces.get_mut(..other.used), other.forces.get(..other.used)) {
            to.copy_from_slice(from);
            self.used = other.used;
        }
        if let (Some(to), Some(from)) = (self.places.get_mut(..other.used), other.places.get(..other.used)) {
            to.copy_from_slice(from);
        }
        if (self.some_pattern || other.some_pattern) && self.patterns.len() == other.patterns.len() {
            self.patterns.copy_from_slice(other.patterns);
            self.some_pattern = other.some_pattern;
        }
    }

    /// Refuses a contact whose nodes there is no room for: so many for each contact.
    pub fn check(&self, shares: &Shares<'_, T>, at: [f64; 3], each: usize) -> Result<(), LoadError> {
        let capacity = self.forces.len();
        if capacity == 0 || self.used + shares.count() <= capacity {
            return Ok(());
        }
        let at = at.map(T::from_f64);
        let known = |node: u32| self.place(T::from_f64(f64::from(node)), at).is_some();
        let mut new = 0;
        for (place, (node, _)) in shares.entries().enumerate() {
            let before = shares.entries().take(place).any(|(other, _)| other == node);
            new += usize::from(!before && !known(node));
        }
        if self.used + new <= capacity {
            Ok(())
        } else {
            Err(LoadError::TooManyContacts { contacts: capacity / each.max(1) })
        }
    }

    /// Adds a contact at a place that was checked.
    pub fn add_contact(&mut self, shares: &Shares<'_, T>, at: [f64; 3], force: [f64; 3], amplitude: f64) {
        if self.forces.is_empty() || amplitude == 0.0 {
            return;
        }
        let at = at.map(T::from_f64);
        for (node, weight) in shares.entries() {
            let number = T::from_f64(f64::from(node));
            let known = self.place(number, at);
            let place = known.unwrap_or(self.used);
            let Some([node, sum @ ..]) = self.forces.get_mut(place) else { return };
            if known.is_none() {
                *node = number;
                *sum = [T::ZERO; 3];
                self.used += 1;
                if let Some(place) = self.places.get_mut(place) {
                    *place = at;
                }
            }
            for (sum, force) in sum.iter_mut().zip(force) {
                *sum += T::from_f64(weight * amplitude * force);
            }
        }
    }

    /// Number of the force on a node, if there is one; with a contact patch that of contacts at this place.
    pub(super) fn place(&self, node: T, at: [T; 3]) -> Option<usize> {
        let mut known = self.forces.iter().take(self.used);
        if self.places.is_empty() {
            return known.position(|[other, ..]| *other == node);
        }
        known.zip(&*self.places).position(|([other, ..], place)| *other == node && *place == at)
    }

    /// Place of the contact of a force; zero without a contact patch.
    pub(super) fn place_of(&self, force: usize) -> [T; 3] {
        self.places.get(force).copied().unwrap_or([T::ZERO; 3])
    }

    /// `true` where forces have the places of their contacts.
    pub const fn has_places(&self) -> bool {
        !self.places.is_empty()
    }

    /// Places of the contacts of all forces \[m\]; none without a contact patch.
    pub fn places(&self) -> impl Iterator<Item = [f64; 3]> {
        self.places.iter().take(self.used).map(|place| place.map(T::to_f64))
    }

    /// Adds a pattern.
    pub fn add_pattern(&mut self, index: usize, amplitude: f64) {
        if let Some(sum) = self.patterns.get_mut(index) {
            *sum += T::from_f64(amplitude);
            self.some_pattern = true;
        }
    }

    /// Adds a force on a node that none acts on yet, at a place.
    pub fn add_force(&mut self, node: f64, force: [f64; 3], at: [f64; 3]) {
        if let Some([number, sum @ ..]) = self.forces.get_mut(self.used) {
            (*number, *sum) = (T::from_f64(node), force.map(T::from_f64));
            if let Some(place) = self.places.get_mut(self.used) {
                *place = at.map(T::from_f64);
            }
            self.used += 1;
        }
    }

    /// Amplitudes of all patterns.
    pub fn all_amplitudes(&self) -> impl Iterator<Item = f64> {
        self.patterns.iter().map(|amplitude| amplitude.to_f64())
    }

    /// Nodes and the forces on them \[N\].
    pub fn forces(&self) -> impl Iterator<Item = (usize, [f64; 3])> {
        let known = self.forces.iter().take(self.used);
        known.map(|&[node, x, y, z]| (node.to_f64() as usize, [x, y, z].map(T::to_f64)))
    }

    /// Patterns that act, and their amplitudes.
    pub fn amplitudes(&self) -> impl Iterator<Item = (usize, f64)> {
        let all = self.patterns.iter().map(|amplitude| amplitude.to_f64()).enumerate();
        all.take(if self.some_pattern { usize::MAX } else { 0 }).filter(|&(_, amplitude)| amplitude != 0.0)
    }
}
