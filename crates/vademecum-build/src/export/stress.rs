//! Sections of the stress.

use faer::MatRef;
use vademecum_format::SectionKind as S;

use super::{Draft, NodeOrder};
use crate::fem::{COMPONENTS, DofMap, Elasticity, Material, StressPoint, StressRows};
use crate::input::Precision;
use crate::residual::StressFlexibility;

/// The points of a body in the order of the file: by node, then by region.
pub(crate) fn stress_order(points: &[StressPoint], order: &NodeOrder) -> Vec<StressPoint> {
    let mut points = points.to_vec();
    points.sort_by_key(|point| (order.file_node[point.node as usize], point.region));
    points
}

/// Section 51, or 75 where a region is not isotropic.
fn constants(materials: &[Material]) -> Draft {
    let isotropic = |material: &Material| match material.elasticity {
        Elasticity::Isotropic { young, poisson } => Some([young, poisson]),
        Elasticity::Anisotropic(_) => None,
    };
    let n = materials.len();
    if let Some(constants) = materials.iter().map(isotropic).collect::<Option<Vec<_>>>() {
        return Draft::f64s(S::ElasticConstants, [n, 2, 1], constants.into_iter().flatten());
    }
    let triangle = |material: &Material| {
        let compliance = material.elasticity.compliance().expect("the model has checked its materials");
        (0..6).flat_map(move |i| (i..6).map(move |j| compliance[i][j]))
    };
    Draft::f64s(S::Compliance, [n, 21, 1], materials.iter().flat_map(triangle))
}

/// Sections 47 to 51, and 75.
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
    let mut drafts = vec![
        Draft::u32s(S::StressPoints, [n, 2, 1], points),
        Draft::fitting(S::StressBasis, precision, [n, COMPONENTS, r], &basis),
        constants(materials),
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
