//! Gmsh 1.0 and MSH 2: one flat list of nodes, one of elements with their tags.

use std::path::Path;

use super::cells::{cell_kind, reorder};
use crate::mesh::error::MeshError;
use crate::mesh::raw::{CellKind, NodeIndex, RawMesh};
use crate::mesh::rows::RowReader;
use crate::mesh::text::Text;

const NODE: &str = "a node: number, x, y, z";
const COUNT: &str = "the number of entries alone on its line";

/// Gmsh 1.0: `$NOD … $ENDNOD`, `$ELM … $ENDELM`.
pub(crate) fn parse_version_1(file: &Path, bytes: &[u8]) -> Result<RawMesh, MeshError> {
    let mut raw = RawMesh::new(file, "Gmsh 1.0");
    let mut rows = RowReader::new(Text::new(file, bytes), None);
    let mut index = NodeIndex::default();
    rows.text.section = "$NOD".into();
    rows.text.literal("$NOD")?;
    nodes(&mut rows, &mut raw, &mut index)?;
    rows.text.literal("$ENDNOD")?;
    rows.text.section = "$ELM".into();
    rows.text.literal("$ELM")?;
    for number in 1..=count(&mut rows, "elements")? {
        element_version_1(&mut rows, &mut raw, &index, number)?;
    }
    rows.text.literal("$ENDELM")?;
    raw.name_regions();
    Ok(raw)
}

fn count(rows: &mut RowReader<'_>, what: &str) -> Result<usize, MeshError> {
    // The count is a line of text in binary files too.
    let line = rows.text.line(COUNT)?;
    let [count] = rows.text.exactly::<u64, 1>(line, COUNT)?;
    rows.text.bounded(count, 8, what)
}

fn element_version_1(
    rows: &mut RowReader<'_>,
    raw: &mut RawMesh,
    index: &NodeIndex,
    number: usize,
) -> Result<(), MeshError> {
    let expected = format!("element {number}: number, type, two tags, node count, nodes");
    rows.begin(&expected)?;
    rows.id(&expected)?;
    let kind = kind_of(rows, &expected)?;
    let tag = rows.int(&expected)?;
    rows.int(&expected)?;
    if rows.size(&expected)? != kind.node_count() as u64 {
        return Err(rows.text.at().malformed("another node count", format!("{} nodes", kind.node_count())));
    }
    cell(rows, raw, index, kind, tag, &expected)
}

pub(crate) fn nodes(
    rows: &mut RowReader<'_>,
    raw: &mut RawMesh,
    index: &mut NodeIndex,
) -> Result<(), MeshError> {
    let count = count(rows, "nodes")?;
    for _ in 0..count {
        rows.begin(NODE)?;
        let id = rows.id(NODE)?;
        let point = rows.point(NODE)?;
        rows.end(NODE)?;
        index.insert(id, raw.nodes.len(), &rows.text.at())?;
        raw.nodes.push(point);
        raw.node_ids.push(id);
    }
    Ok(())
}

pub(crate) fn elements(
    rows: &mut RowReader<'_>,
    raw: &mut RawMesh,
    index: &NodeIndex,
) -> Result<(), MeshError> {
    let count = count(rows, "elements")?;
    if rows.is_binary() {
        return binary_elements(rows, raw, index, count);
    }
    for number in 1..=count {
        let expected = format!("element {number} of {count}: number, type, tag count, tags, nodes");
        rows.begin(&expected)?;
        rows.id(&expected)?;
        let kind = kind_of(rows, &expected)?;
        let tags = rows.size(&expected)?;
        element(rows, raw, index, kind, tags, &expected)?;
    }
    Ok(())
}

/// Binary elements come in runs of one type and tag count.
fn binary_elements(
    rows: &mut RowReader<'_>,
    raw: &mut RawMesh,
    index: &NodeIndex,
    count: usize,
) -> Result<(), MeshError> {
    const EXPECTED: &str = "a run of elements: type, count, tag count";
    let mut read = 0;
    while read < count {
        let kind = kind_of(rows, EXPECTED)?;
        let run = rows.id(EXPECTED)?;
        let tags = rows.id(EXPECTED)?;
        let run = rows.text.bounded(run, 4 * (1 + kind.node_count()), "elements")?;
        if run == 0 || run > count - read {
            let found = format!("a run of {run} elements");
            return Err(rows.text.at().malformed(found, format!("1 to {} elements", count - read)));
        }
        for _ in 0..run {
            rows.id("an element number")?;
            element(rows, raw, index, kind, tags, "tags and nodes of an element")?;
        }
        read += run;
    }
    Ok(())
}

fn kind_of(rows: &mut RowReader<'_>, expected: &str) -> Result<CellKind, MeshError> {
    let code = rows.int(expected)?;
    cell_kind(code).ok_or_else(|| {
        let found = format!("element type {code}");
        rows.text.at().unsupported(found, "a type of up to quadratic tetrahedra", "mesh with tetrahedra")
    })
}

/// The rest of an MSH 2 element: tags (the first one is the physical group), nodes.
fn element(
    rows: &mut RowReader<'_>,
    raw: &mut RawMesh,
    index: &NodeIndex,
    kind: CellKind,
    tags: u64,
    expected: &str,
) -> Result<(), MeshError> {
    let mut physical = 0;
    for place in 0..rows.text.bounded(tags, 1, "tags")? {
        let tag = rows.int(expected)?;
        physical = if place == 0 { tag } else { physical };
    }
    cell(rows, raw, index, kind, physical, expected)
}

fn cell(
    rows: &mut RowReader<'_>,
    raw: &mut RawMesh,
    index: &NodeIndex,
    kind: CellKind,
    physical: i64,
    expected: &str,
) -> Result<(), MeshError> {
    let mut nodes = Vec::with_capacity(kind.node_count());
    for _ in 0..kind.node_count() {
        let id = rows.id(expected)?;
        nodes.push(index.find(id, &rows.text.at())?);
    }
    rows.end(expected)?;
    reorder(kind, &mut nodes);
    // A physical tag of zero means none; a negative one is a reversed orientation of the same group.
    let tags = if physical == 0 { &[][..] } else { &[physical.saturating_abs()][..] };
    raw.push(kind, &nodes, tags, rows.text.place());
    Ok(())
}
