//! A world: members, the pairs of them that may touch, and a step of all together.
//!
//! ```text
//! free motion of each member            (exact, to the end of the step)
//! contacts: nodes near triangles        (where the surfaces will be)
//! forces: gap and slip at the end       (held over the step, Coulomb's friction)
//! step of each member under them
//! ```
//!
//! With the residual flexibility of each contact the law is at the level of displacements, at the end of the
//! step. A step then never adds energy, whatever `Δt`, stiffness and number of contacts: under forces that
//! are held the exact modes take `f' · Δ(Γq)`, and with `γ = g₀ + Γq + Sf` and `E = E_modes + ½ fᵀSf`
//!
//! ```text
//! E' − E = f'·(γ' − γ) − ½ (f' − f)ᵀ S (f' − f) + f_t'·slip ≤ 0
//! ```
//!
//! since `f' ≥ 0` acts where `γ' = min(0, γ)` at most. Rigid motions take the forces at the instant
//! `(1 − η)/2` of the step, which takes `½ η Δt² fᵀ W f` more and makes an impact shorter than the step as
//! inelastic as it is asked to be.

use core::cell::Cell;

use crate::base::error::{LoadError, StepError};
use crate::base::lend::Lender;
use crate::base::scalar::Scalar;
use crate::base::vec3::{add, cross, dot, minus};
use crate::sections::contact::Contact;
use crate::sections::place::Place;
use crate::world::bounds;
use crate::world::error::WorldError;
use crate::world::find::{Found, Surfaces, find};
use crate::world::frame::{Frame, motion_of, turned};
use crate::world::joint::{Anchor, JointKind, JointState, ROWS, WorldJoint, at_rest};
use crate::world::joints::{Joints, envelope, first_shared, gather};
use crate::world::member::{Member, Outline, kicked};
use crate::world::patch::{self, Near};
use crate::world::rows::{answers, padded};
use crate::world::slot::{Slot, Touching};
use crate::world::solve::{System, show, start, sweep};
use crate::world::touch::Touch;

/// Options of a [`World`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WorldOptions {
    /// Acceleration of gravity in space \[m/s²\]; it acts on free and on rigid members. A held body has a
    /// load pattern for it.
    pub gravity: [f64; 3],
    /// Distance up to which nodes and triangles are paired \[m\]; a fiftieth of the smallest member if
    /// `None`.
    pub reach: Option<f64>,
    /// Largest change of a displacement in the last sweep of the solution \[m\]; 1e-9 of the smallest member
    /// if `None`.
    pub tolerance: Option<f64>,
    /// Most sweeps of a step.
    pub sweeps: usize,
    /// Contacts for which there is room. Of more the deepest are kept.
    pub contacts: usize,
    /// Contacts near each contact for which there is room, of bodies whose files have a contact patch.
    pub near: usize,
    /// Share of an overlap, of pairs that changed, that a step takes back.
    pub recover: f64,
}

impl Default for WorldOptions {
    fn default() -> Self {
        Self {
            gravity: [0.0; 3],
            reach: None,
            tolerance: None,
            sweeps: 200,
            contacts: 256,
            near: 64,
            recover: 0.1,
        }
    }
}

/// Memory to lend to a [`World`].
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

/// Report of a step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[must_use]
pub struct WorldReport {
    /// Pairs of nodes and surfaces that were near each other.
    pub contacts: usize,
    /// Those that carry a force.
    pub pressed: usize,
    /// Pairs for which there was no room.
    pub left_out: usize,
    /// Sweeps of the solution.
    pub sweeps: usize,
    /// `true` if the solution is within its tolerance. If not, the forces are those of the last sweep.
    pub converged: bool,
    /// Deepest overlap at the end of the step \[m\]; 0 if there is none.
    pub worst_gap: f64,
    /// Energy that contacts took from the members \[J\]: friction, impact, and what the residual flexibility
    /// gives away. Below 0 where overlaps were taken back.
    pub energy_given_away: f64,
}

/// Memory lent to a [`World`]: at least what [`World::sizes`] says. What is in it does not matter.
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

/// Members that touch and are joined, in lent memory. The members themselves are lent for each step.
#[derive(Debug)]
pub struct World<'m, T> {
    pub(crate) options: WorldOptions,
    pairs: &'m [Touching],
    pub(crate) joints: Joints<'m>,
    pub(crate) slots: &'m mut [Slot],
    pub(crate) now: &'m mut [Touch],
    before: &'m mut [Touch],
    pub(crate) n_now: usize,
    order: &'m mut [u32],
    boxes: &'m mut [[f32; 6]],
    extents: &'m mut [f32],
    normals: &'m mut [[f32; 3]],
    positions: &'m mut [[f64; 3]],
    stamps: &'m mut [u32],
    visits: &'m mut [u32],
    pub(crate) ahead: &'m mut [T],
    pub(crate) work: &'m mut [T],
    rows: &'m mut [f64],
    pub(crate) x: &'m mut [f64],
    pub(crate) p: &'m mut [f64],
    pub(crate) stride: usize,
    pub(crate) step: u32,
    visit: u32,
    pub(crate) time_step: f64,
    reach: f64,
    pub(crate) tolerance: f64,
    /// Diagonal of the box of the smallest member \[m\].
    pub(crate) smallest: f64,
    near: &'m mut [Near],
    /// Amplitudes of the further modes of the members.
    pub(crate) statics: &'m mut [f64],
    further: &'m mut [f64],
    moved: &'m mut [[f32; 6]],
    fresh: &'m mut [u32],
    /// First pair of each node of the patches.
    indices: &'m mut [u32],
    /// Energy of the contacts in the residual flexibility.
    pub(crate) stored: f64,
}

/// Lengths of all pieces.
#[derive(Default)]
struct Pieces {
    order: usize,
    boxes: usize,
    extents: usize,
    nodes: usize,
    modes: usize,
    largest: usize,
    coordinates: usize,
    stride: usize,
    statics: usize,
    indices: usize,
    has_patch: bool,
}

impl Pieces {
    fn add<T: Scalar>(&mut self, member: &Member<'_, '_, T>) -> Option<Slot> {
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
        self.coordinates = self.coordinates.saturating_add(n);
        self.stride = self.stride.max(n);
        Some(slot)
    }

    const fn rows(&self, contacts: usize) -> usize {
        contacts.saturating_mul(6).saturating_mul(self.stride)
    }

    /// Numbers of `f64` of each piece: order, boxes, extents, normals, positions, stamps, visits, coordinates
    /// ahead, work, rows, coordinates and their answers; rows and basis of the joints, first columns and
    /// offsets of their envelope, its numbers, and their gaps; amplitudes and rows of further
    /// modes; moved boxes and their stamps; first pairs of nodes.
    fn words<T: Scalar>(&self, contacts: usize, joints: usize, [rows, numbers]: [usize; 2]) -> [usize; 23] {
        let halves = |n: usize| n.div_ceil(2);
        let of_scalar = |n: usize| n.saturating_mul(size_of::<T>()).div_ceil(size_of::<f64>());
        [
            halves(self.order),
            self.boxes.saturating_mul(3),
            halves(self.extents),
            halves(self.nodes.saturating_mul(3)),
            self.nodes.saturating_mul(3),
            halves(self.nodes),
            halves(self.nodes),
            of_scalar(self.modes),
            of_scalar(self.largest.saturating_mul(3)),
            self.rows(contacts),
            self.coordinates,
            self.coordinates,
            joints.saturating_mul(2 * ROWS).saturating_mul(self.stride),
            joints.saturating_mul(2 * ROWS).saturating_mul(self.largest),
            halves(rows),
            halves(rows),
            numbers,
            rows,
            self.statics,
            self.statics_work().saturating_mul(3),
            self.boxes.saturating_mul(3),
            halves(self.boxes),
            halves(self.indices),
        ]
    }

    /// Most coordinates of a member: room for rows of its further modes.
    const fn statics_work(&self) -> usize {
        self.stride
    }

    /// Blocks between contacts.
    const fn near(&self, options: &WorldOptions) -> usize {
        if self.has_patch { options.contacts.saturating_mul(options.near) } else { 0 }
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
        let mut pieces = Pieces::default();
        for (i, member) in members.iter().enumerate() {
            check_member(i, member)?;
            pieces.add(member).ok_or(no_surface(i))?;
        }
        let envelope = envelope(joints, moves(members));
        let words = pieces.words::<T>(options.contacts, joints.len(), envelope);
        let numbers = words.into_iter().fold(0, usize::saturating_add);
        let touches = options.contacts.saturating_mul(2);
        let near = pieces.near(options);
        Ok(WorldSizes { slots: members.len(), touches, joints: joints.len(), near, numbers })
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
        let mut pieces = Pieces::default();
        for (i, (slot, member)) in slots.iter_mut().zip(members).enumerate() {
            *slot = pieces.add(member).ok_or(no_surface(i))?;
        }
        check_options(options)?;
        check_pairs(members, pairs)?;
        let time_step = common_step(members)?;

        let envelope = envelope(joints, moves(members));
        let [
            order,
            boxes,
            extents,
            normals,
            positions,
            stamps,
            visits,
            ahead,
            work,
            rows,
            x,
            p,
            joint_rows,
            joint_basis,
            starts,
            offsets,
            matrix,
            gaps,
            statics,
            further,
            moved,
            fresh,
            indices,
        ] = pieces.words::<T>(options.contacts, joints.len(), envelope);
        numbers.fill(0.0);
        let mut numbers = Lender::new(numbers);
        let order: &mut [u32] = bytemuck::cast_slice_mut(numbers.take(order)?);
        let (boxes, _) = bytemuck::cast_slice_mut::<f64, f32>(numbers.take(boxes)?).as_chunks_mut();
        let extents: &mut [f32] = bytemuck::cast_slice_mut(numbers.take(extents)?);
        let (normals, _) = bytemuck::cast_slice_mut::<f64, f32>(numbers.take(normals)?).as_chunks_mut();
        let (positions, _) = numbers.take(positions)?.as_chunks_mut();
        let stamps: &mut [u32] = bytemuck::cast_slice_mut(numbers.take(stamps)?);
        let visits: &mut [u32] = bytemuck::cast_slice_mut(numbers.take(visits)?);
        let (ahead, work) = (T::of_words(numbers.take(ahead)?), T::of_words(numbers.take(work)?));
        let (rows, x, p) = (numbers.take(rows)?, numbers.take(x)?, numbers.take(p)?);
        let (joint_rows, basis) = (numbers.take(joint_rows)?, numbers.take(joint_basis)?);
        let starts: &mut [u32] = bytemuck::cast_slice_mut(numbers.take(starts)?);
        let offsets: &mut [u32] = bytemuck::cast_slice_mut(numbers.take(offsets)?);
        let (matrix, gaps) = (numbers.take(matrix)?, numbers.take(gaps)?);
        let (statics, further) = (numbers.take(statics)?, numbers.take(further)?);
        let (moved, _) = bytemuck::cast_slice_mut::<f64, f32>(numbers.take(moved)?).as_chunks_mut();
        let fresh: &mut [u32] = bytemuck::cast_slice_mut(numbers.take(fresh)?);
        let indices: &mut [u32] = bytemuck::cast_slice_mut(numbers.take(indices)?);
        let starts = starts.get_mut(..envelope[0]).unwrap_or_default();
        let offsets = offsets.get_mut(..envelope[0]).unwrap_or_default();
        lay_out(joints, states, moves(members), starts, offsets);
        for (j, (state, joint)) in states.iter_mut().zip(joints).enumerate() {
            place_joint(joint, state, members, slots).ok_or(WorldError::Joint { joint: j })?;
        }
        let joints = Joints {
            all: joints,
            states,
            rows: joint_rows,
            basis,
            largest: pieces.largest,
            starts,
            offsets,
            matrix,
            gaps,
        };
        let mut smallest = f64::INFINITY;
        for (slot, member) in slots.iter().zip(members) {
            let Some(outline) = member.outline() else { continue };
            let pieces = (
                order.get_mut(slot.order..).unwrap_or_default(),
                boxes.get_mut(slot.boxes..).and_then(|all| all.get_mut(..slot.n_boxes)).unwrap_or_default(),
                extents
                    .get_mut(slot.extents..)
                    .and_then(|all| all.get_mut(..3 * slot.r * slot.n_boxes))
                    .unwrap_or_default(),
            );
            let basis = member.elastic().and_then(|body| body.scene.sections.rows.surface);
            let displacement = |node: u32, mode: usize, component: usize| {
                let at = (3 * node as usize + component) * slot.r + mode;
                basis.and_then(|basis| basis.get(at)).unwrap_or(0.0)
            };
            bounds::build(&outline, slot.r, displacement, pieces)?;
            if let Some(patch) = member.elastic().and_then(|body| body.patch.as_ref()) {
                let own = indices.get_mut(slot.index..).and_then(|all| all.get_mut(..slot.n_nodes + 1));
                patch::index(patch, own.unwrap_or_default());
            }
            let own = normals.get_mut(slot.nodes..).and_then(|all| all.get_mut(..slot.n_nodes));
            set_normals(&outline, own.unwrap_or_default());
            if let Some(corners) = boxes.get(slot.boxes).filter(|_| slot.n_boxes > 0) {
                let size: [f64; 3] =
                    core::array::from_fn(|k| f64::from(corners[3 + k]) - f64::from(corners[k]));
                smallest = smallest.min(libm::sqrt(dot(size, size)));
            }
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
            order,
            boxes,
            extents,
            normals,
            positions,
            stamps,
            visits,
            ahead,
            work,
            rows,
            x,
            p,
            stride: pieces.stride,
            step: 0,
            visit: 0,
            time_step,
            reach: options.reach.unwrap_or(0.02 * smallest),
            tolerance: options.tolerance.unwrap_or(1e-9 * smallest),
            smallest,
            near,
            statics,
            further,
            moved,
            fresh,
            indices,
            stored: 0.0,
        })
    }

    /// Joints as they are after the last step.
    #[must_use]
    pub fn joints(&self) -> &[JointState] {
        self.joints.states
    }

    /// Breaks a joint: it holds nothing any more. The energy of the residual flexibility under its force is
    /// given up, and nothing else changes. `None` if there is no such joint.
    pub fn break_joint(&mut self, joint: usize) -> Option<()> {
        let state = self.joints.states.get_mut(joint)?;
        (state.broken, state.force) = (true, [0.0; ROWS]);
        Some(())
    }

    /// Contacts of the last step.
    #[must_use]
    pub fn touches(&self) -> &[Touch] {
        self.now.get(..self.n_now).unwrap_or_default()
    }

    /// Forgets the contacts of the last step: after a member was put elsewhere.
    pub fn forget(&mut self) {
        self.statics.fill(0.0);
        (self.n_now, self.stored, self.step) = (0, 0.0, 0);
        self.stamps.fill(0);
        self.fresh.fill(0);
    }

    /// One step of all members, under the loads on them, gravity, and the forces of the contacts. What was
    /// pushed acts for this step: the loads of all members are empty after it.
    ///
    /// # Errors
    /// [`WorldError`]; the loads of the members are empty then, and what a member did before another one
    /// was refused is done.
    pub fn step(&mut self, members: &mut [Member<'_, '_, T>]) -> Result<WorldReport, WorldError> {
        let report = self.advance(members);
        if report.is_err() {
            for member in members {
                match member {
                    Member::Held(body, _) | Member::Free(body) => body.clear(),
                    Member::Rigid(shape) => shape.accept(*shape.motion()),
                }
            }
        }
        report
    }

    fn advance(&mut self, members: &mut [Member<'_, '_, T>]) -> Result<WorldReport, WorldError> {
        if members.len() != self.slots.len() {
            return Err(WorldError::Mismatch);
        }
        self.predict(members)?;
        core::mem::swap(&mut self.now, &mut self.before);
        let old = self.n_now;
        self.step = self.step.wrapping_add(1).max(1);
        let surfaces = Surfaces {
            slots: self.slots,
            order: self.order,
            boxes: self.boxes,
            moved: Cell::from_mut(&mut *self.moved).as_slice_of_cells(),
            fresh: Cell::from_mut(&mut *self.fresh).as_slice_of_cells(),
            extents: self.extents,
            normals: self.normals,
            ahead: &*self.ahead,
            statics: &*self.statics,
            positions: self.positions,
            stamps: self.stamps,
            visits: self.visits,
            step: self.step,
            visit: &mut self.visit,
            reach: self.reach,
        };
        let mut found = Found { touches: self.now, count: 0, left_out: 0 };
        find(surfaces, members, self.pairs, self.before.get(..old).unwrap_or_default(), &mut found);
        let left_out = found.left_out;
        self.n_now = found.count;
        self.set_up(members)?;
        let stored = self.stored;
        self.set_up_joints(members)?;
        let own = |world: &mut Self| world.system(|system, touches, spans| start(system, touches, spans));
        own(self);
        let (most, tolerance) = (self.options.sweeps, self.tolerance);
        let alone = self.joints.all.is_empty();
        let (sweeps, change) = self.close(members, |world| {
            // With joints, one sweep between two evaluations of them.
            let (mut sweeps, mut change) = (0, 0.0);
            while sweeps < if alone { most } else { 1 } && world.n_now > 0 {
                sweeps += 1;
                change = world.system(|system, touches, spans| sweep(system, touches, spans));
                if change <= tolerance || !alone {
                    break;
                }
            }
            (sweeps, change)
        })?;
        self.system(|system, touches, spans| show(system, touches, spans));
        let mut report = WorldReport {
            contacts: self.n_now,
            left_out,
            sweeps,
            converged: change <= self.tolerance,
            ..WorldReport::default()
        };
        self.show_residual();
        for touch in self.now.get(..self.n_now).unwrap_or_default() {
            if !touch.force.iter().chain(&touch.end).all(|x| x.in_range()) {
                self.n_now = 0;
                return Err(StepError::NotFinite.into());
            }
            report.pressed += usize::from(touch.force[0] > 0.0);
            report.worst_gap = report.worst_gap.max(-touch.end[0]);
            report.energy_given_away += touch.taken();
        }
        gather(
            self.slots,
            self.now.get(..self.n_now).unwrap_or_default(),
            self.joints.all,
            self.joints.states,
        );
        for slot in &*self.slots {
            let axes = slot.axes.map(|axis| dot(slot.middle.to_space(axis), slot.pushed[1]));
            let rigid = slot.pushed[0].into_iter().chain(axes);
            let p = self.p.get(slot.first + slot.r + slot.m..slot.first + slot.n).unwrap_or_default();
            let kick: f64 = rigid.zip(p).map(|(force, p)| force * force * p).sum();
            report.energy_given_away += kick * slot.eta / (1.0 + slot.eta);
        }
        self.commit(members)?;
        report.energy_given_away += stored - self.stored;
        Ok(report)
    }

    /// Displacements of the contacts by their forces in the residual flexibility.
    fn show_residual(&mut self) {
        for c in 0..self.n_now {
            let Some(touch) = self.now.get(c).copied() else { continue };
            let some =
                touch.members.map(|member| self.slots.get(member).map_or([0, 0], |slot| [slot.r, slot.m]));
            let held = self.system(|system, touches, spans| {
                let own = touches.get(c).map_or([[0, 0]; 2], spans);
                let further = system.by_some(c, &own, some);
                let blocks = system.blocks(c, touches);
                core::array::from_fn(|k| further[k] + blocks[k])
            });
            if let Some(touch) = self.now.get_mut(c) {
                touch.held = held;
            }
        }
    }

    /// Runs a part of the solution on the contacts.
    fn system<R>(
        &mut self,
        run: impl FnOnce(&mut System<'_>, &mut [Touch], &dyn Fn(&Touch) -> [[usize; 2]; 2]) -> R,
    ) -> R {
        let touches = self.now.get_mut(..self.n_now).unwrap_or_default();
        let most = self.options.near;
        let mut system =
            System { x: self.x, p: self.p, rows: self.rows, stride: self.stride, near: self.near, most };
        let slots = &*self.slots;
        let spans = |touch: &Touch| {
            touch.members.map(|member| slots.get(member).map_or([0, 0], |slot| [slot.first, slot.n]))
        };
        run(&mut system, touches, &spans)
    }

    /// Motion of all members to the end of the step, without contacts.
    fn predict(&mut self, members: &mut [Member<'_, '_, T>]) -> Result<(), WorldError> {
        let (time, gravity) = (self.time_step, self.options.gravity);
        self.x.fill(0.0);
        self.p.fill(0.0);
        for (i, (slot, member)) in self.slots.iter_mut().zip(members).enumerate() {
            let known = slot.r == member.elastic().map_or(0, |body| body.scene.n_modes());
            if !known || slot.is_rigid != member.rigid().is_some() {
                return Err(WorldError::Mismatch);
            }
            let answers =
                self.p.get_mut(slot.first..).and_then(|all| all.get_mut(..slot.n)).unwrap_or_default();
            let (motions, centre);
            match member {
                Member::Held(_, pose) => {
                    let reason = "its pose is not finite";
                    let motion = motion_of(pose).ok_or(WorldError::Member { member: i, reason })?;
                    (motions, centre) = ([motion; 3], [0.0; 3]);
                }
                Member::Free(body) => {
                    let (scene, loads) = (&body.scene, &mut body.loads);
                    let flight = body.flight.as_mut().ok_or(WorldError::Mismatch)?;
                    flight.follow(scene);
                    let mass = flight.body().mass;
                    flight.pull(gravity.map(|g| mass * g));
                    let ahead = flight.ahead(scene);
                    let spin = flight.motion().spin(flight.body());
                    loads.add_spin(scene, spin, ahead.spin(flight.body()))?;
                    motions = [*flight.motion(), flight.middle(scene), ahead];
                    centre = flight.body().centre;
                }
                Member::Rigid(shape) => {
                    if let Some(mass) = shape.body().map(|body| body.mass) {
                        shape.pull(gravity.map(|g| mass * g), [0.0; 3]);
                    }
                    let [middle, end] = shape.ahead(time);
                    (motions, centre) = ([*shape.motion(), middle, end], shape.centre());
                }
            }
            // A host moves a held body from where the last step left it.
            let last = slot.end;
            [slot.start, slot.middle, slot.end] = motions.map(|motion| Frame::new(&motion, centre));
            if self.step > 0 && matches!(member, Member::Held(..)) {
                slot.start = last;
            }
            if let Some(body) = member.elastic() {
                let ahead = self.ahead.get_mut(slot.ahead..).and_then(|all| all.get_mut(..slot.r));
                let ahead = ahead.ok_or(WorldError::Mismatch)?;
                if body.state.time_step() != time {
                    return Err(StepError::NotCarried.into());
                }
                body.scene.check_fresh(&body.loads)?;
                body.scene.coordinates_ahead(&body.state, &body.loads, ahead)?;
                let work = self.work.get_mut(..slot.r).ok_or(WorldError::Mismatch)?;
                body.scene.held_answers(work)?;
                answers.iter_mut().zip(&*work).for_each(|(answer, value)| *answer = value.to_f64());
                slot.keep = if body.scene.shape.is_filtered() { body.scene.filter.keep } else { 0.0 };
                let further = (1.0 - slot.keep) / body.scene.parameters.stiffness;
                answers.iter_mut().skip(slot.r).take(slot.m).for_each(|answer| *answer = further);
            }
            if let Some(body) = member.rigid() {
                let half = 0.5 * time * time;
                let [x, y, z] = body.moments.map(|moment| half / moment);
                let rigid = [half / body.mass, half / body.mass, half / body.mass, x, y, z];
                answers
                    .iter_mut()
                    .skip(slot.r + slot.m)
                    .zip(rigid)
                    .for_each(|(answer, value)| *answer = value);
                slot.axes = body.axes;
            }
            slot.eta = 0.0;
        }
        Ok(())
    }

    /// Gaps, slips and rows of the contacts.
    fn set_up(&mut self, members: &[Member<'_, '_, T>]) -> Result<(), WorldError> {
        let touches = self.now.get_mut(..self.n_now).unwrap_or_default();
        for (c, touch) in touches.iter_mut().enumerate() {
            let (mut at_start, mut at_end) = ([0.0; 3], [0.0; 3]);
            let mut own = [[0.0; 3]; 3];
            let (mut shown, mut keep) = ([[0.0; 3]; 2], [0.0; 2]);
            for side in 0..2 {
                let member = members.get(touch.members[side]).ok_or(WorldError::Mismatch)?;
                let slot = self.slots.get_mut(touch.members[side]).ok_or(WorldError::Mismatch)?;
                let place = touch.places[side];
                let sign = if side == 0 { 1.0 } else { -1.0 };
                let outline = member.outline().ok_or(WorldError::Mismatch)?;
                let rest = rest_of(&outline, &place);
                touch.rest[side] = rest;
                let start = (2 * c + side) * 3 * self.stride;
                let rows = self.rows.get_mut(start..start + 3 * slot.n).ok_or(WorldError::Mismatch)?;
                let (mut before, mut ahead) = ([0.0; 3], [0.0; 3]);
                rows.fill(0.0);
                if let Some(body) = member.elastic() {
                    let basis = self.work.get_mut(..3 * slot.r).ok_or(WorldError::Mismatch)?;
                    body.scene.project(&[place], basis)?;
                    let q = self.ahead.get(slot.ahead..).unwrap_or_default();
                    for (k, basis) in basis.chunks_exact(slot.r.max(1)).enumerate() {
                        let times = |x: &[T]| basis.iter().zip(x).map(|(b, x)| b.to_f64() * x.to_f64()).sum();
                        before[k] = times(body.state.zeta());
                        ahead[k] = times(q);
                    }
                    for (row, axis) in rows.chunks_exact_mut(slot.n.max(1)).zip(touch.axes) {
                        let axis = slot.middle.to_body(axis).map(|x| sign * x);
                        for (k, basis) in basis.chunks_exact(slot.r.max(1)).enumerate() {
                            row.iter_mut()
                                .zip(basis)
                                .for_each(|(row, basis)| *row += axis[k] * basis.to_f64());
                        }
                    }
                    let own_block = match &body.patch {
                        Some(patch) => {
                            let further = self.further.get_mut(..3 * slot.m).ok_or(WorldError::Mismatch)?;
                            patch::rows(patch, &place, further);
                            let z = self.statics.get(slot.statics..).unwrap_or_default();
                            let along = rows.chunks_exact_mut(slot.n.max(1)).zip(touch.axes);
                            for (row, axis) in along {
                                let axis = slot.middle.to_body(axis).map(|x| sign * x);
                                for (k, further) in further.chunks_exact(slot.m.max(1)).enumerate() {
                                    let row = row.iter_mut().skip(slot.r).zip(further);
                                    row.for_each(|(row, further)| *row += axis[k] * further);
                                }
                            }
                            let mut by = [0.0; 3];
                            for (by, further) in by.iter_mut().zip(further.chunks_exact(slot.m.max(1))) {
                                *by =
                                    sign * further.iter().zip(z).map(|(further, z)| further * z).sum::<f64>();
                            }
                            shown[side] = slot.middle.to_space(by);
                            let index = self.indices.get(slot.index..).unwrap_or_default();
                            patch::between(body, (patch, index), [&place, &place])
                        }
                        None => body.scene.residual_at(&place),
                    };
                    let block = turned(slot.middle.turn, own_block);
                    // With the sign of the force on the node, both sides open the gap.
                    shown[side] = add(shown[side], 1.0, block.map(|row| dot(row, touch.filtered[side])));
                    let held = 1.0 - slot.keep;
                    own.as_flattened_mut()
                        .iter_mut()
                        .zip(block.as_flattened())
                        .for_each(|(own, x)| *own += held * x);
                    touch.blocks[side] = block;
                    keep[side] = slot.keep;
                }
                at_start = add(at_start, sign, slot.start.place(add(rest, 1.0, before)));
                let moved = add(rest, 1.0, ahead);
                at_end = add(at_end, sign, slot.end.place(moved));
                let arm = slot.middle.to_space(minus(add(rest, 1.0, before), slot.middle.centre));
                touch.arms[side] = arm;
                if slot.is_rigid {
                    for (row, axis) in rows.chunks_exact_mut(slot.n.max(1)).zip(touch.axes) {
                        let about = slot.axes.map(|own| dot(axis, cross(slot.middle.to_space(own), arm)));
                        let rigid = axis.into_iter().chain(about).map(|x| sign * x);
                        row.iter_mut().skip(slot.r + slot.m).zip(rigid).for_each(|(row, x)| *row = x);
                    }
                    let (n, span) = (touch.axes[0], slot.first + slot.r + slot.m..slot.first + slot.n);
                    let p = self.p.get(span).unwrap_or_default();
                    let row = rows.get(slot.r + slot.m..slot.n).unwrap_or_default();
                    let rigid: f64 = row.iter().zip(p).map(|(row, p)| 2.0 * row * row * p).sum();
                    let further =
                        self.p.get(slot.first + slot.r..slot.first + slot.r + slot.m).unwrap_or_default();
                    let further =
                        rows.iter().skip(slot.r).zip(further).map(|(row, p)| row * row * p).sum::<f64>();
                    let soft = further + dot(n, touch.blocks[side].map(|row| dot(row, n)));
                    let share = if soft > 0.0 { rigid / (rigid + soft) } else { 1.0 };
                    let eta = (1.0 - touch.restitution) / (1.0 + touch.restitution);
                    slot.eta = slot.eta.max(eta * share);
                }
            }
            let [normal, first, second] = touch.axes;
            let slip = minus(at_end, at_start);
            touch.start = dot(normal, at_start);
            touch.free = [dot(normal, at_end), dot(first, slip), dot(second, slip)];
            touch.keep = 0.5 * (keep[0] + keep[1]);
            for side in 0..2 {
                touch.show(shown[side], keep[side]);
            }
            touch.own = turned(touch.axes, own);
            let force = touch.force;
            touch.force = touch.axes.map(|axis| dot(axis, force));
        }
        if !self.near.is_empty() {
            let near = (&mut *self.near, self.options.near);
            patch::blocks(members, self.slots, touches, near, self.indices);
        }
        for touch in &mut *touches {
            touch.target = ((1.0 - self.options.recover) * touch.start).min(0.0);
        }
        for slot in &*self.slots {
            let rigid = self.p.get_mut(slot.first + slot.r + slot.m..slot.first + slot.n).unwrap_or_default();
            rigid.iter_mut().for_each(|p| *p *= 1.0 + slot.eta);
        }
        for (c, touch) in touches.iter_mut().enumerate() {
            touch.all = touch.own;
            for (side, member) in touch.members.into_iter().enumerate() {
                let slot = self.slots.get(member).ok_or(WorldError::Mismatch)?;
                let start = (2 * c + side) * 3 * self.stride;
                let rows = self.rows.get(start..start + 3 * slot.n).unwrap_or_default();
                let p = self.p.get(slot.first..slot.first + slot.n).unwrap_or_default();
                let more = answers(rows, p);
                touch
                    .all
                    .as_flattened_mut()
                    .iter_mut()
                    .zip(more.as_flattened())
                    .for_each(|(all, x)| *all += x);
            }
        }
        Ok(())
    }

    /// Steps the members under the forces of the contacts.
    fn commit(&mut self, members: &mut [Member<'_, '_, T>]) -> Result<(), WorldError> {
        let time = self.time_step;
        let touches = self.now.get_mut(..self.n_now).unwrap_or_default();
        for touch in &mut *touches {
            let force = touch.force();
            let keeps = touch.members.map(|member| self.slots.get(member).map_or(0.0, |slot| slot.keep));
            for (side, keep) in keeps.into_iter().enumerate() {
                let old = touch.filtered[side];
                touch.filtered[side] = core::array::from_fn(|k| keep * old[k] + (1.0 - keep) * force[k]);
            }
            touch.residual = core::array::from_fn(|k| {
                (0..2).map(|side| dot(touch.blocks[side][k], touch.filtered[side])).sum()
            });
        }
        self.stored = touches.iter().map(Touch::stored).sum();
        for slot in &*self.slots {
            let x = self.x.get(slot.first + slot.r..).unwrap_or_default();
            let z = self.statics.get_mut(slot.statics..slot.statics + slot.m).unwrap_or_default();
            z.iter_mut().zip(x).for_each(|(z, x)| *z = slot.keep * *z + x);
        }
        for (i, (slot, member)) in self.slots.iter().zip(members).enumerate() {
            if let Member::Held(body, _) | Member::Free(body) = member {
                for touch in touches.iter().filter(|touch| touch.force[0] > 0.0) {
                    for side in (0..2).filter(|&side| touch.members[side] == i) {
                        let force = touch.force().map(|x| if side == 0 { x } else { -x });
                        let contact = Contact::new(touch.places[side], slot.middle.to_body(force));
                        body.loads.add_contact(&body.scene, &contact)?;
                    }
                }
                let work = self.work.get_mut(..slot.r).ok_or(WorldError::Mismatch)?;
                work.fill(T::ZERO);
                for (j, (joint, state)) in self.joints.all.iter().zip(&*self.joints.states).enumerate() {
                    for side in (0..2).filter(|&side| joint.members[side] == i) {
                        // At a place the residual flexibility shows the force, where there is room for it.
                        if let Anchor::Place(place) = joint.anchors[side] {
                            let [force, _] = state.wrench(side);
                            let contact = Contact::new(place, slot.middle.to_body(force));
                            match body.loads.add_contact(&body.scene, &contact) {
                                Err(LoadError::TooManyContacts { .. }) => {}
                                added => {
                                    added?;
                                    continue;
                                }
                            }
                        }
                        for (row, &force) in state.force.iter().enumerate().take(state.rows) {
                            let start = ((2 * j + side) * ROWS + row) * self.stride;
                            let own = self.joints.rows.get(start..start + slot.r).unwrap_or_default();
                            let each = work.iter_mut().zip(own);
                            each.for_each(|(sum, own)| *sum += T::from_f64(force * own));
                        }
                    }
                }
                if work.iter().any(|&force| force != T::ZERO) {
                    body.loads.add_coordinates(&body.scene, work)?;
                }
            }
            let pushed = slot.pushed;
            match member {
                Member::Held(body, _) => {
                    body.scene.step(&mut body.state, &body.loads)?;
                    body.loads.clear();
                }
                Member::Free(body) => {
                    let flight = body.flight.as_mut().ok_or(WorldError::Mismatch)?;
                    let motion =
                        kicked(*flight.motion(), flight.body(), time, slot.eta, pushed, flight.pushes());
                    flight.accept(&body.scene, &mut body.state, &mut body.loads, motion)?;
                }
                Member::Rigid(shape) => {
                    let motion = shape.kicked(time, slot.eta, pushed);
                    if !motion.is_finite() {
                        return Err(StepError::NotFinite.into());
                    }
                    shape.accept(motion);
                }
            }
        }
        Ok(())
    }

    /// Kinetic and elastic energy of all members and of the residual flexibility under the contacts \[J\].
    ///
    /// # Errors
    /// [`WorldError::Mismatch`].
    pub fn energy(&self, members: &[Member<'_, '_, T>]) -> Result<f64, WorldError> {
        let mut sum = 0.0;
        for member in members {
            if let Some(body) = member.elastic() {
                let modes = body.scene.energy_of_modes(&body.state);
                sum += modes.map_err(|_| WorldError::Mismatch)?.total();
            }
            sum += match member {
                Member::Free(body) => body.flight.map_or(0.0, |flight| flight.motion().energy(flight.body())),
                Member::Rigid(shape) => shape.body().map_or(0.0, |body| shape.motion().energy(body)),
                Member::Held(..) => 0.0,
            };
        }
        Ok(sum + self.stored + self.stored_in_joints(members))
    }
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
        let shared = first_shared(joints, i, &moves);
        let before = states.get(shared).map_or(row, |state| if shared == i { row } else { state.first_row });
        let Some((state, joint)) = states.get_mut(i).zip(joints.get(i)) else { continue };
        let rows = crate::world::joint::rows_of(joint.kind);
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
    slots: &[Slot],
) -> Option<()> {
    let [a, b] = joint.members;
    let length = if let JointKind::Cable { length } = joint.kind { length } else { 0.0 };
    let sound = a != b
        && joint.compliance.in_range()
        && joint.compliance >= 0.0
        && length.in_range()
        && length >= 0.0;
    sound.then_some(())?;
    let mut frames = [Frame::default(); 2];
    for side in 0..2 {
        let member = members.get(joint.members[side])?;
        slots.get(joint.members[side])?;
        let (rest, axes) = at_rest(member, &joint.anchors[side], joint.kind)?;
        (state.rest[side], state.axes[side]) = (rest, axes);
        frames[side] = member.frame()?;
    }
    state.align([&frames[0], &frames[1]]);
    Some(())
}

/// A place at rest \[m\].
fn rest_of(outline: &Outline<'_>, place: &Place) -> [f64; 3] {
    let nodes = place.entries().map(|(node, weight)| (outline.node(node).unwrap_or_default(), weight));
    nodes.fold([0.0; 3], |sum, (node, weight)| add(sum, weight, node))
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

fn check_options(options: &WorldOptions) -> Result<(), WorldError> {
    let lengths = options.reach.into_iter().chain(options.tolerance);
    let sound = lengths.chain([options.recover]).all(|x| x.in_range() && x >= 0.0);
    let gravity = options.gravity.iter().all(|x| x.in_range());
    if sound && gravity && options.recover <= 1.0 { Ok(()) } else { Err(WorldError::Option) }
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
