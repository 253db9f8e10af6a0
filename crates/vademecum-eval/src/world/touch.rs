//! One contact of a world.

use crate::base::vec3::{add, dot};
use crate::sections::place::Place;

/// A contact between a node of one member and a point of the surface of another.
#[derive(Clone, Copy, Debug)]
pub struct Touch {
    /// Member of the node, and member of the surface.
    pub(crate) members: [usize; 2],
    pub(crate) node: u32,
    pub(crate) places: [Place; 2],
    /// Nodes of the triangle of the second place, and their weights.
    pub(crate) triangle: [u32; 3],
    pub(crate) weights: [f64; 3],
    /// Normal of the surface, outwards, and two tangents, in space.
    pub(crate) axes: [[f64; 3]; 3],
    pub(crate) friction: f64,
    pub(crate) restitution: f64,
    /// Force on the node along the axes, held over the step \[N\].
    pub(crate) force: [f64; 3],
    /// Forces on the node as the residual flexibility of each member answers them \[N\]: in space, and
    /// between two steps in the axes of the member, so that the energy in it does not change as it turns.
    pub(crate) filtered: [[f64; 3]; 2],
    /// Displacement of the node from the point by the residual flexibility, in space \[m\].
    pub(crate) residual: [f64; 3],
    /// Position of the node \[m\].
    pub(crate) position: [f64; 3],
    /// Distance between node and point \[m\] when it was found, which decides if it is kept.
    pub(crate) distance: f64,
    /// Gap at the start of the step; gap and slip at its end without forces of contacts.
    pub(crate) start: f64,
    pub(crate) free: [f64; 3],
    /// Smallest gap at the end of the step.
    pub(crate) target: f64,
    /// Arms of the force about the centre of each member, in space \[m\].
    pub(crate) arms: [[f64; 3]; 2],
    /// Answer of its own residual flexibility to a force, and of all, along the axes \[m/N\].
    pub(crate) own: [[f64; 3]; 3],
    pub(crate) all: [[f64; 3]; 3],
    /// Residual flexibility of each member in space \[m/N\].
    pub(crate) blocks: [[[f64; 3]; 3]; 2],
    /// Gap and slip at the end of the step.
    pub(crate) end: [f64; 3],
    /// Slip over the last step \[m\], in space.
    pub(crate) slid: [f64; 3],
    /// Place on each member at rest \[m\].
    pub(crate) rest: [[f64; 3]; 2],
    /// Contacts near it, with a block between the two.
    pub(crate) n_near: usize,
    /// Gap and slip by the residual flexibility at the start, and by the forces of the step.
    pub(crate) shown: [f64; 3],
    pub(crate) held: [f64; 3],
    /// Share of an old force that the residual flexibility keeps over a step, of both members in the mean.
    pub(crate) keep: f64,
}

impl Touch {
    /// For memory that is lent to a world.
    pub const NONE: Self = Self {
        members: [0; 2],
        node: 0,
        places: [Place::node(0); 2],
        triangle: [0; 3],
        weights: [0.0; 3],
        slid: [0.0; 3],
        axes: [[0.0; 3]; 3],
        friction: 0.0,
        restitution: 0.0,
        force: [0.0; 3],
        filtered: [[0.0; 3]; 2],
        residual: [0.0; 3],
        position: [0.0; 3],
        distance: 0.0,
        start: 0.0,
        free: [0.0; 3],
        target: 0.0,
        arms: [[0.0; 3]; 2],
        own: [[0.0; 3]; 3],
        all: [[0.0; 3]; 3],
        blocks: [[[0.0; 3]; 3]; 2],
        end: [0.0; 3],
        rest: [[0.0; 3]; 2],
        n_near: 0,
        shown: [0.0; 3],
        held: [0.0; 3],
        keep: 0.0,
    };

    /// Numbers of the member of the node and of the member of the surface.
    #[must_use]
    pub const fn members(&self) -> [usize; 2] {
        self.members
    }

    /// Places on the two members.
    #[must_use]
    pub const fn places(&self) -> &[Place; 2] {
        &self.places
    }

    /// Position of the node in space \[m\].
    #[must_use]
    pub const fn position(&self) -> [f64; 3] {
        self.position
    }

    /// Normal of the surface, outwards.
    #[must_use]
    pub const fn normal(&self) -> [f64; 3] {
        self.axes[0]
    }

    /// Force on the node in space \[N\], held over the last step; on the surface acts its opposite.
    #[must_use]
    pub fn force(&self) -> [f64; 3] {
        let each = self.axes.iter().zip(self.force);
        each.fold([0.0; 3], |sum, (axis, force)| add(sum, force, *axis))
    }

    /// Normal force \[N\].
    #[must_use]
    pub const fn pressure(&self) -> f64 {
        self.force[0]
    }

    /// Gap at the end of the last step \[m\]; below 0 if they overlap.
    #[must_use]
    pub const fn gap(&self) -> f64 {
        self.end[0]
    }

    /// Slip over the last step \[m\], in space.
    #[must_use]
    pub fn slip(&self) -> [f64; 3] {
        let [_, first, second] = self.axes;
        add(first.map(|x| self.end[1] * x), self.end[2], second)
    }

    /// Adds a displacement in space that the residual flexibility shows at the start of the step, of which a
    /// share is kept to its end.
    pub(crate) fn show(&mut self, by: [f64; 3], keep: f64) {
        let along = self.axes.map(|axis| dot(axis, by));
        self.start += along[0];
        for (k, along) in along.into_iter().enumerate() {
            self.shown[k] += along;
            self.free[k] += if k == 0 { keep * along } else { (keep - 1.0) * along };
        }
    }

    /// The forces that the residual flexibility shows, along the axes.
    pub(crate) fn remembered(&self) -> [f64; 3] {
        self.axes.map(|axis| 0.5 * (dot(axis, self.filtered[0]) + dot(axis, self.filtered[1])))
    }

    /// Energy of its forces in the residual flexibility after the step \[J\].
    pub(crate) fn stored(&self) -> f64 {
        let along: [f64; 3] = core::array::from_fn(|k| self.keep * self.shown[k] + self.held[k]);
        0.5 * dot(self.remembered(), along)
    }

    /// Energy that its forces take from the modes and the rigid motions in the step \[J\].
    pub(crate) fn taken(&self) -> f64 {
        let [gap, slip, across] = self.end;
        let moved = [gap - self.start, slip, across];
        // Less what the residual flexibility moves.
        let own: [f64; 3] = core::array::from_fn(|k| self.held[k] + (self.keep - 1.0) * self.shown[k]);
        dot(self.force, own) - dot(self.force, moved)
    }

    /// `true` if node and point are the same as those of `other`.
    pub(crate) fn is_same(&self, members: [usize; 2], node: u32) -> bool {
        self.members == members && self.node == node
    }
}

impl Default for Touch {
    fn default() -> Self {
        Self::NONE
    }
}
