//! Lent memory of a world, and the pieces that it is cut into.

use crate::base::lend::{Lender, Short};
use crate::base::scalar::Scalar;
use crate::world::bounds;
use crate::world::joint::{JointState, ROWS};
use crate::world::joints::Joints;
use crate::world::member::Member;
use crate::world::options::WorldOptions;
use crate::world::patch::Near;
use crate::world::rows::padded;
use crate::world::slot::Slot;
use crate::world::touch::Touch;

/// Memory to lend to a [`World`](crate::World).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct WorldSizes {
    /// One for each member.
    pub slots: usize,
    /// Of [`Touch`].
    pub touches: usize,
    /// Of [`JointState`].
    pub joints: usize,
    /// Of [`Near`]; 0 if no file has a contact patch.
    pub near: usize,
    /// Of `f64`.
    pub numbers: usize,
}

/// Memory lent to a [`World`](crate::World): at least what [`World::sizes`](crate::World::sizes) says. Its
/// contents do not matter.
#[derive(Debug)]
pub struct WorldMemory<'m> {
    /// Of the members.
    pub slots: &'m mut [Slot],
    /// Of the contacts.
    pub touches: &'m mut [Touch],
    /// Of the joints.
    pub joints: &'m mut [JointState],
    /// Of the contacts near each contact.
    pub near: &'m mut [Near],
    /// Everything else.
    pub numbers: &'m mut [f64],
}

/// Memory of a world on the heap (feature `alloc`).
#[cfg(feature = "alloc")]
#[derive(Debug)]
pub struct WorldBuffers {
    slots: alloc::vec::Vec<Slot>,
    touches: alloc::vec::Vec<Touch>,
    joints: alloc::vec::Vec<JointState>,
    near: alloc::vec::Vec<Near>,
    numbers: alloc::vec::Vec<f64>,
}

#[cfg(feature = "alloc")]
impl WorldBuffers {
    /// Memory of these sizes.
    #[must_use]
    pub fn new(sizes: &WorldSizes) -> Self {
        Self {
            slots: alloc::vec![Slot::default(); sizes.slots],
            touches: alloc::vec![Touch::NONE; sizes.touches],
            joints: alloc::vec![JointState::default(); sizes.joints],
            near: alloc::vec![Near::default(); sizes.near],
            numbers: alloc::vec![0.0; sizes.numbers],
        }
    }

    /// The memory, for [`World::new`](crate::World::new).
    pub fn lend(&mut self) -> WorldMemory<'_> {
        let Self { slots, touches, joints, near, numbers } = self;
        WorldMemory { slots, touches, joints, near, numbers }
    }
}

/// Lengths of the pieces of all members together.
#[derive(Debug, Default)]
pub(crate) struct Lengths {
    order: usize,
    boxes: usize,
    extents: usize,
    nodes: usize,
    modes: usize,
    /// Most modes, and most further modes, of a member.
    pub largest: usize,
    furthest: usize,
    coordinates: usize,
    /// Most coordinates of a member.
    stride: usize,
    statics: usize,
    indices: usize,
    has_patch: bool,
    members: usize,
}

impl Lengths {
    /// Adds a member, and says where its pieces are; `None` of a file without a surface.
    pub fn add<T: Scalar>(&mut self, member: &Member<'_, '_, T>) -> Option<Slot> {
        let outline = member.outline()?;
        let r = member.elastic().map_or(0, |body| body.scene.n_modes());
        let is_rigid = member.rigid().is_some();
        let patch = member.elastic().and_then(|body| body.patch);
        let m = patch.map_or(0, |patch| patch.n_modes);
        let n = padded(r + m + if is_rigid { 6 } else { 0 });
        let triangles = outline.n_triangles();
        let [order, boxes, extents] = bounds::sizes(triangles, r);
        let slot = Slot {
            r,
            m,
            has_patch: patch.is_some(),
            index: self.indices,
            statics: self.statics,
            n,
            triangles,
            n_boxes: boxes / 6,
            n_nodes: outline.n_nodes(),
            order: self.order,
            boxes: self.boxes,
            extents: self.extents,
            nodes: self.nodes,
            ahead: self.modes,
            first: self.coordinates,
            is_rigid,
            ..Slot::default()
        };
        self.members += 1;
        self.order = self.order.saturating_add(order);
        self.boxes = self.boxes.saturating_add(boxes / 6);
        self.extents = self.extents.saturating_add(extents);
        self.nodes = self.nodes.saturating_add(slot.n_nodes);
        self.modes = self.modes.saturating_add(r);
        self.statics = self.statics.saturating_add(m);
        self.has_patch |= slot.has_patch;
        if slot.has_patch {
            self.indices = self.indices.saturating_add(slot.n_nodes + 1);
        }
        self.largest = self.largest.max(r);
        self.furthest = self.furthest.max(m);
        self.coordinates = self.coordinates.saturating_add(n);
        self.stride = self.stride.max(n);
        Some(slot)
    }

    /// Blocks between contacts.
    pub const fn near(&self, options: &WorldOptions) -> usize {
        if self.has_patch { options.contacts.saturating_mul(options.near) } else { 0 }
    }
}

/// Numbers that are cut from lent memory, or counted before it is lent.
pub(crate) enum Tape<'m> {
    /// So many were asked for.
    Counted(usize),
    /// Memory to cut.
    Lent(Lender<&'m mut [f64]>),
}

impl<'m> Tape<'m> {
    fn words(&mut self, n: usize) -> Result<&'m mut [f64], Short> {
        match self {
            Self::Counted(count) => {
                *count = count.saturating_add(n);
                Ok(&mut [])
            }
            Self::Lent(memory) => memory.take(n),
        }
    }

    fn u32s(&mut self, n: usize) -> Result<&'m mut [u32], Short> {
        Ok(exactly(bytemuck::cast_slice_mut(self.words(n.div_ceil(2))?), n))
    }

    fn f32s(&mut self, n: usize) -> Result<&'m mut [f32], Short> {
        Ok(exactly(bytemuck::cast_slice_mut(self.words(n.div_ceil(2))?), n))
    }

    fn scalars<T: Scalar>(&mut self, n: usize) -> Result<&'m mut [T], Short> {
        let words = n.saturating_mul(size_of::<T>()).div_ceil(size_of::<f64>());
        Ok(exactly(T::of_words(self.words(words)?), n))
    }
}

/// The first `n` numbers; none where they are counted only.
fn exactly<V>(all: &mut [V], n: usize) -> &mut [V] {
    all.get_mut(..n).unwrap_or_default()
}

/// Pieces of the members and of the contacts.
#[derive(Debug)]
pub(crate) struct Room<'m, T> {
    /// Triangles in the order of the trees, boxes at rest, extents of the modes in each.
    pub order: &'m mut [u32],
    pub boxes: &'m mut [[f32; 6]],
    pub extents: &'m mut [f32],
    /// Boxes of the moving surface, and the steps they are of.
    pub moved: &'m mut [[f32; 6]],
    pub fresh: &'m mut [u32],
    /// Boxes of the members in space.
    pub around: &'m mut [[f64; 6]],
    /// Normals at rest, positions, the steps they are of, and the searches that saw them, of the nodes.
    pub normals: &'m mut [[f32; 3]],
    pub positions: &'m mut [[f64; 3]],
    pub stamps: &'m mut [u32],
    pub visits: &'m mut [u32],
    /// First pair of each node of the patches.
    pub indices: &'m mut [u32],
    /// Coordinates of the modes at the end of the step without contacts, and rows of one place.
    pub ahead: &'m mut [T],
    pub work: &'m mut [T],
    /// Amplitudes of the further modes, and rows of one place.
    pub statics: &'m mut [f64],
    pub further: &'m mut [f64],
    /// Coordinates, and their answers to a unit force held over the step.
    pub x: &'m mut [f64],
    pub p: &'m mut [f64],
    /// Rows of the contacts: per contact and side three of `stride` numbers at most.
    pub rows: &'m mut [f64],
    pub stride: usize,
}

impl<'m, T: Scalar> Room<'m, T> {
    /// Cuts or counts them.
    pub fn cut(tape: &mut Tape<'m>, lengths: &Lengths, contacts: usize) -> Result<Self, Short> {
        let stride = lengths.stride;
        Ok(Self {
            order: tape.u32s(lengths.order)?,
            boxes: tape.f32s(lengths.boxes.saturating_mul(6))?.as_chunks_mut().0,
            extents: tape.f32s(lengths.extents)?,
            moved: tape.f32s(lengths.boxes.saturating_mul(6))?.as_chunks_mut().0,
            fresh: tape.u32s(lengths.boxes)?,
            around: tape.words(lengths.members.saturating_mul(6))?.as_chunks_mut().0,
            normals: tape.f32s(lengths.nodes.saturating_mul(3))?.as_chunks_mut().0,
            positions: tape.words(lengths.nodes.saturating_mul(3))?.as_chunks_mut().0,
            stamps: tape.u32s(lengths.nodes)?,
            visits: tape.u32s(lengths.nodes)?,
            indices: tape.u32s(lengths.indices)?,
            ahead: tape.scalars(lengths.modes)?,
            work: tape.scalars(lengths.largest.saturating_mul(3))?,
            statics: tape.words(lengths.statics)?,
            further: tape.words(lengths.furthest.saturating_mul(3))?,
            x: tape.words(lengths.coordinates)?,
            p: tape.words(lengths.coordinates)?,
            rows: tape.words(contacts.saturating_mul(6).saturating_mul(stride))?,
            stride,
        })
    }
}

/// Cuts or counts the pieces of so many joints; `envelope` has their rows, and the numbers of their matrix.
pub(crate) fn cut_joints<'m>(
    tape: &mut Tape<'m>,
    lengths: &Lengths,
    count: usize,
    [rows, numbers]: [usize; 2],
) -> Result<Joints<'m>, Short> {
    let each = count.saturating_mul(2 * ROWS);
    Ok(Joints {
        all: &[],
        states: &mut [],
        rows: tape.words(each.saturating_mul(lengths.stride))?,
        basis: tape.words(each.saturating_mul(lengths.largest))?,
        largest: lengths.largest,
        starts: tape.u32s(rows)?,
        offsets: tape.u32s(rows)?,
        matrix: tape.words(numbers)?,
        gaps: tape.words(rows)?,
    })
}
