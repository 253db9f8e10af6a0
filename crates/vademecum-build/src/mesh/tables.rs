//! The two plain tables of the chapter: coordinates, one node a line, and connectivity, one element a line.

use std::path::Path;

use super::cells::{Separators, TableRow, table_rows};
use super::detect::repaired;
use super::error::{FaultSite, MeshError, shown};
use super::load::load;
use super::place::Location;
use super::raw::{CellKind, RawMesh};
use super::text::ParsedNumber;
use super::{ElementKind, Mesh};

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

/// The values of a row, of as many as `count` allows.
fn values<'a, T: ParsedNumber>(
    site: &dyn Fn(usize) -> FaultSite<'a>,
    row: &TableRow<'_>,
    count: &[usize],
    expected: &str,
) -> Result<Vec<T>, MeshError> {
    let values: Option<Vec<T>> = row.cells.iter().map(|cell| T::parse(cell)).collect();
    let values = values.filter(|values| count.contains(&values.len()));
    values.ok_or_else(|| site(row.line).malformed(shown(row.text), expected))
}

fn points_of(file: &Path, bytes: &[u8]) -> Result<Vec<[f64; 3]>, MeshError> {
    const EXPECTED: &str = "three numbers: x y z";
    let site = |line| FaultSite { file, place: Location::Line(line), section: "the coordinate table" };
    let point = |row: TableRow<'_>| match values::<f64>(&site, &row, &[3], EXPECTED)?[..] {
        [x, y, z] => Ok([x, y, z]),
        _ => Err(site(row.line).malformed(shown(row.text), EXPECTED)),
    };
    table_rows(bytes, Separators::Any).map(point).collect()
}

fn cells_of(file: &Path, bytes: &[u8], raw: &mut RawMesh) -> Result<(), MeshError> {
    const EXPECTED: &str = "4 or 10 node numbers";
    let site = |line| FaultSite { file, place: Location::Line(line), section: "the connectivity table" };
    let mut rows: Vec<(Vec<u64>, usize)> = Vec::new();
    for row in table_rows(bytes, Separators::Any) {
        rows.push((values(&site, &row, &[4, 10], EXPECTED)?, row.line));
    }
    let base = u64::from(!rows.iter().any(|(row, _)| row.contains(&0)));
    raw.node_ids = (base..base + raw.nodes.len() as u64).collect();
    raw.notes.push(format!("node numbers of the connectivity table count from {base}"));
    for (row, line) in rows {
        let mut nodes = Vec::with_capacity(row.len());
        for id in row {
            let index = id - base;
            if index >= raw.nodes.len() as u64 {
                let last = (raw.nodes.len() as u64 + base).saturating_sub(1);
                let expected = format!("node numbers from {base} to {last}");
                return Err(site(line).malformed(format!("node {id}"), expected));
            }
            nodes.push(index as u32);
        }
        let kind = if nodes.len() == 4 { ElementKind::Tet4 } else { ElementKind::Tet10 };
        raw.push(CellKind::Solid(kind), &nodes, &[], Location::Line(line));
    }
    Ok(())
}
