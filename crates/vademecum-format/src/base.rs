//! A base that moves: the names of its twelve patterns, and what a motion makes of them.

/// Names of the last patterns of a file whose base moves: accelerations, angular accelerations, products of
/// angular velocities, in the axes of the base.
pub const BASE_PATTERNS: [&str; 12] = [
    "base.ax",
    "base.ay",
    "base.az",
    "base.dwx",
    "base.dwy",
    "base.dwz",
    "base.wxwx",
    "base.wywy",
    "base.wzwz",
    "base.wxwy",
    "base.wywz",
    "base.wzwx",
];

/// Motion of a base at an instant, in its own axes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BaseMotion {
    /// Acceleration of its point \[m/s²\].
    pub acceleration: [f64; 3],
    /// Angular velocity \[rad/s\].
    pub angular_velocity: [f64; 3],
    /// Angular acceleration \[rad/s²\].
    pub angular_acceleration: [f64; 3],
}

impl BaseMotion {
    /// Amplitudes of the twelve patterns.
    #[must_use]
    pub fn amplitudes(&self) -> [f64; 12] {
        let Self { acceleration: [ax, ay, az], angular_acceleration: [dx, dy, dz], .. } = *self;
        let [x, y, z] = self.angular_velocity;
        [ax, ay, az, dx, dy, dz, x * x, y * y, z * z, x * y, y * z, z * x]
    }
}

/// The acceleration of a point of the base at `x` from the base's point, in a unit of pattern `index`.
#[must_use]
pub fn base_field(index: usize, x: [f64; 3]) -> [f64; 3] {
    let [a, b, c] = x;
    match index {
        0 => [1.0, 0.0, 0.0],
        1 => [0.0, 1.0, 0.0],
        2 => [0.0, 0.0, 1.0],
        // e × x
        3 => [0.0, -c, b],
        4 => [c, 0.0, -a],
        5 => [-b, a, 0.0],
        // ω × (ω × x) = ω (ω·x) − x ω²
        6 => [0.0, -b, -c],
        7 => [-a, 0.0, -c],
        8 => [-a, -b, 0.0],
        9 => [b, a, 0.0],
        10 => [0.0, c, b],
        11 => [c, 0.0, a],
        _ => [0.0; 3],
    }
}
