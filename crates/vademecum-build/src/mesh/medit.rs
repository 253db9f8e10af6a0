//! Medit text files (`MeshVersionFormatted`): keyword, count, rows; free format.

use std::path::Path;

use super::error::MeshError;
use super::kind::{ElementKind, FacetKind};
use super::raw::{CellKind, RawMesh};
use super::text::Text;

/// Reads a Medit `.mesh` file.
pub(crate) fn parse(file: &Path, bytes: &[u8]) -> Result<RawMesh, MeshError> {
    let mut text = Text::new(file, bytes);
    let mut raw = RawMesh::new(file, "Medit .mesh");
    keyword(&mut text, "MeshVersionFormatted")?;
    text.number::<u64>("the version of the format")?;
    let mut has_nodes = false;
    while let Some(word) = text.next_token() {
        if word.starts_with(b"#") {
            text.raw_line();
            continue;
        }
        let name = String::from_utf8_lossy(word).into_owned();
        text.section.clone_from(&name);
        match name.as_str() {
            "Dimension" => dimension(&mut text)?,
            "Vertices" if has_nodes => return Err(text.malformed(word, "one Vertices section")),
            "Vertices" => {
                vertices(&mut text, &mut raw)?;
                has_nodes = true;
            }
            "End" => break,
            _ if !word[0].is_ascii_alphabetic() => {
                return Err(text.malformed(word, "a keyword, like `Vertices`"));
            }
            _ => match cell_kind(&name) {
                Some(kind) => cells(&mut text, &mut raw, kind)?,
                None => skip_numbers(&mut text),
            },
        }
    }
    if !has_nodes {
        return Err(text.at().malformed("the end of the file", "a section Vertices"));
    }
    raw.name_regions();
    Ok(raw)
}

fn keyword(text: &mut Text<'_>, word: &str) -> Result<(), MeshError> {
    let token = text.token(word)?;
    if token == word.as_bytes() { Ok(()) } else { Err(text.malformed(token, format!("`{word}`"))) }
}

fn dimension(text: &mut Text<'_>) -> Result<(), MeshError> {
    match text.number::<u64>("the dimension")? {
        3 => Ok(()),
        other => Err(text.at().unsupported(format!("dimension {other}"), "3", "mesh a solid")),
    }
}

fn vertices(text: &mut Text<'_>, raw: &mut RawMesh) -> Result<(), MeshError> {
    let count = text.number::<u64>("the number of vertices")?;
    for id in 1..=text.bounded(count, 8, "vertices")? {
        let expected = "a vertex: x, y, z, reference";
        let point = [text.number(expected)?, text.number(expected)?, text.number(expected)?];
        let reference = text.number::<i64>(expected)?;
        if reference != 0 {
            raw.node_groups.entry(format!("vertices {reference}")).or_default().push(id as u32 - 1);
        }
        raw.nodes.push(point);
        raw.node_ids.push(id as u64);
    }
    Ok(())
}

fn cell_kind(name: &str) -> Option<CellKind> {
    Some(match name {
        "Edges" => CellKind::Line(2),
        "EdgesP2" => CellKind::Line(3),
        "Triangles" => CellKind::Facet(FacetKind::Tri3),
        "TrianglesP2" => CellKind::Facet(FacetKind::Tri6),
        "Quadrilaterals" => CellKind::Facet(FacetKind::Quad4),
        "Tetrahedra" => CellKind::Solid(ElementKind::Tet4),
        "TetrahedraP2" => CellKind::Solid(ElementKind::Tet10),
        "Hexahedra" => CellKind::Solid(ElementKind::Hex8),
        "Prisms" => CellKind::Solid(ElementKind::Wedge6),
        "Pyramids" => CellKind::Solid(ElementKind::Pyramid5),
        _ => return None,
    })
}

fn cells(text: &mut Text<'_>, raw: &mut RawMesh, kind: CellKind) -> Result<(), MeshError> {
    let count = text.number::<u64>("the number of elements")?;
    let expected = "an element: nodes, reference";
    let mut nodes = vec![0; kind.node_count()];
    for _ in 0..text.bounded(count, 2 * (1 + kind.node_count()), "elements")? {
        for node in &mut nodes {
            let id = text.number::<u64>(expected)?;
            if id == 0 || id > raw.nodes.len() as u64 {
                let range = format!("vertices 1 to {}", raw.nodes.len());
                return Err(text.at().malformed(format!("vertex {id}"), range));
            }
            *node = (id - 1) as u32;
        }
        let reference = text.number::<i64>(expected)?;
        let grouped = reference != 0 || kind.dimension() == 3;
        let tags = if grouped { &[reference][..] } else { &[][..] };
        raw.push(kind, &nodes, tags, text.place());
    }
    Ok(())
}

/// Passes over the rows of a section that says nothing about the mesh.
fn skip_numbers(text: &mut Text<'_>) {
    while text.peek_token().is_some_and(|token| !token[0].is_ascii_alphabetic()) {
        text.next_token();
    }
}
