//! Location of the resources of an FMU: a URI in FMI 2, a folder in FMI 3.
#![allow(unsafe_code)]

use core::ffi::CStr;

use crate::memory::Block;

/// Location of the resources as a master gives it.
#[derive(Clone, Copy, Debug)]
pub enum Location<'a> {
    /// A URI of the scheme `file`, percent-encoded.
    Uri(&'a [u8]),
    /// A folder.
    Folder(&'a [u8]),
}

impl Location<'_> {
    /// Path of a file in the resources, with a zero at its end.
    ///
    /// # Errors
    /// Reason of a refused location, in words.
    pub fn of_file(&self, name: &[u8]) -> Result<Block, &'static str> {
        let folder = match *self {
            Self::Uri(uri) => local(uri)?,
            Self::Folder(folder) => folder,
        };
        let mut block =
            Block::zeroed(folder.len() + name.len() + 2).ok_or("there is no memory for a path")?;
        let mut out = block.bytes_mut().iter_mut();
        let mut put = |byte: u8| out.next().map(|place| *place = byte);
        let mut last = 0;
        let mut rest = folder.iter();
        while let Some(&byte) = rest.next() {
            last = byte;
            if byte == b'%' && matches!(self, Self::Uri(_)) {
                let mut digit = || rest.next().and_then(|&digit| hexadecimal(digit));
                let (Some(high), Some(low)) = (digit(), digit()) else {
                    return Err("a percent sign without two hexadecimal digits");
                };
                last = 16 * high + low;
            }
            if last == 0 {
                return Err("a zero byte in the path");
            }
            put(last);
        }
        if last != b'/' && !(cfg!(windows) && last == b'\\') {
            put(b'/');
        }
        name.iter().for_each(|&byte| {
            put(byte);
        });
        Ok(block)
    }
}

/// The path of a URI that means this machine; still percent-encoded.
fn local(uri: &[u8]) -> Result<&[u8], &'static str> {
    const OTHER: &str = "the resource location is no URI of a local file, such as file:///folder/resources";
    let (scheme, rest) = uri.split_at_checked(5).ok_or(OTHER)?;
    if !scheme.eq_ignore_ascii_case(b"file:") {
        return Err(OTHER);
    }
    // file:/path, file:///path and file://localhost/path.
    let path = match rest.strip_prefix(b"//") {
        None => rest,
        Some(rest) => match rest.strip_prefix(b"localhost") {
            Some(path) => path,
            None => rest,
        },
    };
    let absolute = path.strip_prefix(b"/").ok_or(OTHER)?;
    // file:///C:/path is C:/path.
    let drive = cfg!(windows) && absolute.get(1) == Some(&b':');
    Ok(if drive { absolute } else { path })
}

const fn hexadecimal(digit: u8) -> Option<u8> {
    match digit {
        b'0'..=b'9' => Some(digit - b'0'),
        b'a'..=b'f' => Some(digit - b'a' + 10),
        b'A'..=b'F' => Some(digit - b'A' + 10),
        _ => None,
    }
}

/// The path that [`Location::of_file`] has written.
#[must_use]
pub fn text(block: &Block) -> &CStr {
    // SAFETY: the block is two bytes longer than folder and name together, and was all zeros: at most a slash
    // is between them.
    unsafe { CStr::from_ptr(block.bytes().as_ptr().cast()) }
}

#[cfg(test)]
mod tests {
    use super::{Location, text};

    fn path(location: Location<'_>) -> Result<String, &'static str> {
        let block = location.of_file(b"body.vdm")?;
        Ok(text(&block).to_str().expect("UTF-8").to_string())
    }

    #[test]
    fn uris_and_folders_become_paths() {
        let uris = [
            ("file:///tmp/a%20b/resources", "/tmp/a b/resources/body.vdm"),
            ("file:/tmp/resources/", "/tmp/resources/body.vdm"),
            ("FILE://localhost/r%C3%BC", "/rü/body.vdm"),
        ];
        for (uri, wanted) in uris {
            assert_eq!(path(Location::Uri(uri.as_bytes())).as_deref(), Ok(wanted), "{uri}");
        }
        for bad in ["", "file", "file:", "http://x/y", "file://host/y", "file:///a%2", "file:///a%00b", "/x"]
        {
            assert!(path(Location::Uri(bad.as_bytes())).is_err(), "{bad}");
        }
        assert_eq!(path(Location::Folder(b"/a%20/")).as_deref(), Ok("/a%20/body.vdm"));
        assert_eq!(path(Location::Folder(b"r")).as_deref(), Ok("r/body.vdm"));
        assert!(path(Location::Folder(b"a\0b")).is_err());
    }
}
