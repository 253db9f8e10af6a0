//! A scenario through a file beside the same scenario at full order.
//!
//! A file knows its nodes by their ids in the mesh, so the model of the problem it was built from can be
//! asked for the same loads, the same probes and the norm that errors are measured in.

mod bound_scenario;
mod large;
mod linear;
mod model;

use serde::Serialize;
use vademecum_build::input::Problem;
use vademecum_build::prepared::Prepared;
use vademecum_build::progress::Listener;
use vademecum_eval::StructureChoice;
use vademecum_format::File;

use crate::error::StudyError;
use crate::player::PlayOptions;
use crate::scenario::Scenario;

pub use bound_scenario::{BoundScenario, VerificationRecord};
pub use large::{LargeVerification, verify_large};
pub use linear::{Verification, verify_linear};
pub(crate) use model::full_order_loads;
pub use model::{file_nodes, free_basis};

/// A verification and the series behind it.
pub type AnyVerification = VerificationRecord<Figures>;

/// Figures of either law of motion.
#[derive(Clone, Debug, Serialize)]
#[serde(untagged)]
// One value for a verification.
#[allow(clippy::large_enum_variant)]
pub enum Figures {
    /// Beside the linear motion.
    Linear(Verification),
    /// Beside the motion at large displacements.
    Large(LargeVerification),
}

/// Marches the scenario through the file and at full order, both at the parameters of `options`, and compares
/// them. A problem of large displacements is marched at large displacements, unless `options` ask for the
/// exact structure, which is linear.
///
/// # Errors
/// [`StudyError::TooManySteps`], [`StudyError::Long`], [`StudyError::TooManyLoads`];
/// [`StudyError::Build`]: more than four hours or 2e7 steps of full-order marching, unless they are asked for
/// by `options.long`;
/// [`StudyError::NotFinite`], [`StudyError::Refused`]: a march of the file that ends early;
/// [`StudyError::File`]: a file of another mesh, or one that the evaluator refuses;
/// [`StudyError::NoPattern`], [`StudyError::ForeignPattern`]; a full-order march that fails or is stopped.
pub fn verify(
    file: &File<'_>,
    options: &PlayOptions,
    problem: &Problem,
    prepared: &Prepared,
    scenario: &Scenario,
    listener: &dyn Listener,
) -> Result<AnyVerification, StudyError> {
    let linear = options.chapter || options.scene.structure == StructureChoice::Exact;
    if problem.is_large() && !linear {
        let found = verify_large(file, options, problem, prepared, scenario, listener)?;
        return Ok(found.with(Figures::Large));
    }
    Ok(verify_linear(file, options, problem, prepared, scenario, listener)?.with(Figures::Linear))
}
