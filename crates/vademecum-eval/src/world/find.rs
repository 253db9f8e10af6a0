//! Pairs of nodes and triangles that are near each other.

use core::cell::Cell;

use crate::base::principal::UNITS;
use crate::base::scalar::Scalar;
use crate::base::vec3::{add, cross, dot, minus};
use crate::sections::surface::nearest_in_triangle;
use crate::world::bounds::{Bounds, Corners, overlap};
use crate::world::frame::Frame;
use crate::world::member::{Member, Outline};
use crate::world::patch;
use crate::world::slot::{Slot, Touching};
use crate::world::touch::Touch;

/// A point may lie so far beside a triangle, as a share of its longest edge.
const BESIDE: f64 = 1e-6;

/// Distance of a contact from the place nearest to its node up to which it stays where it slid, as a share of
/// the longest edge.
const KEPT: f64 = 1e-3;

/// Overlaps up to so many times the reach are found: the residual flexibility of a new contact is not there
/// yet.
const DEPTH: f64 = 5.0;

/// Surfaces of the members as they are at the end of the coming step without contacts.
pub(crate) struct Surfaces<'a, T> {
    pub slots: &'a [Slot],
    pub order: &'a [u32],
    pub boxes: &'a [[f32; 6]],
    /// The same as the surface has moved, those whose stamp is that of the step.
    pub moved: &'a [Cell<[f32; 6]>],
    pub fresh: &'a [Cell<u32>],
    /// Boxes of the members in space.
    pub around: &'a mut [[f64; 6]],
    pub extents: &'a [f32],
    pub normals: &'a [[f32; 3]],
    /// Coordinates of the modes.
    pub ahead: &'a [T],
    /// Amplitudes of the further modes.
    pub statics: &'a [f64],
    /// Nodes in the coordinates of their bodies, those whose stamp is that of the step.
    pub positions: &'a mut [[f64; 3]],
    pub stamps: &'a mut [u32],
    pub visits: &'a mut [u32],
    pub step: u32,
    pub visit: &'a mut u32,
    /// Distance up to which pairs are found \[m\].
    pub reach: f64,
}

/// The touches found, in lent memory.
pub(crate) struct Found<'a> {
    pub touches: &'a mut [Touch],
    pub count: usize,
    /// Those for which there was no room.
    pub left_out: usize,
}

/// A member's surface and its coordinates.
struct Side<'a, 'm, T> {
    slot: &'a Slot,
    outline: Outline<'m>,
    bounds: Bounds<'a>,
    q: &'a [T],
}

impl<'a, T: Scalar> Surfaces<'a, T> {
    fn side<'m>(&self, member: usize, outline: Outline<'m>) -> Option<Side<'a, 'm, T>> {
        let slot = self.slots.get(member)?;
        let bounds = Bounds {
            order: self.order.get(slot.order..)?.get(..slot.triangles)?,
            boxes: self.boxes.get(slot.boxes..)?.get(..slot.n_boxes)?,
            extents: self.extents.get(slot.extents..)?.get(..3 * slot.r * slot.n_boxes)?,
            r: slot.r,
            moved: self.moved.get(slot.boxes..)?.get(..slot.n_boxes)?,
            fresh: self.fresh.get(slot.boxes..)?.get(..slot.n_boxes)?,
            step: self.step,
        };
        let q = self.ahead.get(slot.ahead..)?.get(..slot.r)?;
        Some(Side { slot, outline, bounds, q })
    }

    /// A node as it has moved, in the coordinates of its body.
    fn node(&mut self, side: &Side<'_, '_, T>, member: &Member<'_, '_, T>, node: u32) -> Option<[f64; 3]> {
        let at = side.slot.nodes + node as usize;
        let (stamp, position) = (self.stamps.get_mut(at)?, self.positions.get_mut(at)?);
        if *stamp != self.step {
            let mut moved = side.outline.node(node)?;
            if let Some(body) = member.elastic() {
                let rows = &body.scene.sections.rows;
                moved = add(moved, 1.0, rows.node(node as usize, (side.q, 1.0)).ok()?);
                let amplitudes = self.statics.get(side.slot.statics..)?.get(..side.slot.m)?;
                if let Some(patch) = body.patch.as_ref().filter(|_| side.slot.m > 0) {
                    moved = add(moved, 1.0, patch::node(patch, node, amplitudes));
                }
            }
            (*stamp, *position) = (self.step, moved);
        }
        Some(*position)
    }

    /// Boxes of all members in space, with room for the deepest overlap.
    fn set_around(&mut self, members: &[Member<'_, '_, T>]) {
        for (i, member) in members.iter().enumerate() {
            let corners = member.outline().and_then(|outline| {
                let side = self.side(i, outline)?;
                let corners = side.bounds.corners(0, side.q, DEPTH * self.reach)?;
                Some(in_space(&corners, &side.slot.end))
            });
            if let Some(place) = self.around.get_mut(i) {
                *place = corners.map_or([f64::NAN; 6], |[[a, b, c], [d, e, f]]| [a, b, c, d, e, f]);
            }
        }
    }

    /// `true` of members whose boxes in space have nothing in common.
    fn apart(&self, [a, b]: [usize; 2]) -> bool {
        let (Some(a), Some(b)) = (self.around.get(a), self.around.get(b)) else { return false };
        (0..3).any(|k| a[k] > b[3 + k] || b[k] > a[3 + k])
    }

    /// Finds the nodes of one member near the surface of the other.
    fn nodes_on_surface(
        &mut self,
        members: &[Member<'_, '_, T>],
        [a, b]: [usize; 2],
        touching: &Touching,
        before: &[Touch],
        found: &mut Found<'_>,
    ) -> Option<()> {
        let (slave, master) = (members.get(a)?, members.get(b)?);
        let (own, other) = (self.side(a, slave.outline()?)?, self.side(b, master.outline()?)?);
        let (own_frame, other_frame) = (own.slot.end, other.slot.end);
        let reach = self.reach;
        let around = moved(&other.bounds.corners(0, other.q, reach)?, &other_frame, &own_frame);
        let whole = own.bounds.corners(0, own.q, reach)?;
        if !overlap(&whole, &around) {
            return Some(());
        }
        *self.visit = self.visit.wrapping_add(1);
        own.bounds.visit(own.q, reach, &around, |triangle| {
            for node in own.outline.triangle(triangle as usize).into_iter().flatten() {
                let visit = *self.visit;
                let at = own.slot.nodes + node as usize;
                let Some(seen) = self.visits.get_mut(at).filter(|seen| **seen != visit) else { continue };
                *seen = visit;
                let Some(position) = self.node(&own, slave, node) else { continue };
                let Some(normal) = self.normals.get(at) else { continue };
                let old = before.iter().find(|touch| touch.is_same([a, b], node));
                let mut position = own_frame.place(position);
                if let Some(old) = old {
                    position = add(position, 1.0, old.residual);
                }
                let normal = own_frame.to_space(normal.map(f64::from));
                let point = other_frame.locate(position);
                let nearest = self.nearest(&other, master, point, other_frame.to_body(normal));
                let Some(mut nearest) = nearest else { continue };
                if let Some(weights) = old.and_then(|old| self.kept(&other, master, old, &nearest)) {
                    nearest.weights = weights;
                }
                found.add(Touch {
                    members: [a, b],
                    node,
                    places: [
                        crate::sections::place::Place::node(node),
                        other.outline.place(nearest.triangle, nearest.nodes, nearest.weights),
                    ],
                    triangle: nearest.nodes,
                    weights: nearest.weights,
                    axes: axes(other_frame.to_space(nearest.normal)),
                    friction: touching.friction,
                    restitution: touching.restitution,
                    position,
                    distance: nearest.gap,
                    force: old.map_or([0.0; 3], Touch::force),
                    filtered: old.map_or([[0.0; 3]; 2], |old| old.filtered),
                    ..Touch::NONE
                });
            }
        });
        Some(())
    }

    /// Weights of a contact on the same triangle as in the last step, near where it was: it is where it slid,
    /// whatever the motion without its force would be. So one that sticks keeps its place, and with it what
    /// the residual flexibility stores.
    fn kept(
        &mut self,
        side: &Side<'_, '_, T>,
        member: &Member<'_, '_, T>,
        old: &Touch,
        nearest: &Nearest,
    ) -> Option<[f64; 3]> {
        if old.triangle != nearest.nodes || old.force == [0.0; 3] {
            return None;
        }
        let [a, b, c] = nearest.nodes.map(|node| self.node(side, member, node));
        let corners = [a?, b?, c?];
        let at = |weights: [f64; 3]| -> [f64; 3] {
            core::array::from_fn(|k| (0..3).map(|corner| weights[corner] * corners[corner][k]).sum())
        };
        let point = add(at(old.weights), 1.0, side.slot.end.to_body(old.slid));
        let apart = minus(point, at(nearest.weights));
        let [ab, ac] = [minus(corners[1], corners[0]), minus(corners[2], corners[0])];
        let near = dot(apart, apart) <= KEPT * KEPT * dot(ab, ab).max(dot(ac, ac));
        near.then(|| nearest_in_triangle(point, corners))
    }

    /// The nearest triangle that faces a point with an outward normal, both in the coordinates of its body.
    fn nearest(
        &mut self,
        side: &Side<'_, '_, T>,
        member: &Member<'_, '_, T>,
        point: [f64; 3],
        normal: [f64; 3],
    ) -> Option<Nearest> {
        let reach = self.reach;
        let depth = DEPTH * reach;
        let around = [point.map(|x| x - depth), point.map(|x| x + depth)];
        let mut best: Option<Nearest> = None;
        side.bounds.visit(side.q, 0.0, &around, |triangle| {
            let triangle = triangle as usize;
            let Some(nodes) = side.outline.triangle(triangle) else { return };
            let [Some(a), Some(b), Some(c)] = nodes.map(|node| self.node(side, member, node)) else { return };
            let (ab, ac) = (minus(b, a), minus(c, a));
            let up = cross(ab, ac);
            let size = libm::sqrt(dot(up, up));
            let up = up.map(|x| x / size);
            let gap = dot(up, minus(point, a));
            let nearer = best.is_none_or(|best| gap.abs() < best.gap.abs());
            // Not a number is not within reach.
            if !((-depth..=reach).contains(&gap) && nearer && dot(up, normal) < 0.0) {
                return;
            }
            let weights = nearest_in_triangle(point, [a, b, c]);
            let at: [f64; 3] =
                core::array::from_fn(|k| weights[0] * a[k] + weights[1] * b[k] + weights[2] * c[k]);
            let beside = add(minus(point, at), -gap, up);
            let edge = dot(ab, ab).max(dot(ac, ac));
            if dot(beside, beside) <= BESIDE * BESIDE * edge {
                best = Some(Nearest { triangle, nodes, weights, normal: up, gap });
            }
        });
        best
    }
}

#[derive(Clone, Copy)]
struct Nearest {
    triangle: usize,
    nodes: [u32; 3],
    weights: [f64; 3],
    normal: [f64; 3],
    gap: f64,
}

impl Found<'_> {
    fn add(&mut self, touch: Touch) {
        if let Some(place) = self.touches.get_mut(self.count) {
            *place = touch;
            self.count += 1;
            return;
        }
        // The deepest stay.
        self.left_out += 1;
        let widest = self.touches.iter_mut().max_by(|a, b| a.distance.total_cmp(&b.distance));
        if let Some(widest) = widest.filter(|widest| widest.distance > touch.distance) {
            *widest = touch;
        }
    }
}

/// Touches of the step before.
pub(crate) struct Before<'a> {
    pub touches: &'a [Touch],
    /// `true` if they are in the order in which they were found, which is that of the pairs.
    pub ordered: bool,
}

impl<'a> Before<'a> {
    /// Those of a member's nodes on the surface of another, and possibly others; called in the order of the
    /// pairs.
    fn of(&mut self, members: [usize; 2]) -> &'a [Touch] {
        if !self.ordered {
            return self.touches;
        }
        let count = self.touches.iter().take_while(|touch| touch.members == members).count();
        let (own, left) = self.touches.split_at(count);
        self.touches = left;
        own
    }
}

/// Finds all touches of the pairs.
pub(crate) fn find<T: Scalar>(
    mut surfaces: Surfaces<'_, T>,
    members: &[Member<'_, '_, T>],
    pairs: &[Touching],
    mut before: Before<'_>,
    found: &mut Found<'_>,
) {
    surfaces.set_around(members);
    for touching in pairs {
        let [a, b] = touching.members;
        let apart = surfaces.apart([a, b]);
        let sides = [(touching.nodes.of_first(), [a, b]), (touching.nodes.of_second(), [b, a])];
        for (_, side) in sides.into_iter().filter(|(meant, _)| *meant) {
            let own = before.of(side);
            if !apart {
                surfaces.nodes_on_surface(members, side, touching, own, found);
            }
        }
    }
}

/// A box of a body, as a box of space around it.
fn in_space(corners: &Corners, frame: &Frame) -> Corners {
    moved(corners, frame, &Frame { turn: UNITS, ..Frame::default() })
}

/// A box of one body, as a box of another around it.
fn moved(corners: &Corners, from: &Frame, to: &Frame) -> Corners {
    let middle: [f64; 3] = core::array::from_fn(|k| 0.5 * (corners[0][k] + corners[1][k]));
    let half: [f64; 3] = core::array::from_fn(|k| 0.5 * (corners[1][k] - corners[0][k]));
    let middle = to.locate(from.place(middle));
    let mut around = [0.0; 3];
    for (k, size) in half.into_iter().enumerate() {
        let mut side = [0.0; 3];
        side[k] = size;
        let side = to.to_body(from.to_space(side));
        around.iter_mut().zip(side).for_each(|(around, side)| *around += side.abs());
    }
    [minus(middle, around), add(middle, 1.0, around)]
}

/// A unit vector, and two that are square to it and to each other.
fn axes(normal: [f64; 3]) -> [[f64; 3]; 3] {
    let smallest = (0..3).min_by(|&a, &b| normal[a].abs().total_cmp(&normal[b].abs())).unwrap_or(0);
    let mut unit = [0.0; 3];
    unit[smallest] = 1.0;
    let first = cross(normal, unit);
    let size = libm::sqrt(dot(first, first));
    let first = first.map(|x| x / size);
    [normal, first, cross(normal, first)]
}
