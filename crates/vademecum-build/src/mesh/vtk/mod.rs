//! VTK legacy files, text and binary (always big-endian), versions 1 to 5.
//!
//! Only unstructured grids are meshes. Data arrays are passed over by their declared shapes, except integers
//! with one value per cell or point, which may name regions or groups.

pub(crate) mod array;
mod cells;
mod vtu;
pub(crate) mod xml;

pub(crate) use vtu::parse as parse_vtu;

use std::path::Path;

use self::cells::{Grid, build};
use crate::mesh::error::MeshError;
use crate::mesh::raw::RawMesh;
use crate::mesh::text::{Endian, ParsedNumber, Text, tokens};

/// Reads a legacy VTK unstructured grid.
pub(crate) fn parse(file: &Path, bytes: &[u8]) -> Result<RawMesh, MeshError> {
    let mut text = Text::new(file, bytes);
    text.section = "the header".into();
    text.line("# vtk DataFile Version")?;
    text.raw_line();
    let written = text.line("ASCII or BINARY")?;
    let binary = match written.to_ascii_uppercase().as_slice() {
        b"ASCII" => false,
        b"BINARY" => true,
        _ => return Err(text.malformed(written, "ASCII or BINARY")),
    };
    text.binary = binary;
    let mut reader = VtkReader { text, binary, grid: Grid::default(), cells: 0, about: ArrayOwner::Nothing };
    while let Some(line) = reader.text.next_line() {
        reader.section(line)?;
    }
    let VtkReader { text, grid, .. } = reader;
    let name = if binary { "VTK legacy, binary" } else { "VTK legacy, ASCII" };
    build(RawMesh::new(file, name), &grid, &text.at())
}

/// Owner of the current data arrays.
#[derive(Clone, Copy, PartialEq, Eq)]
enum ArrayOwner {
    Nothing,
    Points,
    Cells,
}

struct VtkReader<'a> {
    text: Text<'a>,
    binary: bool,
    grid: Grid,
    cells: usize,
    about: ArrayOwner,
}

/// One number of a data array.
#[derive(Clone, Copy)]
enum Value {
    Int(i64),
    Real(f64),
}

impl Value {
    fn real(self) -> f64 {
        match self {
            Value::Int(i) => i as f64,
            Value::Real(x) => x,
        }
    }
}

impl VtkReader<'_> {
    fn section(&mut self, line: &[u8]) -> Result<(), MeshError> {
        let words: Vec<String> = tokens(line).map(|w| String::from_utf8_lossy(w).into_owned()).collect();
        let keyword = words[0].to_ascii_uppercase();
        self.text.section.clone_from(&keyword);
        let arg = |i: usize| words.get(i).map_or("", String::as_str);
        match keyword.as_str() {
            "DATASET" if arg(1).eq_ignore_ascii_case("UNSTRUCTURED_GRID") => Ok(()),
            "DATASET" => {
                let remedy = "save the volume mesh as an unstructured grid";
                Err(self.text.at().unsupported(crate::mesh::shown(line), "UNSTRUCTURED_GRID", remedy))
            }
            "POINTS" => self.points(line, arg(1), arg(2)),
            "CELLS" => self.cells(line, arg(1), arg(2)),
            "CELL_TYPES" => self.types(line, arg(1)),
            "CELL_DATA" => self.start_data(line, ArrayOwner::Cells, arg(1)),
            "POINT_DATA" => self.start_data(line, ArrayOwner::Points, arg(1)),
            "SCALARS" => {
                let components = if arg(3).is_empty() { "1" } else { arg(3) };
                self.lookup_table_name()?;
                self.data(line, arg(1), components, &self.tuples().to_string(), arg(2))
            }
            "COLOR_SCALARS" => {
                let kind = if self.binary { "unsigned_char" } else { "float" };
                self.data(line, arg(1), arg(2), &self.tuples().to_string(), kind)
            }
            "VECTORS" | "NORMALS" => self.data(line, arg(1), "3", &self.tuples().to_string(), arg(2)),
            "TENSORS" => self.data(line, arg(1), "9", &self.tuples().to_string(), arg(2)),
            "TEXTURE_COORDINATES" => self.data(line, arg(1), arg(2), &self.tuples().to_string(), arg(3)),
            "GLOBAL_IDS" | "PEDIGREE_IDS" => self.data(line, arg(1), "1", &self.tuples().to_string(), arg(2)),
            "LOOKUP_TABLE" => {
                let kind = if self.binary { "unsigned_char" } else { "float" };
                self.data(line, "", "4", arg(2), kind)
            }
            "FIELD" => self.field(line, arg(2)),
            "METADATA" => {
                // Ends with a blank line.
                while self.text.raw_line().is_some_and(|l| !l.is_empty()) {}
                Ok(())
            }
            _ => Err(self.text.malformed(line, "a keyword of the legacy VTK format, like POINTS")),
        }
    }

    fn tuples(&self) -> usize {
        match self.about {
            ArrayOwner::Cells => self.cells,
            ArrayOwner::Points => self.grid.points.len(),
            ArrayOwner::Nothing => 0,
        }
    }

    fn count(&self, line: &[u8], word: &str) -> Result<usize, MeshError> {
        let count = u64::parse(word.as_bytes()).ok_or_else(|| self.text.malformed(line, "a count"))?;
        self.text.bounded(count, 1, "entries")
    }

    /// `count` values of a VTK type.
    fn values(&mut self, kind: &str, count: usize) -> Result<Vec<Value>, MeshError> {
        let kind = kind.to_ascii_lowercase();
        self.text.bounded(count as u64, 1, "values")?;
        (0..count)
            .map(|_| if self.binary { self.binary_value(&kind) } else { self.text_value(&kind) })
            .collect()
    }

    fn text_value(&mut self, kind: &str) -> Result<Value, MeshError> {
        let expected = format!("a number of type {kind}");
        match kind {
            "float" | "double" => Ok(Value::Real(self.text.number(&expected)?)),
            "bit" | "unsigned_char" | "char" | "unsigned_short" | "short" | "unsigned_int" | "int"
            | "unsigned_long" | "long" | "vtkidtype" | "vtktypeint64" | "vtktypeint32" => {
                Ok(Value::Int(self.text.number(&expected)?))
            }
            _ => Err(self.unknown_type(kind)),
        }
    }

    fn binary_value(&mut self, kind: &str) -> Result<Value, MeshError> {
        const BIG: Endian = Endian::Big;
        let text = &mut self.text;
        let real = |x: f64| {
            if x.is_finite() { Some(Value::Real(x)) } else { None }
        };
        let value = match kind {
            "double" => real(text.value(BIG, kind)?),
            "float" => real(f64::from(text.value::<f32>(BIG, kind)?)),
            "char" => Some(Value::Int(text.value::<i8>(BIG, kind)?.into())),
            "unsigned_char" => Some(Value::Int(text.value::<u8>(BIG, kind)?.into())),
            "short" => Some(Value::Int(text.value::<i16>(BIG, kind)?.into())),
            "unsigned_short" => Some(Value::Int(text.value::<u16>(BIG, kind)?.into())),
            "int" | "vtktypeint32" | "vtkidtype" => Some(Value::Int(text.value::<i32>(BIG, kind)?.into())),
            "unsigned_int" => Some(Value::Int(text.value::<u32>(BIG, kind)?.into())),
            "long" | "unsigned_long" | "vtktypeint64" => Some(Value::Int(text.value(BIG, kind)?)),
            _ => return Err(self.unknown_type(kind)),
        };
        value.ok_or_else(|| text.at().malformed("a number that is not finite", "finite numbers"))
    }

    fn unknown_type(&self, kind: &str) -> MeshError {
        let remedy = "write the array in a usual type";
        self.text.at().unsupported(format!("data type `{kind}`"), "a number type of VTK", remedy)
    }

    fn integers(&mut self, kind: &str, count: usize) -> Result<Vec<i64>, MeshError> {
        let values = self.values(kind, count)?;
        Ok(values.iter().map(|v| if let Value::Int(i) = v { *i } else { -1 }).collect())
    }

    fn points(&mut self, line: &[u8], count: &str, kind: &str) -> Result<(), MeshError> {
        let count = self.count(line, count)?;
        let values = self.values(kind, 3 * count)?;
        self.grid.points = values.chunks_exact(3).map(|p| [p[0].real(), p[1].real(), p[2].real()]).collect();
        Ok(())
    }

    fn cells(&mut self, line: &[u8], count: &str, size: &str) -> Result<(), MeshError> {
        let (count, size) = (self.count(line, count)?, self.count(line, size)?);
        let start = self.text.pos();
        // Version 5 splits cells into two typed arrays.
        if self.text.rest().trim_ascii_start().starts_with(b"OFFSETS") {
            return self.cells_version_5(count, size);
        }
        self.cells = count;
        let values = self.integers("int", size)?;
        let mut rest = values.as_slice();
        for cell in 0..count {
            let nodes = rest.split_first().and_then(|(&n, tail)| Some((tail, usize::try_from(n).ok()?)));
            let Some((tail, n)) = nodes.filter(|(tail, n)| *n <= tail.len()) else {
                let found = format!("cell {cell} of {count} beyond the {size} declared integers");
                let at = self.text.at();
                return Err(at.malformed(found, format!("complete cells (they start at byte {start})")));
            };
            self.grid.connectivity.extend_from_slice(&tail[..n]);
            self.grid.offsets.push(self.grid.connectivity.len() as i64);
            rest = &tail[n..];
        }
        if rest.is_empty() { Ok(()) } else { Err(self.text.malformed(line, "as many integers as cells use")) }
    }

    fn cells_version_5(&mut self, offsets: usize, size: usize) -> Result<(), MeshError> {
        let head = self.text.line("OFFSETS type")?;
        let kind = second_word(head);
        let mut ends = self.integers(&kind, offsets)?;
        let head = self.text.line("CONNECTIVITY type")?;
        if !head.starts_with(b"CONNECTIVITY") {
            return Err(self.text.malformed(head, "CONNECTIVITY type"));
        }
        let kind = second_word(head);
        self.grid.connectivity = self.integers(&kind, size)?;
        if ends.first().is_none_or(|&first| first != 0) {
            return Err(self.text.at().malformed("no leading 0", "offsets that start at 0"));
        }
        ends.remove(0);
        self.cells = ends.len();
        self.grid.offsets = ends;
        Ok(())
    }

    fn types(&mut self, line: &[u8], count: &str) -> Result<(), MeshError> {
        let count = self.count(line, count)?;
        self.grid.types = self.integers("int", count)?;
        Ok(())
    }

    fn start_data(&mut self, line: &[u8], about: ArrayOwner, count: &str) -> Result<(), MeshError> {
        self.about = about;
        if u64::parse(count.as_bytes()) == Some(self.tuples() as u64) {
            return Ok(());
        }
        Err(self.text.malformed(line, format!("{} entries, as the mesh has", self.tuples())))
    }

    /// The line `LOOKUP_TABLE name` after SCALARS may be missing.
    fn lookup_table_name(&mut self) -> Result<(), MeshError> {
        if self.text.rest().trim_ascii_start().starts_with(b"LOOKUP_TABLE") {
            self.text.line("LOOKUP_TABLE name")?;
        }
        Ok(())
    }

    fn data(
        &mut self,
        line: &[u8],
        name: &str,
        width: &str,
        tuples: &str,
        kind: &str,
    ) -> Result<(), MeshError> {
        let (width, tuples) = (self.count(line, width)?, self.count(line, tuples)?);
        let total = width.checked_mul(tuples).ok_or_else(|| self.text.malformed(line, "a smaller array"))?;
        let values = self.values(kind, total)?;
        let whole = |v: &Value| match v {
            Value::Int(i) => Some(*i),
            // Some programs keep material numbers in reals.
            Value::Real(x) => (x.fract() == 0.0 && x.abs() < 1e15).then_some(*x as i64),
        };
        let integers: Option<Vec<i64>> = values.iter().map(whole).collect();
        if let (1, Some(integers)) = (width, integers) {
            let data = match self.about {
                ArrayOwner::Cells => &mut self.grid.cell_data,
                ArrayOwner::Points => &mut self.grid.point_data,
                ArrayOwner::Nothing => return Ok(()),
            };
            data.push((name.to_string(), integers));
        }
        Ok(())
    }

    fn field(&mut self, line: &[u8], count: &str) -> Result<(), MeshError> {
        const EXPECTED: &str = "an array: name, components, tuples, type";
        let mut left = self.count(line, count)?;
        while left > 0 {
            let line = self.text.line(EXPECTED)?;
            if line == b"METADATA" {
                self.section(line)?;
                continue;
            }
            let words: Vec<String> = tokens(line).map(|w| String::from_utf8_lossy(w).into_owned()).collect();
            let [name, width, tuples, kind] = &words[..] else {
                return Err(self.text.malformed(line, EXPECTED));
            };
            if kind == "string" {
                let remedy = "write the file without string arrays";
                return Err(self.text.at().unsupported("a string array", "numbers", remedy));
            }
            self.data(line, name, width, tuples, kind)?;
            left -= 1;
        }
        Ok(())
    }
}

fn second_word(line: &[u8]) -> String {
    tokens(line).nth(1).map_or(String::new(), |w| String::from_utf8_lossy(w).into_owned())
}
