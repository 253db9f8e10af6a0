//! The strain structure: sections that go together, and numbers that a strain map can have.

use vademecum_format::{File, SectionKind};

use super::super::error::{Fault, RewriteError};
use super::super::numbers::{reals_of, unsound};

/// Sections 60 to 66, as far as the file has them. Their shapes have been checked on opening.
pub(super) fn check(file: &File<'_>) -> Result<(), RewriteError> {
    use SectionKind as S;
    let refused = |kind, fault, reason: String| Err(unsound(kind, fault, reason));
    let own =
        [S::StrainLinear, S::StrainTail, S::StrainQuadratic, S::StrainBox, S::StrainLimits, S::StrainModes];
    let Some(sizes) = file.strain_sizes()? else {
        let alone = own.into_iter().find(|&kind| file.section(kind).is_some());
        return alone.map_or(Ok(()), |kind| missing(kind, S::StrainSizes));
    };
    if let Some(kind) = [S::RigidBody, S::BaseFrame].into_iter().find(|&kind| file.section(kind).is_some()) {
        let reason = "large displacements are those of a body whose supports stand still";
        return refused(kind, Fault::Disagrees, reason.into());
    }
    let linear = reals_of(file, S::StrainLinear)?.unwrap_or_default();
    let leading = sizes.leading();
    for (row, numbers) in linear.chunks_exact(leading.max(1)).enumerate().take(leading) {
        // A row without linear part would leave a coordinate that nothing holds at rest.
        if numbers.iter().all(|&x| x == 0.0) {
            let reason =
                format!("row {row} has no linear part; expected one in each of the first {leading} rows");
            return refused(S::StrainLinear, Fault::Dependent, reason);
        }
    }
    let tail = reals_of(file, S::StrainTail)?.unwrap_or_default();
    if let Some((place, omega)) = tail.iter().enumerate().find(|(_, omega)| **omega <= 0.0) {
        let reason = format!("frequency {place} is {omega:e}; expected a positive number");
        return refused(S::StrainTail, Fault::Negative, reason);
    }
    let modes = reals_of(file, S::StrainModes)?.unwrap_or_default();
    if let Some((place, omega)) = modes.iter().enumerate().find(|(_, omega)| **omega < 0.0) {
        let reason = format!("natural frequency {place} is {omega:e}; expected a positive number or 0");
        return refused(S::StrainModes, Fault::Negative, reason);
    }
    match [S::StrainBox, S::StrainLimits].map(|kind| file.section(kind).is_some()) {
        [true, false] => return missing(S::StrainBox, S::StrainLimits),
        [false, true] => return missing(S::StrainLimits, S::StrainBox),
        _ => {}
    }
    let limits = reals_of(file, S::StrainLimits)?.unwrap_or_default();
    if let Some((place, limit)) = limits.iter().enumerate().find(|(_, limit)| **limit <= 0.0) {
        let reason = format!("limit {place} is {limit:e}; expected a positive number");
        return refused(S::StrainLimits, Fault::Negative, reason);
    }
    Ok(())
}

fn missing(there: SectionKind, kind: SectionKind) -> Result<(), RewriteError> {
    let reason = format!("section {kind}, which it goes with, is missing");
    Err(unsound(there, Fault::Disagrees, reason))
}
