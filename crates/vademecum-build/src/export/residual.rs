//! Sections of the residual flexibility and its bound.

use vademecum_format::SectionKind as S;

use super::Draft;
use crate::input::Precision;
use crate::residual::ResidualFlexibility;

/// Sections 34 to 41, as far as there is something to keep.
pub(crate) fn residual_sections(residual: &ResidualFlexibility, precision: Precision) -> Vec<Draft> {
    let (nodes, pairs) = (residual.contact.len(), residual.pairs.len());
    let (probes, patterns) = (residual.probes.len(), residual.patterns.len());
    let bound = &residual.bound;
    let of_bound = [f64::from(u8::from(bound.rigorous)), bound.worst, bound.median, bound.most];
    let map = residual.gram.iter().zip(&residual.at_nodes);
    let map: Vec<f64> = map.flat_map(|(gram, &bound)| gram.iter().copied().chain([bound])).collect();
    let mut drafts = vec![
        Draft::fitting(S::ContactResidual, precision, [nodes, 6, 1], residual.contact.as_flattened()),
        Draft::f64s(S::StaticBound, [4, 1, 1], of_bound),
        Draft::fitting(S::BoundMap, precision, [nodes, 7, 1], &map),
    ];
    if pairs > 0 {
        let indices = residual.pairs.iter().flatten().copied();
        drafts.push(Draft::u32s(S::ResidualPairs, [pairs, 2, 1], indices));
        let blocks = residual.pair_blocks.as_flattened();
        drafts.push(Draft::fitting(S::PairResidual, precision, [pairs, 9, 1], blocks));
    }
    if probes > 0 {
        let rows = residual.probes.concat();
        drafts.push(Draft::fitting(S::ProbeResidual, precision, [probes, nodes, 3], rows.as_flattened()));
    }
    if patterns > 0 {
        let rows = residual.patterns.concat();
        drafts.push(Draft::fitting(S::PatternResidual, precision, [patterns, nodes, 3], rows.as_flattened()));
    }
    if patterns > 0 && probes > 0 {
        let values = residual.pattern_probes.concat();
        drafts.push(Draft::f64s(S::PatternProbeResidual, [patterns, probes, 1], values));
    }
    drafts
}
