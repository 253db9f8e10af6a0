//! The two plain tables of the chapter: coordinates, one node a line, and connectivity, one element a line.

use std::path::Path;

use super::Mesh;
use super::detect::repaired;
use super::error::MeshError;
use super::load::load;
use super::raw::{CellKind, RawMesh};
use super::text::{ParsedNumber, Text};

/// Reads a mesh from a coordinate table (`x y z` a line) and a connectivity table (4 or 10 node numbers a
/// line).
///
/// Values are separated by white space, commas or semicolons; lines starting with `#` or `%` are comments.
/// Node numbers count from 1 unless 0 occurs; the one found is noted in [`Mesh::notes`]. Ten nodes follow
/// [`super::Order::Quadratic`].
///
/// # Errors
/// As [`super::read`]; places in the connectivity are reported with its own file name.
pub fn read_tables(coordinates: &Path, connectivity: &Path) -> Result<Mesh, MeshError> {
    read_tables_without(coordinates, connectivity, 0.0)
}

/// The same without the parts that share no facet with the rest and have less than `smallest` of the
/// elements.
///
/// # Errors
/// As [`read_tables`].
pub fn read_tables_without(
    coordinates: &Path,
    connectivity: &Path,
    smallest: f64,
) -> Result<Mesh, MeshError> {
    repaired(parse_tables(coordinates, connectivity)?, smallest)
}

/// The same without judging the mesh.
///
/// # Errors
/// [`MeshError`] if a table cannot be read or is malformed.
pub(crate) fn parse_tables(coordinates: &Path, connectivity: &Path) -> Result<RawMesh, MeshError> {
    let points = load(coordinates)?;
    let cells = load(connectivity)?;
    let mut raw = RawMesh::new(coordinates, "coordinate and connectivity tables");
    raw.nodes = points_of(coordinates, &points)?;
    cells_of(connectivity, &cells, &mut raw)?;
    raw.name_regions();
    Ok(raw)
}

/// The values of a line, or none for a comment.
fn values<T: ParsedNumber>(
    text: &Text<'_>,
    line: &[u8],
    expected: &str,
) -> Result<Option<Vec<T>>, MeshError> {
    if matches!(line.first(), Some(b'#' | b'%')) {
        return Ok(None);
    }
    let words = line.split(|b| b.is_ascii_whitespace() || matches!(b, b',' | b';')).filter(|w| !w.is_empty());
    let values: Option<Vec<T>> = words.map(T::parse).collect();
    values.map(Some).ok_or_else(|| text.malformed(line, expected))
}

fn points_of(file: &Path, bytes: &[u8]) -> Result<Vec<[f64; 3]>, MeshError> {
    const EXPECTED: &str = "three numbers: x y z";
    let mut text = Text::new(file, bytes);
    text.section = "the coordinate table".into();
    let mut points = Vec::new();
    while let Some(line) = text.next_line() {
        let Some(values) = values::<f64>(&text, line, EXPECTED)? else {
            continue;
        };
        let [x, y, z] = values[..] else {
            return Err(text.malformed(line, EXPECTED));
        };
        points.push([x, y, z]);
    }
    Ok(points)
}

fn cells_of(file: &Path, bytes: &[u8], raw: &mut RawMesh) -> Result<(), MeshError> {
    const EXPECTED: &str = "4 or 10 node numbers";
    let mut text = Text::new(file, bytes);
    text.section = "the connectivity table".into();
    let mut rows = Vec::new();
    while let Some(line) = text.next_line() {
        let Some(row) = values::<u64>(&text, line, EXPECTED)? else {
            continue;
        };
        if !matches!(row.len(), 4 | 10) {
            return Err(text.malformed(line, EXPECTED));
        }
        rows.push((row, text.place()));
    }
    let base = u64::from(!rows.iter().any(|(row, _)| row.contains(&0)));
    raw.node_ids = (base..base + raw.nodes.len() as u64).collect();
    raw.notes.push(format!("node numbers of the connectivity table count from {base}"));
    for (row, place) in rows {
        let mut nodes = Vec::with_capacity(row.len());
        for id in row {
            let index = id - base;
            if index >= raw.nodes.len() as u64 {
                let mut at = text.at();
                at.place = place;
                let last = (raw.nodes.len() as u64 + base).saturating_sub(1);
                return Err(at.malformed(format!("node {id}"), format!("node numbers from {base} to {last}")));
            }
            nodes.push(index as u32);
        }
        let kind = if nodes.len() == 4 { CellKind::Tetrahedron4 } else { CellKind::Tetrahedron10 };
        raw.push(kind, &nodes, &[], place);
    }
    Ok(())
}
