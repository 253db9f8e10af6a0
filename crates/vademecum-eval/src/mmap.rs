//! A file mapped into memory: the one place of the crate that needs an operating system, and its one
//! `unsafe`.

use core::fmt;
use memmap2::Mmap;
use std::path::Path;
use std::vec::Vec;
use vademecum_format::{File, FormatError};

/// A file in memory: mapped, so that pages are read when they are first touched, or copied.
#[derive(Debug)]
pub struct Mapped {
    content: Content,
}

#[derive(Debug)]
enum Content {
    Map(Mmap),
    Copy(Vec<u8>),
}

/// Why a path could not be mapped.
#[derive(Debug)]
pub struct OpenError(std::io::Error);

impl fmt::Display for OpenError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "the file cannot be opened, mapped or read")
    }
}

impl core::error::Error for OpenError {
    fn source(&self) -> Option<&(dyn core::error::Error + 'static)> {
        Some(&self.0)
    }
}

impl Mapped {
    /// Maps the file at `path` for reading.
    ///
    /// Nobody may shorten or overwrite the file while it is mapped: a shortened file ends the process when a
    /// lost page is touched, an overwritten one gives other numbers. Replace files by renaming a new one over
    /// the old, as the builder does: the map then keeps the old file. Where that cannot be promised,
    /// [`Mapped::copy`].
    ///
    /// ```
    /// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/bound.rs"));
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// # let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/golden");
    /// # let path = &std::path::Path::new(folder).join("fixed-f64.vdm");
    /// let mapped = Mapped::open(path)?;
    /// let file = mapped.file()?;
    /// assert_eq!(file.metadata().n_modes, 3);
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// [`OpenError`] with the system's reason as its source.
    pub fn open(path: &Path) -> Result<Self, OpenError> {
        let file = std::fs::File::open(path).map_err(OpenError)?;
        // SAFETY: the map is read-only and private to this value, and outlives every slice borrowed from it.
        // What Rust cannot see is another process writing to the file; the documented precondition of `open`
        // excludes it, and every byte read is treated as untrusted data, never as a reference, length or enum
        // without a check.
        #[allow(unsafe_code)]
        let map = unsafe { Mmap::map(&file) }.map_err(OpenError)?;
        Ok(Self { content: Content::Map(map) })
    }

    /// Copies the file at `path` into memory: whatever becomes of the file, these bytes stay. Costs its
    /// length in memory and a read of all of it, where a map reads only the pages it needs.
    ///
    /// # Errors
    /// [`OpenError`] with the system's reason as its source.
    pub fn copy(path: &Path) -> Result<Self, OpenError> {
        std::fs::read(path).map(|bytes| Self { content: Content::Copy(bytes) }).map_err(OpenError)
    }

    /// The bytes.
    #[must_use]
    pub fn bytes(&self) -> &[u8] {
        match &self.content {
            Content::Map(map) => map,
            Content::Copy(bytes) => bytes,
        }
    }

    /// Opens the bytes as a vademecum file.
    ///
    /// # Errors
    /// [`FormatError`].
    pub fn file(&self) -> Result<File<'_>, FormatError> {
        File::parse(self.bytes())
    }
}
