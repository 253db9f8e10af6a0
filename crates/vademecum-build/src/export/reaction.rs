//! Sections of the reactions.

use vademecum_format::SectionKind as S;

use super::Draft;
use crate::prepared::Support;
use crate::reaction::Reactions;

/// Sections 53 to 57, as far as there is something to keep: double precision, whatever that of the fields, so
/// that reactions and loads are in equilibrium to as many digits.
///
/// Sections 118 and 119 are those of live regions, the first unless all shapes are rigid motions, the second
/// if a `density` is live.
pub(crate) fn reaction_sections(supports: &[Support], reactions: &Reactions, density: bool) -> Vec<Draft> {
    let count = supports.len();
    let r = reactions.basis.first().map_or(0, |rows| rows.ncols());
    let nodes = reactions.nodes.first().map_or(0, Vec::len);
    let basis = reactions.basis.iter().flat_map(|rows| (0..6 * r).map(|k| rows[(k / r, k % r)]));
    let points = supports.iter().flat_map(|support| support.point);
    let mut drafts = vec![
        Draft::names(S::SupportNames, supports.iter().map(|support| support.name.as_str())),
        Draft::f64s(S::SupportPoints, [count, 3, 1], points),
        Draft::f64s(S::ReactionBasis, [count, 6, r], basis),
    ];
    if nodes > 0 {
        let loads = reactions.nodes.iter().flatten().flatten().copied();
        drafts.push(Draft::f64s(S::ReactionLoads, [count, nodes, 18], loads));
    }
    if !reactions.patterns.is_empty() {
        let rows = reactions.patterns.iter().flatten().flatten().copied();
        drafts.push(Draft::f64s(S::PatternReaction, [reactions.patterns.len(), count, 6], rows));
    }
    let of_regions = |kind, place: usize| {
        let rows = reactions.regions.iter().map(|forms| &forms[place]);
        let numbers = rows.flat_map(|rows| (0..6 * r).map(|k| rows[(k / r, k % r)]));
        Draft::f64s(kind, [reactions.regions.len(), 6, r], numbers)
    };
    if !reactions.regions.is_empty() && !reactions.rigid {
        drafts.push(of_regions(S::LiveReactionStiffness, 0));
    }
    if !reactions.regions.is_empty() && density {
        drafts.push(of_regions(S::LiveReactionMass, 1));
    }
    drafts
}
