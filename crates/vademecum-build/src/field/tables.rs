//! The tables of imported matrices: meaning of each row, coordinates of the nodes, the surface's triangles
//! (normative: `formats/matrices-1.md`).
//!
//! Each is a text table, one row per line, cells separated by commas. Blank lines and lines that start with
//! `#` or `%` are left out. A reader returns what the file contains; whether the tables fit each other is
//! judged where they are joined.

use std::path::Path;

use super::{FieldError, io_error};
use crate::mesh::cells::{Separators, names, table_rows};
use crate::mesh::text::ParsedNumber;
use crate::mesh::{FaultSite, Location, shown};
use crate::store::read_regular;

/// Meaning of one row of the matrices.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct DofRow {
    /// Row of the matrices, from 0.
    pub(crate) row: u64,
    /// Number of the node.
    pub(crate) node: u64,
    /// Component of its displacement: 0, 1 or 2.
    pub(crate) component: usize,
    /// Coordinates of the node.
    pub(crate) position: [f64; 3],
    /// Line of the table, for messages.
    pub(crate) line: usize,
}

/// A node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PointRow {
    /// Number of the node.
    pub(crate) node: u64,
    /// Its coordinates.
    pub(crate) position: [f64; 3],
    /// Line of the table, for messages.
    pub(crate) line: usize,
}

/// A triangle of the surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct TriangleRow {
    /// Numbers of its nodes, counter-clockwise seen from outside.
    pub(crate) nodes: [u64; 3],
    /// Line of the table, for messages.
    pub(crate) line: usize,
}

/// Reads `row,node,component,x,y,z`, that line first.
///
/// # Errors
/// [`FieldError::Io`], or [`FieldError::Faulty`] with the line.
pub(crate) fn read_dofs(path: &Path) -> Result<Vec<DofRow>, FieldError> {
    const HEADER: &str = "row,node,component,x,y,z";
    const EXPECTED: &str = "a row from 0, a node, `x`, `y` or `z`, and three finite coordinates";
    read(path, TableHeader::Required(HEADER), |line, cells| {
        let [row, node, component, x, y, z] = *cells else { return Err(EXPECTED) };
        let component = [b"x", b"y", b"z"].iter().position(|name| name.as_slice() == component);
        let read = || {
            let position = [f64::parse(x)?, f64::parse(y)?, f64::parse(z)?];
            Some(DofRow {
                row: u64::parse(row)?,
                node: u64::parse(node)?,
                component: component?,
                position,
                line,
            })
        };
        read().ok_or(EXPECTED)
    })
}

/// Reads `node,x,y,z`, that line first.
///
/// # Errors
/// As [`read_dofs`].
pub(crate) fn read_points(path: &Path) -> Result<Vec<PointRow>, FieldError> {
    const EXPECTED: &str = "a node and three finite coordinates";
    read(path, TableHeader::Required("node,x,y,z"), |line, cells| {
        let [node, x, y, z] = *cells else { return Err(EXPECTED) };
        let read = || {
            let position = [f64::parse(x)?, f64::parse(y)?, f64::parse(z)?];
            Some(PointRow { node: u64::parse(node)?, position, line })
        };
        read().ok_or(EXPECTED)
    })
}

/// Reads three node numbers per line, separated by commas, semicolons or white space; the first line may be
/// `a,b,c`.
///
/// # Errors
/// As [`read_dofs`].
pub(crate) fn read_triangles(path: &Path) -> Result<Vec<TriangleRow>, FieldError> {
    const EXPECTED: &str = "three different node numbers";
    read(path, TableHeader::Allowed("a,b,c"), |line, cells| {
        let [a, b, c] = *cells else { return Err(EXPECTED) };
        let read = || Some([u64::parse(a)?, u64::parse(b)?, u64::parse(c)?]);
        let nodes = read().ok_or(EXPECTED)?;
        let different = nodes[0] != nodes[1] && nodes[1] != nodes[2] && nodes[2] != nodes[0];
        if different { Ok(TriangleRow { nodes, line }) } else { Err(EXPECTED) }
    })
}

/// The first line of a table: names of its columns, which make the order of the cells certain.
#[derive(Clone, Copy)]
enum TableHeader {
    Required(&'static str),
    /// The columns are alike, so that nothing depends on their names; white space separates them too.
    Allowed(&'static str),
}

/// The rows of a table; `row` turns the cells of a line into one, or says what it expected.
fn read<T>(
    path: &Path,
    header: TableHeader,
    row: impl Fn(usize, &[&[u8]]) -> Result<T, &'static str>,
) -> Result<Vec<T>, FieldError> {
    let bytes = read_regular(path).map_err(io_error(path))?;
    let (separators, expected) = match header {
        TableHeader::Required(expected) => (Separators::Commas, expected),
        TableHeader::Allowed(expected) => (Separators::Any, expected),
    };
    let (mut rows, mut first, mut last) = (vec![], true, 1);
    for found in table_rows(&bytes, separators) {
        last = found.line;
        let refused = |expected: &str| refused(path, found.line, shown(found.text), expected);
        if std::mem::replace(&mut first, false) {
            if names(&found) == expected {
                continue;
            }
            if matches!(header, TableHeader::Required(_)) {
                return Err(refused(&format!("the line `{expected}` first")));
            }
        }
        rows.push(row(found.line, &found.cells).map_err(refused)?);
    }
    if rows.is_empty() {
        return Err(refused(path, last, "the end of the file".into(), "at least one row"));
    }
    Ok(rows)
}

fn refused(file: &Path, line: usize, found: String, expected: &str) -> FieldError {
    const REMEDY: &str =
        "formats/matrices-1.md has the columns; `vademecum export matrices` writes an example";
    let site = FaultSite { file, place: Location::Line(line), section: "the table" };
    FieldError::Faulty(Box::new(site.fault(found, expected.into(), REMEDY.into())))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(text: &str) -> (tempfile::TempDir, std::path::PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("t.csv");
        std::fs::write(&path, text).unwrap();
        (folder, path)
    }

    #[test]
    fn rows_are_read_with_their_lines() {
        let (_folder, path) = file("row,node,component,x,y,z\n# one\n0,7,y,1e0, 2 ,3\n");
        let row = DofRow { row: 0, node: 7, component: 1, position: [1.0, 2.0, 3.0], line: 3 };
        assert_eq!(read_dofs(&path).unwrap(), [row]);
        let (_folder, path) = file("node,x,y,z\n5,0,0,-1\n");
        assert_eq!(read_points(&path).unwrap(), [PointRow { node: 5, position: [0.0, 0.0, -1.0], line: 2 }]);
        let (_folder, path) = file("\u{feff}\"node\",\"x\",y,z\r\n\"5\",0,0,\"-1\"\r\n");
        assert_eq!(read_points(&path).unwrap(), [PointRow { node: 5, position: [0.0, 0.0, -1.0], line: 2 }]);
        for text in ["a,b,c\n1,2,3\n", "% no names\n1 2\t3\n", "\n1; 2; 3"] {
            let (_folder, path) = file(text);
            assert_eq!(read_triangles(&path).unwrap(), [TriangleRow { nodes: [1, 2, 3], line: 2 }], "{text}");
        }
    }

    #[test]
    fn faults_are_refused_by_line() {
        let said = |error: FieldError| error.to_string();
        let head = "row,node,component,x,y,z\n";
        let bad =
            ["0,1,x,0,0", "0,1,w,0,0,0", "0,1,x,0,0,inf", "-1,1,x,0,0,0", "0,1,x,0,0,0,0", "0 1 x 0 0 0"];
        for row in bad {
            let (_folder, path) = file(&format!("{head}{row}\n"));
            let error = said(read_dofs(&path).unwrap_err());
            assert!(error.contains("t.csv, line 2, in the table: found") && error.contains(row), "{error}");
        }
        for text in ["", head, "0,1,x,0,0,0\n", "node,row,component,x,y,z\n"] {
            let (_folder, path) = file(text);
            assert!(said(read_dofs(&path).unwrap_err()).contains("line 1"), "{text}");
        }
        for row in ["1 2", "1 2 2", "1 2 3 4", "1 2 x"] {
            let (_folder, path) = file(row);
            assert!(said(read_triangles(&path).unwrap_err()).contains("expected three different"), "{row}");
        }
    }
}
