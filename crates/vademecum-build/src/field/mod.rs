//! Fields on meshes: written for ParaView, read back as snapshots.
//!
//! [`write_vtu`] and [`write_pvd`] write what ParaView opens; [`read_vtu`] and [`read_displacements`] read
//! point data of VTU files, [`read_npy`] a NumPy matrix. Snapshots of another code enter the build through
//! the last two; [`matrix_market_into`] hands a model to another code. The model of another code enters
//! through `read_matrix_market`, which reads its matrices, and `read_dofs`, `read_points` and
//! `read_triangles`, which say what their rows are.

mod market;
mod mat;
mod npy;
mod pvd;
mod tables;
mod vtu_read;
mod vtu_write;

use std::io::Write;
use std::path::{Path, PathBuf};

pub(crate) use market::{MarketMatrix, read_matrix_market};

pub use market::{dense_market_into, matrix_market_into};
pub use mat::{MatValue, mat_into};
pub use npy::{NpyArray, NpyValues, npy_array_into, npy_into, npy_texts_into, read_npy, write_npy};
pub use pvd::{PVD_HEAD, PVD_TAIL, pvd_line, read_pvd, write_pvd};
pub(crate) use tables::{DofRow, PointRow, read_dofs, read_points, read_triangles};
pub use vtu_read::{PointArray, VtuFile, read_displacements, read_vtu};
pub use vtu_write::{Cells, vtu_into, write_vtu};

use crate::mesh::{Fault, MeshError};
use crate::store::{Kind, Outputs};

/// A dense matrix, columns one after the other.
#[derive(Clone, Debug, PartialEq)]
pub struct DenseMatrix {
    /// Number of rows.
    pub rows: usize,
    /// Number of columns.
    pub columns: usize,
    /// `(rows, columns)`, column-major.
    pub data: Vec<f64>,
}

impl DenseMatrix {
    /// One column.
    ///
    /// # Panics
    /// If there is no such column.
    pub fn column(&self, index: usize) -> &[f64] {
        &self.data[index * self.rows..(index + 1) * self.rows]
    }
}

/// Why a field could not be read or written.
#[derive(Debug, thiserror::Error)]
pub enum FieldError {
    /// The disk refused.
    #[error("{}: cannot be read or written", .file.display())]
    Io {
        /// The file.
        file: PathBuf,
        /// The error of the system.
        source: std::io::Error,
    },
    /// A VTK file is faulty.
    #[error(transparent)]
    Vtk(#[from] MeshError),
    /// A `.npy` or `.pvd` file is faulty.
    #[error("{}: found {found}, expected {expected}", .file.display())]
    Malformed {
        /// The file.
        file: PathBuf,
        /// The text found.
        found: String,
        /// The expected content.
        expected: String,
    },
    /// A text file is faulty at a line.
    #[error("{0}")]
    Faulty(Box<Fault>),
    /// A file has no point data of this name.
    #[error("{}: no point data `{name}` with {components} components; there are {known}", .file.display())]
    NoSuchField {
        /// The file.
        file: PathBuf,
        /// The name asked for.
        name: String,
        /// The components asked for.
        components: usize,
        /// Names and components there are, or `none`.
        known: String,
    },
    /// The file's points are not the nodes of the mesh.
    #[error("{}: its points are not the nodes of the mesh ({detail}); snapshots must be on the mesh of the problem", .file.display())]
    ForeignMesh {
        /// The file.
        file: PathBuf,
        /// The first difference.
        detail: String,
    },
    /// The caller's arrays do not fit together.
    #[error("{what} has {found} values, but {expected} are needed")]
    WrongLength {
        /// Which array.
        what: String,
        /// Its length.
        found: usize,
        /// The length it must have.
        expected: usize,
    },
}

fn io_error(file: &Path) -> impl Fn(std::io::Error) -> FieldError + '_ {
    |source| FieldError::Io { file: file.to_path_buf(), source }
}

/// Writes a file whole or not at all, over any existing file.
fn write_whole(
    path: &Path,
    kind: Kind,
    write: impl FnOnce(&mut dyn Write) -> std::io::Result<()>,
) -> Result<(), FieldError> {
    Outputs::unasked().write(path, kind, write).map_err(|error| io_error(path)(error.into()))
}
