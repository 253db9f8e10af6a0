//! A surface as it is, of a rigid body.

use std::path::Path;

use super::embedded::joined;
use super::read;
use super::winding::Point;
use crate::mesh::detect::surface_format;
use crate::mesh::error::MeshError;
use crate::mesh::load::load;

/// Vertices and triangles of a surface.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfaceMesh {
    /// Vertices.
    pub nodes: Vec<[f64; 3]>,
    /// Vertices of each triangle.
    pub triangles: Vec<[u32; 3]>,
}

/// A surface (STL, OBJ, PLY, OFF, GLB) in units of `scale`: corners at one place are one vertex, and the
/// triangles turn counterclockwise seen from outside if it encloses something.
///
/// # Errors
/// [`MeshError`]: a file that cannot be read, or is no surface.
pub fn read_surface(file: &Path, scale: f64) -> Result<SurfaceMesh, MeshError> {
    let bytes = load(file)?;
    let refused = || MeshError::Unfilled {
        file: file.to_path_buf(),
        reason: "expected an STL, OBJ, PLY, OFF or GLB surface with triangles of an area".into(),
    };
    let format = surface_format(file, &bytes).ok_or_else(refused)?;
    let mut corners: Vec<[Point; 3]> = read(file, &bytes, format)?.corners;
    corners.iter_mut().flatten().flatten().for_each(|x| *x *= scale);
    let (nodes, triangles) = joined(&mut corners);
    if triangles.is_empty() { Err(refused()) } else { Ok(SurfaceMesh { nodes, triangles }) }
}
