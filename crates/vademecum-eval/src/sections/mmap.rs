//! A file mapped into memory: the one place of the crate that needs an operating system, and its one
//! `unsafe`.

use core::fmt;
use memmap2::Mmap;
use std::path::Path;
use std::vec::Vec;
use vademecum_format::{File, FormatError};

/// A file in memory: copied, or mapped, so that pages are read when they are first touched.
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
    /// Maps the file at `path` for reading: a page is read when it is first touched. Where nobody can promise
    /// what is asked for below, [`Mapped::copy`].
    ///
    /// # Safety
    /// Nobody, in this process or another, may shorten or overwrite the file while it is mapped. A shortened
    /// file ends the process when a lost page is touched; bytes that change under a shared slice are
    /// undefined behaviour. To replace a file by renaming a new one over it, as the builder does, is sound:
    /// the map then keeps the old file.
    ///
    /// ```
    /// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/bound.rs"));
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// # let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/golden");
    /// # let path = std::path::Path::new(folder).join("fixed-f64.vdm");
    /// // SAFETY: the file came with the program, and its folder is read-only.
    /// let mapped = unsafe { Mapped::map(path) }?;
    /// let file = mapped.file()?;
    /// assert_eq!(file.metadata().n_modes, 3);
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// [`OpenError`] with the system's reason as its source.
    #[allow(unsafe_code)]
    pub unsafe fn map(path: impl AsRef<Path>) -> Result<Self, OpenError> {
        let file = std::fs::File::open(path).map_err(OpenError)?;
        // SAFETY: the map is read-only and private to this value, and outlives every slice borrowed from it.
        // The caller promises that nobody writes to the file.
        let map = unsafe { Mmap::map(&file) }.map_err(OpenError)?;
        Ok(Self { content: Content::Map(map) })
    }

    /// Copies the file at `path` into memory: whatever becomes of the file, these bytes stay. Costs its
    /// length in memory and a read of all of it, where [`Mapped::map`] reads only the pages it needs.
    ///
    /// ```
    /// # include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doc/bound.rs"));
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// # let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/golden");
    /// # let path = std::path::Path::new(folder).join("fixed-f64.vdm");
    /// let copied = Mapped::copy(path)?;
    /// assert_eq!(copied.file()?.metadata().n_modes, 3);
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// [`OpenError`] with the system's reason as its source.
    pub fn copy(path: impl AsRef<Path>) -> Result<Self, OpenError> {
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

impl AsRef<[u8]> for Mapped {
    fn as_ref(&self) -> &[u8] {
        self.bytes()
    }
}
