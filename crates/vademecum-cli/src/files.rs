//! Files that commands read and write.

use std::error::Error;
use std::path::Path;

use vademecum_build::mesh::{self, MeshError};
use vademecum_build::store::write_atomic;
use vademecum_eval::Mapped;
use vademecum_format::{Codec, File, FormatError, MAGIC, Section, SectionKind};

use crate::arguments::Limit;
use crate::failure::{Cause, DAMAGED, Failure};

/// Writes a text file.
pub fn write_text(path: &Path, text: &str) -> Result<(), Failure> {
    std::fs::write(path, text).map_err(|error| Failure::io(path, error))
}

/// Makes an output folder.
pub fn make_folder(path: &Path) -> Result<(), Failure> {
    std::fs::create_dir_all(path).map_err(|error| Failure::io(path, error))
}

/// A file for as long as the command runs: mapped, or copied so that nothing that becomes of it on the disk
/// matters.
pub fn open(path: &Path, copy: bool) -> Result<Mapped, Failure> {
    refuse_folder(path)?;
    let opened = if copy { Mapped::copy(path) } else { Mapped::open(path) };
    let mapped = opened.map_err(|error| unreadable(path, error.source()))?;
    recognise(path, mapped.bytes())?;
    Ok(mapped)
}

/// The file of a map with every section raw for which `wanted` holds, every section compared with its
/// checksum: a program reads most of it anyway, and a damaged basis would pass for physics. What is packed is
/// decoded into `memory`, with the wanted sections only.
pub fn usable_file<'a>(
    path: &Path,
    mapped: &'a Mapped,
    wanted: impl Fn(SectionKind) -> bool,
    limit: Limit,
    memory: &'a mut Vec<u8>,
) -> Result<File<'a>, Failure> {
    let failed = |error: FormatError| Failure::file(path, error).remedy(DAMAGED);
    let file = mapped.file().map_err(failed)?;
    file.verify_all().map_err(failed)?;
    let packed = |section: &Section<'_>| section.codec() != Codec::Raw && wanted(section.kind());
    if file.sections().any(|section| packed(&section)) {
        let unpacked = vademecum_rewrite::unpack_wanted(&file, &wanted, limit.of(mapped.bytes().len()));
        *memory = unpacked.map_err(|error| Failure::file(path, error))?;
        return File::parse(memory).map_err(failed);
    }
    Ok(file)
}

/// Whether stepping a file and showing its motion reads a section; the others are for people.
pub fn is_stepped(kind: SectionKind) -> bool {
    use SectionKind as S;
    let for_people =
        [S::SingularValues, S::ModeTable, S::EnrichmentHistory, S::RadiusSamples, S::Losses, S::Repairs];
    !for_people.contains(&kind)
}

/// A vademecum file that cannot be read, for the system's reason.
fn unreadable(path: &Path, reason: Option<&(dyn Error + 'static)>) -> Failure {
    let reason = reason.map_or_else(|| "it cannot be read".to_string(), ToString::to_string);
    Failure::new(Cause::File, reason).about(path)
}

fn refuse_folder(path: &Path) -> Result<(), Failure> {
    if !path.is_dir() {
        return Ok(());
    }
    Err(Failure::new(Cause::File, "this is a folder, not a vademecum file").about(path))
}

/// Refuses a file that is no vademecum at all, with a guess what it is instead.
fn recognise(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    // A file that is damaged in its first bytes keeps the rest of them, or its name.
    let near = bytes.iter().zip(&MAGIC).filter(|(a, b)| a == b).count() >= 4;
    if bytes.starts_with(&MAGIC) || (!bytes.is_empty() && near) {
        return Ok(());
    }
    let (what, remedy) = guess(path, bytes);
    let text = format!("this is not a vademecum file: {what}");
    Err(Failure::new(Cause::File, text).about(path).remedy(remedy))
}

/// What a file that is no vademecum looks like, and what to do with it.
fn guess(path: &Path, bytes: &[u8]) -> (&'static str, &'static str) {
    const BUILD: &str = "`vademecum build PROBLEM -o FILE` makes a vademecum file of it";
    const GIVE: &str = "give the vademecum file first, and the scenario with `--scenario`";
    const MESH: &str = "name the mesh in a problem file (`[mesh]`) and build that; `vademecum mesh` shows it";
    const OTHER: &str = "give a file that `vademecum build` has written";
    if bytes.is_empty() {
        return ("it is empty", OTHER);
    }
    let start = bytes.trim_ascii_start();
    let head = start.get(..512.min(start.len())).unwrap_or_default().to_ascii_lowercase();
    if head.starts_with(b"<!doctype html") || head.starts_with(b"<html") {
        return ("it looks like a page, such as `report` and `view --export` write", OTHER);
    }
    if !matches!(mesh::parse(path), Err(MeshError::UnknownFormat { .. })) {
        return ("it looks like a mesh", MESH);
    }
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
    if ["stl", "step", "stp", "iges", "igs", "obj", "ply"].contains(&extension.as_str()) {
        return (
            "it looks like a surface or a CAD file",
            "mesh its volume first, then name the mesh in a problem file",
        );
    }
    let text = std::str::from_utf8(bytes).ok();
    let table = text.and_then(|text| text.parse::<toml::Table>().ok());
    match table {
        Some(table) if table.contains_key("mesh") || table.contains_key("material") => {
            ("it looks like a problem file (TOML)", BUILD)
        }
        Some(table) if table.contains_key("duration") => ("it looks like a scenario file (TOML)", GIVE),
        Some(_) => ("it looks like a TOML file", OTHER),
        None if extension == "toml" => ("it looks like a problem file (TOML)", BUILD),
        None if text.is_some() => ("it is a text", OTHER),
        None => ("its first eight bytes are others than those of one", OTHER),
    }
}

/// Refuses a file of the canonical representation where contacts anywhere or free states are needed.
pub fn refuse_canonical(path: &Path, file: &File<'_>, what: &str) -> Result<(), Failure> {
    if file.section(SectionKind::CanonicalParts).is_none() {
        return Ok(());
    }
    let text = format!("{what} does not know the canonical representation, whose axes end");
    let remedy = "use `run`, `verify` or `info`, or build it without `representation`";
    Err(Failure::new(Cause::File, text).about(path).remedy(remedy))
}

/// All bytes of a vademecum file, copied: the file itself may then be replaced.
pub fn read_file(path: &Path) -> Result<Vec<u8>, Failure> {
    refuse_folder(path)?;
    let bytes = std::fs::read(path).map_err(|error| unreadable(path, Some(&error)))?;
    recognise(path, &bytes)?;
    Ok(bytes)
}

/// Writes a vademecum file whole or not at all, and says how large it has become.
pub fn write_file(path: &Path, bytes: &[u8], before: usize) -> Result<(), Failure> {
    write_atomic(path, bytes).map_err(|error| Failure::io(path, error))?;
    println!("{}: {} bytes, {before} before", path.display(), bytes.len());
    Ok(())
}
