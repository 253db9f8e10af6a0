//! Residual flexibility: the static answer `R F` that the modes leave out, where the file has it, for the
//! forces on the nodes of contacts and for load patterns.
//!
//! A file holds `R` between a loadable node and itself, and between two that share a facet; between others
//! it is taken as zero. A file with a contact patch has it between all near nodes, and further modes for the
//! rest: then a place `c` moves by `H_c (S + ψ_cd R') H_dᵀ f_d` under the force at a contact `d`
//! ([`crate::sections::near`]). A state remembers the forces of its last step, so that outputs show the modes
//! and the residual together. With stiffness-proportional damping these forces are filtered
//! ([`crate::sections::filter`]).

use crate::base::scalar::Scalar;
use crate::base::vec3::dot;
use crate::sections::near::Near;
use crate::sections::place::Place;
use crate::sections::statics::{Block, Statics, times};
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
    /// The contact patch.
    pub near: Option<Near<'m>>,
}

/// Numbers of nodes and patterns whose forces a scene remembers; zeros where nothing is made of them.
pub(crate) fn room<T: Scalar>(file: &File<'_>, [contacts, each]: [usize; 2], residual: bool) -> [usize; 2] {
    use SectionKind as S;
    let metadata = file.metadata();
    let there = |kind| residual && file.section(kind).is_some_and(|s| s.numbers().is_ok());
    // The number of a node has to be a number of the precision.
    let countable = f64::from(metadata.n_load_nodes) * T::EPSILON < 0.5;
    let reactions = file.section(S::ReactionBasis).is_some_and(|s| s.f64s().is_ok());
    let remembered = (there(S::ContactResidual) || reactions) && countable;
    let nodes = if remembered { contacts.saturating_mul(each) } else { 0 };
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
            near: Near::of(file),
        }
    }

    /// `true` for a file without any of it.
    pub const fn is_empty(&self) -> bool {
        let of_contacts = self.nodes.is_some() || self.probes.is_some();
        !(of_contacts || self.patterns.is_some() || self.pattern_probes.is_some())
    }

    /// `R` between two loadable nodes; zero where the file does not have it.
    pub fn between(&self, a: usize, b: usize) -> Block {
        self.known(a, b).unwrap_or_default()
    }

    /// The same of two nodes of one contact: where the sections of a single contact leave it out, that of the
    /// contact patch.
    pub fn together(&self, a: usize, b: usize) -> Block {
        let near = || self.near.as_ref().map(|near| near.whole(a, b));
        self.known(a, b).or_else(near).unwrap_or_default()
    }

    /// `R` between two loadable nodes by the sections of a single contact; `None` where they leave it out.
    pub fn known(&self, a: usize, b: usize) -> Option<Block> {
        if a == b { self.own(a) } else { self.of_pair(a, b) }
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
        self.add_patterns(node, acting, &mut sum);
        sum
    }

    /// `R F` at a place with these nodes and weights, to be added with weights: `add` takes a weight and the
    /// answer of a node or, with a contact patch, of the place, which is `at` there.
    pub fn place<T: Scalar>(
        &self,
        entries: impl Iterator<Item = (usize, f64)> + Clone,
        at: [f64; 3],
        acting: &Statics<'_, T>,
        mut add: impl FnMut(f64, [f64; 3]),
    ) {
        let Some(near) = &self.near else {
            entries.for_each(|(node, weight)| add(weight, self.node(node, acting)));
            return;
        };
        if entries.clone().any(|(node, _)| node >= self.n_load_nodes) {
            return;
        }
        let mut sum = near.answer(&|a, b| self.known(a, b), entries.clone(), at, acting);
        for (node, weight) in entries {
            let mut of_node = [0.0; 3];
            self.add_patterns(node, acting, &mut of_node);
            sum.iter_mut().zip(of_node).for_each(|(sum, of_node)| *sum += weight * of_node);
        }
        add(1.0, sum);
    }

    /// Place of a contact at rest \[m\] where there is a contact patch; else zero, which is nowhere used.
    pub fn position(&self, place: &Place) -> [f64; 3] {
        let entries = place.entries().map(|(node, weight)| (node as usize, weight));
        self.near.as_ref().map_or([0.0; 3], |near| near.position(entries))
    }

    /// Adds what load patterns move at a loadable node.
    fn add_patterns<T: Scalar>(&self, node: usize, acting: &Statics<'_, T>, sum: &mut [f64; 3]) {
        let Some(patterns) = self.patterns else { return };
        for (pattern, amplitude) in acting.amplitudes() {
            let row = patterns.row((pattern * self.n_load_nodes + node) * 3, 3);
            for (component, sum) in sum.iter_mut().enumerate() {
                *sum += amplitude * row.and_then(|row| row.get(component)).unwrap_or(0.0);
            }
        }
    }

    /// The same for the forces on nodes alone.
    fn of_forces<T: Scalar>(&self, node: usize, acting: &Statics<'_, T>) -> [f64; 3] {
        if let Some(near) = &self.near {
            let only = core::iter::once((node, 1.0));
            return near.answer(&|a, b| self.known(a, b), only.clone(), near.position(only), acting);
        }
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
        if let Some(near) = &self.near {
            return near.energy(&|a, b| self.known(a, b), acting);
        }
        let work = acting.forces().map(|(node, force)| dot(force, self.of_forces(node, acting)));
        0.5 * work.sum::<f64>()
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
        if let Some(near) = &self.near {
            near.add_to_surface(&|a, b| self.known(a, b), self.n_load_nodes, acting, scale, out);
        } else {
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
