//! One file per subcommand; no numerics here.

pub mod bench;
pub mod build;
pub mod demo;
pub mod info;
pub mod mesh;
pub mod modes;
pub mod report;
pub mod run;
pub mod verify;
pub mod view;

use std::path::Path;

use vademecum_eval::Mapped;
use vademecum_format::File;

use crate::failure::Failure;

/// Prints a value as JSON on standard output.
pub fn print_json(value: &impl serde::Serialize) {
    println!("{}", serde_json::to_string_pretty(value).expect("a report has string keys and finite nesting"));
}

/// Writes a text file.
pub fn write_text(path: &Path, text: &str) -> Result<(), Failure> {
    std::fs::write(path, text).map_err(|error| Failure::io(path, error))
}

/// Makes an output folder.
pub fn make_folder(path: &Path) -> Result<(), Failure> {
    std::fs::create_dir_all(path).map_err(|error| Failure::io(path, error))
}

/// The file of a map, every section compared with its checksum: a program reads all of it anyway, and a damaged basis would
/// pass for physics.
pub fn whole_file<'a>(path: &Path, mapped: &'a Mapped) -> Result<File<'a>, Failure> {
    let failed = |error| {
        Failure::file(path, error).remedy("the file was damaged after it was built: copy or build it again")
    };
    let file = mapped.file().map_err(failed)?;
    file.verify_all().map_err(failed)?;
    Ok(file)
}
