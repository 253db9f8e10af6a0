//! Place and rotation of a part.

/// Place and rotation of a part.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pose {
    position: [f64; 3],
    /// Rotation matrix, row by row.
    pub rotation: [[f64; 3]; 3],
}

impl Pose {
    /// Of a position and a unit quaternion, real part first.
    pub fn new(position: [f64; 3], quaternion: [f64; 4]) -> Self {
        let length = quaternion.iter().map(|x| x * x).sum::<f64>().sqrt();
        let [w, x, y, z] = quaternion.map(|number| number / length);
        let rotation = [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
            [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
            [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
        ];
        Self { position, rotation }
    }

    /// A direction of the part in space.
    pub fn turn(&self, v: [f64; 3]) -> [f64; 3] {
        self.rotation.map(|row| row.iter().zip(v).map(|(a, b)| a * b).sum())
    }

    /// A point of the part in space.
    pub fn place(&self, x: [f64; 3]) -> [f64; 3] {
        let turned = self.turn(x);
        std::array::from_fn(|c| turned[c] + self.position[c])
    }

    /// `Q A Qᵀ`.
    pub fn turn_matrix(&self, a: [[f64; 3]; 3]) -> [[f64; 3]; 3] {
        let q = &self.rotation;
        let half: [[f64; 3]; 3] =
            std::array::from_fn(|i| std::array::from_fn(|j| (0..3).map(|k| q[i][k] * a[k][j]).sum()));
        std::array::from_fn(|i| std::array::from_fn(|j| (0..3).map(|k| half[i][k] * q[j][k]).sum()))
    }
}
