//! The response to loads exactly in time, in a space that has converged: what errors are measured against.
//!
//! A march at full order has the error of its time scheme, so it cannot judge a motion that has none. Here
//! the space is the only thing that is approximated, and it is made for the loads: it starts from their
//! static answers `K⁻¹F` and grows by `K⁻¹M` (Nour-Omid and Clough 1984, load-dependent Ritz vectors). The
//! pencil projected on it falls apart into modes, and each is moved in closed form
//! ([`Propagator`](vademecum_format::exact::Propagator)), for loads that are linear in time between their
//! jumps and kinks. The motion under them therefore depends on no time step; a step only says when it is
//! looked at. A sinusoid or a chirp is taken as linear over parts of a step, the same parts that the player
//! of a scenario takes, whose chords are within a millionth of its amplitude ([`CHORD`](super::CHORD)).
//!
//! All loads share one space, a block of as many columns as there are independent forces. The same number of
//! vectors in one space per force would cost less to keep orthogonal, but the low modes that all forces
//! excite would be found once for each, and an error against their sum would have to be measured on vectors
//! that are not orthogonal. Natural modes that are known may stand first: they are their own images, so the
//! space grows orthogonal to them as it would for the loads less their part.
//!
//! Dashpots couple the modes of the space. These are moved together then, exactly in time all the same, with
//! the whole damping matrix of the dashpots; the space also starts from the static answers to forces at the
//! dashpots.
//!
//! The convergence of the space is measured: the answer with all of its vectors against the answer with
//! the first two thirds of those that were added. A point force that jumps on a body without damping makes
//! its highest modes ring. Their share falls slowly, and the estimate says so.

mod coupled;
mod distance;
mod motion;
mod solution;
mod space;

pub use distance::{Complement, MarchMeter, MotionPart, ReferenceDistance};
pub use solution::{Decay, ReferenceError, ReferenceOptions, ReferenceSolution, ReferenceTrajectory};

#[cfg(test)]
mod tests;
