//! The residual flexibility and its bound: blocks that store energy, the pairs that the facets ask for,
//! numbers of the bound in order.

use vademecum_format::{File, SectionKind};

use super::super::codec::room;
use super::super::error::{Fault, RewriteError};
use super::super::numbers::{reals_of, unsound};
use super::symmetric::negative_pivot;

/// Four times the rounding of binary32.
pub(super) const ROUNDED: f64 = 1.0 / (1u64 << 22) as f64;

/// Sections 34 to 41, as far as the file has them.
pub(super) fn check(file: &File<'_>) -> Result<(), RewriteError> {
    use SectionKind as S;
    let all = [
        S::ContactResidual,
        S::ResidualPairs,
        S::PairResidual,
        S::ProbeResidual,
        S::PatternResidual,
        S::PatternProbeResidual,
        S::StaticBound,
        S::BoundMap,
    ];
    if let Some(kind) = all.into_iter().find(|&kind| file.section(kind).is_some())
        && !file.metadata().diagonal
    {
        let reason =
            "the residual flexibility belongs to the diagonal structure, which the file does not have";
        return Err(unsound(kind, Fault::Disagrees, reason.into()));
    }
    for (kind, width) in [(S::ContactResidual, 6), (S::BoundMap, 7)] {
        if let Some(rows) = reals_of(file, kind)? {
            blocks(kind, &rows, width)?;
        }
    }
    pairs(file)?;
    bound(file)
}

/// The symmetric 3 × 3 block at the front of each row takes no negative value.
fn blocks(kind: SectionKind, rows: &[f64], width: usize) -> Result<(), RewriteError> {
    for (node, row) in rows.chunks_exact(width).enumerate() {
        let &[xx, xy, xz, yy, yz, zz, ..] = row else { continue };
        let largest = row[..6].iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        let mut block = [xx, xy, xz, xy, yy, yz, xz, yz, zz];
        if negative_pivot(&mut block, 3, |_| ROUNDED * largest).is_some() {
            let reason = format!(
                "the block of node {node} (xx {xx:e}, xy {xy:e}, xz {xz:e}, yy {yy:e}, yz {yz:e}, zz {zz:e}) \
                 takes a negative value; it is positive semidefinite"
            );
            return Err(unsound(kind, Fault::Negative, reason));
        }
    }
    Ok(())
}

/// Ascending pairs of loadable nodes, exactly those that share a loadable facet, each with its block.
fn pairs(file: &File<'_>) -> Result<(), RewriteError> {
    let kind = SectionKind::ResidualPairs;
    let Some(section) = file.section(kind) else {
        return match file.section(SectionKind::PairResidual) {
            None => Ok(()),
            Some(_) => Err(unsound(
                SectionKind::PairResidual,
                Fault::Disagrees,
                "section ResidualPairs, which says whose blocks these are, is missing".into(),
            )),
        };
    };
    let pairs = section.u32s()?.as_chunks::<2>().0;
    let rows = file.section(SectionKind::PairResidual).map_or(0, |blocks| blocks.shape()[0]);
    if rows != pairs.len() as u64 {
        let reason = format!("{} pairs, and {rows} blocks in section PairResidual", pairs.len());
        return Err(unsound(kind, Fault::Disagrees, reason));
    }
    let mut before = None;
    for (place, pair) in pairs.iter().enumerate() {
        let [first, second] = pair.map(u32::from_le_bytes);
        if first >= second || before.is_some_and(|before| before >= [first, second]) {
            let reason = format!(
                "pair {place} is ({first}, {second}); the first is below the second, and pairs ascend"
            );
            return Err(unsound(kind, Fault::Twice, reason));
        }
        before = Some([first, second]);
    }
    let Some(expected) = pairs_of_facets(file)? else { return Ok(()) };
    let found = pairs.iter().map(|pair| pair.map(u32::from_le_bytes));
    if expected.len() == pairs.len() && found.eq(expected.iter().copied()) {
        return Ok(());
    }
    let reason = format!(
        "its {} pairs are not the {} of nodes that share a loadable facet",
        pairs.len(),
        expected.len()
    );
    Err(unsound(kind, Fault::Disagrees, reason))
}

/// Pairs of nodes that share a loadable facet, ascending; `None` of a file without triangles.
fn pairs_of_facets(file: &File<'_>) -> Result<Option<Vec<[u32; 2]>>, RewriteError> {
    let Some(triangles) = file.section(SectionKind::Triangles) else { return Ok(None) };
    let triangles = triangles.u32s()?.as_chunks::<3>().0;
    let facets = file.quadrangles()?;
    let in_quadrangles: usize = facets.iter().map(|facet| facet.nodes().len().pow(2) / 2).sum();
    let mut pairs: Vec<[u32; 2]> = room(in_quadrangles + 3 * triangles.len())?;
    let mut add = |nodes: &[u32]| {
        for (place, &a) in nodes.iter().enumerate() {
            pairs.extend(nodes.iter().take(place).map(|&b| [a.min(b), a.max(b)]));
        }
    };
    let loadable = file.metadata().n_load_triangles;
    for (triangle, nodes) in (0..loadable).zip(triangles) {
        match facets.of_triangle(triangle) {
            Some(facet) if facet.first == triangle => add(facet.nodes()),
            Some(_) => {}
            None => add(&nodes.map(u32::from_le_bytes)),
        }
    }
    pairs.sort_unstable();
    pairs.dedup();
    Ok(Some(pairs))
}

/// The numbers of the bound in order, and the map's largest the worst.
fn bound(file: &File<'_>) -> Result<(), RewriteError> {
    let kind = SectionKind::StaticBound;
    let map = reals_of(file, SectionKind::BoundMap)?;
    let at_nodes = || map.iter().flat_map(|rows| rows.chunks_exact(7).map(|row| row[6]));
    if let Some((node, bound)) = at_nodes().enumerate().find(|(_, bound)| *bound < 0.0) {
        let reason = format!("the relative bound of node {node} is {bound:e}");
        return Err(unsound(SectionKind::BoundMap, Fault::Negative, reason));
    }
    let Some(numbers) = reals_of(file, kind)? else { return Ok(()) };
    let &[rigorous, worst, median, most] = &numbers[..] else { return Ok(()) };
    if rigorous != 0.0 && rigorous != 1.0 {
        let reason = format!("its first number is {rigorous}; 1 stands for a bound, 0 for an estimate");
        return Err(unsound(kind, Fault::Disagrees, reason));
    }
    if !(0.0 <= median && median <= most && most <= worst) {
        let reason = format!(
            "median {median:e}, 95th percentile {most:e}, worst {worst:e}; expected 0 or more, ascending"
        );
        return Err(unsound(kind, Fault::Disagrees, reason));
    }
    let largest = at_nodes().fold(0.0, f64::max);
    if map.is_some() && (largest - worst).abs() > ROUNDED * worst {
        let reason = format!("the worst is {worst:e}, the largest of section BoundMap {largest:e}");
        return Err(unsound(kind, Fault::Disagrees, reason));
    }
    Ok(())
}
