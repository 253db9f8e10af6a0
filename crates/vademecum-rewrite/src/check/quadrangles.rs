//! Checks of the quadrangular facets: each has triangles of its own, made of its nodes, and all of its nodes
//! are corners of these.

use vademecum_format::{File, SectionKind};

use super::super::error::{Fault, RewriteError};
use super::super::numbers::unsound;

/// Numbers of nodes that a facet may have.
const NODES: [usize; 3] = [4, 8, 9];

pub(super) fn check(file: &File<'_>) -> Result<(), RewriteError> {
    let kind = SectionKind::Quadrangles;
    let disagrees = |reason| unsound(kind, Fault::Disagrees, reason);
    let facets = file.quadrangles()?;
    if facets.is_empty() {
        return Ok(());
    }
    let Some(triangles) = file.section(SectionKind::Triangles) else {
        return Err(disagrees("section Triangles, by which its facets are found, is missing".into()));
    };
    let triangles = triangles.u32s()?.as_chunks::<3>().0;
    let mut end = 0;
    for (index, facet) in facets.iter().enumerate() {
        let (first, count, nodes) = (facet.first as usize, facet.count as usize, facet.nodes());
        if first < end || count == 0 {
            let reason = format!(
                "facet {index} has {count} triangles from {first} on; each has some, \
                 behind {end} of those before"
            );
            return Err(disagrees(reason));
        }
        end = first + count;
        let all: Vec<u32> = facets.numbers(index).into_iter().flatten().collect();
        let behind = all.iter().skip(nodes.len()).any(|&node| node != u32::MAX);
        if !NODES.contains(&nodes.len()) || behind {
            return Err(disagrees(format!(
                "facet {index} has the nodes {all:?}; expected four, eight or nine"
            )));
        }
        let mut corners: Vec<u32> = vec![];
        for triangle in triangles.iter().skip(first).take(count) {
            corners.extend(triangle.iter().map(|&node| u32::from_le_bytes(node)));
        }
        let mut sorted = nodes.to_vec();
        for list in [&mut corners, &mut sorted] {
            list.sort_unstable();
        }
        corners.dedup();
        if corners != sorted {
            let reason = format!(
                "facet {index} has the nodes {nodes:?}, each once; those of its triangles are {corners:?}"
            );
            return Err(disagrees(reason));
        }
    }
    Ok(())
}
