//! MSH 4.1: entities carry the physical groups, nodes and elements come in blocks per entity.

use std::collections::{HashMap, HashSet};

use super::cells::{cell_kind, reorder};
use crate::mesh::error::MeshError;
use crate::mesh::raw::{CellKind, NodeIndex, RawMesh};
use crate::mesh::rows::RowReader;

/// Numbers by which the sections of a file refer to each other.
#[derive(Default)]
pub(crate) struct EntityTable {
    /// Physical tags by dimension and entity tag.
    physical: HashMap<(usize, i64), Vec<i64>>,
    /// Tags of the bounding entities (one dimension lower) by dimension and entity tag.
    boundary: HashMap<(usize, i64), Vec<i64>>,
    /// Dimension and tag of the entity of each node.
    node_entity: Vec<(usize, i64)>,
    /// Node indices by number.
    pub(crate) index: NodeIndex,
}

const HEADER: &str = "four counts: points, curves, surfaces, volumes";

/// `$Entities`: only the physical tags are wanted.
pub(crate) fn entities(rows: &mut RowReader<'_>, model: &mut EntityTable) -> Result<(), MeshError> {
    for (dimension, count) in counts(rows)?.into_iter().enumerate() {
        for _ in 0..count {
            const EXPECTED: &str = "an entity: tag, position or bounds, physical tags, boundary tags";
            rows.begin(EXPECTED)?;
            let tag = rows.int(EXPECTED)?;
            entity(rows, model, dimension, tag, EXPECTED)?;
        }
    }
    Ok(())
}

/// `$PartitionedEntities`: like `$Entities`, with parents and partitions before the bounds.
pub(crate) fn partitioned(rows: &mut RowReader<'_>, model: &mut EntityTable) -> Result<(), MeshError> {
    const PARTITIONS: &str = "the number of partitions";
    rows.begin(PARTITIONS)?;
    rows.size(PARTITIONS)?;
    rows.end(PARTITIONS)?;
    const GHOSTS: &str = "ghost entities: count, then pairs of tag and partition";
    rows.begin(GHOSTS)?;
    let ghosts = rows.size(GHOSTS)?;
    for _ in 0..rows.text.bounded(ghosts, 4, "ghost entities")? {
        rows.begin_if_line_ended(GHOSTS)?;
        rows.int(GHOSTS)?;
        rows.int(GHOSTS)?;
    }
    rows.end(GHOSTS)?;
    for (dimension, count) in counts(rows)?.into_iter().enumerate() {
        for _ in 0..count {
            const EXPECTED: &str = "a partitioned entity: tag, parent, partitions, bounds, tags";
            rows.begin(EXPECTED)?;
            let tag = rows.int(EXPECTED)?;
            rows.int(EXPECTED)?;
            rows.int(EXPECTED)?;
            integers(rows, EXPECTED)?;
            entity(rows, model, dimension, tag, EXPECTED)?;
        }
    }
    Ok(())
}

fn counts(rows: &mut RowReader<'_>) -> Result<[usize; 4], MeshError> {
    rows.begin(HEADER)?;
    let mut out = [0; 4];
    for count in &mut out {
        let declared = rows.size(HEADER)?;
        *count = rows.text.bounded(declared, 8, "entities")?;
    }
    rows.end(HEADER)?;
    Ok(out)
}

fn entity(
    rows: &mut RowReader<'_>,
    model: &mut EntityTable,
    dimension: usize,
    tag: i64,
    expected: &str,
) -> Result<(), MeshError> {
    for _ in 0..if dimension == 0 { 3 } else { 6 } {
        rows.real(expected)?;
    }
    let physical = integers(rows, expected)?.iter().map(|t| t.saturating_abs()).collect();
    if dimension > 0 && !rows.line_is_empty() {
        // The sign of a bounding tag is its orientation.
        let bounding = integers(rows, expected)?.iter().map(|t| t.saturating_abs()).collect();
        model.boundary.insert((dimension, tag), bounding);
    }
    rows.end(expected)?;
    model.physical.insert((dimension, tag), physical);
    Ok(())
}

/// A count and that many integers.
fn integers(rows: &mut RowReader<'_>, expected: &str) -> Result<Vec<i64>, MeshError> {
    let count = rows.size(expected)?;
    let count = rows.text.bounded(count, if rows.is_binary() { 4 } else { 1 }, "tags")?;
    (0..count).map(|_| rows.int(expected)).collect()
}

/// The header of `$Nodes` and `$Elements`: blocks, entries, least and largest tag.
fn block_header(rows: &mut RowReader<'_>, what: &str) -> Result<[u64; 4], MeshError> {
    let expected = format!("four numbers: blocks, {what}, least and largest {what} tag");
    rows.begin(&expected)?;
    let header = [rows.size(&expected)?, rows.size(&expected)?, rows.size(&expected)?, rows.size(&expected)?];
    rows.end(&expected)?;
    rows.text.bounded(header[0], 8, "blocks")?;
    rows.text.bounded(header[1], 2, what)?;
    Ok(header)
}

pub(crate) fn nodes(
    rows: &mut RowReader<'_>,
    raw: &mut RawMesh,
    model: &mut EntityTable,
) -> Result<(), MeshError> {
    let [blocks, total, least, largest] = block_header(rows, "node")?;
    let header_place = rows.text.place();
    for _ in 0..blocks {
        node_block(rows, raw, model)?;
    }
    let mut at = rows.text.at();
    at.place = header_place;
    if raw.nodes.len() as u64 != total {
        return Err(at.malformed(
            format!("a total of {total} nodes"),
            format!("{}, the blocks' sum", raw.nodes.len()),
        ));
    }
    let range = (raw.node_ids.iter().min().copied(), raw.node_ids.iter().max().copied());
    if let (Some(low), Some(high)) = range
        && (low, high) != (least, largest)
    {
        let expected = format!("{low} to {high}, the tags the blocks hold");
        return Err(at.malformed(format!("node tags {least} to {largest}"), expected));
    }
    Ok(())
}

fn node_block(rows: &mut RowReader<'_>, raw: &mut RawMesh, model: &mut EntityTable) -> Result<(), MeshError> {
    const BLOCK: &str = "a node block: dimension, entity, parametric, count";
    rows.begin(BLOCK)?;
    let dimension = rows.int(BLOCK)?;
    let entity = rows.int(BLOCK)?;
    let parametric = rows.int(BLOCK)?;
    let count = rows.size(BLOCK)?;
    rows.end(BLOCK)?;
    if !(0..=3).contains(&dimension) || !(0..=1).contains(&parametric) {
        let found = format!("dimension {dimension}, parametric {parametric}");
        return Err(rows.text.at().malformed(found, "dimension 0 to 3, parametric 0 or 1"));
    }
    let count = rows.text.bounded(count, 2, "nodes")?;
    let first = raw.nodes.len();
    for _ in 0..count {
        rows.begin("a node tag")?;
        let id = rows.size("a node tag alone on its line")?;
        rows.end("a node tag alone on its line")?;
        model.index.insert(id, raw.node_ids.len(), &rows.text.at())?;
        model.node_entity.push((dimension as usize, entity));
        raw.node_ids.push(id);
    }
    for i in first..first + count {
        let expected = format!("x y z of node {}", raw.node_ids[i]);
        rows.begin(&expected)?;
        raw.nodes.push(rows.point(&expected)?);
        for _ in 0..dimension * parametric {
            rows.real(&expected)?;
        }
        rows.end(&expected)?;
    }
    Ok(())
}

pub(crate) fn elements(
    rows: &mut RowReader<'_>,
    raw: &mut RawMesh,
    model: &EntityTable,
) -> Result<(), MeshError> {
    let [blocks, total, ..] = block_header(rows, "element")?;
    let header_place = rows.text.place();
    let mut read = 0;
    for _ in 0..blocks {
        read += element_block(rows, raw, model)?;
    }
    if read != total {
        let mut at = rows.text.at();
        at.place = header_place;
        return Err(at.malformed(format!("a total of {total} elements"), format!("{read}, the blocks' sum")));
    }
    Ok(())
}

fn element_block(rows: &mut RowReader<'_>, raw: &mut RawMesh, model: &EntityTable) -> Result<u64, MeshError> {
    const BLOCK: &str = "an element block: dimension, entity, type, count";
    rows.begin(BLOCK)?;
    let dimension = rows.int(BLOCK)?;
    let entity = rows.int(BLOCK)?;
    let code = rows.int(BLOCK)?;
    let count = rows.size(BLOCK)?;
    rows.end(BLOCK)?;
    let kind = cell_kind(code).ok_or_else(|| {
        let found = format!("{count} elements of type {code}");
        rows.text.at().unsupported(found, "a type of up to quadratic tetrahedra", "mesh with tetrahedra")
    })?;
    if dimension != kind.dimension() as i64 {
        let found = format!("element type {code} in dimension {dimension}");
        return Err(rows.text.at().malformed(found, format!("dimension {}", kind.dimension())));
    }
    let count = rows.text.bounded(count, 2 * (1 + kind.node_count()), "elements")?;
    let none = Vec::new();
    let tags = model.physical.get(&(kind.dimension(), entity)).unwrap_or(&none);
    for _ in 0..count {
        element(rows, raw, model, kind, tags)?;
    }
    Ok(count as u64)
}

fn element(
    rows: &mut RowReader<'_>,
    raw: &mut RawMesh,
    model: &EntityTable,
    kind: CellKind,
    tags: &[i64],
) -> Result<(), MeshError> {
    let expected = "an element: its tag and its nodes";
    rows.begin(expected)?;
    rows.size(expected)?;
    let mut nodes = Vec::with_capacity(kind.node_count());
    for _ in 0..kind.node_count() {
        let id = rows.size(expected)?;
        nodes.push(model.index.find(id, &rows.text.at())?);
    }
    rows.end(expected)?;
    reorder(kind, &mut nodes);
    raw.push(kind, &nodes, tags, rows.text.place());
    Ok(())
}

/// Groups that were named, but of which no element was saved: their nodes are those on their entities and on
/// what bounds these.
pub(crate) fn groups_without_elements(raw: &mut RawMesh, model: &EntityTable) {
    let missing: Vec<(usize, i64, String)> = raw.missing_groups();
    for (dimension, tag, name) in missing {
        let with_tag = model.physical.iter().filter(|(e, tags)| e.0 == dimension && tags.contains(&tag));
        let mut open: Vec<(usize, i64)> = with_tag.map(|(entity, _)| *entity).collect();
        let mut closure = HashSet::new();
        while let Some(entity) = open.pop() {
            if closure.insert(entity) {
                let bounding = model.boundary.get(&entity).into_iter().flatten();
                open.extend(bounding.map(|&tag| (entity.0.saturating_sub(1), tag)));
            }
        }
        let on = |e: &(usize, i64)| closure.contains(e);
        let nodes: Vec<u32> =
            model.node_entity.iter().zip(0..).filter(|(e, _)| on(e)).map(|(_, node)| node).collect();
        if nodes.is_empty() {
            raw.notes.push(format!("group `{name}` is named, but the file has no element of it"));
        } else {
            raw.notes.push(format!("group `{name}` has no elements, its nodes were taken from the geometry"));
            raw.node_groups.entry(name).or_default().extend(nodes);
        }
    }
}
