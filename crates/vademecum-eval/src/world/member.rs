//! Members of a world: bodies of files, held or free, and rigid bodies of a host.

use crate::base::pose::Pose;
use crate::base::scalar::Scalar;
use crate::base::vec3::{add, cross, minus};
use crate::body::body::Body;
use crate::flight::rigid::{RigidBody, RigidMotion};
use crate::sections::place::Place;
use crate::sections::surface::Surface;
use crate::world::frame::{Frame, motion_of};

/// Largest distance of the square of an attitude from one, of a motion that is taken back.
const UNIT: f64 = 1e-12;

/// A body in a world, lent for one step.
#[derive(Debug)]
pub enum Member<'w, 'm, T> {
    /// A body with supports, and its placement.
    Held(&'w mut Body<'m, T>, Pose),
    /// A body without supports, which flies ([`BodyOptions::flight`](crate::BodyOptions::flight)).
    Free(&'w mut Body<'m, T>),
    /// A rigid body of the host.
    Rigid(&'w mut RigidShape<'m>),
}

/// A rigid body of a host: a closed surface of triangles, and its motion.
#[derive(Clone, Copy, Debug)]
pub struct RigidShape<'m> {
    nodes: &'m [[f64; 3]],
    triangles: &'m [[u32; 3]],
    /// Mass and moments; `None` of a body that the host moves.
    body: Option<RigidBody>,
    motion: RigidMotion,
    /// Placement at the end of the coming step, of a body that the host moves.
    goal: RigidMotion,
    force: [f64; 3],
    moment: [f64; 3],
}

impl<'m> RigidShape<'m> {
    /// A body that stands, or that the host moves by [`RigidShape::lead`]. `nodes` \[m\] are in its own
    /// coordinates, triangles turn counterclockwise seen from outside. `None` if the pose is not finite or a
    /// triangle names a node that there is not.
    #[must_use]
    pub fn led(nodes: &'m [[f64; 3]], triangles: &'m [[u32; 3]], pose: Pose) -> Option<Self> {
        Self::new(nodes, triangles, None, motion_of(&pose)?)
    }

    /// A body with a mass, in motion. `nodes` and `triangles` as for [`RigidShape::led`].
    #[must_use]
    pub fn moving(
        nodes: &'m [[f64; 3]],
        triangles: &'m [[u32; 3]],
        body: RigidBody,
        motion: RigidMotion,
    ) -> Option<Self> {
        Self::new(nodes, triangles, Some(body), motion.normalised()?)
    }

    fn new(
        nodes: &'m [[f64; 3]],
        triangles: &'m [[u32; 3]],
        body: Option<RigidBody>,
        motion: RigidMotion,
    ) -> Option<Self> {
        let known = triangles.as_flattened().iter().all(|&node| (node as usize) < nodes.len());
        let finite = nodes.as_flattened().iter().all(|x| x.in_range());
        let (goal, force, moment) = (motion, [0.0; 3], [0.0; 3]);
        let shape = Self { nodes, triangles, body, motion, goal, force, moment };
        (known && finite).then_some(shape)
    }

    /// Nodes of its surface in its own coordinates \[m\].
    #[must_use]
    pub const fn nodes(&self) -> &'m [[f64; 3]] {
        self.nodes
    }

    /// Its motion.
    #[must_use]
    pub const fn motion(&self) -> &RigidMotion {
        &self.motion
    }

    /// Its mass and moments; `None` of a body that the host moves.
    #[must_use]
    pub const fn body(&self) -> Option<&RigidBody> {
        self.body.as_ref()
    }

    /// Puts it elsewhere, or lets it move otherwise. `None`, and nothing changes, if a number is not finite.
    pub fn set_motion(&mut self, motion: RigidMotion) -> Option<()> {
        self.motion = motion.normalised()?;
        self.goal = self.motion;
        Some(())
    }

    /// Takes back what [`RigidShape::motion`] gave, bit by bit. `None`, and nothing changes, if a number is
    /// not finite or the attitude has not length one.
    pub fn restore(&mut self, motion: RigidMotion) -> Option<()> {
        let length: f64 = motion.attitude.iter().map(|x| x * x).sum();
        if !motion.is_finite() || libm::fabs(length - 1.0) > UNIT {
            return None;
        }
        (self.motion, self.goal) = (motion, motion);
        Some(())
    }

    /// Placement at the end of the coming step of a body that the host moves; it stays there. `None`, and
    /// nothing changes, if a number is not finite.
    pub fn lead(&mut self, pose: Pose) -> Option<()> {
        self.goal = motion_of(&pose)?;
        Some(())
    }

    /// Pulls with a force \[N\] and a moment about its centre \[N m\] of space, held over the coming step.
    pub fn pull(&mut self, force: [f64; 3], moment: [f64; 3]) {
        self.force = add(self.force, 1.0, force);
        self.moment = add(self.moment, 1.0, moment);
    }

    /// Pushes at a point of space \[m\] with a force \[N\], held over the coming step.
    pub fn push(&mut self, at: [f64; 3], force: [f64; 3]) {
        self.pull(force, cross(minus(at, self.motion.position), force));
    }

    pub(crate) fn centre(&self) -> [f64; 3] {
        self.body.map_or([0.0; 3], |body| body.centre)
    }

    /// Its motion halfway through the coming step, and at its end, without contacts.
    pub(crate) fn ahead(&self, time: f64) -> [RigidMotion; 2] {
        let Some(body) = &self.body else {
            let between = |a: [f64; 3], b: [f64; 3]| add(a, 1.0, b).map(|x| 0.5 * x);
            let (a, b) = (self.motion, self.goal);
            // Of two quaternions of one rotation the one on the same side.
            let side = if a.attitude.iter().zip(b.attitude).map(|(a, b)| a * b).sum::<f64>() < 0.0 {
                -1.0
            } else {
                1.0
            };
            let mut attitude = a.attitude;
            attitude.iter_mut().zip(b.attitude).for_each(|(a, b)| *a += side * b);
            let middle = RigidMotion { position: between(a.position, b.position), attitude, ..b };
            return [middle.normalised().unwrap_or(b), b];
        };
        let mut middle = self.motion;
        middle.drift(body, 0.5 * time);
        let mut end = middle;
        end.kick(time, self.force, self.moment);
        end.drift(body, 0.5 * time);
        [middle, end]
    }

    /// Its motion at the end of the coming step with an impulse of contacts, held over the step, at the
    /// instant `(1 − η)/2` of it.
    pub(crate) fn kicked(&self, time: f64, eta: f64, contact: [[f64; 3]; 2]) -> RigidMotion {
        match &self.body {
            Some(body) => kicked(self.motion, body, time, eta, contact, [self.force, self.moment]),
            None => self.goal,
        }
    }

    pub(crate) fn accept(&mut self, motion: RigidMotion) {
        self.motion = motion;
        (self.force, self.moment) = ([0.0; 3], [0.0; 3]);
    }
}

/// A rigid motion after a step: forces of contacts at the instant `(1 − η)/2` of it, others at the middle.
pub(crate) fn kicked(
    mut motion: RigidMotion,
    body: &RigidBody,
    time: f64,
    eta: f64,
    contact: [[f64; 3]; 2],
    others: [[f64; 3]; 2],
) -> RigidMotion {
    let before = 0.5 * (1.0 - eta) * time;
    motion.drift(body, before);
    motion.kick(time, contact[0], contact[1]);
    motion.drift(body, 0.5 * time - before);
    motion.kick(time, others[0], others[1]);
    motion.drift(body, 0.5 * time);
    motion
}

/// The surface of a member at rest.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Outline<'m> {
    Elastic(Surface<'m>),
    Rigid(&'m [[f64; 3]], &'m [[u32; 3]]),
}

impl Outline<'_> {
    pub const fn n_triangles(&self) -> usize {
        match self {
            Self::Elastic(surface) => surface.n_triangles(),
            Self::Rigid(_, triangles) => triangles.len(),
        }
    }

    pub const fn n_nodes(&self) -> usize {
        match self {
            Self::Elastic(surface) => surface.n_nodes(),
            Self::Rigid(nodes, _) => nodes.len(),
        }
    }

    pub fn triangle(&self, triangle: usize) -> Option<[u32; 3]> {
        match self {
            Self::Elastic(surface) => surface.triangle(triangle),
            Self::Rigid(_, triangles) => triangles.get(triangle).copied(),
        }
    }

    /// A node at rest \[m\].
    pub fn node(&self, node: u32) -> Option<[f64; 3]> {
        match self {
            Self::Elastic(surface) => {
                let at = (node as usize).checked_mul(3)?;
                let [x, y, z] = [at, at + 1, at + 2].map(|at| surface.coordinate(at));
                Some([x?, y?, z?])
            }
            Self::Rigid(nodes, _) => nodes.get(node as usize).copied(),
        }
    }

    pub fn place(&self, triangle: usize, nodes: [u32; 3], weights: [f64; 3]) -> Place {
        match self {
            Self::Elastic(surface) => surface.place(triangle, nodes, weights),
            Self::Rigid(..) => Place::triangle(nodes, weights),
        }
    }
}

impl<T> Member<'_, '_, T> {
    /// Placement at the end of the coming step, of a body that is held or a rigid body without mass. `None`,
    /// and nothing changes, of any other, and of a placement that is not finite.
    pub fn lead(&mut self, pose: Pose) -> Option<()> {
        match self {
            Self::Held(_, place) if pose.is_sound() => *place = pose,
            Self::Rigid(shape) if shape.body.is_none() => shape.lead(pose)?,
            _ => return None,
        }
        Some(())
    }
}

impl<'m, T: Scalar> Member<'_, 'm, T> {
    /// Its surface; `None` of a file without one.
    pub(crate) fn outline(&self) -> Option<Outline<'m>> {
        match self {
            Self::Held(body, _) | Self::Free(body) => body.surface.map(Outline::Elastic),
            Self::Rigid(shape) => Some(Outline::Rigid(shape.nodes, shape.triangles)),
        }
    }

    /// Its placement.
    pub(crate) fn frame(&self) -> Option<Frame> {
        Some(match self {
            Self::Held(_, pose) => Frame::new(&motion_of(pose)?, [0.0; 3]),
            Self::Free(body) => Frame::new(body.flight?.motion(), body.flight?.body().centre),
            Self::Rigid(shape) => Frame::new(&shape.motion, shape.centre()),
        })
    }

    pub(crate) fn elastic(&self) -> Option<&Body<'m, T>> {
        match self {
            Self::Held(body, _) | Self::Free(body) => Some(body),
            Self::Rigid(_) => None,
        }
    }

    /// Mass and moments of a member whose frame forces move.
    pub(crate) fn rigid(&self) -> Option<RigidBody> {
        match self {
            Self::Free(body) => body.flight.map(|flight| *flight.body()),
            Self::Rigid(shape) => shape.body,
            Self::Held(..) => None,
        }
    }
}
