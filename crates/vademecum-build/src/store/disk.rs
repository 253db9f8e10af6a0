//! A file on disk is the old one or the new one, never half of either.

use std::ffi::OsStr;
use std::io::{self, Write};
use std::path::Path;
use std::time::Duration;

use tempfile::NamedTempFile;

/// A temporary file that nobody has written to for so long was left by a program that was killed. Writing
/// takes seconds; age is used and not a lock, which network folders may lack.
const ABANDONED: Duration = Duration::from_secs(3600);

/// Writes `bytes` to `path`: temporary file beside it, flushed to the disk, renamed over it, folder flushed.
/// Temporary files of programs that were killed more than an hour ago are removed from the folder.
///
/// # Errors
/// What the system says (full disk, read-only folder); the old file is then as it was and the temporary one
/// gone.
pub fn write_atomic(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let folder = folder(path);
    remove_abandoned(folder);
    let mut file = temporary(folder)?;
    file.write_all(bytes)?;
    share_like_new_file(file.as_file())?;
    file.as_file().sync_all()?;
    file.persist(path).map_err(|error| error.error)?;
    // The rename itself lasts only once the folder is on the disk; some systems cannot open a folder, which
    // is no loss.
    if let Ok(folder) = std::fs::File::open(folder) {
        let _ = folder.sync_all();
    }
    Ok(())
}

/// Whether [`write_atomic`] could begin: a temporary file beside `path` is made and removed. To be asked
/// before long work.
///
/// # Errors
/// What the system says (missing or read-only folder), or that `path` is a folder.
pub fn check_writable(path: &Path) -> io::Result<()> {
    if path.is_dir() {
        return Err(io::ErrorKind::IsADirectory.into());
    }
    temporary(folder(path))?.close()
}

fn folder(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    }
}

const PREFIX: &str = ".vademecum-";
const SUFFIX: &str = ".part";

fn temporary(folder: &Path) -> io::Result<NamedTempFile> {
    tempfile::Builder::new().prefix(PREFIX).suffix(SUFFIX).tempfile_in(folder)
}

/// Whether a file of this name is a temporary one of ours.
pub(crate) fn is_temporary(name: &str) -> bool {
    name.starts_with(PREFIX) && name.ends_with(SUFFIX)
}

/// What cannot be looked at or removed stays: it is in nobody's way.
fn remove_abandoned(folder: &Path) {
    let old = |entry: &std::fs::DirEntry| -> io::Result<bool> {
        let written = entry.metadata()?.modified()?;
        Ok(written.elapsed().is_ok_and(|age| age > ABANDONED))
    };
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        let name = entry.file_name();
        if OsStr::to_str(&name).is_some_and(is_temporary) && old(&entry).unwrap_or(false) {
            let _ = std::fs::remove_file(entry.path());
        }
    }
}

/// Temporary files are private; a result is not.
#[cfg(unix)]
fn share_like_new_file(file: &std::fs::File) -> io::Result<()> {
    use std::os::unix::fs::PermissionsExt;
    file.set_permissions(std::fs::Permissions::from_mode(0o644))
}

#[cfg(not(unix))]
fn share_like_new_file(_: &std::fs::File) -> io::Result<()> {
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_write_replaces_the_old_file_whole_and_leaves_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.vdm");
        write_atomic(&path, b"old").unwrap();
        check_writable(&path).unwrap();
        write_atomic(&path, b"newer").unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"newer");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn a_missing_folder_is_an_error() {
        let folder = tempfile::tempdir().unwrap();
        assert!(write_atomic(&folder.path().join("none/a.vdm"), b"x").is_err());
        assert!(check_writable(&folder.path().join("none/a.vdm")).is_err());
        assert!(check_writable(folder.path()).is_err());
    }

    #[test]
    fn what_a_killed_program_left_goes_after_an_hour_and_nothing_else_does() {
        let folder = tempfile::tempdir().unwrap();
        let aged = |name: &str, seconds: u64| {
            let path = folder.path().join(name);
            let file = std::fs::File::create(&path).unwrap();
            file.set_modified(std::time::SystemTime::now() - Duration::from_secs(seconds)).unwrap();
            path
        };
        let abandoned = aged(".vademecum-abc.part", 3700);
        let others =
            [aged(".vademecum-def.part", 3500), aged(".vademecum-notes", 9000), aged("a.part", 9000)];
        write_atomic(&folder.path().join("a.vdm"), b"x").unwrap();
        assert!(!abandoned.exists());
        assert!(others.iter().all(|path| path.exists()));
    }
}
