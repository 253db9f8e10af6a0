//! Members as a world keeps them, and pairs that may touch.

use crate::world::frame::Frame;

/// A pair of members that may touch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Touching {
    /// Numbers of the two members.
    pub members: [usize; 2],
    /// Coefficient of Coulomb's friction, 0 or more.
    pub friction: f64,
    /// Restitution of an impact that is shorter than a step, from 0 to 1.
    pub restitution: f64,
    /// Members whose nodes are held off the surface of the other.
    pub nodes: Nodes,
}

impl Touching {
    /// A pair without friction and with full restitution, nodes of both against the surface of the other.
    #[must_use]
    pub const fn new(first: usize, second: usize) -> Self {
        Self { members: [first, second], friction: 0.0, restitution: 1.0, nodes: Nodes::Both }
    }

    /// The same with friction.
    #[must_use]
    pub const fn with_friction(self, friction: f64) -> Self {
        Self { friction, ..self }
    }

    /// The same with another restitution of impacts shorter than a step.
    #[must_use]
    pub const fn with_restitution(self, restitution: f64) -> Self {
        Self { restitution, ..self }
    }
}

/// Members of a pair whose nodes are held off the surface of the other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Nodes {
    /// Of both.
    Both,
    /// Of the first.
    First,
    /// Of the second.
    Second,
}

impl Nodes {
    pub(crate) fn of_first(self) -> bool {
        self != Self::Second
    }

    pub(crate) fn of_second(self) -> bool {
        self != Self::First
    }
}

/// Memory of one member, to lend to a [`World`](crate::World).
#[derive(Clone, Copy, Debug, Default)]
pub struct Slot {
    /// Modes, and coordinates with those of the rigid motion, padded.
    pub(crate) r: usize,
    /// Further modes that answer at once.
    pub(crate) m: usize,
    pub(crate) has_patch: bool,
    pub(crate) index: usize,
    pub(crate) n: usize,
    pub(crate) triangles: usize,
    pub(crate) n_boxes: usize,
    pub(crate) n_nodes: usize,
    /// Where its pieces start.
    pub(crate) order: usize,
    pub(crate) boxes: usize,
    pub(crate) extents: usize,
    pub(crate) nodes: usize,
    pub(crate) ahead: usize,
    pub(crate) first: usize,
    pub(crate) statics: usize,
    /// Placements at the start, halfway and at the end of the step without contacts.
    pub(crate) start: Frame,
    pub(crate) middle: Frame,
    pub(crate) end: Frame,
    /// Principal axes of a member whose frame forces move, in the body.
    pub(crate) axes: [[f64; 3]; 3],
    pub(crate) is_rigid: bool,
    /// Share of an old force that the residual flexibility keeps over a step.
    pub(crate) keep: f64,
    /// `η`: forces of contacts move the frame at the instant `(1 − η)/2` of the step.
    pub(crate) eta: f64,
    /// Force, and moment about its centre, of contacts and joints.
    pub(crate) pushed: [[f64; 3]; 2],
}
