//! Gmsh files: version 1.0 (`$NOD`/`$ELM`), MSH 2 and MSH 4.1, text and binary.
//!
//! A file is a list of sections `$Name … $EndName`. Text and binary hold the same rows of numbers, so one
//! reader of rows serves both. Physical groups become regions (volumes), facet groups (surfaces) and node
//! groups (the rest).

mod cells;
mod v2;
mod v4;

use std::path::Path;

use crate::mesh::error::{MeshError, shown};
use crate::mesh::raw::RawMesh;
use crate::mesh::rows::RowReader;
use crate::mesh::text::{Endian, Text, tokens};

/// Reads a Gmsh file of any supported version.
pub(crate) fn parse(file: &Path, bytes: &[u8]) -> Result<RawMesh, MeshError> {
    let mut text = Text::new(file, bytes);
    let line = text.line("$MeshFormat or $NOD")?;
    match line {
        b"$NOD" => v2::parse_version_1(file, bytes),
        b"$MeshFormat" => parse_sections(text),
        other => Err(text.malformed(other, "`$MeshFormat` or `$NOD`")),
    }
}

/// The two layouts that follow a `$MeshFormat` header.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Version {
    Two,
    FourOne,
}

fn parse_sections(mut text: Text<'_>) -> Result<RawMesh, MeshError> {
    text.section = "$MeshFormat".into();
    let (version, name, endian) = format_header(&mut text)?;
    let mut raw = RawMesh::new(text.file, &name);
    let mut rows = RowReader::new(text, endian);
    let mut model = v4::EntityTable::default();
    let (mut has_nodes, mut has_elements) = (false, false);
    while let Some(line) = rows.text.next_line() {
        let section = String::from_utf8_lossy(line).into_owned();
        rows.text.section.clone_from(&section);
        match (section.as_str(), version) {
            ("$PhysicalNames", _) => physical_names(&mut rows.text, &mut raw)?,
            ("$Nodes", _) if has_nodes => {
                return Err(rows.text.malformed(line, "one $Nodes section"));
            }
            ("$Elements", _) if has_elements => {
                return Err(rows.text.malformed(line, "one $Elements section"));
            }
            ("$Elements", _) if !has_nodes => {
                return Err(rows.text.malformed(line, "$Nodes before $Elements"));
            }
            ("$Nodes", Version::Two) => v2::nodes(&mut rows, &mut raw, &mut model.index)?,
            ("$Elements", Version::Two) => v2::elements(&mut rows, &mut raw, &model.index)?,
            ("$Entities", Version::FourOne) => v4::entities(&mut rows, &mut model)?,
            ("$PartitionedEntities", Version::FourOne) => v4::partitioned(&mut rows, &mut model)?,
            ("$Nodes", Version::FourOne) => v4::nodes(&mut rows, &mut raw, &mut model)?,
            ("$Elements", Version::FourOne) => v4::elements(&mut rows, &mut raw, &model)?,
            ("$Periodic", _) => {
                raw.notes.push("the periodicity of the mesh ($Periodic) is ignored".into());
                skip_section(&mut rows.text, &section)?;
            }
            (other, _) if other.starts_with('$') => skip_section(&mut rows.text, &section)?,
            _ => {
                return Err(rows.text.malformed(line, "the name of a section, like `$Nodes`"));
            }
        }
        has_nodes |= section == "$Nodes";
        has_elements |= section == "$Elements";
        if matches!(section.as_str(), "$Nodes" | "$Elements" | "$Entities" | "$PartitionedEntities") {
            rows.text.literal(&end_of(&section))?;
        }
    }
    for (present, missing) in [(has_nodes, "$Nodes"), (has_elements, "$Elements")] {
        if !present {
            return Err(rows.text.at().malformed("the end of the file", format!("a section {missing}")));
        }
    }
    raw.name_regions();
    v4::groups_without_elements(&mut raw, &model);
    Ok(raw)
}

fn end_of(section: &str) -> String {
    format!("$End{}", section.trim_start_matches('$'))
}

/// Version, its name, and the byte order of a binary file.
fn format_header(text: &mut Text<'_>) -> Result<(Version, String, Option<Endian>), MeshError> {
    const EXPECTED: &str = "the version, 0 (text) or 1 (binary), and the size of a real, like `4.1 0 8`";
    let line = text.line(EXPECTED)?;
    let words: Vec<&[u8]> = tokens(line).collect();
    let [version, kind, size] = words[..] else {
        return Err(text.malformed(line, EXPECTED));
    };
    let layout = match version {
        b"4.1" => Version::FourOne,
        b"2" | b"2.0" | b"2.1" | b"2.2" => Version::Two,
        _ => {
            let found = format!("MSH version {}", shown(version));
            let remedy = "write it again with `gmsh -save -format msh41`";
            return Err(text.at().unsupported(found, "version 1.0, 2.x or 4.1", remedy));
        }
    };
    if size != b"8" || !matches!(kind, b"0" | b"1") {
        return Err(text.malformed(line, EXPECTED));
    }
    let endian = if kind == b"1" { Some(byte_order(text)?) } else { None };
    text.literal("$EndMeshFormat")?;
    let written = if endian.is_some() { "binary" } else { "ASCII" };
    let name = format!("Gmsh MSH {} {written}", String::from_utf8_lossy(version));
    Ok((layout, name, endian))
}

/// A binary file starts with the integer one.
fn byte_order(text: &mut Text<'_>) -> Result<Endian, MeshError> {
    text.binary = true;
    match text.take(4, "the integer 1, which tells the byte order")? {
        [1, 0, 0, 0] => Ok(Endian::Little),
        [0, 0, 0, 1] => Ok(Endian::Big),
        other => Err(text.malformed(other, "the integer 1, which tells the byte order")),
    }
}

fn physical_names(text: &mut Text<'_>, raw: &mut RawMesh) -> Result<(), MeshError> {
    let line = text.line("the number of physical names")?;
    let [count] = text.exactly::<u64, 1>(line, "the number of physical names alone on its line")?;
    for _ in 0..text.bounded(count, 6, "physical names")? {
        const EXPECTED: &str = "dimension, tag and \"name\"";
        let line = text.line(EXPECTED)?;
        // Some programs write remarks behind the closing quote.
        let mut parts = line.split(|&b| b == b'"');
        let numbers = parts.next().unwrap_or(b"");
        let [dimension, tag] = text.exactly::<i64, 2>(numbers, EXPECTED)?;
        let name = parts.next().filter(|_| parts.next().is_some());
        let (Some(name), 0..=3) = (name, dimension) else {
            return Err(text.malformed(line, EXPECTED));
        };
        raw.names.insert((dimension as usize, tag), String::from_utf8_lossy(name).into_owned());
    }
    text.literal("$EndPhysicalNames")
}

/// Passes over a section that says nothing about the mesh.
fn skip_section(text: &mut Text<'_>, section: &str) -> Result<(), MeshError> {
    let end = end_of(section);
    while let Some(line) = text.raw_line() {
        // Binary data may run into the end mark without a line break.
        if line.ends_with(end.as_bytes()) {
            return Ok(());
        }
    }
    Err(text.at().malformed("the end of the file", format!("`{end}`")))
}
