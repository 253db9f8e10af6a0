//! Stress: points that the body has, as many in every section, and constants of solids.

use vademecum_format::{File, SectionKind};

use super::super::error::{Fault, RewriteError};
use super::super::numbers::{reals_of, unsound};
use super::lines;

/// Sections 47 to 52 and 75, as far as the file has them.
pub(super) fn check(file: &File<'_>) -> Result<(), RewriteError> {
    use SectionKind as S;
    units(file)?;
    let rows = [(S::StressBasis, 0), (S::StressResidual, 0), (S::PatternStress, 1)];
    let Some(points) = file.section(S::StressPoints) else {
        let all = rows.map(|(kind, _)| kind).into_iter();
        let constants = [S::ElasticConstants, S::Compliance];
        let alone = all.chain(constants).find(|&kind| file.section(kind).is_some());
        return alone.map_or(Ok(()), |kind| missing(kind, S::StressPoints));
    };
    if file.section(S::StressBasis).is_none() {
        return missing(S::StressPoints, S::StressBasis);
    }
    match [S::ElasticConstants, S::Compliance].map(|kind| file.section(kind).is_some()) {
        [false, false] => return missing(S::StressPoints, S::ElasticConstants),
        [true, true] => {
            let reason = format!("section {} has the constants of the regions too", S::ElasticConstants);
            return Err(unsound(S::Compliance, Fault::Disagrees, reason));
        }
        _ => {}
    }
    let count = points.shape()[0];
    for (kind, axis) in rows {
        let found = file.section(kind).map_or(count, |section| section.shape()[axis]);
        if found != count {
            let reason = format!("it has {found} points, section StressPoints {count}");
            return Err(unsound(kind, Fault::Disagrees, reason));
        }
    }
    for kind in [S::StressResidual, S::PatternStress] {
        if file.section(kind).is_some() && !file.metadata().diagonal {
            let reason = "it belongs to the residual flexibility of the diagonal structure, which is missing";
            return Err(unsound(kind, Fault::Disagrees, reason.into()));
        }
    }
    let constants = reals_of(file, S::ElasticConstants)?.unwrap_or_default();
    places(points.u32s()?.as_chunks::<2>().0)?;
    for (region, &[young, poisson]) in constants.as_chunks::<2>().0.iter().enumerate() {
        if !(young > 0.0 && poisson > -1.0 && poisson < 0.5) {
            let reason = format!(
                "region {region} has Young's modulus {young:e} Pa and Poisson's ratio {poisson}; expected a positive \
                 modulus and a ratio above −1 and below 0.5"
            );
            return Err(unsound(S::ElasticConstants, Fault::Disagrees, reason));
        }
    }
    let compliance = reals_of(file, S::Compliance)?.unwrap_or_default();
    for (region, triangle) in compliance.as_chunks::<21>().0.iter().enumerate() {
        if !is_positive_definite(triangle) {
            let reason = format!("the compliance of region {region} is not positive definite");
            return Err(unsound(S::Compliance, Fault::Disagrees, reason));
        }
    }
    Ok(())
}

/// True if Cholesky's pivots of a symmetric matrix, given by its upper triangle, are positive.
fn is_positive_definite(triangle: &[f64; 21]) -> bool {
    let (mut rest, mut next) = ([[0.0; 6]; 6], triangle.iter());
    for row in 0..6 {
        for column in row..6 {
            let value = next.next().copied().unwrap_or(f64::NAN);
            (rest[row][column], rest[column][row]) = (value, value);
        }
    }
    for k in 0..6 {
        let pivot = rest[k][k];
        // Written so that a NaN is refused too.
        if !(pivot > 0.0 && pivot.is_finite()) {
            return false;
        }
        for i in k + 1..6 {
            let factor = rest[i][k] / pivot;
            (k..6).for_each(|j| rest[i][j] -= factor * rest[k][j]);
        }
    }
    true
}

fn missing(there: SectionKind, kind: SectionKind) -> Result<(), RewriteError> {
    let reason = format!("section {kind}, which it goes with, is missing");
    Err(unsound(there, Fault::Disagrees, reason))
}

/// Nodes and regions ascend, none twice.
fn places(points: &[[[u8; 4]; 2]]) -> Result<(), RewriteError> {
    let mut before = None;
    for (point, pair) in points.iter().enumerate() {
        let pair = pair.map(u32::from_le_bytes);
        if before.is_some_and(|before| pair <= before) {
            let reason = format!("point {point}, node {} in region {}, does not ascend", pair[0], pair[1]);
            return Err(unsound(SectionKind::StressPoints, Fault::Twice, reason));
        }
        before = Some(pair);
    }
    Ok(())
}

/// A unit for each probe.
fn units(file: &File<'_>) -> Result<(), RewriteError> {
    let kind = SectionKind::ProbeUnits;
    let Some(section) = file.section(kind) else { return Ok(()) };
    let (found, count) = (lines(kind, section.raw()?)?.len(), file.metadata().n_probes);
    if found == count as usize {
        return Ok(());
    }
    let reason = format!("it has {found} units, the metadata count {count} probes");
    Err(RewriteError::Names { kind, reason })
}
