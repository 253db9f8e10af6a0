//! The scenario of most cells: build the problem, read its certificate, march the file in both precisions.

use vademecum_build::basis::BasisError;
use vademecum_build::certificate::StructureReport;
use vademecum_build::dynamics::ModesError;
use vademecum_build::fem::ModelError;
use vademecum_build::input::Problem;
use vademecum_build::pipeline::{BuildError, BuildOptions, Built, build};
use vademecum_build::prepared::{BodyError, PrepareError};
use vademecum_build::progress::Silent;
use vademecum_build::report::{BuildReport, ToleranceMissed};
use vademecum_eval::StructureChoice;

use super::{Form, Measured, Outcome};
use crate::long_march::precision;

/// Builds; or how the build was refused. A cell is judged by its floor and its stability: few modes on a
/// small body err by more than a file may by default, which is not what the matrix asks.
///
/// # Errors
/// [`Outcome::Refused`] with what was measured, [`Outcome::Wrong`].
pub fn build_kept(problem: &Problem) -> Result<Built, Outcome> {
    let mut problem = problem.clone();
    problem.tolerance.error = 1.0;
    let outcome = build(&problem, &BuildOptions::default(), &Silent).map_err(|error| refused(&error))?;
    outcome.kept().map_err(|ToleranceMissed(report)| {
        let measured = structures(&report).into_iter().map(|(_, measured)| measured).collect();
        Outcome::Refused("tolerance missed".into(), measured)
    })
}

/// Builds, and measures what was built.
pub fn certified(problem: &Problem, form: Form) -> Outcome {
    let built = match build_kept(problem) {
        Ok(built) => built,
        Err(refused) => return refused,
    };
    let steps = form.pick(10_000, 200_000);
    let measured = structures(&built.report).into_iter().map(|(choice, measured)| {
        let apart = precision(&built.bytes, choice, steps);
        Measured { single: apart.held.max(apart.released), ..measured }
    });
    Outcome::Ran(measured.collect())
}

/// The certificate of each structure of a report.
pub fn structures(report: &BuildReport) -> Vec<(StructureChoice, Measured)> {
    let c = &report.certificate;
    let measured = |structure, s: &StructureReport| Measured {
        spectral_radius: s.spectral_radius,
        energy: s.energy_ratio,
        error: s.trajectory_error,
        floor: s.projection_floor,
        allowed: c.floor_ratio * s.projection_floor + c.absolute,
        ..Measured::of(structure)
    };
    let diagonal = c.diagonal.as_ref().map(|s| (StructureChoice::Diagonal, measured("diagonal", s)));
    let block = c.block.as_ref().map(|s| (StructureChoice::Block, measured("block", s)));
    diagonal.into_iter().chain(block).collect()
}

/// A refusal, by its name without its numbers, with what the build had measured.
pub fn refused(error: &BuildError) -> Outcome {
    let name = match error {
        BuildError::Prepare(PrepareError::Body(BodyError::Model {
            source: ModelError::Unsupported { .. },
            ..
        })) => "unsupported",
        BuildError::Basis(BasisError::TooManyModes { .. }) => "more modes than the snapshots span",
        BuildError::Modes(ModesError::LostInRounding { .. })
        | BuildError::Basis(BasisError::Modes(ModesError::LostInRounding { .. })) => "lost in rounding",
        BuildError::Modes(ModesError::Count { .. })
        | BuildError::Basis(BasisError::Modes(ModesError::Count { .. })) => "more modes than dofs",
        other => return Outcome::Wrong(format!("{other:?}")),
    };
    Outcome::Refused(name.into(), vec![])
}
