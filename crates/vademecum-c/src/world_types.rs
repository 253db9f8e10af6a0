//! Types of worlds that cross the boundary.

use crate::types::{VdmBody, VdmMotion, VdmPlace, VdmRigidBody};

/// A world, behind a handle.
pub struct VdmWorld {
    _private: [u8; 0],
}

/// Kinds of joints: the values of `VdmJoint.kind`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VdmJointKind {
    /// Two points stay together.
    VDM_BALL = 0,
    /// Two points stay together, and the members turn about the third axis of the first anchor.
    VDM_HINGE = 1,
    /// The second anchor stays on the third axis of the first, and the members do not turn against each
    /// other.
    VDM_SLIDER = 2,
    /// Two points are no farther apart than a length.
    VDM_CABLE = 3,
}

/// Kinds of anchors: the values of `VdmAnchor.kind`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VdmAnchorKind {
    /// A place of the surface of a body, for a ball joint or a cable.
    VDM_AT_PLACE = 0,
    /// A port of a body that is a frame.
    VDM_AT_PORT = 1,
    /// A point of a rigid member, with axes.
    VDM_AT_POINT = 2,
}

/// Members of a pair whose nodes are held off the surface of the other: the values of `VdmTouching.nodes`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VdmNodes {
    /// Of both.
    VDM_NODES_BOTH = 0,
    /// Of the first.
    VDM_NODES_FIRST = 1,
    /// Of the second.
    VDM_NODES_SECOND = 2,
}

/// Options of a world. Fill it with `vdm_default_world_options` first.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct VdmWorldOptions {
    /// Acceleration of gravity in space, in m/s², of members that fly and of rigid members.
    pub gravity: [f64; 3],
    /// Nodes and triangles are paired up to this distance, in m; 0: a fiftieth of the smallest member.
    pub reach: f64,
    /// Largest change of a displacement in the last sweep, in m; 0: 1e-9 of the smallest member.
    pub tolerance: f64,
    /// Share of an overlap that a step takes back, of what is above 1e-4 of the size of the smallest member.
    pub recover: f64,
    /// Most sweeps of a step.
    pub sweeps: u32,
    /// Contacts for which there is room. Of more the deepest are kept.
    pub contacts: u32,
    /// Contacts near each contact for which there is room, of bodies whose files have a contact patch.
    pub near: u32,
}

/// A member of a world: a body, or a rigid body within a surface. Set all of it to zero first.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct VdmMember {
    /// A body; null: a rigid member.
    pub body: *mut VdmBody,
    /// Nodes of a rigid member in its own coordinates, three numbers each, in m.
    pub nodes: *const f64,
    /// Its triangles, three nodes each, counterclockwise from outside.
    pub triangles: *const u32,
    /// Number of nodes.
    pub n_nodes: usize,
    /// Number of triangles.
    pub n_triangles: usize,
    /// Mass and moments of a rigid member that moves; a mass of 0: the host leads it.
    pub mass: VdmRigidBody,
    /// Of a rigid member that moves, its motion. Of a body with supports, and of a rigid member that the host
    /// leads, `position` and `attitude` are the place of the origin of its coordinates and its rotation. A
    /// body that flies has a motion of its own. An attitude of zeros: not turned.
    pub motion: VdmMotion,
}

/// Two members that may touch. Set all of it to zero first.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct VdmTouching {
    /// The first member, counted from 0.
    pub first: u32,
    /// The second.
    pub second: u32,
    /// Members whose nodes are held off the surface of the other: a `VdmNodes`.
    pub nodes: i32,
    /// Coefficient of Coulomb's friction, 0 or more.
    pub friction: f64,
    /// Restitution of an impact that is shorter than a step, from 0 to 1.
    pub restitution: f64,
}

/// Anchor of a joint on a member. Set all of it to zero first.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct VdmAnchor {
    /// Its kind: a `VdmAnchorKind`.
    pub kind: i32,
    /// The port, as `vdm_find` counts them.
    pub port: u32,
    /// The place.
    pub place: VdmPlace,
    /// The point of a rigid member in its own coordinates, in m.
    pub point: [f64; 3],
    /// Its axes, one a row; zeros: those of the coordinates.
    pub axes: [[f64; 3]; 3],
}

/// A joint between two members. Set all of it to zero first.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct VdmJoint {
    /// Its kind: a `VdmJointKind`.
    pub kind: i32,
    /// The first member, counted from 0.
    pub first: u32,
    /// The second.
    pub second: u32,
    /// Its anchors on the two.
    pub anchors: [VdmAnchor; 2],
    /// Length of a cable, in m.
    pub length: f64,
    /// Compliance of its displacements, in m/N; 0 of a joint that holds.
    pub compliance: f64,
    /// Force at which it breaks, in N; 0 of a joint that never does.
    pub breaks_at: f64,
}

/// Report of the steps of a world.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct VdmWorldReport {
    /// Pairs of nodes and surfaces that were near each other in the last step.
    pub contacts: usize,
    /// Those that carry a force.
    pub pressed: usize,
    /// Most pairs of a step for which there was no room.
    pub left_out: usize,
    /// Sweeps of the solutions of all steps.
    pub sweeps: usize,
    /// Steps whose solution was not within the tolerance.
    pub not_converged: usize,
    /// Deepest overlap at the end of a step, in m; 0 if there is none.
    pub worst_gap: f64,
    /// Energy that contacts took from the members, in J.
    pub energy_given_away: f64,
}

/// A contact of the last step, between a node of a member and a point of the surface of another.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct VdmTouch {
    /// Member of the node.
    pub first: u32,
    /// Member of the surface.
    pub second: u32,
    /// Position of the node in space, in m.
    pub position: [f64; 3],
    /// Normal of the surface, outwards.
    pub normal: [f64; 3],
    /// Force on the node in space, in N; on the surface acts its opposite.
    pub force: [f64; 3],
    /// Normal force, in N; 0 of a node that is near and does not touch.
    pub pressure: f64,
    /// Gap at the end of the step, in m; below 0 where they overlap.
    pub gap: f64,
    /// Slip over the step in space, in m.
    pub slip: [f64; 3],
}

/// A joint after the last step.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct VdmJointState {
    /// Force on the first member in space, in N.
    pub force: [f64; 3],
    /// Moment on it about its anchor in space, in N m.
    pub moment: [f64; 3],
    /// Not 0: it was broken.
    pub broken: u32,
}
