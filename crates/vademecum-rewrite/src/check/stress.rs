//! Stress: points that the body has, as many in every section, and constants of a solid.

use vademecum_format::{File, SectionKind};

use super::super::error::{Fault, RewriteError};
use super::super::numbers::{reals_of, unsound};
use super::lines;

/// Sections 47 to 52, as far as the file has them.
pub(super) fn check(file: &File<'_>) -> Result<(), RewriteError> {
    use SectionKind as S;
    units(file)?;
    let rows = [(S::StressBasis, 0), (S::StressResidual, 0), (S::PatternStress, 1)];
    let Some(points) = file.section(S::StressPoints) else {
        let all = rows.map(|(kind, _)| kind).into_iter();
        let alone = all.chain([S::ElasticConstants]).find(|&kind| file.section(kind).is_some());
        return alone.map_or(Ok(()), |kind| missing(kind, S::StressPoints));
    };
    for kind in [S::StressBasis, S::ElasticConstants] {
        if file.section(kind).is_none() {
            return missing(S::StressPoints, kind);
        }
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
    Ok(())
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
