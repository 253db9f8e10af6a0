//! Residual flexibility: the static answer `R F` that the modes leave out, where the file has it, for the
//! forces on the nodes of contacts and for load patterns.
//!
//! A file holds `R` between a loadable node and itself, and between two that share a facet; between others
//! it is taken as zero. A state remembers the forces of its last step, so that outputs show the modes and the
//! residual together. With stiffness-proportional damping these forces are filtered
//! ([`crate::sections::filter`]).

use crate::base::error::LoadError;
use crate::base::lend::{Lender, Short};
use crate::base::scalar::Scalar;
use crate::base::vec3::dot;
use crate::sections::contact::Contact;
use vademecum_format::{File, Numbers, SectionKind};

/// The sections of the residual; `None` where they are absent or compressed.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Residual<'m> {
    nodes: Option<Numbers<'m>>,
    pairs: &'m [[[u8; 4]; 2]],
    pair_blocks: Option<Numbers<'m>>,
    probes: Option<Numbers<'m>>,
    patterns: Option<Numbers<'m>>,
    pattern_probes: Option<Numbers<'m>>,
    n_load_nodes: usize,
    n_probes: usize,
}

/// A 3×3 block, row by row: displacement by force \[m/N\].
type Block = [[f64; 3]; 3];

/// Numbers of nodes and patterns whose forces a scene remembers; zeros where nothing is made of them.
pub(crate) fn room<T: Scalar>(file: &File<'_>, contacts: usize, residual: bool) -> [usize; 2] {
    use SectionKind as S;
    let metadata = file.metadata();
    let there = |kind| residual && file.section(kind).is_some_and(|s| s.numbers().is_ok());
    // The number of a node has to be a number of the precision.
    let countable = f64::from(metadata.n_load_nodes) * T::EPSILON < 0.5;
    let reactions = file.section(S::ReactionBasis).is_some_and(|s| s.f64s().is_ok());
    let remembered = (there(S::ContactResidual) || reactions) && countable;
    let nodes = if remembered { contacts.saturating_mul(file.contact_nodes()) } else { 0 };
    let patterns = there(S::PatternResidual) || there(S::PatternProbeResidual) || reactions;
    [nodes, if patterns { metadata.n_patterns as usize } else { 0 }]
}

impl<'m> Residual<'m> {
    /// Looks the sections up.
    pub fn of(file: &File<'m>) -> Self {
        let optional = |kind| file.section(kind).and_then(|section| section.numbers().ok());
        let pairs = file.section(SectionKind::ResidualPairs).and_then(|section| section.u32s().ok());
        let metadata = file.metadata();
        Self {
            nodes: optional(SectionKind::ContactResidual),
            pairs: pairs.map_or(&[], |pairs| pairs.as_chunks().0),
            pair_blocks: optional(SectionKind::PairResidual),
            probes: optional(SectionKind::ProbeResidual),
            patterns: optional(SectionKind::PatternResidual),
            pattern_probes: optional(SectionKind::PatternProbeResidual),
            n_load_nodes: metadata.n_load_nodes as usize,
            n_probes: metadata.n_probes as usize,
        }
    }

    /// `true` for a file without any of it.
    pub const fn is_empty(&self) -> bool {
        let of_contacts = self.nodes.is_some() || self.probes.is_some();
        !(of_contacts || self.patterns.is_some() || self.pattern_probes.is_some())
    }

    /// `R` between two loadable nodes; zero where the file does not have it.
    pub fn between(&self, a: usize, b: usize) -> Block {
        let known = if a == b { self.own(a) } else { self.of_pair(a, b) };
        known.unwrap_or_default()
    }

    fn own(&self, node: usize) -> Option<Block> {
        let row = self.nodes?.row(node.checked_mul(6)?, 6)?;
        let [xx, xy, xz, yy, yz, zz] = core::array::from_fn(|k| row.get(k).unwrap_or(0.0));
        Some([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    }

    fn of_pair(&self, a: usize, b: usize) -> Option<Block> {
        let wanted = [a.min(b), a.max(b)];
        let place =
            self.pairs.binary_search_by_key(&wanted, |pair| pair.map(|n| u32::from_le_bytes(n) as usize));
        let block = self.pair_blocks?.row(place.ok()?.checked_mul(9)?, 9)?;
        let at = |row: usize, column: usize| block.get(3 * row + column).unwrap_or(0.0);
        let first_is_shown = a <= b;
        Some(core::array::from_fn(|i| {
            core::array::from_fn(|j| if first_is_shown { at(i, j) } else { at(j, i) })
        }))
    }

    /// `R F` at a node for the forces of a state; zero at nodes that cannot be loaded.
    pub fn node<T: Scalar>(&self, node: usize, acting: &Statics<'_, T>) -> [f64; 3] {
        if node >= self.n_load_nodes {
            return [0.0; 3];
        }
        let mut sum = self.of_forces(node, acting);
        let Some(patterns) = self.patterns else { return sum };
        for (pattern, amplitude) in acting.amplitudes() {
            let row = patterns.row((pattern * self.n_load_nodes + node) * 3, 3);
            for (component, sum) in sum.iter_mut().enumerate() {
                *sum += amplitude * row.and_then(|row| row.get(component)).unwrap_or(0.0);
            }
        }
        sum
    }

    /// The same for the forces on nodes alone.
    fn of_forces<T: Scalar>(&self, node: usize, acting: &Statics<'_, T>) -> [f64; 3] {
        let mut sum = [0.0; 3];
        for (loaded, force) in acting.forces() {
            let answer = times(self.between(node, loaded), force);
            sum.iter_mut().zip(answer).for_each(|(sum, answer)| *sum += answer);
        }
        sum
    }

    /// A probe's value of `R F`.
    pub fn probe<T: Scalar>(&self, probe: usize, acting: &Statics<'_, T>) -> f64 {
        let at_node = |(node, force): (usize, [f64; 3])| {
            let row = self.probes?.row((probe * self.n_load_nodes + node) * 3, 3)?;
            Some(force.iter().enumerate().map(|(c, f)| row.get(c).unwrap_or(0.0) * f).sum::<f64>())
        };
        let of_pattern = |(pattern, amplitude): (usize, f64)| {
            Some(amplitude * self.pattern_probes?.get(pattern * self.n_probes + probe)?)
        };
        let forces: f64 = acting.forces().filter_map(at_node).sum();
        forces + acting.amplitudes().filter_map(of_pattern).sum::<f64>()
    }

    /// `½ Fᵀ R F` \[J\] of the forces on nodes.
    pub fn energy<T: Scalar>(&self, acting: &Statics<'_, T>) -> f64 {
        let work = acting.forces().map(|(node, force)| dot(force, self.of_forces(node, acting)));
        0.5 * work.sum::<f64>()
    }

    /// Derivative of [`Residual::energy`] along other forces: `F'ᵀ R F` \[J\].
    pub fn energy_along<T: Scalar>(&self, acting: &Statics<'_, T>, direction: &Statics<'_, T>) -> f64 {
        direction.forces().map(|(node, force)| dot(force, self.of_forces(node, acting))).sum()
    }

    /// Adds `R F` to the loadable nodes of a surface, `out` of shape `(any, 3)`.
    pub fn add_to_surface<T: Scalar>(&self, acting: &Statics<'_, T>, scale: f64, out: &mut [T]) {
        if acting.is_empty() {
            return;
        }
        let mut add = |node: usize, block: Block, force: [f64; 3]| {
            let place = out.iter_mut().skip(3 * node);
            let answer = times(block, force);
            place.zip(answer).for_each(|(out, answer)| *out += T::from_f64(scale * answer));
        };
        for (node, force) in acting.forces() {
            add(node, self.between(node, node), force);
        }
        for pair in self.pairs {
            let [a, b] = pair.map(|n| u32::from_le_bytes(n) as usize);
            for (node, force) in acting.forces().filter(|&(node, _)| node == a || node == b) {
                let other = if node == a { b } else { a };
                add(other, self.between(other, node), force);
            }
        }
        let Some(patterns) = self.patterns else { return };
        for (pattern, amplitude) in acting.amplitudes() {
            let start = 3 * pattern * self.n_load_nodes;
            if let Some(rows) = patterns.row(start, 3 * self.n_load_nodes) {
                let values = rows.iter().map(|value| T::from_f64(scale * amplitude * value));
                out.iter_mut().zip(values).for_each(|(out, value)| *out += value);
            }
        }
    }
}

fn times(block: Block, force: [f64; 3]) -> [f64; 3] {
    block.map(|row| dot(row, force))
}

/// Forces on nodes and amplitudes of patterns, in lent memory.
#[derive(Debug)]
pub(crate) struct Statics<'m, T> {
    /// A node and the force on it; the first `used` count.
    pub(super) forces: &'m mut [[T; 4]],
    pub(super) used: usize,
    pub(super) patterns: &'m mut [T],
    pub(super) some_pattern: bool,
    /// Something may have acted that is not known any more.
    pub forgotten: bool,
}

impl<'m, T: Scalar> Statics<'m, T> {
    /// Nothing acts.
    pub fn new([nodes, patterns]: [usize; 2], memory: &mut Lender<&'m mut [T]>) -> Result<Self, Short> {
        let (forces, patterns) = (memory.take(4 * nodes)?.as_chunks_mut().0, memory.take(patterns)?);
        patterns.fill(T::ZERO);
        Ok(Self { forces, used: 0, patterns, some_pattern: false, forgotten: false })
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
        if (self.some_pattern || other.some_pattern) && self.patterns.len() == other.patterns.len() {
            self.patterns.copy_from_slice(other.patterns);
            self.some_pattern = other.some_pattern;
        }
    }

    /// Refuses a contact whose nodes there is no room for: so many for each contact.
    pub fn check(&self, contact: &Contact, each: usize) -> Result<(), LoadError> {
        let capacity = self.forces.len();
        if capacity == 0 || self.used + contact.place.nodes().len() <= capacity {
            return Ok(());
        }
        let known = |node: u32| self.place(T::from_f64(f64::from(node))).is_some();
        let mut new = 0;
        for (place, &node) in contact.place.nodes().iter().enumerate() {
            let before = contact.place.nodes().iter().take(place).any(|&other| other == node);
            new += usize::from(!before && !known(node));
        }
        if self.used + new <= capacity {
            Ok(())
        } else {
            Err(LoadError::TooManyContacts { contacts: capacity / each.max(1) })
        }
    }

    /// Adds a contact that was checked.
    pub fn add_contact(&mut self, contact: &Contact, amplitude: f64) {
        if self.forces.is_empty() || amplitude == 0.0 {
            return;
        }
        for (node, weight) in contact.place.entries() {
            let number = T::from_f64(f64::from(node));
            let known = self.place(number);
            let place = known.unwrap_or(self.used);
            let Some([at, sum @ ..]) = self.forces.get_mut(place) else { return };
            if known.is_none() {
                *at = number;
                *sum = [T::ZERO; 3];
                self.used += 1;
            }
            for (sum, force) in sum.iter_mut().zip(contact.force) {
                *sum += T::from_f64(weight * amplitude * force);
            }
        }
    }

    /// Place of a node, if a force acts on it.
    pub(super) fn place(&self, node: T) -> Option<usize> {
        self.forces.iter().take(self.used).position(|[other, ..]| *other == node)
    }

    /// Adds a pattern.
    pub fn add_pattern(&mut self, index: usize, amplitude: f64) {
        if let Some(sum) = self.patterns.get_mut(index) {
            *sum += T::from_f64(amplitude);
            self.some_pattern = true;
        }
    }

    /// Adds a force on a node that none acts on yet.
    pub fn add_force(&mut self, node: f64, force: [f64; 3]) {
        if let Some([at, sum @ ..]) = self.forces.get_mut(self.used) {
            (*at, *sum) = (T::from_f64(node), force.map(T::from_f64));
            self.used += 1;
        }
    }

    /// Multiplies all of it.
    #[cfg(feature = "full")]
    pub fn scale(&mut self, factor: T) {
        for [_, force @ ..] in self.forces.iter_mut().take(self.used) {
            force.iter_mut().for_each(|force| *force = factor * *force);
        }
        self.patterns.iter_mut().for_each(|amplitude| *amplitude = factor * *amplitude);
    }

    /// Adds the forces of another; false, and some are left out, where there is no room for them.
    #[cfg(feature = "full")]
    pub fn add_all(&mut self, other: &Statics<'_, T>) -> bool {
        for &[node, ref added @ ..] in other.forces.iter().take(other.used) {
            let known = self.place(node);
            let Some([at, sum @ ..]) = self.forces.get_mut(known.unwrap_or(self.used)) else { return false };
            if known.is_none() {
                (*at, *sum) = (node, [T::ZERO; 3]);
                self.used += 1;
            }
            sum.iter_mut().zip(added).for_each(|(sum, &added)| *sum += added);
        }
        true
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
