//! Motion of the members: to the end of a step without contacts, and the step itself.

use crate::base::error::{LoadError, StepError};
use crate::base::scalar::Scalar;
use crate::base::vec3::dot;
use crate::sections::contact::Contact;
use crate::world::error::WorldError;
use crate::world::frame::{Frame, motion_of};
use crate::world::joint::{Anchor, ROWS};
use crate::world::member::{Member, kicked};
use crate::world::touch::Touch;
use crate::world::world::World;

impl<T: Scalar> World<'_, T> {
    /// Motion of all members to the end of the step, without contacts.
    pub(crate) fn predict(&mut self, members: &mut [Member<'_, '_, T>]) -> Result<(), WorldError> {
        let (time, gravity) = (self.time_step, self.options.gravity);
        self.room.x.fill(0.0);
        self.room.p.fill(0.0);
        for (i, (slot, member)) in self.slots.iter_mut().zip(members).enumerate() {
            let known = slot.r == member.elastic().map_or(0, |body| body.scene.n_modes());
            if !known || slot.is_rigid != member.rigid().is_some() {
                return Err(WorldError::Mismatch);
            }
            let answers =
                self.room.p.get_mut(slot.first..).and_then(|all| all.get_mut(..slot.n)).unwrap_or_default();
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
                let ahead = self.room.ahead.get_mut(slot.ahead..).and_then(|all| all.get_mut(..slot.r));
                let ahead = ahead.ok_or(WorldError::Mismatch)?;
                if body.state.time_step() != time {
                    return Err(StepError::NotCarried.into());
                }
                body.scene.check_fresh(&body.loads)?;
                body.scene.coordinates_ahead(&body.state, &body.loads, ahead)?;
                let work = self.room.work.get_mut(..slot.r).ok_or(WorldError::Mismatch)?;
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

    /// Steps the members under the forces of the contacts.
    pub(crate) fn commit(&mut self, members: &mut [Member<'_, '_, T>]) -> Result<(), WorldError> {
        let time = self.time_step;
        let touches = self.now.get_mut(..self.n_now).unwrap_or_default();
        for touch in &mut *touches {
            touch.slid = touch.slip();
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
        for touch in &mut *touches {
            for (filtered, member) in touch.filtered.iter_mut().zip(touch.members) {
                if let Some(slot) = self.slots.get(member) {
                    *filtered = slot.middle.to_body(*filtered);
                }
            }
        }
        for slot in &*self.slots {
            let x = self.room.x.get(slot.first + slot.r..).unwrap_or_default();
            let z = self.room.statics.get_mut(slot.statics..slot.statics + slot.m).unwrap_or_default();
            z.iter_mut().zip(x).for_each(|(z, x)| *z = slot.keep * *z + x);
        }
        for touch in touches.iter().filter(|touch| touch.force[0] > 0.0) {
            for side in 0..2 {
                let member = touch.members[side];
                let (Some(slot), Some(Member::Held(body, _) | Member::Free(body))) =
                    (self.slots.get(member), members.get_mut(member))
                else {
                    continue;
                };
                let force = touch.force().map(|x| if side == 0 { x } else { -x });
                let contact = Contact::new(touch.places[side], slot.middle.to_body(force));
                body.loads.add_contact(&body.scene, &contact)?;
            }
        }
        for (i, (slot, member)) in self.slots.iter().zip(members).enumerate() {
            if let Member::Held(body, _) | Member::Free(body) = member {
                let work = self.room.work.get_mut(..slot.r).ok_or(WorldError::Mismatch)?;
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
                            let start = ((2 * j + side) * ROWS + row) * self.room.stride;
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
}
