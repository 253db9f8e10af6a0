//! What acts on the body during a step, accumulated in reduced form.
//!
//! A point force enters through one row of `H` per loaded dof (reciprocity): `g_i = Σ_dof H_i[dof, ·] F[dof]`, and the fused
//! step adds `Σ_i p_i L_i g_i` with `p_i = Σ_j f_ij F_j`, the amplitude the scheme's stage `i` sees. Loads stay until they are
//! cleared, so a held contact is added once; when the scene's parameters change, what was added means nothing any more and is
//! refused until it is cleared.

use crate::canonical::{self, Held};
use crate::error::{BindError, LoadError};
use crate::kernel::{add_dense, add_row};
use crate::options::Structure;
use crate::scalar::Scalar;
use crate::scene::Scene;
use crate::shape::Shape;
use vademecum_format::scheme::MAX_STAGES;
use vademecum_format::{Numbers, SectionKind};

/// A point load on the surface: `force` \[N\], shared by three nodes with barycentric `weights` (which sum to 1).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// Loadable nodes, in file order.
    pub nodes: [u32; 3],
    /// Their shares.
    pub weights: [f64; 3],
    /// Force \[N\].
    pub force: [f64; 3],
}

/// Loads of a step, in lent memory.
#[derive(Debug)]
pub struct Loads<'m, T> {
    pub(crate) shape: Shape,
    /// `ℓ`, laid out like a state; of the canonical structure what the loads add to each stage.
    pub(crate) increment: &'m mut [T],
    /// `BᵀF` at the start of the step, length r.
    pub(crate) force: &'m mut [T],
    /// One row of `B`, then one of `H` per stage, each of length r.
    pub(crate) rows: &'m mut [T],
    /// Weights of a part's terms, of the canonical structure.
    pub(crate) scratch: &'m mut [T],
    /// The load that stands in the canonical structure's terms over state and load.
    pub(crate) held: Held,
    /// The scene's generation when the first load was added.
    pub(crate) generation: u64,
    pub(crate) active: bool,
}

/// How a load's amplitude runs over a step.
#[derive(Clone, Copy)]
pub(crate) struct Amplitudes {
    pub start: f64,
    pub stages: [f64; MAX_STAGES],
}

impl<'m, T: Scalar> Loads<'m, T> {
    /// No loads. `memory` holds at least [`crate::Sizes::loads`] numbers; what is in it does not matter.
    ///
    /// # Errors
    /// [`BindError::LentMemory`].
    pub fn new(scene: &Scene<'_, T>, memory: &'m mut [T]) -> Result<Self, BindError> {
        let shape = scene.shape;
        let (padded, r) = (shape.padded(), shape.r);
        let short = BindError::LentMemory { found: memory.len(), needed: shape.loads_len() };
        let memory = memory.get_mut(..shape.loads_len()).ok_or(short)?;
        let (increment, rest) = memory.split_at_mut_checked(padded).ok_or(short)?;
        let (force, rest) = rest.split_at_mut_checked(r).ok_or(short)?;
        let (rows, scratch) = rest.split_at_mut_checked((1 + shape.n_stages) * r).ok_or(short)?;
        let (generation, held) = (scene.generation, Held::default());
        let mut loads = Self { shape, increment, force, rows, scratch, held, generation, active: false };
        loads.clear();
        Ok(loads)
    }

    /// Takes all loads away.
    pub fn clear(&mut self) {
        self.increment.fill(T::ZERO);
        self.force.fill(T::ZERO);
        self.held = Held::default();
        self.active = false;
    }

    /// Whether anything was added since the loads were cleared.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        !self.active
    }

    /// Adds a contact held over the step.
    ///
    /// # Errors
    /// [`LoadError`]; the loads are then unchanged.
    pub fn add_contact(&mut self, scene: &Scene<'_, T>, contact: &Contact) -> Result<(), LoadError> {
        self.contact(scene, contact, Amplitudes { start: 1.0, stages: [1.0; MAX_STAGES] })
    }

    /// Adds a contact whose force is `contact.force` times an amplitude given at [`Scene::instants`] of the step.
    ///
    /// # Errors
    /// [`LoadError`]; the loads are then unchanged.
    pub fn add_contact_staged(
        &mut self,
        scene: &Scene<'_, T>,
        contact: &Contact,
        amplitudes: &[f64; 1 + MAX_STAGES],
    ) -> Result<(), LoadError> {
        self.contact(scene, contact, staged(scene, amplitudes))
    }

    /// Adds the load pattern `index` times an amplitude held over the step.
    ///
    /// # Errors
    /// [`LoadError`]; the loads are then unchanged.
    pub fn add_pattern(
        &mut self,
        scene: &Scene<'_, T>,
        index: usize,
        amplitude: f64,
    ) -> Result<(), LoadError> {
        self.pattern(scene, index, Amplitudes { start: amplitude, stages: [amplitude; MAX_STAGES] })
    }

    /// Adds the load pattern `index` times an amplitude given at [`Scene::instants`] of the step.
    ///
    /// # Errors
    /// [`LoadError`]; the loads are then unchanged.
    pub fn add_pattern_staged(
        &mut self,
        scene: &Scene<'_, T>,
        index: usize,
        amplitudes: &[f64; 1 + MAX_STAGES],
    ) -> Result<(), LoadError> {
        self.pattern(scene, index, staged(scene, amplitudes))
    }

    fn contact(&mut self, scene: &Scene<'_, T>, contact: &Contact, p: Amplitudes) -> Result<(), LoadError> {
        self.check(scene, contact.weights.iter().chain(&contact.force), p)?;
        let limit = scene.metadata.n_load_nodes;
        if let Some(&node) = contact.nodes.iter().find(|&&node| node >= limit) {
            return Err(LoadError::NotLoadable { node, limit });
        }
        let basis = scene.sections.surface.ok_or(LoadError::Missing { kind: SectionKind::SurfaceBasis })?;
        let block = self.block_rows(scene.sections.block_load, SectionKind::BlockLoad)?;
        let (r, n_terms, stored) = (self.shape.r, self.shape.n_terms, scene.metadata.n_terms as usize);
        let (direct, stages) = self.rows.split_at_mut_checked(r).unwrap_or_default();
        direct.fill(T::ZERO);
        for (&node, weight) in contact.nodes.iter().zip(contact.weights) {
            for (component, force) in contact.force.iter().enumerate() {
                let at = (3 * node as usize + component) * r;
                basis
                    .row(at, r)
                    .into_iter()
                    .for_each(|row| add_row(row, T::from_f64(weight * force), direct));
            }
        }
        if self.shape.structure == Structure::Canonical {
            canonical::add_contact(self, scene, contact, p)?;
            self.add_force(p.start);
            self.mark(scene);
            return Ok(());
        }
        copy_to_stages(direct, stages);
        for (&node, weight) in contact.nodes.iter().zip(contact.weights) {
            for (t, component, force) in
                (0..n_terms).flat_map(|t| (0..3).zip(contact.force).map(move |(c, f)| (t, c, f)))
            {
                let at = ((node as usize * stored + t) * 3 + component) * r;
                add_term(scene, t, block.row(at, r), weight * force, stages);
            }
        }
        self.apply(scene, p);
        Ok(())
    }

    fn pattern(&mut self, scene: &Scene<'_, T>, index: usize, p: Amplitudes) -> Result<(), LoadError> {
        self.check(scene, [].iter(), p)?;
        if self.shape.structure == Structure::Canonical {
            return Err(LoadError::NoPatterns);
        }
        let count = scene.metadata.n_patterns as usize;
        if index >= count {
            return Err(LoadError::NoPattern { index, count });
        }
        let basis =
            scene.sections.pattern_basis.ok_or(LoadError::Missing { kind: SectionKind::PatternBasis })?;
        let block = self.block_rows(scene.sections.pattern_block, SectionKind::PatternBlock)?;
        let (r, n_terms, stored) = (self.shape.r, self.shape.n_terms, scene.metadata.n_terms as usize);
        let (direct, stages) = self.rows.split_at_mut_checked(r).unwrap_or_default();
        direct.fill(T::ZERO);
        basis.row(index * r, r).into_iter().for_each(|row| add_row(row, T::from_f64(1.0), direct));
        copy_to_stages(direct, stages);
        for t in 0..n_terms {
            add_term(scene, t, block.row((index * stored + t) * r, r), 1.0, stages);
        }
        self.apply(scene, p);
        Ok(())
    }

    fn check<'n>(
        &self,
        scene: &Scene<'_, T>,
        mut numbers: impl Iterator<Item = &'n f64>,
        p: Amplitudes,
    ) -> Result<(), LoadError> {
        if self.shape != scene.shape {
            return Err(LoadError::Mismatch);
        }
        if self.active && self.generation != scene.generation {
            return Err(LoadError::Stale);
        }
        let finite =
            numbers.all(|x| x.is_finite()) && p.start.is_finite() && p.stages.iter().all(|x| x.is_finite());
        if finite { Ok(()) } else { Err(LoadError::NotFinite) }
    }

    /// The rows of `H − B`; the diagonal structure needs none, its load maps hold `1/(1 + θλ)`, nor does the canonical one.
    fn block_rows<'n>(
        &self,
        numbers: Option<Numbers<'n>>,
        kind: SectionKind,
    ) -> Result<Numbers<'n>, LoadError> {
        match self.shape.structure {
            Structure::Diagonal | Structure::Canonical => Ok(Numbers::F64(&[])),
            Structure::Block => numbers.ok_or(LoadError::Missing { kind }),
        }
    }

    /// `BᵀF += p_0 g`, `ℓ += Σ_i p_i L_i g_i`.
    fn apply(&mut self, scene: &Scene<'_, T>, p: Amplitudes) {
        let (r, stride) = (self.shape.r, self.shape.stride().max(1));
        self.add_force(p.start);
        let (_, stages) = self.rows.split_at_mut_checked(r).unwrap_or_default();
        for (stage, (row, amplitude)) in stages.chunks_exact_mut(r.max(1)).zip(p.stages).enumerate() {
            let amplitude = T::from_f64(amplitude);
            row.iter_mut().for_each(|g| *g = *g * amplitude);
            let map = scene.load_map(stage);
            match self.shape.structure {
                Structure::Diagonal => {
                    for (out, map) in self.increment.chunks_exact_mut(stride).zip(map.chunks_exact(stride)) {
                        out.iter_mut().zip(map).zip(row.iter()).for_each(|((out, &map), &g)| *out += map * g);
                    }
                }
                Structure::Block => add_dense(map.as_chunks().0, row, self.increment),
                Structure::Canonical => {}
            }
        }
        self.mark(scene);
    }

    /// `BᵀF += p_0 g`.
    fn add_force(&mut self, start: f64) {
        let start = T::from_f64(start);
        self.force.iter_mut().zip(self.rows.iter()).for_each(|(force, &g)| *force += start * g);
    }

    /// Something acts, and belongs to the scene as it is now.
    fn mark(&mut self, scene: &Scene<'_, T>) {
        self.active = true;
        self.generation = scene.generation;
    }
}

/// Starts every stage's row of `H` from the row of `B`.
fn copy_to_stages<T: Scalar>(direct: &[T], stages: &mut [T]) {
    for row in stages.chunks_exact_mut(direct.len().max(1)) {
        row.iter_mut().zip(direct).for_each(|(out, &value)| *out = value);
    }
}

/// Adds `scale` times a row of term `t` to each stage's row, weighted by the term's factors there.
fn add_term<T: Scalar>(
    scene: &Scene<'_, T>,
    t: usize,
    row: Option<Numbers<'_>>,
    scale: f64,
    stages: &mut [T],
) {
    let Some(row) = row else { return };
    let weights = scene.weights.chunks_exact(scene.shape.n_terms.max(1));
    for (stage, weights) in stages.chunks_exact_mut(scene.shape.r.max(1)).zip(weights) {
        let weight = weights.get(t).copied().unwrap_or_default();
        if weight != T::ZERO {
            add_row(row, weight * T::from_f64(scale), stage);
        }
    }
}

fn staged<T: Scalar>(scene: &Scene<'_, T>, amplitudes: &[f64; 1 + MAX_STAGES]) -> Amplitudes {
    let mut stages = [0.0; MAX_STAGES];
    for (out, stage) in stages.iter_mut().zip(scene.metadata.scheme.active()) {
        *out = stage.load.iter().zip(amplitudes).map(|(f, a)| f * a).sum();
    }
    Amplitudes { start: amplitudes[0], stages }
}
