//! Reactions: as many supports in every section, named one by one, and a force that stays is held whole.

use vademecum_format::{File, SectionKind};

use super::super::error::{Fault, RewriteError};
use super::super::numbers::{reals_of, unsound};
use super::names::check_names;

/// Tolerance for rounding in the sum over all supports.
const ROUNDED: f64 = 1e-8;

/// Sections 53 to 57, as far as the file has them.
pub(super) fn check(file: &File<'_>) -> Result<(), RewriteError> {
    use SectionKind as S;
    let all = [S::SupportNames, S::SupportPoints, S::ReactionBasis, S::ReactionLoads, S::PatternReaction];
    let Some(first) = all.into_iter().find(|&kind| file.section(kind).is_some()) else { return Ok(()) };
    if !file.metadata().diagonal {
        let reason = "reactions belong to the diagonal structure, which the file does not have";
        return Err(unsound(first, Fault::Disagrees, reason.into()));
    }
    let Some(basis) = file.section(S::ReactionBasis) else {
        let reason = "section ReactionBasis, which counts the supports, is missing";
        return Err(unsound(first, Fault::Disagrees, reason.into()));
    };
    let count = basis.shape()[0];
    for (kind, axis) in [(S::SupportPoints, 0), (S::ReactionLoads, 0), (S::PatternReaction, 1)] {
        let Some(section) = file.section(kind) else { continue };
        let found = section.shape()[axis];
        if found != count {
            let reason = format!("it has {found} supports, section ReactionBasis {count}");
            return Err(unsound(kind, Fault::Disagrees, reason));
        }
    }
    if file.metadata().n_patterns > 0 && file.section(S::PatternReaction).is_none() {
        let reason = "section PatternReaction, which says how load patterns are held, is missing";
        return Err(unsound(S::ReactionBasis, Fault::Disagrees, reason.into()));
    }
    let kind = S::SupportNames;
    match file.section(kind) {
        Some(names) => check_names(kind, names.raw()?, u32::try_from(count).unwrap_or(u32::MAX))?,
        None => return Err(unsound(kind, Fault::Disagrees, "the names of the supports are missing".into())),
    }
    match file.section(S::SupportPoints) {
        Some(_) => held(file, count as usize),
        None => Err(unsound(S::SupportPoints, Fault::Disagrees, "the points of moments are missing".into())),
    }
}

/// A unit force at a loadable node and what all supports exert under it are in equilibrium.
fn held(file: &File<'_>, count: usize) -> Result<(), RewriteError> {
    let kind = SectionKind::ReactionLoads;
    let (Some(rows), Some(points), Some(nodes)) = (
        reals_of(file, kind)?,
        reals_of(file, SectionKind::SupportPoints)?,
        reals_of(file, SectionKind::NodeCoordinates)?,
    ) else {
        return Ok(());
    };
    let n = file.metadata().n_load_nodes as usize;
    for (node, at) in nodes.as_chunks::<3>().0.iter().enumerate().take(n) {
        for c in 0..3 {
            let mut force: [f64; 3] = std::array::from_fn(|i| if i == c { 1.0 } else { 0.0 });
            let mut moment = [0.0; 3];
            let (mut size, mut arm) = (1.0f64, 0.0f64);
            for (support, point) in points.as_chunks::<3>().0.iter().enumerate().take(count) {
                let part = |i: usize| rows[(support * n + node) * 18 + 3 * i + c];
                let from: [f64; 3] = std::array::from_fn(|i| point[i] - at[i]);
                let (f, turn) = ([part(0), part(1), part(2)], [part(3), part(4), part(5)]);
                let about = [
                    from[1] * f[2] - from[2] * f[1],
                    from[2] * f[0] - from[0] * f[2],
                    from[0] * f[1] - from[1] * f[0],
                ];
                for i in 0..3 {
                    force[i] += f[i];
                    moment[i] += turn[i] + about[i];
                    size = size.max(f[i].abs());
                    // A node's place may be rounded to single precision.
                    arm = arm.max(turn[i].abs()).max(from[i].abs() * size).max(at[i].abs());
                }
            }
            let apart = |x: [f64; 3]| x.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
            if apart(force) > ROUNDED * size || apart(moment) > 1e-6 * arm {
                let reason = format!(
                    "under a unit force along axis {c} at node {node} the supports leave a force of {:e} N and a \
                     moment of {:e} N m; expected none",
                    apart(force),
                    apart(moment)
                );
                return Err(unsound(kind, Fault::Disagrees, reason));
            }
        }
    }
    Ok(())
}
