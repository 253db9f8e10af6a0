//! Point data of VTU files, as snapshots come from other codes.

use std::path::{Path, PathBuf};

use super::{DenseMatrix, FieldError, io_error};
use crate::linalg::vec3::{norm, sub};
use crate::mesh::vtk::array::decode;
use crate::mesh::vtk::xml::{Shell, arrays};
use crate::mesh::{Mesh, bounding_box};
use crate::store::read_regular;

/// One array of point data.
#[derive(Clone, Debug, PartialEq)]
pub struct PointArray {
    /// Its name.
    pub name: String,
    /// Values per point.
    pub components: usize,
    /// `components` values per point, point after point.
    pub values: Vec<f64>,
}

/// Points and point data of a VTU file.
#[derive(Clone, Debug, PartialEq)]
pub struct VtuFile {
    /// Positions.
    pub points: Vec<[f64; 3]>,
    /// Point data in file order.
    pub data: Vec<PointArray>,
}

/// Reads points and all point data of a VTU file (text, base64 or appended, plain or zlib).
///
/// # Errors
/// [`FieldError::Io`], [`FieldError::Vtk`] with place if the file is faulty.
pub fn read_vtu(path: &Path) -> Result<VtuFile, FieldError> {
    let bytes = read_regular(path).map_err(io_error(path))?;
    let shell = Shell::new(path, &bytes)?;
    let document = shell.document()?;
    let storage = shell.storage(&document, "UnstructuredGrid")?;
    let piece = shell.piece(&document)?;
    let count = shell.count(piece, "NumberOfPoints")?;
    let fits = |components: usize| count.checked_mul(components);
    let too_many =
        || shell.at(piece, "Piece").malformed("a count beyond the file", "counts the file can hold");
    let points = arrays(piece, "Points").into_iter().next();
    let points = points.ok_or_else(|| shell.at(piece, "Points").malformed("no array", "one DataArray"))?;
    let positions = decode(&shell, storage, points, Some(fits(3).ok_or_else(too_many)?))?.reals();
    let mut data = Vec::new();
    for node in arrays(piece, "PointData") {
        let components = match node.attribute("NumberOfComponents") {
            None => 1,
            Some(_) => shell.count(node, "NumberOfComponents")?,
        };
        let values = decode(&shell, storage, node, Some(fits(components).ok_or_else(too_many)?))?.reals();
        let name = node.attribute("Name").unwrap_or("").to_string();
        data.push(PointArray { name, components, values });
    }
    let points = positions.chunks_exact(3).map(|p| [p[0], p[1], p[2]]).collect();
    Ok(VtuFile { points, data })
}

/// Reads the displacement `name` from a series of VTU files on the mesh, one column per file: rows are the
/// dofs in node order of the mesh, x y z of each node.
///
/// The points of each file must be the nodes of the mesh, to 1e-6 of the bounding box diagonal (single
/// precision): either in the same order and number, or as in the file the mesh was read from, unused nodes
/// included.
///
/// # Errors
/// [`FieldError::NoSuchField`], [`FieldError::ForeignMesh`], and those of [`read_vtu`].
pub fn read_displacements(files: &[PathBuf], name: &str, mesh: &Mesh) -> Result<DenseMatrix, FieldError> {
    let rows = 3 * mesh.nodes.len();
    let mut data = Vec::with_capacity(rows * files.len());
    for file in files {
        let VtuFile { points, data: arrays } = read_vtu(file)?;
        let Some(array) = arrays.iter().find(|a| a.name == name && a.components == 3) else {
            return Err(no_such_field(file, name, &arrays));
        };
        for point in order_of(file, &points, mesh)? {
            data.extend_from_slice(&array.values[3 * point..3 * point + 3]);
        }
    }
    Ok(DenseMatrix { rows, columns: files.len(), data })
}

fn no_such_field(file: &Path, name: &str, arrays: &[PointArray]) -> FieldError {
    let known: Vec<String> = arrays.iter().map(|a| format!("`{}` ({})", a.name, a.components)).collect();
    let known = if known.is_empty() { "none".into() } else { known.join(", ") };
    FieldError::NoSuchField { file: file.to_path_buf(), name: name.into(), components: 3, known }
}

/// The point of the file that each node of the mesh is.
fn order_of(file: &Path, points: &[[f64; 3]], mesh: &Mesh) -> Result<Vec<usize>, FieldError> {
    let (low, high) = bounding_box(&mesh.nodes);
    let tolerance = 1e-6 * norm(sub(high, low));
    let same = |node: usize, point: usize| {
        points.get(point).is_some_and(|p| norm(sub(*p, mesh.nodes[node])) <= tolerance)
    };
    let nodes = 0..mesh.nodes.len();
    if points.len() == mesh.nodes.len() && nodes.clone().all(|n| same(n, n)) {
        return Ok(nodes.collect());
    }
    // Files number their nodes from 0 (VTK) or 1 (most others).
    for base in [0, 1] {
        let point = |n: usize| usize::try_from(mesh.node_ids[n].checked_sub(base)?).ok();
        if nodes.clone().all(|n| point(n).is_some_and(|p| same(n, p))) {
            return Ok(nodes.filter_map(point).collect());
        }
    }
    let first = nodes.clone().find(|&n| !same(n, n)).unwrap_or(0);
    let detail = format!(
        "{} points for {} nodes, the first difference at node {} {:?}",
        points.len(),
        mesh.nodes.len(),
        mesh.node_ids.get(first).copied().unwrap_or(0),
        mesh.nodes.get(first)
    );
    Err(FieldError::ForeignMesh { file: file.to_path_buf(), detail })
}
