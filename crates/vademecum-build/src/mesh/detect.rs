//! Which format a file has: by its first words where they tell, else by its extension.

use std::path::Path;

use super::check::check;
use super::error::{MeshError, shown};
use super::filled::{self, Format};
use super::flaw::Flaw;
use super::foreign::foreign;
use super::load::load;
use super::raw::RawMesh;
use super::{Mesh, ansys, gmsh, inp, medit, mfem, nastran, tetgen, unv, vtk};

/// Reads a mesh that can be computed with.
///
/// Unused nodes are dropped and inverted elements reoriented, with a note in [`Mesh::notes`].
///
/// # Errors
/// [`MeshError`] with place, found, expected and remedy if the file is faulty; [`MeshError::Unsound`] with
/// all problems if the mesh has foreign cells, two orders, flat or folded elements, coincident nodes or
/// several bodies.
pub fn read(path: &Path) -> Result<Mesh, MeshError> {
    read_without(path, 0.0)
}

/// The same without the parts that share no facet with the rest and have less than `smallest` of the
/// elements.
///
/// # Errors
/// As [`read`].
pub fn read_without(path: &Path, smallest: f64) -> Result<Mesh, MeshError> {
    repaired(parse(path)?, smallest)
}

/// The same of a file that was parsed.
///
/// # Errors
/// [`MeshError::Unsound`].
pub fn repaired(mut raw: RawMesh, smallest: f64) -> Result<Mesh, MeshError> {
    raw.drop_small_parts(smallest);
    sound(&raw)
}

/// The same of several bodies that constraints may join: bodies that share no node, and nodes at one place,
/// are no flaws.
///
/// # Errors
/// [`MeshError::Unsound`].
pub fn repaired_apart(raw: &RawMesh) -> Result<Mesh, MeshError> {
    without(raw, |flaw| matches!(flaw, Flaw::Disconnected { .. } | Flaw::DuplicateNodes { .. }))
}

/// The same of a deck, whose quadratic tetrahedra have the mass of its program: those that are folded are no
/// flaw if they are sound at the points of the stiffness, and are noted.
///
/// # Errors
/// [`MeshError::Unsound`].
pub fn repaired_deck(raw: &RawMesh) -> Result<Mesh, MeshError> {
    use Flaw::{Disconnected, DuplicateNodes, FoldedElements};
    without(raw, |flaw| {
        matches!(
            flaw,
            Disconnected { .. } | DuplicateNodes { .. } | FoldedElements { stiffness_is_sound: true, .. }
        )
    })
}

/// Checks and repairs a raw mesh; some flaws are none, and folded elements among them are noted.
fn without(raw: &RawMesh, harmless: impl Fn(&Flaw) -> bool) -> Result<Mesh, MeshError> {
    let mut checked = check(raw);
    let folded = |flaw: &&Flaw| matches!(flaw, Flaw::FoldedElements { .. }) && harmless(flaw);
    if let Some(flaw) = checked.problems.iter().find(folded) {
        checked.mesh.notes.push(format!("{flaw}; the points of their stiffness are sound"));
    }
    checked.problems.retain(|flaw| !harmless(flaw));
    match checked.problems.is_empty() {
        true => Ok(checked.mesh),
        false => Err(MeshError::Unsound { file: raw.file.clone(), problems: checked.problems }),
    }
}

/// Checks and repairs a raw mesh, or refuses it.
fn sound(raw: &RawMesh) -> Result<Mesh, MeshError> {
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
    parse_with_cells(path, None)
}

/// The same; a surface is filled with this number of cells along its longest side, else with one that fits
/// its volume. Other files have no use for it, and a note says so.
///
/// # Errors
/// As [`parse`].
pub fn parse_with_cells(path: &Path, cells: Option<u32>) -> Result<RawMesh, MeshError> {
    let bytes = load(path)?;
    parse_bytes(path, &bytes, cells)
}

/// The same, for content at hand; `path` gives the extension, neighbours and the name in messages.
pub(crate) fn parse_bytes(path: &Path, bytes: &[u8], cells: Option<u32>) -> Result<RawMesh, MeshError> {
    // A byte order mark of some editors.
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let head = bytes.trim_ascii_start();
    let starts =
        |word: &str| head.get(..word.len()).is_some_and(|start| start.eq_ignore_ascii_case(word.as_bytes()));
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase();
    // Comments of other programs begin like that too.
    let gmsh_1 = starts("$NOD") && head.get(4).is_none_or(u8::is_ascii_whitespace);
    let raw = if starts("$MeshFormat") || gmsh_1 {
        gmsh::parse(path, bytes)
    } else if starts("# vtk DataFile") {
        vtk::parse(path, bytes)
    } else if extension == "unv" || unv::is_universal(head) {
        unv::parse(path, bytes)
    } else if let Some((found, remedy)) = foreign(head, &extension) {
        Err(MeshError::Foreign { file: path.to_path_buf(), found, remedy })
    } else if starts("<?xml") || starts("<VTKFile") {
        vtk::parse_vtu(path, bytes)
    } else if starts("MFEM ") {
        mfem::parse(path, bytes)
    } else if starts("MeshVersionFormatted") {
        medit::parse(path, bytes)
    } else if matches!(extension.as_str(), "node" | "ele") {
        tetgen::parse(path)
    } else if matches!(extension.as_str(), "bdf" | "nas" | "fem") {
        nastran::parse(path, bytes)
    } else if extension == "cdb" || (!starts("*") && has_line(bytes, ansys_block)) {
        // Its input files are called `.inp` and `.dat`, as those of others.
        ansys::parse(path, bytes)
    } else if extension == "inp"
        || (starts("*") && head.get(1).is_some_and(|b| *b == b'*' || b.is_ascii_alphabetic()))
    {
        inp::parse(path, bytes)
    } else if extension == "mesh" {
        medit::parse(path, bytes)
    } else if let Some((found, shape)) = geometry(bytes, head, &extension) {
        return match shape {
            Shape::Surface(format) => filled::parse(path, bytes, format, cells),
            Shape::Solid => Err(MeshError::Geometry { file: path.to_path_buf(), found }),
        };
    } else if has_line(bytes, nastran_line) {
        nastran::parse(path, bytes)
    } else {
        let first = head.split(|&b| b == b'\n').next().unwrap_or(b"");
        Err(MeshError::UnknownFormat { file: path.to_path_buf(), found: shown(first) })
    };
    raw.map(|mut raw| {
        if cells.is_some() {
            raw.notes.push("`cells` is for surfaces: the file has elements of its own".into());
        }
        raw
    })
}

/// The format of a surface, by its content and its extension; none of another file.
pub(super) fn surface_format(path: &Path, bytes: &[u8]) -> Option<Format> {
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase();
    match geometry(bytes, bytes.trim_ascii_start(), &extension) {
        Some((_, Shape::Surface(format))) => Some(format),
        _ => None,
    }
}

/// True if one of the first lines of a text is like this; comments of both programs are left out.
fn has_line(bytes: &[u8], is_like: impl Fn(&[u8]) -> bool) -> bool {
    // Binary data are no lines.
    let head = bytes.get(..1000).unwrap_or(bytes);
    let lines = bytes.split(|b| *b == b'\n').map(<[u8]>::trim_ascii);
    let mut lines = lines.filter(|line| !line.is_empty() && !line.starts_with(b"$")).take(5000);
    !head.contains(&0) && lines.any(is_like)
}

/// A line that begins a block of nodes of Ansys.
fn ansys_block(line: &[u8]) -> bool {
    let mut parts = line.split(|b| *b == b',');
    let is_block = parts.next().is_some_and(|word| word.trim_ascii().eq_ignore_ascii_case(b"NBLOCK"));
    is_block && parts.next().is_some_and(|field| field.trim_ascii().iter().all(u8::is_ascii_digit))
}

/// A line that begins the bulk data of Nastran, or a grid point.
fn nastran_line(line: &[u8]) -> bool {
    let starts = |word: &[u8]| line.get(..word.len()).is_some_and(|start| start.eq_ignore_ascii_case(word));
    let rest = line.get(4..).unwrap_or_default();
    let rest = rest.strip_prefix(b"*").unwrap_or(rest);
    let field = rest.trim_ascii_start();
    let field = field.strip_prefix(b",").map_or(field, <[u8]>::trim_ascii_start);
    let is_grid =
        starts(b"GRID") && field.len() < rest.len() && field.first().is_some_and(u8::is_ascii_digit);
    starts(b"BEGIN BULK") || is_grid
}

/// Content of a file that is no mesh of a volume.
#[derive(Clone, Copy)]
enum Shape {
    /// CAD geometry, which Gmsh meshes.
    Solid,
    /// A surface, which is filled here.
    Surface(Format),
}

/// The kind of a file that describes a surface or a shape, by its first words, else by its extension.
fn geometry(bytes: &[u8], head: &[u8], extension: &str) -> Option<(&'static str, Shape)> {
    type Kind = ((&'static str, Shape), &'static [&'static str], &'static [&'static str]);
    const fn filled(name: &'static str, format: Format) -> (&'static str, Shape) {
        (name, Shape::Surface(format))
    }
    const KINDS: [Kind; 9] = [
        (filled("an STL file", Format::StlText), &["solid "], &["stl"]),
        (("a STEP file", Shape::Solid), &["ISO-10303-21"], &["step", "stp"]),
        (filled("an OBJ file", Format::Obj), &[], &["obj"]),
        (("an IGES file", Shape::Solid), &[], &["iges", "igs"]),
        (filled("a PLY file", Format::Ply), &["ply\n", "ply\r"], &["ply"]),
        (filled("an OFF file", Format::Off), &["OFF\n", "OFF\r", "COFF\n", "NOFF\n"], &["off"]),
        (filled("a glTF file", Format::Glb), &["glTF"], &["glb", "gltf"]),
        (("a BREP file", Shape::Solid), &["DBRep_DrawableShape", "CASCADE Topology"], &["brep"]),
        (("a geometry script of Gmsh", Shape::Solid), &[], &["geo", "geo_unrolled"]),
    ];
    // A binary STL file: 80 bytes of anything, the number of triangles, 50 bytes for each.
    let triangles = bytes.get(80..84).and_then(|count| Some(u32::from_le_bytes(count.try_into().ok()?)));
    if triangles.is_some_and(|count| bytes.len() as u64 == 84 + 50 * u64::from(count)) {
        return Some(filled("an STL file", Format::StlBinary));
    }
    // One that was cut short, or is no text at all.
    if extension == "stl" && bytes.get(..1000).unwrap_or(bytes).contains(&0) {
        return Some(filled("an STL file", Format::StlBinary));
    }
    let by_words = KINDS.iter().find(|(_, words, _)| words.iter().any(|w| head.starts_with(w.as_bytes())));
    let by_name = || KINDS.iter().find(|(_, _, extensions)| extensions.contains(&extension));
    by_words.or_else(by_name).map(|(found, ..)| *found)
}
