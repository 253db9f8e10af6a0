//! Reading what people name: regular files only, whole, and texts of a bounded length.
//!
//! A FIFO would wait for a writer who never comes, a device would never end, a folder would give a message
//! of the system. Every input of the program is opened here, so all of them refuse those alike, by what they
//! are. Note: `/dev/stdin` is a device by name and may be a pipe, and is good for a text all the
//! same, which then ends at the limit at the latest.

use std::fs::{File, FileType};
use std::io::{self, Read};
use std::path::Path;

/// Longest text a person writes \[bytes\]: problems, scenarios, reports of a build.
pub(crate) const TEXT_LIMIT: u64 = 64 << 20;

/// Opens a regular file; links are followed.
///
/// # Errors
/// The error of the system, or [`io::ErrorKind::InvalidInput`] with the kind of the path if it is no regular
/// file.
pub fn open_regular(path: &Path) -> io::Result<File> {
    // Asked before it is opened, because opening a FIFO waits; and again of what was opened.
    refuse_other(std::fs::metadata(path)?.file_type())?;
    let file = File::open(path)?;
    refuse_other(file.metadata()?.file_type())?;
    Ok(file)
}

/// All bytes of a regular file.
///
/// # Errors
/// As [`open_regular`], and a file for which there is no memory.
pub fn read_regular(path: &Path) -> io::Result<Vec<u8>> {
    let mut file = open_regular(path)?;
    let mut bytes = Vec::new();
    bytes.try_reserve_exact(usize::try_from(file.metadata()?.len()).unwrap_or(usize::MAX))?;
    file.read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// The text of a regular file, or of `/dev/stdin`.
///
/// # Errors
/// As [`open_regular`]; [`io::ErrorKind::FileTooLarge`] above `TEXT_LIMIT`,
/// [`io::ErrorKind::InvalidData`] for bytes that are no UTF-8.
pub fn read_text(path: &Path) -> io::Result<String> {
    read_text_within(path, TEXT_LIMIT)
}

/// The same of a text of at most `limit` bytes.
///
/// # Errors
/// As [`read_text`].
pub(crate) fn read_text_within(path: &Path, limit: u64) -> io::Result<String> {
    let file = if path == Path::new("/dev/stdin") { File::open(path)? } else { open_regular(path)? };
    text_of(file, limit)
}

/// A text of at most `limit` bytes.
fn text_of(source: impl Read, limit: u64) -> io::Result<String> {
    let mut bytes = vec![];
    source.take(limit + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > limit {
        let found = format!("it is longer than {} MiB; expected a text that a person wrote", limit >> 20);
        return Err(io::Error::new(io::ErrorKind::FileTooLarge, found));
    }
    String::from_utf8(bytes).map_err(|error| {
        let at = error.utf8_error().valid_up_to();
        let line = 1 + error.as_bytes()[..at].iter().filter(|&&byte| byte == b'\n').count();
        let found = format!("line {line} has bytes that are no UTF-8; expected text in UTF-8");
        io::Error::new(io::ErrorKind::InvalidData, found)
    })
}

fn refuse_other(kind: FileType) -> io::Result<()> {
    if kind.is_file() {
        return Ok(());
    }
    let found = format!("it is {}; expected a regular file", words(kind));
    Err(io::Error::new(io::ErrorKind::InvalidInput, found))
}

/// Kind of a path that is no regular file, in words.
fn words(kind: FileType) -> &'static str {
    if kind.is_dir() {
        return "a folder";
    }
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt;
        let kinds = [
            (kind.is_fifo(), "a FIFO (named pipe)"),
            (kind.is_socket(), "a socket"),
            (kind.is_char_device(), "a character device"),
            (kind.is_block_device(), "a block device"),
        ];
        if let Some((_, words)) = kinds.iter().find(|(is, _)| *is) {
            return words;
        }
    }
    "no file that can be read"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn regular_files_are_read_whole_and_through_links() {
        let folder = tempfile::tempdir().unwrap();
        let (file, link) = (folder.path().join("a"), folder.path().join("b"));
        std::fs::write(&file, "text\n").unwrap();
        assert_eq!(read_regular(&file).unwrap(), b"text\n");
        assert_eq!(read_text(&file).unwrap(), "text\n");
        #[cfg(unix)]
        {
            std::os::unix::fs::symlink(&file, &link).unwrap();
            assert_eq!(read_text(&link).unwrap(), "text\n");
        }
        assert_eq!(open_regular(&folder.path().join("none")).unwrap_err().kind(), io::ErrorKind::NotFound);
    }

    #[test]
    fn a_folder_is_named_as_one() {
        let folder = tempfile::tempdir().unwrap();
        let error = read_regular(folder.path()).unwrap_err();
        assert_eq!(error.to_string(), "it is a folder; expected a regular file");
    }

    /// Each of these would wait for ever, or never end.
    #[cfg(target_os = "linux")]
    #[test]
    fn fifos_sockets_and_devices_are_named_and_not_read() {
        let folder = tempfile::tempdir().unwrap();
        let [fifo, socket] = ["fifo", "socket"].map(|name| folder.path().join(name));
        assert!(std::process::Command::new("mkfifo").arg(&fifo).status().unwrap().success());
        let _bound = std::os::unix::net::UnixListener::bind(&socket).unwrap();
        let cases = [
            (fifo.as_path(), "a FIFO (named pipe)"),
            (socket.as_path(), "a socket"),
            (Path::new("/dev/zero"), "a character device"),
            (Path::new("/dev/random"), "a character device"),
        ];
        for (path, kind) in cases {
            for error in [read_regular(path).unwrap_err(), read_text(path).unwrap_err()] {
                assert_eq!(error.to_string(), format!("it is {kind}; expected a regular file"));
            }
        }
    }

    #[test]
    fn a_text_ends_at_the_limit() {
        assert_eq!(text_of(&b"four"[..], 4).unwrap(), "four");
        let error = text_of(io::repeat(b'a'), 1 << 20).unwrap_err();
        assert_eq!(error.to_string(), "it is longer than 1 MiB; expected a text that a person wrote");
        let error = text_of(&b"a\nb\xff"[..], 10).unwrap_err();
        assert_eq!(error.to_string(), "line 2 has bytes that are no UTF-8; expected text in UTF-8");
    }
}
