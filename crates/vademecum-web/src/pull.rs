//! The hand of a page: a spring with a damper between a point that the pointer leads and a point of a member.
//!
//! The force is that at the end of the step, held over it, with the Delassus operator `W` of the point:
//!
//! ```text
//! f = k (target − x) − c (x − x₀)/Δt,   x = x_free + W f   ⇒   (1/K + W) f = X − x_free,
//! K = k + c/Δt,   X = (k target + c/Δt x₀)/K
//! ```
//!
//! so no stiffness makes the step unstable.

use vademecum_eval::{Field, LoadError, Member, Place, RigidBody, RigidMotion, StepError};

use crate::refusal::Refusal;
use crate::vectors::{Vector, minus, plus, times};

/// The held place of a member.
#[derive(Clone, Copy, Debug)]
pub enum Grip {
    /// A place of a body of a file.
    Place(Place),
    /// A point of a rigid body, in its own coordinates \[m\].
    Point(Vector),
}

/// A hand on a member.
#[derive(Clone, Copy, Debug)]
pub struct Pull {
    /// Number of the member.
    pub member: usize,
    /// The place that it holds.
    pub grip: Grip,
    /// Place of the hand in space \[m\].
    pub target: Vector,
    /// Stiffness \[N/m\].
    pub stiffness: f64,
    /// Damping \[N s/m\].
    pub damping: f64,
    /// Force of the last step in space \[N\].
    pub force: Vector,
}

/// Rigid motion of a member, and the centre that its position is of.
pub(crate) fn motion_of(member: &Member<'_, '_, f64>) -> (RigidMotion, Vector) {
    match member {
        Member::Held(_, pose) => {
            let (position, attitude) = (pose.position(), pose.attitude());
            let still = RigidMotion { position, attitude, momentum: [0.0; 3], angular_momentum: [0.0; 3] };
            (still, [0.0; 3])
        }
        Member::Free(body) => {
            let centre = body.rigid_body().map_or([0.0; 3], |rigid| rigid.centre);
            let still = RigidMotion {
                position: centre,
                attitude: [1.0, 0.0, 0.0, 0.0],
                momentum: [0.0; 3],
                angular_momentum: [0.0; 3],
            };
            (body.motion().copied().unwrap_or(still), centre)
        }
        Member::Rigid(shape) => (*shape.motion(), shape.body().map_or([0.0; 3], |body| body.centre)),
    }
}

/// A point of a body in space.
pub(crate) fn placed((motion, centre): &(RigidMotion, Vector), point: Vector) -> Vector {
    plus(motion.position, motion.to_space(minus(point, *centre)))
}

impl Pull {
    /// Place of the held point in space \[m\].
    ///
    /// # Errors
    /// [`Refusal`]: a place that the member has not.
    pub fn at(&self, member: &Member<'_, '_, f64>) -> Result<Vector, Refusal> {
        let moved = match (member, &self.grip) {
            (Member::Held(body, _) | Member::Free(body), Grip::Place(place)) => {
                plus(body.position(place)?, body.point(place, Field::Displacement)?)
            }
            (_, Grip::Point(point)) => *point,
            (Member::Rigid(_), Grip::Place(_)) => return Err(Refusal::BadPull),
        };
        Ok(placed(&motion_of(member), moved))
    }

    /// Pulls the member over the coming step of `time` \[s\].
    ///
    /// # Errors
    /// [`Refusal`]: a place that the member has not.
    pub fn act(&mut self, member: &mut Member<'_, '_, f64>, time: f64) -> Result<(), Refusal> {
        let now = self.at(member)?;
        let rigid = match member {
            Member::Free(body) => body.rigid_body(),
            Member::Rigid(shape) => shape.body().copied(),
            Member::Held(..) => None,
        };
        let (mut ahead, centre) = motion_of(member);
        if let Some(rigid) = &rigid {
            ahead.drift(rigid, time);
        }
        let mut w = [0.0; 9];
        let (rest, free) = match (&mut *member, &self.grip) {
            (Member::Held(body, _) | Member::Free(body), Grip::Place(place)) => {
                body.compliance(&[*place], &mut w)?;
                let mut free = [[0.0; 3]];
                body.free_motion(&[*place], &mut free)?;
                (body.position(place)?, free[0])
            }
            (_, Grip::Point(point)) => (*point, [0.0; 3]),
            (Member::Rigid(_), Grip::Place(_)) => return Err(Refusal::BadPull),
        };
        if let Some(rigid) = &rigid {
            rigid.add_compliance(time, &[rest], &mut w);
        }
        let free = placed(&(ahead, centre), plus(rest, free));
        let slow = self.damping / time;
        let both = self.stiffness + slow;
        let goal = times(1.0 / both, plus(times(self.stiffness, self.target), times(slow, now)));
        for diagonal in [0, 4, 8] {
            w[diagonal] += 1.0 / both;
        }
        let force = solved(&w, ahead.to_body(minus(goal, free))).ok_or(StepError::NotFinite)?;
        self.force = ahead.to_space(force);
        match (member, &self.grip) {
            (Member::Held(body, _), Grip::Place(place)) => body.push(place, force)?,
            (Member::Free(body), Grip::Place(place)) => body.push(place, self.force)?,
            (Member::Rigid(shape), _) => shape.push(now, self.force),
            (Member::Held(..) | Member::Free(_), Grip::Point(_)) => return Err(LoadError::Mismatch.into()),
        }
        Ok(())
    }
}

/// Solution of a symmetric positive definite system of three, by elimination.
fn solved(w: &[f64; 9], b: Vector) -> Option<Vector> {
    let [a, b_, c, _, d, e, _, _, f] = *w;
    let (l, m) = (b_ / a, c / a);
    let (d, e) = (d - l * b_, e - l * c);
    let n = e / d;
    let f = f - m * c - n * e;
    let y = b[1] - l * b[0];
    let z = (b[2] - m * b[0] - n * y) / f;
    let y = y / d - n * z;
    let x = b[0] / a - l * y - m * z;
    let all = [x, y, z];
    all.iter().all(|x| x.is_finite()).then_some(all)
}

/// Velocity of the centre \[m/s\] and angular velocity in space \[rad/s\] as the momenta of a body.
pub(crate) fn thrown(
    mut motion: RigidMotion,
    body: &RigidBody,
    velocity: Vector,
    spin: Vector,
) -> RigidMotion {
    motion.momentum = times(body.mass, velocity);
    motion.angular_momentum = motion.to_space(body.angular_momentum_of(motion.to_body(spin)));
    motion
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_equations_are_solved() {
        let w = [4.0, 1.0, -1.0, 1.0, 3.0, 0.5, -1.0, 0.5, 2.0];
        let x = [1.0, -2.0, 3.0];
        let b = core::array::from_fn(|i| (0..3).map(|j| w[3 * i + j] * x[j]).sum());
        let found = solved(&w, b).expect("a solution");
        assert!(found.iter().zip(x).all(|(a, b)| (a - b).abs() < 1e-14), "{found:?}");
        assert!(solved(&[0.0; 9], x).is_none());
    }
}
