//! Thresholds of accuracy and stability, for builder and evaluator alike.
//!
//! The builder judges a file by these rules before it writes it, and the evaluator judges by the same rules
//! when it chooses between the structures of a file. A problem file may ask other tolerances of its build
//! (`[tolerance]` in `formats/problem-1.md`); the evaluator still chooses by these.

/// A trajectory may err by this many times the projection floor. The floor is what the basis cannot show of
/// the full-order trajectory, so no structure on that basis does better.
pub const FLOOR_RATIO: f64 = 1.1;

/// Allowed error of a trajectory besides [`FLOOR_RATIO`] times the floor, relative to that of full order,
/// so that a basis with a floor near 0 does not have to be matched to rounding.
pub const ABSOLUTE_ERROR: f64 = 1e-6;

/// Largest spectral radius of a step that counts as stable: 1, and what an eigenvalue at 1 gains by rounding.
pub const STABLE_RADIUS: f64 = 1.0 + 1e-12;

/// The error that is accepted on a basis of this projection floor, both relative: [`FLOOR_RATIO`] times the
/// floor plus [`ABSOLUTE_ERROR`].
///
/// ```
/// use vademecum_format::policy::allowed_error;
///
/// assert_eq!(allowed_error(0.0), 1e-6);
/// assert_eq!(allowed_error(1e-3), 1.1 * 1e-3 + 1e-6);
/// ```
#[must_use]
pub fn allowed_error(floor: f64) -> f64 {
    FLOOR_RATIO * floor + ABSOLUTE_ERROR
}
