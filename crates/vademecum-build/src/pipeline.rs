//! The whole build on one page: mesh → model → basis → a road → bytes.
//!
//! A road is a file of this folder and a function from the reduced model to a certified file: `exact`
//! (modal superposition), `staged` (separated time steps at fixed parameters), `separated` (over live
//! parameters), `parametric` (a parametric reduced-order model of live regions), `large` (large
//! displacements).

mod context;
mod error;
mod exact;
mod file;
mod large;
mod options;
mod outcome;
mod over_box;
mod parametric;
mod patch;
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
pub use options::BuildOptions;
pub use outcome::{Built, Outcome};
pub use reduced::ReducedModel;

use faer::MatRef;

use crate::basis::BasisError;
use crate::input::{BasisKind, Problem};
use crate::prepared::Prepared;
use crate::progress::{Listener, Stopwatch};

/// Runs the whole build. Nothing is written here; the caller has the bytes.
///
/// # Errors
/// [`BuildError`], by stage; [`BuildError::OtherCrate`] for the chapter's representation.
pub fn build(
    problem: &Problem,
    options: &BuildOptions<'_>,
    listener: &dyn Listener,
) -> Result<Outcome, BuildError> {
    if problem.chapter().is_some() {
        return Err(BuildError::OtherCrate);
    }
    with_context(problem, options, listener, |context, watch| {
        let mut missed = None;
        note_separated(context, problem);
        for modes in basis_sizes(problem, context.prepared) {
            let mut sized = problem.clone();
            sized.basis.modes = modes;
            let built = build_sized(context, &sized, watch);
            context.check_engine()?;
            match built {
                Ok(built) if built.report.certificate.holds() => return Ok(Outcome::Kept(built)),
                Ok(built) => {
                    listener.note(&format!("{} modes do not keep the tolerance", built.report.modes));
                    // More modes improve neither maps nor instability.
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

/// Tells why the time step is separated over live regions.
fn note_separated(context: &BuildContext<'_>, problem: &Problem) {
    if let Some(by) = problem.separated_by().filter(|_| context.prepared.space.has_region_parameters()) {
        context.kept.listener.note(&format!(
            "live regions: the time step is separated over their factors, because of {by}; without it a \
             parametric reduced-order model is built, with exact steps"
        ));
    }
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
    if context.prepared.is_parametric(problem) {
        return parametric::build(context, problem, plan, watch);
    }
    let mut model = ReducedModel::new(context, problem, &plan, watch)?;
    context.estimate_mesh_error(natural_modes(context, problem, &model), watch)?;
    if !context.prepared.exact {
        model.add_residual(context, problem, watch)?;
    }
    let certified = if context.prepared.exact {
        exact::certified(context, problem, &mut model, watch)?
    } else if context.prepared.space.parameters.is_empty() {
        staged::certified(context, problem, &model, watch)?
    } else {
        separated::certified(context, problem, &model, watch)?
    };
    Ok(certified.reported(context, problem, (&model.basis, model.snapshots), plan, watch))
}

/// The natural modes of the body, where the basis is made of them.
fn natural_modes<'m>(
    context: &BuildContext<'_>,
    problem: &Problem,
    model: &'m ReducedModel,
) -> Option<(&'m [f64], MatRef<'m, f64>)> {
    let natural = problem.basis_kind() == BasisKind::Modes && !context.prepared.space.has_region_parameters();
    let eigenvalues = model.basis.eigenvalues.as_deref().filter(|_| natural)?;
    Some((eigenvalues, model.basis.vectors.as_ref()))
}

/// Sizes of the basis to try, smallest first: the one asked for, unless live regions turn the eigenvectors
/// and the problem leaves the number open.
fn basis_sizes(problem: &Problem, prepared: &Prepared) -> Vec<Option<usize>> {
    let asked = problem.basis.modes.is_some() || problem.basis_kind() == BasisKind::Modes;
    let fixed = asked || problem.is_parametric() || !prepared.space.has_region_parameters();
    if fixed { vec![problem.basis.modes] } else { [8, 16, 32, 64].map(Some).to_vec() }
}
