//! The one place where files are opened for writing.
//!
//! A file on disk is the old one or the new one, never half of either: it is written to a temporary file next
//! to it and renamed. What is no file is left what it is: a link is followed, a pipe or a character device is
//! written through, everything else is refused. What a command reads it cannot write, and what it would
//! replace must be of the kind that it writes, unless the caller forces it.

use std::cell::RefCell;
use std::collections::BTreeSet;
use std::fs::{File, Metadata, OpenOptions};
use std::io::{self, BufWriter, Read, Write};
use std::path::{Path, PathBuf};

use super::growing::GrowingFile;
use super::kind::{HEAD, Kind, Signature};
use super::part::{PartialFile, remove_left_behind};
use crate::limits::memory_in_words;

/// Meaning of `-` elsewhere; here a file of this name would be made by mistake.
const STANDARD_OUTPUT: &str = "standard output by the sign of other programs, `/dev/stdout` here";

/// Longest chain of links that is followed.
const LINKS: usize = 40;

/// Why a file is not written.
#[derive(Debug, thiserror::Error)]
pub enum OutputError {
    /// The system refuses.
    #[error("{}: {source}", .file.display())]
    Io {
        /// The file, as the caller named it.
        file: PathBuf,
        /// The error of the system.
        source: io::Error,
    },
    /// There is no such folder.
    #[error("{}: there is no folder {}", .file.display(), .folder.display())]
    NoFolder {
        /// The file.
        file: PathBuf,
        /// The expected place.
        folder: PathBuf,
    },
    /// No file can stand there.
    #[error("{}: this is {what}; expected a file, a new name, a pipe or a character device", .file.display())]
    NotAFile {
        /// The path.
        file: PathBuf,
        /// Its kind.
        what: &'static str,
    },
    /// Something else exists where a folder is needed.
    #[error("{}: this is no folder", .folder.display())]
    NotAFolder {
        /// The path.
        folder: PathBuf,
    },
    /// The file may not be written.
    #[error("{}: the file is read-only; it was not overwritten", .file.display())]
    ReadOnly {
        /// The file.
        file: PathBuf,
    },
    /// The disk has less room than is needed.
    #[error("{}: the results take at least {}, and the disk has {} left", .folder.display(),
        memory_in_words(*.needed), memory_in_words(*.left))]
    NoSpace {
        /// The folder.
        folder: PathBuf,
        /// Bytes that are needed.
        needed: u64,
        /// Bytes that are left.
        left: u64,
    },
    /// The command reads this very file.
    #[error("{}: the command reads this file{}, so it cannot write it", .file.display(), also(.file, .input))]
    Input {
        /// The output.
        file: PathBuf,
        /// The input, by the name it was given with.
        input: PathBuf,
    },
    /// The command writes this very file under another name.
    #[error("{}: the command writes this file{} too", .file.display(), also(.file, .other))]
    Twice {
        /// The output.
        file: PathBuf,
        /// The other output.
        other: PathBuf,
    },
    /// A file of another kind exists there.
    #[error("{}: already exists and seems to be {found}, not {expected}; it was not overwritten",
        .file.display())]
    OtherKind {
        /// The file.
        file: PathBuf,
        /// Its apparent kind.
        found: String,
        /// The kind to be written.
        expected: Kind,
    },
}

/// Another name of a file, for messages.
fn also(file: &Path, other: &Path) -> String {
    if file == other { String::new() } else { format!(" ({})", other.display()) }
}

impl From<OutputError> for io::Error {
    fn from(error: OutputError) -> Self {
        match error {
            OutputError::Io { source, .. } => source,
            OutputError::NoFolder { .. } => Self::new(io::ErrorKind::NotFound, error),
            error => Self::other(error),
        }
    }
}

fn io_error(file: &Path) -> impl Fn(io::Error) -> OutputError + '_ {
    |source| OutputError::Io { file: file.to_path_buf(), source }
}

/// Identity of a file, independent of its name.
#[derive(Clone, Debug, PartialEq, Eq)]
struct FileIdentity {
    /// Device and number on it; hard links share them.
    #[cfg(unix)]
    node: Option<(u64, u64)>,
    /// The path without links.
    path: PathBuf,
}

impl FileIdentity {
    /// Of what is there, or of what will be there once it is written.
    fn of(path: &Path) -> Option<Self> {
        let found = std::fs::metadata(path).ok();
        let real = match &found {
            Some(_) => std::fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf()),
            None => {
                let target = follow(path).ok()?;
                std::fs::canonicalize(folder(&target)).ok()?.join(target.file_name()?)
            }
        };
        Some(Self {
            #[cfg(unix)]
            node: found.as_ref().map(node),
            path: real,
        })
    }

    #[cfg(unix)]
    fn is(&self, other: &Self) -> bool {
        self.path == other.path || (self.node.is_some() && self.node == other.node)
    }

    #[cfg(not(unix))]
    fn is(&self, other: &Self) -> bool {
        self.path == other.path
    }
}

#[cfg(unix)]
fn node(found: &Metadata) -> (u64, u64) {
    use std::os::unix::fs::MetadataExt;
    (found.dev(), found.ino())
}

/// True if two paths lead to the same file or folder, be it there or not.
pub fn is_same_place(a: &Path, b: &Path) -> bool {
    let (a, b) = (FileIdentity::of(a), FileIdentity::of(b));
    a.zip(b).is_some_and(|(a, b)| a.is(&b))
}

/// True if bytes for this path go to a pipe or a device, next to which nothing can be stored.
pub fn goes_through(path: &Path) -> bool {
    let found = std::fs::metadata(path);
    found.is_ok_and(|found| !found.is_file() && neither_file_nor_through(&found).is_none())
}

/// Outputs that a command may write: none of its inputs, and no file of another kind unless forced.
#[derive(Debug, Default)]
pub struct Outputs {
    inputs: Vec<(PathBuf, FileIdentity)>,
    force: bool,
    /// True if what killed programs left is let be.
    lets_be: bool,
    /// Folders that were rid of it.
    cleaned: RefCell<BTreeSet<PathBuf>>,
}

/// Destination of the bytes of an output.
enum Destination {
    /// To a new file that replaces what is at `target`.
    File { target: PathBuf, old: Option<Metadata> },
    /// To a pipe or a device, which stays.
    Through,
}

impl Outputs {
    /// For a command that reads `inputs`; `force` lets it replace files of any kind. Those that are not there
    /// are no concern of this.
    pub fn new(inputs: impl IntoIterator<Item = PathBuf>, force: bool) -> Self {
        let known = |path: PathBuf| FileIdentity::of(&path).map(|identity| (path, identity));
        Self { inputs: inputs.into_iter().filter_map(known).collect(), force, ..Self::default() }
    }

    /// For a program that writes many files and knows its outputs: every file is replaced, and folders are
    /// not searched for what killed programs left.
    pub(crate) fn unasked() -> Self {
        Self { force: true, lets_be: true, ..Self::default() }
    }

    /// True if all of `outputs` could be written, before long work: existing files may be replaced, no two
    /// are one file, and where the folder is there already, a file can be made in it.
    ///
    /// # Errors
    /// As [`Self::write`].
    pub fn check(&self, outputs: &[(PathBuf, Kind)]) -> Result<(), OutputError> {
        let mut seen: Vec<(&Path, FileIdentity)> = vec![];
        for (path, kind) in outputs {
            if let Destination::File { target, .. } = self.place(path, *kind)? {
                self.clean(folder(&target));
                PartialFile::new(folder(&target), None).map_err(refused(path, &target))?;
            } else {
                continue;
            }
            let Some(identity) = FileIdentity::of(path) else { continue };
            if let Some((other, _)) = seen.iter().find(|(_, known)| known.is(&identity)) {
                return Err(OutputError::Twice { file: path.clone(), other: other.to_path_buf() });
            }
            seen.push((path, identity));
        }
        Ok(())
    }

    /// [`Self::check`] for files of a folder that need not be there yet.
    ///
    /// # Errors
    /// As [`Self::check`]; [`OutputError::NotAFolder`] if the folder is something else.
    pub fn check_in(&self, folder: &Path, outputs: &[(&str, Kind)]) -> Result<(), OutputError> {
        if folder == Path::new("-") {
            return Err(not_a_file(folder, STANDARD_OUTPUT));
        }
        match std::fs::metadata(folder) {
            Ok(found) if found.is_dir() => {
                let outputs: Vec<_> = outputs.iter().map(|(name, kind)| (folder.join(name), *kind)).collect();
                self.check(&outputs)
            }
            Ok(_) => Err(not_a_folder(folder)),
            Err(_) => Ok(()),
        }
    }

    /// Refuses results of at least so many bytes where the disk has no room for them: before long work, and
    /// before anything is written. A system that does not say what is left refuses nothing.
    ///
    /// # Errors
    /// [`OutputError::NoSpace`].
    pub fn check_space(&self, folder: &Path, needed: u64) -> Result<(), OutputError> {
        match space_left(folder) {
            Some(left) if needed > left => Err(OutputError::NoSpace { folder: folder.into(), needed, left }),
            _ => Ok(()),
        }
    }

    /// Makes a folder for outputs, and those above it.
    ///
    /// # Errors
    /// The error of the system; or that another file exists there.
    pub fn make_folder(&self, folder: &Path) -> Result<(), OutputError> {
        match std::fs::metadata(folder) {
            Ok(found) if !found.is_dir() => Err(not_a_folder(folder)),
            Ok(_) => Ok(()),
            Err(_) => std::fs::create_dir_all(folder).map_err(io_error(folder)),
        }
    }

    /// Writes a file whole or not at all: to a temporary file, renamed over the old one, with its mode; files
    /// of the kinds that take long to make are flushed to the disk. Bytes for a pipe or a device go there.
    ///
    /// # Errors
    /// [`OutputError`]; the old file is then as it was.
    pub fn write(
        &self,
        path: &Path,
        kind: Kind,
        write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
    ) -> Result<(), OutputError> {
        let fill = |file: &File| {
            let mut out = BufWriter::new(file);
            write(&mut out)?;
            out.flush()
        };
        match self.place(path, kind)? {
            Destination::Through => open_through(path).and_then(|file| fill(&file)).map_err(io_error(path)),
            Destination::File { target, old } => {
                let mut part = self.part(path, &target, old.as_ref())?;
                let finish = || -> io::Result<()> {
                    fill(&part.file)?;
                    if kind.is_flushed() { part.file.sync_all() } else { Ok(()) }
                };
                finish().and_then(|()| part.name(&target)).map_err(io_error(path))?;
                if kind.is_flushed() {
                    flush_folder(folder(&target));
                }
                Ok(())
            }
        }
    }

    /// Begins a text that grows line by line in place, between a head and a tail. What stood there before is
    /// replaced at once.
    ///
    /// # Errors
    /// [`OutputError`].
    pub fn grow(
        &self,
        path: &Path,
        kind: Kind,
        head: &str,
        tail: &'static str,
    ) -> Result<GrowingFile, OutputError> {
        match self.place(path, kind)? {
            Destination::Through => {
                open_through(path).and_then(|file| GrowingFile::begin(file, false, head, tail))
            }
            Destination::File { target, old } => {
                let mut part = self.part(path, &target, old.as_ref())?;
                let begun = part.file.try_clone().and_then(|file| GrowingFile::begin(file, true, head, tail));
                begun.and_then(|begun| part.name(&target).map(|()| begun))
            }
        }
        .map_err(io_error(path))
    }

    /// Removes a file that an older run of a command wrote, if it may be replaced by one of its kind: inputs,
    /// files of other kinds and what is no file stay.
    ///
    /// # Errors
    /// The error of the system.
    pub fn remove(&self, path: &Path, kind: Kind) -> Result<(), OutputError> {
        match self.place(path, kind) {
            Ok(Destination::File { old: Some(_), .. }) => std::fs::remove_file(path).map_err(io_error(path)),
            _ => Ok(()),
        }
    }

    fn part(&self, path: &Path, target: &Path, old: Option<&Metadata>) -> Result<PartialFile, OutputError> {
        self.clean(folder(target));
        PartialFile::new(folder(target), old).map_err(refused(path, target))
    }

    /// Rids a folder, once, of what killed programs left.
    fn clean(&self, folder: &Path) {
        if !self.lets_be && self.cleaned.borrow_mut().insert(folder.to_path_buf()) {
            remove_left_behind(folder);
        }
    }

    /// Destination of an output, if it may be written.
    fn place(&self, path: &Path, kind: Kind) -> Result<Destination, OutputError> {
        if path == Path::new("-") {
            return Err(not_a_file(path, STANDARD_OUTPUT));
        }
        if path.file_name().is_none() || path.as_os_str().as_encoded_bytes().ends_with(b"/") {
            return Err(not_a_file(path, "the name of a folder"));
        }
        let found = match std::fs::metadata(path) {
            Ok(found) => found,
            Err(error) if error.kind() == io::ErrorKind::NotFound => {
                let target = follow(path).map_err(io_error(path))?;
                return Ok(Destination::File { target, old: None });
            }
            Err(error) => return Err(io_error(path)(error)),
        };
        if let Some(what) = neither_file_nor_through(&found) {
            return Err(not_a_file(path, what));
        }
        if is_character_device(&found) {
            return Ok(Destination::Through);
        }
        self.refuse_input(path)?;
        if !found.is_file() {
            return Ok(Destination::Through);
        }
        self.refuse_other_kind(path, kind)?;
        if found.permissions().readonly() && !self.force {
            return Err(OutputError::ReadOnly { file: path.into() });
        }
        let is_link = std::fs::symlink_metadata(path).is_ok_and(|found| found.is_symlink());
        let target = if is_link { std::fs::canonicalize(path) } else { Ok(path.to_path_buf()) };
        Ok(Destination::File { target: target.map_err(io_error(path))?, old: Some(found) })
    }

    fn refuse_input(&self, path: &Path) -> Result<(), OutputError> {
        let output = FileIdentity::of(path);
        let is_output = |identity: &FileIdentity| output.as_ref().is_some_and(|output| output.is(identity));
        match self.inputs.iter().find(|(_, identity)| is_output(identity)) {
            Some((input, _)) => Err(OutputError::Input { file: path.into(), input: input.clone() }),
            None => Ok(()),
        }
    }

    fn refuse_other_kind(&self, path: &Path, kind: Kind) -> Result<(), OutputError> {
        if self.force || kind == Kind::Any {
            return Ok(());
        }
        let other = |found: String| OutputError::OtherKind { file: path.into(), found, expected: kind };
        let head = head(path).map_err(|error| other(format!("one that cannot be read ({error})")))?;
        if kind.replaces(&head) { Ok(()) } else { Err(other(Signature::like(&head).to_string())) }
    }
}

/// The first bytes of a file.
fn head(path: &Path) -> io::Result<Vec<u8>> {
    let mut head = vec![];
    File::open(path)?.take(HEAD as u64).read_to_end(&mut head)?;
    Ok(head)
}

/// A pipe waits here for its reader.
fn open_through(path: &Path) -> io::Result<File> {
    OpenOptions::new().write(true).open(path)
}

fn not_a_file(path: &Path, what: &'static str) -> OutputError {
    OutputError::NotAFile { file: path.into(), what }
}

fn not_a_folder(path: &Path) -> OutputError {
    OutputError::NotAFolder { folder: path.into() }
}

/// Why no temporary file can be made next to `target`, in terms of the path that the caller knows.
fn refused<'a>(path: &'a Path, target: &'a Path) -> impl Fn(io::Error) -> OutputError + 'a {
    |source| {
        let folder = folder(target);
        if folder.is_dir() {
            return OutputError::Io { file: path.into(), source };
        }
        OutputError::NoFolder { file: path.into(), folder: folder.into() }
    }
}

/// A path that can be written neither through a temporary file nor directly.
#[cfg(unix)]
fn neither_file_nor_through(found: &Metadata) -> Option<&'static str> {
    use std::os::unix::fs::FileTypeExt;
    let kind = found.file_type();
    let through = kind.is_char_device() || kind.is_fifo();
    if kind.is_dir() {
        Some("a folder")
    } else if kind.is_block_device() {
        Some("a block device")
    } else if kind.is_socket() {
        Some("a socket")
    } else {
        (!kind.is_file() && !through).then_some("neither a file nor a device")
    }
}

#[cfg(not(unix))]
fn neither_file_nor_through(found: &Metadata) -> Option<&'static str> {
    if found.is_dir() { Some("a folder") } else { (!found.is_file()).then_some("no file") }
}

/// A character device may be read and written by the same command: nothing is lost.
#[cfg(unix)]
fn is_character_device(found: &Metadata) -> bool {
    use std::os::unix::fs::FileTypeExt;
    found.file_type().is_char_device()
}

#[cfg(not(unix))]
fn is_character_device(_: &Metadata) -> bool {
    false
}

/// Target of a path through dangling links.
fn follow(path: &Path) -> io::Result<PathBuf> {
    let mut path = path.to_path_buf();
    for _ in 0..LINKS {
        match std::fs::symlink_metadata(&path) {
            Ok(found) if found.is_symlink() => path = folder(&path).join(std::fs::read_link(&path)?),
            _ => return Ok(path),
        }
    }
    Err(io::Error::other("links that lead in a circle"))
}

fn folder(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    }
}

/// Bytes left for this user on the disk of a folder that need not be there yet.
#[cfg(unix)]
fn space_left(path: &Path) -> Option<u64> {
    let mut at = path;
    while !at.exists() {
        at = folder(at);
    }
    let found = rustix::fs::statvfs(at).ok()?;
    Some(found.f_bavail.saturating_mul(found.f_frsize))
}

#[cfg(not(unix))]
fn space_left(_: &Path) -> Option<u64> {
    None
}

/// A rename lasts only once the folder is on the disk; some systems cannot open a folder, which is no loss.
fn flush_folder(folder: &Path) {
    if let Ok(folder) = File::open(folder) {
        let _ = folder.sync_all();
    }
}

/// Writes `bytes` to `path` as [`Outputs::write`] does, over any existing file.
///
/// # Errors
/// The error of the system (full disk, read-only folder); the old file is then unchanged.
pub fn write_atomic(path: &Path, bytes: &[u8]) -> io::Result<()> {
    Ok(Outputs::default().write(path, Kind::Any, |out| out.write_all(bytes))?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_write_replaces_the_old_file_whole_and_leaves_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.vdm");
        write_atomic(&path, b"old").unwrap();
        Outputs::default().check(&[(path.clone(), Kind::Any)]).unwrap();
        write_atomic(&path, b"newer").unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"newer");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn a_missing_folder_is_an_error_that_names_it() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("none/a.vdm");
        assert_eq!(write_atomic(&path, b"x").unwrap_err().kind(), io::ErrorKind::NotFound);
        let refused = Outputs::default().check(&[(path, Kind::Any)]).unwrap_err();
        assert!(matches!(&refused, OutputError::NoFolder { folder, .. } if folder.ends_with("none")));
        for wrong in [folder.path().to_path_buf(), folder.path().join("b/"), "..".into(), "".into()] {
            let refused = Outputs::default().check(&[(wrong, Kind::Any)]).unwrap_err();
            assert!(matches!(refused, OutputError::NotAFile { .. }), "{refused}");
        }
    }

    #[test]
    fn two_names_of_one_file_are_one_output() {
        let folder = tempfile::tempdir().unwrap();
        let [a, b] = ["a", "./b/../a"].map(|name| folder.path().join(name));
        std::fs::create_dir(folder.path().join("b")).unwrap();
        assert!(is_same_place(&a, &b));
        let twice = Outputs::default().check(&[(a, Kind::Any), (b, Kind::Any)]).unwrap_err();
        assert!(matches!(twice, OutputError::Twice { .. }), "{twice}");
    }
}
