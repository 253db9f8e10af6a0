//! VTU files: unstructured grids in VTK's XML format.

use std::path::Path;

use super::array::{Values, decode};
use super::cells::{Grid, build};
use super::xml::{AppendedData, Shell, arrays};
use crate::mesh::error::MeshError;
use crate::mesh::raw::RawMesh;

/// Reads a VTU file.
pub(crate) fn parse(file: &Path, bytes: &[u8]) -> Result<RawMesh, MeshError> {
    let shell = Shell::new(file, bytes)?;
    let document = shell.document()?;
    let storage = shell.storage(&document, "UnstructuredGrid")?;
    let piece = shell.piece(&document)?;
    let (points, cells) = (shell.count(piece, "NumberOfPoints")?, shell.count(piece, "NumberOfCells")?);
    let too_many =
        || shell.at(piece, "Piece").malformed("a count beyond the file", "counts the file can hold");
    let coordinates = points.checked_mul(3).ok_or_else(too_many)?;
    let single = |section: &str, name: &str, expected: Option<usize>| {
        let all = arrays(piece, section);
        let node = all.iter().find(|n| name.is_empty() || n.attribute("Name") == Some(name)).copied();
        let node = node.ok_or_else(|| {
            shell.at(piece, section).malformed("no such array", format!("DataArray {name}"))
        })?;
        decode(&shell, storage, node, expected)
    };
    let positions = single("Points", "", Some(coordinates))?.reals();
    let whole = |values: Values, name: &str| {
        values
            .integers()
            .ok_or_else(|| shell.at(piece, "Cells").malformed(format!("reals in {name}"), "integers"))
    };
    let mut grid = Grid {
        points: positions.chunks_exact(3).map(|p| [p[0], p[1], p[2]]).collect(),
        connectivity: whole(single("Cells", "connectivity", None)?, "connectivity")?,
        offsets: whole(single("Cells", "offsets", Some(cells))?, "offsets")?,
        types: whole(single("Cells", "types", Some(cells))?, "types")?,
        ..Grid::default()
    };
    for (section, count) in [("CellData", cells), ("PointData", points)] {
        for node in arrays(piece, section) {
            if !matches!(node.attribute("NumberOfComponents"), None | Some("" | "1")) {
                continue;
            }
            let Some(name) = node.attribute("Name") else {
                continue;
            };
            // Only whole numbers can name regions or groups.
            let Some(values) = decode(&shell, storage, node, Some(count))?.integers() else {
                continue;
            };
            let data = if section == "CellData" { &mut grid.cell_data } else { &mut grid.point_data };
            data.push((name.to_string(), values));
        }
    }
    let written = match storage.appended {
        AppendedData::None => "VTU",
        AppendedData::Raw(_) => "VTU, appended raw",
        AppendedData::Base64(_) => "VTU, appended base64",
    };
    build(RawMesh::new(file, written), &grid, &shell.at(piece, "Cells"))
}
