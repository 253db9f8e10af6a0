//! Faults of mesh files, with position and remedy.

use std::fmt;
use std::path::{Path, PathBuf};

use super::flaw::Flaw;
use super::place::Location;
use crate::printable::printable;

/// One fault of a file: where, what was found, what was expected, what to do.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fault {
    /// The file.
    pub file: PathBuf,
    /// The line or byte.
    pub place: Location,
    /// The section as the file spells it, for instance `$Nodes` or `*ELEMENT`.
    pub section: String,
    /// The text found there, shortened.
    pub found: String,
    /// The expected content.
    pub expected: String,
    /// The remedy.
    pub(crate) remedy: String,
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}, {}, in {}: ", self.file.display(), self.place, self.section)?;
        write!(f, "found {}, expected {}; {}", self.found, self.expected, self.remedy)
    }
}

/// Remedy for CAD geometry; without the last option curved faces fold quadratic elements.
const CAD: &str = "for example with Gmsh: gmsh -3 -order 2 -optimize_ho";

/// Why a mesh could not be read. The file is at fault in all of them but `Io`.
#[derive(Debug, thiserror::Error)]
pub enum MeshError {
    /// The file could not be read from disk.
    #[error("{}: cannot be read", .file.display())]
    Io {
        /// The file.
        file: PathBuf,
        /// The error of the system.
        source: std::io::Error,
    },
    /// Neither content nor extension tells the format.
    #[error("{}: the format is not recognised (the file starts with {found}); known are Gmsh 1.0, MSH 2.2 and 4.1, Abaqus/CalculiX .inp, Nastran .bdf, Ansys .cdb, universal files (.unv), VTK legacy, VTU, TetGen .node/.ele, Medit .mesh, MFEM mesh v1.0, and the surfaces STL, OBJ, PLY, OFF, glTF", .file.display())]
    UnknownFormat {
        /// The file.
        file: PathBuf,
        /// Its first characters.
        found: String,
    },
    /// The file describes a solid, which no mesh has been made of yet.
    #[error("{}: {found}, which is CAD geometry and no mesh of the volume; mesh its volume first, {CAD}", .file.display())]
    Geometry {
        /// The file.
        file: PathBuf,
        /// Kind of the file, with its article.
        found: &'static str,
    },
    /// The surface of the file could not be filled with tetrahedra.
    #[error("{}: the surface cannot be filled: {reason}", .file.display())]
    Unfilled {
        /// The file.
        file: PathBuf,
        /// The reason and the remedy.
        reason: String,
    },
    /// A surface that is not one, or does not lie on its mesh.
    #[error("{}: it cannot be embedded: {reason}", .file.display())]
    NotEmbedded {
        /// The file.
        file: PathBuf,
        /// The reason and the remedy.
        reason: String,
    },
    /// The file is of a format that is known and not read.
    #[error("{}: {found}, which is not read; {remedy}", .file.display())]
    Foreign {
        /// The file.
        file: PathBuf,
        /// Kind of the file, with its article.
        found: &'static str,
        /// The remedy.
        remedy: &'static str,
    },
    /// The file breaks the rules of its own format.
    #[error("{0}")]
    Malformed(Box<Fault>),
    /// The file keeps its format's rules, but asks for something that is not supported.
    #[error("not supported: {0}")]
    Unsupported(Box<Fault>),
    /// The file was read, but its mesh cannot be computed with.
    #[error("{}: {}", .file.display(), sentences(.problems))]
    Unsound {
        /// The file.
        file: PathBuf,
        /// Flaws, the gravest first; never empty.
        problems: Vec<Flaw>,
    },
}

fn sentences(problems: &[Flaw]) -> String {
    let all: Vec<String> = problems.iter().map(|p| p.to_string()).collect();
    all.join("; ")
}

impl MeshError {
    /// The located fault, for the variants that have one.
    pub fn fault(&self) -> Option<&Fault> {
        match self {
            MeshError::Malformed(fault) | MeshError::Unsupported(fault) => Some(fault),
            _ => None,
        }
    }

    /// The problems of an unsound mesh, empty for the other variants.
    pub fn problems(&self) -> &[Flaw] {
        match self {
            MeshError::Unsound { problems, .. } => problems,
            _ => &[],
        }
    }
}

/// Position of a parser, for the report of a fault.
pub(crate) struct FaultSite<'a> {
    pub(crate) file: &'a Path,
    pub(crate) place: Location,
    pub(crate) section: &'a str,
}

/// The remedy for a file that breaks its format's rules.
const REWRITE: &str = "correct the file, or write it again with the mesher";

impl FaultSite<'_> {
    pub(crate) fn malformed(&self, found: impl Into<String>, expected: impl Into<String>) -> MeshError {
        MeshError::Malformed(Box::new(self.fault(found.into(), expected.into(), REWRITE.into())))
    }

    pub(crate) fn unsupported(
        &self,
        found: impl Into<String>,
        expected: impl Into<String>,
        remedy: impl Into<String>,
    ) -> MeshError {
        MeshError::Unsupported(Box::new(self.fault(found.into(), expected.into(), remedy.into())))
    }

    pub(crate) fn fault(&self, found: String, expected: String, remedy: String) -> Fault {
        let (file, section) = (self.file.to_path_buf(), self.section.to_string());
        Fault { file, place: self.place, section, found, expected, remedy }
    }
}

/// A piece of the file as it may be shown in a message: quoted, at most 60 characters, control characters as
/// escapes.
pub(crate) fn shown(bytes: &[u8]) -> String {
    if bytes.is_empty() {
        return "nothing".into();
    }
    let head = String::from_utf8_lossy(&bytes[..bytes.len().min(240)]);
    let short: String = head.chars().take(60).collect();
    let more = if head.chars().count() > 60 { "…" } else { "" };
    format!("`{}{more}`", printable(&short.trim().replace(['\n', '\t'], " ")))
}
