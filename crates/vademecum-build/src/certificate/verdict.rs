//! What was measured of a structure, and whether it keeps a tolerance.

use vademecum_format::StructureCertificate;
use vademecum_format::policy::STABLE_RADIUS;

use super::endurance::Measured;
use crate::dynamics::TrajectoryError;

/// A structure's certificate as a report shows it.
#[derive(Clone, Copy, Debug, serde::Serialize)]
pub struct StructureReport {
    /// Relative L2 error over all dofs and steps, mass norm.
    pub trajectory_error: f64,
    /// The same of the projection of the full-order trajectory.
    pub projection_floor: f64,
    /// Error ÷ floor.
    pub floor_ratio: f64,
    /// Of the fused step.
    pub spectral_radius: f64,
    /// Largest energy of a free run over the energy at its start.
    pub energy_ratio: f64,
    /// Relative error of the stage maps at fresh points, root mean square (of the solve alone at fixed
    /// parameters).
    pub map_error_rms: f64,
    /// The same at the worst point.
    pub map_error_max: f64,
    /// Steps of the march behind the errors.
    pub steps: f64,
}

impl StructureReport {
    /// From what the file holds.
    pub fn new(c: &StructureCertificate) -> Self {
        Self {
            trajectory_error: c.trajectory_error,
            projection_floor: c.projection_floor,
            floor_ratio: c.trajectory_error / c.projection_floor,
            spectral_radius: c.spectral_radius,
            energy_ratio: c.energy_ratio,
            map_error_rms: c.map_error_rms,
            map_error_max: c.map_error_max,
            steps: c.steps,
        }
    }

    /// Steps for which the trajectory keeps a tolerance, estimated from this one march, which is why it is no
    /// condition of a build: 0 where the march missed it, infinite where nothing was seen beyond the floor.
    pub fn good_for_steps(&self, floor_ratio: f64, absolute: f64) -> f64 {
        let Self { steps, trajectory_error: error, projection_floor: floor, .. } = *self;
        Measured { steps, error, floor, floor_ratio, absolute }.good_for_steps()
    }

    /// Whether the stage maps keep a tolerance; an error that is not a number does not.
    pub(crate) fn maps_keep(&self, tolerance: f64) -> bool {
        self.map_error_rms <= tolerance && self.map_error_max <= 10.0 * tolerance
    }

    /// Whether the trajectories keep a tolerance and the step is stable.
    pub(crate) fn keeps(&self, floor_ratio: f64, absolute: f64) -> bool {
        let accurate = self.trajectory_error <= floor_ratio * self.projection_floor + absolute;
        accurate && self.spectral_radius <= STABLE_RADIUS && self.energy_ratio <= BOUNDED
    }
}

/// Largest energy of a free run over the energy at its start. A stable step decays; between, the energy of
/// `Bζ` may swing a little where the full-order field is not quite `Bζ` (live regions).
pub const BOUNDED: f64 = 1.05;

/// The trajectory farthest above its floor.
pub(crate) fn worst(errors: &[TrajectoryError]) -> TrajectoryError {
    let excess = |e: &TrajectoryError| e.error / e.floor.max(f64::MIN_POSITIVE);
    errors.iter().copied().max_by(|a, b| excess(a).total_cmp(&excess(b))).expect("there are trajectories")
}
