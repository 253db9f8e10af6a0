//! Residual flexibility between contacts that are near each other.
//!
//! A file with a contact patch has further modes, which answer at once, and what is left between near nodes.
//! The modes are coordinates of the solution like the others, with the answer 1; the rest is a block between
//! two contacts `c` and `d`, times `ψ(|x_c − x_d|/h)`. Both are positive semidefinite, the second by Schur's
//! product theorem (1911) with Wendland's function (1995), and one contact alone has the whole residual.

use crate::base::scalar::Scalar;
use crate::base::vec3::{add, dot, minus};
use crate::body::body::Body;
use crate::sections::place::Place;
use crate::world::frame::{transposed, turned};
use crate::world::member::Member;
use crate::world::slot::Slot;
use crate::world::touch::Touch;
use vademecum_format::{ContactPatch, taper};

/// Block between two contacts of a step.
#[derive(Clone, Copy, Debug, Default)]
pub struct Near {
    /// The other contact.
    pub(crate) other: u32,
    /// Gap and slip by the force of the other, along the axes of each \[m/N\].
    pub(crate) block: [[f64; 3]; 3],
}

/// First pair of each loadable node, and the number of all: one number more than nodes.
pub(crate) fn index(patch: &ContactPatch<'_>, out: &mut [u32]) {
    let mut pair = 0;
    for (node, out) in out.iter_mut().enumerate() {
        let before = |pair: &[[u8; 4]; 2]| (u32::from_le_bytes(pair[0]) as usize) < node;
        while patch.pairs.get(pair).is_some_and(before) {
            pair += 1;
        }
        *out = pair as u32;
    }
}

/// The block of two loadable nodes, found by the index; zero of nodes that are no pair.
fn block(patch: &ContactPatch<'_>, index: &[u32], a: u32, b: u32) -> [f64; 9] {
    let (low, high) = (a.min(b), a.max(b));
    let range = index.get(low as usize).zip(index.get(low as usize + 1));
    let found = range.and_then(|(&first, &last)| {
        let own = patch.pairs.get(first as usize..last as usize)?;
        let place = own.binary_search_by_key(&high, |pair| u32::from_le_bytes(pair[1])).ok()?;
        patch.blocks.row(9 * (first as usize + place), 9)
    });
    let mut block = [0.0; 9];
    for (at, value) in block.iter_mut().enumerate() {
        let at = if a <= b { at } else { 3 * (at % 3) + at / 3 };
        *value = found.and_then(|row| row.get(at)).unwrap_or(0.0);
    }
    block
}

/// Displacements of a place by the further modes, three rows of as many numbers.
pub(crate) fn rows(patch: &ContactPatch<'_>, place: &Place, out: &mut [f64]) {
    let m = patch.n_modes;
    out.fill(0.0);
    let Some(modes) = patch.modes else { return };
    for (component, out) in out.chunks_exact_mut(m.max(1)).enumerate().take(3) {
        for (node, weight) in place.entries() {
            let row = modes.row((3 * node as usize + component) * m, m);
            let numbers = row.iter().flat_map(|row| row.iter());
            out.iter_mut().zip(numbers).for_each(|(out, value)| *out += weight * value);
        }
    }
}

/// Displacement of a node by the further modes.
pub(crate) fn node(patch: &ContactPatch<'_>, node: u32, amplitudes: &[f64]) -> [f64; 3] {
    let m = patch.n_modes;
    core::array::from_fn(|component| {
        let row = patch.modes.and_then(|modes| modes.row((3 * node as usize + component) * m, m));
        row.map_or(0.0, |row| row.iter().zip(amplitudes).map(|(row, z)| row * z).sum())
    })
}

/// Residual flexibility between two places of a body beyond the further modes, without `ψ`.
pub(crate) fn between<T: Scalar>(
    body: &Body<'_, T>,
    (patch, index): (&ContactPatch<'_>, &[u32]),
    [a, b]: [&Place; 2],
) -> [[f64; 3]; 3] {
    let mut sum = [[0.0; 3]; 3];
    for (of, of_a) in a.entries() {
        for (by, of_b) in b.entries() {
            let scale = of_a * of_b / body.scene.parameters.stiffness;
            let block = block(patch, index, of, by);
            sum.as_flattened_mut().iter_mut().zip(block).for_each(|(sum, block)| *sum += scale * block);
        }
    }
    sum
}

/// Blocks between the contacts of bodies with a patch: those of contact `c` are `counts[c]` from
/// `most c` on. Of more than `most` the nearest ones are found first in the order of the contacts.
pub(crate) fn blocks<T: Scalar>(
    members: &[Member<'_, '_, T>],
    slots: &[Slot],
    touches: &mut [Touch],
    (near, most): (&mut [Near], usize),
    indices: &[u32],
) {
    touches.iter_mut().for_each(|touch| touch.n_near = 0);
    for c in 0..touches.len() {
        for d in 0..c {
            let (before, after) = touches.split_at_mut(c);
            let (Some(other), Some(touch)) = (before.get_mut(d), after.first_mut()) else { continue };
            let mut sum = [[0.0; 3]; 3];
            let others = other.members;
            let mut any = touch.n_near < most && other.n_near < most;
            if !any {
                continue;
            }
            any = false;
            for side in 0..2 {
                let member = touch.members[side];
                for with in (0..2).filter(|&with| others[with] == member) {
                    let (Some(slot), Some(body)) =
                        (slots.get(member), members.get(member).and_then(Member::elastic))
                    else {
                        continue;
                    };
                    let Some(patch) = &body.patch else { continue };
                    let index = indices.get(slot.index..).unwrap_or_default();
                    let away = minus(touch.rest[side], other.rest[with]);
                    let share = taper(libm::sqrt(dot(away, away)) / patch.distance);
                    if share == 0.0 || share.is_nan() {
                        continue;
                    }
                    any = true;
                    let places = [&touch.places[side], &other.places[with]];
                    let block = between(body, (patch, index), places);
                    let sign = if side == with { share } else { -share };
                    let block = turned(slot.middle.turn, block).map(|row| row.map(|value| sign * value));
                    // From the axes of the other to those of this one.
                    for (i, axis) in touch.axes.into_iter().enumerate() {
                        let row = transposed(block).map(|column| dot(column, axis));
                        for (j, axis) in other.axes.into_iter().enumerate() {
                            sum[i][j] += (1.0 - slot.keep) * dot(row, axis);
                        }
                    }
                    // What the forces of the last step show.
                    let (of, by) = (other.filtered[with], touch.filtered[side]);
                    touch.show(block.map(|row| dot(row, of)), slot.keep);
                    other.show(transposed(block).map(|row| dot(row, by)), slot.keep);
                }
            }
            if !any {
                continue;
            }
            let own = Near { other: d as u32, block: sum };
            let back = Near { other: c as u32, block: transposed(sum) };
            for (at, value, count) in [(c, own, &mut touch.n_near), (d, back, &mut other.n_near)] {
                if let Some(place) = near.get_mut(at * most + *count) {
                    *place = value;
                    *count += 1;
                }
            }
        }
    }
}

/// Gap and slip of a contact by the forces of those near it.
#[inline]
pub(crate) fn answer(near: &[Near], force: impl Fn(usize) -> [f64; 3]) -> [f64; 3] {
    near.iter().fold([0.0; 3], |sum, near| {
        let force = force(near.other as usize);
        add(sum, 1.0, near.block.map(|row| dot(row, force)))
    })
}
