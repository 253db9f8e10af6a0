//! The rigid motion of a free body: where it is, how it is turned, and its momenta, over large rotations.
//!
//! A step drifts half of its length, takes the impulse of forces and moments, and drifts the other half.
//! While it drifts, a body keeps its momenta; its attitude follows from turns about its three principal axes,
//! each as far as the energy of that axis alone would turn it, in an order that is the same from behind
//! (McLachlan 1993; Reich 1994; Dullweber, Leimkuhler and McLachlan 1997). The momenta in space are what is
//! kept in memory, so free flight does not change a bit of them. The whole is symplectic and of second order,
//! its energy stays near where it was, and it solves nothing.

use crate::base::principal::{UNITS, principal};
use crate::base::scalar::Scalar;
use crate::base::vec3::{add, cross, dot, minus};
use vademecum_format::{File, SectionKind};

/// Mass, centre and moments of inertia of a free body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RigidBody {
    /// Mass \[kg\].
    pub mass: f64,
    /// Its centre \[m\], in the coordinates of the file.
    pub centre: [f64; 3],
    /// Principal moments of inertia about the centre \[kg m²\].
    pub moments: [f64; 3],
    /// The principal axes, in the coordinates of the file; of length one and square to each other.
    pub axes: [[f64; 3]; 3],
    /// The first of the six load patterns of its angular velocity.
    pub first_pattern: usize,
}

/// The rigid motion of a body: what a state is to its elastic motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RigidMotion {
    /// Position of the centre in space \[m\].
    pub position: [f64; 3],
    /// Attitude of the body, a quaternion of length one, the real part first: a direction `d` of the
    /// body points along `q d q*` in space.
    pub attitude: [f64; 4],
    /// Momentum in space \[kg m/s\].
    pub momentum: [f64; 3],
    /// Angular momentum about the centre, in space \[kg m²/s\].
    pub angular_momentum: [f64; 3],
}

impl RigidBody {
    /// The free body of a file, at the density the file was built with. `None` for a body that is held, and
    /// where the numbers are not those of a body.
    #[must_use]
    pub fn of(file: &File<'_>) -> Option<Self> {
        Self::read(file.section(SectionKind::RigidBody)?.f64s().ok()?, file.metadata().n_patterns)
    }

    pub(crate) fn read(numbers: &[[u8; 8]], n_patterns: u32) -> Option<Self> {
        let (own, _) = numbers.split_first_chunk::<11>()?;
        let [mass, x, y, z, xx, xy, xz, yy, yz, zz, first] = own.map(f64::from_le_bytes);
        let (moments, axes) = principal([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]);
        let centre = [x, y, z];
        let sound = |x: f64| x > 0.0 && x.is_finite();
        let finite = centre.iter().chain(axes.as_flattened()).all(|x| x.is_finite());
        let body = Self { mass, centre, moments, axes, first_pattern: first_pattern(first, n_patterns)? };
        (sound(mass) && moments.into_iter().all(sound) && finite).then_some(body)
    }

    /// The same body at so many times its density.
    #[must_use]
    pub fn at_density(self, scale: f64) -> Self {
        Self { mass: scale * self.mass, moments: self.moments.map(|x| scale * x), ..self }
    }

    /// Angular velocity for an angular momentum, both in the body \[rad/s, kg m²/s\].
    #[must_use]
    pub fn spin_of(&self, angular_momentum: [f64; 3]) -> [f64; 3] {
        self.along_axes(angular_momentum, |share, moment| share / moment)
    }

    /// Angular momentum for an angular velocity, both in the body \[kg m²/s, rad/s\].
    #[must_use]
    pub fn angular_momentum_of(&self, spin: [f64; 3]) -> [f64; 3] {
        self.along_axes(spin, |share, moment| share * moment)
    }

    fn along_axes(&self, vector: [f64; 3], scaled: impl Fn(f64, f64) -> f64) -> [f64; 3] {
        let each = self.axes.iter().zip(self.moments);
        each.fold([0.0; 3], |sum, (axis, moment)| add(sum, scaled(dot(*axis, vector), moment), *axis))
    }

    /// Adds the Delassus operator of the rigid motion at points of the body, for forces held over `time_step`
    /// \[s\], to `w`: what [`Scene::compliance`](crate::Scene::compliance), which is of the elastic motion
    /// alone, leaves out. Points \[m\] and directions are those of the body; `w` has shape `(3n, 3n)` for `n`
    /// points, row by row \[m/N\]; what is beyond its end is left out.
    ///
    /// A force at `d` moves `c` by `½Δt² (1/m F + I⁻¹(r_d × F) × r_c)` by the end of the step.
    pub fn add_compliance(&self, time_step: f64, points: &[[f64; 3]], w: &mut [f64]) {
        let n = points.len().saturating_mul(3);
        let half = 0.5 * time_step * time_step;
        for (d, at) in points.iter().enumerate() {
            for (j, force) in UNITS.into_iter().enumerate() {
                let turn = self.spin_of(cross(minus(*at, self.centre), force));
                for (c, seen) in points.iter().enumerate() {
                    let moved = cross(turn, minus(*seen, self.centre));
                    let moved = add(moved, 1.0 / self.mass, force);
                    for (i, moved) in moved.into_iter().enumerate() {
                        if let Some(out) = w.get_mut((3 * c + i) * n + 3 * d + j) {
                            *out += half * moved;
                        }
                    }
                }
            }
        }
    }
}

/// The number of the first of six patterns, if the file has them.
pub(crate) fn first_pattern(number: f64, n_patterns: u32) -> Option<usize> {
    let there = number >= 0.0 && number + 6.0 <= f64::from(n_patterns) && libm::floor(number) == number;
    there.then_some(number as usize)
}

impl RigidMotion {
    /// The body where the file has it, at rest.
    #[must_use]
    pub const fn at_rest(body: &RigidBody) -> Self {
        Self {
            position: body.centre,
            attitude: [1.0, 0.0, 0.0, 0.0],
            momentum: [0.0; 3],
            angular_momentum: [0.0; 3],
        }
    }

    /// The body where the file has it, thrown with a velocity of its centre \[m/s\] and an angular velocity
    /// \[rad/s\].
    #[must_use]
    pub fn thrown(body: &RigidBody, velocity: [f64; 3], spin: [f64; 3]) -> Self {
        Self {
            momentum: velocity.map(|v| body.mass * v),
            angular_momentum: body.angular_momentum_of(spin),
            ..Self::at_rest(body)
        }
    }

    /// A direction of the body in space.
    #[must_use]
    pub fn to_space(&self, direction: [f64; 3]) -> [f64; 3] {
        turned(self.attitude, direction)
    }

    /// A direction of space in the body.
    #[must_use]
    pub fn to_body(&self, direction: [f64; 3]) -> [f64; 3] {
        let [w, x, y, z] = self.attitude;
        turned([w, -x, -y, -z], direction)
    }

    /// Position in space \[m\] of a point of the body: `point` at rest, in the coordinates of the file, has
    /// moved by `displacement` in the body.
    #[must_use]
    pub fn place(&self, body: &RigidBody, point: [f64; 3], displacement: [f64; 3]) -> [f64; 3] {
        let arm = add(minus(point, body.centre), 1.0, displacement);
        add(self.to_space(arm), 1.0, self.position)
    }

    /// Velocity of the same point in space \[m/s\]; `velocity` is that of its displacement in the body.
    #[must_use]
    pub fn velocity(
        &self,
        body: &RigidBody,
        point: [f64; 3],
        displacement: [f64; 3],
        velocity: [f64; 3],
    ) -> [f64; 3] {
        let arm = add(minus(point, body.centre), 1.0, displacement);
        let own = add(cross(self.spin(body), arm), 1.0, velocity);
        add(self.to_space(own), 1.0 / body.mass, self.momentum)
    }

    /// Angular velocity in the body \[rad/s\].
    #[must_use]
    pub fn spin(&self, body: &RigidBody) -> [f64; 3] {
        body.spin_of(self.to_body(self.angular_momentum))
    }

    /// Kinetic energy \[J\] of the rigid motion.
    #[must_use]
    pub fn energy(&self, body: &RigidBody) -> f64 {
        let turning = dot(self.spin(body), self.to_body(self.angular_momentum));
        0.5 * (dot(self.momentum, self.momentum) / body.mass + turning)
    }

    /// Flies for `time` \[s\] without forces. Momenta keep every bit.
    pub fn drift(&mut self, body: &RigidBody, time: f64) {
        self.position = add(self.position, time / body.mass, self.momentum);
        let [x, y, z] = [0, 1, 2].map(|k| (body.axes.get(k), body.moments.get(k)));
        for ((axis, moment), share) in [(x, 0.5), (y, 0.5), (z, 1.0), (y, 0.5), (x, 0.5)] {
            let (Some(axis), Some(moment)) = (axis, moment) else { continue };
            let rate = dot(self.to_space(*axis), self.angular_momentum) / moment;
            let half = 0.5 * share * time * rate;
            let (real, along) = (libm::cos(half), libm::sin(half));
            let [a, b, c] = axis.map(|x| along * x);
            self.attitude = product(self.attitude, [real, a, b, c]);
        }
        // What rounding adds to its length in a million steps would show.
        let length = libm::sqrt(self.attitude.iter().map(|x| x * x).sum());
        self.attitude = self.attitude.map(|x| x / length);
    }

    /// Takes the impulse of a force \[N\] and a moment about the centre \[N m\], both in space, over `time`
    /// \[s\].
    pub fn kick(&mut self, time: f64, force: [f64; 3], moment: [f64; 3]) {
        self.momentum = add(self.momentum, time, force);
        self.angular_momentum = add(self.angular_momentum, time, moment);
    }

    /// The same motion with an attitude of length one; `None` if a number is not finite or too large
    /// ([`Scalar::LARGEST`](crate::Scalar::LARGEST)), or the attitude is zero.
    #[must_use]
    pub fn normalised(self) -> Option<Self> {
        let length = libm::sqrt(self.attitude.iter().map(|x| x * x).sum());
        let motion = Self { attitude: self.attitude.map(|x| x / length), ..self };
        motion.is_finite().then_some(motion)
    }

    /// `true` if every number is finite, and none too large for what is computed of it
    /// ([`Scalar::LARGEST`](crate::Scalar::LARGEST)).
    #[must_use]
    pub fn is_finite(&self) -> bool {
        let all = self.position.iter().chain(&self.attitude).chain(&self.momentum);
        all.chain(&self.angular_momentum).all(|x| x.in_range())
    }
}

/// `q d q*` for a quaternion of length one.
fn turned([w, x, y, z]: [f64; 4], direction: [f64; 3]) -> [f64; 3] {
    let axis = [x, y, z];
    let twice = cross(axis, direction).map(|t| 2.0 * t);
    add(add(direction, w, twice), 1.0, cross(axis, twice))
}

/// `a b` of two quaternions.
fn product([w, x, y, z]: [f64; 4], [v, a, b, c]: [f64; 4]) -> [f64; 4] {
    [
        w * v - x * a - y * b - z * c,
        w * a + x * v + y * c - z * b,
        w * b - x * c + y * v + z * a,
        w * c + x * b - y * a + z * v,
    ]
}

#[cfg(test)]
mod tests {
    extern crate std;

    use super::*;
    use std::vec::Vec;

    /// A body with three different moments and tilted axes.
    fn racket() -> RigidBody {
        let tilt = |d| turned([0.5, 0.5, 0.5, 0.5].map(|x: f64| x), turned([0.8, 0.0, 0.6, 0.0], d));
        let axes = UNITS.map(tilt);
        RigidBody {
            mass: 0.3,
            centre: [0.1, -0.2, 0.3],
            moments: [1e-3, 2e-3, 2.5e-3],
            axes,
            first_pattern: 0,
        }
    }

    /// Spin about the middle axis, a little off it: the body turns over again and again.
    fn tumbling(body: &RigidBody) -> RigidMotion {
        let [x, y, z] = body.axes;
        let spin = add(add(y.map(|c| 20.0 * c), 0.01, x), 0.02, z);
        RigidMotion::thrown(body, [1.0, -2.0, 3.0], spin)
    }

    fn off(a: &[f64], b: &[f64]) -> f64 {
        a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
    }

    /// Momenta of the body as a cloud of points: six, two on each principal axis.
    fn of_points(body: &RigidBody, motion: &RigidMotion) -> [f64; 6] {
        let [a, b, c] = body.moments;
        // m (y² + z²) summed over the pairs gives the moments.
        let squares = [b + c - a, c + a - b, a + b - c].map(|x| 3.0 * x / (2.0 * body.mass));
        let mut sum = [0.0; 6];
        for (axis, square) in body.axes.into_iter().zip(squares) {
            for sign in [-1.0, 1.0] {
                let point = add(body.centre, sign * square.sqrt(), axis);
                let mass = body.mass / 6.0;
                let v = motion.velocity(body, point, [0.0; 3], [0.0; 3]).map(|v| mass * v);
                let arm = minus(motion.place(body, point, [0.0; 3]), motion.position);
                let turning = cross(arm, v);
                for k in 0..3 {
                    sum[k] += v[k];
                    sum[3 + k] += turning[k];
                }
            }
        }
        sum
    }

    #[test]
    fn principal_axes_are_found_and_span_the_body() {
        let body = racket();
        let full: [[f64; 3]; 3] = core::array::from_fn(|i| body.angular_momentum_of(UNITS[i]));
        let (mut moments, axes) = principal(full);
        for i in 0..3 {
            for j in 0..3 {
                let expected = f64::from(u8::from(i == j));
                assert!((dot(axes[i], axes[j]) - expected).abs() < 1e-14);
            }
            assert!(off(&full.map(|row| dot(row, axes[i])), &axes[i].map(|x| moments[i] * x)) < 1e-17);
        }
        moments.sort_by(f64::total_cmp);
        assert!(off(&moments, &body.moments) < 1e-17, "{moments:?}");
    }

    #[test]
    fn a_million_steps_of_free_flight_keep_the_momenta_and_the_energy() {
        let body = racket();
        let mut motion = tumbling(&body);
        let (start, energy) = (of_points(&body, &motion), motion.energy(&body));
        let [x, y, z] = body.axes;
        let expected = [body.mass, -2.0 * body.mass, 3.0 * body.mass];
        assert!(off(&start[..3], &expected) < 1e-15);
        let turning = body.angular_momentum_of(add(add(y.map(|c| 20.0 * c), 0.01, x), 0.02, z));
        assert!(off(&start[3..], &turning) < 1e-15 * 20.0);
        let (mut worst, mut turned_over) = (0.0f64, 0);
        let mut last = 1.0;
        for step in 0..1_000_000 {
            motion.drift(&body, 1e-3);
            worst = worst.max((motion.energy(&body) / energy - 1.0).abs());
            let middle = dot(motion.spin(&body), y);
            turned_over += i32::from(middle * last < 0.0);
            last = middle;
            if step % 1000 == 999 {
                let now = of_points(&body, &motion);
                assert!(off(&now[..3], &start[..3]) < 1e-10 * off(&start[..3], &[0.0; 3]));
                assert!(off(&now[3..], &start[3..]) < 1e-10 * off(&start[3..], &[0.0; 3]), "{step}");
            }
        }
        // It is bounded: (ωΔt)² is 4e-4.
        assert!(worst < 4e-4, "{worst:e}");
        assert!(turned_over > 100, "{turned_over}");
    }

    #[test]
    fn the_order_is_two_against_a_tight_reference_with_moments_that_follow_the_body() {
        let body = racket();
        let fly = |steps: usize| {
            let mut motion = tumbling(&body);
            let dt = 1.0 / steps as f64;
            for _ in 0..steps {
                motion.drift(&body, 0.5 * dt);
                // A force at a point of the body, along a direction of space that is fixed.
                let (arm, force) = ([0.05, 0.02, -0.03], [0.02, 0.05, -0.01]);
                motion.kick(dt, force, cross(motion.to_space(arm), force));
                motion.drift(&body, 0.5 * dt);
            }
            motion
        };
        let all = |m: RigidMotion| -> Vec<f64> {
            m.position.into_iter().chain(m.attitude).chain(m.angular_momentum.map(|x| 20.0 * x)).collect()
        };
        let reference = all(fly(400_000));
        let errors: Vec<f64> = [500, 1000, 2000].map(|n| off(&all(fly(n)), &reference)).into();
        for pair in errors.windows(2) {
            let order = (pair[0] / pair[1]).log2();
            assert!((order - 2.0).abs() < 0.1, "{errors:?}");
        }
    }

    #[test]
    fn a_symmetric_top_precesses_as_the_closed_form_says() {
        let moments = [2e-3, 2e-3, 3e-3];
        let body = RigidBody { mass: 1.0, centre: [0.0; 3], moments, axes: UNITS, first_pattern: 0 };
        let spin = [3.0, 0.0, 10.0];
        let mut motion = RigidMotion::thrown(&body, [0.0; 3], spin);
        for _ in 0..2000 {
            motion.drift(&body, 5e-4);
        }
        // In the body ω turns about z at (C − A)/A ω_z.
        let angle = (moments[2] - moments[0]) / moments[0] * spin[2];
        let expected = [3.0 * angle.cos(), 3.0 * angle.sin(), 10.0];
        assert!(off(&motion.spin(&body), &expected) < 1e-3, "{:?} {expected:?}", motion.spin(&body));
    }

    #[test]
    fn what_the_rigid_compliance_says_is_what_a_step_does() {
        let body = racket();
        let points = [[0.2, -0.1, 0.3], [0.1, 0.0, 0.2]];
        let mut w = [0.0; 36];
        let dt = 1e-4;
        body.add_compliance(dt, &points, &mut w);
        for d in 0..2 {
            for j in 0..3 {
                let mut motion = RigidMotion::at_rest(&body);
                motion.kick(dt, UNITS[j], cross(minus(points[d], body.centre), UNITS[j]));
                motion.drift(&body, 0.5 * dt);
                for c in 0..2 {
                    let moved = minus(motion.place(&body, points[c], [0.0; 3]), points[c]);
                    let said: [f64; 3] = core::array::from_fn(|i| w[(3 * c + i) * 6 + 3 * d + j]);
                    assert!(off(&moved, &said) < 1e-5 * off(&said, &[0.0; 3]), "{moved:?} {said:?}");
                }
            }
        }
        assert!((0..6).all(|i| (0..6).all(|j| (w[6 * i + j] - w[6 * j + i]).abs() < 1e-18)));
    }

    #[test]
    fn numbers_that_are_no_body_are_none() {
        let own = [2.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 1.0, 1.0];
        let read = |numbers: &[f64], patterns: u32| {
            let bytes: Vec<[u8; 8]> = numbers.iter().map(|x| x.to_le_bytes()).collect();
            RigidBody::read(&bytes, patterns)
        };
        assert_eq!(read(&own, 7).map(|body| (body.mass, body.first_pattern)), Some((2.0, 1)));
        assert_eq!(read(&own, 6), None);
        assert_eq!(read(&own[..10], 7), None);
        for (place, value) in [(0, -1.0), (0, f64::NAN), (4, 0.0), (5, 1e3), (1, f64::INFINITY), (10, 0.5)] {
            let mut wrong = own;
            wrong[place] = value;
            assert_eq!(read(&wrong, 7), None, "{place} {value}");
        }
    }
}
