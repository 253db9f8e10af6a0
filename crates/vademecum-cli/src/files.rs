//! Files that commands read and write.

use std::path::Path;

use vademecum_build::store::{open_regular, read_regular, write_atomic};
use vademecum_eval::Mapped;
use vademecum_format::{Codec, File, FormatError, SectionKind};
use vademecum_rewrite::DECODED_LIMIT;

use crate::failure::{Cause, Failure};

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
    // What is no regular file is told apart before it is mapped, because opening a FIFO would wait for ever.
    if let Err(error) = open_regular(path)
        && error.kind() == std::io::ErrorKind::InvalidInput
    {
        return Err(unread(path, error));
    }
    let opened = if copy { Mapped::copy(path) } else { Mapped::open(path) };
    opened.map_err(|error| Failure::file(path, error))
}

/// The file of a map, every section compared with its checksum: a program reads all of it anyway, and a
/// damaged basis would pass for physics. A packed file is decoded into `memory` first.
pub fn whole_file<'a>(path: &Path, mapped: &'a Mapped, memory: &'a mut Vec<u8>) -> Result<File<'a>, Failure> {
    let failed = |error: FormatError| {
        Failure::file(path, error).remedy("the file was damaged after it was built: copy or build it again")
    };
    let file = mapped.file().map_err(failed)?;
    if file.sections().any(|section| section.codec() != Codec::Raw) {
        let unpacked = vademecum_rewrite::unpack(mapped.bytes(), DECODED_LIMIT);
        *memory = unpacked.map_err(|error| Failure::file(path, error))?;
        return File::parse(memory).map_err(failed);
    }
    file.verify_all().map_err(failed)?;
    Ok(file)
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
    read_regular(path).map_err(|error| unread(path, error))
}

/// A vademecum file that cannot be read.
fn unread(path: &Path, error: std::io::Error) -> Failure {
    let text = format!("{}: cannot be opened: {error}", path.display());
    Failure::new(Cause::File, text).remedy("name a vademecum file that exists and that you may read")
}

/// Writes a vademecum file whole or not at all, and says how large it has become.
pub fn write_file(path: &Path, bytes: &[u8], before: usize) -> Result<(), Failure> {
    write_atomic(path, bytes).map_err(|error| Failure::io(path, error))?;
    println!("{}: {} bytes, {before} before", path.display(), bytes.len());
    Ok(())
}
