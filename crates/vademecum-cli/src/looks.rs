//! Recognition of a file that is not of the expected kind.

use std::path::Path;

use vademecum_build::mesh::{self, MeshError};
use vademecum_build::store::read_regular;
use vademecum_format::MAGIC;

/// Kind of a file by its contents.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Looks {
    /// There is nothing in it.
    Empty,
    /// A vademecum file.
    Vademecum,
    /// A page in HTML.
    Page,
    /// CAD geometry.
    Solid,
    /// A mesh, sound or not.
    Mesh,
    /// A problem file.
    Problem,
    /// A scenario file.
    Scenario,
    /// An assembly file.
    Assembly,
    /// Another TOML file.
    Toml,
    /// Some text.
    Text,
    /// Anything else.
    Unknown,
}

impl Looks {
    /// As a message has it.
    pub(crate) fn words(self) -> &'static str {
        match self {
            Self::Empty => "it is empty",
            Self::Vademecum => "it looks like a vademecum file",
            Self::Page => "it looks like a page, such as `report` and `view --export` write",
            Self::Solid => "it looks like a CAD file",
            Self::Mesh => "it looks like a mesh",
            Self::Problem => "it looks like a problem file (TOML)",
            Self::Scenario => "it looks like a scenario file (TOML)",
            Self::Assembly => "it looks like an assembly file (TOML)",
            Self::Toml => "it looks like a TOML file",
            Self::Text => "it is a text",
            Self::Unknown => "its first eight bytes are others than those of one",
        }
    }
}

/// Kind of the file at `path`; unknown if it cannot be read.
pub(crate) fn look(path: &Path) -> Looks {
    read_regular(path).map_or(Looks::Unknown, |bytes| look_at(path, &bytes))
}

/// Kind of these bytes of the file at `path`.
pub(crate) fn look_at(path: &Path, bytes: &[u8]) -> Looks {
    if bytes.is_empty() {
        return Looks::Empty;
    }
    if is_vademecum(bytes) {
        return Looks::Vademecum;
    }
    let start = bytes.trim_ascii_start();
    let head = start.get(..512.min(start.len())).unwrap_or_default().to_ascii_lowercase();
    if head.starts_with(b"<!doctype html") || head.starts_with(b"<html") {
        return Looks::Page;
    }
    match mesh::parse(path) {
        Err(MeshError::UnknownFormat { .. }) => {}
        Err(MeshError::Geometry { .. }) => return Looks::Solid,
        _ => return Looks::Mesh,
    }
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
    let text = std::str::from_utf8(bytes).ok();
    let table = text.and_then(|text| text.parse::<toml::Table>().ok());
    match table {
        Some(table) if table.get("part").is_some_and(toml::Value::is_array) => Looks::Assembly,
        None if is_assembly(text.unwrap_or_default()) => Looks::Assembly,
        Some(table) if table.contains_key("mesh") || table.contains_key("material") => Looks::Problem,
        Some(table) if table.contains_key("duration") => Looks::Scenario,
        Some(_) => Looks::Toml,
        None if extension == "toml" => Looks::Problem,
        None if text.is_some() => Looks::Text,
        None => Looks::Unknown,
    }
}

/// True of an assembly file that breaks the rules of TOML.
fn is_assembly(text: &str) -> bool {
    text.lines().any(|line| line.trim() == "[[part]]")
}

/// A file that is damaged in its first bytes keeps the rest of them.
pub(crate) fn is_vademecum(bytes: &[u8]) -> bool {
    let near = bytes.iter().zip(&MAGIC).filter(|(a, b)| a == b).count() >= 4;
    bytes.starts_with(&MAGIC) || (!bytes.is_empty() && near)
}
