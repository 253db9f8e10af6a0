//! Rows, gaps and slips of the contacts of a step.

use crate::base::scalar::Scalar;
use crate::base::vec3::{add, cross, dot, minus};
use crate::sections::place::Place;
use crate::world::error::WorldError;
use crate::world::frame::turned;
use crate::world::member::{Member, Outline};
use crate::world::patch;
use crate::world::rows::answers;
use crate::world::solve::System;
use crate::world::touch::Touch;
use crate::world::world::World;

/// Overlap that is left as it is, in sizes of the smallest member.
const ALLOWED: f64 = 1e-4;

impl<T: Scalar> World<'_, T> {
    /// Gaps, slips and rows of the contacts.
    pub(crate) fn set_up(&mut self, members: &[Member<'_, '_, T>]) -> Result<(), WorldError> {
        let touches = self.now.get_mut(..self.n_now).unwrap_or_default();
        for (c, touch) in touches.iter_mut().enumerate() {
            let (mut at_start, mut at_end) = ([0.0; 3], [0.0; 3]);
            let mut own = [[0.0; 3]; 3];
            let (mut shown, mut keep) = ([[0.0; 3]; 2], [0.0; 2]);
            for side in 0..2 {
                let member = members.get(touch.members[side]).ok_or(WorldError::Mismatch)?;
                let slot = self.slots.get_mut(touch.members[side]).ok_or(WorldError::Mismatch)?;
                let place = touch.places[side];
                touch.filtered[side] = slot.middle.to_space(touch.filtered[side]);
                let sign = if side == 0 { 1.0 } else { -1.0 };
                let outline = member.outline().ok_or(WorldError::Mismatch)?;
                let rest = rest_of(&outline, &place);
                touch.rest[side] = rest;
                let start = (2 * c + side) * 3 * self.room.stride;
                let rows = self.room.rows.get_mut(start..start + 3 * slot.n).ok_or(WorldError::Mismatch)?;
                let (mut before, mut ahead) = ([0.0; 3], [0.0; 3]);
                rows.fill(0.0);
                if let Some(body) = member.elastic() {
                    let basis = self.room.work.get_mut(..3 * slot.r).ok_or(WorldError::Mismatch)?;
                    body.scene.project(&[place], basis)?;
                    let q = self.room.ahead.get(slot.ahead..).unwrap_or_default();
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
                            let further =
                                self.room.further.get_mut(..3 * slot.m).ok_or(WorldError::Mismatch)?;
                            patch::rows(patch, &place, further);
                            let z = self.room.statics.get(slot.statics..).unwrap_or_default();
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
                            let index = self.room.indices.get(slot.index..).unwrap_or_default();
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
                // The residual flexibility turns with the body, which the moment of the force pays for.
                let arm = add(arm, sign, shown[side]);
                touch.arms[side] = arm;
                if slot.is_rigid {
                    for (row, axis) in rows.chunks_exact_mut(slot.n.max(1)).zip(touch.axes) {
                        let about = slot.axes.map(|own| dot(axis, cross(slot.middle.to_space(own), arm)));
                        let rigid = axis.into_iter().chain(about).map(|x| sign * x);
                        row.iter_mut().skip(slot.r + slot.m).zip(rigid).for_each(|(row, x)| *row = x);
                    }
                    let (n, span) = (touch.axes[0], slot.first + slot.r + slot.m..slot.first + slot.n);
                    let p = self.room.p.get(span).unwrap_or_default();
                    let row = rows.get(slot.r + slot.m..slot.n).unwrap_or_default();
                    let rigid: f64 = row.iter().zip(p).map(|(row, p)| 2.0 * row * row * p).sum();
                    let further = self
                        .room
                        .p
                        .get(slot.first + slot.r..slot.first + slot.r + slot.m)
                        .unwrap_or_default();
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
            patch::blocks(members, self.slots, touches, near, self.room.indices);
        }
        for touch in &mut *touches {
            let excess = (-touch.start - ALLOWED * self.smallest).max(0.0);
            touch.target = touch.start.min(0.0) + self.options.recover * excess;
        }
        for slot in &*self.slots {
            let rigid =
                self.room.p.get_mut(slot.first + slot.r + slot.m..slot.first + slot.n).unwrap_or_default();
            rigid.iter_mut().for_each(|p| *p *= 1.0 + slot.eta);
        }
        for (c, touch) in touches.iter_mut().enumerate() {
            touch.all = touch.own;
            for (side, member) in touch.members.into_iter().enumerate() {
                let slot = self.slots.get(member).ok_or(WorldError::Mismatch)?;
                let start = (2 * c + side) * 3 * self.room.stride;
                let rows = self.room.rows.get(start..start + 3 * slot.n).unwrap_or_default();
                let p = self.room.p.get(slot.first..slot.first + slot.n).unwrap_or_default();
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

    /// Displacements of the contacts by their forces in the residual flexibility.
    pub(crate) fn show_residual(&mut self) {
        for c in 0..self.n_now {
            let Some(members) = self.now.get(c).map(|touch| touch.members) else { continue };
            let some = members.map(|member| self.slots.get(member).map_or([0, 0], |slot| [slot.r, slot.m]));
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
    pub(crate) fn system<R>(
        &mut self,
        run: impl FnOnce(&mut System<'_>, &mut [Touch], &dyn Fn(&Touch) -> [[usize; 2]; 2]) -> R,
    ) -> R {
        let touches = self.now.get_mut(..self.n_now).unwrap_or_default();
        let most = self.options.near;
        let mut system = System {
            x: self.room.x,
            p: self.room.p,
            rows: self.room.rows,
            stride: self.room.stride,
            near: self.near,
            most,
        };
        let slots = &*self.slots;
        let spans = |touch: &Touch| {
            touch.members.map(|member| slots.get(member).map_or([0, 0], |slot| [slot.first, slot.n]))
        };
        run(&mut system, touches, &spans)
    }
}

/// A place at rest \[m\].
fn rest_of(outline: &Outline<'_>, place: &Place) -> [f64; 3] {
    let nodes = place.entries().map(|(node, weight)| (outline.node(node).unwrap_or_default(), weight));
    nodes.fold([0.0; 3], |sum, (node, weight)| add(sum, weight, node))
}
