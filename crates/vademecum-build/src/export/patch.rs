//! Sections of the residual flexibility between near nodes.

use vademecum_format::SectionKind as S;

use super::Draft;
use crate::input::Precision;
use crate::residual::PatchFlexibility;

/// Sections 107 to 110: `distance` is that of contacts which have nothing between them.
pub(crate) fn patch_sections(
    found: &PatchFlexibility,
    pairs: &[[u32; 2]],
    nodes: usize,
    distance: f64,
    precision: Precision,
) -> Vec<Draft> {
    let (n, m) = (pairs.len(), found.n_modes);
    let mut drafts = vec![
        Draft::u32s(S::PatchPairs, [n, 2, 1], pairs.iter().flatten().copied()),
        Draft::fitting(S::PatchResidual, precision, [n, 9, 1], found.blocks.as_flattened()),
        Draft::f64s(S::ContactPatch, [1, 1, 1], [distance]),
    ];
    if m > 0 {
        drafts.push(Draft::fitting(S::ContactModes, precision, [nodes, 3, m], &found.modes));
    }
    drafts
}
