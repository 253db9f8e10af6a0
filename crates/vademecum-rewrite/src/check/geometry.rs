//! Checks of nodes and triangles: finite coordinates, unique ids, a surface.

use vademecum_format::{File, Section, SectionKind};

use super::super::codec::room;
use super::super::error::{Fault, RewriteError};
use super::super::numbers::unsound;

/// Largest coordinate \[m\]: its square is finite in binary32, in which pages and games compute.
const LARGEST_COORDINATE: f64 = (1u64 << 63) as f64;

/// Nodes, their ids and the triangles, as far as the file has them.
pub(super) fn check(file: &File<'_>) -> Result<(), RewriteError> {
    use SectionKind as S;
    if let Some(section) = file.section(S::NodeIds) {
        node_ids(&section)?;
    }
    if let Some(section) = file.section(S::Triangles) {
        triangles(&section)?;
    }
    check_coordinates(file)?;
    match (file.section(S::NodeCoordinates), file.section(S::Triangles)) {
        (Some(nodes), Some(corners)) => area(&nodes, &corners),
        _ => Ok(()),
    }
}

/// Coordinates of nodes that one can compute with: finite, not past 2⁶³ m, and, where there is a surface, not
/// all the same. A file without coordinates passes.
///
/// # Errors
/// [`RewriteError::NotFinite`], [`RewriteError::Unsound`]; [`RewriteError::Format`] for a section that is not
/// raw.
pub fn check_coordinates(file: &File<'_>) -> Result<(), RewriteError> {
    let kind = SectionKind::NodeCoordinates;
    let Some(section) = file.section(kind) else { return Ok(()) };
    let numbers = section.numbers()?;
    let first = [0, 1, 2].map(|c| numbers.get(c));
    let mut differ = false;
    for (place, value) in numbers.iter().enumerate() {
        if !value.is_finite() {
            return Err(RewriteError::NotFinite { kind, place, value });
        }
        if value.abs() > LARGEST_COORDINATE {
            let (node, axis) = (place / 3, ["x", "y", "z"][place % 3]);
            let reason = format!(
                "{axis} of node {node} is {value:e} m; coordinates are at most {LARGEST_COORDINATE:e}, so that \
                 their squares are finite in single precision"
            );
            return Err(unsound(kind, Fault::Magnitude, reason));
        }
        differ |= Some(value) != first[place % 3];
    }
    if differ || file.metadata().n_triangles == 0 {
        return Ok(());
    }
    let reason = format!("all {} nodes lie at one place, and they have a surface", file.metadata().n_nodes);
    Err(unsound(kind, Fault::Twice, reason))
}

/// No id belongs to two nodes.
fn node_ids(section: &Section<'_>) -> Result<(), RewriteError> {
    let ids = section.u64s()?;
    let mut sorted: Vec<u64> = room(ids.len())?;
    sorted.extend(ids.iter().map(|&id| u64::from_le_bytes(id)));
    sorted.sort_unstable();
    let Some(pair) = sorted.windows(2).find(|pair| pair[0] == pair[1]) else { return Ok(()) };
    let mut places = ids.iter().enumerate().filter(|(_, id)| u64::from_le_bytes(**id) == pair[0]);
    let mut place = || places.next().map_or(0, |(place, _)| place);
    let reason = format!("nodes {} and {} both have the id {}", place(), place(), pair[0]);
    Err(unsound(SectionKind::NodeIds, Fault::Twice, reason))
}

/// Triangles are made of three different nodes, and none is there twice.
fn triangles(section: &Section<'_>) -> Result<(), RewriteError> {
    let kind = SectionKind::Triangles;
    let all = section.u32s()?.as_chunks::<3>().0;
    let mut sorted: Vec<([u32; 3], u32)> = room(all.len())?;
    for (place, &triangle) in all.iter().enumerate() {
        let mut nodes = triangle.map(u32::from_le_bytes);
        nodes.sort_unstable();
        if nodes[0] == nodes[1] || nodes[1] == nodes[2] {
            let reason = format!("triangle {place} has node {} twice; it takes three nodes", nodes[1]);
            return Err(unsound(kind, Fault::Twice, reason));
        }
        sorted.push((nodes, place as u32));
    }
    sorted.sort_unstable();
    match sorted.windows(2).find(|pair| pair[0].0 == pair[1].0) {
        None => Ok(()),
        Some(pair) => {
            let reason = format!("triangles {} and {} have the same three nodes", pair[0].1, pair[1].1);
            Err(unsound(kind, Fault::Twice, reason))
        }
    }
}

/// A surface has an area: nodes on one line make none.
fn area(nodes: &Section<'_>, corners: &Section<'_>) -> Result<(), RewriteError> {
    let numbers = nodes.numbers()?;
    let node = |node: [u8; 4]| {
        let at = 3 * u32::from_le_bytes(node) as usize;
        [0, 1, 2].map(|c| numbers.get(at + c).unwrap_or(0.0))
    };
    let has_area = |triangle: &[[u8; 4]; 3]| {
        let [a, b, c] = triangle.map(node);
        let (u, v) = ([0, 1, 2].map(|i| b[i] - a[i]), [0, 1, 2].map(|i| c[i] - a[i]));
        (0..3).any(|i| u[i] * v[(i + 1) % 3] != u[(i + 1) % 3] * v[i])
    };
    let all = corners.u32s()?.as_chunks::<3>().0;
    if all.is_empty() || all.iter().any(has_area) {
        return Ok(());
    }
    let reason = format!("the nodes of each of the {} triangles lie on one line", all.len());
    Err(unsound(SectionKind::NodeCoordinates, Fault::Twice, reason))
}
