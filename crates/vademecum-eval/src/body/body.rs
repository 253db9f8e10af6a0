//! One owner of all that belongs to a body, over one lent slice of numbers.
//!
//! The slice is cut once: numbers of the body's precision for the scene, its state, its loads and what is
//! kept of them, and numbers of `f64` for work and for the static answer of the whole body. Work is shared:
//! binding, parameters and the compliance at places never run at once.

use crate::base::error::{BindError, LoadError, LocateError, OutputError, StepError};
use crate::base::lend::Lender;
use crate::base::options::{MAX_CONTACTS, SceneOptions, Status, Structure};
use crate::base::scalar::Scalar;
use crate::body::identity::identity;
use crate::flight::free::FreeBody;
use crate::flight::rigid::{RigidBody, RigidMotion};
use crate::scene::loads::{Loads, check_range};
use crate::scene::scene::Scene;
use crate::scene::shape::{at_most, shape};
use crate::scene::state::State;
use crate::sections::contact::Contact;
use crate::sections::factor::Factor;
use crate::sections::place::Place;
use crate::sections::rows::Field;
use crate::sections::surface::{Surface, SurfacePoint};
use crate::show::static_field::{StaticField, static_field_sizes};
use vademecum_format::scheme::MAX_STAGES;
use vademecum_format::{BaseMotion, File, SectionKind};

/// Options of a [`Body`] and the room it has.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyOptions {
    /// Structure and parameters of the step.
    pub scene: SceneOptions,
    /// Places that [`Body::compliance`] and [`Body::free_motion`] take at most, up to [`MAX_CONTACTS`].
    pub places: usize,
    /// Room for [`Body::keep_loads`].
    pub keep_loads: bool,
    /// Room for the static answer of the whole body, where the file has the factor of its stiffness; with the
    /// feature `full` only.
    pub static_field: bool,
    /// Flight of a body without supports: [`Body::step`] then moves its frame, too. Without it, and without
    /// the feature `full`, the host moves the frame and gives its angular velocity to [`Body::push_spin`].
    pub flight: bool,
    /// Stepped modes of a parametric file whose parameters are set, [`LiveMemory`](crate::LiveMemory);
    /// [`STEPPED_MODES`](crate::STEPPED_MODES) or all of fewer if `None`.
    pub modes: Option<usize>,
}

impl Default for BodyOptions {
    fn default() -> Self {
        Self {
            scene: SceneOptions::default(),
            places: 16,
            keep_loads: false,
            static_field: false,
            flight: true,
            modes: None,
        }
    }
}

/// Validity of the loads after a change of parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[must_use]
pub enum LoadsAfter {
    /// There were none.
    Empty,
    /// They belong to the parameters from before: a step refuses them until [`Body::clear`], after which the
    /// caller adds them again.
    Stale,
}

/// A file, a scene, one state, its loads and, of a body without supports, its flight, in lent memory.
///
/// ```
/// use vademecum_eval::format::File;
/// use vademecum_eval::{Body, BodyOptions, Field};
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// # let bytes = include_bytes!(concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/golden/fixed-f64.vdm"));
/// let (file, options) = (File::parse(bytes)?, BodyOptions::default());
/// let mut memory = vec![0.0; Body::<f32>::len_for(&file, &options)?];
/// let mut body = Body::<f32>::bind(&file, &options, &mut memory)?;
///
/// let finger = body.locate([0.1, 0.05, 0.0])?;
/// body.push(&finger, [0.0, 0.0, -20.0])?;
/// for _ in 0..1000 {
///     body.step()?;
/// }
/// let [_, _, down] = body.point(&finger, Field::Displacement)?;
/// # assert!(down < 0.0);
/// # Ok(())
/// # }
/// ```
#[derive(Debug)]
pub struct Body<'m, T> {
    pub(crate) file: File<'m>,
    pub(crate) surface: Option<Surface<'m>>,
    /// Residual flexibility between contacts near each other.
    #[cfg(feature = "world")]
    pub(crate) patch: Option<vademecum_format::ContactPatch<'m>>,
    pub(crate) scene: Scene<'m, T>,
    pub(crate) state: State<'m, T>,
    pub(crate) loads: Loads<'m, T>,
    pub(crate) flight: Option<FreeBody>,
    kept: Option<Kept<'m, T>>,
    statics: Option<StaticField<'m, T>>,
    pub(crate) work: &'m mut [f64],
    /// Identity of the file in a saved state.
    pub(crate) identity: [u8; 8],
}

/// Loads that were kept, and what pushed the frame beside them.
#[derive(Debug)]
struct Kept<'m, T> {
    loads: Loads<'m, T>,
    flight: Option<FreeBody>,
}

/// The parts of a body, for what has no method on it.
#[derive(Debug)]
#[non_exhaustive]
pub struct BodyParts<'b, 'm, T> {
    /// The file bound to parameters.
    pub scene: &'b mut Scene<'m, T>,
    /// The elastic motion.
    pub state: &'b mut State<'m, T>,
    /// The loads on it.
    pub loads: &'b mut Loads<'m, T>,
    /// The rigid motion of a body that flies.
    pub flight: &'b mut Option<FreeBody>,
    /// Work, for parameters and compliance.
    pub work: &'b mut [f64],
}

/// Numbers of each piece of the lent slice.
struct Pieces {
    /// Of `T`: scene, state, loads, kept loads, rest of the static field.
    scene: usize,
    state: usize,
    loads: usize,
    kept: usize,
    rest: usize,
    /// Of `f64`: static answer, work.
    answer: usize,
    work: usize,
}

impl Pieces {
    fn of<T: Scalar>(file: &File<'_>, options: &BodyOptions) -> Result<Self, BindError> {
        let shape = shape::<T>(file, &options.scene)?;
        at_most("places", options.places, MAX_CONTACTS)?;
        let sizes = shape.sizes();
        let factor = if FULL && options.scene.residual { Factor::of(file) } else { Factor::default() };
        let [answer, rest] =
            if FULL && options.static_field { static_field_sizes(&factor, &shape) } else { [0; 2] };
        let operator = shape.compliance_work(options.places).max(3 * shape.r);
        Ok(Self {
            scene: sizes.scene,
            state: sizes.state,
            loads: sizes.loads,
            kept: if options.keep_loads { sizes.loads } else { 0 },
            rest,
            answer,
            work: sizes.work.max(words::<T>(operator)),
        })
    }

    fn of_scalar(&self) -> usize {
        let all = [self.scene, self.state, self.loads, self.kept, self.rest];
        all.into_iter().fold(0, usize::saturating_add)
    }

    fn sum<T: Scalar>(&self) -> usize {
        words::<T>(self.of_scalar()).saturating_add(self.answer).saturating_add(self.work)
    }
}

/// Numbers of `f64` in which so many of `T` fit.
const fn words<T>(numbers: usize) -> usize {
    numbers.saturating_mul(size_of::<T>()).div_ceil(size_of::<f64>())
}

impl<'m, T: Scalar> Body<'m, T> {
    /// Numbers of `f64` to lend for a body of these options, whatever its precision.
    ///
    /// # Errors
    /// As [`Scene::sizes`].
    pub fn len_for(file: &File<'_>, options: &BodyOptions) -> Result<usize, BindError> {
        Ok(Pieces::of::<T>(file, options)?.sum::<T>())
    }

    /// Binds a file; the body is at rest and unloaded. `memory` holds at least what [`Body::len_for`] says;
    /// what is in it does not matter.
    ///
    /// # Errors
    /// [`BindError`].
    pub fn bind(file: &File<'m>, options: &BodyOptions, memory: &'m mut [f64]) -> Result<Self, BindError> {
        let pieces = Pieces::of::<T>(file, options)?;
        let (found, needed) = (memory.len(), pieces.sum::<T>());
        let memory = memory.get_mut(..needed).ok_or(BindError::LentMemory { found, needed })?;
        let mut memory = Lender::new(memory);
        let (answer, work) = (memory.take(pieces.answer)?, memory.take(pieces.work)?);
        let mut numbers = Lender::new(T::of_words(memory.rest()));
        let scene = Scene::bind(file, &options.scene, numbers.take(pieces.scene)?, work)?;
        let state = State::new(&scene, numbers.take(pieces.state)?)?;
        let loads = Loads::new(&scene, numbers.take(pieces.loads)?)?;
        let flight = if FULL && options.flight { FreeBody::new(&scene, RigidMotion::at_rest) } else { None };
        let (kept, rest) = (numbers.take(pieces.kept)?, numbers.take(pieces.rest)?);
        let kept =
            if options.keep_loads { Some(Kept { loads: Loads::new(&scene, kept)?, flight }) } else { None };
        let statics =
            if FULL && pieces.answer > 0 { Some(StaticField::new(&scene, answer, rest)?) } else { None };
        let surface = Surface::new(file).ok();
        #[cfg(feature = "world")]
        let patch = file.contact_patch().ok().flatten();
        let (file, identity) = (*file, identity(file));
        Ok(Self {
            #[cfg(feature = "world")]
            patch,
            file,
            surface,
            scene,
            state,
            loads,
            flight,
            kept,
            statics,
            work,
            identity,
        })
    }

    /// The file.
    #[must_use]
    pub const fn file(&self) -> &File<'m> {
        &self.file
    }

    /// The file bound to parameters.
    #[must_use]
    pub const fn scene(&self) -> &Scene<'m, T> {
        &self.scene
    }

    /// The elastic motion.
    #[must_use]
    pub const fn state(&self) -> &State<'m, T> {
        &self.state
    }

    /// The loads on the elastic motion.
    #[must_use]
    pub const fn loads(&self) -> &Loads<'m, T> {
        &self.loads
    }

    /// The rigid motion of a body that flies, and what pushes it.
    #[must_use]
    pub const fn flight(&self) -> Option<&FreeBody> {
        self.flight.as_ref()
    }

    const fn flies(&self) -> bool {
        FULL && self.flight.is_some()
    }

    /// Lends the parts to what has no method here.
    pub fn with<R>(&mut self, run: impl FnOnce(BodyParts<'_, 'm, T>) -> R) -> R {
        let Self { scene, state, loads, flight, work, .. } = self;
        run(BodyParts { scene, state, loads, flight, work })
    }

    /// `Δt` \[s\].
    #[must_use]
    pub const fn time_step(&self) -> f64 {
        self.scene.parameters.time_step
    }

    /// The nearest point of the loadable surface at rest, as [`Surface::locate`]. A point further away than
    /// the body is large is most likely in another unit, and is refused.
    ///
    /// # Errors
    /// [`LocateError`].
    pub fn locate(&self, point: [f64; 3]) -> Result<SurfacePoint, LocateError> {
        if !point.iter().all(|x| x.is_finite()) {
            return Err(LocateError::NotFinite);
        }
        let surface = self.surface.as_ref().ok_or(LocateError::NoSurface)?;
        let found = surface.locate(point).ok_or(LocateError::NoSurface)?;
        let (distance, reach) = (found.distance, surface.reach_from(found.distance));
        if distance > reach { Err(LocateError::Far { distance, reach }) } else { Ok(found) }
    }

    /// Position of a place at rest \[m\].
    ///
    /// # Errors
    /// [`OutputError::Place`]; [`OutputError::Missing`] in a file without coordinates,
    /// [`OutputError::OutOfRange`].
    pub fn position(&self, at: &impl AsRef<Place>) -> Result<[f64; 3], OutputError> {
        let kind = SectionKind::NodeCoordinates;
        let section = self.file.section(kind).and_then(|section| section.numbers().ok());
        let coordinates = section.ok_or(OutputError::Missing { kind })?;
        let place = at.as_ref();
        place.check()?;
        let mut position = [0.0; 3];
        for (node, weight) in place.entries() {
            let index = node as usize;
            let row = coordinates.row(index.saturating_mul(3), 3);
            let row = row.ok_or(OutputError::OutOfRange { index, count: coordinates.len() / 3 })?;
            position.iter_mut().zip(row.iter()).for_each(|(sum, x)| *sum += weight * x);
        }
        Ok(position)
    }

    /// Instants at which a step needs a changing load, as [`Scene::instants`].
    #[must_use]
    pub fn instants(&self) -> [f64; 1 + MAX_STAGES] {
        self.scene.instants()
    }

    /// Adds a force \[N\] at a place. Of a body that flies it is a force of space, which acts for one step
    /// ([`FreeBody::push`]); any other load stays until [`Body::clear`] ([`Loads::add_contact`]).
    ///
    /// # Errors
    /// [`LoadError`]; nothing has changed then.
    pub fn push(&mut self, at: &impl AsRef<Place>, force: [f64; 3]) -> Result<(), LoadError> {
        let place = *at.as_ref();
        if !self.flies() {
            return self.loads.add_contact(&self.scene, &Contact::new(place, force));
        }
        place.check()?;
        let kind = SectionKind::NodeCoordinates;
        let position = self.position(&place).map_err(|_| LoadError::Missing { kind })?;
        let Some(free) = flying(&mut self.flight) else { return Err(LoadError::Mismatch) };
        free.push(&self.scene, &mut self.loads, &SurfacePoint { place, position, distance: 0.0 }, force)
    }

    /// Adds a force at a place whose amplitude is given at [`Body::instants`], as
    /// [`Loads::add_contact_staged`]. A body that flies takes the mean of start and end.
    ///
    /// # Errors
    /// [`LoadError`]; nothing has changed then.
    pub fn push_staged(
        &mut self,
        at: &impl AsRef<Place>,
        force: [f64; 3],
        amplitudes: &[f64; 1 + MAX_STAGES],
    ) -> Result<(), LoadError> {
        if self.flies() {
            let mean = mean(amplitudes);
            return self.push(at, force.map(|force| mean * force));
        }
        let contact = Contact::new(*at.as_ref(), force);
        self.loads.add_contact_staged(&self.scene, &contact, amplitudes)
    }

    /// Adds a force that goes from `start` to `end` \[N\] over the step.
    ///
    /// # Errors
    /// [`LoadError`]; nothing has changed then.
    pub fn push_ramp(
        &mut self,
        at: &impl AsRef<Place>,
        start: [f64; 3],
        end: [f64; 3],
    ) -> Result<(), LoadError> {
        // Both are checked before the first is added: what refuses the second then refuses the first, too.
        check_range::<T>(start.iter().chain(&end))?;
        let later = self.instants();
        self.push_staged(at, start, &later.map(|t| 1.0 - t))?;
        self.push_staged(at, end, &later)
    }

    /// Adds a load pattern, as [`Loads::add_pattern`]; of a body that flies it turns with the body and acts
    /// for one step ([`FreeBody::push_pattern`]).
    ///
    /// # Errors
    /// [`LoadError`]; nothing has changed then.
    pub fn push_pattern(&mut self, pattern: usize, amplitude: f64) -> Result<(), LoadError> {
        match flying(&mut self.flight) {
            None => self.loads.add_pattern(&self.scene, pattern, amplitude),
            Some(free) => free.push_pattern(&self.scene, &mut self.loads, pattern, amplitude),
        }
    }

    /// Adds a load pattern whose amplitude is given at [`Body::instants`], as
    /// [`Loads::add_pattern_staged`]. A body that flies takes the mean of start and end.
    ///
    /// # Errors
    /// [`LoadError`]; nothing has changed then.
    pub fn push_pattern_staged(
        &mut self,
        pattern: usize,
        amplitudes: &[f64; 1 + MAX_STAGES],
    ) -> Result<(), LoadError> {
        if self.flies() {
            return self.push_pattern(pattern, mean(amplitudes));
        }
        self.loads.add_pattern_staged(&self.scene, pattern, amplitudes)
    }

    /// Adds the inertia of a base that moves so, as [`Loads::add_base`].
    ///
    /// # Errors
    /// [`LoadError`].
    pub fn push_base(&mut self, motion: &BaseMotion) -> Result<(), LoadError> {
        self.loads.add_base(&self.scene, motion)
    }

    /// Adds the centrifugal forces of a body that its host moves, as [`Loads::add_spin`].
    ///
    /// # Errors
    /// [`LoadError`].
    pub fn push_spin(&mut self, before: [f64; 3], after: [f64; 3]) -> Result<(), LoadError> {
        self.loads.add_spin(&self.scene, before, after)
    }

    /// Pulls a body that flies at its centre with a force \[N\] of space, for one step.
    ///
    /// # Errors
    /// [`LoadError::Missing`]: a body that does not fly.
    pub fn pull(&mut self, force: [f64; 3]) -> Result<(), LoadError> {
        let kind = SectionKind::RigidBody;
        self.flight.as_mut().ok_or(LoadError::Missing { kind })?.pull(force);
        Ok(())
    }

    /// Takes all loads away.
    pub fn clear(&mut self) {
        match flying(&mut self.flight) {
            None => self.loads.clear(),
            Some(free) => free.clear(&mut self.loads),
        }
    }

    /// Keeps the loads as they are, for [`Body::recall_loads`].
    ///
    /// # Errors
    /// [`LoadError::NoRoom`]: a body that was bound without room for them.
    pub fn keep_loads(&mut self) -> Result<(), LoadError> {
        let kept = self.kept.as_mut().ok_or(LoadError::NoRoom)?;
        kept.loads.copy_from(&self.loads)?;
        kept.flight = self.flight;
        Ok(())
    }

    /// The loads become what was kept.
    ///
    /// # Errors
    /// As [`Body::keep_loads`].
    pub fn recall_loads(&mut self) -> Result<(), LoadError> {
        let kept = self.kept.as_ref().ok_or(LoadError::NoRoom)?;
        self.loads.copy_from(&kept.loads)?;
        if let (Some(free), Some(kept)) = (flying(&mut self.flight), &kept.flight) {
            free.pushed_as(kept);
        }
        Ok(())
    }

    /// Advances the body by `Δt` under its loads, as [`Scene::step`]; a body that flies by both motions, as
    /// [`FreeBody::step`].
    ///
    /// # Errors
    /// [`StepError`]; the body is then where it was.
    #[inline]
    pub fn step(&mut self) -> Result<Status, StepError> {
        if !self.flies() { self.scene.step(&mut self.state, &self.loads) } else { self.fly() }
    }

    #[cold]
    fn fly(&mut self) -> Result<Status, StepError> {
        let Some(free) = flying(&mut self.flight) else { return Err(StepError::Mismatch) };
        free.step(&self.scene, &mut self.state, &mut self.loads)
    }

    /// So many steps; fewer once the body rests, which it then goes on doing.
    ///
    /// # Errors
    /// [`StepError`]; the steps before it are taken.
    #[inline]
    pub fn march(&mut self, steps: usize) -> Result<Status, StepError> {
        let mut status = Status::Moving;
        for _ in 0..steps {
            status = self.step()?;
            if status == Status::AtRest {
                break;
            }
        }
        Ok(status)
    }

    /// Puts the body at rest where the file has it; loads stay.
    pub fn rest(&mut self) {
        self.state.rest();
        if let Some(free) = flying(&mut self.flight) {
            free.set_motion(RigidMotion::at_rest(free.body()));
        }
    }

    /// Sets the elastic motion in reduced coordinates, as [`Scene::set`].
    ///
    /// # Errors
    /// [`StepError`]; the state is then unchanged.
    pub fn set(&mut self, zeta: &[f64], zeta_dot: &[f64]) -> Result<(), StepError> {
        self.scene.set(&mut self.state, zeta, zeta_dot, &self.loads)
    }

    /// Writes `ζ` and `ζ̇`, each of length r, in SI: what survives a change of `Δt`.
    ///
    /// # Errors
    /// [`OutputError::Length`].
    pub fn coordinates_into(&self, zeta: &mut [f64], zeta_dot: &mut [f64]) -> Result<(), OutputError> {
        let (needed, rate) = (self.scene.n_modes(), 1.0 / self.state.time_step());
        for found in [zeta.len(), zeta_dot.len()] {
            if found != needed {
                return Err(OutputError::Length { found, needed });
            }
        }
        zeta.iter_mut().zip(self.state.zeta()).for_each(|(out, x)| *out = x.to_f64());
        let rates = zeta_dot.iter_mut().zip(self.state.scaled_velocity());
        rates.for_each(|(out, x)| *out = x.to_f64() * rate);
        Ok(())
    }

    /// Sets parameters of the file, as [`Scene::set_parameters`], and carries both motions over: velocities
    /// stay.
    ///
    /// # Errors
    /// [`BindError`]; nothing has changed then.
    pub fn set_parameters(&mut self, settings: &[(usize, f64)]) -> Result<LoadsAfter, BindError> {
        self.scene.set_parameters(settings, &mut self.state, self.work)?;
        Ok(self.followed())
    }

    /// Binds the body to other options of the same structure where it is, as [`Scene::rebind`], and carries
    /// both motions over.
    ///
    /// # Errors
    /// [`BindError`]; nothing has changed then.
    pub fn rebind(&mut self, options: &SceneOptions) -> Result<LoadsAfter, BindError> {
        self.scene.rebind_with(options, &mut self.state, self.work)?;
        Ok(self.followed())
    }

    /// Takes over from a body of the same file at other parameters all but its elastic motion: forces of the
    /// last step, and the rigid motion. Loads of the other are refused here as stale.
    #[cfg(feature = "parametric")]
    pub(crate) fn follow(&mut self, other: &Body<'_, T>) -> LoadsAfter {
        if self.state.shape.statics == other.state.shape.statics {
            self.state.statics.copy(&other.state.statics);
            self.state.statics.forgotten = other.state.statics.forgotten;
        }
        if self.state.shape.filtered == other.state.shape.filtered {
            self.state.filtered.forces.copy(&other.state.filtered.forces);
            self.state.filtered.largest = other.state.filtered.largest;
        }
        self.flight = other.flight;
        if !other.loads.is_empty() {
            self.scene.generation = self.loads.generation.wrapping_add(1);
            self.loads.active = true;
        }
        self.followed()
    }

    fn followed(&mut self) -> LoadsAfter {
        if let Some(free) = flying(&mut self.flight) {
            free.follow(&self.scene);
        }
        if self.loads.is_empty() { LoadsAfter::Empty } else { LoadsAfter::Stale }
    }

    /// Delassus operator of the elastic motion at places, in its present state, as [`Scene::compliance_at`].
    ///
    /// # Errors
    /// [`LoadError`]; [`LoadError::Mismatch`] also for more places than the body has room for.
    #[doc(alias = "Delassus operator")]
    pub fn compliance(&mut self, places: &[impl AsRef<Place>], w: &mut [f64]) -> Result<(), LoadError> {
        self.scene.compliance_at(&self.state, places, w, T::of_words(self.work))
    }

    /// Displacements of places at the end of the coming step, as [`Scene::free_motion`].
    ///
    /// # Errors
    /// [`StepError`]; [`StepError::Mismatch`] also for more places than the body has room for.
    pub fn free_motion(
        &mut self,
        places: &[impl AsRef<Place>],
        out: &mut [[f64; 3]],
    ) -> Result<(), StepError> {
        self.scene.free_motion(&self.state, &self.loads, places, out, T::of_words(self.work))
    }

    /// Mass, centre and moments of inertia of a body without supports, at its density.
    #[must_use]
    pub fn rigid_body(&self) -> Option<RigidBody> {
        self.scene.rigid_body()
    }

    /// The rigid motion of a body that flies.
    #[must_use]
    pub fn motion(&self) -> Option<&RigidMotion> {
        self.flight.as_ref().map(FreeBody::motion)
    }

    /// Puts a body that flies elsewhere, or lets it move otherwise; `None` for any other body, and for a
    /// motion with a number that is not finite or an attitude of zero, which change nothing.
    #[must_use]
    pub fn set_motion(&mut self, motion: RigidMotion) -> Option<()> {
        let free = self.flight.as_mut()?;
        free.set_motion(motion.normalised()?);
        Some(())
    }

    /// Throws a body that flies from where the file has it, with a velocity of its centre \[m/s\] and an
    /// angular velocity \[rad/s\]; `None` as [`Body::set_motion`].
    #[must_use]
    pub fn throw(&mut self, velocity: [f64; 3], spin: [f64; 3]) -> Option<()> {
        let body = self.scene.rigid_body()?;
        self.set_motion(RigidMotion::thrown(&body, velocity, spin))
    }

    /// Place or velocity in space of a place of a body that flies.
    ///
    /// # Errors
    /// [`OutputError`]; [`OutputError::Missing`]: a body that does not fly.
    pub fn in_space(&self, at: &impl AsRef<Place>, field: Field) -> Result<[f64; 3], OutputError> {
        let free = self.flight.as_ref().ok_or(OutputError::Missing { kind: SectionKind::RigidBody })?;
        let place = *at.as_ref();
        let at = SurfacePoint { place, position: self.position(&place)?, distance: 0.0 };
        match field {
            Field::Displacement => free.point(&self.scene, &self.state, &at),
            Field::Velocity => free.velocity(&self.scene, &self.state, &at),
        }
    }

    /// Value of a probe, as [`Scene::probe`].
    ///
    /// # Errors
    /// [`OutputError`].
    #[inline]
    pub fn probe(&self, probe: usize, field: Field) -> Result<f64, OutputError> {
        self.scene.probe(&self.state, probe, field)
    }

    /// Displacement or velocity of a node, as [`Scene::node`].
    ///
    /// # Errors
    /// [`OutputError`].
    pub fn node(&self, node: usize, field: Field) -> Result<[f64; 3], OutputError> {
        self.scene.node(&self.state, node, field)
    }

    /// Displacement or velocity of a place, as [`Scene::point`].
    ///
    /// # Errors
    /// [`OutputError`].
    #[inline]
    pub fn point(&self, at: &impl AsRef<Place>, field: Field) -> Result<[f64; 3], OutputError> {
        self.scene.point(&self.state, at, field)
    }

    /// The whole surface, as [`Scene::surface_into`].
    ///
    /// # Errors
    /// [`OutputError`].
    pub fn surface_into(&self, field: Field, out: &mut [T]) -> Result<(), OutputError> {
        self.scene.surface_into(&self.state, field, out)
    }

    /// The whole body, as [`Scene::body_into`].
    ///
    /// # Errors
    /// [`OutputError`].
    pub fn body_into(&self, field: Field, out: &mut [T]) -> Result<(), OutputError> {
        self.scene.body_into(&self.state, field, out)
    }

    /// Solves for the static answer of the whole body to the forces of the last step, as
    /// [`Scene::solve_static_field`].
    ///
    /// # Errors
    /// [`OutputError::Missing`] where the file does not have the factor of the stiffness, or the body was
    /// bound without room for it.
    pub fn solve_static_field(&mut self) -> Result<(), OutputError> {
        let kind = SectionKind::FactorValues;
        let statics = self.statics.as_mut().ok_or(OutputError::Missing { kind })?;
        self.scene.solve_static_field(&self.state, statics)
    }

    /// `true` if there is room for the static answer of the whole body.
    #[must_use]
    pub const fn has_static_field(&self) -> bool {
        self.statics.is_some()
    }

    /// The whole surface with the static answer that was solved for, as [`Scene::surface_with`].
    ///
    /// # Errors
    /// As [`Body::solve_static_field`].
    pub fn surface_with_statics(&mut self, field: Field, out: &mut [T]) -> Result<(), OutputError> {
        let kind = SectionKind::FactorValues;
        let statics = self.statics.as_mut().ok_or(OutputError::Missing { kind })?;
        self.scene.surface_with(&self.state, field, statics, out)
    }

    /// The whole body with the static answer that was solved for, as [`Scene::body_with`].
    ///
    /// # Errors
    /// As [`Body::solve_static_field`].
    pub fn body_with_statics(&mut self, field: Field, out: &mut [T]) -> Result<(), OutputError> {
        let kind = SectionKind::FactorValues;
        let statics = self.statics.as_mut().ok_or(OutputError::Missing { kind })?;
        self.scene.body_with(&self.state, field, statics, out)
    }

    /// The structure of the step.
    #[must_use]
    pub const fn structure(&self) -> Structure {
        self.scene.structure()
    }

    /// Kinetic and elastic energy \[J\], as [`Scene::energy`].
    ///
    /// # Errors
    /// [`OutputError`].
    pub fn energy(&self) -> Result<f64, OutputError> {
        self.scene.energy(&self.state)
    }
}

/// Flight and the static answer of the whole body need the feature `full`: a microcontroller spends no flash
/// on them.
const FULL: bool = cfg!(feature = "full");

const fn flying(flight: &mut Option<FreeBody>) -> Option<&mut FreeBody> {
    if FULL { flight.as_mut() } else { None }
}

/// Loads over a step of a flight under a load that is linear in it.
fn mean(amplitudes: &[f64; 1 + MAX_STAGES]) -> f64 {
    let [start, end, ..] = *amplitudes;
    0.5 * (start + end)
}
