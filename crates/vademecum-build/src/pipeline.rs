//! The whole build on one page: mesh → model → basis → a road → bytes.
//!
//! A road is a file of this folder and a function from the reduced model to a certified file: [`exact`]
//! (modal superposition), [`staged`] (separated time steps at fixed parameters), [`separated`] (over live
//! parameters), [`large`] (large displacements).

mod chapter;
mod context;
mod error;
mod exact;
mod file;
mod large;
mod plan;
#[cfg(test)]
mod ranks_tests;
mod reduced;
mod separated;
mod staged;

pub use context::{BuildContext, with_context};
pub use error::BuildError;
pub use file::{CertifiedFile, FileStep, encode_file};
pub use large::SHAPES;
pub use reduced::ReducedModel;

use std::sync::Arc;

use crate::basis::BasisError;
use crate::fem::Engine;
use crate::input::{BasisKind, Problem};
use crate::limits::Memory;
use crate::prepared::{FactorPrecision, ParameterSpace};
use crate::progress::{Listener, Stopwatch};
use crate::report::{BuildReport, ToleranceMissed};
use crate::store::Store;

/// What the user may change without changing the problem.
#[derive(Clone, Copy, Debug, Default)]
pub struct BuildOptions<'a> {
    /// Where finished stages are kept and found again; the file is the same with and without.
    pub store: Option<&'a Store>,
    /// Add terms where the fused step is unstable over live parameters; report and file say what was done.
    pub repair: bool,
    /// Do what takes more than four hours, or more than 2e7 full-order steps, too.
    pub long: bool,
    /// Memory that may be used \[bytes\]; absent: what the machine and the limits of the process leave.
    pub memory: Option<u64>,
    /// What factorises and solves with the stiffness, and searches for natural modes; absent: this process.
    pub engine: Option<&'a Arc<dyn Engine>>,
    /// The precision of the factor of the stiffness in this process.
    pub precision: FactorPrecision,
}

impl BuildOptions<'_> {
    fn memory(&self) -> Memory {
        Memory::asked_or_available(self.memory)
    }

    /// The same with the memory that is free now, before the build itself takes of it.
    fn at_the_start(&self) -> Self {
        Self { memory: Some(self.memory().limit()), ..*self }
    }
}

/// A finished build.
pub struct Built {
    /// The file.
    pub bytes: Vec<u8>,
    /// What was done and measured.
    pub report: BuildReport,
}

/// How a build ends.
pub enum Outcome {
    /// A structure of the file keeps the tolerance.
    Kept(Built),
    /// No structure does. The file is whole, and its certificate says by how much it misses.
    Missed(Built),
}

impl Outcome {
    /// The file, if it keeps its tolerance.
    ///
    /// # Errors
    /// [`ToleranceMissed`], with the report of what was built.
    pub fn kept(self) -> Result<Built, ToleranceMissed> {
        match self {
            Self::Kept(built) => Ok(built),
            Self::Missed(built) => Err(ToleranceMissed(Box::new(built.report))),
        }
    }

    /// The file, whether it keeps its tolerance or not.
    pub fn either(self) -> Built {
        match self {
            Self::Kept(built) | Self::Missed(built) => built,
        }
    }
}

/// Runs the whole build. Nothing is written here; the caller has the bytes.
///
/// # Errors
/// [`BuildError`], by stage.
pub fn build(
    problem: &Problem,
    options: &BuildOptions<'_>,
    listener: &dyn Listener,
) -> Result<Outcome, BuildError> {
    with_context(problem, options, listener, |context, watch| {
        let mut missed = None;
        for modes in basis_sizes(problem, &context.prepared.space) {
            let mut sized = problem.clone();
            sized.basis.modes = modes;
            let built = build_sized(context, &sized, watch);
            context.check_engine()?;
            match built {
                Ok(built) if built.report.certificate.holds() => return Ok(Outcome::Kept(built)),
                Ok(built) => {
                    listener.note(&format!("{} modes do not keep the tolerance", built.report.modes));
                    // More modes mend neither maps nor instability.
                    let grow = built.report.certificate.misses_trajectories_only();
                    missed = Some(built);
                    if !grow {
                        break;
                    }
                }
                Err(BuildError::Basis(BasisError::TooManyModes { found, .. })) if missed.is_some() => {
                    listener.note(&format!("the snapshots span {found} dimensions: no larger basis"));
                    break;
                }
                Err(error) => return Err(error),
            }
        }
        Ok(Outcome::Missed(missed.expect("every size ends in a file or in an error")))
    })
}

/// One file, at one size of the basis.
fn build_sized(
    context: &BuildContext<'_>,
    problem: &Problem,
    watch: &mut Stopwatch<'_>,
) -> Result<Built, BuildError> {
    let plan = context.plan(problem)?;
    if problem.is_large() {
        return large::build(context, problem, plan, watch);
    }
    let model = ReducedModel::new(context, problem, &plan, watch)?;
    let certified = if let Some(entry) = problem.chapter() {
        chapter::certified(context, problem, &entry, &model, watch)?
    } else if context.prepared.exact {
        exact::certified(context, problem, &model, watch)?
    } else if context.prepared.space.parameters.is_empty() {
        staged::certified(context, problem, &model, watch)?
    } else {
        separated::certified(context, problem, &model, watch)?
    };
    Ok(certified.reported(context, problem, (&model.basis, model.snapshots), plan, watch))
}

/// Sizes of the basis to try, smallest first: the one asked for, unless live regions turn the eigenvectors
/// and the problem leaves the number open.
fn basis_sizes(problem: &Problem, space: &ParameterSpace) -> Vec<Option<usize>> {
    let asked = problem.basis.modes.is_some() || problem.basis_kind() == BasisKind::Modes;
    let fixed = asked || !space.has_region_parameters();
    if fixed { vec![problem.basis.modes] } else { [8, 16, 32, 64].map(Some).to_vec() }
}
