//! VTU files with appended raw data: exact, compact, and quick for ParaView to open.

use std::io::Write;
use std::path::Path;

use super::pvd::escaped;
use super::{FieldError, write_whole};
use crate::mesh::ElementKinds;
use crate::store::Kind;

/// The cells of a VTU file, on indices into its points.
#[derive(Clone, Copy, Debug)]
pub enum Cells<'a> {
    /// Elements, and their nodes one after the other.
    Elements(&'a ElementKinds, &'a [u32]),
    /// Linear triangles.
    Triangles(&'a [[u32; 3]]),
}

impl Cells<'_> {
    fn connectivity(&self) -> &[u32] {
        match self {
            Cells::Elements(_, nodes) => nodes,
            Cells::Triangles(triangles) => triangles.as_flattened(),
        }
    }

    /// Number of cells, and of the nodes that they have.
    fn counts(&self) -> [usize; 2] {
        match self {
            Cells::Elements(kinds, nodes) => {
                let count = kinds.count(nodes.len());
                [count, count.checked_sub(1).map_or(0, |last| kinds.range(last).end)]
            }
            Cells::Triangles(triangles) => [triangles.len(), 3 * triangles.len()],
        }
    }

    /// End of each cell in the connectivity, and VTK's number of its type (`vtkCellType.h`).
    fn cell(&self, index: usize) -> (usize, u8) {
        match self {
            Cells::Elements(kinds, _) => (kinds.range(index).end, kinds.kind(index).vtk()),
            Cells::Triangles(_) => (3 * (index + 1), 5),
        }
    }
}

/// Writes points, cells and point data: `(name, values, components)` with `components` values per point,
/// point after point. Values are stored as float64, little-endian, appended raw with 64-bit sizes.
///
/// # Errors
/// [`FieldError::WrongLength`] if an array does not fit the points or cells, [`FieldError::Io`].
pub fn write_vtu(
    path: &Path,
    points: &[[f64; 3]],
    cells: Cells<'_>,
    data: &[(&str, &[f64], usize)],
) -> Result<(), FieldError> {
    check(points, cells, data)?;
    write_whole(path, Kind::Vtu, |out| vtu_into(out, points, cells, data))
}

/// [`write_vtu`] to an open output.
///
/// # Errors
/// Of the output; [`FieldError::WrongLength`] inside.
pub fn vtu_into(
    mut out: &mut dyn Write,
    points: &[[f64; 3]],
    cells: Cells<'_>,
    data: &[(&str, &[f64], usize)],
) -> std::io::Result<()> {
    let count = check(points, cells, data).map_err(std::io::Error::other)?;
    let out = &mut out;
    let mut layout = Layout { offset: 0 };
    writeln!(out, "<?xml version=\"1.0\"?>")?;
    writeln!(
        out,
        "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">"
    )?;
    let piece = format!("<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{count}\">", points.len());
    writeln!(out, "<UnstructuredGrid>\n{piece}\n<PointData>")?;
    for (name, values, components) in data {
        layout.array(out, "Float64", name, *components, 8 * values.len())?;
    }
    writeln!(out, "</PointData>\n<Points>")?;
    layout.array(out, "Float64", "Points", 3, 24 * points.len())?;
    writeln!(out, "</Points>\n<Cells>")?;
    layout.array(out, "Int64", "connectivity", 1, 8 * cells.connectivity().len())?;
    layout.array(out, "Int64", "offsets", 1, 8 * count)?;
    layout.array(out, "UInt8", "types", 1, count)?;
    writeln!(out, "</Cells>\n</Piece>\n</UnstructuredGrid>")?;
    write!(out, "<AppendedData encoding=\"raw\">\n_")?;
    for (_, values, _) in data {
        reals(out, values)?;
    }
    reals(out, points.as_flattened())?;
    integers(out, cells.connectivity().iter().map(|&n| i64::from(n)), cells.connectivity().len())?;
    integers(out, (0..count).map(|i| cells.cell(i).0 as i64), count)?;
    size(out, count)?;
    out.write_all(&(0..count).map(|i| cells.cell(i).1).collect::<Vec<u8>>())?;
    writeln!(out, "\n</AppendedData>\n</VTKFile>")
}

/// The number of cells, if everything fits together.
fn check(points: &[[f64; 3]], cells: Cells<'_>, data: &[(&str, &[f64], usize)]) -> Result<usize, FieldError> {
    let wrong = |what: String, found, expected| FieldError::WrongLength { what, found, expected };
    let length = cells.connectivity().len();
    let [count, needed] = cells.counts();
    if length != needed {
        return Err(wrong("the connectivity".into(), length, needed));
    }
    for (name, values, components) in data {
        if values.len() != components * points.len() {
            return Err(wrong(format!("point data `{name}`"), values.len(), components * points.len()));
        }
    }
    Ok(count)
}

/// Keeps track of where the next array starts in the appended data.
struct Layout {
    offset: usize,
}

impl Layout {
    fn array(
        &mut self,
        out: &mut impl Write,
        kind: &str,
        name: &str,
        width: usize,
        bytes: usize,
    ) -> std::io::Result<()> {
        let name = escaped(name);
        write!(out, "<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{width}\" ")?;
        writeln!(out, "format=\"appended\" offset=\"{}\"/>", self.offset)?;
        self.offset += 8 + bytes;
        Ok(())
    }
}

fn size(out: &mut impl Write, bytes: usize) -> std::io::Result<()> {
    out.write_all(&(bytes as u64).to_le_bytes())
}

fn reals(out: &mut impl Write, values: &[f64]) -> std::io::Result<()> {
    size(out, 8 * values.len())?;
    values.iter().try_for_each(|x| out.write_all(&x.to_le_bytes()))
}

fn integers(
    out: &mut impl Write,
    mut values: impl Iterator<Item = i64>,
    count: usize,
) -> std::io::Result<()> {
    size(out, 8 * count)?;
    values.try_for_each(|i| out.write_all(&i.to_le_bytes()))
}
