//! The rigid motion of a free body: where it starts, where it is, and how its last step was turned.

use vademecum_eval::{FreeBody, RigidBody, RigidMotion};

use crate::variables::Variable;

/// Numbers of a flight that is kept.
pub const NUMBERS: usize = START + 13 + 4 + 6;
/// Those of the start.
const START: usize = 13;

/// Start and last step of a flight, whose rigid motion the evaluator's body has.
#[derive(Clone, Copy, Debug)]
pub struct Flight {
    /// As it was set before the first step: position, attitude (real part last), velocity, angular velocity.
    start: [f64; START],
    /// Orientation of the body halfway through the last step, in which forces of space acted on it.
    pub turned: RigidMotion,
    /// Its angular velocity before and after that step.
    pub spins: [[f64; 3]; 2],
}

impl Flight {
    /// A start at the body's present motion.
    pub fn new(free: &FreeBody) -> Self {
        let mut flight = Self { start: [0.0; START], turned: *free.motion(), spins: [[0.0; 3]; 2] };
        for (index, place) in (0..).zip(flight.start.iter_mut()) {
            *place = own(free, index);
        }
        flight
    }

    /// Place of a variable among the numbers of a start.
    const fn place(variable: Variable) -> Option<usize> {
        match variable {
            Variable::BodyPosition(c) => Some(c as usize),
            Variable::BodyAttitude(c) => Some(3 + c as usize),
            Variable::BodyVelocity(c) => Some(7 + c as usize),
            Variable::BodySpin(c) => Some(10 + c as usize),
            _ => None,
        }
    }

    /// True at the start of a flight.
    pub const fn is_start(variable: Variable) -> bool {
        Self::place(variable).is_some()
    }

    /// Sets a number of the start, of all of which [`Flight::begin`] makes a motion.
    pub fn set(&mut self, variable: Variable, value: f64) {
        let place = Self::place(variable).and_then(|place| self.start.get_mut(place));
        place.into_iter().for_each(|place| *place = value);
    }

    /// The motion of the start; `None` where the attitude is zero.
    pub fn begin(&self, body: &RigidBody) -> Option<RigidMotion> {
        let [x, y, z, a, b, c, w, u, v, s, p, q, r] = self.start;
        let placed =
            RigidMotion { position: [x, y, z], attitude: [w, a, b, c], ..RigidMotion::at_rest(body) };
        let placed = placed.normalised()?;
        let turning = body.angular_momentum_of(placed.to_body([p, q, r]));
        let motion = RigidMotion {
            momentum: [u, v, s].map(|v| body.mass * v),
            angular_momentum: placed.to_space(turning),
            ..placed
        };
        motion.normalised()
    }

    /// The numbers that are kept.
    pub fn numbers(&self, motion: &RigidMotion) -> [f64; NUMBERS] {
        let mut numbers = [0.0; NUMBERS];
        let RigidMotion { position, attitude, momentum, angular_momentum } = *motion;
        let all = self.start.iter().chain(&position).chain(&attitude).chain(&momentum);
        let all = all.chain(&angular_momentum).chain(&self.turned.attitude).chain(self.spins.as_flattened());
        numbers.iter_mut().zip(all).for_each(|(out, &number)| *out = number);
        numbers
    }

    /// A flight and its motion as they were kept; `None` where a number is not finite, or an attitude zero.
    pub fn restored(numbers: &[f64; NUMBERS]) -> Option<(Self, RigidMotion)> {
        let mut left = numbers.iter().copied();
        let start: [f64; START] = take(&mut left);
        let (position, attitude) = (take(&mut left), take(&mut left));
        let (momentum, angular_momentum) = (take(&mut left), take(&mut left));
        let motion = RigidMotion { position, attitude, momentum, angular_momentum };
        motion.normalised()?;
        // Only its attitude is used: it turns directions.
        let turned = RigidMotion { attitude: take(&mut left), ..motion };
        turned.normalised()?;
        let spins = [take(&mut left), take(&mut left)];
        let finite = start.iter().chain(spins.as_flattened()).all(|number| number.is_finite());
        finite.then_some((Self { start, turned, spins }, motion))
    }
}

/// Value of a variable of the rigid motion.
pub fn value(free: &FreeBody, variable: Variable) -> Option<f64> {
    Some(own(free, Flight::place(variable)?))
}

/// The next numbers.
fn take<const N: usize>(left: &mut impl Iterator<Item = f64>) -> [f64; N] {
    let mut taken = [0.0; N];
    taken.iter_mut().for_each(|out| *out = left.next().unwrap_or_default());
    taken
}

/// Number `index` of a start, as the body is now.
fn own(free: &FreeBody, index: usize) -> f64 {
    let (motion, body) = (free.motion(), free.body());
    let [w, x, y, z] = motion.attitude;
    let velocity = motion.momentum.map(|share| share / body.mass);
    let spin = motion.to_space(motion.spin(body));
    let attitude = [x, y, z, w];
    let mut all = motion.position.iter().chain(&attitude).chain(&velocity).chain(&spin);
    all.nth(index).copied().unwrap_or_default()
}
