//! Which format a file has: by its first words where they tell, else by its extension.

use std::path::Path;

use super::check::check;
use super::error::{MeshError, shown};
use super::load::load;
use super::raw::RawMesh;
use super::{Mesh, gmsh, inp, medit, mfem, tetgen, vtk};

/// Reads a mesh that can be computed with.
///
/// Unused nodes are dropped and inverted elements reoriented, with a note in [`Mesh::notes`].
///
/// # Errors
/// [`MeshError`] with place, found, expected and remedy if the file is faulty; [`MeshError::Unsound`] with
/// all problems if the mesh has foreign cells, two orders, flat or folded elements, coincident nodes or
/// several bodies.
pub fn read(path: &Path) -> Result<Mesh, MeshError> {
    sound(&parse(path)?)
}

/// Checks and mends a raw mesh, or refuses it.
pub(crate) fn sound(raw: &RawMesh) -> Result<Mesh, MeshError> {
    let checked = check(raw);
    if checked.problems.is_empty() {
        return Ok(checked.mesh);
    }
    Err(MeshError::Unsound { file: raw.file.clone(), problems: checked.problems })
}

/// Reads what a mesh file says, without judging the mesh.
///
/// # Errors
/// [`MeshError`] if the file cannot be read, its format is unknown, or it breaks the rules of its format.
pub fn parse(path: &Path) -> Result<RawMesh, MeshError> {
    let bytes = load(path)?;
    parse_bytes(path, &bytes)
}

/// The same, for content at hand; `path` gives the extension, neighbours and the name in messages.
pub(crate) fn parse_bytes(path: &Path, bytes: &[u8]) -> Result<RawMesh, MeshError> {
    // A byte order mark of some editors.
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let head = bytes.trim_ascii_start();
    let starts =
        |word: &str| head.get(..word.len()).is_some_and(|start| start.eq_ignore_ascii_case(word.as_bytes()));
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase();
    if starts("$MeshFormat") || starts("$NOD") {
        gmsh::parse(path, bytes)
    } else if starts("# vtk DataFile") {
        vtk::parse(path, bytes)
    } else if starts("<?xml") || starts("<VTKFile") {
        vtk::parse_vtu(path, bytes)
    } else if starts("MFEM ") {
        mfem::parse(path, bytes)
    } else if starts("MeshVersionFormatted") {
        medit::parse(path, bytes)
    } else if matches!(extension.as_str(), "node" | "ele") {
        tetgen::parse(path)
    } else if extension == "inp"
        || (starts("*") && head.get(1).is_some_and(|b| *b == b'*' || b.is_ascii_alphabetic()))
    {
        inp::parse(path, bytes)
    } else if extension == "mesh" {
        medit::parse(path, bytes)
    } else {
        let first = head.split(|&b| b == b'\n').next().unwrap_or(b"");
        Err(MeshError::UnknownFormat { file: path.to_path_buf(), found: shown(first) })
    }
}
