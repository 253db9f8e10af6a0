//! A world over bodies behind handles, in lent memory.

use core::mem::MaybeUninit;
use core::ptr::NonNull;

use vademecum_eval::{
    Anchor, AnyBody, Field, JointKind, Member, Near, Nodes, Pose, RigidBody, RigidMotion, RigidShape, Scalar,
    Slot, Touch, Touching, World, WorldError, WorldJoint, WorldMemory, WorldOptions, WorldSizes, WorldSizing,
};

use crate::handle::{Body, Handle, Lent};
use crate::message::Message;
use crate::refusal::{Answer, Refusal, needed};
use crate::slices::lent;
use crate::types::{VdmMotion, VdmPlace, VdmStatus};
use crate::world_types::{
    VdmAnchor, VdmAnchorKind, VdmJoint, VdmJointKind, VdmJointState, VdmMember, VdmNodes, VdmTouch,
    VdmTouching, VdmWorld, VdmWorldOptions, VdmWorldReport,
};

/// Alignment of the pieces of lent memory.
const PIECE: usize = 16;

/// Numbers of a placement, and of a rigid motion, in a saved world.
const POSE: usize = 7;
const MOTION: usize = 13;

/// A precision whose bodies are members of one world.
pub trait Precise: Scalar + 'static {
    /// The body in this precision.
    fn of(body: &mut Body) -> Option<&mut vademecum_eval::Body<'static, Self>>;
}

impl Precise for f32 {
    fn of(body: &mut Body) -> Option<&mut vademecum_eval::Body<'static, Self>> {
        match body {
            AnyBody::Single(body) => Some(body),
            #[cfg(feature = "double")]
            AnyBody::Double(_) => None,
        }
    }
}

#[cfg(feature = "double")]
impl Precise for f64 {
    fn of(body: &mut Body) -> Option<&mut vademecum_eval::Body<'static, Self>> {
        match body {
            AnyBody::Double(body) => Some(body),
            AnyBody::Single(_) => None,
        }
    }
}

/// A member between two calls.
enum Kept {
    /// A body with supports, or one whose frame the host moves, and its placement.
    Held(NonNull<Handle>, Pose),
    /// A body that flies.
    Free(NonNull<Handle>),
    /// A rigid member.
    Rigid(RigidShape<'static>),
}

type Lendable<T> = Member<'static, 'static, T>;

impl Kept {
    /// # Safety
    /// `member.body` is null or a handle whose memory stays lent as long as the world is used; otherwise
    /// `nodes` and `triangles` point to as many numbers as are said, which stay as they are as long.
    unsafe fn of(member: &VdmMember) -> Result<Self, Refusal> {
        if let Some(handle) = NonNull::new(member.body.cast::<Handle>()) {
            // SAFETY: as the caller promises.
            let flies = unsafe { handle.as_ref() }.body.flight().is_some();
            return Ok(if flies { Self::Free(handle) } else { Self::Held(handle, pose_of(&member.motion)) });
        }
        // SAFETY: as the caller promises.
        let (nodes, triangles) = unsafe {
            let nodes = lent(member.nodes, member.n_nodes.saturating_mul(3));
            (nodes, lent(member.triangles, member.n_triangles.saturating_mul(3)))
        };
        let nodes: &'static [[f64; 3]] = needed(nodes, "nodes")?.as_chunks().0;
        let triangles: &'static [[u32; 3]] = needed(triangles, "triangles")?.as_chunks().0;
        let shape = if member.mass.mass > 0.0 {
            let crate::types::VdmRigidBody { mass, centre, moments, axes } = member.mass;
            let body = RigidBody { mass, centre, moments, axes, first_pattern: 0 };
            let whole = moments.iter().all(|moment| *moment > 0.0);
            whole.then(|| RigidShape::moving(nodes, triangles, body, motion_of(&member.motion))).flatten()
        } else {
            RigidShape::led(nodes, triangles, pose_of(&member.motion))
        };
        let said = "a rigid member: a number is not finite, a moment of inertia is not above 0, or a triangle \
                    has a node that there is not";
        shape.map(Self::Rigid).ok_or(Refusal::Words(VdmStatus::VDM_WORLD, said))
    }

    /// It as a member of a world.
    ///
    /// # Safety
    /// As for [`Kept::of`]; nobody else uses the body, nor `kept`, as long as the member is used.
    unsafe fn lend<T: Precise>(kept: NonNull<Self>) -> Result<Lendable<T>, Refusal> {
        let said = "the bodies of a world are of one precision";
        let other = || Refusal::Words(VdmStatus::VDM_WORLD, said);
        // SAFETY: as the caller promises.
        unsafe {
            Ok(match &mut *kept.as_ptr() {
                Self::Held(handle, pose) => {
                    Member::Held(T::of(&mut (*handle.as_ptr()).body).ok_or_else(other)?, *pose)
                }
                Self::Free(handle) => Member::Free(T::of(&mut (*handle.as_ptr()).body).ok_or_else(other)?),
                Self::Rigid(shape) => Member::Rigid(shape),
            })
        }
    }
}

fn attitude_of(attitude: [f64; 4]) -> [f64; 4] {
    if attitude == [0.0; 4] { [1.0, 0.0, 0.0, 0.0] } else { attitude }
}

fn pose_of(motion: &VdmMotion) -> Pose {
    Pose::new(motion.position, attitude_of(motion.attitude))
}

fn motion_of(motion: &VdmMotion) -> RigidMotion {
    let VdmMotion { position, attitude, momentum, angular_momentum } = *motion;
    RigidMotion { position, attitude: attitude_of(attitude), momentum, angular_momentum }
}

fn options_of(given: Option<&VdmWorldOptions>) -> WorldOptions {
    let Some(given) = given else { return WorldOptions::default() };
    WorldOptions {
        gravity: given.gravity,
        reach: (given.reach != 0.0).then_some(given.reach),
        tolerance: (given.tolerance != 0.0).then_some(given.tolerance),
        sweeps: given.sweeps as usize,
        contacts: given.contacts as usize,
        near: given.near as usize,
        recover: given.recover,
    }
}

fn touching_of(pair: &VdmTouching) -> Result<Touching, Refusal> {
    let nodes = match pair.nodes {
        n if n == VdmNodes::VDM_NODES_BOTH as i32 => Nodes::Both,
        n if n == VdmNodes::VDM_NODES_FIRST as i32 => Nodes::First,
        n if n == VdmNodes::VDM_NODES_SECOND as i32 => Nodes::Second,
        _ => return Err(Refusal::Words(VdmStatus::VDM_ARGUMENT, "no such nodes of a pair: see VdmNodes")),
    };
    let members = [pair.first as usize, pair.second as usize];
    Ok(Touching { members, friction: pair.friction, restitution: pair.restitution, nodes })
}

fn anchor_of(anchor: &VdmAnchor) -> Result<Anchor, Refusal> {
    Ok(match anchor.kind {
        k if k == VdmAnchorKind::VDM_AT_PLACE as i32 => Anchor::Place(*AsRef::as_ref(&anchor.place)),
        k if k == VdmAnchorKind::VDM_AT_PORT as i32 => Anchor::Frame(anchor.port as usize),
        k if k == VdmAnchorKind::VDM_AT_POINT as i32 => {
            let own = anchor.axes.as_flattened().iter().all(|x| *x == 0.0);
            if own {
                Anchor::point(anchor.point)
            } else {
                Anchor::Point { at: anchor.point, axes: anchor.axes }
            }
        }
        _ => return Err(Refusal::Words(VdmStatus::VDM_ARGUMENT, "no such anchor: see VdmAnchorKind")),
    })
}

fn kind_of(joint: &VdmJoint) -> Result<JointKind, Refusal> {
    Ok(match joint.kind {
        k if k == VdmJointKind::VDM_BALL as i32 => JointKind::Ball,
        k if k == VdmJointKind::VDM_HINGE as i32 => JointKind::Hinge,
        k if k == VdmJointKind::VDM_SLIDER as i32 => JointKind::Slider,
        k if k == VdmJointKind::VDM_CABLE as i32 => JointKind::Cable { length: joint.length },
        _ => return Err(Refusal::Words(VdmStatus::VDM_ARGUMENT, "no such joint: see VdmJointKind")),
    })
}

fn joint_of(joint: &VdmJoint) -> Result<WorldJoint, Refusal> {
    let [first, second] = &joint.anchors;
    Ok(WorldJoint {
        kind: kind_of(joint)?,
        members: [joint.first as usize, joint.second as usize],
        anchors: [anchor_of(first)?, anchor_of(second)?],
        compliance: joint.compliance,
        breaks_at: if joint.breaks_at == 0.0 { f64::INFINITY } else { joint.breaks_at },
    })
}

/// Members, pairs and joints that a caller lists.
pub struct Listed<'a> {
    pub members: &'a [VdmMember],
    pub pairs: &'a [VdmTouching],
    pub joints: &'a [VdmJoint],
    pub options: Option<&'a VdmWorldOptions>,
}

impl Listed<'_> {
    /// True if its bodies are in double precision.
    ///
    /// # Safety
    /// As for [`Kept::of`].
    #[cfg(feature = "double")]
    unsafe fn is_double(&self) -> bool {
        let bodies = self.members.iter().filter_map(|member| NonNull::new(member.body.cast::<Handle>()));
        // SAFETY: as the caller promises.
        let mut all = bodies.map(|body| !matches!(unsafe { &body.as_ref().body }, AnyBody::Single(_)));
        all.next().unwrap_or(false)
    }

    fn check(&self) -> Result<(), Refusal> {
        let twice = self.members.iter().enumerate().any(|(i, member)| {
            let before = self.members.iter().take(i);
            !member.body.is_null() && before.into_iter().any(|other| other.body == member.body)
        });
        let said = "a body is a member of a world once";
        if twice { Err(Refusal::Words(VdmStatus::VDM_WORLD, said)) } else { Ok(()) }
    }

    /// Bytes to lend, and the sizes of the pieces.
    ///
    /// # Safety
    /// As for [`Kept::of`].
    unsafe fn sizes<T: Precise>(&self) -> Result<(usize, WorldSizes), Refusal> {
        self.check()?;
        let mut sizing = WorldSizing::default();
        for member in self.members {
            // SAFETY: as the caller promises; the member is gone before the next one.
            unsafe {
                let mut kept = Kept::of(member)?;
                sizing.add(&Kept::lend::<T>(NonNull::from(&mut kept))?)?;
            }
        }
        for joint in self.joints {
            kind_of(joint)?;
        }
        let joint = |j: usize| {
            let joint = self.joints.get(j)?;
            Some((kind_of(joint).ok()?, [joint.first as usize, joint.second as usize]))
        };
        let moves = |i: usize| {
            self.members.get(i).is_some_and(|member| !member.body.is_null() || member.mass.mass > 0.0)
        };
        let options = options_of(self.options);
        let sizes = sizing.sizes::<T>(self.joints.len(), joint, moves, &options)?;
        let pieces = [
            size_of::<WorldHandle>(),
            self.members.len().saturating_mul(size_of::<Kept>()),
            self.members.len().saturating_mul(size_of::<Lendable<T>>()),
            self.pairs.len().saturating_mul(size_of::<Touching>()),
            self.joints.len().saturating_mul(size_of::<WorldJoint>()),
            sizes.slots.saturating_mul(size_of::<Slot>()),
            sizes.touches.saturating_mul(size_of::<Touch>()),
            sizes.joints.saturating_mul(size_of::<vademecum_eval::JointState>()),
            sizes.near.saturating_mul(size_of::<Near>()),
            sizes.numbers.saturating_mul(size_of::<f64>()),
        ];
        let whole = |bytes: usize| bytes.div_ceil(PIECE).saturating_mul(PIECE);
        Ok((pieces.into_iter().map(whole).fold(0, usize::saturating_add), sizes))
    }

    /// Bytes to lend to a world of them.
    ///
    /// # Safety
    /// As for [`Kept::of`].
    pub unsafe fn bytes(&self) -> Result<usize, Refusal> {
        // SAFETY: as the caller promises.
        unsafe {
            #[cfg(feature = "double")]
            if self.is_double() {
                return Ok(self.sizes::<f64>()?.0);
            }
            Ok(self.sizes::<f32>()?.0)
        }
    }

    /// A world of them in lent memory.
    ///
    /// # Safety
    /// As for [`Kept::of`]; nobody else uses the memory.
    pub unsafe fn bind(&self, memory: Lent) -> Result<*mut VdmWorld, Refusal> {
        // SAFETY: as the caller promises.
        unsafe {
            #[cfg(feature = "double")]
            if self.is_double() {
                return self.bind_in(memory, AnyWorld::Double);
            }
            self.bind_in(memory, AnyWorld::Single)
        }
    }

    /// # Safety
    /// As for [`Listed::bind`].
    unsafe fn bind_in<T: Precise>(
        &self,
        memory: Lent,
        any: impl FnOnce(Live<T>) -> AnyWorld,
    ) -> Result<*mut VdmWorld, Refusal> {
        // SAFETY: as the caller promises; the pieces are within the bytes that were asked for.
        unsafe {
            let (bytes, sizes) = self.sizes::<T>()?;
            memory.check(bytes)?;
            let mut left = memory;
            let place = piece::<MaybeUninit<WorldHandle>>(&mut left, 1).as_mut_ptr();
            let kept = piece::<MaybeUninit<Kept>>(&mut left, self.members.len());
            for (kept, member) in kept.iter_mut().zip(self.members) {
                kept.write(Kept::of(member)?);
            }
            let kept = written(kept);
            let scratch = piece::<MaybeUninit<Lendable<T>>>(&mut left, self.members.len());
            let pairs = piece::<MaybeUninit<Touching>>(&mut left, self.pairs.len());
            for (pair, given) in pairs.iter_mut().zip(self.pairs) {
                pair.write(touching_of(given)?);
            }
            let pairs = written(pairs);
            let joints = piece::<MaybeUninit<WorldJoint>>(&mut left, self.joints.len());
            for (joint, given) in joints.iter_mut().zip(self.joints) {
                joint.write(joint_of(given)?);
            }
            let joints = written(joints);
            let memory = WorldMemory {
                slots: filled(&mut left, sizes.slots, Slot::default()),
                touches: filled(&mut left, sizes.touches, Touch::NONE),
                joints: filled(&mut left, sizes.joints, vademecum_eval::JointState::default()),
                near: filled(&mut left, sizes.near, Near::default()),
                numbers: filled(&mut left, sizes.numbers, 0.0),
            };
            let members = members::<T>(kept, scratch)?;
            let world = World::new(members, pairs, joints, &options_of(self.options), memory)?;
            let world = any(Live { world, kept, scratch });
            place.cast::<WorldHandle>().write(WorldHandle { world, message: Message::default() });
            Ok(place.cast())
        }
    }
}

/// The first `n` values of lent memory, not written yet; the rest is left.
///
/// # Safety
/// The memory is as long as the pieces that are taken, rounded up to 16 bytes each, and nobody else's.
unsafe fn piece<V>(left: &mut Lent, n: usize) -> &'static mut [V] {
    let bytes = n.saturating_mul(size_of::<V>()).div_ceil(PIECE).saturating_mul(PIECE);
    let at = left.at.cast::<V>();
    // SAFETY: as the caller promises; aligned to 16 as every piece is.
    unsafe {
        *left = Lent { at: left.at.add(bytes), bytes: left.bytes.saturating_sub(bytes) };
        core::slice::from_raw_parts_mut(at.as_ptr(), n)
    }
}

/// The same, filled with a value.
///
/// # Safety
/// As for [`piece`].
unsafe fn filled<V: Copy>(left: &mut Lent, n: usize, value: V) -> &'static mut [V] {
    // SAFETY: as the caller promises; every value is written.
    unsafe {
        let all = piece::<MaybeUninit<V>>(left, n);
        for each in &mut *all {
            each.write(value);
        }
        written(all)
    }
}

/// # Safety
/// Every value is written.
unsafe fn written<V>(all: &mut [MaybeUninit<V>]) -> &mut [V] {
    // SAFETY: as the caller promises; both are laid out alike.
    unsafe { &mut *(core::ptr::from_mut(all) as *mut [V]) }
}

/// The members, lent for a call.
///
/// # Safety
/// As for [`Kept::lend`].
unsafe fn members<'c, T: Precise>(
    kept: &mut [Kept],
    scratch: &'c mut [MaybeUninit<Lendable<T>>],
) -> Result<&'c mut [Lendable<T>], Refusal> {
    for (kept, place) in kept.iter_mut().zip(&mut *scratch) {
        // SAFETY: as the caller promises.
        place.write(unsafe { Kept::lend(NonNull::from(kept))? });
    }
    // SAFETY: there are as many of one as of the other.
    Ok(unsafe { written(scratch) })
}

/// A world in a precision.
pub struct Live<T: Precise> {
    world: World<'static, T>,
    kept: &'static mut [Kept],
    scratch: &'static mut [MaybeUninit<Lendable<T>>],
}

/// A world in the precision of its bodies.
pub enum AnyWorld {
    Single(Live<f32>),
    #[cfg(feature = "double")]
    Double(Live<f64>),
}

/// The world behind a handle.
#[repr(align(16))]
pub struct WorldHandle {
    world: AnyWorld,
    message: Message,
}

/// The same lines in the precision of a world.
macro_rules! in_precision {
    ($any:expr, $live:ident => $lines:expr) => {
        match $any {
            AnyWorld::Single($live) => $lines,
            #[cfg(feature = "double")]
            AnyWorld::Double($live) => $lines,
        }
    };
}

impl WorldHandle {
    /// # Safety
    /// `world` is null or a handle of [`Listed::bind`] whose memory, and that of whose bodies, is still lent,
    /// used by no other thread.
    pub unsafe fn of_mut<'a>(world: *mut VdmWorld) -> Option<&'a mut Self> {
        // SAFETY: as the caller promises.
        unsafe { world.cast::<Self>().as_mut() }
    }

    pub fn words(&self) -> *const core::ffi::c_char {
        self.message.as_ptr()
    }
}

/// Runs a call on a world and keeps the words of its refusal; a null handle has nowhere to keep them.
///
/// # Safety
/// As for [`WorldHandle::of_mut`].
pub unsafe fn on_world(world: *mut VdmWorld, run: impl FnOnce(&mut AnyWorld) -> Answer) -> VdmStatus {
    // SAFETY: as the caller promises.
    let Some(handle) = (unsafe { WorldHandle::of_mut(world) }) else { return VdmStatus::VDM_ARGUMENT };
    run(&mut handle.world).unwrap_or_else(|refusal| handle.message.note(&refusal))
}

/// The refusal of a number of a member or a joint.
const NO_SUCH: Refusal = Refusal::Words(VdmStatus::VDM_ARGUMENT, "the world has no such member or joint");

impl AnyWorld {
    /// Steps so often.
    ///
    /// # Safety
    /// As for [`WorldHandle::of_mut`].
    pub unsafe fn step(&mut self, steps: u64, out: &mut VdmWorldReport) -> Answer {
        *out = VdmWorldReport::default();
        in_precision!(self, live => {
            for _ in 0..steps {
                // SAFETY: as the caller promises.
                let members = unsafe { members(live.kept, live.scratch)? };
                let report = live.world.step(members)?;
                (out.contacts, out.pressed) = (report.contacts, report.pressed);
                out.left_out = out.left_out.max(report.left_out);
                out.sweeps += report.sweeps;
                out.not_converged += usize::from(!report.converged);
                out.worst_gap = out.worst_gap.max(report.worst_gap);
                out.energy_given_away += report.energy_given_away;
            }
        });
        Ok(VdmStatus::VDM_OK)
    }

    /// Kinetic and elastic energy \[J\].
    ///
    /// # Safety
    /// As for [`WorldHandle::of_mut`].
    pub unsafe fn energy(&mut self) -> Result<f64, Refusal> {
        Ok(in_precision!(self, live => {
            // SAFETY: as the caller promises.
            let members = unsafe { members(live.kept, live.scratch)? };
            live.world.energy(members)?
        }))
    }

    fn kept(&mut self, member: usize) -> Result<&mut Kept, Refusal> {
        in_precision!(self, live => live.kept.get_mut(member)).ok_or(NO_SUCH)
    }

    /// Placement of a member.
    ///
    /// # Safety
    /// As for [`WorldHandle::of_mut`].
    pub unsafe fn pose(&mut self, member: usize) -> Result<Pose, Refusal> {
        let of = |motion: &RigidMotion, centre: [f64; 3]| {
            let arm = motion.to_space(centre);
            Pose::new(core::array::from_fn(|k| motion.position[k] - arm[k]), motion.attitude)
        };
        Ok(match self.kept(member)? {
            Kept::Held(_, pose) => *pose,
            Kept::Free(handle) => {
                // SAFETY: as the caller promises.
                let body = unsafe { &handle.as_ref().body };
                let flight = body.motion().zip(body.rigid_body());
                flight.map_or(Pose::IDENTITY, |(motion, rigid)| of(motion, rigid.centre))
            }
            Kept::Rigid(shape) => of(shape.motion(), shape.body().map_or([0.0; 3], |body| body.centre)),
        })
    }

    /// Puts a held body elsewhere, or leads a rigid member there.
    pub fn lead(&mut self, member: usize, pose: Pose) -> Answer {
        let said = "a number of the placement is not finite, its attitude is not of length one, or the member \
                    is not led by the host";
        let led = match self.kept(member)? {
            Kept::Held(_, own) if pose.is_sound() => {
                *own = pose;
                Some(())
            }
            Kept::Rigid(shape) if shape.body().is_none() => shape.lead(pose),
            _ => None,
        };
        led.ok_or(Refusal::Words(VdmStatus::VDM_ARGUMENT, said))?;
        Ok(VdmStatus::VDM_OK)
    }

    /// The rigid member of a number.
    pub fn rigid(&mut self, member: usize) -> Result<&mut RigidShape<'static>, Refusal> {
        let said = "the member is a body: vdm_push, vdm_pull, vdm_motion and vdm_set_motion are for it";
        match self.kept(member)? {
            Kept::Rigid(shape) => Ok(shape),
            _ => Err(Refusal::Words(VdmStatus::VDM_ARGUMENT, said)),
        }
    }

    /// Position \[m\] or velocity \[m/s\] in space of a place of a body.
    ///
    /// # Safety
    /// As for [`WorldHandle::of_mut`].
    pub unsafe fn in_space(
        &mut self,
        member: usize,
        place: &VdmPlace,
        field: Field,
    ) -> Result<[f64; 3], Refusal> {
        match self.kept(member)? {
            Kept::Free(handle) => {
                // SAFETY: as the caller promises.
                let body = unsafe { &handle.as_ref().body };
                Ok(body.in_space(place, field)?)
            }
            Kept::Held(handle, pose) => {
                // SAFETY: as the caller promises.
                let body = unsafe { &handle.as_ref().body };
                let moved = body.point(place, field)?;
                if field == Field::Velocity {
                    return Ok(pose.turn(moved));
                }
                let rest = in_rest(body, place)?;
                Ok(pose.place(core::array::from_fn(|k| rest[k] + moved[k])))
            }
            Kept::Rigid(_) => {
                let said = "the member is rigid: vdm_world_pose is for it";
                Err(Refusal::Words(VdmStatus::VDM_ARGUMENT, said))
            }
        }
    }

    /// Contacts of the last step, as far as there is room; gives their number.
    pub fn touches(&self, out: &mut [VdmTouch]) -> usize {
        let all = in_precision!(self, live => live.world.touches());
        for (out, touch) in out.iter_mut().zip(all) {
            let [first, second] = touch.members().map(|member| member as u32);
            *out = VdmTouch {
                first,
                second,
                position: touch.position(),
                normal: touch.normal(),
                force: touch.force(),
                pressure: touch.pressure(),
                gap: touch.gap(),
                slip: touch.slip(),
            };
        }
        all.len()
    }

    /// A joint after the last step.
    pub fn joint(&self, joint: usize) -> Result<VdmJointState, Refusal> {
        let state = in_precision!(self, live => live.world.joints().get(joint)).ok_or(NO_SUCH)?;
        let broken = u32::from(state.is_broken());
        Ok(VdmJointState { force: state.force(), moment: state.moment(), broken })
    }

    /// Breaks a joint.
    pub fn break_joint(&mut self, joint: usize) -> Answer {
        in_precision!(self, live => live.world.break_joint(joint)).ok_or(NO_SUCH)?;
        Ok(VdmStatus::VDM_OK)
    }

    /// Forgets the contacts of the last step.
    pub fn forget(&mut self) -> VdmStatus {
        in_precision!(self, live => live.world.forget());
        VdmStatus::VDM_OK
    }

    /// Numbers of a saved world.
    pub fn saved_len(&self) -> usize {
        in_precision!(self, live => {
            let of = |kept: &Kept| match kept {
                Kept::Held(..) => POSE,
                Kept::Free(_) => 0,
                Kept::Rigid(_) => MOTION,
            };
            live.world.saved_len() + live.kept.iter().map(of).sum::<usize>()
        })
    }

    /// Writes contacts, joints, placements of held bodies and motions of rigid members.
    pub fn save_into(&self, out: &mut [f64]) -> Answer {
        let (found, needed) = (out.len(), self.saved_len());
        if found != needed {
            return Err(WorldError::LentMemory { found, needed }.into());
        }
        in_precision!(self, live => {
            let (own, rest) = out.split_at_mut(live.world.saved_len());
            live.world.save_into(own)?;
            let mut rest = rest.iter_mut();
            let mut put = |numbers: &[f64]| {
                rest.by_ref().zip(numbers).for_each(|(out, number)| *out = *number);
            };
            for kept in &*live.kept {
                match kept {
                    Kept::Held(_, pose) => {
                        put(&pose.position());
                        put(&pose.attitude());
                    }
                    Kept::Free(_) => {}
                    Kept::Rigid(shape) => {
                        let RigidMotion { position, attitude, momentum, angular_momentum } = shape.motion();
                        put(position);
                        put(attitude);
                        put(momentum);
                        put(angular_momentum);
                    }
                }
            }
        });
        Ok(VdmStatus::VDM_OK)
    }

    /// Takes them back; nothing has changed where they are refused.
    pub fn restore(&mut self, saved: &[f64]) -> Answer {
        let (found, needed) = (saved.len(), self.saved_len());
        if found != needed {
            return Err(WorldError::LentMemory { found, needed }.into());
        }
        in_precision!(self, live => {
            let (own, rest) = saved.split_at(live.world.saved_len());
            take(live.kept, rest, false)?;
            live.world.restore(own)?;
            take(live.kept, rest, true)?;
        });
        Ok(VdmStatus::VDM_OK)
    }
}

/// Reads placements and motions of members, and takes them over if that is asked for.
fn take(all: &mut [Kept], mut saved: &[f64], over: bool) -> Result<(), Refusal> {
    let said = "the numbers are no saved state of this world";
    let none = || Refusal::Words(VdmStatus::VDM_STATE, said);
    for kept in all {
        match kept {
            Kept::Held(_, own) => {
                let (&[x, y, z, a, b, c, d], rest) = saved.split_first_chunk::<POSE>().ok_or_else(none)?;
                saved = rest;
                let pose = Pose::new([x, y, z], [a, b, c, d]);
                if !pose.is_sound() {
                    return Err(none());
                }
                if over {
                    *own = pose;
                }
            }
            Kept::Free(_) => {}
            Kept::Rigid(shape) => {
                let (numbers, rest) = saved.split_first_chunk::<MOTION>().ok_or_else(none)?;
                saved = rest;
                let &[x, y, z, a, b, c, d, i, j, k, l, m, n] = numbers;
                let (position, attitude) = ([x, y, z], [a, b, c, d]);
                let (momentum, angular_momentum) = ([i, j, k], [l, m, n]);
                let motion = RigidMotion { position, attitude, momentum, angular_momentum };
                let mut other = *shape;
                other.restore(motion).ok_or_else(none)?;
                if over {
                    *shape = other;
                }
            }
        }
    }
    Ok(())
}

/// Position at rest of a place of a body \[m\].
fn in_rest(body: &Body, place: &VdmPlace) -> Result<[f64; 3], Refusal> {
    Ok(match body {
        AnyBody::Single(body) => body.position(place)?,
        #[cfg(feature = "double")]
        AnyBody::Double(body) => body.position(place)?,
    })
}
