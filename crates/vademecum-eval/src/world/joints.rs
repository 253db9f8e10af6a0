//! All joints of a world, the envelope of their matrix, and what they push with.

use crate::base::vec3::{add, cross};
use crate::world::joint::{self, JointState, ROWS, WorldJoint};
use crate::world::slot::Slot;
use crate::world::touch::Touch;

/// Joints of a world, in lent memory.
#[derive(Debug)]
pub(crate) struct Joints<'m> {
    pub all: &'m [WorldJoint],
    pub states: &'m mut [JointState],
    /// Per joint and side, six rows of `stride` numbers.
    pub rows: &'m mut [f64],
    /// Per joint and side, six rows of `largest` numbers: displacement and rotation by the modes.
    pub basis: &'m mut [f64],
    pub largest: usize,
    /// Envelope of the matrix of all rows: first column, offset, and numbers.
    pub starts: &'m mut [u32],
    pub offsets: &'m mut [u32],
    pub matrix: &'m mut [f64],
    pub gaps: &'m mut [f64],
}

/// Rows and members of a joint of a list.
pub(crate) type JointRows = Option<(usize, [usize; 2])>;

/// Rows and members of the joints of a list, by their numbers.
pub(crate) fn rows_and_members(joints: &[WorldJoint]) -> impl Fn(usize) -> JointRows + '_ {
    |i| joints.get(i).map(|joint| (joint::rows_of(joint.kind), joint.members))
}

/// Rows of so many joints, and numbers of their envelope.
pub(crate) fn envelope(
    count: usize,
    joint: impl Fn(usize) -> JointRows,
    moves: impl Fn(usize) -> bool,
) -> [usize; 2] {
    let (mut rows, mut numbers) = (0_usize, 0_usize);
    let of = |i: usize| joint(i).map_or(0, |(rows, _)| rows);
    for i in 0..count {
        let before: usize = (0..first_shared(&joint, i, &moves)).map(of).sum();
        for _ in 0..of(i) {
            rows += 1;
            numbers = numbers.saturating_add(rows - before);
        }
    }
    [rows, numbers]
}

/// The first joint that shares a member that moves with joint `i`.
pub(crate) fn first_shared(
    joint: impl Fn(usize) -> JointRows,
    i: usize,
    moves: impl Fn(usize) -> bool,
) -> usize {
    let Some((_, own)) = joint(i) else { return i };
    let shares = |other: [usize; 2]| other.iter().any(|m| own.contains(m) && moves(*m));
    (0..i).find(|&j| joint(j).is_some_and(|(_, other)| shares(other))).unwrap_or(i)
}

impl Joints<'_> {
    pub fn row(&self, joint: usize, side: usize, row: usize, stride: usize) -> &[f64] {
        let start = ((2 * joint + side) * ROWS + row) * stride;
        self.rows.get(start..start + stride).unwrap_or_default()
    }

    pub fn basis(&self, joint: usize, side: usize) -> &[f64] {
        let size = ROWS * self.largest;
        self.basis.get((2 * joint + side) * size..(2 * joint + side + 1) * size).unwrap_or_default()
    }
}

/// Forces and moments about its centre on each member.
pub(crate) fn gather(slots: &mut [Slot], touches: &[Touch], joints: &[WorldJoint], states: &[JointState]) {
    slots.iter_mut().for_each(|slot| slot.pushed = [[0.0; 3]; 2]);
    let mut push = |member: usize, force: [f64; 3], moment: [f64; 3]| {
        if let Some(slot) = slots.get_mut(member) {
            slot.pushed = [add(slot.pushed[0], 1.0, force), add(slot.pushed[1], 1.0, moment)];
        }
    };
    for touch in touches.iter().filter(|touch| touch.force[0] > 0.0) {
        for (side, sign) in [(0, 1.0), (1, -1.0)] {
            let force = touch.force().map(|x| sign * x);
            push(touch.members[side], force, cross(touch.arms[side], force));
        }
    }
    for (joint, state) in joints.iter().zip(states) {
        for side in 0..2 {
            let [force, moment] = state.wrench(side);
            push(joint.members[side], force, add(moment, 1.0, cross(state.arms[side], force)));
        }
    }
}
