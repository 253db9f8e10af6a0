//! Placements of a body in space.

use crate::base::principal::UNITS;
use crate::base::vec3::{add, dot, minus};
use crate::flight::rigid::RigidMotion;

/// Placement of a body whose frame a host moves, or that stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Place of the origin of its coordinates \[m\].
    pub position: [f64; 3],
    /// Rotation, a quaternion of length one, real part first.
    pub attitude: [f64; 4],
}

impl Pose {
    /// The coordinates of the file.
    pub const IDENTITY: Self = Self { position: [0.0; 3], attitude: [1.0, 0.0, 0.0, 0.0] };

    /// Moved, not turned.
    #[must_use]
    pub const fn at(position: [f64; 3]) -> Self {
        Self { position, ..Self::IDENTITY }
    }

    /// The same as a motion with the origin as centre, with an attitude of length one; `None` if a number is
    /// not finite.
    pub(crate) fn motion(self) -> Option<RigidMotion> {
        let Self { position, attitude } = self;
        RigidMotion { position, attitude, momentum: [0.0; 3], angular_momentum: [0.0; 3] }.normalised()
    }
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

    pub fn to_space(&self, direction: [f64; 3]) -> [f64; 3] {
        self.turn.map(|row| dot(row, direction))
    }

    pub fn to_body(&self, direction: [f64; 3]) -> [f64; 3] {
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
