//! Binding a world: checks, lent memory, trees over the surfaces, and the joints as they stand.

use crate::base::lend::Lender;
use crate::base::scalar::Scalar;
use crate::base::vec3::{cross, dot, minus};
use crate::world::bounds;
use crate::world::error::WorldError;
use crate::world::frame::Frame;
use crate::world::joint::{JointKind, JointState, WorldJoint, at_rest, rows_of};
use crate::world::joints::{JointRows, Joints, envelope, first_shared, rows_and_members};
use crate::world::member::{Member, Outline};
use crate::world::options::WorldOptions;
use crate::world::patch;
use crate::world::room::{Lengths, Room, Tape, WorldMemory, WorldSizes, cut_joints};
use crate::world::slot::{Slot, Touching};
use crate::world::world::World;

/// Sizes of a world whose members and joints are shown one by one, where there is no memory for lists of them
/// yet.
#[derive(Debug, Default)]
pub struct WorldSizing {
    lengths: Lengths,
    members: usize,
}

impl WorldSizing {
    /// Adds a member.
    ///
    /// # Errors
    /// [`WorldError::Member`].
    pub fn add<T: Scalar>(&mut self, member: &Member<'_, '_, T>) -> Result<(), WorldError> {
        check_member(self.members, member)?;
        self.lengths.add(member).ok_or(no_surface(self.members))?;
        self.members = self.members.saturating_add(1);
        Ok(())
    }

    /// The memory that a world of the members asks for, with `count` joints, of which `joint` gives kind and
    /// members. `moves` is true of a member that is a body, or rigid with a mass.
    ///
    /// # Errors
    /// [`WorldError`].
    pub fn sizes<T: Scalar>(
        &self,
        count: usize,
        joint: impl Fn(usize) -> Option<(JointKind, [usize; 2])>,
        moves: impl Fn(usize) -> bool,
        options: &WorldOptions,
    ) -> Result<WorldSizes, WorldError> {
        let rows = |i: usize| joint(i).map(|(kind, members)| (rows_of(kind), members));
        self.sized::<T>(count, rows, moves, options)
    }

    fn sized<T: Scalar>(
        &self,
        count: usize,
        joint: impl Fn(usize) -> JointRows,
        moves: impl Fn(usize) -> bool,
        options: &WorldOptions,
    ) -> Result<WorldSizes, WorldError> {
        let mut tape = Tape::Counted(0);
        Room::<T>::cut(&mut tape, &self.lengths, options.contacts)?;
        cut_joints(&mut tape, &self.lengths, count, envelope(count, joint, moves))?;
        let numbers = if let Tape::Counted(numbers) = tape { numbers } else { 0 };
        let (touches, near) = (options.contacts.saturating_mul(2), self.lengths.near(options));
        Ok(WorldSizes { slots: self.members, touches, joints: count, near, numbers })
    }
}

impl<'m, T: Scalar> World<'m, T> {
    /// The memory that a world of these members and joints asks for.
    ///
    /// # Errors
    /// [`WorldError::Member`].
    pub fn sizes(
        members: &[Member<'_, '_, T>],
        joints: &[WorldJoint],
        options: &WorldOptions,
    ) -> Result<WorldSizes, WorldError> {
        let mut sizing = WorldSizing::default();
        members.iter().try_for_each(|member| sizing.add(member))?;
        sizing.sized::<T>(joints.len(), rows_and_members(joints), moves(members), options)
    }

    /// A world of these members, of which `pairs` may touch and `joints` hold some together. `O(n r)` in the
    /// nodes of the surfaces.
    ///
    /// # Errors
    /// [`WorldError`].
    pub fn new(
        members: &[Member<'_, '_, T>],
        pairs: &'m [Touching],
        joints: &'m [WorldJoint],
        options: &WorldOptions,
        memory: WorldMemory<'m>,
    ) -> Result<Self, WorldError> {
        let sizes = Self::sizes(members, joints, options)?;
        let slots = lent(memory.slots, sizes.slots)?;
        let touches = lent(memory.touches, sizes.touches)?;
        let states = lent(memory.joints, sizes.joints)?;
        let near = lent(memory.near, sizes.near)?;
        let numbers = lent(memory.numbers, sizes.numbers)?;
        options.check()?;
        check_pairs(members, pairs)?;
        let time_step = common_step(members)?;
        let mut lengths = Lengths::default();
        for (i, (slot, member)) in slots.iter_mut().zip(members).enumerate() {
            *slot = lengths.add(member).ok_or(no_surface(i))?;
        }
        numbers.fill(0.0);
        let mut tape = Tape::Lent(Lender::new(numbers));
        let mut room = Room::cut(&mut tape, &lengths, options.contacts)?;
        let envelope = envelope(joints.len(), rows_and_members(joints), moves(members));
        let cut = cut_joints(&mut tape, &lengths, joints.len(), envelope)?;
        let joints = Joints { all: joints, states, ..cut };
        lay_out(joints.all, joints.states, moves(members), joints.starts, joints.offsets);
        for (j, (state, joint)) in joints.states.iter_mut().zip(joints.all).enumerate() {
            place_joint(joint, state, members).ok_or(WorldError::Joint { joint: j })?;
        }
        let mut smallest = f64::INFINITY;
        for (slot, member) in slots.iter().zip(members) {
            smallest = smallest.min(build(slot, member, &mut room)?);
        }
        let (now, before) = touches.split_at_mut(options.contacts);
        Ok(Self {
            options: *options,
            pairs,
            joints,
            slots,
            now,
            before,
            n_now: 0,
            ordered: true,
            near,
            room,
            step: 0,
            visit: 0,
            time_step,
            reach: options.reach.unwrap_or(0.02 * smallest),
            tolerance: options.tolerance.unwrap_or(1e-9 * smallest),
            smallest,
            stored: 0.0,
        })
    }
}

/// Builds tree, index of the patch and normals of a member; the diagonal of its box \[m\], infinite without a
/// surface.
fn build<T: Scalar>(
    slot: &Slot,
    member: &Member<'_, '_, T>,
    room: &mut Room<'_, T>,
) -> Result<f64, WorldError> {
    let Some(outline) = member.outline() else { return Ok(f64::INFINITY) };
    let boxes = part(room.boxes, slot.boxes, slot.n_boxes);
    let extents = part(room.extents, slot.extents, 3 * slot.r * slot.n_boxes);
    let basis = member.elastic().and_then(|body| body.scene.sections.rows.surface);
    let displacement = |node: u32, mode: usize, component: usize| {
        let at = (3 * node as usize + component) * slot.r + mode;
        basis.and_then(|basis| basis.get(at)).unwrap_or(0.0)
    };
    let order = part(room.order, slot.order, 4 * slot.triangles);
    bounds::build(&outline, slot.r, displacement, (order, boxes, extents))?;
    if let Some(patch) = member.elastic().and_then(|body| body.patch.as_ref()) {
        patch::index(patch, part(room.indices, slot.index, slot.n_nodes + 1));
    }
    set_normals(&outline, part(room.normals, slot.nodes, slot.n_nodes));
    let Some(&[a, b, c, d, e, f]) = room.boxes.get(slot.boxes).filter(|_| slot.n_boxes > 0) else {
        return Ok(f64::INFINITY);
    };
    let size = minus([d, e, f].map(f64::from), [a, b, c].map(f64::from));
    Ok(libm::sqrt(dot(size, size)))
}

/// `n` numbers from `first` on.
fn part<V>(all: &mut [V], first: usize, n: usize) -> &mut [V] {
    all.get_mut(first..).and_then(|all| all.get_mut(..n)).unwrap_or_default()
}

/// The first pieces of lent memory.
fn lent<V>(memory: &mut [V], needed: usize) -> Result<&mut [V], WorldError> {
    let found = memory.len();
    memory.get_mut(..needed).ok_or(WorldError::LentMemory { found, needed })
}

/// `true` of a member that forces move or bend.
fn moves<'a, T: Scalar>(members: &'a [Member<'_, '_, T>]) -> impl Fn(usize) -> bool + 'a {
    |i| members.get(i).is_some_and(|member| member.elastic().is_some() || member.rigid().is_some())
}

/// Rows of the joints in the envelope of their matrix.
fn lay_out(
    joints: &[WorldJoint],
    states: &mut [JointState],
    moves: impl Fn(usize) -> bool,
    starts: &mut [u32],
    offsets: &mut [u32],
) {
    let (mut row, mut offset) = (0, 0);
    for i in 0..joints.len() {
        let shared = first_shared(rows_and_members(joints), i, &moves);
        let before = states.get(shared).map_or(row, |state| if shared == i { row } else { state.first_row });
        let Some((state, joint)) = states.get_mut(i).zip(joints.get(i)) else { continue };
        let rows = rows_of(joint.kind);
        *state = JointState { first_row: row, first_shared: shared, rows, ..JointState::default() };
        for _ in 0..rows {
            if let (Some(start), Some(place)) = (starts.get_mut(row), offsets.get_mut(row)) {
                (*start, *place) = (before as u32, offset as u32);
            }
            row += 1;
            offset += row - before;
        }
    }
}

/// Anchors of a joint at rest; `None` where they do not fit it.
fn place_joint<T: Scalar>(
    joint: &WorldJoint,
    state: &mut JointState,
    members: &[Member<'_, '_, T>],
) -> Option<()> {
    let [a, b] = joint.members;
    let length = if let JointKind::Cable { length } = joint.kind { length } else { 0.0 };
    let sound = a != b
        && joint.compliance.in_range()
        && joint.compliance >= 0.0
        && length.in_range()
        && joint.breaks_at >= 0.0
        && length >= 0.0;
    sound.then_some(())?;
    let mut frames = [Frame::default(); 2];
    for side in 0..2 {
        let member = members.get(joint.members[side])?;
        let (rest, axes) = at_rest(member, &joint.anchors[side], joint.kind)?;
        (state.rest[side], state.axes[side]) = (rest, axes);
        frames[side] = member.frame()?;
    }
    state.align([&frames[0], &frames[1]]);
    Some(())
}

/// Outward normals of the nodes of a surface at rest, weighted by the areas of their triangles.
fn set_normals(outline: &Outline<'_>, normals: &mut [[f32; 3]]) {
    for triangle in 0..outline.n_triangles() {
        let Some(nodes) = outline.triangle(triangle) else { continue };
        let [Some(a), Some(b), Some(c)] = nodes.map(|node| outline.node(node)) else { continue };
        let up = cross(minus(b, a), minus(c, a));
        for node in nodes {
            if let Some(normal) = normals.get_mut(node as usize) {
                normal.iter_mut().zip(up).for_each(|(normal, up)| *normal += up as f32);
            }
        }
    }
}

const fn no_surface(member: usize) -> WorldError {
    WorldError::Member { member, reason: "its file has no surface that may be touched" }
}

fn check_member<T: Scalar>(i: usize, member: &Member<'_, '_, T>) -> Result<(), WorldError> {
    let refuse = |reason| Err(WorldError::Member { member: i, reason });
    let Some(body) = member.elastic() else { return Ok(()) };
    let shape = body.scene.shape;
    if shape.is_strain() {
        return refuse("a file of large displacements is not a member of a world yet");
    }
    if shape.is_block() || !shape.is_modal() {
        return refuse("a file with a separated step is not a member of a world yet");
    }
    if shape.is_coupled() {
        return refuse("a file whose dashpots couple the modes is not a member of a world yet");
    }
    match member {
        Member::Free(body) if body.flight.is_none() => {
            refuse("it does not fly: bind it with flight, or put it into the world as a held body")
        }
        Member::Held(body, _) if body.flight.is_some() => {
            refuse("it flies: put it into the world as a free body, or bind it without flight")
        }
        _ => Ok(()),
    }
}

fn check_pairs<T: Scalar>(members: &[Member<'_, '_, T>], pairs: &[Touching]) -> Result<(), WorldError> {
    for (pair, touching) in pairs.iter().enumerate() {
        let [a, b] = touching.members;
        let elastic = |i: usize| members.get(i).map(|member| member.elastic().is_some());
        let some = matches!((elastic(a), elastic(b)), (Some(a), Some(b)) if a || b);
        let numbers = touching.friction >= 0.0
            && touching.friction.in_range()
            && (0.0..=1.0).contains(&touching.restitution);
        if a == b || !some || !numbers {
            return Err(WorldError::Pair { pair });
        }
    }
    Ok(())
}

/// The step of all bodies.
fn common_step<T: Scalar>(members: &[Member<'_, '_, T>]) -> Result<f64, WorldError> {
    let mut step = None;
    for (i, member) in members.iter().enumerate() {
        let Some(body) = member.elastic() else { continue };
        let own = body.scene.parameters.time_step;
        if *step.get_or_insert(own) != own {
            let reason = "its step is not that of the bodies before it: bind all to one";
            return Err(WorldError::Member { member: i, reason });
        }
    }
    step.ok_or(WorldError::Member { member: 0, reason: "a world has at least one body of a file" })
}
