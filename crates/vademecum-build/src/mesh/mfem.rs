//! MFEM mesh v1.0: straight elements with attributes, boundary elements with attributes, vertices.

use std::path::Path;

use super::error::MeshError;
use super::kind::{ElementKind, FacetKind};
use super::raw::{CellKind, RawMesh};
use super::text::{Text, tokens};

/// Reads an MFEM mesh of tetrahedra.
pub(crate) fn parse(file: &Path, bytes: &[u8]) -> Result<RawMesh, MeshError> {
    let mut text = Text::new(file, bytes);
    let mut raw = RawMesh::new(file, "MFEM mesh v1.0");
    let line = text.line("MFEM mesh v1.0")?;
    if line != b"MFEM mesh v1.0" {
        let remedy = "save the mesh as `MFEM mesh v1.0`";
        return Err(text.at().unsupported(super::shown(line), "`MFEM mesh v1.0`", remedy));
    }
    // Cells come before the vertices they name.
    let mut cells = Vec::new();
    let mut has_nodes = false;
    while let Some(line) = next_row(&mut text) {
        text.section = String::from_utf8_lossy(line).into_owned();
        match line {
            b"dimension" => dimension(&mut text)?,
            b"elements" | b"boundary" => read_cells(&mut text, &mut cells)?,
            b"vertices" => {
                vertices(&mut text, &mut raw)?;
                has_nodes = true;
            }
            b"nodes" => return Err(curved(&text)),
            other => return Err(text.malformed(other, "dimension, elements, boundary or vertices")),
        }
    }
    if !has_nodes {
        return Err(text.at().malformed("the end of the file", "a section vertices"));
    }
    for (kind, attribute, nodes, place) in cells {
        if let Some(bad) = nodes.iter().find(|&&n| n as usize >= raw.nodes.len()) {
            let mut at = text.at();
            at.place = place;
            return Err(at.malformed(format!("vertex {bad}"), format!("less than {}", raw.nodes.len())));
        }
        raw.push(kind, &nodes, &[attribute], place);
    }
    raw.name_regions();
    Ok(raw)
}

type Cell = (CellKind, i64, Vec<u32>, super::Location);

/// The next line that is not a comment.
fn next_row<'a>(text: &mut Text<'a>) -> Option<&'a [u8]> {
    loop {
        let line = text.next_line()?;
        if !line.starts_with(b"#") {
            return Some(line);
        }
    }
}

fn row<'a>(text: &mut Text<'a>, expected: &str) -> Result<&'a [u8], MeshError> {
    next_row(text).ok_or_else(|| text.at().malformed("the end of the file", expected))
}

fn dimension(text: &mut Text<'_>) -> Result<(), MeshError> {
    let line = row(text, "the dimension")?;
    match text.exactly::<u64, 1>(line, "the dimension")? {
        [3] => Ok(()),
        [other] => Err(text.at().unsupported(format!("dimension {other}"), "3", "mesh a solid")),
    }
}

fn count(text: &mut Text<'_>) -> Result<usize, MeshError> {
    let line = row(text, "a count")?;
    let [count] = text.exactly::<u64, 1>(line, "a count alone on its line")?;
    text.bounded(count, 4, "entries")
}

/// Geometry types of MFEM's `fem/geom.hpp`, as their file lists them.
fn cell_kind(code: u64) -> Option<CellKind> {
    Some(match code {
        0 => CellKind::Point,
        1 => CellKind::Line(2),
        2 => CellKind::Facet(FacetKind::Tri3),
        3 => CellKind::Facet(FacetKind::Quad4),
        4 => CellKind::Solid(ElementKind::Tet4),
        5 => CellKind::Solid(ElementKind::Hex8),
        6 => CellKind::Solid(ElementKind::Wedge6),
        7 => CellKind::Solid(ElementKind::Pyramid5),
        _ => return None,
    })
}

fn read_cells(text: &mut Text<'_>, cells: &mut Vec<Cell>) -> Result<(), MeshError> {
    const EXPECTED: &str = "an element: attribute, geometry type, vertices";
    for _ in 0..count(text)? {
        let line = row(text, EXPECTED)?;
        let numbers: Option<Vec<u64>> = tokens(line).map(super::text::ParsedNumber::parse).collect();
        let numbers = numbers.filter(|n| n.len() > 2).ok_or_else(|| text.malformed(line, EXPECTED))?;
        let kind =
            cell_kind(numbers[1]).ok_or_else(|| text.malformed(line, "a geometry type from 0 to 7"))?;
        let nodes: Option<Vec<u32>> = numbers[2..].iter().map(|&n| u32::try_from(n).ok()).collect();
        let nodes = nodes.filter(|n| n.len() == kind.node_count());
        let nodes = nodes.ok_or_else(|| text.malformed(line, format!("{} vertices", kind.node_count())))?;
        let attribute = i64::try_from(numbers[0]).map_err(|_| text.malformed(line, EXPECTED))?;
        cells.push((kind, attribute, nodes, text.place()));
    }
    Ok(())
}

/// The refusal of a mesh whose coordinates are a grid function.
fn curved(text: &Text<'_>) -> MeshError {
    let remedy = "save the mesh without `nodes`, with straight elements";
    text.at().unsupported("curved elements (`nodes`)", "straight elements with a list of vertices", remedy)
}

fn vertices(text: &mut Text<'_>, raw: &mut RawMesh) -> Result<(), MeshError> {
    if !raw.nodes.is_empty() {
        return Err(text.at().malformed("a second section vertices", "one"));
    }
    let count = count(text)?;
    let line = row(text, "the number of coordinates")?;
    // A curved mesh has its coordinates in a grid function, and only the number of its vertices here.
    if line == b"nodes" {
        text.section = "nodes".into();
        return Err(curved(text));
    }
    if text.exactly::<u64, 1>(line, "the number of coordinates")? != [3] {
        return Err(text.malformed(line, "3 coordinates per vertex"));
    }
    for id in 0..count {
        let line = row(text, "a vertex: x y z")?;
        raw.nodes.push(text.exactly::<f64, 3>(line, "a vertex: x y z")?);
        raw.node_ids.push(id as u64);
    }
    Ok(())
}
