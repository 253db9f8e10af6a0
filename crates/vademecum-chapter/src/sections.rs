//! Sections of the canonical structure.

use vademecum_format::SectionKind as S;

use crate::certificate::ChapterCertificate;
use crate::map::{ChapterMap, MapPart};
use vademecum_build::export::{Draft, NodeOrder};

/// Tables of parts and axes, factors and terms, positions and direction, the certificate.
pub fn sections(map: &ChapterMap, certificate: &ChapterCertificate, order: &NodeOrder) -> Vec<Draft> {
    let parts = || {
        let stages = map.stages.iter().enumerate();
        stages.flat_map(|(stage, s)| s.parts.iter().map(move |part| (stage, part)))
    };
    let table: Vec<u32> = parts()
        .flat_map(|(stage, part)| [stage, part.axes.len(), part.terms.ncols()].map(|x| x as u32))
        .collect();
    let axes: Vec<f64> = parts().flat_map(|(_, part)| part.axes.iter().flat_map(|axis| axis.row())).collect();
    let factors: Vec<f64> = parts().flat_map(|(_, part)| factors(part)).collect();
    let terms: Vec<f64> =
        parts().flat_map(|(_, part)| part.terms.col_iter().flat_map(|f| f.iter().copied())).collect();
    let positions: Vec<u32> = map.positions.iter().map(|&node| order.file_node[node as usize]).collect();
    let numbers = numbers(certificate);
    let r = map.n_modes;
    let mut drafts = vec![
        Draft::u32s(S::CanonicalParts, [table.len() / 3, 3, 1], table),
        Draft::f64s(S::CanonicalAxes, [axes.len() / 6, 6, 1], axes),
        Draft::f64s(S::CanonicalFactors, [factors.len(), 1, 1], factors),
        Draft::f64s(S::CanonicalTerms, [terms.len() / r, r, 1], terms),
        Draft::u32s(S::CanonicalPositions, [positions.len(), 1, 1], positions),
        Draft::f64s(S::CanonicalCertificate, [numbers.len(), 1, 1], numbers),
    ];
    drafts.extend(map.direction.map(|direction| Draft::f64s(S::CanonicalDirection, [3, 1, 1], direction)));
    drafts
}

/// Each axis `(n_points, n_terms)`.
fn factors(part: &MapPart) -> impl Iterator<Item = f64> + '_ {
    part.factors.iter().flat_map(|g| g.row_iter().flat_map(|row| row.iter().copied().collect::<Vec<_>>()))
}

/// The certificate as section 29 has it; numbers that were not measured are NaN in the file, too.
fn numbers(certificate: &ChapterCertificate) -> Vec<f64> {
    let mut numbers = certificate.structure.known().numbers().to_vec();
    numbers.push(certificate.left.map_or(f64::NAN, |(step, _)| step as f64));
    numbers.extend(certificate.stages.iter().flat_map(|e| [e.total, e.state, e.load]));
    // What overflowed was not measured either.
    numbers.iter_mut().filter(|x| x.is_infinite()).for_each(|x| *x = f64::NAN);
    numbers
}
