//! The bytes of a file, shared by everything that was made of it.

use std::path::Path;
use std::sync::Arc;

use vademecum_cli::{Failure, Limit, is_stepped, open_or_map, usable_bytes};
use vademecum_eval::Mapped;
use vademecum_format::File;
use vademecum_study::live::{BodyAtValues, at_values};
use vademecum_study::parameters::ParameterValue;

use crate::options::Asked;
use crate::refusal::Refusal;

/// A file in memory, every section compared with its checksum.
pub struct Content {
    original: Original,
    /// The same with every section raw that a scene reads, where some were packed.
    raw: Option<Vec<u8>>,
}

enum Original {
    OnDisk(Mapped),
    Given(Vec<u8>),
}

impl Content {
    /// The file at `path`, copied, or mapped if the caller promises that nobody shortens or overwrites it.
    pub fn open(path: &Path, map: bool) -> Result<Self, Refusal> {
        Self::of(path, Original::OnDisk(open_or_map(path, map)?))
    }

    /// Bytes of a file; `name` is for messages.
    pub fn given(name: &Path, bytes: Vec<u8>) -> Result<Self, Refusal> {
        Self::of(name, Original::Given(bytes))
    }

    fn of(name: &Path, original: Original) -> Result<Self, Refusal> {
        let mut memory = vec![];
        usable_bytes(name, original.bytes(), is_stepped, Limit::default(), &mut memory)?;
        let raw = (!memory.is_empty()).then_some(memory);
        Ok(Self { original, raw })
    }

    /// The file as it was given.
    pub fn original(&self) -> &[u8] {
        self.original.bytes()
    }

    /// The file with every section raw that a scene reads.
    pub fn file(&self, name: &Path) -> Result<File<'_>, Refusal> {
        Ok(File::parse(self.stepped()).map_err(|error| Failure::file(name, error))?)
    }

    /// The body of a parametric file at values of its live parameters, as a file of its own; any other file
    /// as it is.
    pub fn at(
        self: &Arc<Self>,
        name: &Path,
        asked: &Asked,
    ) -> Result<(Arc<Self>, Vec<ParameterValue>), Refusal> {
        let body = at_values(&self.file(name)?, &asked.live, asked.modes)?;
        Ok(body.map_or_else(
            || (Arc::clone(self), vec![]),
            |BodyAtValues { bytes, values }| {
                (Arc::new(Self { original: Original::Given(bytes), raw: None }), values)
            },
        ))
    }

    fn stepped(&self) -> &[u8] {
        self.raw.as_deref().unwrap_or(self.original())
    }
}

impl Original {
    fn bytes(&self) -> &[u8] {
        match self {
            Self::OnDisk(mapped) => mapped.bytes(),
            Self::Given(bytes) => bytes,
        }
    }
}

/// Parts of a file that a simulation holds.
pub struct Shared(pub Arc<Content>);

impl AsRef<[u8]> for Shared {
    fn as_ref(&self) -> &[u8] {
        self.0.stepped()
    }
}
