//! A free body: its elastic motion in a scene, and its rigid motion beside it.
//!
//! The modes of a free body move no mass as a whole (its frame is that of the mean axes), so forces reach
//! them through the basis as of any body, and the acceleration of the frame does not reach them at all. What
//! does is its angular velocity, by the centrifugal forces `−M(ω × (ω × x))`: six load patterns of the file,
//! on which the products of the components of `ω` are the factors. Forces of Coriolis on the elastic motion,
//! and what the elastic motion changes of the moments of inertia, are left out: both are by a factor of
//! `ω / ω_elastic`, or of the strain, smaller than what is kept (`docs/how-to/free-bodies.md`).

use crate::base::error::{LoadError, OutputError, StepError};
use crate::base::options::Status;
use crate::base::scalar::Scalar;
use crate::base::vec3::{add, cross, minus};
use crate::flight::rigid::{RigidBody, RigidMotion, first_pattern};
use crate::scene::loads::Loads;
use crate::scene::scene::Scene;
use crate::scene::state::State;
use crate::sections::contact::Contact;
use crate::sections::rows::Field;
use crate::sections::surface::SurfacePoint;
use vademecum_format::scheme::MAX_STAGES;
use vademecum_format::{BaseMotion, SectionKind};

/// The rigid motion of a scene's body, and what pushes it in the coming step.
///
/// Forces are those of space and act for one step: [`FreeBody::step`] takes them away.
///
/// ```
/// use vademecum_eval::format::File;
/// use vademecum_eval::{FreeBody, Loads, RigidMotion, Scene, SceneOptions, State, Surface};
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// # let bytes = include_bytes!(concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/golden/free.vdm"));
/// let file = File::parse(bytes)?;
/// let options = SceneOptions::default();
/// let sizes = Scene::<f64>::sizes(&file, &options)?;
/// let (mut memory, mut work) = (vec![0.0; sizes.scene], vec![0.0; sizes.work]);
/// let (mut state_memory, mut load_memory) = (vec![0.0; sizes.state], vec![0.0; sizes.loads]);
/// let scene = Scene::bind(&file, &options, &mut memory, &mut work)?;
/// let mut state = State::new(&scene, &mut state_memory)?;
/// let mut loads = Loads::new(&scene, &mut load_memory)?;
///
/// // Thrown upwards, turning; hit in the first step.
/// let thrown = |body: &_| RigidMotion::thrown(body, [0.0, 0.0, 3.0], [5.0, 1.0, 0.0]);
/// let mut free = FreeBody::new(&scene, thrown).ok_or("the body is held")?;
/// let touched = Surface::new(&file)?.locate([0.1, 0.05, 0.0]).ok_or("nothing to touch")?;
/// free.push(&scene, &mut loads, &touched, [20.0, 0.0, 0.0])?;
/// for _ in 0..100 {
///     free.pull([0.0, 0.0, -9.81 * free.body().mass]);
///     free.step(&scene, &mut state, &mut loads)?;
/// }
/// let [.., height] = free.motion().position;
/// let expected = free.body().centre[2] + 3.0 * 0.1 - 0.5 * 9.81 * 0.1 * 0.1;
/// assert!((height - expected).abs() < 1e-12);
/// assert!(scene.energy(&state)? > 0.0); // it swings
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Copy, Debug)]
#[doc(alias = "floating frame of reference")]
pub struct FreeBody {
    /// At the density it was last stepped with.
    body: RigidBody,
    density: f64,
    motion: RigidMotion,
    force: [f64; 3],
    moment: [f64; 3],
}

impl FreeBody {
    /// The body of `scene` in `motion`; `None` if the file holds a body with supports.
    #[must_use]
    pub fn new<T: Scalar>(
        scene: &Scene<'_, T>,
        motion: impl FnOnce(&RigidBody) -> RigidMotion,
    ) -> Option<Self> {
        let body = scene.rigid_body()?;
        let motion = motion(&body);
        Some(Self { body, density: scene.parameters.density, motion, force: [0.0; 3], moment: [0.0; 3] })
    }

    /// Mass, centre and moments of inertia.
    #[must_use]
    pub const fn body(&self) -> &RigidBody {
        &self.body
    }

    /// The rigid motion.
    #[must_use]
    pub const fn motion(&self) -> &RigidMotion {
        &self.motion
    }

    /// Puts the body elsewhere, or lets it move otherwise. What pushes it stays.
    pub fn set_motion(&mut self, motion: RigidMotion) {
        self.motion = motion;
    }

    /// Pushes at a point of the surface with a force \[N\] of space, held over the coming step. It acts on
    /// the modes, turned as the body is halfway through the step, and on the rigid motion; its arm is that of
    /// the body at rest.
    ///
    /// # Errors
    /// [`LoadError`]; nothing has changed then.
    pub fn push<T: Scalar>(
        &mut self,
        scene: &Scene<'_, T>,
        loads: &mut Loads<'_, T>,
        at: &SurfacePoint,
        force: [f64; 3],
    ) -> Result<(), LoadError> {
        let middle = self.middle(scene);
        let contact = Contact::new(at.place, middle.to_body(force));
        loads.add_contact(scene, &contact)?;
        let arm = middle.to_space(minus(at.position, self.body.centre));
        self.pull(force);
        self.moment = add(self.moment, 1.0, cross(arm, force));
        Ok(())
    }

    /// Pulls at the centre with a force \[N\] of space, held over the coming step: gravity is the mass times
    /// its acceleration. It does not reach the modes.
    pub fn pull(&mut self, force: [f64; 3]) {
        self.force = add(self.force, 1.0, force);
    }

    /// Adds a load pattern, which turns with the body, for the coming step: to the modes and, with its force
    /// and its moment, to the rigid motion.
    ///
    /// # Errors
    /// [`LoadError`]; nothing has changed then. The patterns of the angular velocity are refused as
    /// [`LoadError::NoPattern`]: a step adds them itself.
    pub fn push_pattern<T: Scalar>(
        &mut self,
        scene: &Scene<'_, T>,
        loads: &mut Loads<'_, T>,
        index: usize,
        amplitude: f64,
    ) -> Result<(), LoadError> {
        let count = self.body.first_pattern;
        if index >= count {
            return Err(LoadError::NoPattern { index, count });
        }
        let kind = SectionKind::RigidBody;
        let wrench = scene.wrench(index).ok_or(LoadError::Missing { kind })?;
        loads.add_pattern(scene, index, amplitude)?;
        let middle = self.middle(scene);
        let [x, y, z, a, b, c] = wrench.map(|number| amplitude * number);
        self.pull(middle.to_space([x, y, z]));
        self.moment = add(self.moment, 1.0, middle.to_space([a, b, c]));
        Ok(())
    }

    /// Takes away what pushes both motions in the coming step.
    pub fn clear<T: Scalar>(&mut self, loads: &mut Loads<'_, T>) {
        (self.force, self.moment) = ([0.0; 3], [0.0; 3]);
        loads.clear();
    }

    /// Force at the centre and moment about it in the coming step, in space.
    #[cfg(feature = "world")]
    pub(crate) const fn pushes(&self) -> [[f64; 3]; 2] {
        [self.force, self.moment]
    }

    /// Steps the elastic motion under all its loads, takes them away, and goes on from a rigid motion that
    /// was found outside.
    pub(crate) fn accept<T: Scalar>(
        &mut self,
        scene: &Scene<'_, T>,
        state: &mut State<'_, T>,
        loads: &mut Loads<'_, T>,
        motion: RigidMotion,
    ) -> Result<Status, StepError> {
        (self.force, self.moment) = ([0.0; 3], [0.0; 3]);
        let stepped = if motion.is_finite() { scene.step(state, loads) } else { Err(StepError::NotFinite) };
        loads.clear();
        let status = stepped?;
        self.motion = motion;
        let [x, y, z] = motion.momentum;
        let [a, b, c] = motion.angular_momentum;
        let still = [x, y, z, a, b, c] == [0.0; 6];
        Ok(if still { status } else { Status::Moving })
    }

    /// Takes over what pushes another one.
    pub(crate) const fn pushed_as(&mut self, other: &Self) {
        (self.force, self.moment) = (other.force, other.moment);
    }

    /// Rigid motion at the end of the coming step under what pushes it so far.
    #[must_use]
    pub fn ahead<T: Scalar>(&self, scene: &Scene<'_, T>) -> RigidMotion {
        let time = scene.parameters.time_step;
        let mut motion = self.middle(scene);
        motion.kick(time, self.force, self.moment);
        motion.drift(&self.body, 0.5 * time);
        motion
    }

    /// The rigid motion halfway through the coming step.
    #[must_use]
    pub fn middle<T: Scalar>(&self, scene: &Scene<'_, T>) -> RigidMotion {
        let mut motion = self.motion;
        motion.drift(&self.body, 0.5 * scene.parameters.time_step);
        motion
    }

    /// One step of both motions, under what was pushed since the last one, and takes that away. A live
    /// density that has changed keeps the velocities.
    ///
    /// # Errors
    /// [`StepError`]; both motions are then unchanged, and nothing pushes any more.
    pub fn step<T: Scalar>(
        &mut self,
        scene: &Scene<'_, T>,
        state: &mut State<'_, T>,
        loads: &mut Loads<'_, T>,
    ) -> Result<Status, StepError> {
        self.follow(scene);
        let ahead = self.ahead(scene);
        let spun = loads.add_spin(scene, self.motion.spin(&self.body), ahead.spin(&self.body));
        if let Err(refused) = spun {
            self.clear(loads);
            return Err(match refused {
                LoadError::Stale => StepError::StaleLoads,
                LoadError::Mismatch => StepError::Mismatch,
                _ => StepError::NotFinite,
            });
        }
        self.accept(scene, state, loads, ahead)
    }

    /// Takes a live density that has changed over, as a step does: mass and moments follow it, and the
    /// velocities stay. A host that sets a motion or asks for it in between calls this first.
    pub fn follow<T: Scalar>(&mut self, scene: &Scene<'_, T>) {
        let density = scene.parameters.density;
        if density != self.density {
            let scale = density / self.density;
            self.body = self.body.at_density(scale);
            self.motion.momentum = self.motion.momentum.map(|x| scale * x);
            self.motion.angular_momentum = self.motion.angular_momentum.map(|x| scale * x);
            self.density = density;
        }
    }

    /// Position in space \[m\] of a point of the deformed surface.
    ///
    /// # Errors
    /// [`OutputError`].
    pub fn point<T: Scalar>(
        &self,
        scene: &Scene<'_, T>,
        state: &State<'_, T>,
        at: &SurfacePoint,
    ) -> Result<[f64; 3], OutputError> {
        let displacement = scene.point(state, at, Field::Displacement)?;
        Ok(self.motion.place(&self.body, at.position, displacement))
    }

    /// Velocity of a point of the surface in space \[m/s\].
    ///
    /// # Errors
    /// [`OutputError`].
    pub fn velocity<T: Scalar>(
        &self,
        scene: &Scene<'_, T>,
        state: &State<'_, T>,
        at: &SurfacePoint,
    ) -> Result<[f64; 3], OutputError> {
        let displacement = scene.point(state, at, Field::Displacement)?;
        let velocity = scene.point(state, at, Field::Velocity)?;
        Ok(self.motion.velocity(&self.body, at.position, displacement, velocity))
    }
}

impl<T: Scalar> Scene<'_, T> {
    /// Mass, centre and moments of inertia of a free body at the density the scene is bound to; `None` of a
    /// body with supports.
    #[must_use]
    pub fn rigid_body(&self) -> Option<RigidBody> {
        let body = RigidBody::read(self.sections.rigid_body?, self.metadata.n_patterns)?;
        Some(body.at_density(self.parameters.density))
    }

    /// The first pattern of the angular velocity. Every step asks, so the principal axes are not looked for.
    fn first_spin_pattern(&self) -> Option<usize> {
        let (own, _) = self.sections.rigid_body?.split_first_chunk::<11>()?;
        let [.., first] = own.map(f64::from_le_bytes);
        first_pattern(first, self.metadata.n_patterns)
    }

    /// Force and moment of a pattern about the centre of a free body, in the body.
    fn wrench(&self, pattern: usize) -> Option<[f64; 6]> {
        let start = pattern.checked_mul(6)?.checked_add(11)?;
        let numbers = self.sections.rigid_body?.get(start..)?.first_chunk::<6>()?;
        Some(numbers.map(f64::from_le_bytes))
    }
}

impl<T: Scalar> Loads<'_, T> {
    /// Adds the centrifugal forces of a free body for a step in which its angular velocity \[rad/s, in the
    /// body\] goes from `before` to `after`: for a host that moves the body itself, and gives the scene the
    /// forces at its surface ([`Loads::add_contact`]) in the body. [`FreeBody::step`] does it itself.
    ///
    /// # Errors
    /// [`LoadError::Missing`] for a body with supports, and the errors of a pattern that cannot be added;
    /// some of the six may then have been added.
    pub fn add_spin(
        &mut self,
        scene: &Scene<'_, T>,
        before: [f64; 3],
        after: [f64; 3],
    ) -> Result<(), LoadError> {
        let kind = SectionKind::RigidBody;
        let first = scene.first_spin_pattern().ok_or(LoadError::Missing { kind })?;
        let density = scene.parameters.density;
        let products = |angular_velocity| {
            let [.., xx, yy, zz, xy, yz, zx] =
                BaseMotion { angular_velocity, ..BaseMotion::default() }.amplitudes();
            [xx, yy, zz, xy, yz, zx]
        };
        for (k, (before, after)) in products(before).into_iter().zip(products(after)).enumerate() {
            if before == 0.0 && after == 0.0 {
                continue;
            }
            // The forces grow with the density, the patterns are those of the file as it was built.
            let mut amplitudes = [density * after; 1 + MAX_STAGES];
            if let Some(first) = amplitudes.first_mut() {
                *first = density * before;
            }
            self.add_pattern_staged(scene, first + k, &amplitudes)?;
        }
        Ok(())
    }
}
