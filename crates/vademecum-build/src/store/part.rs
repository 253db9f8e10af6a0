//! Files that are being written, under a temporary name in the same folder.
//!
//! Each is locked for as long as it is written, so whoever finds one without a lock knows that its writer was
//! killed. Where a system or a folder has no locks, a file that nobody has written to for an hour counts as
//! left behind.

use std::ffi::OsStr;
use std::fs::{File, Metadata, OpenOptions};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, SystemTime};

const PREFIX: &str = ".vademecum-";
const SUFFIX: &str = ".part";

/// Without file locks: a file that nobody has written to for so long was left by a program that was
/// killed.
const ABANDONED: Duration = Duration::from_secs(3600);

/// A file that is being written; removed unless it gets its name.
pub(super) struct PartialFile {
    path: PathBuf,
    pub(super) file: File,
    named: bool,
}

impl PartialFile {
    /// A new file in `folder`. It has the permissions of `old`, the file it will replace, and otherwise those
    /// that the system gives to a new file.
    pub(super) fn new(folder: &Path, old: Option<&Metadata>) -> io::Result<Self> {
        for _ in 0..100 {
            let path = folder.join(name());
            let file = match open_new(&path, old) {
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => continue,
                file => file?,
            };
            let part = Self { path, file, named: false };
            // Between the two lines above, somebody who cleans may have seen the file without its lock.
            if !lock(&part.file) || is_at(&part.file, &part.path) {
                if let Some(old) = old {
                    like(&part.file, old)?;
                }
                return Ok(part);
            }
        }
        Err(io::Error::other("no free name for a new file was found"))
    }

    /// Gives the file its name, in place of what has it. What is written later goes to the same file.
    pub(super) fn name(&mut self, target: &Path) -> io::Result<()> {
        std::fs::rename(&self.path, target)?;
        self.named = true;
        unlock(&self.file);
        Ok(())
    }
}

impl Drop for PartialFile {
    fn drop(&mut self) {
        if !self.named {
            // The error before this one is the one to tell.
            let _ = std::fs::remove_file(&self.path);
        }
    }
}

/// A name that no other file has: of this process, this instant, and this call.
fn name() -> String {
    static CALLS: AtomicUsize = AtomicUsize::new(0);
    let call = CALLS.fetch_add(1, Ordering::Relaxed);
    let now = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).map_or(0, |since| since.as_nanos());
    format!("{PREFIX}{:x}-{now:x}-{call:x}{SUFFIX}", std::process::id())
}

/// True if a file of this name is one that is or was being written.
pub(super) fn is_part(name: &OsStr) -> bool {
    name.to_str().is_some_and(|name| name.starts_with(PREFIX) && name.ends_with(SUFFIX))
}

/// Removes from a folder what killed programs have left. What cannot be looked at or removed stays: it is in
/// nobody's way.
pub(super) fn remove_left_behind(folder: &Path) {
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        if is_part(&entry.file_name()) {
            let _ = remove_if_left(&entry.path());
        }
    }
}

#[cfg(unix)]
fn remove_if_left(path: &Path) -> io::Result<()> {
    let found = path.symlink_metadata()?;
    if !found.is_file() {
        return Ok(());
    }
    let file = OpenOptions::new().read(true).write(true).open(path)?;
    let left = match rustix::fs::flock(&file, rustix::fs::FlockOperation::NonBlockingLockExclusive) {
        Ok(()) => true,
        Err(rustix::io::Errno::WOULDBLOCK) => false,
        Err(_) => is_old(&found),
    };
    // Its writer may have given it its name meanwhile.
    if left && is_at(&file, path) { std::fs::remove_file(path) } else { Ok(()) }
}

#[cfg(not(unix))]
fn remove_if_left(path: &Path) -> io::Result<()> {
    if is_old(&path.symlink_metadata()?) { std::fs::remove_file(path) } else { Ok(()) }
}

fn is_old(file: &Metadata) -> bool {
    file.modified().ok().and_then(|written| written.elapsed().ok()).is_some_and(|age| age > ABANDONED)
}

/// Locks a file that nobody else writes; whether there are locks. Who cleans holds one for an instant.
#[cfg(unix)]
fn lock(file: &File) -> bool {
    rustix::io::retry_on_intr(|| rustix::fs::flock(file, rustix::fs::FlockOperation::LockExclusive)).is_ok()
}

#[cfg(not(unix))]
fn lock(_: &File) -> bool {
    false
}

#[cfg(unix)]
fn unlock(file: &File) {
    let _ = rustix::fs::flock(file, rustix::fs::FlockOperation::Unlock);
}

#[cfg(not(unix))]
fn unlock(_: &File) {}

/// True if the path still leads to the open file.
#[cfg(unix)]
fn is_at(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let node = |found: io::Result<Metadata>| found.ok().map(|found| (found.dev(), found.ino()));
    node(file.metadata()).is_some_and(|open| node(path.symlink_metadata()) == Some(open))
}

#[cfg(not(unix))]
fn is_at(_: &File, path: &Path) -> bool {
    path.exists()
}

/// Private files are private while they are written: the mode is set from the start.
#[cfg(unix)]
fn open_new(path: &Path, old: Option<&Metadata>) -> io::Result<File> {
    use std::os::unix::fs::{OpenOptionsExt, PermissionsExt};
    let mut options = OpenOptions::new();
    if let Some(old) = old {
        options.mode(old.permissions().mode() & 0o777);
    }
    options.write(true).create_new(true).open(path)
}

#[cfg(not(unix))]
fn open_new(path: &Path, _: Option<&Metadata>) -> io::Result<File> {
    OpenOptions::new().write(true).create_new(true).open(path)
}

/// Owner, if the system lets us, and mode of the file that is replaced.
#[cfg(unix)]
fn like(file: &File, old: &Metadata) -> io::Result<()> {
    use std::os::unix::fs::{MetadataExt, PermissionsExt, fchown};
    let new = file.metadata()?;
    if (new.uid(), new.gid()) != (old.uid(), old.gid()) {
        let _ = fchown(file, Some(old.uid()), Some(old.gid()));
    }
    file.set_permissions(std::fs::Permissions::from_mode(old.permissions().mode() & 0o777))
}

#[cfg(not(unix))]
fn like(_: &File, _: &Metadata) -> io::Result<()> {
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(unix)]
    #[test]
    fn what_is_being_written_stays_and_what_was_left_behind_goes() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        let written = PartialFile::new(folder.path(), None).unwrap();
        for name in [".vademecum-left.part", ".vademecum-notes", "a.part"] {
            std::fs::write(at(name), b"half").unwrap();
        }
        std::os::unix::fs::symlink(at("a.part"), at(".vademecum-link.part")).unwrap();
        remove_left_behind(folder.path());
        assert!(!at(".vademecum-left.part").exists());
        assert!([".vademecum-notes", "a.part", ".vademecum-link.part"].iter().all(|name| at(name).exists()));
        assert!(written.path.exists());
    }

    #[test]
    fn a_part_goes_unless_it_gets_its_name() {
        let folder = tempfile::tempdir().unwrap();
        drop(PartialFile::new(folder.path(), None).unwrap());
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
        PartialFile::new(folder.path(), None).unwrap().name(&folder.path().join("a")).unwrap();
        assert!(folder.path().join("a").exists());
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }
}
