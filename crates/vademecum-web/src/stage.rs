//! A world on a page: files, members, joints and pairs in memory of its own, the ways of members that are
//! led, the hands that pull, and the strikes that are heard.
//!
//! A stage is filled once, part by part, and lives as long as the page: its memory is given out and never
//! taken back. It starts over from the state that it had when it was bound.

use alloc::boxed::Box;
use alloc::vec;
use alloc::vec::Vec;

use vademecum_eval::format::{File, FormatError, SectionKind};
use vademecum_eval::{
    Body, BodyOptions, Field, Lead, Member, Pose, RigidBody, RigidMotion, RigidShape, Touch, Touching, World,
    WorldBuffers, WorldJoint, WorldOptions, WorldReport,
};

use crate::pull::{Pull, motion_of, placed, thrown};
use crate::refusal::Refusal;
use crate::strikes::Strikes;
use crate::vectors::{Vector, dot, length, minus, plus};

/// Most contacts of one body; of more the world keeps the deepest.
const MOST_CONTACTS: usize = 1024;

/// A member that is led, where it stands at the start, and its way.
struct Led {
    member: usize,
    start: Pose,
    way: Lead<'static>,
}

/// A world on a page.
#[derive(Default)]
pub struct Stage {
    /// Files, and the nodes of their surfaces at rest.
    files: Vec<(File<'static>, Vec<Vector>)>,
    members: Vec<Member<'static, 'static, f64>>,
    /// File of each member.
    file_of: Vec<usize>,
    led: Vec<Led>,
    pairs: Vec<Touching>,
    joints: Vec<WorldJoint>,
    bound: Option<Bound>,
    /// Hands, by their numbers.
    pulls: Vec<(u32, Pull)>,
}

/// A world that is bound, and what it was.
struct Bound {
    world: World<'static, f64>,
    strikes: Strikes,
    time_step: f64,
    gravity: Vector,
    steps: u64,
    report: WorldReport,
    joints_broken: usize,
    start: Vec<u8>,
}

/// Placement and motion of a part at the start.
#[derive(Clone, Copy, Debug, Default)]
pub struct Start {
    /// Place of the origin of its coordinates \[m\].
    pub position: Vector,
    /// Its rotation, a unit quaternion, real part first.
    pub rotation: [f64; 4],
    /// Velocity of its centre of mass \[m/s\].
    pub velocity: Vector,
    /// Angular velocity in space \[rad/s\].
    pub spin: Vector,
}

impl Start {
    fn pose(&self) -> Pose {
        Pose::new(self.position, self.rotation)
    }

    fn motion(&self, body: &RigidBody) -> RigidMotion {
        let still = RigidMotion {
            position: self.position,
            attitude: self.rotation,
            momentum: [0.0; 3],
            angular_momentum: [0.0; 3],
        };
        let position = plus(self.position, still.to_space(body.centre));
        thrown(RigidMotion { position, ..still }, body, self.velocity, self.spin)
    }
}

/// The field that is drawn on a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shown {
    /// Displacement of the nodes in their body \[m\].
    Displacement,
    /// Velocity of the nodes in space \[m/s\].
    Velocity,
}

impl Stage {
    /// An empty stage.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            files: Vec::new(),
            members: Vec::new(),
            file_of: Vec::new(),
            led: Vec::new(),
            pairs: Vec::new(),
            joints: Vec::new(),
            bound: None,
            pulls: Vec::new(),
        }
    }

    /// Opens a file and compares every section with its checksum; its number.
    ///
    /// # Errors
    /// [`FormatError`].
    pub fn open(&mut self, bytes: &'static [u8]) -> Result<usize, FormatError> {
        let file = File::parse(bytes)?;
        file.verify_all()?;
        let count = file.metadata().n_surface_nodes as usize;
        let coordinates =
            file.section(SectionKind::NodeCoordinates).and_then(|section| section.numbers().ok());
        let at = |i: usize| coordinates.as_ref().and_then(|all| all.get(i)).unwrap_or(0.0);
        let nodes = (0..count).map(|node| [at(3 * node), at(3 * node + 1), at(3 * node + 2)]).collect();
        self.files.push((file, nodes));
        Ok(self.files.len() - 1)
    }

    /// A file by its number.
    #[must_use]
    pub fn file(&self, number: usize) -> Option<&File<'static>> {
        self.files.get(number).map(|(file, _)| file)
    }

    /// Members, in the order in which they were added.
    #[must_use]
    pub fn members(&self) -> &[Member<'static, 'static, f64>] {
        &self.members
    }

    fn push(&mut self, member: Member<'static, 'static, f64>, file: usize) -> Result<usize, Refusal> {
        if self.bound.is_some() {
            return Err(Refusal::BadPart);
        }
        self.members.push(member);
        self.file_of.push(file);
        Ok(self.members.len() - 1)
    }

    /// Adds a body of a file with room for so many contacts; its number. A body without supports flies.
    ///
    /// # Errors
    /// [`Refusal`].
    pub fn add_body(
        &mut self,
        number: usize,
        time_step: f64,
        contacts: usize,
        start: &Start,
    ) -> Result<usize, Refusal> {
        let (file, _) = self.files.get(number).ok_or(Refusal::BadPart)?;
        let mut options = BodyOptions { places: 1, ..BodyOptions::default() };
        options.scene.time_step = Some(time_step);
        options.scene.contacts = contacts.min(MOST_CONTACTS);
        let memory = vec![0.0; Body::<f64>::len_for(file, &options)?].leak();
        let body = Box::leak(Box::new(Body::bind(file, &options, memory)?));
        match body.rigid_body() {
            Some(rigid) => {
                body.set_motion(start.motion(&rigid)).ok_or(Refusal::BadPart)?;
                self.push(Member::Free(body), number)
            }
            None => self.push(Member::Held(body, start.pose()), number),
        }
    }

    /// Adds a rigid body; its number. Without mass it stands or is led.
    ///
    /// # Errors
    /// [`Refusal::BadPart`].
    pub fn add_rigid(
        &mut self,
        nodes: &'static [Vector],
        triangles: &'static [[u32; 3]],
        body: Option<RigidBody>,
        start: &Start,
    ) -> Result<usize, Refusal> {
        let shape = match body {
            None => RigidShape::led(nodes, triangles, start.pose()),
            Some(body) => RigidShape::moving(nodes, triangles, body, start.motion(&body)),
        };
        self.push(Member::Rigid(Box::leak(Box::new(shape.ok_or(Refusal::BadPart)?))), usize::MAX)
    }

    /// Adds a pair that may touch.
    pub fn add_pair(&mut self, pair: Touching) {
        self.pairs.push(pair);
    }

    /// Adds a joint.
    pub fn add_joint(&mut self, joint: WorldJoint) {
        self.joints.push(joint);
    }

    /// Leads a member that is held, or a rigid one without mass, along a way from where it stands.
    ///
    /// # Errors
    /// [`Refusal::BadPart`]: any other member.
    pub fn lead(&mut self, member: usize, way: Lead<'static>) -> Result<(), Refusal> {
        let start = match self.members.get(member) {
            Some(Member::Held(_, pose)) => *pose,
            Some(Member::Rigid(shape)) if shape.body().is_none() => {
                Pose::new(shape.motion().position, shape.motion().attitude)
            }
            _ => return Err(Refusal::BadPart),
        };
        self.led.push(Led { member, start, way });
        Ok(())
    }

    /// Makes the world of all that was added.
    ///
    /// # Errors
    /// [`Refusal`].
    pub fn bind(&mut self, options: &WorldOptions, time_step: f64) -> Result<(), Refusal> {
        lead(&mut self.members, &self.led, 0.0);
        let joints = self.joints.clone().leak();
        let pairs = self.pairs.clone().leak();
        let sizes = World::sizes(&self.members, joints, options)?;
        let buffers = Box::leak(Box::new(WorldBuffers::new(&sizes)));
        let world = World::new(&self.members, pairs, joints, options, buffers.lend())?;
        self.bound = Some(Bound {
            world,
            strikes: Strikes::default(),
            time_step,
            gravity: options.gravity,
            steps: 0,
            report: WorldReport::default(),
            joints_broken: 0,
            start: Vec::new(),
        });
        let start = self.save()?;
        if let Some(bound) = &mut self.bound {
            bound.start = start;
        }
        Ok(())
    }

    fn bound(&self) -> Result<&Bound, Refusal> {
        self.bound.as_ref().ok_or(Refusal::NoWorld)
    }

    /// Time \[s\].
    ///
    /// # Errors
    /// [`Refusal::NoWorld`].
    pub fn time(&self) -> Result<f64, Refusal> {
        self.bound().map(|bound| bound.steps as f64 * bound.time_step)
    }

    /// Report of the last step, and how many joints broke since the start.
    ///
    /// # Errors
    /// [`Refusal::NoWorld`].
    pub fn report(&self) -> Result<(WorldReport, usize), Refusal> {
        self.bound().map(|bound| (bound.report, bound.joints_broken))
    }

    /// Contacts of the last step.
    ///
    /// # Errors
    /// [`Refusal::NoWorld`].
    pub fn touches(&self) -> Result<&[Touch], Refusal> {
        self.bound().map(|bound| bound.world.touches())
    }

    /// The joints as they are after the last step: the force on the first member in space \[N\], and whether
    /// it is broken.
    ///
    /// # Errors
    /// [`Refusal::NoWorld`].
    pub fn joints(&self) -> Result<impl Iterator<Item = (Vector, bool)>, Refusal> {
        let states = self.bound()?.world.joints();
        Ok(states.iter().map(|state| (state.force(), state.is_broken())))
    }

    /// Kinetic and elastic energy, and the potential of gravity \[J\].
    ///
    /// # Errors
    /// [`Refusal`].
    pub fn energies(&self) -> Result<[f64; 2], Refusal> {
        let bound = self.bound()?;
        let mass = |member: &Member<'_, '_, f64>| match member {
            Member::Free(body) => body.rigid_body().map_or(0.0, |body| body.mass),
            Member::Rigid(shape) => shape.body().map_or(0.0, |body| body.mass),
            Member::Held(..) => 0.0,
        };
        let potential =
            |member: &Member<'_, '_, f64>| -mass(member) * dot(bound.gravity, motion_of(member).0.position);
        Ok([bound.world.energy(&self.members)?, self.members.iter().map(potential).sum()])
    }

    /// Takes a step.
    ///
    /// # Errors
    /// [`Refusal`].
    pub fn step(&mut self) -> Result<(), Refusal> {
        let bound = self.bound.as_mut().ok_or(Refusal::NoWorld)?;
        let end = (bound.steps + 1) as f64 * bound.time_step;
        lead(&mut self.members, &self.led, end);
        for (_, pull) in &mut self.pulls {
            let member = self.members.get_mut(pull.member).ok_or(Refusal::BadPull)?;
            pull.act(member, bound.time_step)?;
        }
        bound.report = bound.world.step(&mut self.members)?;
        bound.joints_broken += bound.report.broken;
        bound.steps += 1;
        bound.strikes.hear(bound.world.touches(), bound.time_step);
        Ok(())
    }

    /// Strikes that were heard; [`Strikes::taken`] forgets them. `None` before the world is bound.
    pub fn strikes(&mut self) -> Option<&mut Strikes> {
        self.bound.as_mut().map(|bound| &mut bound.strikes)
    }

    /// Lays a hand on a member, or moves it, by a number of its own.
    ///
    /// # Errors
    /// [`Refusal::BadPull`].
    pub fn pull(&mut self, hand: u32, pull: Pull) -> Result<(), Refusal> {
        let sizes = [pull.stiffness, pull.damping];
        let sound = sizes.iter().all(|x| x.is_finite() && *x >= 0.0) && pull.stiffness > 0.0;
        let member = self.members.get(pull.member).ok_or(Refusal::BadPull)?;
        if !sound || !pull.target.iter().all(|x| x.is_finite()) {
            return Err(Refusal::BadPull);
        }
        pull.at(member)?;
        match self.pulls.iter_mut().find(|(number, _)| *number == hand) {
            Some((_, old)) => *old = pull,
            None => self.pulls.push((hand, pull)),
        }
        Ok(())
    }

    /// The hands on the members, by their numbers.
    #[must_use]
    pub fn pulls(&self) -> &[(u32, Pull)] {
        &self.pulls
    }

    /// Moves a hand. `None` if there is none of this number, or a number is not finite.
    pub fn move_pull(&mut self, hand: u32, target: Vector) -> Option<()> {
        let finite = target.iter().all(|x| x.is_finite());
        let (_, pull) = self.pulls.iter_mut().find(|(number, _)| *number == hand && finite)?;
        pull.target = target;
        Some(())
    }

    /// Takes a hand away.
    pub fn release(&mut self, hand: u32) {
        self.pulls.retain(|(number, _)| *number != hand);
    }

    /// Throws a member that moves freely from where it is: velocity of its centre \[m/s\], angular velocity
    /// in space \[rad/s\].
    ///
    /// # Errors
    /// [`Refusal::BadPart`].
    pub fn throw(&mut self, member: usize, velocity: Vector, spin: Vector) -> Result<(), Refusal> {
        let member = self.members.get_mut(member).ok_or(Refusal::BadPart)?;
        let (motion, _) = motion_of(member);
        let set = match member {
            Member::Free(body) => {
                let rigid = body.rigid_body().ok_or(Refusal::BadPart)?;
                body.set_motion(thrown(motion, &rigid, velocity, spin))
            }
            Member::Rigid(shape) => {
                let rigid = *shape.body().ok_or(Refusal::BadPart)?;
                shape.set_motion(thrown(motion, &rigid, velocity, spin))
            }
            Member::Held(..) => None,
        };
        set.ok_or(Refusal::BadPart)
    }

    /// Breaks a joint.
    ///
    /// # Errors
    /// [`Refusal`]: there is none of this number.
    pub fn break_joint(&mut self, joint: usize) -> Result<(), Refusal> {
        let bound = self.bound.as_mut().ok_or(Refusal::NoWorld)?;
        let already = bound.world.joints().get(joint).is_some_and(|state| state.is_broken());
        bound.world.break_joint(joint).ok_or(Refusal::BadPart)?;
        bound.joints_broken += usize::from(!already);
        Ok(())
    }

    /// Sets the acceleration of gravity \[m/s²\].
    ///
    /// # Errors
    /// [`Refusal::BadPart`]: numbers that are not finite.
    pub fn set_gravity(&mut self, gravity: Vector) -> Result<(), Refusal> {
        let bound = self.bound.as_mut().ok_or(Refusal::NoWorld)?;
        bound.world.set_gravity(gravity).ok_or(Refusal::BadPart)?;
        bound.gravity = gravity;
        Ok(())
    }

    /// Place of the origin of a member in space \[m\], and its rotation.
    #[must_use]
    pub fn pose(&self, member: usize) -> Option<([f64; 3], [f64; 4])> {
        let motion = motion_of(self.members.get(member)?);
        Some((placed(&motion, [0.0; 3]), motion.0.attitude))
    }

    /// Mass of a member that moves freely \[kg\]; 0 of any other.
    #[must_use]
    pub fn mass(&self, member: usize) -> f64 {
        match self.members.get(member) {
            Some(Member::Free(body)) => body.rigid_body().map_or(0.0, |body| body.mass),
            Some(Member::Rigid(shape)) => shape.body().map_or(0.0, |body| body.mass),
            _ => 0.0,
        }
    }

    /// Number of nodes of the surface of a member.
    #[must_use]
    pub fn n_nodes(&self, member: usize) -> usize {
        match self.members.get(member) {
            Some(Member::Rigid(shape)) => shape.nodes().len(),
            _ => self.rest(member).len(),
        }
    }

    /// Nodes at rest of a member of a file, in its own coordinates.
    fn rest(&self, member: usize) -> &[Vector] {
        let file = self.file_of.get(member).and_then(|file| self.files.get(*file));
        file.map_or(&[], |(_, nodes)| nodes.as_slice())
    }

    /// Writes nodes of the surface of a member in space \[m\] and a field there, three numbers each.
    ///
    /// # Errors
    /// [`Refusal`].
    pub fn surface_into(
        &self,
        member: usize,
        shown: Shown,
        work: &mut Vec<f64>,
        nodes: &mut [[f32; 3]],
        field: &mut [[f32; 3]],
    ) -> Result<(), Refusal> {
        let rests = self.rest(member);
        let member = self.members.get(member).ok_or(Refusal::BadPart)?;
        let motion = motion_of(member);
        let single = |x: Vector| x.map(|x| x as f32);
        let count = nodes.len();
        match member {
            Member::Free(body) | Member::Held(body, _) => {
                work.clear();
                work.resize(6 * count, 0.0);
                let (moved, rates) = work.split_at_mut(3 * count);
                body.surface_into(Field::Displacement, moved)?;
                if shown == Shown::Velocity {
                    body.surface_into(Field::Velocity, rates)?;
                }
                let rigid = body.rigid_body();
                let each = moved.as_chunks::<3>().0.iter().zip(rates.as_chunks::<3>().0).zip(rests);
                for (((by, rate), rest), (node, field)) in each.zip(nodes.iter_mut().zip(field)) {
                    let at = plus(*rest, *by);
                    *node = single(placed(&motion, at));
                    *field = single(match shown {
                        Shown::Displacement => *by,
                        Shown::Velocity => plus(
                            motion.0.to_space(*rate),
                            rigid.map_or([0.0; 3], |rigid| carried(&motion.0, &rigid, at)),
                        ),
                    });
                }
            }
            Member::Rigid(shape) => {
                for (rest, (node, field)) in shape.nodes().iter().zip(nodes.iter_mut().zip(field)) {
                    *node = single(placed(&motion, *rest));
                    *field = single(match (shown, shape.body()) {
                        (Shown::Velocity, Some(rigid)) => carried(&motion.0, rigid, *rest),
                        _ => [0.0; 3],
                    });
                }
            }
        }
        Ok(())
    }

    /// The state of all: time, contacts, joints and members.
    ///
    /// # Errors
    /// [`Refusal`].
    pub fn save(&self) -> Result<Vec<u8>, Refusal> {
        let mut out = Vec::new();
        self.save_into(&mut out)?;
        Ok(out)
    }

    /// Writes what [`Stage::save`] gives to `out`, in place of what was there.
    ///
    /// # Errors
    /// [`Refusal`].
    pub fn save_into(&self, out: &mut Vec<u8>) -> Result<(), Refusal> {
        let bound = self.bound()?;
        let lengths = self.members.iter().map(|member| match member {
            Member::Free(body) | Member::Held(body, _) => body.saved_len(),
            Member::Rigid(_) => 0,
        });
        let mut state = vec![0; lengths.max().unwrap_or(0)];
        out.clear();
        let mut numbers = vec![0.0; 2 + bound.world.saved_len()];
        if let [steps, broken, world @ ..] = numbers.as_mut_slice() {
            (*steps, *broken) = (bound.steps as f64, bound.joints_broken as f64);
            bound.world.save_into(world)?;
        }
        add(out, &numbers);
        for member in &self.members {
            match member {
                Member::Free(body) | Member::Held(body, _) => {
                    let length = body.save_into(&mut state)?;
                    add(out, &[length as f64]);
                    out.extend(state.iter().take(length));
                }
                Member::Rigid(shape) => add(out, &flat(shape.motion())),
            }
        }
        Ok(())
    }

    /// Takes back what [`Stage::save`] of the same world gave. Members may be elsewhere after a refusal.
    ///
    /// # Errors
    /// [`Refusal`].
    pub fn restore(&mut self, saved: &[u8]) -> Result<(), Refusal> {
        let bound = self.bound.as_mut().ok_or(Refusal::NoWorld)?;
        let mut left = saved;
        let numbers = take(&mut left, 2 + bound.world.saved_len()).ok_or(Refusal::BadState)?;
        let [steps, broken, world @ ..] = numbers.as_slice() else { return Err(Refusal::BadState) };
        bound.world.restore(world)?;
        (bound.steps, bound.joints_broken) = (*steps as u64, *broken as usize);
        bound.report = WorldReport::default();
        bound.strikes.forget();
        for member in &mut self.members {
            match member {
                Member::Free(body) | Member::Held(body, _) => {
                    let length = take(&mut left, 1).and_then(|numbers| numbers.first().copied());
                    let length = length.ok_or(Refusal::BadState)? as usize;
                    let (own, rest) = left.split_at_checked(length).ok_or(Refusal::BadState)?;
                    body.restore(own)?;
                    left = rest;
                }
                Member::Rigid(shape) => {
                    let numbers = take(&mut left, 13).ok_or(Refusal::BadState)?;
                    let motion = motion(&numbers).ok_or(Refusal::BadState)?;
                    shape.set_motion(motion).ok_or(Refusal::BadState)?;
                }
            }
        }
        lead(&mut self.members, &self.led, bound.steps as f64 * bound.time_step);
        if left.is_empty() { Ok(()) } else { Err(Refusal::BadState) }
    }

    /// Starts over; gravity and hands stay.
    ///
    /// # Errors
    /// [`Refusal`].
    pub fn reset(&mut self) -> Result<(), Refusal> {
        let start = core::mem::take(&mut self.bound.as_mut().ok_or(Refusal::NoWorld)?.start);
        let done = self.restore(&start);
        if let Some(bound) = &mut self.bound {
            bound.start = start;
        }
        done
    }
}

/// Puts the members that are led where they are to be at a time \[s\].
fn lead(members: &mut [Member<'_, '_, f64>], led: &[Led], time: f64) {
    for Led { member, start, way } in led {
        let pose = Pose::new(plus(start.position(), way.at(time)), start.attitude());
        if let Some(member) = members.get_mut(*member) {
            // It was such a member when it was added.
            let _ = member.lead(pose);
        }
    }
}

/// Velocity of a point of a rigid motion.
fn carried(motion: &RigidMotion, rigid: &RigidBody, at: Vector) -> Vector {
    let arm = motion.to_space(minus(at, rigid.centre));
    let [a, b, c] = motion.to_space(motion.spin(rigid));
    let turning = [b * arm[2] - c * arm[1], c * arm[0] - a * arm[2], a * arm[1] - b * arm[0]];
    core::array::from_fn(|k| motion.momentum[k] / rigid.mass + turning[k])
}

fn add(out: &mut Vec<u8>, numbers: &[f64]) {
    numbers.iter().for_each(|x| out.extend(x.to_le_bytes()));
}

fn take(left: &mut &[u8], count: usize) -> Option<Vec<f64>> {
    let (own, rest) = left.split_at_checked(count.checked_mul(8)?)?;
    *left = rest;
    Some(own.as_chunks::<8>().0.iter().map(|bytes| f64::from_le_bytes(*bytes)).collect())
}

fn flat(motion: &RigidMotion) -> [f64; 13] {
    let mut out = [0.0; 13];
    let all = motion.position.iter().chain(&motion.attitude).chain(&motion.momentum);
    out.iter_mut().zip(all.chain(&motion.angular_momentum)).for_each(|(out, x)| *out = *x);
    out
}

fn motion(numbers: &[f64]) -> Option<RigidMotion> {
    let &[x, y, z, w, i, j, k, px, py, pz, lx, ly, lz] = numbers else { return None };
    Some(RigidMotion {
        position: [x, y, z],
        attitude: [w, i, j, k],
        momentum: [px, py, pz],
        angular_momentum: [lx, ly, lz],
    })
}

/// Sum of the sizes of the contact forces \[N\].
#[must_use]
pub fn pressed(touches: &[Touch]) -> f64 {
    touches.iter().map(|touch| length(touch.force())).sum()
}
