//! TetGen: the pair `NAME.node` and `NAME.ele`, numbered from 0 or 1.

use std::path::Path;

use super::error::MeshError;
use super::kind::{EDGES, ElementKind};
use super::load::load;
use super::raw::{CellKind, NodeIndex, RawMesh};
use super::text::{ParsedNumber, Text, tokens};
use crate::linalg::vec3::{dot, sub};

/// Reads both files, whichever of them `path` is.
pub(crate) fn parse(path: &Path) -> Result<RawMesh, MeshError> {
    let (node_path, element_path) = (path.with_extension("node"), path.with_extension("ele"));
    let node_bytes = load(&node_path)?;
    let element_bytes = load(&element_path)?;
    parse_pair(&node_path, &node_bytes, &element_path, &element_bytes)
}

/// The same for content at hand.
pub(crate) fn parse_pair(
    node_path: &Path,
    node_bytes: &[u8],
    element_path: &Path,
    element_bytes: &[u8],
) -> Result<RawMesh, MeshError> {
    let mut raw = RawMesh::new(node_path, "TetGen .node and .ele");
    let mut index = NodeIndex::default();
    nodes(&mut Text::new(node_path, node_bytes), &mut raw, &mut index)?;
    elements(&mut Text::new(element_path, element_bytes), &mut raw, &index)?;
    raw.name_regions();
    Ok(raw)
}

/// The next line that is not a comment, without a trailing one.
fn row<'a>(text: &mut Text<'a>, expected: &str) -> Result<&'a [u8], MeshError> {
    loop {
        let line = text.line(expected)?;
        let content = line.split(|&b| b == b'#').next().unwrap_or(b"").trim_ascii();
        if !content.is_empty() {
            return Ok(content);
        }
    }
}

fn nodes(text: &mut Text<'_>, raw: &mut RawMesh, index: &mut NodeIndex) -> Result<(), MeshError> {
    const HEADER: &str = "point count, dimension 3, attribute count, 0 or 1 for markers";
    text.section = "the .node file".into();
    let line = row(text, HEADER)?;
    let [count, dimension, attributes, marked] = text.exactly::<u64, 4>(line, HEADER)?;
    if dimension != 3 || marked > 1 || attributes > 1000 {
        return Err(text.malformed(line, HEADER));
    }
    for _ in 0..text.bounded(count, 7, "points")? {
        const EXPECTED: &str = "a point: number, x, y, z, attributes, marker";
        let line = row(text, EXPECTED)?;
        let words: Vec<&[u8]> = tokens(line).collect();
        if words.len() as u64 != 4 + attributes + marked {
            return Err(text.malformed(line, EXPECTED));
        }
        let fault = || text.malformed(line, EXPECTED);
        let id = u64::parse(words[0]).ok_or_else(fault)?;
        let mut point = [0.0; 3];
        for (x, word) in point.iter_mut().zip(&words[1..]) {
            *x = f64::parse(word).ok_or_else(fault)?;
        }
        if marked == 1 {
            let marker = i64::parse(words[words.len() - 1]).ok_or_else(fault)?;
            if marker != 0 {
                let group = raw.node_groups.entry(format!("marker {marker}")).or_default();
                group.push(raw.nodes.len() as u32);
            }
        }
        index.insert(id, raw.nodes.len(), &text.at())?;
        raw.nodes.push(point);
        raw.node_ids.push(id);
    }
    Ok(())
}

fn elements(text: &mut Text<'_>, raw: &mut RawMesh, index: &NodeIndex) -> Result<(), MeshError> {
    const HEADER: &str = "tetrahedron count, 4 or 10 nodes, 0 or 1 for regions";
    text.section = "the .ele file".into();
    let line = row(text, HEADER)?;
    let [count, per, attributes] = text.exactly::<u64, 3>(line, HEADER)?;
    if !matches!(per, 4 | 10) || attributes > 1000 {
        return Err(text.malformed(line, HEADER));
    }
    for _ in 0..text.bounded(count, 9, "tetrahedra")? {
        const EXPECTED: &str = "a tetrahedron: number, nodes, region";
        let line = row(text, EXPECTED)?;
        let words: Vec<&[u8]> = tokens(line).collect();
        if words.len() as u64 != 1 + per + attributes {
            return Err(text.malformed(line, EXPECTED));
        }
        let mut nodes = Vec::with_capacity(10);
        for word in &words[1..1 + per as usize] {
            let id = u64::parse(word).ok_or_else(|| text.malformed(line, EXPECTED))?;
            nodes.push(index.find(id, &text.at())?);
        }
        // Region attributes are reals in TetGen, mostly whole numbers.
        let region = match words.get(1 + per as usize) {
            Some(word) => f64::parse(word).ok_or_else(|| text.malformed(line, EXPECTED))? as i64,
            None => 0,
        };
        let kind = CellKind::Solid(if per == 4 { ElementKind::Tet4 } else { ElementKind::Tet10 });
        if per == 10 && !sort_mid_nodes(&raw.nodes, &mut nodes) {
            let remedy = "TetGen places them on straight edges: write the file again";
            let expected = "mid-side nodes in the middles of the six edges";
            return Err(text.at().unsupported("a mid-side node elsewhere", expected, remedy));
        }
        raw.push(kind, &nodes, &[region], text.place());
    }
    Ok(())
}

/// Versions of TetGen number mid-side nodes differently, but always put them on straight edges: place each by
/// position.
fn sort_mid_nodes(points: &[[f64; 3]], nodes: &mut [u32]) -> bool {
    let given: Vec<u32> = nodes[4..].to_vec();
    for (edge, [a, b]) in EDGES.into_iter().enumerate() {
        let (p, q) = (points[nodes[a] as usize], points[nodes[b] as usize]);
        let middle: [f64; 3] = std::array::from_fn(|k| 0.5 * (p[k] + q[k]));
        let distance = |n: u32| {
            let d = sub(points[n as usize], middle);
            dot(d, d)
        };
        let Some(nearest) = given.iter().copied().min_by(|&m, &n| distance(m).total_cmp(&distance(n))) else {
            return false;
        };
        nodes[4 + edge] = nearest;
    }
    let mut placed = nodes[4..].to_vec();
    placed.sort_unstable();
    placed.dedup();
    placed.len() == 6
}
