//! The state of a world beside that of its members: contacts and joints, as numbers.

use crate::base::principal::UNITS;
use crate::base::scalar::Scalar;
use crate::world::error::WorldError;
use crate::world::joint::ROWS;
use crate::world::touch::Touch;
use crate::world::world::World;

/// Numbers of a contact: members, node, force, filtered forces, residual displacement, slip, nodes of the
/// triangle and weights.
const TOUCH: usize = 24;

/// Numbers of a member: where it was at the end of the last step, position and rotation.
const SLOT: usize = 12;

/// Numbers of a joint: forces, and 1 of a broken one.
const JOINT: usize = ROWS + 1;

impl<T: Scalar> World<'_, T> {
    /// Numbers that [`World::save_into`] writes.
    #[must_use]
    pub fn saved_len(&self) -> usize {
        let own = 2 + self.options.contacts * TOUCH + self.slots.len() * SLOT;
        own + self.joints.all.len() * JOINT + self.room.statics.len()
    }

    /// Writes contacts and joints as they are after the last step. With the states of the members
    /// ([`Body::save_into`](crate::Body::save_into), [`RigidShape::motion`](crate::RigidShape::motion)) a
    /// world goes on from there bit by bit.
    ///
    /// # Errors
    /// [`WorldError::LentMemory`] for memory of another length.
    pub fn save_into(&self, out: &mut [f64]) -> Result<(), WorldError> {
        let (found, needed) = (out.len(), self.saved_len());
        if found != needed {
            return Err(WorldError::LentMemory { found, needed });
        }
        out.fill(0.0);
        let touches = self.touches();
        let of_touch = |touch: &Touch| {
            let [a, b] = touch.members.map(|member| member as f64);
            let [first, second] = touch.filtered;
            let triangle = touch.triangle.map(f64::from);
            let numbers = [touch.force(), first, second, touch.residual, touch.slid, triangle, touch.weights];
            [a, b, f64::from(touch.node)].into_iter().chain(numbers.into_iter().flatten())
        };
        let (head, rest) = out.split_at_mut(2);
        head.iter_mut().zip([touches.len() as f64, self.stored]).for_each(|(out, number)| *out = number);
        let (of_touches, rest) = rest.split_at_mut(self.options.contacts * TOUCH);
        let numbers = touches.iter().flat_map(of_touch);
        of_touches.iter_mut().zip(numbers).for_each(|(out, number)| *out = number);
        let (of_slots, rest) = rest.split_at_mut(self.slots.len() * SLOT);
        let ends = self.slots.iter().map(|slot| &slot.end);
        let numbers = ends.flat_map(|end| end.position.into_iter().chain(end.turn.into_iter().flatten()));
        of_slots.iter_mut().zip(numbers).for_each(|(out, number)| *out = number);
        let (of_joints, rest) = rest.split_at_mut(self.joints.all.len() * JOINT);
        let states = self.joints.states.iter();
        let numbers =
            states.flat_map(|state| state.force.into_iter().chain([f64::from(u8::from(state.broken))]));
        of_joints.iter_mut().zip(numbers).for_each(|(out, number)| *out = number);
        rest.iter_mut().zip(&*self.room.statics).for_each(|(out, number)| *out = *number);
        Ok(())
    }

    /// Takes back what [`World::save_into`] of a world of the same members, joints and options wrote.
    ///
    /// # Errors
    /// [`WorldError::LentMemory`] for numbers of another length, [`WorldError::Mismatch`] for numbers that
    /// are none of this world; nothing changes then.
    pub fn restore(&mut self, saved: &[f64]) -> Result<(), WorldError> {
        let (found, needed) = (saved.len(), self.saved_len());
        if found != needed {
            return Err(WorldError::LentMemory { found, needed });
        }
        let (head, rest) = saved.split_at(2);
        let (of_touches, rest) = rest.split_at(self.options.contacts * TOUCH);
        let (of_slots, rest) = rest.split_at(self.slots.len() * SLOT);
        let (of_joints, of_statics) = rest.split_at(self.joints.all.len() * JOINT);
        let whole = |number: f64, below: usize| {
            (number >= 0.0 && number < below as f64 && libm::floor(number) == number)
                .then_some(number as usize)
        };
        let [count, stored] = *head else { return Err(WorldError::Mismatch) };
        let count = whole(count, self.options.contacts + 1).ok_or(WorldError::Mismatch)?;
        let used = of_touches.as_chunks::<TOUCH>().0.get(..count).unwrap_or_default();
        let members = self.slots.len();
        let sound = |touch: &[f64; TOUCH]| {
            let [a, b, node, ..] = *touch;
            let node = whole(node, u32::MAX as usize);
            whole(a, members).is_some() && whole(b, members).is_some() && node.is_some()
        };
        if !saved.iter().all(|x| x.in_range()) || !used.iter().all(sound) {
            return Err(WorldError::Mismatch);
        }
        for (touch, saved) in self.now.iter_mut().zip(used) {
            let [a, b, node, rest @ ..] = *saved;
            let [fx, fy, fz, ax, ay, az, bx, by, bz, rx, ry, rz, rest @ ..] = rest;
            let [sx, sy, sz, i, j, k, u, v, w] = rest;
            *touch = Touch {
                members: [a as usize, b as usize],
                node: node as u32,
                axes: UNITS,
                force: [fx, fy, fz],
                filtered: [[ax, ay, az], [bx, by, bz]],
                residual: [rx, ry, rz],
                slid: [sx, sy, sz],
                triangle: [i, j, k].map(|node| node as u32),
                weights: [u, v, w],
                ..Touch::NONE
            };
        }
        (self.n_now, self.stored) = (count, stored);
        // That they were is not saved.
        self.ordered = false;
        for (slot, saved) in self.slots.iter_mut().zip(of_slots.as_chunks::<SLOT>().0) {
            let [x, y, z, turn @ ..] = *saved;
            slot.end.position = [x, y, z];
            slot.end.turn.as_flattened_mut().iter_mut().zip(turn).for_each(|(to, from)| *to = from);
        }
        // Placements of a world that was never stepped are none.
        self.step = if of_slots.iter().all(|&x| x == 0.0) { 0 } else { self.step.max(1) };
        for (state, saved) in self.joints.states.iter_mut().zip(of_joints.as_chunks::<JOINT>().0) {
            let [force @ .., broken] = *saved;
            (state.force, state.broken) = (force, broken != 0.0);
        }
        self.room.statics.iter_mut().zip(of_statics).for_each(|(number, saved)| *number = *saved);
        Ok(())
    }
}
