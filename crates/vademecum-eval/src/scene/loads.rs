//! Loads on the body during a step, accumulated in reduced form.
//!
//! A point force enters through one row of `H` per loaded dof (reciprocity):
//! `g_i = Σ_dof H_i[dof, ·] F[dof]`, and the fused step adds `Σ_i p_i L_i g_i` with `p_i = Σ_j f_ij F_j`, the
//! amplitude the scheme's stage `i` sees. Loads stay until they are cleared, so a held contact is added once;
//! when the scene's parameters change, what was added means nothing any more and is refused until it is
//! cleared.

use crate::base::error::{BindError, LoadError};
use crate::base::lend::Lender;
use crate::base::scalar::Scalar;
use crate::kernels::kernel::{add_dense, add_row};
use crate::scene::scene::Scene;
use crate::scene::shape::Shape;
use crate::sections::contact::Contact;
use crate::sections::residual::Statics;
use vademecum_format::scheme::{MAX_STAGES, SchemeTable};
use vademecum_format::{Numbers, SectionKind};

/// Loads of a step, in lent memory.
#[derive(Debug)]
pub struct Loads<'m, T> {
    pub(crate) shape: Shape,
    /// `ℓ`, laid out like a state.
    pub(crate) increment: &'m mut [T],
    /// `BᵀF` at the start of the step, length r.
    pub(crate) force: &'m mut [T],
    /// Row of `B` of the load that is being added, length r.
    direct: &'m mut [T],
    /// Its row of `H` in each stage, `(n_stages, r)`.
    stages: &'m mut [T],
    /// The scene's generation when the first load was added.
    pub(crate) generation: u64,
    pub(crate) active: bool,
    /// Forces at the end of the step, for what the modes leave out.
    pub(crate) statics: Statics<'m, T>,
    /// Contribution of the step to the filtered forces; no room without a filter.
    pub(crate) drive: Statics<'m, T>,
}

/// Course of a load's amplitude over a step.
#[derive(Clone, Copy)]
pub(crate) struct Amplitudes {
    pub start: f64,
    pub end: f64,
    pub stages: [f64; MAX_STAGES],
}

impl Amplitudes {
    /// Held over the step.
    pub const fn held(amplitude: f64) -> Self {
        Self { start: amplitude, end: amplitude, stages: [amplitude; MAX_STAGES] }
    }

    /// Given at the scheme's instants; at the start and the end of an exact step.
    pub fn staged(scheme: &SchemeTable, amplitudes: &[f64; 1 + MAX_STAGES]) -> Self {
        let mut stages = [0.0; MAX_STAGES];
        if scheme.is_exact() {
            stages.iter_mut().zip(amplitudes).take(2).for_each(|(out, &amplitude)| *out = amplitude);
        }
        for (out, stage) in stages.iter_mut().zip(scheme.active()) {
            *out = stage.load.iter().zip(amplitudes).map(|(f, a)| f * a).sum();
        }
        let [start, rest @ ..] = *amplitudes;
        // The last stage of a scheme lies at the end of the step.
        let last = if scheme.is_exact() { 1 } else { scheme.active().len() };
        let end = rest.into_iter().take(last).next_back().unwrap_or(start);
        Self { start, end, stages }
    }

    /// Refuses what is not finite, or too large for the precision.
    pub fn check<T: Scalar>(&self) -> Result<(), LoadError> {
        check_range::<T>(self.stages.iter().chain([&self.start, &self.end]))
    }
}

/// Refuses a force or an amplitude that is not finite, or too large for the precision.
pub(crate) fn check_range<'a, T: Scalar>(
    mut numbers: impl Iterator<Item = &'a f64>,
) -> Result<(), LoadError> {
    let sound = numbers.all(|&number| number.in_range() && T::from_f64(number).in_range());
    if sound { Ok(()) } else { Err(LoadError::NotFinite) }
}

impl<'m, T: Scalar> Loads<'m, T> {
    /// No loads. `memory` holds at least [`crate::Sizes::loads`] numbers; what is in it does not matter.
    ///
    /// ```
    /// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/bound.rs"));
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// # bound!(BODY, Auto: file, sizes, scene, state, loads, work);
    /// let mut memory = vec![f64::NAN; sizes.loads];
    /// let loads = Loads::new(&scene, &mut memory)?;
    /// assert!(loads.is_empty());
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// [`BindError::LentMemory`].
    pub fn new(scene: &Scene<'_, T>, memory: &'m mut [T]) -> Result<Self, BindError> {
        let shape = scene.shape;
        let short = BindError::LentMemory { found: memory.len(), needed: shape.loads_len() };
        let mut memory = Lender::new(memory.get_mut(..shape.loads_len()).ok_or(short)?);
        let increment = memory.take(shape.padded())?;
        let (force, direct) = (memory.take(shape.r)?, memory.take(shape.r)?);
        let stages = memory.take(shape.n_stages * shape.r)?;
        let generation = scene.generation;
        let statics = Statics::new(shape.statics, &mut memory)?;
        let drive = Statics::new(shape.drive(), &mut memory)?;
        let active = false;
        let mut loads = Self { shape, increment, force, direct, stages, generation, active, statics, drive };
        loads.clear();
        Ok(loads)
    }

    /// Takes all loads away.
    ///
    /// ```
    /// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/bound.rs"));
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// # bound!(BODY, Auto: file, sizes, scene, state, loads, work);
    /// loads.add_pattern(&scene, 0, 1.0)?;
    /// scene.step(&mut state, &loads)?; // under the pattern
    /// scene.step(&mut state, &loads)?; // and still
    /// loads.clear();
    /// assert!(loads.is_empty());
    /// # Ok(())
    /// # }
    /// ```
    pub fn clear(&mut self) {
        self.increment.fill(T::ZERO);
        self.force.fill(T::ZERO);
        self.statics.clear();
        self.drive.clear();
        self.active = false;
    }

    /// Becomes what `other` is: for a loop that adds to loads that stay what only one step has.
    ///
    /// ```
    /// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/bound.rs"));
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// # bound!(BODY, Auto: file, sizes, scene, state, loads, work);
    /// loads.add_pattern(&scene, 0, 1.0)?;
    /// let mut memory = vec![f64::NAN; sizes.loads];
    /// let mut with_more = Loads::new(&scene, &mut memory)?;
    /// with_more.copy_from(&loads)?;
    /// assert!(!with_more.is_empty());
    /// scene.step(&mut state, &with_more)?;
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// [`LoadError::Mismatch`] if they are of another scene.
    pub fn copy_from(&mut self, other: &Loads<'_, T>) -> Result<(), LoadError> {
        if self.shape != other.shape {
            return Err(LoadError::Mismatch);
        }
        self.increment.iter_mut().zip(&*other.increment).for_each(|(to, from)| *to = *from);
        self.force.iter_mut().zip(&*other.force).for_each(|(to, from)| *to = *from);
        self.statics.copy(&other.statics);
        self.drive.copy(&other.drive);
        (self.generation, self.active) = (other.generation, other.active);
        Ok(())
    }

    /// `true` if anything was added since the loads were cleared.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        !self.active
    }

    /// Adds a contact held over the step.
    ///
    /// ```
    /// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/bound.rs"));
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// # bound!(BODY, Auto: file, sizes, scene, state, loads, work);
    /// let touched = Surface::new(&file)?.locate([0.1, 0.05, 0.0]).ok_or("nothing to touch")?;
    /// let force = [0.0, 0.0, -20.0];
    /// let contact = Contact::new(touched.place, force);
    /// loads.add_contact(&scene, &contact)?;
    /// scene.step(&mut state, &loads)?;
    /// let once = scene.point(&state, &touched, Field::Displacement)?;
    /// assert!(once[2] < 0.0); // a body moves where it is pushed
    ///
    /// // Contacts add up, and the body is linear.
    /// state.rest();
    /// loads.add_contact(&scene, &contact)?;
    /// scene.step(&mut state, &loads)?;
    /// let twice = scene.point(&state, &touched, Field::Displacement)?;
    /// assert!((twice[2] / once[2] - 2.0).abs() < 1e-12);
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// [`LoadError`]; the loads are then unchanged.
    pub fn add_contact(&mut self, scene: &Scene<'_, T>, contact: &Contact) -> Result<(), LoadError> {
        self.contact(scene, contact, Amplitudes::held(1.0))
    }

    /// Adds a contact whose force is `contact.force` times an amplitude given at [`Scene::instants`] of the
    /// step.
    ///
    /// # Errors
    /// [`LoadError`]; the loads are then unchanged.
    pub fn add_contact_staged(
        &mut self,
        scene: &Scene<'_, T>,
        contact: &Contact,
        amplitudes: &[f64; 1 + MAX_STAGES],
    ) -> Result<(), LoadError> {
        self.contact(scene, contact, Amplitudes::staged(scene.scheme(), amplitudes))
    }

    /// Adds the load pattern `index` times an amplitude held over the step.
    ///
    /// ```
    /// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/bound.rs"));
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// # bound!(BODY, Auto: file, sizes, scene, state, loads, work);
    /// // Patterns are numbered in the order of their names in the file.
    /// use vademecum_eval::format::SectionKind;
    /// let names = file.section(SectionKind::PatternNames).ok_or("no names")?.text()?;
    /// let pull = names.lines().position(|name| name == "pull").ok_or("no such pattern")?;
    /// loads.add_pattern(&scene, pull, 0.5)?;
    /// assert_eq!(scene.step(&mut state, &loads)?, Status::Moving);
    /// let beyond = loads.add_pattern(&scene, 1, 0.5);
    /// assert_eq!(beyond, Err(LoadError::NoPattern { index: 1, count: 1 }));
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// [`LoadError`]; the loads are then unchanged.
    pub fn add_pattern(
        &mut self,
        scene: &Scene<'_, T>,
        index: usize,
        amplitude: f64,
    ) -> Result<(), LoadError> {
        self.pattern(scene, index, Amplitudes::held(amplitude))
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
        self.pattern(scene, index, Amplitudes::staged(scene.scheme(), amplitudes))
    }

    fn contact(&mut self, scene: &Scene<'_, T>, contact: &Contact, p: Amplitudes) -> Result<(), LoadError> {
        self.check(scene, p)?;
        contact.check(scene.metadata.n_load_nodes)?;
        check_range::<T>(contact.force.iter())?;
        self.statics.check(contact, self.shape.contact_nodes)?;
        let block = self.block_rows(scene.sections.block_load, SectionKind::BlockLoad)?;
        contact.project(&scene.sections.rows, self.direct)?;
        self.start_stages();
        let (r, n_terms, stored) = (self.shape.r, self.shape.n_terms, scene.metadata.n_terms as usize);
        for (node, weight) in contact.place.entries() {
            for (t, component, force) in
                (0..n_terms).flat_map(|t| (0..3).zip(contact.force).map(move |(c, f)| (t, c, f)))
            {
                let at = ((node as usize * stored + t) * 3 + component) * r;
                let row = block.row(at, r).ok_or(LoadError::Missing { kind: SectionKind::BlockLoad })?;
                self.add_term(scene, t, row, weight * force)?;
            }
        }
        self.apply(scene, p)?;
        self.statics.add_contact(contact, p.end);
        if self.shape.is_filtered() {
            self.drive.add_contact(contact, scene.filter.drive(p.start, p.end));
        }
        Ok(())
    }

    fn pattern(&mut self, scene: &Scene<'_, T>, index: usize, p: Amplitudes) -> Result<(), LoadError> {
        self.check(scene, p)?;
        let count = scene.metadata.n_patterns as usize;
        if index >= count {
            return Err(LoadError::NoPattern { index, count });
        }
        let kind = SectionKind::PatternBasis;
        let basis = scene.sections.pattern_basis.ok_or(LoadError::Missing { kind })?;
        let block = self.block_rows(scene.sections.pattern_block, SectionKind::PatternBlock)?;
        let (r, n_terms, stored) = (self.shape.r, self.shape.n_terms, scene.metadata.n_terms as usize);
        self.direct.fill(T::ZERO);
        add_row(basis.row(index * r, r).ok_or(LoadError::Missing { kind })?, T::from_f64(1.0), self.direct);
        self.start_stages();
        for t in 0..n_terms {
            let row = block.row((index * stored + t) * r, r);
            let row = row.ok_or(LoadError::Missing { kind: SectionKind::PatternBlock })?;
            self.add_term(scene, t, row, 1.0)?;
        }
        self.apply(scene, p)?;
        self.statics.add_pattern(index, p.end);
        if self.shape.is_filtered() {
            self.drive.add_pattern(index, scene.filter.drive(p.start, p.end));
        }
        Ok(())
    }

    /// Adds forces along the modes, held over the step.
    #[cfg(feature = "world")]
    pub(crate) fn add_coordinates(&mut self, scene: &Scene<'_, T>, forces: &[T]) -> Result<(), LoadError> {
        let held = Amplitudes::held(1.0);
        self.check(scene, held)?;
        self.direct.iter_mut().zip(forces).for_each(|(to, &from)| *to = from);
        self.start_stages();
        self.apply(scene, held)
    }

    fn check(&self, scene: &Scene<'_, T>, p: Amplitudes) -> Result<(), LoadError> {
        if self.shape != scene.shape {
            return Err(LoadError::Mismatch);
        }
        if self.active && self.generation != scene.generation {
            return Err(LoadError::Stale);
        }
        p.check::<T>()
    }

    /// The rows of `H − B`; the diagonal structure needs none, its load maps hold `1/(1 + θλ)`.
    fn block_rows<'n>(
        &self,
        numbers: Option<Numbers<'n>>,
        kind: SectionKind,
    ) -> Result<Numbers<'n>, LoadError> {
        if self.shape.is_block() { numbers.ok_or(LoadError::Missing { kind }) } else { Ok(Numbers::F64(&[])) }
    }

    /// Starts every stage's row of `H` from the row of `B`.
    fn start_stages(&mut self) {
        for row in self.stages.chunks_exact_mut(self.shape.r.max(1)) {
            row.iter_mut().zip(&*self.direct).for_each(|(out, &value)| *out = value);
        }
    }

    /// Adds `scale` times a row of term `t` to each stage's row, weighted by the term's factors there.
    fn add_term(
        &mut self,
        scene: &Scene<'_, T>,
        t: usize,
        row: Numbers<'_>,
        scale: f64,
    ) -> Result<(), LoadError> {
        let mut weights = Lender::new(&*scene.weights);
        for stage in self.stages.chunks_exact_mut(self.shape.r.max(1)) {
            let &weight = weights.take(self.shape.n_terms)?.get(t).ok_or(LoadError::Mismatch)?;
            if weight != T::ZERO {
                add_row(row, weight * T::from_f64(scale), stage);
            }
        }
        Ok(())
    }

    /// `BᵀF += p_0 g`, `ℓ += Σ_i p_i L_i g_i`.
    fn apply(&mut self, scene: &Scene<'_, T>, p: Amplitudes) -> Result<(), LoadError> {
        let stride = self.shape.stride().max(1);
        let start = T::from_f64(p.start);
        self.force.iter_mut().zip(&*self.direct).for_each(|(force, &g)| *force += start * g);
        let mut maps = Lender::new(&*scene.load_maps);
        for (row, amplitude) in self.stages.chunks_exact_mut(self.shape.r.max(1)).zip(p.stages) {
            let amplitude = T::from_f64(amplitude);
            row.iter_mut().for_each(|g| *g = *g * amplitude);
            let map = maps.take(self.shape.load_map_len())?;
            if self.shape.is_dense() {
                add_dense(map.as_chunks().0, row, self.increment);
                continue;
            }
            for (out, map) in self.increment.chunks_exact_mut(stride).zip(map.chunks_exact(stride)) {
                out.iter_mut().zip(map).zip(row.iter()).for_each(|((out, &map), &g)| *out += map * g);
            }
        }
        self.active = true;
        self.generation = scene.generation;
        Ok(())
    }
}
