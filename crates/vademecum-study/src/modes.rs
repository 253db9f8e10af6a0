//! The lowest natural modes of a problem, and the damping that each receives.

use serde::Serialize;
use vademecum_build::dynamics::{lowest_modes, numerical_damping};
use vademecum_build::input::Problem;
use vademecum_build::prepared::{prepare, proposed_time_step};
use vademecum_build::progress::{Listener, Stopwatch};

use crate::error::StudyError;

/// The lowest natural modes of a problem, one number per mode in each list.
#[derive(Clone, Debug, Serialize)]
pub struct NaturalModes {
    /// Free dofs.
    pub dofs: usize,
    /// Step that the scheme's figures belong to \[s\]: the problem's.
    pub time_step: f64,
    /// Step for such a body \[s\]: a round number, with at least 40 steps in the first period.
    pub proposed_time_step: f64,
    /// Frequency \[Hz\], ascending.
    pub frequencies_hz: Vec<f64>,
    /// Relative residual of the eigenvalue problem.
    pub residuals: Vec<f64>,
    /// Damping ratio of the material.
    pub material_damping: Vec<f64>,
    /// Damping ratio that the time scheme adds; absent where the mode does not swing any more.
    pub scheme_damping: Vec<Option<f64>>,
    /// Relative elongation of the period by the time scheme; absent as above.
    pub period_elongation: Vec<Option<f64>>,
}

/// The `count` lowest modes.
///
/// # Errors
/// [`StudyError::Build`]: a problem that cannot be computed with, modes that do not converge.
pub fn natural_modes(
    problem: &Problem,
    count: usize,
    listener: &dyn Listener,
) -> Result<NaturalModes, StudyError> {
    let prepared = prepare(problem, &mut Stopwatch::new(listener), listener)?;
    listener.stage("natural modes");
    let pencil = prepared.body.model.pencil();
    let modes = lowest_modes(pencil, &prepared.symbolic, count)?;
    let frequencies_hz = modes.frequencies_hz();
    let material_damping: Vec<f64> = frequencies_hz
        .iter()
        .enumerate()
        .map(|(k, &f)| prepared.rayleigh().ratio(f) + prepared.ratios.of(k))
        .collect();
    let damping = |(&value, &ratio): (&f64, &f64)| {
        numerical_damping(prepared.file_scheme(), value.sqrt() * prepared.step.time_step, ratio)
    };
    let numerical: Vec<_> = modes.eigenvalues.iter().zip(&material_damping).map(damping).collect();
    let added = numerical.iter().zip(&material_damping).map(|(n, m)| n.ratio.map(|r| r - m));
    Ok(NaturalModes {
        dofs: pencil.n_dof(),
        time_step: prepared.step.time_step,
        proposed_time_step: proposed_time_step(1.0 / frequencies_hz[0]),
        scheme_damping: added.collect(),
        period_elongation: numerical.iter().map(|n| n.period_elongation).collect(),
        frequencies_hz,
        residuals: modes.residuals,
        material_damping,
    })
}
