//! Placements of a body in space.

use crate::base::pose::Pose;
use crate::base::principal::UNITS;
use crate::base::vec3::{add, dot, minus};
use crate::flight::rigid::RigidMotion;

/// A placement as a motion with the origin as centre; `None` if it is not sound.
pub(crate) fn motion_of(pose: &Pose) -> Option<RigidMotion> {
    let (position, attitude) = (pose.position(), pose.attitude());
    let motion = RigidMotion { position, attitude, momentum: [0.0; 3], angular_momentum: [0.0; 3] };
    motion.normalised().filter(|_| pose.is_sound())
}

/// A rotation as a matrix, and the place of a centre.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Frame {
    /// Place of the centre in space \[m\].
    pub position: [f64; 3],
    /// The centre in the coordinates of the body \[m\].
    pub centre: [f64; 3],
    /// Directions of the body in space, one a column.
    pub turn: [[f64; 3]; 3],
}

impl Frame {
    pub fn new(motion: &RigidMotion, centre: [f64; 3]) -> Self {
        let columns = UNITS.map(|unit| motion.to_space(unit));
        Self { position: motion.position, centre, turn: transposed(columns) }
    }

    /// A point of the body in space.
    pub fn place(&self, point: [f64; 3]) -> [f64; 3] {
        add(self.position, 1.0, self.to_space(minus(point, self.centre)))
    }

    /// A point of space in the body.
    pub fn locate(&self, point: [f64; 3]) -> [f64; 3] {
        add(self.centre, 1.0, self.to_body(minus(point, self.position)))
    }

    pub fn to_space(self, direction: [f64; 3]) -> [f64; 3] {
        self.turn.map(|row| dot(row, direction))
    }

    pub fn to_body(self, direction: [f64; 3]) -> [f64; 3] {
        transposed(self.turn).map(|column| dot(column, direction))
    }
}

/// The transpose of a 3×3 matrix.
pub(crate) fn transposed([[a, b, c], [d, e, f], [g, h, i]]: [[f64; 3]; 3]) -> [[f64; 3]; 3] {
    [[a, d, g], [b, e, h], [c, f, i]]
}

/// `T A Tᵀ`.
pub(crate) fn turned(turn: [[f64; 3]; 3], a: [[f64; 3]; 3]) -> [[f64; 3]; 3] {
    let half = turn.map(|row| transposed(a).map(|column| dot(row, column)));
    half.map(|row| turn.map(|other| dot(row, other)))
}
