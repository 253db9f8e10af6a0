//! What live parameters add to a build: separations repeated until the step is stable, and carriers that grow until they keep the tolerance.

use super::{BuildError, BuildOptions, Built, Context, build};
use crate::parametric::{ParameterSpace, Parametric, SeparationOptions};
use crate::problem::{BasisKind, Problem};
use crate::progress::{Listener, Stopwatch};
use crate::report::{STABLE, SeparationReport};
use vademecum_format::Certificate;

/// The separated solution and its certificate; with `repair`, as often as it takes to make the step stable.
///
/// The stage is Galerkin in its lifted space already (with live regions) or the full-order projection (without), and either is
/// stable as it is: what makes the separated step unstable is what the terms miss. So the repair is more terms.
pub(super) fn separate_and_certify(
    context: &Context<'_>,
    repair: bool,
    watch: &mut Stopwatch<'_>,
) -> Result<(Parametric, Certificate, SeparationReport), BuildError> {
    const MOST_REPAIRS: usize = 4;
    let tolerance = &context.problem.tolerance;
    let mut asked = SeparationOptions { tolerance: tolerance.map, max_terms: tolerance.max_terms };
    let mut repairs = vec![];
    loop {
        let parametric = watch.stage("separate over the parameters", || context.separate(&asked))?;
        let (certificate, mut report) = watch.stage("certificate", || context.certify_box(&parametric))?;
        let radius = certificate.block.spectral_radius;
        if !repair || radius <= STABLE || repairs.len() == MOST_REPAIRS {
            report.repairs = repairs;
            return Ok((parametric, certificate, report));
        }
        let terms = report.terms;
        asked = SeparationOptions {
            tolerance: (0.1 * asked.tolerance).max(1e-11),
            max_terms: 2 * asked.max_terms,
        };
        let done = format!(
            "spectral radius 1{:+.1e} at {} with {terms} terms: separated again to {:.0e}, at most {} terms",
            radius - 1.0,
            report.place(&report.worst_radius_at),
            asked.tolerance,
            asked.max_terms
        );
        context.kept.listener.note(&done);
        repairs.push(done);
    }
}

/// Carrier sizes tried, the smallest first, when live regions turn the eigenvectors and `basis.modes` is left open.
const CARRIER_SIZES: [usize; 4] = [8, 16, 32, 64];

pub(super) fn carrier_size_is_free(problem: &Problem, space: &ParameterSpace) -> bool {
    let open = problem.basis.modes.is_none() && problem.basis.kind != BasisKind::Modes;
    open && space.has_region_parameters()
}

/// Builds with more and more modes until the trajectories keep the tolerance over the box. More modes mend neither maps nor
/// instability: a build that misses in those ends here.
pub(super) fn build_with_growing_carrier(
    problem: &Problem,
    options: &BuildOptions,
    listener: &dyn Listener,
) -> Result<Built, BuildError> {
    let mut missed = None;
    for count in CARRIER_SIZES {
        let mut sized = problem.clone();
        sized.basis.modes = Some(count);
        let last = count == CARRIER_SIZES[CARRIER_SIZES.len() - 1];
        let keep_missed = options.keep_missed && last;
        match build(&sized, &BuildOptions { keep_missed, ..*options }, listener) {
            Err(BuildError::ToleranceMissed(report)) if report.certificate.misses_trajectories_only() => {
                listener.note(&format!("{count} modes do not keep the tolerance over the box"));
                missed = Some(BuildError::ToleranceMissed(report));
            }
            Err(BuildError::TooManyModes { found, .. }) if missed.is_some() => {
                listener.note(&format!("the snapshots span {found} dimensions: no carrier of {count} modes"));
                break;
            }
            ended => return ended,
        }
    }
    Err(missed.expect("the last size either ends the build or misses"))
}
