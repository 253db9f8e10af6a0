//! Place and rotation of a body.

use crate::base::vec3::{add, dot};

/// Largest distance of a quaternion from unit length.
const UNIT: f64 = 1e-6;

/// Largest size of a coordinate.
const LARGEST: f64 = 1e30;

/// Distance of a length from one that rounding leaves.
const ROUNDING: f64 = 4.0 * f64::EPSILON;

/// Place and rotation of a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    position: [f64; 3],
    attitude: [f64; 4],
    /// Rotation matrix, row by row.
    pub(crate) rotation: [[f64; 3]; 3],
    sound: bool,
}

impl Pose {
    /// The body where its file has it.
    pub const IDENTITY: Self = Self {
        position: [0.0; 3],
        attitude: [1.0, 0.0, 0.0, 0.0],
        rotation: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        sound: true,
    };

    /// Of a position \[m\] and a unit quaternion, real part first. Numbers that are not finite, and a
    /// quaternion that is not of unit length within 1e-6, are refused where it is used.
    #[must_use]
    pub fn new(position: [f64; 3], quaternion: [f64; 4]) -> Self {
        let length = libm::sqrt(quaternion.iter().map(|x| x * x).sum());
        let sound = (length - 1.0).abs() <= UNIT && position.iter().all(|x| x.abs() <= LARGEST);
        // One that has been brought to length one before keeps its bits.
        let length = if (length - 1.0).abs() <= ROUNDING { 1.0 } else { length };
        let [w, x, y, z] = quaternion.map(|number| number / length);
        let rotation = [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
            [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
            [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
        ];
        Self { position, attitude: [w, x, y, z], rotation, sound }
    }

    /// Moved, not turned.
    #[must_use]
    pub fn at(position: [f64; 3]) -> Self {
        Self::new(position, [1.0, 0.0, 0.0, 0.0])
    }

    /// Place of the origin of its coordinates \[m\].
    #[must_use]
    pub const fn position(&self) -> [f64; 3] {
        self.position
    }

    /// Rotation, a quaternion of length one, real part first.
    #[must_use]
    pub const fn attitude(&self) -> [f64; 4] {
        self.attitude
    }

    /// True if its numbers are finite and its quaternion is of unit length.
    #[must_use]
    pub const fn is_sound(&self) -> bool {
        self.sound
    }
}

impl Pose {
    /// A direction of the body in space.
    #[must_use]
    pub fn turn(&self, v: [f64; 3]) -> [f64; 3] {
        self.rotation.map(|row| dot(row, v))
    }

    /// A direction of space in the body.
    #[must_use]
    pub fn turn_back(&self, v: [f64; 3]) -> [f64; 3] {
        let [a, b, c] = self.rotation;
        let [x, y, z] = v;
        add(add(a.map(|a| x * a), y, b), z, c)
    }

    /// A point of the body in space \[m\].
    #[must_use]
    pub fn place(&self, x: [f64; 3]) -> [f64; 3] {
        add(self.turn(x), 1.0, self.position)
    }

    /// `Q A Qᵀ`.
    #[cfg(feature = "assembly")]
    pub(crate) fn turn_matrix(&self, a: [[f64; 3]; 3]) -> [[f64; 3]; 3] {
        let [x, y, z] = a;
        // Rows of Q A, then each by the rows of Q.
        let half = self.rotation.map(|[a, b, c]| add(add(x.map(|x| a * x), b, y), c, z));
        half.map(|row| self.turn(row))
    }
}
