//! Many instances of one scene stepped together: a bridge with a thousand cables, a game with five hundred
//! props.
//!
//! Each instance has a state, a load and a rest of its own. With the diagonal structure, [`Batch::LANES`]
//! instances are held with their numbers interleaved (instance fastest): every operation of a step is done
//! for all of them at once and a coefficient is read once for all of them, also where one body has too few
//! modes to fill a vector. With the block structure, and where dashpots couple the modes, the rows of `D`
//! fill the vectors already; interleaving was measured to win nothing there (`docs/measurements/step.md`), so
//! instances lie one after the other.
//!
//! The bits of an instance are those of [`Scene::step`]: each number is the same sum in the same order. (One
//! exception is in [`Batch::step`].) A batch knows no threads; a caller with several cores makes a batch for
//! each, over the same scene.

use crate::base::error::{BindError, LoadError, StepError};
use crate::base::lend::{Lender, Short, put};
use crate::base::options::{Status, Structure};
use crate::base::scalar::Scalar;
use crate::base::vectors::{Kernel, vectorised};
use crate::kernels::kernel::{LANES, ModeBlock, blocks, flushed};
use crate::scene::loads::Loads;
use crate::scene::scene::Scene;
use crate::scene::shape::Shape;
use crate::scene::state::State;

/// One number of every instance of a group.
type Lane<T> = [T; WIDTH];

/// Instances in a group.
const WIDTH: usize = 16;

/// States and loads of many instances of one scene, in lent memory.
#[derive(Debug)]
pub struct Batch<'m, T> {
    shape: Shape,
    n_instances: usize,
    /// `Δt` \[s\] the states are scaled by.
    time_step: f64,
    /// The scene's generation when the first load was taken.
    generation: u64,
    n_loaded: usize,
    /// `y` of every instance, see [`place`].
    states: &'m mut [T],
    /// `ℓ` of every instance, laid out alike.
    loads: &'m mut [T],
    /// `BᵀF` of every instance at the start of a step, `(instance, mode)`.
    forces: &'m mut [T],
    /// `Σ|y|` of every instance after its last step, not finite if that was refused; 0 at rest.
    magnitudes: &'m mut [T],
    /// 1 for a loaded instance, 0 for one without load.
    loaded: &'m mut [T],
    /// 1 for an instance that has been neither stepped nor set, see [`Scene::step`]; 0 for one that has.
    unstarted: &'m mut [T],
    /// `true` if there may be such an instance.
    some_unstarted: bool,
    /// Scratch of a step of the strain structure.
    scratch: &'m mut [T],
    /// Memory of the new states; then the two change places. Zero where an instance rests.
    next: &'m mut [T],
}

/// Status of an instance after a step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BatchStatus {
    /// Instances that moved or are loaded.
    pub moving: usize,
    /// Instances at rest.
    pub at_rest: usize,
    /// Instances whose new state would not be finite: they keep the old one ([`Batch::status`] tells which).
    pub refused: usize,
}

impl<'m, T: Scalar> Batch<'m, T> {
    /// Instances stepped at once: a batch does best with a multiple of this.
    pub const LANES: usize = WIDTH;

    /// Numbers of `T` to lend for a batch of so many instances.
    #[must_use]
    pub const fn len_for(scene: &Scene<'_, T>, n_instances: usize) -> usize {
        let (group, groups) = (group_len(scene.shape), n_instances.div_ceil(WIDTH));
        let one_each = WIDTH.saturating_mul(scene.shape.r.saturating_add(3));
        let states = group.saturating_mul(3).saturating_add(one_each).saturating_mul(groups);
        states.saturating_add(scene.shape.scratch_len())
    }

    /// `n_instances` bodies at rest, without loads. `memory` holds at least [`Batch::len_for`] numbers; what
    /// is in it does not matter.
    ///
    /// ```
    /// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/bound.rs"));
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// # bound!(BODY, Auto: file, sizes, scene, state, loads, work);
    /// let mut memory = vec![0.0; Batch::len_for(&scene, 500)];
    /// let mut batch = Batch::new(&scene, 500, &mut memory)?;
    /// loads.add_pattern(&scene, 0, 1.0)?;
    /// batch.load(&scene, 7, &loads)?;
    /// let status = batch.step(&scene)?;
    /// assert_eq!((status.moving, status.at_rest), (1, 499));
    ///
    /// // An instance has the bits that it would have alone.
    /// scene.step(&mut state, &loads)?;
    /// let alone = state.zeta().to_vec();
    /// batch.get(7, &mut state)?;
    /// assert_eq!(state.zeta(), alone);
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// [`BindError::LentMemory`].
    pub fn new(scene: &Scene<'_, T>, n_instances: usize, memory: &'m mut [T]) -> Result<Self, BindError> {
        let (found, needed) = (memory.len(), Self::len_for(scene, n_instances));
        let memory = memory.get_mut(..needed).ok_or(BindError::LentMemory { found, needed })?;
        memory.fill(T::ZERO);
        let (group, groups) = (group_len(scene.shape), n_instances.div_ceil(WIDTH));
        let mut memory = Lender::new(memory);
        let mut take = |per_group: usize| memory.take(per_group * groups);
        let (states, next, loads) = (take(group)?, take(group)?, take(group)?);
        let (magnitudes, loaded, unstarted) = (take(WIDTH)?, take(WIDTH)?, take(WIDTH)?);
        let forces = take(WIDTH * scene.shape.r)?;
        let scratch = memory.take(scene.shape.scratch_len())?;
        let some_unstarted = scene.shape.n_parts() > 2;
        unstarted.fill(if some_unstarted { T::from_f32(1.0) } else { T::ZERO });
        let (shape, generation) = (scene.shape, scene.generation);
        let time_step = scene.parameters.time_step;
        Ok(Self {
            shape,
            n_instances,
            time_step,
            generation,
            n_loaded: 0,
            states,
            loads,
            forces,
            magnitudes,
            loaded,
            unstarted,
            some_unstarted,
            scratch,
            next,
        })
    }

    /// Number of instances.
    #[must_use]
    pub const fn n_instances(&self) -> usize {
        self.n_instances
    }

    /// Loads `instance` with what `loads` holds, in place of what it had; it stays until the next call.
    /// `O(r)`.
    ///
    /// # Errors
    /// [`LoadError`]; the batch is then unchanged.
    pub fn load(
        &mut self,
        scene: &Scene<'_, T>,
        instance: usize,
        loads: &Loads<'_, T>,
    ) -> Result<(), LoadError> {
        if instance >= self.n_instances {
            return Err(LoadError::NoInstance { index: instance, count: self.n_instances });
        }
        if self.shape != scene.shape || self.shape != loads.shape {
            return Err(LoadError::Mismatch);
        }
        let stale = |generation| generation != scene.generation;
        if loads.active && (stale(loads.generation) || (self.n_loaded > 0 && stale(self.generation))) {
            return Err(LoadError::Stale);
        }
        if loads.increment.iter().chain(&*loads.force).any(|value| !value.to_f64().is_finite()) {
            return Err(LoadError::NotFinite);
        }
        let mut forces = self.forces.chunks_exact_mut(self.shape.r.max(1));
        let force = forces.nth(instance).ok_or(LoadError::Mismatch)?;
        force.iter_mut().zip(&*loads.force).for_each(|(out, &value)| *out = value);
        let loaded = self.loaded.get_mut(instance).ok_or(LoadError::Mismatch)?;
        self.n_loaded -= usize::from(*loaded != T::ZERO);
        self.n_loaded += usize::from(loads.active);
        *loaded = T::from_f32(f32::from(u8::from(loads.active)));
        self.generation = if loads.active { scene.generation } else { self.generation };
        Ok(self.put_increment(instance, loads.increment)?)
    }

    /// Writes `ℓ` of an instance.
    fn put_increment(&mut self, instance: usize, increment: &[T]) -> Result<(), Short> {
        for third in 0..self.shape.n_parts() {
            let from = increment.iter().skip(third * self.shape.stride()).take(self.shape.r);
            for (k, &value) in from.enumerate() {
                put(self.loads, place(self.shape, instance, third, k), value)?;
            }
        }
        Ok(())
    }

    /// Loads an instance with what is added to its state in a step, laid out like one.
    #[cfg(feature = "full")]
    pub(crate) fn load_increment(
        &mut self,
        scene: &Scene<'_, T>,
        instance: usize,
        increment: &[T],
    ) -> Result<(), StepError> {
        if instance >= self.n_instances {
            return Err(StepError::NoInstance);
        }
        self.put_increment(instance, increment)?;
        let loaded = self.loaded.get_mut(instance).ok_or(StepError::Mismatch)?;
        self.n_loaded += usize::from(*loaded == T::ZERO);
        *loaded = T::from_f32(1.0);
        self.generation = scene.generation;
        Ok(())
    }

    /// Number `k` of a part of the state of an instance.
    #[cfg(feature = "full")]
    pub(crate) fn number(&self, instance: usize, part: usize, k: usize) -> Option<T> {
        self.states.get(place(self.shape, instance, part, k)).copied()
    }

    /// Takes the loads of all instances away.
    pub fn clear(&mut self) {
        self.loads.fill(T::ZERO);
        self.forces.fill(T::ZERO);
        self.loaded.fill(T::ZERO);
        self.n_loaded = 0;
    }

    /// Gives `instance` a state. `O(r)`.
    ///
    /// # Errors
    /// [`StepError::NoInstance`], [`StepError::Mismatch`], and [`StepError::NotCarried`] for a state of
    /// another `Δt`; the batch is then unchanged.
    pub fn set(&mut self, instance: usize, state: &State<'_, T>) -> Result<(), StepError> {
        self.check(instance, state)?;
        for third in 0..self.shape.n_parts() {
            for (k, &value) in state.y.part(third).iter().enumerate() {
                put(self.states, place(self.shape, instance, third, k), value)?;
                put(self.next, place(self.shape, instance, third, k), T::ZERO)?;
            }
        }
        put(self.unstarted, instance, if state.y.unstarted { T::from_f32(1.0) } else { T::ZERO })?;
        self.some_unstarted |= state.y.unstarted;
        Ok(put(self.magnitudes, instance, if state.y.at_rest { T::ZERO } else { T::from_f32(1.0) })?)
    }

    /// Writes the state of `instance` to `state`, from which everything can be read but reactions: a batch
    /// does not keep the forces of the last step ([`Batch::get_under`]). `O(r)`.
    ///
    /// # Errors
    /// [`StepError::NoInstance`], [`StepError::Mismatch`], and [`StepError::NotCarried`] for a state of
    /// another `Δt`; `state` is then unchanged.
    pub fn get(&self, instance: usize, state: &mut State<'_, T>) -> Result<(), StepError> {
        self.check(instance, state)?;
        for third in 0..self.shape.n_parts() {
            for (k, out) in state.y.part_mut(third).iter_mut().enumerate() {
                let at = place(self.shape, instance, third, k);
                *out = *self.states.get(at).ok_or(StepError::Mismatch)?;
            }
        }
        state.y.unstarted = self.unstarted.get(instance).is_some_and(|&flag| flag != T::ZERO);
        state.y.at_rest = state.y.unstarted || self.status(instance) == Ok(Status::AtRest);
        // Nothing acted on a body that rests.
        if state.y.at_rest {
            state.statics.clear();
            state.clear_filtered();
        } else {
            state.statics.forget();
            state.clear_filtered();
        }
        Ok(())
    }

    /// [`Batch::get`] for an instance whose last step was one under `loads`: outputs add what the modes leave
    /// out of the answer to them, and reactions are those of [`Scene::step`], bit for bit. A batch keeps no
    /// filtered forces: with stiffness-proportional damping the residual is in equilibrium with `loads`.
    ///
    /// ```
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// # use vademecum_eval::format::File;
    /// # use vademecum_eval::{Batch, Loads, OutputError, Scene, SceneOptions, State};
    /// # let bytes =
    /// #     include_bytes!(concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/golden/reactions.vdm"));
    /// # let (file, options) = (File::parse(bytes)?, SceneOptions::default());
    /// # let sizes = Scene::<f64>::sizes(&file, &options)?;
    /// # let (mut memory, mut work) = (vec![0.0; sizes.scene], vec![0.0; sizes.work]);
    /// # let (mut state_memory, mut load_memory) = (vec![0.0; sizes.state], vec![0.0; sizes.loads]);
    /// # let scene = Scene::bind(&file, &options, &mut memory, &mut work)?;
    /// # let mut state = State::new(&scene, &mut state_memory)?;
    /// # let mut loads = Loads::new(&scene, &mut load_memory)?;
    /// let mut memory = vec![0.0; Batch::len_for(&scene, 20)];
    /// let mut batch = Batch::new(&scene, 20, &mut memory)?;
    /// loads.add_pattern(&scene, 0, 1.0)?;
    /// batch.load(&scene, 7, &loads)?;
    /// batch.step(&scene)?;
    /// scene.step(&mut state, &loads)?;
    /// let alone = scene.reaction(&state, 0)?;
    /// assert!(alone.total()[2] != 0.0);
    ///
    /// batch.get(7, &mut state)?;
    /// assert_eq!(scene.reaction(&state, 0), Err(OutputError::ForcesForgotten));
    /// batch.get_under(7, &mut state, &loads)?;
    /// assert_eq!(scene.reaction(&state, 0)?, alone);
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// As [`Batch::get`]; [`StepError::Mismatch`] for loads of another shape.
    pub fn get_under(
        &self,
        instance: usize,
        state: &mut State<'_, T>,
        loads: &Loads<'_, T>,
    ) -> Result<(), StepError> {
        if loads.shape != self.shape {
            return Err(StepError::Mismatch);
        }
        self.get(instance, state)?;
        state.settle_residual(loads);
        Ok(())
    }

    /// Status of `instance` after the last step.
    ///
    /// # Errors
    /// [`StepError::NotFinite`] if it was refused (its state is the one before), [`StepError::NoInstance`].
    pub fn status(&self, instance: usize) -> Result<Status, StepError> {
        let known = self.magnitudes.get(instance).zip(self.loaded.get(instance));
        let (&magnitude, &loaded) =
            known.filter(|_| instance < self.n_instances).ok_or(StepError::NoInstance)?;
        if !finite(magnitude) {
            return Err(StepError::NotFinite);
        }
        Ok(if rests(magnitude, loaded, T::ZERO) { Status::AtRest } else { Status::Moving })
    }

    /// Carries all states over to the parameters of `scene`; see [`State::carry`]. Loads from before are
    /// stale: clear them.
    ///
    /// # Errors
    /// [`StepError::Mismatch`], and [`StepError::NotFinite`] if a number of some instance leaves the
    /// precision; the batch is then unchanged.
    pub fn carry(&mut self, scene: &Scene<'_, T>) -> Result<(), StepError> {
        if self.shape != scene.shape {
            return Err(StepError::Mismatch);
        }
        let ratio = scene.parameters.time_step / self.time_step;
        let (shape, n) = (self.shape, self.n_instances);
        let rates = [(1, ratio), (2, ratio * ratio)];
        let places = rates.into_iter().take(shape.n_parts() - 1).flat_map(|(third, factor)| {
            (0..n).flat_map(move |i| (0..shape.r).map(move |k| (place(shape, i, third, k), factor)))
        });
        let scaled = |states: &[T], at: usize, factor: f64| {
            let value = states.get(at).ok_or(StepError::Mismatch)?;
            let value = T::from_f64(value.to_f64() * factor);
            if value.in_range() { Ok(value) } else { Err(StepError::NotFinite) }
        };
        for (at, factor) in places.clone() {
            scaled(self.states, at, factor)?;
        }
        for (at, factor) in places {
            put(self.states, at, scaled(self.states, at, factor)?)?;
        }
        self.time_step = scene.parameters.time_step;
        Ok(())
    }

    /// Advances every instance by `Δt` under its load; the first step of an instance starts as that of
    /// [`Scene::step`]. An instance whose new state would not be finite keeps
    /// the old one and is counted as refused; the others go on.
    ///
    /// An instance is put at rest by the rule of [`Scene::step`], except that `Σ|y|` is summed in another
    /// order: with [`SceneOptions::rest_below`](crate::SceneOptions::rest_below) above 0 it may rest a step
    /// sooner or later than it would alone.
    ///
    /// # Errors
    /// [`StepError::Mismatch`], [`StepError::NotCarried`] and [`StepError::StaleLoads`], for the batch as a
    /// whole and before anything moves.
    pub fn step(&mut self, scene: &Scene<'_, T>) -> Result<BatchStatus, StepError> {
        if self.shape != scene.shape {
            return Err(StepError::Mismatch);
        }
        if self.time_step != scene.parameters.time_step {
            return Err(StepError::NotCarried);
        }
        if self.n_loaded > 0 && self.generation != scene.generation {
            return Err(StepError::StaleLoads);
        }
        if self.some_unstarted {
            self.start(scene)?;
        }
        match self.shape.structure() {
            Structure::Diagonal => self.step_groups::<3>(scene)?,
            Structure::Exact if self.shape.is_coupled() => self.step_each(scene)?,
            Structure::Exact => self.step_groups::<2>(scene)?,
            Structure::Block | Structure::Strain => self.step_each(scene)?,
        }
        core::mem::swap(&mut self.states, &mut self.next);
        if self.some_unstarted {
            self.started()?;
        }
        let (mut at_rest, mut refused) = (0u32, 0u32);
        for (&magnitude, &loaded) in self.magnitudes.iter().zip(&*self.loaded).take(self.n_instances) {
            at_rest += u32::from(rests(magnitude, loaded, T::ZERO));
            refused += u32::from(!finite(magnitude));
        }
        let (at_rest, refused) = (at_rest as usize, refused as usize);
        Ok(BatchStatus { moving: self.n_instances.saturating_sub(at_rest + refused), at_rest, refused })
    }

    /// Gives every loaded instance that has not started yet the acceleration that its load demands; one that
    /// is not finite, so that the step is refused, where there is none.
    #[cold]
    fn start(&mut self, scene: &Scene<'_, T>) -> Result<(), StepError> {
        let (shape, equation) = (self.shape, scene.equation());
        let flags = self.unstarted.iter().zip(&*self.loaded).take(self.n_instances);
        let forces = self.forces.chunks_exact(shape.r.max(1));
        for (instance, ((&unstarted, &loaded), force)) in flags.zip(forces).enumerate() {
            if unstarted == T::ZERO || loaded == T::ZERO {
                continue;
            }
            // The next states of the group are not written yet.
            let group = instance / WIDTH * group_len(shape);
            let work = self.next.get_mut(group..group + 3 * shape.r).ok_or(StepError::Mismatch)?;
            let mut lender = Lender::new(&mut *work);
            let [a, b, c] = [lender.take(shape.r)?, lender.take(shape.r)?, lender.take(shape.r)?];
            let found = equation.acceleration_at_rest(force, [a, b, &mut *c]);
            for (k, &value) in c.iter().enumerate() {
                let value = if found.is_ok() { value } else { T::from_f64(f64::NAN) };
                put(self.states, place(shape, instance, 2, k), value)?;
            }
            work.fill(T::ZERO);
        }
        Ok(())
    }

    /// Every instance has started, but one whose step was refused is as it was.
    #[cold]
    fn started(&mut self) -> Result<(), StepError> {
        self.some_unstarted = false;
        for instance in 0..self.n_instances {
            let unstarted = self.unstarted.get_mut(instance).ok_or(StepError::Mismatch)?;
            let finite = self.magnitudes.get(instance).is_some_and(|&m| finite(m));
            if *unstarted == T::ZERO {
                continue;
            }
            if finite {
                *unstarted = T::ZERO;
                continue;
            }
            self.some_unstarted = true;
            for k in 0..self.shape.r {
                put(self.states, place(self.shape, instance, 2, k), T::ZERO)?;
            }
        }
        Ok(())
    }

    fn step_groups<const N: usize>(&mut self, scene: &Scene<'_, T>) -> Result<(), StepError> {
        vectorised(Groups::<'_, '_, '_, T, N> { batch: self, scene })
    }

    fn step_each(&mut self, scene: &Scene<'_, T>) -> Result<(), StepError> {
        let length = self.shape.padded().max(1);
        let (mut states, mut loads) = (self.states.chunks_exact_mut(length), self.loads.chunks_exact(length));
        let mut news = self.next.chunks_exact_mut(length);
        for (magnitude, &loaded) in self.magnitudes.iter_mut().zip(&*self.loaded) {
            let (Some(old), Some(load), Some(new)) = (states.next(), loads.next(), news.next()) else {
                return Err(StepError::Mismatch);
            };
            if *magnitude == T::ZERO && loaded == T::ZERO {
                continue;
            }
            *magnitude = match self.shape.structure() {
                Structure::Strain => {
                    new.iter_mut().zip(&*old).for_each(|(new, &old)| *new = old);
                    scene.sub_steps(new, load, self.scratch, None)?
                }
                _ => scene.step_together(old, load, new),
            };
            if rests(*magnitude, loaded, scene.rest_below) {
                *magnitude = T::ZERO;
                old.fill(T::ZERO);
                new.fill(T::ZERO);
            } else if !finite(*magnitude) {
                new.iter_mut().zip(&*old).for_each(|(new, &old)| *new = old);
            }
        }
        Ok(())
    }

    fn check(&self, instance: usize, state: &State<'_, T>) -> Result<(), StepError> {
        if instance >= self.n_instances {
            return Err(StepError::NoInstance);
        }
        if state.shape != self.shape {
            return Err(StepError::Mismatch);
        }
        if state.y.time_step == self.time_step { Ok(()) } else { Err(StepError::NotCarried) }
    }
}

/// Numbers of a group's states.
const fn group_len(shape: Shape) -> usize {
    WIDTH * if shape.is_per_mode() { shape.n_parts() * shape.r } else { shape.padded() }
}

/// Index at which `instance` has number `k` of `ζ`, `Δt ζ̇` or `Δt² ζ̈`. Diagonal: `(group, mode, third,
/// lane)`, so that the numbers of a mode are side by side. Block: `(instance, third, mode)`, padded for the
/// kernel.
const fn place(shape: Shape, instance: usize, third: usize, k: usize) -> usize {
    if shape.is_per_mode() {
        ((instance / WIDTH * shape.r + k) * shape.n_parts() + third) * WIDTH + instance % WIDTH
    } else {
        instance * shape.padded() + third * shape.r + k
    }
}

#[inline(always)]
fn rests<T: Scalar>(magnitude: T, loaded: T, below: T) -> bool {
    (loaded == T::ZERO) & (magnitude <= below)
}

/// Without a branch, so that many are asked at once.
#[inline(always)]
fn finite<T: Scalar>(magnitude: T) -> bool {
    magnitude <= T::LARGEST
}

/// Puts right the new states of a group: an instance that is refused keeps the old one, one that rests is
/// zero in both.
#[inline(always)]
fn settle<T: Scalar>(
    rest_below: T,
    loaded: &Lane<T>,
    magnitudes: &mut Lane<T>,
    old: &mut [Lane<T>],
    new: &mut [Lane<T>],
) {
    let goes_on = |lane: usize| finite(magnitudes[lane]) & !rests(magnitudes[lane], loaded[lane], rest_below);
    if (0..WIDTH).fold(true, |all, lane| all & goes_on(lane)) {
        return;
    }
    for lane in 0..WIDTH {
        if rests(magnitudes[lane], loaded[lane], rest_below) {
            magnitudes[lane] = T::ZERO;
            old.iter_mut().chain(&mut *new).for_each(|row| row[lane] = T::ZERO);
        } else if !finite(magnitudes[lane]) {
            old.iter().zip(&mut *new).for_each(|(old, new)| new[lane] = old[lane]);
        }
    }
}

/// The groups of a batch whose modes are independent.
struct Groups<'a, 'b, 's, T: Scalar, const N: usize> {
    batch: &'a mut Batch<'b, T>,
    scene: &'a Scene<'s, T>,
}

impl<T: Scalar, const N: usize> Kernel for Groups<'_, '_, '_, T, N> {
    type Output = Result<(), StepError>;

    #[inline(always)]
    fn run(self) -> Self::Output {
        let Self { batch, scene } = self;
        let length = group_len(batch.shape).max(1);
        let (mut states, mut loads) =
            (batch.states.chunks_exact_mut(length), batch.loads.chunks_exact(length));
        let mut news = batch.next.chunks_exact_mut(length);
        let loaded = batch.loaded.as_chunks::<WIDTH>().0;
        for (magnitudes, loaded) in batch.magnitudes.as_chunks_mut::<WIDTH>().0.iter_mut().zip(loaded) {
            let (Some(old), Some(load), Some(new)) = (states.next(), loads.next(), news.next()) else {
                return Err(StepError::Mismatch);
            };
            if magnitudes.iter().chain(loaded).all(|&value| value == T::ZERO) {
                continue;
            }
            let (old, load) = (old.as_chunks_mut().0, load.as_chunks().0);
            let new = new.as_chunks_mut().0;
            *magnitudes = step_modes::<T, N>(
                blocks(scene.map),
                old.as_chunks().0,
                load.as_chunks().0,
                new.as_chunks_mut().0,
            );
            settle(scene.rest_below, loaded, magnitudes, old, new);
        }
        Ok(())
    }
}

/// [`step_diagonal`](crate::kernels::kernel::step_diagonal) for a group: a coefficient meets [`WIDTH`]
/// instances at
/// once.
#[inline(always)]
fn step_modes<T: Scalar, const N: usize>(
    blocks: &[ModeBlock<T, N>],
    old: &[[Lane<T>; N]],
    load: &[[Lane<T>; N]],
    new: &mut [[Lane<T>; N]],
) -> Lane<T> {
    let mut sums = [T::ZERO; WIDTH];
    let coefficients = blocks.iter().flat_map(|block| (0..LANES).map(move |k| (block, k)));
    for (((old, load), new), (d, k)) in old.iter().zip(load).zip(new).zip(coefficients) {
        for row in 0..N {
            let d = d[row].each_ref().map(|lanes| lanes[k]);
            new[row] = mode_row(d, old, &old[row], &load[row], &mut sums);
        }
    }
    sums
}

/// One row of the block of a mode, as the single step has it.
#[inline(always)]
fn mode_row<T: Scalar, const N: usize>(
    d: [T; N],
    y: &[Lane<T>; N],
    kept: &Lane<T>,
    load: &Lane<T>,
    sums: &mut Lane<T>,
) -> Lane<T> {
    let mut new = [T::ZERO; WIDTH];
    for lane in 0..WIDTH {
        let mut increment = load[lane];
        for part in 0..N {
            increment += d[part] * y[part][lane];
        }
        new[lane] = flushed(kept[lane] + increment, &mut sums[lane]);
    }
    new
}
