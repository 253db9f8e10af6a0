//! Forces of contacts at the end of the step: projected Gauss–Seidel in the coordinates of the members.
//!
//! ```text
//! y_c = G_c x + S_c f_c        x = Σ_c P G_cᵀ f_c
//! 0 ≤ f_n  ⟂  free_n + y_n − target ≥ 0        |f_t| ≤ μ f_n, against the slip free_t + y_t
//! ```
//!
//! A contact reads the coordinates and adds its answer to them: no Delassus matrix is formed, and a sweep is
//! `O(r)` a contact. The forces of the last step are where it starts.

use crate::base::vec3::dot;
use crate::world::patch::{Near, answer as answer_of};
use crate::world::rows::{add, times};
use crate::world::touch::Touch;

/// Coordinates, their answers to a unit force held over the step, and the rows of contacts.
pub(crate) struct System<'a> {
    pub x: &'a mut [f64],
    pub p: &'a [f64],
    /// `6 stride` numbers a contact: three rows of each member.
    pub rows: &'a [f64],
    pub stride: usize,
    /// Blocks between contacts, `most` a contact at most.
    pub near: &'a [Near],
    pub most: usize,
}

/// Coordinates of the two members of a contact: where they start, and their number.
type Spans<'a> = &'a dyn Fn(&Touch) -> [[usize; 2]; 2];

impl System<'_> {
    /// Rows of one side of a contact, and where its coordinates are.
    fn side(&self, contact: usize, side: usize, n: usize) -> &[f64] {
        let start = (2 * contact + side) * 3 * self.stride;
        self.rows.get(start..start + 3 * n).unwrap_or_default()
    }

    /// Displacements of a contact by the coordinates.
    fn read(&self, contact: usize, spans: &[[usize; 2]; 2]) -> [f64; 3] {
        let mut sum = [0.0; 3];
        for (side, &[first, n]) in spans.iter().enumerate() {
            let x = self.x.get(first..first + n).unwrap_or_default();
            let own = times(self.side(contact, side, n), x);
            sum.iter_mut().zip(own).for_each(|(sum, own)| *sum += own);
        }
        sum
    }

    /// Displacements of a contact by its own block and those of the contacts near it.
    pub(crate) fn blocks(&self, contact: usize, touches: &[Touch]) -> [f64; 3] {
        let Some(touch) = touches.get(contact) else { return [0.0; 3] };
        let own = touch.own.map(|row| dot(row, touch.force));
        let near = self.near.get(contact * self.most..).and_then(|near| near.get(..touch.n_near));
        let near =
            answer_of(near.unwrap_or_default(), |other| touches.get(other).map_or([0.0; 3], |t| t.force));
        core::array::from_fn(|k| own[k] + near[k])
    }

    /// Displacements of a contact by coordinates `from` on, as many of each member as `counts`.
    pub(crate) fn by_some(&self, contact: usize, spans: &[[usize; 2]; 2], some: [[usize; 2]; 2]) -> [f64; 3] {
        let mut sum = [0.0; 3];
        for (side, (&[first, n], [from, count])) in spans.iter().zip(some).enumerate() {
            let x = self.x.get(first + from..first + from + count).unwrap_or_default();
            for (sum, row) in sum.iter_mut().zip(self.side(contact, side, n).chunks_exact(n.max(1))) {
                *sum += row.iter().skip(from).zip(x).map(|(row, x)| row * x).sum::<f64>();
            }
        }
        sum
    }

    /// Adds the answer to a force at a contact.
    fn push(&mut self, contact: usize, spans: &[[usize; 2]; 2], force: [f64; 3]) {
        for (side, &[first, n]) in spans.iter().enumerate() {
            let start = (2 * contact + side) * 3 * self.stride;
            let rows = self.rows.get(start..start + 3 * n).unwrap_or_default();
            let p = self.p.get(first..first + n).unwrap_or_default();
            let x = self.x.get_mut(first..first + n).unwrap_or_default();
            add(rows, p, force, x);
        }
    }
}

/// Takes the forces that the contacts have, and their answers.
pub(crate) fn start(system: &mut System<'_>, touches: &mut [Touch], spans: Spans<'_>) {
    for (c, touch) in touches.iter_mut().enumerate() {
        touch.force = in_cone(touch.force, touch.friction);
        system.push(c, &spans(touch), touch.force);
    }
}

/// One sweep; the largest change of a displacement \[m\].
pub(crate) fn sweep(system: &mut System<'_>, touches: &mut [Touch], spans: Spans<'_>) -> f64 {
    let mut largest = 0.0_f64;
    for c in 0..touches.len() {
        let (Some(y), Some(touch)) = (displacement(system, c, touches, spans), touches.get_mut(c)) else {
            continue;
        };
        let spans = spans(touch);
        let (next, change, by) = changed(touch, y);
        if change == [0.0; 3] {
            continue;
        }
        largest = largest.max(by);
        touch.force = next;
        system.push(c, &spans, change);
    }
    largest
}

/// Writes gap and slip at the end of the step; the largest displacement by which a contact is off \[m\].
pub(crate) fn show(system: &mut System<'_>, touches: &mut [Touch], spans: Spans<'_>) -> f64 {
    let mut largest = 0.0_f64;
    for c in 0..touches.len() {
        if let (Some(end), Some(touch)) = (displacement(system, c, touches, spans), touches.get_mut(c)) {
            touch.end = end;
            largest = largest.max(changed(touch, end).2);
        }
    }
    largest
}

/// The next force of a contact that shows gap and slip `y`, its change, and the largest displacement of the
/// contact by that change.
fn changed(touch: &Touch, y: [f64; 3]) -> ([f64; 3], [f64; 3], f64) {
    let next = answer(touch, y);
    let change: [f64; 3] = core::array::from_fn(|k| next[k] - touch.force[k]);
    let by = |(k, row): (usize, &[f64; 3])| (row[k] * change[k]).abs();
    (next, change, touch.all.iter().enumerate().map(by).fold(0.0, f64::max))
}

/// Gap and slip of a contact under the present forces.
fn displacement(system: &System<'_>, c: usize, touches: &[Touch], spans: Spans<'_>) -> Option<[f64; 3]> {
    let touch = touches.get(c)?;
    let (y, blocks) = (system.read(c, &spans(touch)), system.blocks(c, touches));
    Some(core::array::from_fn(|k| y[k] + blocks[k] + touch.free[k]))
}

/// The force of a contact that shows gap and slip `y` under its present force: first the normal one, then
/// that of friction, on the disc that the normal one allows.
fn answer(touch: &Touch, y: [f64; 3]) -> [f64; 3] {
    let [normal, first, second] = touch.all;
    let force = touch.force;
    // A contact that nothing answers carries nothing.
    let answers = normal[0] > 0.0;
    if !answers {
        return [0.0; 3];
    }
    let pressure = (force[0] - (y[0] - touch.target) / normal[0]).max(0.0);
    let more = pressure - force[0];
    let softest = first[1].max(second[2]) + first[2].abs();
    let slips = softest > 0.0;
    if touch.friction == 0.0 || !slips {
        return [pressure, 0.0, 0.0];
    }
    let slip = [y[1] + first[0] * more, y[2] + second[0] * more];
    let tangent = [force[1] - slip[0] / softest, force[2] - slip[1] / softest];
    in_cone([pressure, tangent[0], tangent[1]], touch.friction)
}

/// The force with its tangential part on the disc that the normal one allows.
fn in_cone([normal, first, second]: [f64; 3], friction: f64) -> [f64; 3] {
    let normal = normal.max(0.0);
    let size = libm::sqrt(first * first + second * second);
    let most = friction * normal;
    let scale = if size <= most { 1.0 } else { most / size };
    [normal, scale * first, scale * second]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One mass flies onto another: by hand in `docs/explanation/contact.md`.
    #[test]
    fn two_masses() {
        for (residual, force, velocities) in [(3.0, 0.25, [0.75, 0.25]), (0.0, 1.0, [0.0, 1.0])] {
            let mut touch = Touch { members: [0, 1], free: [-1.0, 0.0, 0.0], ..Touch::NONE };
            touch.own[0][0] = residual;
            touch.all[0][0] = 1.0 + residual;
            // One coordinate each, padded; the first is pushed back by the force, the second on.
            let (mut x, p) = ([0.0; 8], [0.5, 0.0, 0.0, 0.0, 0.5, 0.0, 0.0, 0.0]);
            let mut rows = [0.0; 24];
            (rows[0], rows[12]) = (1.0, -1.0);
            let mut system = System { x: &mut x, p: &p, rows: &rows, stride: 4, near: &[], most: 0 };
            let spans = |_: &Touch| [[0, 4], [4, 4]];
            let mut touches = [touch];
            start(&mut system, &mut touches, &spans);
            assert!(sweep(&mut system, &mut touches, &spans) > 0.0);
            assert!(sweep(&mut system, &mut touches, &spans) < 1e-15);
            show(&mut system, &mut touches, &spans);
            assert!((touches[0].force[0] - force).abs() < 1e-15);
            assert!(touches[0].end[0].abs() < 1e-15);
            let found = [1.0 - touches[0].force[0], touches[0].force[0]];
            assert_eq!(found, velocities);
            let energy = found.iter().map(|v| 0.5 * v * v).sum::<f64>() + 0.5 * residual * force * force;
            assert!((0.5 - energy - 0.5 * residual * force * force).abs() < 1e-15);
        }
    }
}
