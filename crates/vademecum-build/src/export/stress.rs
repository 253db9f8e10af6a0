//! Sections of the stress.

use faer::MatRef;
use vademecum_format::SectionKind as S;

use super::{Draft, NodeOrder};
use crate::fem::{COMPONENTS, DofMap, Material, StressPoint, StressRows};
use crate::input::Precision;
use crate::residual::StressFlexibility;

/// The points of a body in the order of the file: by node, then by region.
pub(crate) fn stress_order(points: &[StressPoint], order: &NodeOrder) -> Vec<StressPoint> {
    let mut points = points.to_vec();
    points.sort_by_key(|point| (order.file_node[point.node as usize], point.region));
    points
}

/// Sections 47 to 51.
pub(crate) fn stress_sections(
    rows: &StressRows,
    residual: Option<&StressFlexibility>,
    vectors: MatRef<'_, f64>,
    (order, dofs, materials): (&NodeOrder, &DofMap, &[Material]),
    precision: Precision,
) -> Vec<Draft> {
    let (n, r) = (rows.points.len(), vectors.ncols());
    let points = rows.points.iter().flat_map(|p| [order.file_node[p.node as usize], p.region]);
    let mut basis = vec![0.0; n * COMPONENTS * r];
    for (row, out) in rows.rows.iter().zip(basis.chunks_exact_mut((COMPONENTS * r).max(1))) {
        for (node, block) in row {
            let components =
                (0..3).flat_map(|c| dofs.terms(3 * *node as usize + c).map(move |term| (c, term)));
            for (c, (free, weight)) in components {
                for (k, component) in block.iter().enumerate() {
                    let (share, out) =
                        (weight * component[c], out[k * r..(k + 1) * r].iter_mut().enumerate());
                    out.for_each(|(mode, sum)| *sum += share * vectors[(free as usize, mode)]);
                }
            }
        }
    }
    let constants = materials.iter().flat_map(|material| [material.young, material.poisson]);
    let mut drafts = vec![
        Draft::u32s(S::StressPoints, [n, 2, 1], points),
        Draft::fitting(S::StressBasis, precision, [n, COMPONENTS, r], &basis),
        Draft::f64s(S::ElasticConstants, [materials.len(), 2, 1], constants),
    ];
    let Some(StressFlexibility { contacts, patterns }) = residual else { return drafts };
    if let Some(first) = contacts.first() {
        let shape = [n, first.len(), 3 * COMPONENTS];
        let values = contacts.concat();
        drafts.push(Draft::fitting(S::StressResidual, precision, shape, values.as_flattened()));
    }
    if !patterns.is_empty() {
        let values = patterns.concat();
        let shape = [patterns.len(), n, COMPONENTS];
        drafts.push(Draft::f64s(S::PatternStress, shape, values.as_flattened().iter().copied()));
    }
    drafts
}
