//! Closing the joints of a world at the end of a step.

use crate::base::scalar::Scalar;
use crate::base::vec3::{add, cross, dot};
use crate::body::body::Body;
use crate::world::error::WorldError;
use crate::world::frame::Frame;
use crate::world::joint::{self, JointKind, JointState, Moved, ROWS, WorldJoint, residual};
use crate::world::joints::{Joints, gather};
use crate::world::member::{Member, kicked};
use crate::world::slot::Slot;
use crate::world::world::World;

/// Displacement and rotation of an anchor by the modes, from its rows and the coordinates.
fn by_modes(basis: &[f64], r: usize, q: impl Fn(usize) -> f64) -> Moved {
    let mut all = [0.0; ROWS];
    for (sum, row) in all.iter_mut().zip(basis.chunks_exact(r.max(1))) {
        *sum = row.iter().enumerate().map(|(k, b)| b * q(k)).sum();
    }
    let [a, b, c, d, e, f] = all;
    Moved { by: [a, b, c], turned: [d, e, f] }
}

impl<T: Scalar> World<'_, T> {
    /// Rows of the joints halfway through the step, with the forces of the last step on them.
    pub(crate) fn set_up_joints(&mut self, members: &[Member<'_, '_, T>]) -> Result<(), WorldError> {
        let stride = self.room.stride;
        for (j, joint) in self.joints.all.iter().enumerate() {
            let mut moved = [Moved::default(); 2];
            for side in 0..2 {
                let (Some(member), Some(slot)) =
                    (members.get(joint.members[side]), self.slots.get(joint.members[side]))
                else {
                    return Err(WorldError::Mismatch);
                };
                if let Some(body) = member.elastic() {
                    let size = ROWS * self.joints.largest;
                    let start = (2 * j + side) * size;
                    let out = self
                        .joints
                        .basis
                        .get_mut(start..start + ROWS * slot.r)
                        .ok_or(WorldError::Mismatch)?;
                    joint::basis(body, &joint.anchors[side], self.room.work, out)?;
                    // Arms as the last step left the body: without the forces of the joints it would be
                    // elsewhere at the end of this one.
                    let zeta = body.state.zeta();
                    let q = |k: usize| zeta.get(k).map_or(0.0, |x| x.to_f64());
                    moved[side] = by_modes(self.joints.basis(j, side), slot.r, q);
                }
            }
            let [Some(a), Some(b)] = joint.members.map(|member| self.slots.get(member)) else {
                return Err(WorldError::Mismatch);
            };
            for (side, slot) in [a, b].into_iter().enumerate() {
                if let Some(body) = members.get(joint.members[side]).and_then(Member::elastic) {
                    let more = self.by_residual(body, slot, joint, side);
                    moved[side].by = add(moved[side].by, 1.0, more.by);
                    moved[side].turned = add(moved[side].turned, 1.0, more.turned);
                }
            }
            let [Some(a), Some(b)] = joint.members.map(|member| self.slots.get(member)) else {
                return Err(WorldError::Mismatch);
            };
            let Some(state) = self.joints.states.get_mut(j) else { return Err(WorldError::Mismatch) };
            state.start = state.gaps(joint.kind, [&a.start, &b.start], moved);
            state.direct(joint.kind, [&a.middle, &b.middle], moved);
            if state.broken {
                state.force = [0.0; ROWS];
            }
            for (side, slot) in [a, b].into_iter().enumerate() {
                for row in 0..state.rows {
                    let start = ((2 * j + side) * ROWS + row) * stride;
                    let out = self.joints.rows.get_mut(start..start + stride).ok_or(WorldError::Mismatch)?;
                    out.fill(0.0);
                    let (along, about) = (state.along[side][row], state.about[side][row]);
                    let own = [slot.middle.to_body(along), slot.middle.to_body(about)];
                    let size = ROWS * self.joints.largest;
                    let basis = self.joints.basis.get((2 * j + side) * size..).unwrap_or_default();
                    for (k, basis) in
                        basis.chunks_exact(slot.r.max(1)).take(if slot.r > 0 { ROWS } else { 0 }).enumerate()
                    {
                        let weight = own[k / 3][k % 3];
                        out.iter_mut().zip(basis).for_each(|(out, basis)| *out += weight * basis);
                    }
                    if slot.is_rigid {
                        let moment = add(about, 1.0, cross(state.arms[side], along));
                        let turning = slot.axes.map(|axis| dot(slot.middle.to_space(axis), moment));
                        let rigid = along.into_iter().chain(turning);
                        out.iter_mut().skip(slot.r + slot.m).zip(rigid).for_each(|(out, x)| *out = x);
                    }
                }
            }
        }
        Ok(())
    }

    /// Motion of an anchor of a member by what its modes leave out, under all joints of the member.
    fn by_residual(&self, body: &Body<'_, T>, slot: &Slot, joint: &WorldJoint, side: usize) -> Moved {
        let mut sum = Moved::default();
        for (other, state) in self.joints.all.iter().zip(&*self.joints.states) {
            for t in (0..2).filter(|&t| other.members[t] == joint.members[side]) {
                let [force, moment] = state.wrench(t).map(|x| slot.middle.to_body(x));
                let more = residual(body, [&joint.anchors[side], &other.anchors[t]], force, moment);
                sum.by = add(sum.by, 1.0, more.by);
                sum.turned = add(sum.turned, 1.0, more.turned);
            }
        }
        sum
    }

    /// Matrix of all rows, factorised. Cables that are slack, and joints that broke, have rows of a unit
    /// matrix.
    fn factorise(&mut self, members: &[Member<'_, '_, T>]) -> Result<(), WorldError> {
        let mut row = 0_usize;
        for (i, own) in self.joints.all.iter().enumerate() {
            let Some(state) = self.joints.states.get(i).copied() else { return Err(WorldError::Mismatch) };
            for a in 0..state.rows {
                let offset = self.joints.offsets.get(row).copied().unwrap_or(0) as usize;
                let mut column = 0_usize;
                for (k, other) in self.joints.all.iter().enumerate().take(i + 1).skip(state.first_shared) {
                    let Some(with) = self.joints.states.get(k).copied() else {
                        return Err(WorldError::Mismatch);
                    };
                    let columns = if k == i { a + 1 } else { with.rows };
                    for b in 0..columns {
                        let diagonal = k == i && a == b;
                        let mut sum = if diagonal { 2.0 * own.compliance } else { 0.0 };
                        if !state.holds() || !with.holds() {
                            sum = if diagonal { 1.0 } else { 0.0 };
                        } else {
                            for (s, t) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                                if own.members[s] == other.members[t] {
                                    sum += self.shared(members, [(i, s, a), (k, t, b)], [&state, &with]);
                                }
                            }
                        }
                        if let Some(place) = self.joints.matrix.get_mut(offset + column) {
                            *place = sum;
                        }
                        column += 1;
                    }
                }
                row += 1;
            }
        }
        let Joints { matrix, starts, offsets, .. } = &mut self.joints;
        joint::factorise(matrix, starts, offsets).map_err(|row| {
            let mut rows = self.joints.all.iter().map(|joint| joint::rows_of(joint.kind));
            let mut left = row;
            let joint = rows.position(|rows| {
                let own = left < rows;
                left = left.saturating_sub(rows);
                own
            });
            WorldError::Redundant { joint: joint.unwrap_or(0) }
        })
    }

    /// A number of the matrix by one member that two rows share.
    fn shared(
        &self,
        members: &[Member<'_, '_, T>],
        [(i, s, a), (k, t, b)]: [(usize, usize, usize); 2],
        [own, other]: [&JointState; 2],
    ) -> f64 {
        let Some(joint) = self.joints.all.get(i) else { return 0.0 };
        let Some(with) = self.joints.all.get(k) else { return 0.0 };
        let member = joint.members[s];
        let (Some(slot), Some(member)) = (self.slots.get(member), members.get(member)) else { return 0.0 };
        let p = self.room.p.get(slot.first..slot.first + slot.n).unwrap_or_default();
        let rows =
            self.joints.row(i, s, a, self.room.stride).iter().zip(self.joints.row(k, t, b, self.room.stride));
        let mut sum: f64 = rows.zip(p).map(|((a, b), p)| a * b * p).sum();
        if let Some(body) = member.elastic() {
            let frame = &slot.middle;
            let force = [other.along[t][b], other.about[t][b]].map(|x| frame.to_body(x));
            let answer = residual(body, [&joint.anchors[s], &with.anchors[t]], force[0], force[1]);
            sum += dot(frame.to_body(own.along[s][a]), answer.by)
                + dot(frame.to_body(own.about[s][a]), answer.turned);
        }
        sum
    }

    /// Forces that close the joints at the end of the step, together with those of the contacts.
    pub(crate) fn close(
        &mut self,
        members: &[Member<'_, '_, T>],
        mut contacts: impl FnMut(&mut Self) -> (usize, f64),
    ) -> Result<(usize, f64), WorldError> {
        if self.joints.all.is_empty() {
            return Ok(contacts(self));
        }
        self.push_joints(|state| state.force);
        let (mut sweeps, mut change) = (0, 0.0);
        let most = if self.n_now == 0 { 12 } else { self.options.sweeps };
        for turn in 0..most {
            let (swept, changed) = contacts(self);
            sweeps += swept.max(1);
            let worst = self.gaps(members)?;
            change = worst.max(changed);
            if change <= self.tolerance {
                break;
            }
            // Cables that tighten or slacken change the matrix.
            let mut changed = turn == 0;
            for (state, joint) in self.joints.states.iter_mut().zip(self.joints.all) {
                if let JointKind::Cable { .. } = joint.kind {
                    let gap = self.joints.gaps.get(state.first_row).copied().unwrap_or(0.0);
                    let slack = gap > 0.0 && state.force[0] <= 0.0;
                    changed |= slack != state.slack;
                    state.slack = slack;
                }
            }
            if changed {
                self.factorise(members)?;
            }
            let Joints { matrix, starts, offsets, gaps, .. } = &mut self.joints;
            joint::solve(matrix, starts, offsets, gaps);
            for (state, joint) in self.joints.states.iter_mut().zip(self.joints.all) {
                let before = state.force;
                if state.holds() {
                    let more = self.joints.gaps.get(state.first_row..).unwrap_or_default();
                    state
                        .force
                        .iter_mut()
                        .zip(more)
                        .take(state.rows)
                        .for_each(|(force, more)| *force -= more);
                    if let JointKind::Cable { .. } = joint.kind {
                        state.force[0] = state.force[0].max(0.0);
                    }
                }
                state.change = core::array::from_fn(|k| state.force[k] - before[k]);
            }
            self.push_joints(|state| state.change);
        }
        Ok((sweeps, change))
    }

    /// Adds the answers to forces of the joints to the coordinates.
    fn push_joints(&mut self, force: impl Fn(&JointState) -> [f64; ROWS]) {
        for (j, (joint, state)) in self.joints.all.iter().zip(&*self.joints.states).enumerate() {
            let force = force(state);
            for (side, &member) in joint.members.iter().enumerate() {
                let Some(slot) = self.slots.get(member) else { continue };
                for (row, force) in
                    force.into_iter().enumerate().take(state.rows).filter(|&(_, force)| force != 0.0)
                {
                    let p = self.room.p.get(slot.first..slot.first + slot.n).unwrap_or_default();
                    let x = self.room.x.get_mut(slot.first..slot.first + slot.n).unwrap_or_default();
                    let start = ((2 * j + side) * ROWS + row) * self.room.stride;
                    let own = self.joints.rows.get(start..start + slot.n).unwrap_or_default();
                    x.iter_mut().zip(p).zip(own).for_each(|((x, p), own)| *x += p * own * force);
                }
            }
        }
    }

    /// Gaps of the joints as they are at the end of the step under the present forces, and the largest that
    /// is not allowed.
    fn gaps(&mut self, members: &[Member<'_, '_, T>]) -> Result<f64, WorldError> {
        gather(
            self.slots,
            self.now.get(..self.n_now).unwrap_or_default(),
            self.joints.all,
            self.joints.states,
        );
        let mut worst = 0.0_f64;
        for (j, joint) in self.joints.all.iter().enumerate() {
            let (mut moved, mut frames) = ([Moved::default(); 2], [Frame::default(); 2]);
            for side in 0..2 {
                let (Some(member), Some(slot)) =
                    (members.get(joint.members[side]), self.slots.get(joint.members[side]))
                else {
                    return Err(WorldError::Mismatch);
                };
                frames[side] = end_of(member, slot, self.time_step);
                let Some(body) = member.elastic() else { continue };
                let ahead = self.room.ahead.get(slot.ahead..).unwrap_or_default();
                let x = self.room.x.get(slot.first..).unwrap_or_default();
                let q =
                    |k: usize| ahead.get(k).map_or(0.0, |q| q.to_f64()) + x.get(k).copied().unwrap_or(0.0);
                moved[side] = by_modes(self.joints.basis(j, side), slot.r, q);
                let more = self.by_residual(body, slot, joint, side);
                moved[side].by = add(moved[side].by, 1.0, more.by);
                moved[side].turned = add(moved[side].turned, 1.0, more.turned);
            }
            let Some(state) = self.joints.states.get_mut(j) else { return Err(WorldError::Mismatch) };
            let gaps = state.gaps(joint.kind, [&frames[0], &frames[1]], moved);
            state.end = gaps;
            for row in 0..state.rows {
                // A spring has its force in the mean over the step, which keeps its energy.
                let spring = if joint.compliance > 0.0 { state.start[row] } else { 0.0 };
                let mut gap = gaps[row] + spring + 2.0 * joint.compliance * state.force[row];
                let cable = matches!(joint.kind, JointKind::Cable { .. });
                let open = cable && gap > 0.0 && state.force[0] <= 0.0;
                if state.broken || open && state.slack {
                    gap = if open { gap } else { 0.0 };
                } else if !open {
                    // Of a rotation the displacement at the size of the smallest member.
                    let rotation = row >= 3 || matches!(joint.kind, JointKind::Slider) && row >= 2;
                    worst = worst.max(gap.abs() * if rotation { self.smallest } else { 1.0 });
                }
                if let Some(place) = self.joints.gaps.get_mut(state.first_row + row) {
                    *place = if state.broken { 0.0 } else { gap };
                }
            }
        }
        if worst.is_finite() { Ok(worst) } else { Err(crate::StepError::NotFinite.into()) }
    }
}

impl<T: Scalar> World<'_, T> {
    /// Energy of the forces of the joints in the residual flexibility of the members, and in their own \[J\].
    pub(crate) fn stored_in_joints(&self, members: &[Member<'_, '_, T>]) -> f64 {
        let mut sum = 0.0;
        for (joint, state) in self.joints.all.iter().zip(&*self.joints.states) {
            if joint.compliance > 0.0 && !state.broken {
                let cable = matches!(joint.kind, JointKind::Cable { .. });
                let stretched = |gap: &f64| if cable { gap.min(0.0) } else { *gap };
                let square = |x: f64| x * x;
                sum += state.end.iter().map(|gap| square(stretched(gap))).sum::<f64>() / joint.compliance;
            }
            for (side, &member) in joint.members.iter().enumerate() {
                let (Some(slot), Some(body)) =
                    (self.slots.get(member), members.get(member).and_then(Member::elastic))
                else {
                    continue;
                };
                let own = state.wrench(side).map(|x| slot.middle.to_body(x));
                for (other, with) in self.joints.all.iter().zip(&*self.joints.states) {
                    for t in (0..2).filter(|&t| other.members[t] == member) {
                        let [force, moment] = with.wrench(t).map(|x| slot.middle.to_body(x));
                        let by = residual(body, [&joint.anchors[side], &other.anchors[t]], force, moment);
                        sum += dot(own[0], by.by) + dot(own[1], by.turned);
                    }
                }
            }
        }
        0.5 * sum
    }
}

/// Placement of a member at the end of the step under what was gathered on it.
fn end_of<T: Scalar>(member: &Member<'_, '_, T>, slot: &Slot, time: f64) -> Frame {
    match member {
        Member::Held(..) => slot.end,
        Member::Free(body) => body.flight.map_or(slot.end, |flight| {
            let motion =
                kicked(*flight.motion(), flight.body(), time, slot.eta, slot.pushed, flight.pushes());
            Frame::new(&motion, slot.end.centre)
        }),
        Member::Rigid(shape) => Frame::new(&shape.kicked(time, slot.eta, slot.pushed), slot.end.centre),
    }
}
