//! Joints that turn far: rows at the displacement level at the end of the step, solved directly.
//!
//! The rows of all joints make one symmetric matrix `W = G P Gᵀ + S`, whose envelope is that of the joints
//! that share a member: a chain gives a block tridiagonal one. Its Cholesky factor is frozen over a step, and
//! a few evaluations of the joints as they are at the end of the step, under rotations of any size, close
//! them.

use crate::base::error::LoadError;
use crate::base::principal::UNITS;
use crate::base::scalar::Scalar;
use crate::base::vec3::{add, cross, dot, minus};
use crate::body::body::Body;
use crate::sections::place::Place;
use crate::world::frame::{Frame, transposed};
use crate::world::member::Member;
use vademecum_format::{PortKind, PortRange, SectionKind};

/// Rows of a joint at most.
pub(crate) const ROWS: usize = 6;

/// A joint between two members.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WorldJoint {
    /// Its kind.
    pub kind: JointKind,
    /// Numbers of the two members.
    pub members: [usize; 2],
    /// Where it is on each.
    pub anchors: [Anchor; 2],
    /// Compliance of its displacements \[m/N\]; 0 of one that holds.
    pub compliance: f64,
    /// Size of its force \[N\] above which it breaks after a step; infinite of one that does not.
    pub breaks_at: f64,
}

/// Kind of a joint. The relative placement that it keeps is that of the members when the world is made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum JointKind {
    /// Two points stay together.
    Ball,
    /// Two points stay together, and the members turn about the third axis of the first anchor.
    Hinge,
    /// The second anchor stays on the third axis of the first, and the members do not turn against each
    /// other.
    Slider,
    /// Two points are no farther apart than a length \[m\].
    Cable {
        /// The length.
        length: f64,
    },
}

/// Anchor of a joint on a member.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Anchor {
    /// A place of the surface of a body: of a ball joint or a cable.
    Place(Place),
    /// A port of a body that is a frame, by its number in the file.
    Frame(usize),
    /// A point \[m\] of a rigid body in its own coordinates, and its axes.
    Point {
        /// The point.
        at: [f64; 3],
        /// The axes.
        axes: [[f64; 3]; 3],
    },
}

impl Anchor {
    /// A point of a rigid body, with the axes of its coordinates.
    #[must_use]
    pub const fn point(at: [f64; 3]) -> Self {
        Self::Point { at, axes: UNITS }
    }
}

impl WorldJoint {
    /// A joint that holds.
    #[must_use]
    pub const fn new(kind: JointKind, members: [usize; 2], anchors: [Anchor; 2]) -> Self {
        Self { kind, members, anchors, compliance: 0.0, breaks_at: f64::INFINITY }
    }
}

/// Force and memory of a joint, to lend to a [`World`](crate::World).
#[derive(Clone, Copy, Debug, Default)]
pub struct JointState {
    /// Forces of the rows.
    pub(crate) force: [f64; ROWS],
    /// Gaps at the start and at the end of the step.
    pub(crate) start: [f64; ROWS],
    pub(crate) end: [f64; ROWS],
    /// Rows that hold.
    pub(crate) rows: usize,
    /// Directions of force and of moment on each member, in space.
    pub(crate) along: [[[f64; 3]; ROWS]; 2],
    pub(crate) about: [[[f64; 3]; ROWS]; 2],
    /// Anchor at rest, in the coordinates of each member, and its axes.
    pub(crate) rest: [[f64; 3]; 2],
    pub(crate) axes: [[[f64; 3]; 3]; 2],
    /// Arms about the centres, in space.
    pub(crate) arms: [[f64; 3]; 2],
    /// `true` once it was broken.
    pub(crate) broken: bool,
    /// `true` of a cable that carries nothing.
    pub(crate) slack: bool,
    /// Change of its forces in an evaluation.
    pub(crate) change: [f64; ROWS],
    /// First of its rows, and first joint that it shares a member with.
    pub(crate) first_row: usize,
    pub(crate) first_shared: usize,
}

/// Displacement and rotation of an anchor in the coordinates of its body.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Moved {
    pub by: [f64; 3],
    pub turned: [f64; 3],
}

/// An anchor in space: its point, and three axes.
#[derive(Clone, Copy)]
struct InSpace {
    at: [f64; 3],
    axes: [[f64; 3]; 3],
}

impl JointState {
    /// `false` of a joint that carries nothing in this step.
    pub(crate) const fn holds(&self) -> bool {
        !self.broken && !self.slack
    }

    /// Force \[N\] on the first member in space, held over the last step.
    #[must_use]
    pub fn force(&self) -> [f64; 3] {
        self.wrench(0)[0]
    }

    /// Moment \[N m\] on the first member about its anchor, in space.
    #[must_use]
    pub fn moment(&self) -> [f64; 3] {
        self.wrench(0)[1]
    }

    /// `true` once it was broken.
    #[must_use]
    pub const fn is_broken(&self) -> bool {
        self.broken
    }

    fn in_space(&self, side: usize, frame: &Frame, moved: Moved) -> InSpace {
        let turn = |axis: [f64; 3]| {
            // Small rotations of the anchor in its body.
            let axis = add(axis, 1.0, cross(moved.turned, axis));
            frame.to_space(axis)
        };
        InSpace { at: frame.place(add(self.rest[side], 1.0, moved.by)), axes: self.axes[side].map(turn) }
    }

    /// Keeps the relative placement of two frames: the axes of the first on the second, too.
    pub(crate) fn align(&mut self, frames: [&Frame; 2]) {
        let axes = self.axes[0].map(|axis| frames[1].to_body(frames[0].to_space(axis)));
        self.axes[1] = axes;
    }

    /// Gaps of its rows.
    pub(crate) fn gaps(&self, kind: JointKind, frames: [&Frame; 2], moved: [Moved; 2]) -> [f64; ROWS] {
        let a = self.in_space(0, frames[0], moved[0]);
        let b = self.in_space(1, frames[1], moved[1]);
        let apart = minus(a.at, b.at);
        let [x, y, z] = a.axes;
        match kind {
            JointKind::Ball => [apart[0], apart[1], apart[2], 0.0, 0.0, 0.0],
            JointKind::Hinge => [apart[0], apart[1], apart[2], dot(z, b.axes[0]), dot(z, b.axes[1]), 0.0],
            JointKind::Slider => {
                let turned = [dot(y, b.axes[2]), dot(z, b.axes[0]), dot(x, b.axes[1])];
                [-dot(x, apart), -dot(y, apart), turned[0], turned[1], turned[2], 0.0]
            }
            JointKind::Cable { length } => {
                let [x, y, z] = apart;
                [length - libm::sqrt(x * x + y * y + z * z), 0.0, 0.0, 0.0, 0.0, 0.0]
            }
        }
    }

    /// Directions of force and moment of its rows, for members as they are in `frames`.
    pub(crate) fn direct(&mut self, kind: JointKind, frames: [&Frame; 2], moved: [Moved; 2]) {
        let a = self.in_space(0, frames[0], moved[0]);
        let b = self.in_space(1, frames[1], moved[1]);
        for side in 0..2 {
            let at = if side == 0 { a.at } else { b.at };
            self.arms[side] = minus(at, frames[side].position);
        }
        (self.along, self.about) = ([[[0.0; 3]; ROWS]; 2], [[[0.0; 3]; ROWS]; 2]);
        let apart = minus(a.at, b.at);
        let mut set = |row: usize, along: [f64; 3], about: [[f64; 3]; 2]| {
            let minus_it = along.map(|x| -x);
            (self.along[0][row], self.along[1][row]) = (along, minus_it);
            (self.about[0][row], self.about[1][row]) = (about[0], about[1]);
        };
        let none = [[0.0; 3]; 2];
        let turning = |u: [f64; 3], v: [f64; 3]| [cross(u, v), cross(v, u)];
        let [x, y, z] = a.axes;
        match kind {
            JointKind::Ball | JointKind::Hinge => {
                UNITS.into_iter().enumerate().for_each(|(row, unit)| set(row, unit, none));
                if kind == JointKind::Hinge {
                    set(3, [0.0; 3], turning(z, b.axes[0]));
                    set(4, [0.0; 3], turning(z, b.axes[1]));
                }
            }
            JointKind::Slider => {
                // `x · (p_b − p_a)`: the axis turns with the first member.
                let lever = |axis: [f64; 3]| [cross(axis, apart.map(|x| -x)), [0.0; 3]];
                set(0, x.map(|x| -x), lever(x));
                set(1, y.map(|x| -x), lever(y));
                set(2, [0.0; 3], turning(y, b.axes[2]));
                set(3, [0.0; 3], turning(z, b.axes[0]));
                set(4, [0.0; 3], turning(x, b.axes[1]));
            }
            JointKind::Cable { .. } => {
                let size = libm::sqrt(dot(apart, apart));
                if size > 0.0 {
                    set(0, apart.map(|x| -x / size), none);
                }
            }
        }
        self.rows = rows_of(kind);
    }

    /// Force and moment at its anchor on a member, in space.
    pub(crate) fn wrench(&self, side: usize) -> [[f64; 3]; 2] {
        let sum = |all: &[[f64; 3]; ROWS]| {
            let each = all.iter().zip(self.force).take(self.rows);
            each.fold([0.0; 3], |sum, (direction, force)| add(sum, force, *direction))
        };
        [sum(&self.along[side]), sum(&self.about[side])]
    }
}

/// Rows of a kind.
pub(crate) const fn rows_of(kind: JointKind) -> usize {
    match kind {
        JointKind::Ball => 3,
        JointKind::Hinge | JointKind::Slider => 5,
        JointKind::Cable { .. } => 1,
    }
}

/// The number of the rows of a port that is a frame.
pub(crate) fn frame_rows<T>(body: &Body<'_, T>, port: usize) -> Option<usize> {
    let table = body.file.port_table().ok()?;
    let range = PortRange::of(table.get(port)?)?;
    (range.kind == PortKind::Frame).then_some(range.rows[0])
}

/// An anchor at rest in the coordinates of its member, with its axes; `None` of one that the member has not,
/// or that the kind of joint cannot use.
pub(crate) fn at_rest<T: Scalar>(
    member: &Member<'_, '_, T>,
    anchor: &Anchor,
    kind: JointKind,
) -> Option<([f64; 3], [[f64; 3]; 3])> {
    let points_are_enough = matches!(kind, JointKind::Ball | JointKind::Cable { .. });
    match (member.elastic(), anchor) {
        (None, Anchor::Point { at, axes }) => {
            let finite = at.iter().chain(axes.as_flattened()).all(|x| x.in_range());
            finite.then_some((*at, *axes))
        }
        (Some(body), Anchor::Place(place)) if points_are_enough => {
            let n_load = body.scene.metadata().n_load_nodes;
            crate::sections::contact::check_loadable(place, n_load).ok()?;
            let outline = member.outline()?;
            let mut sum = [0.0; 3];
            for (node, weight) in place.entries() {
                sum = add(sum, weight, outline.node(node)?);
            }
            Some((sum, UNITS))
        }
        (Some(body), Anchor::Frame(port)) => {
            frame_rows(body, *port)?;
            let frames = body.file.section(SectionKind::PortFrames)?.numbers().ok()?;
            let row = frames.row(port.checked_mul(12)?, 12)?;
            let three = |k: usize| Some([row.get(k)?, row.get(k + 1)?, row.get(k + 2)?]);
            Some((three(0)?, [three(3)?, three(6)?, three(9)?]))
        }
        _ => None,
    }
}

/// Displacements by the modes of an anchor along and about the axes of the body: six rows of `r` numbers, of
/// a place the first three.
pub(crate) fn basis<T: Scalar>(
    body: &Body<'_, T>,
    anchor: &Anchor,
    work: &mut [T],
    out: &mut [f64],
) -> Result<(), LoadError> {
    let r = body.scene.n_modes();
    out.fill(0.0);
    match anchor {
        Anchor::Place(place) => {
            let work = work.get_mut(..3 * r).ok_or(LoadError::Mismatch)?;
            body.scene.project(&[place], work)?;
            out.iter_mut().zip(&*work).for_each(|(out, value)| *out = value.to_f64());
        }
        Anchor::Frame(port) => {
            let kind = SectionKind::PortRows;
            let missing = LoadError::Missing { kind };
            let first = frame_rows(body, *port).ok_or(missing)?;
            let rows = body.file.section(kind).and_then(|rows| rows.numbers().ok()).ok_or(missing)?;
            let axes = frame_axes(body, *port).ok_or(missing)?;
            for (row, out) in out.chunks_exact_mut(r.max(1)).enumerate().take(ROWS) {
                for (k, axis) in axes.iter().enumerate() {
                    let own = rows.row((first + row / 3 * 3 + k) * r, r).ok_or(missing)?;
                    let weight = axis[row % 3];
                    out.iter_mut().zip(own.iter()).for_each(|(out, value)| *out += weight * value);
                }
            }
        }
        Anchor::Point { .. } => return Err(LoadError::Mismatch),
    }
    Ok(())
}

fn frame_axes<T>(body: &Body<'_, T>, port: usize) -> Option<[[f64; 3]; 3]> {
    let frames = body.file.section(SectionKind::PortFrames)?.numbers().ok()?;
    let row = frames.row(port.checked_mul(12)?, 12)?;
    let three = |k: usize| Some([row.get(k)?, row.get(k + 1)?, row.get(k + 2)?]);
    Some([three(3)?, three(6)?, three(9)?])
}

/// Residual flexibility between two anchors of one body: displacement and rotation of the first by a force
/// and a moment at the second, along and about the axes of the body. Zero where the file has none.
pub(crate) fn residual<T: Scalar>(
    body: &Body<'_, T>,
    [a, b]: [&Anchor; 2],
    force: [f64; 3],
    moment: [f64; 3],
) -> Moved {
    match (a, b) {
        (Anchor::Place(of), Anchor::Place(by)) if of == by => {
            let block = body.scene.residual_at(of);
            Moved { by: block.map(|row| dot(row, force)), turned: [0.0; 3] }
        }
        (Anchor::Frame(of), Anchor::Frame(by)) => {
            of_frames(body, *of, *by, force, moment).unwrap_or_default()
        }
        _ => Moved::default(),
    }
}

fn of_frames<T: Scalar>(
    body: &Body<'_, T>,
    of: usize,
    by: usize,
    force: [f64; 3],
    moment: [f64; 3],
) -> Option<Moved> {
    let section = body.file.section(SectionKind::PortCompliance)?;
    let (numbers, width) = (section.numbers().ok()?, section.shape()[0] as usize);
    let [rows, columns] = [frame_rows(body, of)?, frame_rows(body, by)?];
    let [own, other] = [frame_axes(body, of)?, frame_axes(body, by)?];
    let local = |vector: [f64; 3]| other.map(|axis| dot(axis, vector));
    let (force, moment) = (local(force), local(moment));
    let answer = |row: usize| -> f64 {
        let row = numbers.row((rows + row) * width + columns, ROWS);
        let at = |k: usize| row.and_then(|row| row.get(k)).unwrap_or(0.0);
        (0..3).map(|k| at(k) * force[k] + at(3 + k) * moment[k]).sum::<f64>()
    };
    let scale = 1.0 / body.scene.parameters.stiffness;
    let to_body = |local: [f64; 3]| transposed(own).map(|column| scale * dot(column, local));
    Some(Moved {
        by: to_body([answer(0), answer(1), answer(2)]),
        turned: to_body([answer(3), answer(4), answer(5)]),
    })
}

/// Cholesky's factor of a symmetric matrix whose rows start at `starts`, in place: row `i` holds its numbers
/// from `starts[i]` to the diagonal. The row of the first pivot that is not positive otherwise.
pub(crate) fn factorise(rows: &mut [f64], starts: &[u32], offsets: &[u32]) -> Result<(), usize> {
    let at = |i: usize, j: usize| -> Option<usize> {
        let (start, offset) = (*starts.get(i)? as usize, *offsets.get(i)? as usize);
        (j >= start).then(|| offset + j - start)
    };
    for i in 0..starts.len() {
        let start = starts.get(i).copied().unwrap_or(0) as usize;
        for j in start..=i {
            let common = start.max(starts.get(j).copied().unwrap_or(0) as usize);
            let (Some(own), Some(row_i), Some(row_j)) = (at(i, j), at(i, common), at(j, common)) else {
                continue;
            };
            let length = j - common;
            let of = |first: usize| rows.get(first..first + length).unwrap_or_default();
            let less: f64 = of(row_i).iter().zip(of(row_j)).map(|(a, b)| a * b).sum();
            let before = rows.get(own).copied().unwrap_or(0.0);
            let value = before - less;
            let pivot = at(j, j).and_then(|at| rows.get(at)).copied().unwrap_or(0.0);
            let next = if i == j {
                // A row that follows from others, or is not a number.
                let holds = value > 1e-12 * before;
                if !holds {
                    return Err(i);
                }
                libm::sqrt(value)
            } else {
                value / pivot
            };
            if let Some(place) = rows.get_mut(own) {
                *place = next;
            }
        }
    }
    Ok(())
}

/// Solves with the factor, in place.
pub(crate) fn solve(rows: &[f64], starts: &[u32], offsets: &[u32], x: &mut [f64]) {
    let row = |i: usize| -> Option<(usize, &[f64])> {
        let (start, offset) = (*starts.get(i)? as usize, *offsets.get(i)? as usize);
        Some((start, rows.get(offset..offset + i + 1 - start)?))
    };
    for i in 0..x.len() {
        let Some((start, own)) = row(i) else { continue };
        let Some((pivot, own)) = own.split_last() else { continue };
        let sum: f64 = own.iter().zip(x.get(start..).unwrap_or_default()).map(|(a, x)| a * x).sum();
        if let Some(x) = x.get_mut(i) {
            *x = (*x - sum) / pivot;
        }
    }
    for i in (0..x.len()).rev() {
        let Some((start, own)) = row(i) else { continue };
        let Some((pivot, own)) = own.split_last() else { continue };
        let Some(value) = x.get_mut(i).map(|x| {
            *x /= pivot;
            *x
        }) else {
            continue;
        };
        let above = x.get_mut(start..i).unwrap_or_default();
        above.iter_mut().zip(own).for_each(|(x, a)| *x -= a * value);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_matrix_with_an_envelope_is_factorised_and_solved() {
        // Rows that start late: 4 -1 0 0 / -1 4 -1 0 / 0 -1 4 -1 / 0 0 -1 4.
        let (starts, offsets) = ([0, 0, 1, 2], [0, 1, 3, 5]);
        let mut rows = [4.0, -1.0, 4.0, -1.0, 4.0, -1.0, 4.0];
        assert_eq!(factorise(&mut rows, &starts, &offsets), Ok(()));
        let mut x = [2.0, 4.0, 6.0, 13.0];
        solve(&rows, &starts, &offsets, &mut x);
        for (found, expected) in x.into_iter().zip([1.0, 2.0, 3.0, 4.0]) {
            assert!((found - expected).abs() < 1e-14, "{found} {expected}");
        }
        let mut singular = [1.0, 1.0, 1.0];
        assert_eq!(factorise(&mut singular, &[0, 0], &[0, 1]), Err(1));
    }
}
