//! Checks of live parameters: sections that go together, parameters with a range and a role of their own,
//! matrices that sum to those as built, terms of nodes and regions that there are.

use vademecum_format::{File, LiveError, SectionKind as S};

use super::super::error::{Fault, RewriteError};
use super::super::numbers::{reals_of, unsound};

/// Largest difference of the sum of the matrices from that as built, relative to its largest number.
const SUM: f64 = 1e-9;

/// Sections 111 to 122, if the file has any of them.
pub(super) fn check(file: &File<'_>) -> Result<(), RewriteError> {
    let needed = [S::LiveParameters, S::LiveNames, S::LiveStiffness, S::LiveRegions];
    let of_supports = [S::LiveReactionStiffness, S::LiveReactionMass];
    let others =
        [S::LiveMass, S::LiveResidual, S::LiveCertificate, S::LiveWitnesses, S::LiveLoss, S::LiveDampers];
    let mut all = needed.into_iter().chain(others).chain(of_supports);
    let Some(there) = all.find(|kind| file.section(*kind).is_some()) else { return Ok(()) };
    if let Some(missing) = needed.into_iter().find(|kind| file.section(*kind).is_none()) {
        let reason = format!("without section {} ({missing}) no parameter is live", missing.number());
        return Err(unsound(there, Fault::Disagrees, reason));
    }
    if !file.metadata().diagonal {
        let reason = "it belongs to the diagonal structure, which the file does not have";
        return Err(unsound(there, Fault::Disagrees, reason.into()));
    }
    let live = match file.live_parameters() {
        Ok(Some(live)) => live,
        Ok(None) => return Ok(()),
        Err(LiveError::Format(error)) => return Err(error.into()),
        Err(error) => return Err(unsound(S::LiveParameters, Fault::Disagrees, error.to_string())),
    };
    let eigenvalues = reals_of(file, S::Eigenvalues)?.unwrap_or_default();
    sums(file, S::LiveStiffness, &eigenvalues)?;
    sums(file, S::LiveMass, &vec![1.0; eigenvalues.len()])?;
    let supports = file.section(S::ReactionBasis).map_or(0, |section| section.shape()[0]);
    for section in of_supports.into_iter().filter_map(|kind| file.section(kind)) {
        let (found, expected) = (section.shape()[0], supports * (1 + live.n_regions as u64));
        if found != expected || found == 0 {
            let reason =
                format!("it has {found} rows; {supports} supports and the live regions have {expected}");
            return Err(unsound(section.kind(), Fault::Disagrees, reason));
        }
    }
    if file.section(S::LiveLoss).is_some() && file.section(S::DampingRatios).is_none() {
        let reason = "loss factors decide damping ratios (section 33), which the file does not have";
        return Err(unsound(S::LiveLoss, Fault::Disagrees, reason.into()));
    }
    let rows = file.section(S::DampingRows).map_or(0, |section| section.shape()[0]);
    if file.section(S::LiveDampers).is_some_and(|section| section.shape()[0] != rows) {
        let reason = format!("it names the groups of {} dashpots; section 79 has {rows}", live.dampers.len());
        return Err(unsound(S::LiveDampers, Fault::Disagrees, reason));
    }
    let (nodes, regions) = (f64::from(file.metadata().n_load_nodes), live.n_regions as f64);
    for (place, term) in live.residual.iter().enumerate() {
        let [node, first, second, share, weight] = term.map(f64::from_le_bytes);
        let is_index = |x: f64, most: f64| x.fract() == 0.0 && (0.0..=most).contains(&x);
        let known =
            is_index(node, nodes - 1.0) && is_index(first, regions + 1.0) && is_index(second, regions + 1.0);
        if !known || !(0.0..=1.0).contains(&share) || weight < 0.0 {
            let reason =
                format!("term {place}: a node, two live regions, a share of 0 to 1 and a weight from 0");
            return Err(unsound(S::LiveResidual, Fault::Disagrees, reason));
        }
    }
    Ok(())
}

/// Matrices of the regions sum to a diagonal one.
fn sums(file: &File<'_>, kind: S, diagonal: &[f64]) -> Result<(), RewriteError> {
    let Some(numbers) = reals_of(file, kind)? else { return Ok(()) };
    let r = diagonal.len();
    let mut sum = vec![0.0; r * (r + 1) / 2];
    for matrix in numbers.chunks_exact(sum.len().max(1)) {
        sum.iter_mut().zip(matrix).for_each(|(sum, own)| *sum += own);
    }
    let largest = diagonal.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    let mut sum = sum.into_iter();
    for i in 0..r {
        for j in 0..=i {
            let expected = if i == j { diagonal[i] } else { 0.0 };
            let found = sum.next().unwrap_or(f64::NAN);
            if (found - expected).abs().max(0.0) > SUM * largest || found.is_nan() {
                let reason =
                    format!("regions sum to {found} in row {i}, column {j}; as built it is {expected}");
                return Err(unsound(kind, Fault::Disagrees, reason));
            }
        }
    }
    Ok(())
}
