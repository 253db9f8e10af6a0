//! Content of an Ansys file (`.cdb`): commands, and blocks of nodes, elements and components.

use std::path::Path;

use super::format::Columns;
use crate::mesh::error::{FaultSite, MeshError, shown};
use crate::mesh::fortran::real;
use crate::mesh::place::Location;
use crate::mesh::ranges::IdRanges;

/// A command of one line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Command {
    /// Name in capitals, for instance `MPDATA` or `/PREP7`.
    pub name: String,
    /// Texts between its commas, trimmed; empty ones at the end are left out.
    pub fields: Vec<String>,
    /// Its line, from 1.
    pub line: usize,
}

impl Command {
    /// A field; empty where there is none.
    pub fn field(&self, index: usize) -> &str {
        self.fields.get(index).map_or("", String::as_str)
    }
}

/// A node of a block.
pub(super) struct NodeRow {
    pub(super) id: u64,
    pub(super) point: [f64; 3],
    /// Rotations of its coordinate system about z, x and y, in degrees.
    pub(super) angles: [f64; 3],
    pub(super) line: usize,
}

/// An element of a block.
pub(super) struct ElementRow {
    pub(super) number: u64,
    /// Number of its element type.
    pub(super) kind: u64,
    pub(super) material: u64,
    /// Number of its nodes in [`Scan::element_nodes`].
    pub(super) nodes: usize,
    pub(super) line: usize,
}

/// A named set.
pub(super) struct Component {
    pub(super) name: String,
    pub(super) of_nodes: bool,
    pub(super) ids: IdRanges,
}

/// Everything in a file.
#[derive(Default)]
pub(super) struct Scan {
    pub(super) commands: Vec<Command>,
    pub(super) nodes: Vec<NodeRow>,
    pub(super) elements: Vec<ElementRow>,
    /// Nodes of all elements, one after the other; 0 is none.
    pub(super) element_nodes: Vec<u64>,
    pub(super) components: Vec<Component>,
    /// Rows of blocks of element types: number, element, its options.
    pub(super) types: Vec<Vec<i64>>,
    /// Element types of blocks that are not read, with the number of lines.
    pub(super) loose: Vec<(u64, usize)>,
}

/// Reads a file.
pub(super) fn scan(file: &Path, bytes: &[u8]) -> Result<Scan, MeshError> {
    let mut scanner = Scanner { file, bytes, pos: 0, line: 0, found: Scan::default() };
    while let Some(line) = scanner.next() {
        scanner.command_line(line)?;
    }
    Ok(scanner.found)
}

struct Scanner<'a> {
    file: &'a Path,
    bytes: &'a [u8],
    pos: usize,
    /// Number of the line that was read last.
    line: usize,
    found: Scan,
}

impl<'a> Scanner<'a> {
    /// The next line as it is; none at the end of the file.
    fn next(&mut self) -> Option<&'a [u8]> {
        let rest = self.bytes.get(self.pos..).filter(|rest| !rest.is_empty())?;
        let end = rest.iter().position(|b| *b == b'\n').unwrap_or(rest.len());
        self.pos += end + 1;
        self.line += 1;
        let line = rest.get(..end)?;
        Some(line.strip_suffix(b"\r").unwrap_or(line))
    }

    /// The next line of a block that begins with a number, blank ones left out; none, and nothing taken, at
    /// another one.
    fn data(&mut self) -> Option<&'a [u8]> {
        loop {
            let (pos, number) = (self.pos, self.line);
            let line = self.next()?;
            let first = line.trim_ascii_start().first();
            if first.is_some_and(|b| !(b.is_ascii_digit() || b"+-.".contains(b))) {
                (self.pos, self.line) = (pos, number);
                return None;
            }
            if first.is_some() {
                return Some(line);
            }
        }
    }

    fn malformed(&self, section: &str, found: &[u8], expected: &str) -> MeshError {
        let site = FaultSite { file: self.file, place: Location::Line(self.line.max(1)), section };
        site.malformed(shown(found.trim_ascii()), expected)
    }

    /// The columns of a block, from the line before it.
    fn columns(&mut self, section: &str) -> Result<Columns, MeshError> {
        let line = self.next().unwrap_or_default();
        Columns::parse(line).ok_or_else(|| self.malformed(section, line, "a format, like (3i9,6e21.13e3)"))
    }

    /// A whole number; 0 for a blank.
    fn integer(&self, section: &str, text: &[u8], line: &[u8]) -> Result<i64, MeshError> {
        if text.is_empty() {
            return Ok(0);
        }
        let number = std::str::from_utf8(text).ok().and_then(|text| text.parse().ok());
        number.ok_or_else(|| self.malformed(section, line, "whole numbers in the columns of the format"))
    }

    /// The same of a number that is not negative.
    fn natural(&self, section: &str, text: &[u8], line: &[u8]) -> Result<u64, MeshError> {
        let number = self.integer(section, text, line)?;
        u64::try_from(number).map_err(|_| self.malformed(section, line, "numbers that are not negative"))
    }

    fn command_line(&mut self, line: &[u8]) -> Result<(), MeshError> {
        let text = String::from_utf8_lossy(line);
        let text = text.trim();
        let is_title = ["/COM", "/TITLE", "C***"]
            .iter()
            .any(|word| text.get(..word.len()).is_some_and(|start| start.eq_ignore_ascii_case(word)));
        if is_title {
            self.push(text);
            return Ok(());
        }
        let text = text.split('!').next().unwrap_or_default();
        for text in text.split('$').map(str::trim).filter(|text| !text.is_empty()) {
            // Rows of blocks that are not read, and their formats.
            if text.starts_with(|c: char| c.is_ascii_digit() || ['+', '-', '.', '('].contains(&c)) {
                continue;
            }
            self.push(text);
            let block = self.found.commands.last().filter(|command| command.name.ends_with("BLOCK")).cloned();
            let Some(Command { name, fields, .. }) = block else { continue };
            match name.as_str() {
                "NBLOCK" => self.node_block()?,
                "EBLOCK" => self.element_block(&fields)?,
                "ETBLOCK" => self.type_block()?,
                "CMBLOCK" => self.component_block(&fields)?,
                _ => {}
            }
        }
        Ok(())
    }

    fn push(&mut self, text: &str) {
        let mut parts = text.split(',').map(|part| part.trim().to_string());
        let name = parts.next().unwrap_or_default().to_ascii_uppercase();
        let mut fields: Vec<String> = parts.collect();
        let filled = fields.iter().rposition(|field| !field.is_empty()).map_or(0, |last| last + 1);
        fields.truncate(filled);
        self.found.commands.push(Command { name, fields, line: self.line });
    }

    fn node_block(&mut self) -> Result<(), MeshError> {
        let columns = self.columns("NBLOCK")?;
        while let Some(line) = self.data() {
            let id = self.integer("NBLOCK", columns.integer(line, 0), line)?;
            if id == -1 {
                break;
            }
            let id = u64::try_from(id).map_err(|_| self.malformed("NBLOCK", line, "a positive number"))?;
            let mut values = [0.0; 6];
            for (k, value) in values.iter_mut().enumerate().take(columns.reals) {
                let text = columns.real(line, k);
                if !text.is_empty() {
                    let number = std::str::from_utf8(text).ok().and_then(real);
                    let fault = || self.malformed("NBLOCK", line, "numbers in the columns of the format");
                    *value = number.ok_or_else(fault)?;
                }
            }
            let [x, y, z, a, b, c] = values;
            self.found.nodes.push(NodeRow { id, point: [x, y, z], angles: [a, b, c], line: self.line });
        }
        Ok(())
    }

    fn element_block(&mut self, fields: &[String]) -> Result<(), MeshError> {
        const END: &str = "an element, or -1 at the end of the block";
        let columns = self.columns("EBLOCK")?;
        let is_solid = fields.get(1).is_some_and(|key| key.eq_ignore_ascii_case("SOLID"));
        if !is_solid {
            return self.loose_block(columns, fields);
        }
        if columns.integers < 11 {
            return Err(self.malformed("EBLOCK", b"a narrow format", "11 columns or more, like (19i9)"));
        }
        loop {
            let Some(line) = self.data() else {
                let next = self.next().unwrap_or(b"the end of the file");
                return Err(self.malformed("EBLOCK", next, END));
            };
            if line.trim_ascii() == b"-1" || columns.integer(line, 0) == b"-1" {
                return Ok(());
            }
            let natural = |column| self.natural("EBLOCK", columns.integer(line, column), line);
            let (material, kind, declared) = (natural(0)?, natural(1)?, natural(8)?);
            let (number, first) = (natural(10)?, self.line);
            let mut row = line;
            let mut column = 11;
            let mut count = 0;
            // A row without the number of its nodes has as many as it has columns.
            let declared = if declared == 0 { columns.integers as u64 - 11 } else { declared };
            while count < declared {
                if column == columns.integers {
                    let Some(more) = self.data() else {
                        let next = self.next().unwrap_or(b"the end of the file");
                        let expected = format!("{declared} nodes of element {number}");
                        return Err(self.malformed("EBLOCK", next, &expected));
                    };
                    (row, column) = (more, 0);
                }
                let node = self.natural("EBLOCK", columns.integer(row, column), row)?;
                self.found.element_nodes.push(node);
                (column, count) = (column + 1, count + 1);
            }
            let row = ElementRow { number, kind, material, nodes: count as usize, line: first };
            self.found.elements.push(row);
        }
    }

    /// Passes over a block of other elements than solids; its type is that of the last `TYPE`.
    fn loose_block(&mut self, columns: Columns, fields: &[String]) -> Result<(), MeshError> {
        let mut rows = 0;
        while let Some(line) = self.data() {
            if columns.integer(line, 0) == b"-1" || line.trim_ascii() == b"-1" {
                break;
            }
            rows += 1;
        }
        let declared = fields.get(3).and_then(|count| count.parse().ok()).filter(|count| *count <= rows);
        let kind = self.found.commands.iter().rev().find(|command| command.name == "TYPE");
        let kind = kind.and_then(|command| command.field(0).parse().ok()).unwrap_or(0);
        self.found.loose.push((kind, declared.unwrap_or(rows)));
        Ok(())
    }

    /// Element types: number, element, and their options, which may be texts of the same width.
    fn type_block(&mut self) -> Result<(), MeshError> {
        let columns = self.columns("ETBLOCK")?;
        while let Some(line) = self.data() {
            if columns.integer(line, 0) == b"-1" {
                break;
            }
            let mut row = Vec::new();
            for column in 0..20 {
                let text = columns.integer(line, column);
                let number = std::str::from_utf8(text).ok().and_then(|text| text.parse().ok());
                row.push(number.unwrap_or(0));
            }
            let filled = row.iter().rposition(|value| *value != 0).map_or(0, |last| last + 1);
            row.truncate(filled);
            row.shrink_to_fit();
            self.found.types.push(row);
        }
        Ok(())
    }

    fn component_block(&mut self, fields: &[String]) -> Result<(), MeshError> {
        let field = |index: usize| fields.get(index).map_or("", String::as_str);
        let (name, kind) = (field(0).trim_matches('\'').trim(), field(1).to_ascii_uppercase());
        let count: u64 = field(2).parse().unwrap_or(0);
        let columns = self.columns("CMBLOCK")?;
        let mut ids = IdRanges::default();
        let (mut read, mut last) = (0, 0);
        while read < count {
            let Some(line) = self.data() else {
                let next = self.next().unwrap_or(b"the end of the file");
                return Err(self.malformed("CMBLOCK", next, &format!("{count} numbers of {name}")));
            };
            for column in 0..columns.integers {
                let text = columns.integer(line, column);
                if read == count || text.is_empty() {
                    break;
                }
                let id = self.integer("CMBLOCK", text, line)?;
                read += 1;
                // A negative number ends a range from the one before it.
                let to = id.unsigned_abs();
                let from = if id < 0 { last } else { to };
                if from > to || (id < 0 && last == 0) {
                    return Err(self.malformed("CMBLOCK", line, "a range after its first number"));
                }
                ids.add([from, to]);
                last = to;
            }
        }
        let of_nodes = kind.starts_with("NODE");
        if of_nodes || kind.starts_with("ELEM") {
            self.found.components.push(Component { name: name.to_string(), of_nodes, ids });
        }
        Ok(())
    }
}
