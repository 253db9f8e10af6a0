//! The archive of an FMU.

use std::io::{Cursor, Write};

use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipWriter};

use super::description::Description;
use super::error::FmuError;
use super::version::FmiVersion;

/// The library for one platform.
#[derive(Clone, Debug)]
pub struct Library {
    /// The platform as FMI 3 names it, such as `x86_64-linux`.
    pub platform: String,
    /// The bytes of the library.
    pub bytes: Vec<u8>,
}

/// Errors of a library for an FMU.
#[derive(Clone, Debug, thiserror::Error)]
pub enum LibraryError {
    /// An unknown name of a platform.
    #[error(
        "`{platform}` is no platform; expected an architecture (x86_64, x86, aarch64, aarch32, riscv64), a dash, and linux, windows or darwin, such as x86_64-linux"
    )]
    Platform {
        /// The name.
        platform: String,
    },
    /// A file without the entry points.
    #[error(
        "this is no library for an FMU: it does not name {symbol}; expected what `cargo build --release -p vademecum-fmu` makes on that platform"
    )]
    NoEntry {
        /// Missing symbol.
        symbol: &'static str,
    },
}

const ARCHITECTURES: [&str; 5] = ["x86_64", "x86", "aarch64", "aarch32", "riscv64"];

impl Library {
    /// Checks that these bytes could be the library for the platform.
    ///
    /// # Errors
    /// [`LibraryError`].
    pub fn new(platform: &str, bytes: Vec<u8>) -> Result<Self, LibraryError> {
        let known = platform.split_once('-').is_some_and(|(architecture, system)| {
            ARCHITECTURES.contains(&architecture) && ["linux", "windows", "darwin"].contains(&system)
        });
        if !known {
            return Err(LibraryError::Platform { platform: platform.into() });
        }
        for symbol in ["fmi2DoStep", "fmi3DoStep"] {
            if !bytes.windows(symbol.len()).any(|window| window == symbol.as_bytes()) {
                return Err(LibraryError::NoEntry { symbol });
            }
        }
        Ok(Self { platform: platform.into(), bytes })
    }

    /// Its folder below `binaries`: FMI 2 has names of its own for the platforms of its time.
    fn folder(&self, version: FmiVersion) -> &str {
        match (version, self.platform.as_str()) {
            (FmiVersion::Two, "x86_64-linux") => "linux64",
            (FmiVersion::Two, "x86-linux") => "linux32",
            (FmiVersion::Two, "x86_64-windows") => "win64",
            (FmiVersion::Two, "x86-windows") => "win32",
            (FmiVersion::Two, "x86_64-darwin") => "darwin64",
            (_, other) => other,
        }
    }

    fn extension(&self) -> &'static str {
        match self.platform.rsplit('-').next() {
            Some("windows") => "dll",
            Some("darwin") => "dylib",
            _ => "so",
        }
    }
}

/// A name as C takes it.
pub(super) fn identifier(name: &str) -> String {
    let mut identifier: String =
        name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    if !identifier.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_') {
        identifier.insert(0, '_');
    }
    identifier.truncate(64);
    identifier
}

/// Files of the archive beside the libraries.
pub(super) struct Files<'a> {
    pub(crate) description: Description<'a>,
    /// Terminals, of FMI 3.
    pub(crate) terminals: Option<String>,
    /// The vademecum file.
    pub(crate) vademecum: &'a [u8],
    /// The table of points.
    pub(crate) points: &'a [u8],
}

/// Writes the archive. Its entries are stored as they are, and bear no time: the same input gives the same
/// bytes.
///
/// # Errors
/// [`FmuError::NoPlatform`], [`FmuError::Archive`].
pub(super) fn write(files: &Files<'_>, libraries: &[Library]) -> Result<Vec<u8>, FmuError> {
    if libraries.is_empty() {
        return Err(FmuError::NoPlatform);
    }
    let mut zip = ZipWriter::new(Cursor::new(vec![]));
    let mut put = |name: &str, bytes: &[u8], mode: u32| {
        let options = SimpleFileOptions::default()
            .compression_method(CompressionMethod::Stored)
            .last_modified_time(DateTime::default())
            .unix_permissions(mode);
        zip.start_file(name, options)?;
        zip.write_all(bytes).map_err(zip::result::ZipError::from)
    };
    let Files { description, terminals, vademecum, points } = files;
    // The description comes first: that is what tells an FMU from other archives.
    put("modelDescription.xml", description.xml().as_bytes(), 0o644)?;
    for library in libraries {
        let (folder, extension) = (library.folder(description.version), library.extension());
        let name = format!("binaries/{folder}/{}.{extension}", description.identifier);
        put(&name, &library.bytes, 0o755)?;
    }
    if let Some(terminals) = terminals {
        put("terminalsAndIcons/terminalsAndIcons.xml", terminals.as_bytes(), 0o644)?;
    }
    put("resources/points.bin", points, 0o644)?;
    put("resources/body.vdm", vademecum, 0o644)?;
    Ok(zip.finish()?.into_inner())
}

#[cfg(test)]
mod tests {
    use super::{Library, identifier};

    #[test]
    fn names_become_identifiers_and_platforms_are_known() {
        let names = ["body", "my body-2", "2", "ü", ""].map(identifier);
        assert_eq!(names, ["body", "my_body_2", "_2", "_", "_"]);
        let bytes = || b"fmi2DoStep fmi3DoStep".to_vec();
        assert!(Library::new("aarch64-darwin", bytes()).is_ok());
        for platform in ["linux64", "x86_64-", "x86_64-linux-gnu", ""] {
            assert!(Library::new(platform, bytes()).is_err(), "{platform}");
        }
        let none = Library::new("x86_64-linux", b"\x7fELF fmi2DoStep".to_vec());
        assert!(none.is_err_and(|error| error.to_string().contains("fmi3DoStep")));
    }
}
