//! The bytes of a mesh file.

use std::path::Path;

use super::error::MeshError;

/// The whole file.
pub(crate) fn load(path: &Path) -> Result<Vec<u8>, MeshError> {
    std::fs::read(path).map_err(|source| MeshError::Io { file: path.to_path_buf(), source })
}
