//! The file that a command was given: a vademecum file, or an assembly file that is joined in memory.

use std::io::Read as _;
use std::path::{Path, PathBuf};

use vademecum_assembly::{Assembled, AssemblyError, AssemblyFile, assemble};
use vademecum_build::progress::Listener;
use vademecum_build::store::{Outputs, open_regular};
use vademecum_eval::Mapped;
use vademecum_format::{File, FormatError};

use crate::arguments::OutputArguments;
use crate::failure::Failure;
use crate::files::{open_or_map, outputs};
use crate::looks::{Looks, is_vademecum, look};

/// The kind of file at the path that a command was given.
pub(crate) enum Given {
    /// A vademecum file, or what is refused when it is opened.
    File,
    /// An assembly file.
    Assembly(Box<AssemblyFile>),
}

impl Given {
    /// Reads the assembly file, if it is one.
    pub(crate) fn look(path: &Path) -> Result<Self, Failure> {
        let mut head = [0; 8];
        let read = open_regular(path).and_then(|mut file| file.read_exact(&mut head));
        if read.is_err() || is_vademecum(&head) || look(path) != Looks::Assembly {
            return Ok(Self::File);
        }
        let file = AssemblyFile::read(path).map_err(AssemblyError::from)?;
        Ok(Self::Assembly(Box::new(file)))
    }

    /// The files that an assembly file names; none of a vademecum file.
    pub(crate) fn parts(&self) -> Vec<PathBuf> {
        match self {
            Self::File => vec![],
            Self::Assembly(file) => file.inputs(),
        }
    }

    /// The file for as long as the command runs, copied or mapped; an assembly is joined.
    pub(crate) fn open(&self, path: &Path, map: bool, listener: &dyn Listener) -> Result<Opened, Failure> {
        match self {
            Self::File => open_or_map(path, map).map(Opened::File),
            Self::Assembly(file) => {
                listener.stage("join the parts");
                let joined = join(file, path)?;
                joined.report.notes.iter().for_each(|note| listener.note(note));
                Ok(Opened::Joined(joined.bytes))
            }
        }
    }
}

/// Outputs of a command that reads `inputs` and the parts of an assembly.
pub(crate) fn outputs_of(arguments: &OutputArguments, given: &Given, inputs: &[Option<&Path>]) -> Outputs {
    let parts = given.parts();
    let inputs: Vec<_> =
        inputs.iter().copied().chain(parts.iter().map(|part| Some(part.as_path()))).collect();
    outputs(arguments, &inputs, None)
}

/// Joins an assembly; failures name its file.
pub(crate) fn join(file: &AssemblyFile, path: &Path) -> Result<Assembled, Failure> {
    assemble(file).map_err(|error| match error {
        // It names file and line.
        AssemblyError::File(_) => error.into(),
        error => Failure::from(error).within(path),
    })
}

/// The bytes of a vademecum file.
pub(crate) enum Opened {
    /// Of a file on the disk.
    File(Mapped),
    /// Of parts that were joined.
    Joined(Vec<u8>),
}

impl Opened {
    /// The bytes.
    pub(crate) fn bytes(&self) -> &[u8] {
        self.as_ref()
    }

    /// The bytes as a vademecum file.
    pub(crate) fn file(&self) -> Result<File<'_>, FormatError> {
        File::parse(self.bytes())
    }
}

impl AsRef<[u8]> for Opened {
    fn as_ref(&self) -> &[u8] {
        match self {
            Self::File(mapped) => mapped.bytes(),
            Self::Joined(bytes) => bytes,
        }
    }
}
